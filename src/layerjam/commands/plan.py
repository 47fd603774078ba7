"""`plan`: whether the vacuum will be there when the collision comes, and what to build if not."""

from __future__ import annotations

import math

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.commands.quantities import ARRIVAL_SPEED as SPEED
from layerjam.commands.quantities import MASS, ROPE_STIFFNESS
from layerjam.commands.quantities import STOP_TRAVEL as TRAVEL
from layerjam.commands.tuning import apart, tune
from layerjam.commands.vacuum_line import FLUIDS, AnyLine, line_at
from layerjam.control.plan import Arrival, Plan
from layerjam.control.plan import plan as make_plan
from layerjam.control.plan_build import Build, Size, valve_cv, what_to_build
from layerjam.control.plan_spread import SAMPLES, SEED, SHIFTS, Spread, spread
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError, QuantityError, UnknownNameError
from layerjam.fluid import energy
from layerjam.fluid.closed_forms import lowest, reachable
from layerjam.fluid.file import LineFile
from layerjam.fluid.line import Line
from layerjam.fluid.network import CHAMBER, RESERVOIR
from layerjam.mechanics.pull import brake_force
from layerjam.simulate.coupled import MATTERS
from layerjam.simulate.record import Outcome
from layerjam.units import QuantitySpec, show

WARNING = QuantitySpec("s", "warning time, up to the taut rope,", hi=1e5)
STANDING = QuantitySpec("Pa", "vacuum held while waiting")
STORED = QuantitySpec("Pa", "vacuum in the reservoir before the warning")
MOST_SD = 1.0
"""Greatest standard deviation, over the mean."""
COUNT = QuantitySpec("1", "number of samples", lo=100, hi=10_000_000, whole=True)
SEEDS = QuantitySpec("1", "seed", hi=2**63, whole=True)
UNITS = {
    "warning": "s", "standing": "Pa", "reached": "Pa", "reachable": "Pa", "needed": "Pa",
    "slip": "m", "peak_force": "N", "peak_g": "1", "end_speed": "m/s", "dissipated_energy": "J",
    "tuned_vacuum": "Pa", "tuned_slip": "m", "tuned_peak_force": "N", "tuned_peak_g": "1",
    "vacuum_change": "Pa", "slip_change": "m", "peak_change": "N", "tuned_vacuum_change": "Pa",
    "tuned_slip_change": "m", "tuned_peak_change": "N", "coupling_remaining": "1",
    "full_expected_g": "1", "full_g_95": "1", "full_beyond": "1", "full_out": "1",
    "tuned_expected_g": "1", "tuned_g_95": "1", "tuned_beyond": "1", "tuned_out": "1",
    "expected_g_error": "1", "chance_error": "1", "warning_needed": "s",
    "reservoir_needed": "m^3", "reservoir_conductance": "m^3/(s Pa)",
    "conductance_needed": "m^3/(s Pa)", "cv_needed": "1", "conductance_volume": "m^3",
    "standing_needed": "Pa", "standing_needed_force": "N", "standing_needed_power": "W",
    "standing_needed_electric": "W", "standing_power": "W", "standing_electric": "W",
    "jam_work": "J", "refill_work": "J", "pump_energy": "J", "heat_per_work": "1",
    "heat_per_pump_energy": "1",
}  # fmt: skip


