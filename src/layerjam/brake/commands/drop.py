"""`drop`: the stop of a moving mass by the brake, and its measurement."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import (
    Accept,
    ArrivalSpeed,
    Atmosphere,
    BrakeInput,
    Height,
    HoldTime,
    Horizontal,
    Interval,
    LeakTime,
    Mass,
    OtherFilm,
    RopeDamping,
    RopeStiffness,
    StopTravel,
    TunedKeyword,
    Vacuum,
    VacuumShare,
    apply_share,
    check_vacuum,
    list_rope_notices,
)
from layerjam.brake.commands.drop_options import check_damping, check_leak, check_options
from layerjam.brake.commands.sensor import Heating, Reading, Sensing, Warmth, heating, reading
from layerjam.brake.commands.tuning import TunedVacuum, arrival_speed, tune, tuning_case
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.crash import Crash, crash
from layerjam.brake.simulate.quantities import DURATION
from layerjam.brake.simulate.record import DropRecord, Outcome
from layerjam.brake.simulate.rope_alone import BareDrop
from layerjam.brake.simulate.tuned import tuning_vacuum
from layerjam.brake.simulate.vacuum_history import History
from layerjam.core.command.arguments import check_kind
from layerjam.core.command.declare import Help, Progress, PythonOnly, command
from layerjam.core.command.log_options import LogOptions
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import fact, number, result
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.plugins import load_plugin
from layerjam.core.units import show

if TYPE_CHECKING:
    from layerjam.core.drawing.chart import Curve, Pane

IDLE_SENSOR = (
    "measured_peak",
    "measured_peak_g",
    "measured_peak_time",
    "peak_loss",
    "filter",
    "accelerometer",
)
ASSUMED = ("least_stiffness", "allowed_rise", "film_coefficient", "saturated")


@result
class Stop(Reading, Heating, PredictionResult):
    """Stop of the mass, up to its first standstill or the end of the travel.

    `record` is the DropRecord, or a BareDrop without a brake.
    """

    record: DropRecord | BareDrop | None = None
    slip: float | None = number("m", "slip of the brake", default=None)
    peak_force: float | None = number("N", "maximum force on the mass", default=None)
    peak_deceleration: float | None = number(
        "m/s^2", "ratio of peak force to mass, minus gravity along the pull", default=None
    )
    peak_g: float | None = number("1", "ratio of peak force to weight", default=None)
    stopping_time: float | None = number("s", "time since the rope became taut", default=None)
    dissipated_energy: float | None = number("J", "heat generated until then", default=None)
    end_speed: float | None = number("m/s", "speed at the end", default=None)
    crash_force: float | None = number(
        "N", "maximum force after the travel is used up, if its end is rigid", default=None
    )
    crash_g: float | None = number("1", "ratio of that force to weight", default=None)
    vacuum: float | None = number("Pa", "vacuum of the brake", default=None)
    outcome: str | None = fact("outcome", default=None)
    speed: float | None = number("m/s", "speed when the rope becomes taut", default=None)
    feasible: bool = fact(
        "whether the drop could be computed", default=True, shown=lambda yes: "" if yes else "no"
    )
    reason: str | None = fact("reason if it could not", default=None)
    least_stiffness: float | None = number(
        "N/m", "stiffness of rope and brake above which the brake cannot snap", default=None
    )
    slip_at_end: float | None = number("m", "slip at the end of `duration`", default=None)
    outcome_at_end: str | None = fact("outcome at the end of `duration`", default=None)
    crash: Crash | None = None
    """Outcome of an impact at the end of the travel, or None if it is unknown."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the rows without values that were only assumed, and without an ideal sensor."""
        left_out: tuple[str, ...] = ASSUMED if self.feasible else ()
        if (self.accelerometer, self.filter, self.measured_rate) == ("ideal", "none", None):
            left_out += IDLE_SENSOR
        names = {name.replace("_", " ") for name in left_out}
        return [(name, text) for name, text in super().rows() if name not in names]

    def panes(self) -> "Sequence[Pane]":
        """Return force, speed and slip versus time, or the rope's force if there is no brake."""
        from layerjam.brake.figures import impact_figures

        if isinstance(self.record, BareDrop):
            return impact_figures.rope_panes(self.record)
        if self.record is None:
            raise QuantityError(f"a drop that was not computed has no curve: {self.reason}")
        panes = impact_figures.drop_panes(self.record, self.crash)
        peak = (self.intervals or {}).get("peak_force", {})
        ends = peak.get("low"), peak.get("high")
        return impact_figures.show_certainty(panes, ends, self.basis)

    def overlay_curves(self) -> "Sequence[Curve]":
        """Return the main curves; for a drop without a brake, only force versus time."""
        return super().overlay_curves()[: 1 if isinstance(self.record, BareDrop) else None]


