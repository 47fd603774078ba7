"""`tune`: vacuum that stops a mass within a travel, or why there is none, with alternatives."""

import math
from collections.abc import Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.brake.commands.arguments import (
    ArrivalSpeed,
    Atmosphere,
    BrakeInput,
    Confidence,
    Height,
    Horizontal,
    Interval,
    Mass,
    OtherFilm,
    RopeStiffness,
    StopTravel,
    list_rope_notices,
)
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.command.declare import PythonOnly, command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import fact, number, result
from layerjam.core.command.wording import format_share
from layerjam.core.errors import Notice, QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import exact_text, show

if TYPE_CHECKING:
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.brake.simulate.tuned import Case


SEARCHES = ("safety", "speeds", "alternatives")
"""Names of the searches of `tune` besides those for the vacuum and the lowest peak."""


@result
class TunedVacuum(PredictionResult):
    """Vacuum that stops the mass within the travel, or the reason why none does."""

    safe_vacuum: float | None = number(
        "Pa", "vacuum that keeps the stated share of stops within the travel", default=None
    )
    confidence: float | None = number("1", "that share of stops", shown=format_share, default=None)
    vacuum: float | None = number(
        "Pa", "vacuum that stops the mass after exactly the travel, on average"
    )
    vacuum_eq10: float | None = number(
        "Pa", ("vacuum by the paper's eq. 10, without gravity and elastic energy")
    )
    feasible: bool = fact("whether there is such a vacuum", shown=lambda yes: "" if yes else "no")
    reason: str | None = fact("reason if there is none, with alternatives", default=None)
    floor_g: float | None = number("1", "lowest possible peak of a stop within the travel, in g")
    least_speed: float | None = number("m/s", "lowest arrival speed for such a stop")
    greatest_speed: float | None = number("m/s", "highest arrival speed for such a stop")
    travel_needed: float | None = number("m", "nearest sufficient travel", default=None)
    sheets_needed: int | None = number("1", "sufficient number of sheets", default=None)
    brakes_needed: int | None = number("1", "sufficient number of brakes in parallel", default=None)


def arrival_speed(
    speed: float | None, height: float | None, horizontal: bool, gravity: float
) -> float:
    """Return the speed [m/s] when the rope becomes taut, from a speed or a height.

    Raises QuantityError if both or neither are given.
    """
    if (speed is None) == (height is None):
        both = "both" if speed is not None else "neither"
        raise QuantityError(f"speed and height: {both} given; give exactly one")
    if height is None:
        return float(speed or 0.0)
    if horizontal:
        raise QuantityError("height: nothing falls in a horizontal stop; give the speed")
    if not gravity:
        raise QuantityError("height: nothing falls if gravity is 0 m/s^2; give the speed")
    return math.sqrt(2 * gravity * height)


@command("predict")
def tune(
    brake: BrakeInput,
    *,
    mass: Mass,
    travel: StopTravel,
    speed: ArrivalSpeed | None = None,
    height: Height | None = None,
    rope_stiffness: RopeStiffness | None = None,
    horizontal: Horizontal = False,
    confidence: Confidence = 0.95,
    atmosphere: Atmosphere = None,
    film: OtherFilm = None,
    interval: Interval = "next",
    searches: Annotated[
        Sequence[str], PythonOnly("Searches besides those for the vacuum and the lowest peak.")
    ] = SEARCHES,
) -> TunedVacuum:
    """Find the vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. At `vacuum` the average brake uses exactly
    the travel, so half of the stops exceed it; at `safe_vacuum` the share `confidence` of stops
    stays within it, because friction and mounting scatter. If there is no such vacuum, `reason`
    explains why and lists alternatives: the speeds that can be stopped, or a different travel,
    number of sheets or number of parallel brakes, each as the only change. Each alternative has
    been checked by tuning it. `searches` lists the other searches: "safety" for the safe vacuum and
    the intervals, "speeds" for those that can be stopped, "alternatives" for the changes.
    """
    from layerjam.brake.mechanics.stop.tune import vacuum_eq10
    from layerjam.brake.simulate.drop import series_spring
    from layerjam.brake.simulate.safe_vacuum import predict_decision
    from layerjam.brake.simulate.speed import list_stop_notices
    from layerjam.brake.simulate.tuned import tuning_vacuum

    if not set(searches) <= set(SEARCHES):
        names = ", ".join(map(repr, SEARCHES))
        raise QuantityError.of("searches", f"{searches!r} is not allowed; list some of {names}")
    device, g = brake.brake, brake.brake.site.gravity
    arrives = arrival_speed(speed, height, horizontal, g)
    case = tuning_case(brake, mass, arrives, travel, rope_stiffness, horizontal)
    pressure = tuning_vacuum(case)
    eq10 = float(vacuum_eq10(mass, arrives, travel, device))
    top = _find_top_force(case, pressure or device.site.atmosphere)
    distance = travel + top / series_spring(device, rope_stiffness)
    speed_range = _find_speeds(case, pressure is not None, searches)
    safety: dict[str, Any] = {}
    notices: list[Notice] = []
    if "safety" in searches:
        prediction = predict_decision(brake, case, pressure)
        high = speed_range["greatest_speed"]
        too_fast = high is None or arrives > high
        safety, notices = _find_safety(prediction, case, confidence, interval, too_fast)
    return TunedVacuum(
        vacuum=pressure,
        vacuum_eq10=eq10 if math.isfinite(eq10) else None,
        feasible=pressure is not None,
        floor_g=arrives**2 / (2 * g * distance) + (0.0 if horizontal else 1.0) if g else None,
        warnings=[
            *brake.warnings(),
            *list_stop_notices(brake),
            *list_rope_notices(brake, rope_stiffness),
            *notices,
        ],
        **safety,
        **speed_range,
    )