def plan(
    line: AnyLine,
    brake: AnyBrake,
    *,
    mass: Quantity,
    speed: Quantity,
    warning: Quantity,
    travel: Quantity,
    mass_sd: Quantity | None = None,
    speed_sd: Quantity | None = None,
    standing: Quantity = 0.0,
    stored: Quantity | None = None,
    rope_stiffness: Quantity | None = None,
    horizontal: bool = False,
    fluid: str = "air",
    samples: int = SAMPLES,
    seed: int = SEED,
    atmosphere: Quantity | None = None,
) -> Answer:
    """Vacuum reached in a warning time, the stop it gives, and what would be enough.

    `feasible` says whether the estimate (mean mass and speed) stops within `travel` (slip) at all
    the vacuum that comes in time. `full_*` uses that vacuum; `tuned_*` what just stops the estimate
    within the travel, capped by it. Expected peak and chances are over log-normal mass and speed of
    the given standard deviations: `*_beyond` needs more slip than `travel`, `*_out` more than the
    brake has; `expected_g` is of those that stop. `stored` is the reservoir's vacuum before the
    warning, as low as pump and leak come to unless given. `*_needed` are sizes that would do, each
    alone; None where it would not or need not, with the reason under the same name and `_reason`.
    `record` is the Plan.
    """
    if fluid not in FLUIDS:
        raise UnknownNameError("fluid", fluid, FLUIDS)
    pipe, file = line_at(line, atmosphere), brake_at(brake, atmosphere)
    water = fluid == "water"
    _check_site(pipe, file, water)
    case = _case(
        pipe.line, file, mass, speed, warning, travel, mass_sd, speed_sd, standing, rope_stiffness,
        horizontal, water,
    )  # fmt: skip
    kept = None if stored is None else _stored(stored, pipe.line)
    COUNT.check(float(samples), "samples")
    SEEDS.check(float(seed), "seed")
    made = make_plan(file, pipe.line, case, stored=kept, water=water)
    fine = made.full.within(case.travel)
    build = None
    if not fine and made.needed is not None and made.needed > made.reached:
        build = what_to_build(made.standby, made.needed, case.warning)
    full = spread(made.reached, file.brake, case, samples, seed)
    tuned = full if made.capped else spread(made.tuned.vacuum, file.brake, case, samples, seed)
    reason = None if fine else _reason(made, file, case, horizontal)
    values: dict[str, object] = {
        "feasible": fine,
        "reason": reason,
        "warning": case.warning,
        "standing": case.standing,
        "reached": made.reached,
        "reachable": reachable(pipe.line, water),
        "needed": made.needed,
        **_stops(made, file),
        **_uncertain(full, tuned, case, samples, seed),
        **_sizes(made, build, pipe.line, file, water),
        **_cost(made, pipe.line, water),
    }
    said = [*pipe.warnings(), *file.warnings(), *_remarks(made, build, pipe.line, kept, water)]
    return Answer(values=values, units=UNITS, warnings=said, record=made)


def _case(
    line: Line, file: BrakeFile, mass: Quantity, speed: Quantity, warning: Quantity,
    travel: Quantity, mass_sd: Quantity | None, speed_sd: Quantity | None, standing: Quantity,
    rope: Quantity | None, horizontal: bool, water: bool,
) -> Arrival:  # fmt: skip
    """All in SI, each within its bounds."""
    weighs, arrives, way = si(mass, MASS, "mass"), si(speed, SPEED, "speed"), si(
        travel, TRAVEL, "travel"
    )  # fmt: skip
    usable = file.brake.sheets.usable_travel
    if way > usable:
        raise QuantityError(
            f"travel: {apart(way, usable, 'm')} is beyond the usable travel of {show(usable, 'm')}"
        )
    held = si(standing, STANDING, "standing")
    most = reachable(line, water)
    if held > most:
        raise QuantityError(
            f"standing: {apart(held, most, 'Pa')} is more than the line can hold; pump and leak "
            f"come to {show(most, 'Pa')}"
        )
    return Arrival(
        mass=weighs, speed=arrives, warning=si(warning, WARNING, "warning"), travel=way,
        mass_sd=_sd(mass_sd, weighs, MASS, "mass"), speed_sd=_sd(speed_sd, arrives, SPEED, "speed"),
        standing=held,
        rope_stiffness=None if rope is None else si(rope, ROPE_STIFFNESS, "rope stiffness"),
        gravity=0.0 if horizontal else file.brake.site.gravity,
    )  # fmt: skip


def _sd(sd: Quantity | None, mean: float, spec: QuantitySpec, name: str) -> float:
    if sd is None:
        return 0.0
    most = MOST_SD * mean
    what = f"standard deviation of the {name} (at most the {name} itself)"
    return si(sd, QuantitySpec(spec.unit, what, hi=most), f"{name} sd")


