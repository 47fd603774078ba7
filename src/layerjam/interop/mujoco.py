"""A brake in MuJoCo: a helper that needs no compiler, and the actuator plugin `layerjam.brake`.

    brake = mujoco.Brake(model, "cable", "choi2018-kapton")
    while data.time < 2:
        brake.before_step(data, vacuum=94.5e3)
        mj.mj_step(model, data)

The helper moves the rest length of a tendon's spring: it is the slip. The plugin's control is the
vacuum. Either holds a load without creep, bit for bit, which `frictionloss` does not.
"""

from __future__ import annotations

from typing import Any

from layerjam.errors import CompilerError
from layerjam.interop.mjcf import AnyBrake, attach, brake_file, mjcf
from layerjam.interop.plugin import installed, load, plugin
from layerjam.interop.tendon import (
    LOWEST,
    Coupling,
    check_integrator,
    checked,
    compliance_of,
    tendon_of,
)
from layerjam.kernel.kernel import Kernel
from layerjam.kernel.parameters import parameters

__all__ = ["AnyBrake", "Brake", "Coupling", "attach", "load", "mjcf", "plugin"]


class Brake:
    """A brake on a tendon of a mujoco.MjModel, stepped from Python.

    The tendon's stiffness must be the brake's, `rope_stiffness` [N/m] in series; the upper end of
    its `springlength` is the length at zero elongation (the length at qpos0 unless it is given).
    From then on the rest length of that tendon in `model` is the brake's. Without a C compiler the
    law runs in JAX, more slowly. Integrators that evaluate the spring more than once a step, or
    damp it, are refused; the plugin takes them.

    Raises UnknownNameError, QuantityError, MissingExtraError.
    """

    def __init__(
        self,
        model: Any,
        tendon: str,
        brake: AnyBrake,
        *,
        coupling: Coupling = "limited",
        rope_stiffness: float | None = None,
    ) -> None:
        installed()
        given = brake_file(brake)
        numbers = parameters(given, rope_stiffness)
        check_integrator(model)
        self.tendon = tendon_of(model, tendon, numbers)
        self.coupling = checked(coupling)
        self.stiffness = numbers.stiffness
        self.law = _law(given, rope_stiffness)
        self._model = model
        model.tendon_stiffness[self.tendon.id] = numbers.stiffness
        self._rest(0.0)

    @property
    def slip(self) -> float:
        """[m]."""
        return self.law.slip

    @property
    def force(self) -> float:
        """Of the last step [N]."""
        return self.law.force

    @property
    def heat(self) -> float:
        """Dissipated so far [J]."""
        return self.law.heat

    @property
    def state(self) -> bytes:
        """All that the brake remembers; assign it to go back there."""
        return self.law.state

    @state.setter
    def state(self, given: bytes) -> None:
        self.law.state = given
        self._rest(self.law.slip)

    def reset(self) -> None:
        """Back to rest, as `mj_resetData` puts the model back to its start."""
        self.law.start()
        self._rest(0.0)

    def before_step(self, data: Any, vacuum: float) -> float:
        """Move the brake to where the tendon is, under a vacuum [Pa]; the force [N].

        Call it before every `mj_step`. It brings the tendon's length up to date first, because
        `mj_step` leaves the length of the position before the step. Raises QuantityError for a
        vacuum that is negative or not finite; nothing has changed then.
        """
        import mujoco

        model, at = self._model, self.tendon.id
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        elongation = data.ten_length[at] - self.tendon.rest_length
        ahead, compliance, step = 0.0, 0.0, model.opt.timestep
        if self.coupling != "explicit":
            mobility, row, columns = self._mobility(data)
            compliance = compliance_of(self.coupling, mobility, step, self.stiffness)
            if self.coupling == "implicit":
                ahead = step * float(row @ data.qvel[columns])
        force = self.law.move(elongation + ahead, vacuum, compliance)
        # the spring pulls with k (u - rest): with a compliance in series its stretch is less
        self._rest(self.law.slip + compliance * force - ahead)
        return force

    def _mobility(self, data: Any) -> tuple[float, Any, Any]:
        """A = J M^-1 J^T [1/kg] of the tendon, and its Jacobian's row with the row's columns."""
        import mujoco
        import numpy as np

        model, at = self._model, self.tendon.id
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        start = model.ten_J_rowadr[at]
        part = slice(start, start + model.ten_J_rownnz[at])
        columns, row = model.ten_J_colind[part], data.ten_J[part]
        pull, answer = np.zeros((1, model.nv)), np.zeros((1, model.nv))
        pull[0, columns] = row
        mujoco.mj_solveM(model, data, answer, pull)
        return float(answer[0] @ pull[0]), row, columns

    def _rest(self, slip: float) -> None:
        self._model.tendon_lengthspring[self.tendon.id] = (LOWEST, self.tendon.rest_length + slip)


def _law(brake: Any, rope_stiffness: float | None) -> Any:
    """The compiled kernel, or its twin in JAX where no C compiler is installed."""
    try:
        return Kernel(brake, rope_stiffness=rope_stiffness)
    except CompilerError:
        from layerjam.interop.increment import Increment

        return Increment(parameters(brake, rope_stiffness))
