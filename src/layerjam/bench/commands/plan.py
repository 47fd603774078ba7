"""`plan`: whether the vacuum is reached before a collision, and the changes needed if not."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.bench.commands.plan_notices import list_plan_notices
from layerjam.brake.commands.arguments import (
    Accept,
    ArrivalSpeed,
    Atmosphere,
    BrakeInput,
    Confidence,
    Horizontal,
    Interval,
    LeakTime,
    Mass,
    RopeStiffness,
    Seed,
    StopTravel,
    VacuumShare,
    apply_share,
    check_vacuum,
)
from layerjam.brake.commands.lines import Fluid, LineInput
from layerjam.brake.commands.tuning import format_distinct, tune
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line import Leak, Line, water_compliance
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, MASS, VACUUM
from layerjam.brake.simulate.record import Outcome
from layerjam.core.command.declare import Help, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Figure, Judged, add_prefix, fact, number, result
from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec, show, show_at_least
from layerjam.core.verdict import judge

if TYPE_CHECKING:
    from layerjam.bench.control.plan import Arrival, Plan
    from layerjam.bench.control.plan_build import Build
    from layerjam.bench.control.plan_spread import Spread
    from layerjam.bench.control.standby import Standby

NO_VACUUM = "no vacuum available at the site stops it within the travel"
WARNING = QuantitySpec("s", "warning time, until the rope is taut,", hi=1e5, example="3s")
SAMPLES = QuantitySpec("1", "masses, speeds and brakes to try", lo=100, hi=10_000_000, whole=True)
MASS_SD = QuantitySpec("kg", "standard deviation of the mass", hi=MASS.hi, example="0.1kg")
SPEED_SD = QuantitySpec(
    "m/s", "standard deviation of the speed", hi=ARRIVAL_SPEED.hi, example="0.2m/s"
)


@result
class CollisionPlan(Judged, PredictionResult):
    """Stop with the vacuum that is reached in time, and stop with a sufficient vacuum.

    `record` is the Plan.

    Keys without a prefix use all the vacuum that is reached in time. Those with `tuned_` use the
    vacuum that just stops the estimate within the travel, limited to that reached in time. `full_`
    and `tuned_` are probabilities for log-normal mass and speed and a brake that scatters:
    `_beyond` of needing more slip than the travel, `_out` of needing more than the brake has.
    `expected_g` covers the stops that succeed. Each `_needed` value is a size that suffices if only
    that size is changed. It is None, with a reason, if no size is sufficient or needed.
    """

    record: Plan
    feasible: bool = fact(
        "whether the estimated mass stops within the travel at the vacuum reached in time"
    )
    reason: str | None = fact("reason if it does not")
    warning: float = number("s", "warning time")
    standing: float = number("Pa", "idle vacuum, held while waiting")
    reached: float = number("Pa", "vacuum when the rope becomes taut")
    reachable: float = number("Pa", "highest vacuum that the line reaches")
    needed: float | None = number(
        "Pa", "lowest vacuum that stops the estimated mass within the travel"
    )
    knife_edge: bool = fact(
        "whether a vacuum 1 ppm lower would exceed the travel", shown=lambda edge: "yes" * edge
    )
    safe_vacuum: float | None = number(
        "Pa", "vacuum that keeps the stated share of stops within the travel", default=None
    )
    confidence: float = number(
        "1", "that share of stops", shown=lambda share: f"{share * 100:.4g} %", default=0.95
    )
    outcome: str = fact("outcome of the stop")
    slip: float | None = number("m", "slip of the brake")
    peak_force: float | None = number("N", "maximum force on the mass")
    peak_g: float | None = number("1", "ratio of peak force to weight")
    end_speed: float | None = number("m/s", "speed at the end")
    dissipated_energy: float | None = number("J", "heat of the stop")
    vacuum_change: float | None = number("Pa", "change in vacuum during the stop")
    slip_change: float | None = number("m", "resulting change in slip")
    peak_change: float | None = number("N", "resulting change in peak force")
    coupling_matters: bool | None = fact("whether that change is significant")
    tuned_vacuum: float = number("Pa", "tuned vacuum")
    tuned_capped: bool = fact("whether the line limits the tuned vacuum")
    tuned_outcome: str = fact("outcome of the stop")
    tuned_slip: float | None = number("m", "slip of the brake")
    tuned_peak_force: float | None = number("N", "maximum force on the mass")
    tuned_peak_g: float | None = number("1", "ratio of peak force to weight")
    tuned_vacuum_change: float | None = number("Pa", "change in vacuum during the stop")
    tuned_slip_change: float | None = number("m", "resulting change in slip")
    tuned_peak_change: float | None = number("N", "resulting change in peak force")
    tuned_coupling_matters: bool | None = fact("whether that change is significant")
    coupling_rounds: int | None = fact("iterations between line and stop")
    coupling_remaining: float | None = number("1", "relative change in the last iteration")
    full_expected_g: float | None = number("1", "expected peak in g")
    full_g_95: float | None = number("1", "95th percentile of the peak in g")
    full_beyond: float = number("1", "probability of needing more slip than the travel")
    full_out: float = number("1", "probability of needing more slip than the brake has")
    tuned_expected_g: float | None = number("1", "expected peak in g")
    tuned_g_95: float | None = number("1", "95th percentile of the peak in g")
    tuned_beyond: float = number("1", "probability of needing more slip than the travel")
    tuned_out: float = number("1", "probability of needing more slip than the brake has")
    expected_g_error: float | None = number("1", "standard error of the expected peaks")
    chance_error: float = number("1", "standard error of the probabilities")
    samples: int = fact("masses, speeds and brakes tried")
    seed: int = fact("random seed for them")
    warning_needed: float | None = number("s", "sufficient warning time")
    warning_needed_reason: str | None = fact("reason if there is none")
    reservoir_needed: float | None = number("m^3", "sufficient reservoir volume")
    reservoir_needed_reason: str | None = fact("reason if there is none")
    conductance_needed: float | None = number("m^3/(s Pa)", "conductance of the reservoir valve")
    conductance_needed_reason: str | None = fact("reason if there is none")
    standing_needed: float | None = number("Pa", "sufficient idle vacuum")
    standing_needed_reason: str | None = fact("reason if there is none")
    cv_needed: float | None = number("1", "flow coefficient Cv of the valve")
    reservoir_conductance: float | None = number("m^3/(s Pa)", "conductance used for it")
    conductance_volume: float | None = number("m^3", "volume used for that conductance")
    standing_needed_power: float | None = number("W", "minimum pump power to hold that idle vacuum")
    standing_needed_electric: float | None = number("W", "electric power for it")
    standing_needed_force: float | None = number("N", "force of the brake at that idle vacuum")
    jam_work: float = number("J", "work done on the gas to jam the brake once")
    refill_work: float = number("J", "work to evacuate the reservoir again")
    pump_energy: float | None = number("J", "electric energy of the pump during the warning")
    standing_power: float | None = number("W", "minimum power to hold the idle vacuum")
    standing_electric: float | None = number("W", "electric power for it")
    heat_per_work: float | None = number(
        "1", ("ratio of the heat of the stop to the work of jamming")
    )
    heat_per_pump_energy: float | None = number(
        "1", ("ratio of the heat of the stop to the pump energy")
    )

    def rows(self) -> list[tuple[str, str]]:
        """Return the rows without empty reasons."""
        left_out = set()
        if self.needed is None or self.feasible:
            left_out |= {f.name for f in self.keys() if f.name.endswith("_needed_reason")}
        names = {name.replace("_", " ") for name in left_out}
        return [
            (name, self._format_rounded_up_value(name) or text)
            for name, text in super().rows()
            if name not in names
        ]

    def _format_rounded_up_value(self, name: str) -> str | None:
        """Return the text of a quantity that must not be rounded down; None for any other."""
        key = name.replace(" ", "_")
        if key not in LEAST_SIZES or (key == "tuned_vacuum" and self.tuned_capped):
            return None  # a capped value is the vacuum that is reached
        limit = math.inf
        if key == "standing_needed":
            limit = self.reachable
        elif self.units[key] == "Pa":
            limit = self.record.brake.brake.site.atmosphere
        return show_at_least(getattr(self, key), self.units[key], limit)

    def draw(self) -> Figure:
        """Return the figure of the vacuum during the warning, the stops, and the probabilities."""
        from layerjam.bench.figures import control_figures

        return control_figures.draw_plan(self.record)


LEAST_SIZES = {
    *("needed", "safe_vacuum", "tuned_vacuum", "warning_needed", "reservoir_needed"),
    *("conductance_needed", "standing_needed", "cv_needed"),
}
"""Keys of minimum values, which must therefore not be rounded down."""
StoredVacuum = Annotated[
    float | None, VACUUM, Help("Vacuum in the line's reservoir before the warning.")
]
SampleCount = Annotated[int, SAMPLES, Help("Minimum number of masses, speeds and brakes to try.")]
SPREAD = ("expected_g", "g_95", "beyond", "out")


@command("vacuum")
def plan(
    line: LineInput,
    brake: BrakeInput,
    *,
    mass: Mass,
    speed: Annotated[ArrivalSpeed, Help("Estimated arrival speed.")],
    warning: Annotated[float, WARNING, Help("Time from the warning until the rope is taut.")],
    travel: StopTravel,
    mass_sd: Annotated[float, MASS_SD] = 0.0,
    speed_sd: Annotated[float, SPEED_SD] = 0.0,
    standing: Annotated[float, VACUUM, Help("Idle vacuum, held while waiting.")] = 0.0,
    stored: StoredVacuum = None,
    rope_stiffness: RopeStiffness | None = None,
    horizontal: Horizontal = False,
    fluid: Fluid = "air",
    vacuum_share: VacuumShare | None = None,
    leak_time: LeakTime | None = None,
    samples: SampleCount = 40_000,
    seed: Annotated[Seed, Help("Random seed for them.")] = 1,
    confidence: Confidence = 0.95,
    interval: Interval = "next",
    accept: Accept = None,
    atmosphere: Atmosphere = None,
) -> CollisionPlan:
    """Predict whether the vacuum is reached before a collision, and the changes needed if not.

    The estimated mass and speed are means. Friction and mounting of the brake scatter too: at
    `safe_vacuum`, the share `confidence` of stops stays within the travel. By default `stored` is
    the pressure at which pump and leak balance. The fraction `vacuum_share` of the gauge's reading
    presses the sheets. `leak_time` is a laminar leak of the chamber, also during the stop.
    """
    from layerjam.bench.control.plan import Arrival, checks_of_plan, plan_stop

    water = fluid == "water"
    brake, line = apply_share(brake, vacuum_share), _add_leak(line, leak_time, water)
    case = Arrival(
        mass=mass,
        speed=speed,
        warning=warning,
        travel=travel,
        mass_sd=mass_sd,
        speed_sd=speed_sd,
        standing=standing,
        rope_stiffness=rope_stiffness,
        gravity=0.0 if horizontal else brake.brake.site.gravity,
    )
    highest = _check_arrival(case, line, brake, water)
    reservoir = None if stored is None else _reservoir_pressure(stored, line.line)
    leaks = leak_time is not None
    plan = plan_stop(brake, line.line, case, stored=reservoir, water=water, leaks=leaks)
    full_spread, later_spread, intervals = _predict_scatter(
        plan, samples, seed, confidence, interval == "mean"
    )
    is_enough, build = plan.full.stops_within(travel), _suggest_build(plan)
    checks = checks_of_plan(plan, full_spread.beyond, intervals["safe_vacuum"], confidence)
    return CollisionPlan.create(
        case,
        plan,
        judge(checks, accept),
        intervals,
        *_collect_stop_records(plan),
        _collision_probabilities(full_spread, later_spread),
        _suggest_sizes(plan, build),
        seed=seed,
        feasible=is_enough,
        reason=None if is_enough else _failure_reason(plan),
        reachable=highest,
        warnings=[*line.warnings(), *brake.warnings(), *list_plan_notices(plan, build)],
        record=plan,
    )


def _collect_stop_records(plan: Plan) -> tuple[Any, ...]:
    """Return both stops, the iteration of each stop with the vacuum line, and the energies."""
    full_coupling, tuned_coupling = plan.full.coupled, plan.tuned.coupled
    later_stop = add_prefix(
        "tuned_", plan.tuned, tuned_coupling, add_prefix("coupling_", tuned_coupling)
    )
    iteration, limits = add_prefix("coupling_", full_coupling), {"tuned_capped": plan.capped}
    return plan.full, full_coupling, iteration, later_stop, limits, _compute_energies(plan)


def _add_leak(line: LineFile, leak_time: Any, water: bool) -> LineFile:
    """Return the line with a chamber leak that has the time constant `leak_time` [s]."""
    if leak_time is None:
        return line
    if water:
        raise QuantityError.of("leak_time", "is a gas leak; omit it in water")
    if line.line.leak != Leak():
        raise QuantityError.of(
            "leak_time", f"{line.name} already states a leak; omit one of the two"
        )
    leak = Leak(laminar=line.line.chamber.volume / leak_time)
    leaking_line = replace(line, line=replace(line.line, leak=leak))
    leaking_line.check(leaking_line.line)
    return leaking_line


def _reservoir_pressure(vacuum: float, line: Line) -> float:
    if line.reservoir is None:
        raise QuantityError.of("stored", "the line has no reservoir; omit this option")
    check_vacuum(vacuum, line, "stored")
    return line.site.atmosphere - vacuum


def _check_arrival(case: Arrival, line: LineFile, brake: BrakeFile, water: bool) -> float:
    """Return the line's highest vacuum [Pa]; raises QuantityError for contradictory options."""
    from layerjam.brake.fluid.closed_forms import reachable_vacuum

    outside, inside = line.line.site.atmosphere, brake.brake.site.atmosphere
    if outside != inside:
        raise QuantityError.of(
            "atmosphere",
            f"{show(outside, 'Pa', 6)} in the line {line.name} and {show(inside, 'Pa', 6)} "
            f"in the brake {brake.name}; give that of your site",
        )
    if water:
        water_compliance(line.line)
    if water and line.line.reservoir is not None:
        raise QuantityError.of(
            "fluid",
            f"water, but {line.name} has a gas reservoir; plan in air, or remove the "
            "reservoir from the line file",
        )
    highest, usable = reachable_vacuum(line.line, water), brake.brake.sheets.usable_travel
    sentence = f"more than the line can hold; pump and leak balance at {show(highest, 'Pa')}"
    for name, value, limit, unit, consequence in (
        ("travel", case.travel, usable, "m", f"beyond the usable travel of {show(usable, 'm')}"),
        ("mass sd", case.mass_sd, case.mass, "kg", "more than the mass itself"),
        ("speed sd", case.speed_sd, case.speed, "m/s", "more than the speed itself"),
        ("standing", case.standing, highest, "Pa", sentence),
    ):
        if value > limit:
            raise QuantityError.of(name, f"{format_distinct(value, limit, unit)} is {consequence}")
    return highest


