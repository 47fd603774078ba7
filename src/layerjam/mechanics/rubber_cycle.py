"""The brake with a hyperelastic enclosure under a moving crosshead."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.fan import force_of, tangent, work_of
from layerjam.mechanics.friction import sheets_at
from layerjam.mechanics.hyperelastic import strip_at
from layerjam.mechanics.rubber_strip import Rubber, cells_for, follow, new_strip
from layerjam.mechanics.stiffness import working_stiffness


class _State(NamedTuple):
    enclosure: Rubber
    force: Any
    work: Any
    heat: Any
    vacuum: Any
    has_closed: Any
    has_snapped: Any
    is_invalid: Any
    """True once the vacuum fell on a loaded brake, or the rubber was strained beyond its range."""


def rubber_cycle(elongation: Any, vacuum: Any, brake: Brake) -> Cycle:
    """The brake along an elongation history [m] at a vacuum [Pa] that never falls, shapes (N,).

    As `brake_cycle` for one modulus. NaN from the point where the vacuum falls on a brake that is
    not relaxed, or where the enclosure is stretched beyond the strain that was fitted.
    """
    k, overlap = jnp.asarray(working_stiffness(brake), jnp.float64), brake.sheets.overlap
    cells = cells_for(elongation.max(), vacuum.min(), vacuum.max(), brake)

    def step(state: _State, point: tuple[Any, Any]) -> tuple[_State, Cycle]:
        target, pressure = point
        before, sheets = state.enclosure, sheets_at(pressure, brake)
        friction = strip_at(pressure, brake).friction
        trial, hold = k * (target - before.slip), force_of(before.slip, sheets)
        out = trial > 2 * before.pull + hold
        returns = jnp.maximum(trial, 0.0) < 2 * before.pull - hold
        sign = jnp.where(out, 1.0, -1.0)

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            # when slack, the enclosure closes the brake against its friction
            taut = k * (target - slip)
            residual = jnp.maximum(taut, 0.0) - 2 * pull - sign * force_of(slip, sheets)
            over_slip = sign * tangent(slip, sheets).c - jnp.where(taut > 0, k, 0.0)
            return residual, -2.0 + 0.0 * pull, over_slip

        strip = jax.lax.cond(
            out | returns, lambda: follow(before, drive, friction, cells), lambda: before
        )
        force = jnp.maximum(k * (target - strip.slip), 0.0)
        heat = jnp.abs(work_of(before.slip, strip.slip, sheets)) + strip.heat - before.heat
        elastic = (force**2 - state.force**2) / (2 * k)
        falls = (pressure < state.vacuum) & ((before.slip > 0) | (state.force > 0))
        new = _State(
            enclosure=strip,
            force=force,
            work=state.work + heat + (strip.stored - before.stored) + elastic,
            heat=state.heat + heat,
            vacuum=pressure,
            has_closed=state.has_closed | (before.slip - strip.slip > 1e-12 * overlap),
            has_snapped=state.has_snapped | (out & (k <= tangent(before.slip, sheets).c)),
            is_invalid=state.is_invalid | falls | strip.is_exceeded,
        )
        fine = (target >= 0) & (pressure >= 0) & ~(new.has_snapped | new.is_invalid)
        return new, Cycle(
            force=jnp.where(fine, force, jnp.nan),
            slip=strip.slip,
            sleeve_force=2 * strip.pull,
            work=new.work,
            heat=new.heat,
            stored=strip.stored + force**2 / (2 * k),
            slack=(force <= 0) & (target < strip.slip),
            closed=new.has_closed,
            separated=strip.slip >= overlap * (1 - 1e-12),
            overflow=jnp.array(False),
            snapped=new.has_snapped,
        )

    zero, no = jnp.array(0.0), jnp.array(False)
    start = _State(new_strip(cells), zero, zero, zero, vacuum[0], no, no, no)
    return jax.lax.scan(step, start, (elongation, vacuum))[1]
