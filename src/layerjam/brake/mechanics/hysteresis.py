"""The brake under a moving crosshead: sheets that stick and slide, an enclosure with memory.

The model is for tension only: in compression the sheets buckle and the brake carries no load.
Without load its slip stays constant if friction holds the enclosure; otherwise the enclosure closes
the brake until friction holds it.
"""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.arrays import choose, scan, xp
from layerjam.brake.mechanics.cycle import Cycle, Setting
from layerjam.brake.mechanics.enclosure import EnclosureLaw, brake_enclosure, check_modulus
from layerjam.brake.mechanics.friction import sheet_law
from layerjam.brake.mechanics.law import compiled, law
from layerjam.brake.mechanics.memory import Memory, new_memory, relaxed_enclosure
from layerjam.brake.mechanics.rubber_strip import Rubber
from layerjam.brake.mechanics.slip_effects import (
    friction_force,
    friction_tangent,
    friction_work,
    scale_friction,
)
from layerjam.brake.mechanics.speed_effects import brake_growth, has_speed_effects
from layerjam.brake.mechanics.stiffness import working_stiffness


class State(NamedTuple):
    """The brake between two moves."""

    enclosure: Memory | Rubber
    elongation: Any
    force: Any
    work: Any
    heat: Any
    vacuum: Any
    closed: Any
    snapped: Any
    growth: Any = None
    """Friction relative to that at the speed law's test speed; None if no speed is specified."""


def make_setting(vacuum: Any, spring: Any, brake: Brake, growth: Any = None) -> Setting:
    """Return the setting at a vacuum [Pa] on a spring [N/m], with friction times `growth`."""
    sheets, enclosure = sheet_law(vacuum, brake), brake_enclosure(vacuum, brake)
    if growth is not None:
        sheets = scale_friction(sheets, growth)
    paced_brake = brake if has_speed_effects(brake) else None
    return Setting(sheets.c, spring, sheets.overlap, enclosure, sheets.shapes, paced_brake)


def _friction_heat(start: Any, end: Any, setting: Setting) -> Any:
    """Return the heat of the sheets' friction over a move [J]."""
    if not setting.shapes and isinstance(setting.enclosure, EnclosureLaw):
        return xp.abs(end - start) * setting.c * (setting.overlap - (end + start) / 2)
    return xp.abs(friction_work(start, end, setting))  # zero past the end of the overlap


def move(state: State, elongation: Any, setting: Setting) -> State:
    """Move the crosshead at constant vacuum; work and heat are exact."""
    memory = state.enclosure
    trial = setting.k * (elongation - memory.slip)
    hold = friction_force(memory.slip, setting)
    out = trial > memory.force + hold
    returns = xp.maximum(trial, 0.0) < memory.force - hold
    new = memory.balance(elongation, out, returns, setting)
    slip = new.slip
    force = xp.maximum(setting.k * (elongation - slip), 0.0)
    friction_heat = _friction_heat(memory.slip, slip, setting)
    heat = friction_heat + new.heat - memory.heat
    elastic = (force**2 - state.force**2) / (2 * setting.k)
    return State(
        enclosure=new,
        elongation=elongation,
        force=force,
        work=state.work + heat + (new.stored - memory.stored) + elastic,
        heat=state.heat + heat,
        vacuum=state.vacuum,
        growth=state.growth,
        closed=state.closed | (memory.slip - slip > 1e-12 * setting.overlap),
        snapped=state.snapped | (out & (setting.k <= friction_tangent(memory.slip, setting).c)),
    )


def change_vacuum(state: State, vacuum: Any, after: Setting) -> State:
    """Change the vacuum at a fixed crosshead, without work; released energy becomes heat."""
    pumped_memory = state.enclosure.apply_vacuum(after.enclosure)
    new = move(state._replace(enclosure=pumped_memory), state.elongation, after)
    spring = (state.force**2 - new.force**2) / (2 * after.k)
    loss = state.enclosure.stored - new.enclosure.stored + spring
    return new._replace(work=state.work, heat=state.heat + loss, vacuum=vacuum)