@command("predict", record=(".csv", ".nc"))
def drop(
    brake: BrakeInput,
    *,
    mass: Mass,
    speed: ArrivalSpeed | None = None,
    height: Height | None = None,
    vacuum: Vacuum | TunedKeyword | None = None,
    travel: StopTravel | None = None,
    rope_stiffness: RopeStiffness | None = None,
    rope_damping: RopeDamping | None = None,
    vacuum_history: Annotated[
        str | Path | History | None,
        Help("CSV of vacuum versus time, for a varying vacuum.", metavar="FILE"),
    ] = None,
    log: LogOptions = LogOptions(),
    vacuum_share: VacuumShare | None = None,
    leak_time: LeakTime | None = None,
    held: HoldTime | None = None,
    duration: Annotated[float | None, DURATION, Help("Simulate the rebound for this long.")] = None,
    sensing: Sensing = Sensing(),
    warmth: Warmth = Warmth(),
    no_brake: Annotated[bool, Help("Use the rope alone, without the brake.")] = False,
    horizontal: Horizontal = False,
    accept: Accept = None,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
    has_intervals: Annotated[bool, PythonOnly("Whether to compute intervals.")] = True,
    progress: Progress | None = None,
) -> Stop:
    """Stop a falling mass with the brake, at a vacuum or at "tuned" for a travel (slip).

    Without `rope_stiffness` only the brake holds the mass, even if its file has a [rope]; with
    `no_brake` only the rope. Slip, peak and time refer to the first standstill or the end of
    travel. The result is exact at constant vacuum. With `rope_damping`, a `vacuum_history` or a
    `duration` that includes the rebound it is integrated in time. `reading` is the pressure
    reference of a file (absolute, gauge or vacuum) if its column does not state it. The fraction
    `vacuum_share` of the gauge's reading presses the sheets. With `leak_time` the line is shut off
    `held` before the rope is taut, and the vacuum leaks away. A mass that still moves after
    `duration` has the outcome FINISHED and no `stopping_time`, nor has one that creeps on a rope.
    """
    site = brake.brake.site
    arrives = arrival_speed(speed, height, horizontal, site.gravity)
    numbers: dict[str, Any] = {"mass": mass, "speed": arrives, "rope_stiffness": rope_stiffness}
    case = {**numbers, "gravity": 0.0 if horizontal else site.gravity}
    damping = check_damping(rope_damping, rope_stiffness)
    check_options(vacuum, travel, vacuum_history, log, no_brake, duration)
    check_leak((vacuum_share, leak_time, held), vacuum_history, no_brake)
    brake = apply_share(brake, vacuum_share)
    if no_brake:
        return observed(_drop_without_brake(case, damping, site.gravity), sensing, accept=accept)
    pressure: float | History | None
    if vacuum_history is not None:
        pressure = _read_history(vacuum_history, site.atmosphere, log)
    elif travel is not None:
        to_tune = tuning_case(brake, mass, arrives, travel, rope_stiffness, horizontal)
        if (pressure := tuning_vacuum(to_tune)) is None:
            return failed_run(tune(brake, travel=travel, horizontal=horizontal, **numbers), arrives)
    else:
        pressure = check_vacuum(vacuum, brake.brake)
    at_start = None
    if leak_time is not None and not isinstance(pressure, History):
        pressure = History.leaking(pressure, leak_time, site.atmosphere, held or 0.0)
        at_start = float(pressure.interpolate(0.0))
    kind = interval if has_intervals else None
    stop = _stop_with_brake(brake, case, pressure, damping, duration, travel, kind, progress)
    stop = stop.with_notices(*list_rope_notices(brake, rope_stiffness))
    leaks = at_start is not None
    stop = observed(evolve(stop, vacuum=at_start) if leaks else stop, sensing, warmth, accept)
    return _add_neglect_notices(bool(damping), leaks, stop, travel) if travel is not None else stop


