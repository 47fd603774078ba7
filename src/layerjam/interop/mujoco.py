"""A brake in MuJoCo: a helper that needs no compiler, and the actuator plugin `layerjam.brake`.

    brake = mujoco.Brake(model, "cable", "choi2018-kapton")
    while data.time < 2:
        brake.before_step(data, vacuum=94.5e3)
        mj.mj_step(model, data)

The helper moves the rest length of a tendon's spring, which is the slip. The plugin's control is
the vacuum. Unlike `frictionloss`, both hold a load exactly, without creep.
"""

from typing import Any

from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.kernel.parameters import parameters
from layerjam.core.errors import CompilerError
from layerjam.interop.mjcf import AnyBrake, attach, load_brake_file, mjcf
from layerjam.interop.plugin import import_mujoco, load, plugin
from layerjam.interop.tendon import (
    LOWEST,
    Coupling,
    check_coupling,
    check_integrator,
    find_tendon,
    series_compliance,
)

__all__ = ["AnyBrake", "Brake", "Coupling", "attach", "load", "mjcf", "plugin"]


class Brake:
    """A brake on a tendon of a mujoco.MjModel, stepped from Python.

    The tendon must have the stiffness of the brake, with `rope_stiffness` [N/m] in series. The
    upper end of its `springlength` is the length at zero elongation (by default the length at
    qpos0). From then on, the brake sets the rest length of that tendon in `model`. If there is no C
    compiler, the law runs in JAX, more slowly. Integrators that evaluate the spring more than once
    a step, or damp it, are rejected; the plugin accepts them.

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
        import_mujoco()
        file = load_brake_file(brake)
        numbers = parameters(file, rope_stiffness)
        check_integrator(model)
        self.tendon = find_tendon(model, tendon, numbers)
        self.coupling = check_coupling(coupling)
        self.stiffness = numbers.stiffness
        self.law = _make_law(file, rope_stiffness)
        self._model = model
        model.tendon_stiffness[self.tendon.id] = numbers.stiffness
        self._set_rest_length(0.0)

    @property
    def slip(self) -> float:
        """Slip [m]."""
        return self.law.slip

    @property
    def force(self) -> float:
        """Force of the last step [N]."""
        return self.law.force

    @property
    def heat(self) -> float:
        """Energy dissipated so far [J]."""
        return self.law.heat

    @property
    def state(self) -> bytes:
        """Complete state of the brake; assign it to restore the state."""
        return self.law.state

    @state.setter
    def state(self, data: bytes) -> None:
        self.law.state = data
        self._set_rest_length(self.law.slip)

    def reset(self) -> None:
        """Reset the brake to rest, as `mj_resetData` resets the model."""
        self.law.start()
        self._set_rest_length(0.0)

    def before_step(self, data: Any, vacuum: float) -> float:
        """Move the brake to the tendon's length, under a vacuum [Pa]; return the force [N].

        Call this before every `mj_step`. The tendon's length is updated first, because `mj_step`
        leaves the length of the previous position. Raises QuantityError for a vacuum that is
        negative or not finite; nothing changes then.
        """
        import mujoco

        model, tendon = self._model, self.tendon.id
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_tendon(model, data)
        elongation = data.ten_length[tendon] - self.tendon.rest_length
        advance, compliance, step = 0.0, 0.0, model.opt.timestep
        if self.coupling != "explicit":
            mobility, row, columns = self._compute_mobility(data)
            compliance = series_compliance(self.coupling, mobility, step, self.stiffness)
            if self.coupling == "implicit":
                advance = step * float(row @ data.qvel[columns])
        force = self.law.move(elongation + advance, vacuum, compliance)
        # the spring pulls with k (u - rest), and a compliance in series reduces its stretch
        self._set_rest_length(self.law.slip + compliance * force - advance)
        return force

    def _compute_mobility(self, data: Any) -> tuple[float, Any, Any]:
        """Return A = J M^-1 J^T [1/kg] of the tendon, its Jacobian row and the row's columns."""
        import mujoco
        import numpy as np

        model, tendon = self._model, self.tendon.id
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        start = model.ten_J_rowadr[tendon]
        part = slice(start, start + model.ten_J_rownnz[tendon])
        columns, row = model.ten_J_colind[part], data.ten_J[part]
        pull, answer = np.zeros((1, model.nv)), np.zeros((1, model.nv))
        pull[0, columns] = row
        mujoco.mj_solveM(model, data, answer, pull)
        return float(answer[0] @ pull[0]), row, columns

    def _set_rest_length(self, slip: float) -> None:
        self._model.tendon_lengthspring[self.tendon.id] = (LOWEST, self.tendon.rest_length + slip)


def _make_law(brake: Any, rope_stiffness: float | None) -> Any:
    """Return the compiled kernel, or its JAX version if no C compiler is installed."""
    try:
        return Kernel(brake, rope_stiffness=rope_stiffness)
    except CompilerError:
        from layerjam.interop.increment import Increment

        return Increment(parameters(brake, rope_stiffness))
