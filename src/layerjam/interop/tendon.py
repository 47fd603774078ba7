"""What a MuJoCo tendon must be like to carry a brake, and how a brake is coupled to it.

The tendon is a spring that only pulls, of the brake's stiffness; the upper end of its rest length
is the slip. So the engine computes k (u - x), and whatever resists is in how the slip moves.
"""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from layerjam.errors import QuantityError, UnknownNameError
from layerjam.kernel.parameters import Parameters

Coupling = Literal["limited", "explicit", "implicit"]
"""How a step's force is found: see `compliance_of`."""
SAME = 1e-6
"""Share by which a stiffness written in a model may differ from the brake's."""
LOWEST = -1e10
"""Lower end of the rest length [m]: a rope does not push, however short it gets."""


class Tendon(NamedTuple):
    """A tendon of a model that carries a brake."""

    id: int
    rest_length: float
    """Length at zero elongation [m]."""


def tendon_of(model: Any, name: str, numbers: Parameters) -> Tendon:
    """The tendon of a mujoco.MjModel, checked.

    Raises UnknownNameError for a name that no tendon has, QuantityError for a tendon that is no
    spring of the brake's stiffness, or that resists by itself.
    """
    import mujoco

    count = model.ntendon
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, i) or "" for i in range(count)]
    if name not in names:
        raise UnknownNameError("tendon", name, names or ["(the model has no tendon)"])
    at = names.index(name)
    _check(model, at, f"tendon '{name}'", numbers.stiffness)
    return Tendon(at, float(model.tendon_lengthspring[at, 1]))


def check_integrator(model: Any) -> None:
    """Raise QuantityError for an integrator that does not take the spring's force as it is set."""
    import mujoco

    known = mujoco.mjtIntegrator
    fine = {known.mjINT_EULER, known.mjINT_IMPLICIT, known.mjINT_IMPLICITFAST}
    found = known(model.opt.integrator)
    if found not in fine:
        name = found.name.removeprefix("mjINT_").lower()
        raise QuantityError.of(
            "integrator",
            f"with '{name}' a spring whose rest length is the slip stops a mass too early; write "
            'integrator="Euler", "implicit" or "implicitfast", or take the plugin layerjam.brake',
        )


def _check(model: Any, at: int, label: str, due: float) -> None:
    """Raise QuantityError for a tendon that cannot carry the brake."""
    found = float(model.tendon_stiffness[at])
    if found == 0:
        reason = f'without stiffness it carries nothing; write stiffness="{due!r}"'
        raise QuantityError.of(label, reason)
    if abs(found - due) > SAME * due:
        reason = f"its stiffness is {found:g} N/m, the brake's with its rope {due:.9g} N/m; "
        raise QuantityError.of(label, reason + f'write stiffness="{due!r}"')
    if model.tendon_frictionloss[at] != 0:
        raise QuantityError.of(
            label, "frictionloss would resist a second time, and creep; leave it out"
        )
    if np.any(model.tendon_stiffnesspoly[at]):
        raise QuantityError.of(label, "the brake's stiffness is one number; write one stiffness")
    if model.tendon_springyield[at] != 0:
        raise QuantityError.of(
            label, "springyield would slide a second time, beside the brake; leave it out"
        )


def checked(coupling: str) -> Coupling:
    """The coupling of a name; UnknownNameError where there is none of that name."""
    if coupling not in get_args(Coupling):
        raise UnknownNameError("coupling", coupling, get_args(Coupling))
    return coupling  # type: ignore[return-value]


def compliance_of(coupling: Coupling, reflected: Any, step: float, stiffness: float) -> Any:
    """Compliance in series [m/N] for a step [s] and a mobility A = J M^-1 J^T [1/kg].

    `limited` softens the spring only where the step could not carry it (omega h > 1); `implicit` is
    backward Euler, stable at any step, and eats energy; `explicit` adds nothing.
    """
    if coupling == "explicit":
        return 0.0 * reflected
    whole = step**2 * reflected
    if coupling == "implicit":
        return whole
    excess = whole - 1 / stiffness
    return excess * (excess > 0)