def _find_top_force(case: "Case", vacuum: float) -> float:
    """Return the largest force [N] of the brake at a vacuum [Pa], in a slow pull or in the stop."""
    from layerjam.brake.mechanics.pull import peak
    from layerjam.brake.mechanics.speed_effects import depends_on_speed
    from layerjam.brake.mechanics.stop.exact import stop
    from layerjam.brake.simulate.drop import series_spring

    device = case.brake
    top = float(peak(vacuum, device.sheets.usable_travel, device).force)
    if not depends_on_speed(device):
        return top
    spring = series_spring(device, case.rope)
    end = stop(case.mass, case.speed, vacuum, spring, case.gravity, device)
    return max(top, float(end.peak_force))


def _find_speeds(case: "Case", has_vacuum: bool, searches: Sequence[str]) -> dict[str, Any]:
    """Return the speeds that can be stopped and, without a tuned vacuum, reason and alternatives.

    Without a tuned vacuum, the basis of the prediction depends on these speeds as well.
    """
    from layerjam.brake.simulate.tuned import find_tunable_speeds

    uses_speeds = {"speeds"} if has_vacuum else {"safety", "alternatives"}
    reach = find_tunable_speeds(case) if uses_speeds.intersection(searches) else None
    low, high = reach or (None, None)
    speeds: dict[str, Any] = {"least_speed": low, "greatest_speed": high}
    if has_vacuum:
        return speeds
    if "alternatives" in searches:
        return speeds | _suggest_alternatives(case, reach)
    return speeds | {"reason": f"no vacuum stops the mass after exactly {show(case.travel, 'm')}"}


def _find_safety(
    prediction: "Prediction", case: "Case", confidence: float, interval: str, too_fast: bool
) -> tuple[dict[str, Any], list[Notice]]:
    """Return the fields of the safe vacuum, intervals and basis, and notices about them."""
    from layerjam.brake.simulate.safe_vacuum import find_safe_vacuum

    if prediction.vacuum is None:
        if too_fast:  # at the site's full vacuum
            prediction = evolve(prediction, vacuum=case.brake.site.atmosphere)
        return prediction.state(), prediction.notices()
    safe = find_safe_vacuum(case, prediction, confidence)
    interval_source, vacuums = prediction, safe.least_vacuums
    if interval == "mean":
        # the safe vacuum always covers the scatter of the next stops
        interval_source = evolve(prediction, of_mean=True)
        vacuums = find_safe_vacuum(case, interval_source, confidence).least_vacuums
    safety_fields = {
        "safe_vacuum": safe.vacuum,
        "confidence": confidence,
        **interval_source.state(vacuum=vacuums),
    }
    if safe.vacuum is not None:
        return safety_fields, prediction.notices()
    sentence = (
        f"no vacuum keeps {format_share(confidence)} of the stops within "
        f"{show(case.travel, 'm')}: at the site's full vacuum {safe.share:.0%} of them stay within"
    )
    return safety_fields, [*prediction.notices(), Notice(sentence, "no-safe-vacuum")]


def tuning_case(
    brake: BrakeFile,
    mass: float,
    speed: float,
    travel: float,
    rope_stiffness: float | None,
    horizontal: bool,
) -> "Case":
    """Return the stop for which a vacuum is tuned; raises QuantityError for too much travel."""
    from layerjam.brake.simulate.tuned import Case

    device = brake.brake
    usable = device.sheets.usable_travel
    if travel > usable:
        raise QuantityError.of(
            "travel",
            f"{format_distinct(travel, usable, 'm')} is beyond the usable travel of "
            f"{show(usable, 'm')}",
        )
    gravity = 0.0 if horizontal else device.site.gravity
    return Case(
        brake=device, mass=mass, speed=speed, travel=travel, gravity=gravity, rope=rope_stiffness
    )


