"""A brake in MJX: the rest length of the tendon's spring is the slip, traced with the simulation.

    brake = mjx.brake(model, "cable", "choi2018-kapton")
    state = mjx.start(brake)
    d, state = mjx.step(mx, d, state, vacuum, brake)

`step` stands in place of `mujoco.mjx.step`; it is jitted, scanned, batched and differentiated like
it. MJX takes plugins and plastic springs without a word and computes something else: they are
refused here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.errors import MissingExtraError, QuantityError
from layerjam.interop.increment import Moved, at_start, moved
from layerjam.interop.mjcf import AnyBrake, brake_file
from layerjam.interop.tendon import (
    LOWEST,
    Coupling,
    check_integrator,
    checked,
    compliance_of,
    tendon_of,
)
from layerjam.kernel.parameters import Parameters, parameters


class Held(NamedTuple):
    """The numbers of a brake on a tendon; they may be traced and differentiated."""

    numbers: Parameters
    rest_length: Any
    """Length of the tendon at zero elongation [m]."""


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True)
class TendonBrake:
    """A brake on one tendon of a model."""

    held: Held
    tendon: int
    coupling: Coupling

    def tree_flatten(self) -> tuple[tuple[Held], tuple[int, Coupling]]:
        """Leaves: numbers and rest length."""
        return (self.held,), (self.tendon, self.coupling)

    @classmethod
    def tree_unflatten(cls, fixed: tuple[int, Coupling], leaves: tuple[Held]) -> TendonBrake:
        """The brake with other leaves."""
        return cls(leaves[0], *fixed)


def brake(
    model: Any,
    tendon: str,
    brake: AnyBrake,
    *,
    coupling: Coupling = "limited",
    rope_stiffness: float | None = None,
) -> TendonBrake:
    """A brake for a tendon of a mujoco.MjModel, before `mjx.put_model`.

    Sets the stiffness of the tendon, as written within 1e-6, to the brake's. Raises
    UnknownNameError, QuantityError for a tendon that cannot carry the brake and for what MJX would
    take and not compute, MissingExtraError.
    """
    with MissingExtraError.raise_if_missing("a brake in MJX", "mjx"):
        from mujoco import mjx as _  # noqa: F401
    _check(model)
    numbers = parameters(brake_file(brake), rope_stiffness)
    check_integrator(model)
    found = tendon_of(model, tendon, numbers)
    model.tendon_stiffness[found.id] = numbers.stiffness
    model.tendon_lengthspring[found.id] = (LOWEST, found.rest_length)
    return TendonBrake(Held(numbers, found.rest_length), found.id, checked(coupling))


def _check(model: Any) -> None:
    """Raise QuantityError for what MJX takes in silence and computes as something else."""
    import mujoco

    for i in range(model.nactuator):
        if model.actuator_plugin[i] >= 0:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) or i
            raise QuantityError.of(
                f"actuator '{name}'",
                "MJX drives a plugin as a motor with its control as the force; leave it out",
            )
    for i in range(model.ntendon):
        if model.tendon_springyield[i] != 0:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, i) or i
            raise QuantityError.of(
                f"tendon '{name}'", "MJX takes springyield for an elastic spring; leave it out"
            )


def start(brake: TendonBrake, dtype: Any = None) -> Moved:
    """The brake at rest; `dtype` float32 or float64, that of JAX unless it is given.

    Raises QuantityError for float64 while JAX works in single precision.
    """
    wide = jnp.result_type(float) == jnp.float64
    dtype = jnp.dtype(dtype or (jnp.float64 if wide else jnp.float32))
    if dtype not in (jnp.float32, jnp.float64):
        raise QuantityError.of("dtype", f"{dtype} is not allowed; float32 or float64")
    if dtype == jnp.float64 and not wide:
        raise QuantityError.of(
            "dtype", 'float64 needs jax.config.update("jax_enable_x64", True) first'
        )
    return at_start(dtype)


def step(mx: Any, d: Any, state: Moved, vacuum: Any, brake: TendonBrake) -> tuple[Any, Moved]:
    """One step of MJX with the brake under a vacuum [Pa]; the data and the brake after it.

    Brings the tendon's length up to date, moves the brake, and sets the rest length for this step
    alone: `mx` itself stays. A vacuum that is negative or no number keeps the last one.
    """
    from mujoco import mjx
    from mujoco.mjx._src import smooth

    d = mjx.fwd_position(mx, d)
    at, held = brake.tendon, brake.held
    elongation, ahead = d.ten_length[at] - held.rest_length, 0.0
    compliance: Any = 0.0
    if brake.coupling != "explicit":
        pull = d._impl.ten_J[at]
        mobility = pull @ smooth.solve_m(mx, d, pull)
        timestep = mx.opt.timestep
        compliance = compliance_of(brake.coupling, mobility, timestep, held.numbers.stiffness)
        if brake.coupling == "implicit":
            ahead = timestep * (pull @ d.qvel)
    state = moved(state, elongation + ahead, vacuum, held.numbers, compliance)
    rest = held.rest_length + state.slip + compliance * state.force - ahead
    lengths = mx.tendon_lengthspring.at[at, 1].set(rest.astype(mx.tendon_lengthspring.dtype))
    return mjx.step(mx.replace(tendon_lengthspring=lengths), d), state