def _failure_reason(plan: Plan) -> str:
    """Return the reason why the estimate does not stop within the travel."""
    case = plan.case
    if plan.needed is None:
        numbers = {k: getattr(case, k) for k in ("mass", "speed", "travel", "rope_stiffness")}
        tuning = tune(plan.brake, **numbers, horizontal=not case.gravity)
        return f"no vacuum available at the site is sufficient: {tuning.reason}"
    if plan.full.outcome is Outcome.SNAPS:
        return (
            f"at {show(plan.reached, 'Pa')} the brake snaps on such a soft rope; the tuned vacuum, "
            f"{show(plan.needed, 'Pa')}, stops the mass"
        )
    enough = show_at_least(plan.needed, "Pa", plan.brake.brake.site.atmosphere)
    vacuum = format_distinct(plan.reached, plan.needed, "Pa")
    return (
        f"{vacuum} is reached after {show(case.warning, 's')}; "
        f"{enough} is needed to stop within {show(case.travel, 'm')}"
    )


def _suggest_build(plan: Plan) -> Build | None:
    """Return possible changes if stopping needs a higher vacuum than is reached in time."""
    from layerjam.bench.control.plan_build import suggest_sizes

    is_enough = plan.full.stops_within(plan.case.travel)
    if is_enough or plan.needed is None or plan.needed <= plan.reached:
        return None
    return suggest_sizes(plan.standby, plan.needed, plan.case.warning)