def _stored(stored: Quantity, line: Line) -> float:
    """Absolute pressure of the reservoir [Pa]."""
    vacuum, a = si(stored, STORED, "stored"), line.site.atmosphere
    if line.reservoir is None:
        raise QuantityError("stored: the line has no reservoir; leave it out")
    if vacuum > a:
        raise QuantityError(
            f"stored: {show(vacuum, 'Pa', 6)} is more than the atmosphere, {show(a, 'Pa', 6)}; a "
            "vacuum is at most that"
        )
    return a - vacuum


def _check_site(line: LineFile, file: BrakeFile, water: bool) -> None:
    ours, theirs = line.line.site.atmosphere, file.brake.site.atmosphere
    if ours != theirs:
        raise QuantityError(
            f"atmosphere: {show(ours, 'Pa', 6)} in the line {line.name} and {show(theirs, 'Pa', 6)}"
            f" in the brake {file.name}; give the one of the site"
        )
    if water and line.line.chamber.compliance is None:
        raise FitError(
            f"chamber.compliance: {line.name} has none, so that nothing says how much water a "
            "vacuum draws out"
        )
    if water and line.line.reservoir is not None:
        raise QuantityError(
            f"fluid: water, but {line.name} has a reservoir, which is one of gas; plan it in air "
            "or take the reservoir out of its file"
        )


def _reason(made: Plan, file: BrakeFile, case: Arrival, horizontal: bool) -> str:
    """Why the estimate does not stop within the travel."""
    if made.needed is None:
        found = tune(
            file, mass=case.mass, speed=case.speed, travel=case.travel,
            rope_stiffness=case.rope_stiffness, horizontal=horizontal,
        )  # fmt: skip
        return f"no vacuum of the site does it: {found.reason}"
    if made.full.outcome is Outcome.SNAPS:
        return (
            f"at {show(made.reached, 'Pa')} the brake snaps on a rope so soft; the tuned vacuum, "
            f"{show(made.needed, 'Pa')}, does it"
        )
    return (
        f"{apart(made.reached, made.needed, 'Pa')} is there after {show(case.warning, 's')}; "
        f"{show(made.needed, 'Pa')} is needed to stop within {show(case.travel, 'm')}"
    )


def _stops(made: Plan, file: BrakeFile) -> dict[str, object]:
    g, mass = file.brake.site.gravity, made.case.mass
    out: dict[str, object] = {}
    for head, mode in (("", made.full), ("tuned_", made.tuned)):
        if head:
            out["tuned_vacuum"] = mode.vacuum
            out["tuned_capped"] = made.capped
        known = mode.outcome is not Outcome.SNAPS
        out |= {
            f"{head}outcome": str(mode.outcome),
            f"{head}slip": mode.slip if known else None,
            f"{head}peak_force": mode.peak_force if known else None,
            f"{head}peak_g": mode.peak_force / (mass * g) if g and known else None,
        }
        if not head:
            out["end_speed"] = mode.end_speed if known else None
            out["dissipated_energy"] = mode.heat if known else None
        both = mode.coupled
        out |= {
            f"{head}vacuum_change": None if both is None else both.vacuum_change,
            f"{head}slip_change": None if both is None else both.slip_change,
            f"{head}peak_change": None if both is None else both.peak_change,
            f"{head}coupling_matters": None if both is None else both.matters,
        }
    both = made.full.coupled
    out["coupling_rounds"] = None if both is None else both.rounds
    out["coupling_remaining"] = None if both is None else both.remaining
    return out


