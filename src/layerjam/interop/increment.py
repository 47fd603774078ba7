"""One move of a brake in JAX, like the C kernel's; it can be traced, batched and differentiated.

`layerjam.c` does the same for one brake, in either precision; the laws are those of
`mechanics.hysteresis`.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.kernel.parameters import Parameters
from layerjam.brake.mechanics.cycle import Setting
from layerjam.brake.mechanics.enclosure import make_enclosure
from layerjam.brake.mechanics.hysteresis import State, change_vacuum, move
from layerjam.brake.mechanics.memory import PIECES, new_memory
from layerjam.brake.mechanics.tracing import in_double_precision, jax, jnp
from layerjam.core.errors import QuantityError


class Motion(NamedTuple):
    """State of a brake between two moves; its leaves are scalars, or batched."""

    brake: State
    separated: Any
    """Whether the overlap was used up; from then on only the enclosure pulls."""

    @property
    def slip(self) -> Any:
        """Slip [m]."""
        return self.brake.enclosure.slip

    @property
    def force(self) -> Any:
        """Force [N]."""
        return self.brake.force


def make_motion(dtype: Any = jnp.float64) -> Motion:
    """Return a brake at rest without vacuum: no slip, no force, no elongation.

    If JAX works in single precision, float64 yields float32 leaves, as in all of JAX.
    """
    zero, false = jnp.zeros((), dtype), jnp.array(False)
    memory = jax.tree.map(
        lambda leaf: leaf.astype(dtype) if jnp.issubdtype(leaf.dtype, jnp.floating) else leaf,
        new_memory(),
    )
    return Motion(State(memory, zero, zero, zero, zero, zero, false, false), false)


def move_state(
    state: Motion, elongation: Any, vacuum: Any, numbers: Parameters, compliance: Any = 0.0
) -> Motion:
    """Return the brake after a change to a vacuum [Pa] and a move to an elongation [m].

    `compliance` [m/N] in series is for solvers; the elongation is then the one without any force.
    If the vacuum is negative or not finite, the last vacuum is kept. A move to an elongation that
    is not finite has no effect, because traced code cannot raise errors.
    """
    brake = state.brake
    vacuum = jnp.where((vacuum >= 0) & jnp.isfinite(vacuum), vacuum, brake.vacuum)
    spring = numbers.stiffness / (1 + numbers.stiffness * compliance)
    setting = _make_setting(state, vacuum, spring, numbers)
    stiff = setting._replace(k=numbers.stiffness)
    brake_now = jax.lax.cond(
        vacuum == brake.vacuum,
        lambda s: s,
        lambda s: _cast(change_vacuum(s, vacuum, stiff), s),
        brake,
    )
    result, parts = _slide(brake_now, elongation, setting, state.separated)
    result = result._replace(elongation=elongation - compliance * result.force)
    is_finite = jnp.isfinite(elongation)
    return jax.tree.map(
        lambda new, old: jnp.where(is_finite, new, old), _cast(Motion(result, parts), state), state
    )


def _make_setting(state: Motion, vacuum: Any, spring: Any, numbers: Parameters) -> Setting:
    """Return the resistances and the stiffness for a move from the kernel's eight numbers."""
    c = jnp.where(state.separated, 0.0, numbers.contact * vacuum)
    if not isinstance(numbers.exponent, float) or numbers.exponent != 0:
        positive = jnp.where(vacuum > 0, vacuum, 1.0)
        c = c * jnp.where(vacuum > 0, (positive / numbers.test_pressure) ** numbers.exponent, 0.0)
    strip = make_enclosure(
        numbers.enclosure_stiffness, numbers.enclosure_contact * vacuum, numbers.reach
    )
    return Setting(c, spring, numbers.overlap, strip)


def _slide(state: State, elongation: Any, law: Setting, was_separated: Any) -> tuple[State, Any]:
    """Return the state after a move, and whether the sheets have separated by then."""
    first = _cast(move(state, elongation, law), state)
    parts = (first.enclosure.slip >= law.overlap) & ~was_separated

    overlap_left = jnp.maximum(law.overlap - state.enclosure.slip, 0.0)
    heat = (
        law.c * overlap_left**2 / 2
    )  # up to the end of the overlap; beyond it only the enclosure acts

    def with_enclosure() -> State:
        free = move(state, elongation, law._replace(c=0.0 * law.c))
        return _cast(free._replace(heat=free.heat + heat, work=free.work + heat), state)

    result = jax.lax.cond(parts, with_enclosure, lambda: first)
    is_at_rest = result.enclosure.slip == state.enclosure.slip
    # a move without slip leaves no turning point, because rounding is not a reversal
    memory = jax.tree.map(
        lambda new, old: jnp.where(is_at_rest, old, new), result.enclosure, state.enclosure
    )
    return result._replace(enclosure=memory), was_separated | parts


def _cast(new: Any, old: Any) -> Any:
    """Return the new state with the types of the old one, which a JAX loop must not change."""
    return jax.tree.map(lambda a, b: jnp.asarray(a).astype(jnp.result_type(b)), new, old)


@functools.cache
def _compile_move() -> Any:
    return jax.jit(move_state)


class Increment:
    """One brake, stepped by JAX in double precision, without a compiler: slower than `Kernel`."""

    @in_double_precision
    def __init__(self, numbers: Parameters) -> None:
        self.parameters = numbers
        self._state = make_motion()

    @in_double_precision
    def start(self) -> None:
        """Reset the brake to rest without vacuum."""
        self._state = make_motion()

    @in_double_precision
    def move(self, elongation: float, vacuum: float, compliance: float = 0.0) -> float:
        """Move the brake and return the force [N], like `Kernel.move`; raises QuantityError."""
        for name, value in (("elongation", elongation), ("vacuum", vacuum)):
            if not np.isfinite(value):
                raise QuantityError.of(name, f"{value} is not a finite number")
        if vacuum < 0:
            raise QuantityError.of("vacuum", f"{vacuum:g} Pa is not allowed; use zero or more")
        numbers = (float(elongation), float(vacuum), self.parameters, float(compliance))
        self._state = _compile_move()(self._state, *numbers)
        return self.force

    @property
    def force(self) -> float:
        """Force [N]."""
        return float(self._state.force)

    @property
    def slip(self) -> float:
        """Slip [m]."""
        return float(self._state.slip)

    @property
    def heat(self) -> float:
        """Energy dissipated so far [J]."""
        return float(self._state.brake.heat)

    @property
    def state(self) -> bytes:
        """Complete state of the brake; assign it to restore the state.

        Raises QuantityError for bytes that are not the state of a brake, which is then unchanged.
        """
        return b"".join(np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(self._state))

    @state.setter
    def state(self, data: bytes) -> None:
        leaves, kind = jax.tree.flatten(self._state)
        size = sum(leaf.nbytes for leaf in leaves)
        if len(data) != size:
            raise QuantityError.of("state", f"expected {size} bytes, got {len(data)}")
        arrays, start = [], 0
        for leaf in map(np.asarray, leaves):
            part = np.frombuffer(data[start : start + leaf.nbytes], leaf.dtype)
            pieces = part.dtype.kind == "i" and not 2 <= part[0] < PIECES
            if pieces or not np.isfinite(part).all():
                raise QuantityError.of("state", "the bytes are damaged: a number is out of range")
            arrays.append(part.reshape(leaf.shape))
            start += leaf.nbytes
        self._state = jax.tree.unflatten(kind, arrays)