def _predict_scatter(
    plan: Plan, samples: int, seed: int, confidence: float, of_mean: bool
) -> tuple[Spread, Spread, dict[str, Any]]:
    """Return the spread of the next stops at both vacuums, and the fields of their prediction."""
    from layerjam.bench.control import plan_spread

    spreads = plan_spread.predict_spreads(plan, samples, seed)
    safe_vacuum = plan_spread.find_safe_vacuum(plan, confidence, seed)
    sources, vacuums = spreads, safe_vacuum
    if of_mean:
        sources = plan_spread.predict_spreads(plan, samples, seed, of_mean)
        vacuums = plan_spread.find_safe_vacuum(plan, confidence, seed, of_mean)
    intervals = plan_spread.predict_intervals(plan, sources, vacuums.least_vacuums, of_mean)
    return *spreads, {**intervals, "safe_vacuum": safe_vacuum.vacuum, "confidence": confidence}


def _collision_probabilities(full: Spread, later: Spread) -> dict[str, float]:
    """Return the mean peaks and probabilities of both stops, and the larger sampling error."""
    out: dict[str, float] = {
        "samples": full.tried,
        "expected_g_error": max(full.peak_g_error, later.peak_g_error),
        "chance_error": max(full.beyond_error, full.out_error, later.beyond_error, later.out_error),
    }
    for head, spread in (("full", full), ("tuned", later)):
        numbers = (spread.peak_g, spread.peak_g_95, spread.beyond, spread.out)
        out |= {f"{head}_{key}": n for key, n in zip(SPREAD, numbers, strict=True)}
    return out


