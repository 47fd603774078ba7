"""A brake in MJX: the slip is the rest length of the tendon's spring, traced with the simulation.

    brake = mjx.brake(model, "cable", "choi2018-kapton")
    state = mjx.start(brake)
    d, state = mjx.step(mx, d, state, vacuum, brake)

`step` replaces `mujoco.mjx.step`; it can also be jitted, scanned, batched and differentiated. MJX
silently accepts plugins and plastic springs but computes something else, so they are rejected here.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

from layerjam.brake.kernel.parameters import Parameters, parameters
from layerjam.brake.mechanics.tracing import jax, jnp
from layerjam.core.errors import MissingExtraError, QuantityError
from layerjam.interop.increment import Motion, make_motion, move_state
from layerjam.interop.mjcf import AnyBrake, load_brake_file
from layerjam.interop.tendon import (
    LOWEST,
    Coupling,
    check_coupling,
    check_integrator,
    find_tendon,
    series_compliance,
)


class Setup(NamedTuple):
    """Numbers of a brake on a tendon, which may be traced and differentiated."""

    numbers: Parameters
    rest_length: Any
    """Length of the tendon at zero elongation [m]."""


@jax.tree_util.register_pytree_node_class
@dataclass(frozen=True)
class TendonBrake:
    """A brake on one tendon of a model."""

    values: Setup
    tendon: int
    coupling: Coupling

    def tree_flatten(self) -> tuple[tuple[Setup], tuple[int, Coupling]]:
        """Return the leaves (numbers and rest length) and the static values."""
        return (self.values,), (self.tendon, self.coupling)

    @classmethod
    def tree_unflatten(cls, meta: tuple[int, Coupling], leaves: tuple[Setup]) -> "TendonBrake":
        """Return the brake with these leaves."""
        return cls(leaves[0], *meta)


def brake(
    model: Any,
    tendon: str,
    brake: AnyBrake,
    *,
    coupling: Coupling = "limited",
    rope_stiffness: float | None = None,
) -> TendonBrake:
    """Return a brake for a tendon of a mujoco.MjModel; call it before `mjx.put_model`.

    Sets the tendon's stiffness, which must agree within 1e-6, to the brake's. Raises
    UnknownNameError, MissingExtraError, and QuantityError for a tendon that cannot carry the brake
    or a feature that MJX would not compute.
    """
    with MissingExtraError.raise_if_missing("a brake in MJX", "mjx"):
        from mujoco import mjx as _  # noqa: F401
    _check_model(model)
    numbers = parameters(load_brake_file(brake), rope_stiffness)
    check_integrator(model)
    target = find_tendon(model, tendon, numbers)
    model.tendon_stiffness[target.id] = numbers.stiffness
    model.tendon_lengthspring[target.id] = (LOWEST, target.rest_length)
    return TendonBrake(Setup(numbers, target.rest_length), target.id, check_coupling(coupling))


def _check_model(model: Any) -> None:
    """Raise QuantityError for features that MJX accepts silently but computes differently."""
    import mujoco

    for i in range(model.nactuator):
        if model.actuator_plugin[i] >= 0:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) or i
            raise QuantityError.of(
                f"actuator '{name}'",
                "MJX would treat this plugin as a motor whose control is the force; omit it",
            )
    for i in range(model.ntendon):
        if model.tendon_springyield[i] != 0:
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_TENDON, i) or i
            raise QuantityError.of(
                f"tendon '{name}'", "MJX treats springyield as an elastic spring; omit it"
            )


def start(brake: TendonBrake, dtype: Any = None) -> Motion:
    """Return the brake at rest; `dtype` is float32 or float64, by default JAX's.

    Raises QuantityError for float64 if JAX works in single precision.
    """
    has_float64 = jnp.result_type(float) == jnp.float64
    dtype = jnp.dtype(dtype or (jnp.float64 if has_float64 else jnp.float32))
    if dtype not in (jnp.float32, jnp.float64):
        raise QuantityError.of("dtype", f"{dtype} is not allowed; use float32 or float64")
    if dtype == jnp.float64 and not has_float64:
        raise QuantityError.of(
            "dtype", 'float64 needs jax.config.update("jax_enable_x64", True) first'
        )
    return make_motion(dtype)


def step(mx: Any, d: Any, state: Motion, vacuum: Any, brake: TendonBrake) -> tuple[Any, Motion]:
    """Return the data and the brake after one step of MJX under a vacuum [Pa].

    Updates the tendon's length, moves the brake, and sets the rest length for this step only: `mx`
    is unchanged. If the vacuum is negative or not finite, the last one is kept.
    """
    from mujoco import mjx
    from mujoco.mjx._src import smooth

    d = mjx.fwd_position(mx, d)
    index, values = brake.tendon, brake.values
    elongation, advance = d.ten_length[index] - values.rest_length, 0.0
    compliance: Any = 0.0
    if brake.coupling != "explicit":
        pull = d._impl.ten_J[index]
        mobility = pull @ smooth.solve_m(mx, d, pull)
        timestep = mx.opt.timestep
        compliance = series_compliance(brake.coupling, mobility, timestep, values.numbers.stiffness)
        if brake.coupling == "implicit":
            advance = timestep * (pull @ d.qvel)
    state = move_state(state, elongation + advance, vacuum, values.numbers, compliance)
    length = values.rest_length + state.slip + compliance * state.force - advance
    lengths = mx.tendon_lengthspring.at[index, 1].set(length.astype(mx.tendon_lengthspring.dtype))
    return mjx.step(mx.replace(tendon_lengthspring=lengths), d), state
