"""Requirements on a MuJoCo tendon that carries a brake, and the coupling of the brake to it.

The tendon is a spring that only pulls, with the brake's stiffness; the upper end of its rest length
is the slip. The engine computes the force k (u - x); all friction is in the motion of the slip x.
"""

from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from layerjam.brake.kernel.parameters import Parameters
from layerjam.core.errors import QuantityError, UnknownNameError

Coupling = Literal["limited", "explicit", "implicit"]
"""Method that determines the force of a step: see `series_compliance`."""
SAME = 1e-6
"""Allowed relative difference between the tendon's stiffness in a model and the brake's."""
LOWEST = -1e10
"""Lower end of the rest length [m], so that the rope does not push however short it becomes."""


class Tendon(NamedTuple):
    """A tendon of a model that carries a brake."""

    id: int
    rest_length: float
    """Length at zero elongation [m]."""


def find_tendon(model: Any, name: str, numbers: Parameters) -> Tendon:
    """Return the checked tendon of a mujoco.MjModel.

    Raises UnknownNameError for an unknown name, QuantityError for a tendon that is not a spring of
    the brake's stiffness, or that has friction of its own.
    """
    import mujoco

    count = model.ntendon
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, i) or "" for i in range(count)]
    if name not in names:
        raise UnknownNameError("tendon", name, names or ["(the model has no tendon)"])
    index = names.index(name)
    _check_tendon(model, index, f"tendon '{name}'", numbers.stiffness)
    return Tendon(index, float(model.tendon_lengthspring[index, 1]))


def check_integrator(model: Any) -> None:
    """Raise QuantityError for an integrator that changes the spring's force within a step."""
    import mujoco

    kinds = mujoco.mjtIntegrator
    integrators = {kinds.mjINT_EULER, kinds.mjINT_IMPLICIT, kinds.mjINT_IMPLICITFAST}
    kind = kinds(model.opt.integrator)
    if kind not in integrators:
        name = kind.name.removeprefix("mjINT_").lower()
        raise QuantityError.of(
            "integrator",
            f"with '{name}' a spring whose rest length is the slip stops a mass too "
            'early; write integrator="Euler", "implicit" or "implicitfast", or '
            "use the plugin layerjam.brake",
        )


def _check_tendon(model: Any, index: int, label: str, series: float) -> None:
    """Raise QuantityError for a tendon that cannot carry the brake."""
    stiffness = float(model.tendon_stiffness[index])
    if stiffness == 0:
        reason = f'without stiffness it carries no load; write stiffness="{series!r}"'
        raise QuantityError.of(label, reason)
    if abs(stiffness - series) > SAME * series:
        reason = f"its stiffness is {stiffness:g} N/m, but brake and rope have {series:.9g} N/m; "
        raise QuantityError.of(label, reason + f'write stiffness="{series!r}"')
    if model.tendon_frictionloss[index] != 0:
        raise QuantityError.of(
            label, "frictionloss would add a second resistance, and creep; omit it"
        )
    if np.any(model.tendon_stiffnesspoly[index]):
        raise QuantityError.of(label, "the brake has one stiffness; write a single number")
    if model.tendon_springyield[index] != 0:
        raise QuantityError.of(label, "springyield would slide in addition to the brake; omit it")


def check_coupling(coupling: str) -> Coupling:
    """Return a valid name of a coupling unchanged; raises UnknownNameError for any other."""
    if coupling not in get_args(Coupling):
        raise UnknownNameError("coupling", coupling, get_args(Coupling))
    return coupling  # type: ignore[return-value]


def series_compliance(coupling: Coupling, mobility: Any, step: float, stiffness: float) -> Any:
    """Return the compliance in series [m/N] for a step [s] and a mobility A = J M^-1 J^T [1/kg].

    `limited` softens the spring only if the step could not resolve it (omega h > 1). `implicit` is
    backward Euler, stable at any step, but dissipative. `explicit` adds nothing.
    """
    if coupling == "explicit":
        return 0.0 * mobility
    compliance = step**2 * mobility
    if coupling == "implicit":
        return compliance
    excess = compliance - 1 / stiffness
    return excess * (excess > 0)