@law
@compiled
def brake_cycle(elongation: Any, vacuum: Any, brake: Brake, speed: Any = None) -> Cycle:
    """Return the response of the brake along an elongation history [m], (N,), from rest at zero.

    `vacuum` [Pa] is one number or a history of the same shape, applied before each move. Sheets
    stick with stiffness k and slide at F_f; the enclosure has a memory. If the brake starts to
    slide on a k that is not above c (`least_stiffness`) it snaps, and later forces are NaN. A
    hyperelastic enclosure is divided into cells, and the vacuum must not fall once it is stretched
    (NaN from there).
    `speed` [m/s] of the crosshead, a number or a history, activates a speed law: it replaces the
    speed of the slip, which is smaller by the factor 1/(1 + F'/k).
    """
    elongation = xp.atleast_1d(elongation)
    is_steady = xp.ndim(vacuum) == 0 and (speed is None or xp.ndim(speed) == 0)
    vacuum, growth = xp.broadcast_to(vacuum, elongation.shape), None
    if speed is not None:
        check_modulus(brake)
        growth = xp.broadcast_to(brake_growth(speed, brake), elongation.shape)
    spring = xp.asarray(working_stiffness(brake), xp.float64)

    def step(state: State, point: tuple[Any, Any, Any]) -> tuple[State, Cycle]:
        target, pressure, growth = point
        if is_steady:  # a change of vacuum would have to be compiled too
            return _pull_to(state, target, make_setting(pressure, spring, brake, growth), brake)
        return step_state(state, target, pressure, growth, spring, brake)

    start = new_state(vacuum[0], None if growth is None else growth[0])
    start = start._replace(enclosure=relaxed_enclosure(elongation, vacuum, brake))
    return scan(step, start, (elongation, vacuum, growth))[1]


def new_state(vacuum: Any, growth: Any = None) -> State:
    """Return a brake that was never pulled, at a vacuum [Pa]."""
    zero, false = xp.array(0.0), xp.array(False)
    return State(new_memory(), zero, zero, zero, zero, vacuum, false, false, growth)


def step_state(
    state: State, target: Any, pressure: Any, growth: Any, spring: Any, brake: Brake
) -> tuple[State, Cycle]:
    """Return the brake after a change of vacuum [Pa] and a move to an elongation [m]."""
    new_setting = make_setting(pressure, spring, brake, growth)
    is_unchanged = pressure == state.vacuum
    if growth is not None:
        is_unchanged = is_unchanged & (growth == state.growth)
    # the vacuum is constant in most of a history, so the other branch is skipped
    state = choose(
        is_unchanged,
        lambda s: s,
        lambda s: change_vacuum(s, pressure, new_setting)._replace(growth=growth),
        state,
    )
    return _pull_to(state, target, new_setting, brake)


def _pull_to(state: State, target: Any, setting: Setting, brake: Brake) -> tuple[State, Cycle]:
    """Return the brake after a move to an elongation [m] at its vacuum."""
    state = move(state, target, setting)
    enclosure = state.enclosure
    is_valid = (target >= 0) & (state.vacuum >= 0) & ~(enclosure.is_invalid | state.snapped)
    force = xp.where(is_valid, state.force, xp.nan)
    return state, Cycle(
        force=force,
        slip=enclosure.slip,
        sleeve_force=enclosure.force,
        work=state.work,
        heat=state.heat,
        stored=enclosure.stored + state.force**2 / (2 * setting.k),
        slack=(state.force <= 0) & (target < enclosure.slip),
        closed=state.closed,
        separated=enclosure.slip >= brake.sheets.overlap * (1 - 1e-12),
        overflow=enclosure.overflow,
        snapped=state.snapped,
    )