def failed_run(tuning: TunedVacuum, speed: float | None = None) -> Stop:
    """Return the result if no tuned vacuum exists: only the reason."""
    return Stop(
        speed=speed,
        feasible=False,
        reason=tuning.reason,
        basis=tuning.basis,
        basis_reason=tuning.basis_reason,
        extrapolated=tuning.extrapolated,
        warnings=tuning.warnings,
    )


def _add_neglect_notices(damping: bool, leak: bool, stop: Stop, travel: float) -> Stop:
    """Return the stop with a notice of the effects that its tuned vacuum neglects."""
    for is_there, key, words in (
        (damping, "damping", "for a rope without damping"),
        (leak, "leak", "without the leak"),
    ):
        if is_there and stop.slip is not None:
            sentence = (
                f"the vacuum is tuned {words}; with {key} the brake slips {show(stop.slip, 'm')}, "
                f"not {show(travel, 'm')}"
            )
            stop = stop.with_notices(Notice(sentence, f"tuned-without-{key}"))
    return stop


def _stop_with_brake(
    brake: BrakeFile,
    case: dict[str, Any],
    vacuum: float | History,
    damping: float,
    end_time: float | None,
    travel: float | None,
    interval: str | None,
    progress: Progress | None,
) -> Stop:
    """Return the stop of a mass by a brake, without intervals if `interval` is None."""
    from layerjam.brake.mechanics.pull import least_stiffness
    from layerjam.brake.mechanics.speed_effects import depends_on_speed
    from layerjam.brake.simulate.stop import simulate_stop
    from layerjam.brake.simulate.stop_spread import spread_stop

    def report_progress(time: float) -> None:
        if progress is not None and end_time is not None:
            progress("the drop in time", time / end_time)

    end, record = simulate_stop(
        brake,
        vacuum=vacuum,
        **case,
        rope_damping=damping,
        duration=end_time,
        progress=report_progress,
    )
    g = brake.brake.site.gravity
    spread = spread_stop(brake, end, record, interval == "mean", sampled=interval is not None)
    ways = (record.mass, record.gravity, g)
    numbers: dict[str, Any] = {
        **spread.state(lambda force: _peak_results(force, *ways)),
        "vacuum": None if isinstance(vacuum, History) else vacuum,
        "speed": record.speed,
        "outcome": str(end.outcome),
        "record": record,
    }
    if end.outcome is Outcome.SNAPS:
        # if the brake snaps, there are no results
        return Stop(
            feasible=False,
            reason=end.reason,
            least_stiffness=end.least_stiffness,
            warnings=[
                *(words for words in record.warnings if words != end.reason),
                *spread.prediction.notices(),
            ],
            **numbers,
        )
    if end_time is not None:
        numbers |= {"slip_at_end": end.slip_at_end, "outcome_at_end": str(end.outcome_at_end)}
    crashing, crash_results, notices = _find_crash(record, g)
    return Stop(
        slip=end.slip,
        **_peak_results(end.peak_force, *ways),
        end_speed=end.end_speed,
        dissipated_energy=end.heat,
        stopping_time=None if end.outcome is Outcome.FINISHED else end.time,
        # if friction grows with speed, sliding is stable on any spring
        least_stiffness=None
        if depends_on_speed(brake.brake)
        else float(least_stiffness(record.vacuum, brake.brake)),
        warnings=[*record.warnings, *notices, *spread.notices(travel, end.outcome)],
        crash=crashing,
        **crash_results,
        **numbers,
    )


