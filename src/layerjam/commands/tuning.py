"""`tune`: the vacuum that stops a mass within a travel, or why there is none and what would do."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from layerjam.commands.declare import command
from layerjam.commands.quantities import (
    ArrivalSpeed,
    Atmosphere,
    BrakeInput,
    Height,
    Horizontal,
    Mass,
    RopeStiffness,
    StopTravel,
)
from layerjam.commands.results import Result, fact, number, result
from layerjam.errors import QuantityError
from layerjam.units import show

if TYPE_CHECKING:
    from layerjam.device.brake import Brake

MOST_SHEETS, MOST_BRAKES = 500, 1000


@result
class TunedVacuum(Result):
    """The vacuum that stops the mass within the travel; or the reason, and what would be enough."""

    vacuum: float | None = number("Pa", "vacuum that stops the mass after exactly the travel")
    vacuum_eq10: float | None = number("Pa", "the paper's: eq. 10, no gravity, no elastic part")
    feasible: bool = fact("whether there is such a vacuum", shown=lambda yes: "" if yes else "no")
    reason: str | None = fact("why there is none, and what would do", default=None)
    floor_g: float | None = number("1", "least peak in g of any stop within the travel")
    least_speed: float | None = number("m/s", "slowest arrival that can be stopped so")
    greatest_speed: float | None = number("m/s", "fastest arrival that can be stopped so")
    travel_needed: float | None = number("m", "travel that would be enough", default=None)
    sheets_needed: int | None = number("1", "sheets that would be enough", default=None)
    brakes_needed: int | None = number("1", "brakes side by side that would do", default=None)


def arrival(speed: float | None, height: float | None, horizontal: bool, gravity: float) -> float:
    """Speed [m/s] at the taut rope, from one of the two; QuantityError for both or neither."""
    if (speed is None) == (height is None):
        both = "both" if speed is not None else "neither"
        raise QuantityError(f"speed and height: {both} given; give one of them")
    if height is None:
        return float(speed or 0.0)
    if horizontal:
        raise QuantityError("height: nothing falls in a horizontal stop; give the speed")
    if not gravity:
        raise QuantityError("height: nothing falls where gravity is 0 m/s^2; give the speed")
    return math.sqrt(2 * gravity * height)


@command(
    "predict",
    place=60,
    examples=("layerjam tune choi2018-kapton --mass 1kg --speed 2.5m/s --travel 40mm",),
)
def tune(
    brake: BrakeInput,
    *,
    mass: Mass,
    travel: StopTravel,
    speed: ArrivalSpeed | None = None,
    height: Height | None = None,
    rope_stiffness: RopeStiffness | None = None,
    horizontal: Horizontal = False,
    atmosphere: Atmosphere = None,
) -> TunedVacuum:
    """Vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. Where there is no such vacuum, `reason`
    says why and what would do: the speeds that can be stopped so, a longer travel, more sheets,
    more brakes side by side.
    """
    from layerjam.mechanics.pull import peak
    from layerjam.mechanics.stop.tune import vacuum_eq10
    from layerjam.simulate.drop import spring_of

    device, g = brake.brake, brake.brake.site.gravity
    arrives = arrival(speed, height, horizontal, g)
    usable = device.sheets.usable_travel
    if travel > usable:
        raise QuantityError(
            f"travel: {apart(travel, usable, 'm')} is beyond the usable travel of "
            f"{show(usable, 'm')}"
        )
    along = 0.0 if horizontal else g
    pressure = _tuned(device, mass, arrives, travel, rope_stiffness, along)
    eq10 = float(vacuum_eq10(mass, arrives, travel, device))
    top = float(peak(pressure or device.site.atmosphere, usable, device).force)
    distance = travel + top / spring_of(device, rope_stiffness)
    low, high = speed_range(device, mass, travel, rope_stiffness, along)
    more: dict[str, Any] = {"least_speed": low, "greatest_speed": high}
    if pressure is None:
        more |= _ways_out(device, mass, arrives, travel, rope_stiffness, along, low, high)
    return TunedVacuum(
        vacuum=pressure,
        vacuum_eq10=eq10 if math.isfinite(eq10) else None,
        feasible=pressure is not None,
        floor_g=arrives**2 / (2 * g * distance) + (0.0 if horizontal else 1.0) if g else None,
        warnings=brake.warnings(),
        **more,
    )


def _tuned(
    brake: Brake, mass: float, speed: float, travel: float, rope: float | None, gravity: float
) -> float | None:
    from layerjam.mechanics.stop.exact import STOPPED, stop
    from layerjam.mechanics.stop.tune import tuned_vacuum
    from layerjam.simulate.drop import spring_of

    spring = spring_of(brake, rope)
    vacuum = float(tuned_vacuum(mass, speed, travel, spring, gravity, brake))
    if not math.isfinite(vacuum):
        return None
    # the balance holds at the end of the travel; on a soft rope the mass may stop or snap before it
    result = stop(mass, speed, vacuum, spring, gravity, brake)
    there = int(result.outcome) == STOPPED and abs(float(result.slip) - travel) <= 1e-6 * travel
    return vacuum if there else None


def speed_range(
    brake: Brake, mass: float, travel: float, rope: float | None, gravity: float
) -> tuple[float | None, float | None]:
    """Speeds [m/s] that some vacuum of the site stops after exactly `travel` [m] of slip.

    The slowest is stopped by the vacuum that just holds the weight there. (None, None) where not
    even full vacuum holds it.
    """
    from layerjam.mechanics.energy import slip_work
    from layerjam.mechanics.pull import brake_force, vacuum_for_force
    from layerjam.simulate.drop import spring_of

    full, spring = brake.site.atmosphere, spring_of(brake, rope)
    weight = mass * gravity
    if float(brake_force(travel, full, brake)) < weight:
        return None, None
    alone = float(brake_force(travel, 0.0, brake))
    held = float(vacuum_for_force(max(weight, alone), travel, brake))

    def speed(vacuum: float) -> float:
        force = float(brake_force(travel, vacuum, brake))
        taken = float(slip_work(travel, vacuum, brake)) + force**2 / (2 * spring)
        return math.sqrt(max(taken - weight * (travel + force / spring), 0.0) * 2 / mass)

    return speed(held), speed(full)


def _ways_out(
    brake: Brake, mass: float, speed: float, travel: float, rope: float | None, gravity: float,
    low: float | None, high: float | None,
) -> dict[str, object]:  # fmt: skip
    """Why no vacuum does it, and what would."""
    from layerjam.mechanics.pull import brake_force, least_stiffness
    from layerjam.simulate.drop import spring_of

    if low is not None and speed < low:
        alone = float(brake_force(travel, 0.0, brake))
        why = (
            f"a vacuum low enough to let the mass run that far could not hold its weight there; "
            f"from {show(low, 'm/s')} on there is one"
        )
        if alone >= mass * gravity:
            # the enclosure pulls harder than the weight: no vacuum at all stops it sooner already
            why = (
                f"the enclosure alone, without vacuum, stops the mass before that; from "
                f"{show(low, 'm/s')} on it runs that far"
            )
        reason = f"{apart(speed, low, 'm/s')} is too slow for {show(travel, 'm')}: {why}"
        return {"reason": f"{reason}, or choose a shorter travel"}
    if high is not None and low is not None and low <= speed <= high:
        least = float(least_stiffness(brake.site.atmosphere, brake))
        reason = (
            f"rope and brake together give {show(spring_of(brake, rope), 'N/m')}: on a spring so "
            f"soft the mass stops or the brake snaps before {show(travel, 'm')}; above "
            f"{show(least, 'N/m')} it cannot snap"
        )
        # the two speeds count on a mass that gets there
        return {"reason": reason, "least_speed": None, "greatest_speed": None}
    if high is not None and low is not None and high < low:
        # what full vacuum leaves over the weight cannot even take the drop into the rope
        return {"reason": _no_speed(mass, travel, gravity), "least_speed": None,
                "greatest_speed": None}  # fmt: skip
    head = (
        f"the brake cannot hold {show(mass * gravity, 'N')} at {show(travel, 'm')} of slip"
        if high is None
        else f"{apart(speed, high, 'm/s')} is too fast for {show(travel, 'm')}: full vacuum stops "
        f"up to {show(high, 'm/s')}"
    )
    out = _enough(brake, mass, speed, travel, rope, gravity)
    said = {
        "travel_needed": f"{show(out['travel_needed'], 'm')} of travel",
        "sheets_needed": f"{out['sheets_needed']} sheets",
        "brakes_needed": f"{out['brakes_needed']} brakes side by side",
    }
    ways = [text for key, text in said.items() if out[key] is not None]
    none = (
        f"neither more travel nor up to {MOST_SHEETS - 1} sheets or {MOST_BRAKES - 1} brakes side "
        "by side"
    )
    return {**out, "reason": f"{head}; {' or '.join(ways) or none} would do"}


def _enough(
    brake: Brake, mass: float, speed: float, travel: float, rope: float | None, gravity: float
) -> dict[str, float | None]:
    """The least travel, number of sheets and number of brakes that stop the mass; None for none."""
    import numpy as np

    def stops(other: Brake, share: int) -> bool:
        part = None if rope is None else rope / share
        _, fastest = speed_range(other, mass / share, travel, part, gravity)
        return fastest is not None and fastest >= speed

    def thicker(count: int) -> Brake:
        return replace(brake, sheets=replace(brake.sheets, count=count))

    travels = np.linspace(travel, brake.sheets.usable_travel, 200)[1:].tolist()
    fine = (x for x in travels if _tuned(brake, mass, speed, x, rope, gravity) is not None)
    sheets = (n for n in range(brake.sheets.count + 1, MOST_SHEETS) if stops(thicker(n), 1))
    brakes = (n for n in range(2, MOST_BRAKES) if stops(brake, n))
    return {
        "travel_needed": next(fine, None),
        "sheets_needed": next(sheets, None),
        "brakes_needed": next(brakes, None),
    }


def _no_speed(mass: float, travel: float, gravity: float) -> str:
    return (
        f"no vacuum stops {show(mass, 'kg')} after just {show(travel, 'm')} at any speed: what "
        f"holds its weight of {show(mass * gravity, 'N')} there stops it sooner; choose a "
        "shorter travel"
    )


def apart(value: float, bound: float, unit: str) -> str:
    """The value with as many digits as it takes to tell it from the bound."""
    shown = [(show(value, unit, d), show(bound, unit, d)) for d in (4, 6, 9, 12, 17)]
    return next((ours for ours, theirs in shown if ours != theirs), shown[-1][0])
