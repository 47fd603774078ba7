"""The kernel's increment in JAX: one move of a brake, traced, batched and differentiated.

What `layerjam.c` does one brake at a time, in either precision; the laws are those of
`mechanics.hysteresis`.
"""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.errors import QuantityError
from layerjam.kernel.parameters import Parameters
from layerjam.mechanics.enclosure import enclosure_of
from layerjam.mechanics.hysteresis import Setting, State, change_vacuum, move
from layerjam.mechanics.law import in_double_precision
from layerjam.mechanics.memory import PIECES, at_rest


class Moved(NamedTuple):
    """The brake between two moves; leaves of shape (), or batched."""

    brake: State
    separated: Any
    """True once the overlap was used up; the enclosure alone pulls from there on."""

    @property
    def slip(self) -> Any:
        """[m]."""
        return self.brake.enclosure.slip

    @property
    def force(self) -> Any:
        """[N]."""
        return self.brake.force


def at_start(dtype: Any = jnp.float64) -> Moved:
    """A brake at rest under no vacuum: no slip, no force, no elongation.

    With float64 while JAX works in single precision the leaves are float32, as everywhere in JAX.
    """
    zero, no = jnp.zeros((), dtype), jnp.array(False)
    memory = jax.tree.map(
        lambda leaf: leaf.astype(dtype) if jnp.issubdtype(leaf.dtype, jnp.floating) else leaf,
        at_rest(),
    )
    return Moved(State(memory, zero, zero, zero, zero, zero, no, no), no)


def moved(
    state: Moved, elongation: Any, vacuum: Any, numbers: Parameters, compliance: Any = 0.0
) -> Moved:
    """The brake after it took a vacuum [Pa] and moved to an elongation [m].

    `compliance` [m/N] in series is for solvers: the elongation is then the one that would be
    reached without any force. A vacuum below zero or not finite leaves the last one, a move to an
    elongation that is not finite is not made: traced code cannot raise.
    """
    brake = state.brake
    vacuum = jnp.where((vacuum >= 0) & jnp.isfinite(vacuum), vacuum, brake.vacuum)
    spring = numbers.stiffness / (1 + numbers.stiffness * compliance)
    softened = _setting(state, vacuum, spring, numbers)
    stiff = softened._replace(k=numbers.stiffness)
    held = jax.lax.cond(
        vacuum == brake.vacuum,
        lambda s: s,
        lambda s: _typed(change_vacuum(s, vacuum, stiff), s),
        brake,
    )
    made, separated = _whole(held, elongation, softened, state.separated)
    made = made._replace(elongation=elongation - compliance * made.force)
    fine = jnp.isfinite(elongation)
    return jax.tree.map(
        lambda new, old: jnp.where(fine, new, old), _typed(Moved(made, separated), state), state
    )


def _setting(state: Moved, vacuum: Any, spring: Any, numbers: Parameters) -> Setting:
    """What resists, from the kernel's eight numbers."""
    c = jnp.where(state.separated, 0.0, numbers.contact * vacuum)
    if not isinstance(numbers.exponent, float) or numbers.exponent != 0:
        positive = jnp.where(vacuum > 0, vacuum, 1.0)
        c = c * jnp.where(vacuum > 0, (positive / numbers.test_pressure) ** numbers.exponent, 0.0)
    strip = enclosure_of(
        numbers.enclosure_stiffness, numbers.enclosure_contact * vacuum, numbers.reach
    )
    return Setting(c, spring, numbers.overlap, strip)


def _whole(state: State, elongation: Any, at: Setting, separated: Any) -> tuple[State, Any]:
    """The move, and whether the sheets have parted; then the enclosure alone pulls."""
    first = _typed(move(state, elongation, at), state)
    parts = (first.enclosure.slip >= at.overlap) & ~separated

    left = jnp.maximum(at.overlap - state.enclosure.slip, 0.0)
    rubbed = at.c * left**2 / 2  # up to the end of the overlap; beyond it the enclosure is alone

    def alone() -> State:
        free = move(state, elongation, at._replace(c=0.0 * at.c))
        return _typed(free._replace(heat=free.heat + rubbed, work=free.work + rubbed), state)

    made = jax.lax.cond(parts, alone, lambda: first)
    still = made.enclosure.slip == state.enclosure.slip
    # a move that changes no slip leaves no turning point: rounding is no turn
    memory = jax.tree.map(
        lambda new, old: jnp.where(still, old, new), made.enclosure, state.enclosure
    )
    return made._replace(enclosure=memory), separated | parts


def _typed(new: Any, old: Any) -> Any:
    """The new state in the types of the old one: a loop's carry may not change them."""
    return jax.tree.map(lambda a, b: jnp.asarray(a).astype(jnp.result_type(b)), new, old)


@functools.cache
def _compiled() -> Any:
    return jax.jit(moved)


class Increment:
    """One brake, stepped by JAX in double precision: `Kernel` without a C compiler, and slower."""

    @in_double_precision
    def __init__(self, numbers: Parameters) -> None:
        self.parameters = numbers
        self._state = at_start()

    @in_double_precision
    def start(self) -> None:
        """Back to rest under no vacuum."""
        self._state = at_start()

    @in_double_precision
    def move(self, elongation: float, vacuum: float, compliance: float = 0.0) -> float:
        """As `Kernel.move`: the force [N]; QuantityError for a number that is not allowed."""
        for name, value in (("elongation", elongation), ("vacuum", vacuum)):
            if not np.isfinite(value):
                raise QuantityError.of(name, f"{value} is no number that can be computed with")
        if vacuum < 0:
            raise QuantityError.of("vacuum", f"{vacuum:g} Pa is not allowed; zero or more")
        given = (float(elongation), float(vacuum), self.parameters, float(compliance))
        self._state = _compiled()(self._state, *given)
        return self.force

    @property
    def force(self) -> float:
        """[N]."""
        return float(self._state.force)

    @property
    def slip(self) -> float:
        """[m]."""
        return float(self._state.slip)

    @property
    def heat(self) -> float:
        """Energy dissipated so far [J]."""
        return float(self._state.brake.heat)

    @property
    def state(self) -> bytes:
        """All that the brake remembers; assign it to go back there.

        Raises QuantityError for bytes that are not the state of a brake; nothing has changed then.
        """
        return b"".join(np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(self._state))

    @state.setter
    def state(self, given: bytes) -> None:
        leaves, kind = jax.tree.flatten(self._state)
        size = sum(leaf.nbytes for leaf in leaves)
        if len(given) != size:
            raise QuantityError.of("state", f"expected {size} bytes, got {len(given)}")
        made, at = [], 0
        for leaf in map(np.asarray, leaves):
            part = np.frombuffer(given[at : at + leaf.nbytes], leaf.dtype)
            pieces = part.dtype.kind == "i" and not 2 <= part[0] < PIECES
            if pieces or not np.isfinite(part).all():
                raise QuantityError.of("state", "the bytes are damaged: a number out of range")
            made.append(part.reshape(leaf.shape))
            at += leaf.nbytes
        self._state = jax.tree.unflatten(kind, made)