def _find_crash(record: DropRecord, g: float) -> tuple[Crash | None, dict[str, Any], list[Notice]]:
    """Return the impact at the end of the travel, its results, and notices about it."""
    if record.outcome is not Outcome.BOTTOMED_OUT:
        return None, {}, []
    crash_record = crash(record)
    if crash_record is None:
        sentence = (
            "the peaks exclude the crash at the end of the travel: its force depends on "
            "the compliance there, which is unknown without a rope"
        )
        return None, {}, [Notice(sentence, "crash-unknown")]
    force = crash_record.peak_force
    peak_g = force / (record.mass * g) if g else None
    or_g = "" if peak_g is None else f" or {show(peak_g, '1', 3)} g"
    sentence = (
        "peak force, deceleration and g do not include the crash. If the end of the travel is "
        f"rigid, the rope pulls the mass with up to {show(force, 'N')}{or_g}, otherwise with less"
    )
    return crash_record, {"crash_force": force, "crash_g": peak_g}, [Notice(sentence, "crash")]


def _peak_results(force: Any, mass: float, gravity: float, g: float) -> dict[str, Any]:
    """Return a mass's [kg] peak force [N] and decelerations; `gravity` is along the pull."""
    return {
        "peak_force": force,
        "peak_deceleration": force / mass - gravity,
        "peak_g": force / (mass * g) if g else None,
    }


def _drop_without_brake(case: dict[str, Any], damping: float, g: float) -> Stop:
    from layerjam.brake.simulate.rope_alone import simulate_bare_drop, simulate_damped_rope

    mass, speed, rope, gravity = (case[k] for k in ("mass", "speed", "rope_stiffness", "gravity"))
    if rope is None:
        raise QuantityError.of(
            "rope stiffness",
            "missing; without a brake the mass hangs on the rope, so give the stiffness "
            "of the rope (--rope-stiffness), not a brake",
        )
    force, time, heat = simulate_damped_rope(mass, speed, rope, damping, gravity)
    stands = math.isfinite(time)
    reason = None
    if not stands:
        reason = (
            f"on a rope damped by {show(damping, 'N s/m')} the mass never comes to rest: "
            f"it creeps towards {show(mass * gravity / rope, 'm')}, where the rope "
            "carries its weight; peak and heat cover the whole motion"
        )
    return Stop(
        **_peak_results(force, mass, gravity, g),
        stopping_time=time if stands else None,
        dissipated_energy=heat,
        end_speed=0.0 if stands else None,
        outcome=str(Outcome.STOPPED) if stands else None,
        speed=speed,
        reason=reason,
        record=simulate_bare_drop(mass, speed, rope, damping, gravity, g),
    )


def _read_history(source: str | Path | History, atmosphere: float, log: LogOptions) -> History:
    if not isinstance(source, History):
        history: History = load_plugin("layerjam.readers", "vacuum-history")(
            source, atmosphere, log
        )
        return history
    if log != LogOptions():
        raise QuantityError("reading: only valid with a file; a History contains the vacuum itself")
    return source


def observed(
    stop: Stop,
    sensing: Sensing | None = None,
    warmth: Warmth | None = None,
    accept: Mapping[str, str] | None = None,
) -> Stop:
    """Return the stop for a different accelerometer or a different allowed temperature rise.

    The result includes the temperature rise of the sheets; an impossible stop is unchanged.
    """
    check_kind(stop, Stop, "stop")
    if not stop.feasible or stop.record is None:
        return stop
    sensing = sensing or Sensing()
    if isinstance(stop.record, BareDrop):
        bare = stop.record
        signal = reading(
            (bare.time, bare.acceleration), sensing, gravity=bare.gravity, accept=accept
        )
        bounces = "the reading covers the first pull of the rope; later bounces are excluded"
        notices = [] if sensing.is_plain() else [Notice(bounces, "first-pull")]
        return evolve(
            stop,
            **_reading_values(signal),
            warnings=[*stop.warnings, *signal.warnings, *notices],
        )
    record = stop.record
    if stop.outcome_at_end:
        # the force after the end of travel depends on the record's outcome, not on that of the stop
        record = evolve(record, outcome=Outcome(stop.outcome_at_end))
    signal = reading(record, sensing, accept=accept)
    warm = heating(float(stop.dissipated_energy or 0.0), stop.record.brake, warmth)
    return evolve(
        stop,
        **_reading_values(signal),
        **warm.values,
        warnings=[*stop.warnings, *signal.warnings, *warm.warnings],
    )


def _reading_values(reading: Reading) -> dict[str, Any]:
    return {**reading.values, **(reading.judgement if reading.verdict else {})}
