"""The brake with a hyperelastic enclosure under a moving crosshead."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from layerjam.device.brake import Brake
from layerjam.mechanics.cycle import Cycle
from layerjam.mechanics.fan import force_of, tangent, work_of
from layerjam.mechanics.friction import sheets_at
from layerjam.mechanics.hyperelastic import strip_at
from layerjam.mechanics.rubber_strip import Rubber, cells_for, follow, relaxed
from layerjam.mechanics.stiffness import working_stiffness


class _State(NamedTuple):
    enclosure: Rubber
    force: Any
    work: Any
    heat: Any
    vacuum: Any
    closed: Any
    snapped: Any
    lost: Any
    """True once the vacuum fell on a loaded brake, or the rubber was asked too much."""


def rubber_cycle(elongation: Any, vacuum: Any, brake: Brake) -> Cycle:
    """The brake along an elongation history [m] at a vacuum [Pa] that never falls, shapes (N,).

    As `brake_cycle` for one modulus. NaN from where the vacuum falls on a brake that is not
    relaxed, or where the enclosure is stretched beyond the strain that was fitted.
    """
    k, overlap = jnp.asarray(working_stiffness(brake), jnp.float64), brake.sheets.overlap
    cells = cells_for(elongation.max(), vacuum.min(), vacuum.max(), brake)

    def step(state: _State, point: tuple[Any, Any]) -> tuple[_State, Cycle]:
        target, pressure = point
        before, sheets = state.enclosure, sheets_at(pressure, brake)
        friction = strip_at(pressure, brake).friction
        trial, hold = k * (target - before.slip), force_of(before.slip, sheets)
        out = trial > 2 * before.pull + hold
        back = jnp.maximum(trial, 0.0) < 2 * before.pull - hold
        way = jnp.where(out, 1.0, -1.0)

        def drive(pull: Any, slip: Any) -> tuple[Any, Any, Any]:
            # slack, the enclosure closes the brake against its friction
            taut = k * (target - slip)
            rest = jnp.maximum(taut, 0.0) - 2 * pull - way * force_of(slip, sheets)
            over_slip = way * tangent(slip, sheets).c - jnp.where(taut > 0, k, 0.0)
            return rest, -2.0 + 0.0 * pull, over_slip

        made = jax.lax.cond(
            out | back, lambda: follow(before, drive, friction, cells), lambda: before
        )
        force = jnp.maximum(k * (target - made.slip), 0.0)
        heat = jnp.abs(work_of(before.slip, made.slip, sheets)) + made.heat - before.heat
        elastic = (force**2 - state.force**2) / (2 * k)
        fell = (pressure < state.vacuum) & ((before.slip > 0) | (state.force > 0))
        now = _State(
            enclosure=made,
            force=force,
            work=state.work + heat + (made.stored - before.stored) + elastic,
            heat=state.heat + heat,
            vacuum=pressure,
            closed=state.closed | (before.slip - made.slip > 1e-12 * overlap),
            snapped=state.snapped | (out & (k <= tangent(before.slip, sheets).c)),
            lost=state.lost | fell | made.beyond,
        )
        fine = (target >= 0) & (pressure >= 0) & ~(now.snapped | now.lost)
        return now, Cycle(
            force=jnp.where(fine, force, jnp.nan),
            slip=made.slip,
            sleeve_force=2 * made.pull,
            work=now.work,
            heat=now.heat,
            stored=made.stored + force**2 / (2 * k),
            slack=(force <= 0) & (target < made.slip),
            closed=now.closed,
            separated=made.slip >= overlap * (1 - 1e-12),
            overflow=jnp.array(False),
            snapped=now.snapped,
        )

    zero, no = jnp.array(0.0), jnp.array(False)
    start = _State(relaxed(cells), zero, zero, zero, vacuum[0], no, no, no)
    return jax.lax.scan(step, start, (elongation, vacuum))[1]