def _uncertain(
    full: Spread, tuned: Spread, case: Arrival, samples: int, seed: int
) -> dict[str, object]:
    out: dict[str, object] = {}
    for head, made in (("full", full), ("tuned", tuned)):
        out |= {
            f"{head}_expected_g": _finite(made.peak_g), f"{head}_g_95": _finite(made.peak_g_95),
            f"{head}_beyond": made.beyond, f"{head}_out": made.out,
        }  # fmt: skip
    out["expected_g_error"] = _finite(max(full.peak_g_error, tuned.peak_g_error))
    out["chance_error"] = max(
        full.beyond_error, full.out_error, tuned.beyond_error, tuned.out_error
    )
    out["samples"], out["seed"] = full.tried, seed
    return out


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _sizes(
    made: Plan, build: Build | None, line: Line, file: BrakeFile, water: bool
) -> dict[str, object]:
    """What would do; all None with one reason where nothing is short or nothing helps."""
    why = "not needed: enough vacuum is there in time" if made.needed is not None else (
        "no vacuum of the site stops it within the travel"
    )  # fmt: skip
    nothing = Size(None, why)
    sizes = {
        "warning": nothing if build is None else build.warning,
        "reservoir": nothing if build is None else build.reservoir,
        "conductance": nothing if build is None else build.conductance,
        "standing": nothing if build is None else build.standing,
    }
    out: dict[str, object] = {}
    for name, size in sizes.items():
        out[f"{name}_needed"] = size.value
        out[f"{name}_needed_reason"] = size.reason
    opening, held = sizes["conductance"].value, sizes["standing"].value
    out["cv_needed"] = None if opening is None else valve_cv(opening)
    out["reservoir_conductance"] = None if build is None else build.conductance_used
    out["conductance_volume"] = None if build is None else build.volume_used
    cost = None if held is None or water else energy.holding(held, line)
    out["standing_needed_power"] = None if cost is None else _finite(cost.least_power)
    out["standing_needed_electric"] = None if cost is None else cost.electric_power
    out["standing_needed_force"] = (
        None if held is None else float(brake_force(0.0, held, file.brake))
    )
    return out


def _cost(made: Plan, line: Line, water: bool) -> dict[str, object]:
    """Work of this jam and power of waiting."""
    start, end = made.rising.states[0], made.rising.states[-1]
    work = energy.jam_work(made.reached, line, water, made.case.standing)
    refill = energy.refill_work(float(end[RESERVOIR]), float(start[RESERVOIR]), line)
    spent = energy.electric_energy(made.case.warning, line)
    held = None if water else energy.holding(made.case.standing, line)
    stops = made.full.outcome is not Outcome.SNAPS
    return {
        "jam_work": work,
        "refill_work": 0.0 if water else refill,
        "pump_energy": spent,
        "standing_power": None if held is None else _finite(held.least_power),
        "standing_electric": None if held is None else held.electric_power,
        "heat_per_work": energy.per_joule(made.full.heat, work) if stops else None,
        "heat_per_pump_energy": energy.per_joule(made.full.heat, spent) if stops else None,
    }


def _remarks(
    made: Plan, build: Build | None, line: Line, stored: float | None, water: bool
) -> list[str]:
    case, out = made.case, []
    if case.mass_sd or case.speed_sd:
        out.append(
            "mass and speed: log-normal, independent; chances and expected peak by exact stops at "
            f"constant vacuum on a Fibonacci lattice with {SHIFTS} random shifts, whose scatter is "
            "the error"
        )
    tank = line.reservoir
    if tank is not None and tank.delay >= case.warning:
        out.append(
            f"the reservoir's valve opens after {show(tank.delay, 's')}, when the mass is there"
        )
    if (tank is not None or build is not None) and stored is None and not water:
        out.append(
            f"reservoir: emptied to {show(lowest(line), 'Pa')} absolute before the warning, as low "
            "as pump and leak come to"
        )
    if build is not None:
        out += build.assumed
    if water:
        out.append("water: pump and compliance only; neither tube nor bubbles are counted")
    for name, mode in (("full", made.full), ("tuned", made.tuned)):
        both = mode.coupled
        if both is not None and both.matters and (name == "full" or not made.capped):
            out.append(
                f"{name} vacuum: the sleeve's stretching changes slip or peak by more than "
                f"{MATTERS:.0%}; chances and sizes count at constant vacuum"
            )
    if made.tuned.vacuum > (made.needed or math.inf) and not made.capped:
        out.append(
            f"the standing vacuum cannot be let off in time to the tuned "
            f"{show(made.needed, 'Pa')}; {show(made.tuned.vacuum, 'Pa')} is left"
        )
    a = line.site.atmosphere
    if a - float(made.rising.states[-1][CHAMBER]) < case.standing * (1 - 1e-9):
        out.append("the vacuum falls during the warning: the leak is more than the pump takes out")
    return out