def _suggest_alternatives(case: "Case", reach: tuple[float, float] | None) -> dict[str, Any]:
    """Return the reason why no vacuum suffices, with alternatives, each checked by tuning it."""
    from layerjam.brake.simulate import tuned

    out: dict[str, Any] = {
        "travel_needed": tuned.suggest_travel(case),
        "sheets_needed": tuned.suggest_sheet_count(case),
        "brakes_needed": tuned.suggest_brake_count(case),
    }
    sentences = {
        "travel_needed": f"{show(out['travel_needed'], 'm', tuned.DIGITS)} of travel",
        "sheets_needed": f"{out['sheets_needed']} sheets",
        "brakes_needed": f"{out['brakes_needed']} brakes in parallel",
    }
    ways = [text for key, text in sentences.items() if out[key] is not None]
    none = (
        f"none of {tuned.TRAVELS} other travels, 2 to {tuned.MOST_SHEETS} sheets and 2 to "
        f"{tuned.MOST_BRAKES} brakes in parallel"
    )
    return {
        **out,
        "reason": f"{_failure_reason(case, reach)}; {' or '.join(ways) or none} would suffice "
        "on average",
    }


def _failure_reason(case: "Case", reach: tuple[float, float] | None) -> str:
    """Return the reason why no vacuum uses exactly the travel, and the speeds that allow it."""
    from layerjam.brake.mechanics.pull import least_stiffness
    from layerjam.brake.simulate.drop import series_spring
    from layerjam.brake.simulate.tuned import balanced_speeds

    weight, travel = show(case.mass * case.gravity, "N"), show(case.travel, "m")
    low, high = balanced_speeds(case)
    if math.isnan(high):
        return f"the brake cannot hold {weight} at a slip of {travel}"
    if high < low:
        # even at full vacuum, the force minus the weight cannot absorb the energy of the fall
        return (
            f"no vacuum stops {show(case.mass, 'kg')} after exactly {travel} at any "
            f"speed: a vacuum that holds its weight of {weight} there stops it sooner"
        )
    least, most_text = ("", "") if reach is None else _format_inner_range(case, *reach)
    range_text = (
        f"there is one from {least} to {most_text}"
        if reach
        else ("no speed with such a vacuum was found")
    )
    if case.speed > high:
        reach_text = f"full vacuum stops up to {most_text}" if reach else range_text
        return f"{format_distinct(case.speed, high, 'm/s')} is too fast for {travel}: {reach_text}"
    if case.speed >= low:
        stiff = float(least_stiffness(case.brake.site.atmosphere, case.brake))
        stiff = _round_digits(stiff, 4, ROUND_CEILING)
        return (
            "rope and brake in series have a stiffness of "
            f"{show(series_spring(case.brake, case.rope), 'N/m')}: on such a soft spring the "
            f"mass stops, or the brake snaps, before {travel} at "
            f"{show(case.speed, 'm/s')}; {range_text}; above {show(stiff, 'N/m')} the "
            "brake cannot snap"
        )
    speed = format_distinct(case.speed, low, "m/s")
    return f"{speed} is too slow for {travel}: {_slow_mass_reason(case)}; {range_text}"


def _slow_mass_reason(case: "Case") -> str:
    """Return the reason why a slow mass stops before the travel is used."""
    from layerjam.brake.mechanics.pull import brake_force

    if float(brake_force(case.travel, 0.0, case.brake)) >= case.mass * case.gravity:
        # even without vacuum the enclosure, whose pull exceeds the weight, stops the mass too early
        return "the enclosure alone, without vacuum, stops the mass before that"
    return "a vacuum low enough for that travel could not hold the weight there"


def _format_inner_range(case: "Case", low: float, high: float) -> tuple[str, str]:
    """Return the ends of a range of speeds [m/s] as text, with values inside the range.

    They are rounded inwards, with as many digits as necessary.
    """
    from layerjam.brake.simulate.tuned import tuning_vacuum

    for digits in range(4, 17):
        ends = [_round_digits(low, digits, ROUND_CEILING), _round_digits(high, digits, ROUND_FLOOR)]
        cases = [case.with_changes(speed=v) for v in ends]
        if ends[0] <= ends[1] and all(tuning_vacuum(c) is not None for c in cases):
            return show(ends[0], "m/s", digits), show(ends[1], "m/s", digits)
    return exact_text(low, "m/s"), exact_text(high, "m/s")


def _round_digits(value: float, digits: int, rounding: str) -> float:
    return float(Context(prec=digits, rounding=rounding).create_decimal_from_float(value))


def format_distinct(value: float, bound: float, unit: str) -> str:
    """Return the value with enough digits to distinguish it from the bound."""
    pairs = [(show(value, unit, d), show(bound, unit, d)) for d in (4, 6, 9, 12, 17)]
    return next((ours for ours, theirs in pairs if ours != theirs), pairs[-1][0])