def _suggest_sizes(plan: Plan, build: Build | None) -> dict[str, Any]:
    """Return sufficient sizes or the reason why there is none; one reason if `build` is None."""
    from layerjam.bench.control.plan_build import Size, valve_cv
    from layerjam.brake.mechanics.pull import brake_force

    enough = "not needed: the vacuum is reached in time"
    no_size = Size(None, NO_VACUUM if plan.needed is None else enough)
    out: dict[str, Any] = {}
    for name in ("warning", "reservoir", "conductance", "standing"):
        size = no_size if build is None else getattr(build, name)
        out[f"{name}_needed"], out[f"{name}_needed_reason"] = size.value, size.reason
    if build is not None:
        out["reservoir_conductance"] = build.conductance_used
        out["conductance_volume"] = build.volume_used
    if out["conductance_needed"] is not None:
        out["cv_needed"] = valve_cv(out["conductance_needed"])
    standing = out["standing_needed"]
    if standing is not None:
        out["standing_needed_force"] = float(brake_force(0.0, standing, plan.brake.brake))
        out |= _standby_power("standing_needed", standing, plan.standby)
    return out


def _standby_power(head: str, vacuum: float, standby: Standby) -> dict[str, float | None]:
    """Return the power for maintaining a vacuum [Pa] in air while waiting."""
    from layerjam.brake.fluid.vacuum_energy import holding_cost

    if standby.water:
        return {}
    record = holding_cost(vacuum, standby.line)
    return {f"{head}_power": record.least_power, f"{head}_electric": record.electric_power}


def _compute_energies(plan: Plan) -> dict[str, Any]:
    """Return the heat of the stop, the work of this evacuation and the power while waiting."""
    from layerjam.brake.fluid import vacuum_energy as energy
    from layerjam.brake.fluid.network import RESERVOIR

    line, water, heat = plan.standby.line, plan.standby.water, plan.full.heat
    start, end = plan.rising.states[0], plan.rising.states[-1]
    work = energy.jam_work(plan.reached, line, water, plan.case.standing)
    refill = energy.refill_work(float(end[RESERVOIR]), float(start[RESERVOIR]), line)
    electric = energy.electric_energy(plan.case.warning, line)
    return {
        "dissipated_energy": heat,
        "jam_work": work,
        "refill_work": 0.0 if water else refill,
        "pump_energy": electric,
        **_standby_power("standing", plan.case.standing, plan.standby),
        "heat_per_work": energy.heat_per_joule(heat, work),
        "heat_per_pump_energy": energy.heat_per_joule(heat, electric),
    }
