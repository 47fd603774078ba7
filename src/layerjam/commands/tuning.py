"""`tune`: the vacuum that stops a mass within a travel, or why there is none and what would do."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import QuantityError
from layerjam.mechanics.energy import slip_work
from layerjam.mechanics.pull import brake_force, least_stiffness, peak, vacuum_for_force
from layerjam.mechanics.stop.exact import STOPPED, stop
from layerjam.mechanics.stop.tune import tuned_vacuum, vacuum_eq10
from layerjam.simulate.drop import spring_of
from layerjam.units import QuantitySpec, show

MASS = QuantitySpec("kg", "mass", lo=1e-6, hi=1e6)
SPEED = QuantitySpec("m/s", "speed on arrival", lo=1e-6, hi=1e4)
HEIGHT = QuantitySpec("m", "height of the fall", open_lo=True, hi=1e5)
ROPE = QuantitySpec("N/m", "stiffness of the rope", lo=1, hi=1e9)
TRAVEL = QuantitySpec("m", "slip of the brake", lo=1e-6, hi=10)
MOST_SHEETS, MOST_BRAKES = 500, 1000


def rope_of(stiffness: Quantity | None) -> float | None:
    """Stiffness of the rope [N/m], None without one."""
    if stiffness is None:
        return None
    return si(stiffness, ROPE, "rope stiffness")


def arrival(
    speed: Quantity | None, height: Quantity | None, horizontal: bool, gravity: float
) -> float:
    """Speed [m/s] at the taut rope, from one of the two; QuantityError for both or neither."""
    if (speed is None) == (height is None):
        both = "both" if speed is not None else "neither"
        raise QuantityError(f"speed and height: {both} given; give one of them")
    if speed is not None:
        return si(speed, SPEED, "speed")
    if horizontal:
        raise QuantityError("height: a horizontal stop falls from none; give the speed")
    if not gravity:
        raise QuantityError("height: nothing falls where gravity is 0 m/s^2; give the speed")
    return math.sqrt(2 * gravity * si(height, HEIGHT, "height"))  # type: ignore[arg-type]


def tune(
    brake: AnyBrake,
    *,
    mass: Quantity,
    speed: Quantity | None = None,
    height: Quantity | None = None,
    travel: Quantity,
    rope_stiffness: Quantity | None = None,
    horizontal: bool = False,
    atmosphere: Quantity | None = None,
) -> Answer:
    """Vacuum that stops a mass within a travel (slip of the brake), exactly and by eq. 10.

    The mass arrives with `speed` or falls from `height`. Where there is no such vacuum, `reason`
    says why and what would do: the speeds that can be stopped so, a longer travel, more sheets,
    more brakes side by side.
    """
    file = brake_at(brake, atmosphere)
    device = file.brake
    weighs = si(mass, MASS, "mass")
    arrives = arrival(speed, height, horizontal, device.site.gravity)
    way, rope = si(travel, TRAVEL, "travel"), rope_of(rope_stiffness)
    if way > device.sheets.usable_travel:
        raise QuantityError(
            f"travel: {apart(way, device.sheets.usable_travel, 'm')} is beyond the usable travel "
            f"of {show(device.sheets.usable_travel, 'm')}"
        )
    along = 0.0 if horizontal else device.site.gravity
    pressure = _tuned(device, weighs, arrives, way, rope, along)
    eq10 = float(vacuum_eq10(weighs, arrives, way, device))
    spring = spring_of(device, rope)
    full = device.site.atmosphere
    top = float(peak(pressure or full, device.sheets.usable_travel, device).force)
    stretch = way + top / spring
    g = device.site.gravity
    floor = arrives**2 / (2 * g * stretch) + (0.0 if horizontal else 1.0) if g else None
    values: dict[str, object] = {
        "vacuum": pressure,
        "vacuum_eq10": eq10 if math.isfinite(eq10) else None,
        "feasible": pressure is not None,
        "reason": None,
        "floor_g": floor,
        "least_speed": None,
        "greatest_speed": None,
        "travel_needed": None,
        "sheets_needed": None,
        "brakes_needed": None,
    }
    low, high = speed_range(device, weighs, way, rope, along)
    values |= {"least_speed": low, "greatest_speed": high}
    if pressure is None:
        values |= _ways_out(file, weighs, arrives, way, rope, along, low, high)
    units = {
        "vacuum": "Pa", "vacuum_eq10": "Pa", "floor_g": "1", "least_speed": "m/s",
        "greatest_speed": "m/s", "travel_needed": "m", "sheets_needed": "1", "brakes_needed": "1",
    }  # fmt: skip
    return Answer(values=values, units=units, warnings=file.warnings())


def _tuned(
    brake: Brake, mass: float, speed: float, way: float, rope: float | None, gravity: float
) -> float | None:
    spring = spring_of(brake, rope)
    vacuum = float(tuned_vacuum(mass, speed, way, spring, gravity, brake))
    if not math.isfinite(vacuum):
        return None
    # the balance holds at the end of the way; on a soft rope the mass may stop or snap before it
    result = stop(mass, speed, vacuum, spring, gravity, brake)
    there = int(result.outcome) == STOPPED and abs(float(result.slip) - way) <= 1e-6 * way
    return vacuum if there else None


def speed_range(
    brake: Brake, mass: float, way: float, rope: float | None, gravity: float
) -> tuple[float | None, float | None]:
    """Speeds [m/s] that some vacuum of the site stops after exactly `way` [m] of slip.

    The slowest is stopped by the vacuum that just holds the weight there. (None, None) where not
    even full vacuum holds it.
    """
    full, spring = brake.site.atmosphere, spring_of(brake, rope)
    weight = mass * gravity
    if float(brake_force(way, full, brake)) < weight:
        return None, None
    alone = float(brake_force(way, 0.0, brake))
    held = float(vacuum_for_force(max(weight, alone), way, brake))

    def speed(vacuum: float) -> float:
        force = float(brake_force(way, vacuum, brake))
        taken = float(slip_work(way, vacuum, brake)) + force**2 / (2 * spring)
        return math.sqrt(max(taken - weight * (way + force / spring), 0.0) * 2 / mass)

    return speed(held), speed(full)


def _ways_out(
    file: BrakeFile, mass: float, speed: float, way: float, rope: float | None, gravity: float,
    low: float | None, high: float | None,
) -> dict[str, object]:  # fmt: skip
    """Why no vacuum does it, and what would."""
    brake = file.brake
    if low is not None and speed < low:
        alone = float(brake_force(way, 0.0, brake))
        why = (
            f"a vacuum low enough to let the mass run that far could not hold its weight there; "
            f"from {show(low, 'm/s')} on there is one"
        )
        if alone >= mass * gravity:
            # the sleeve pulls harder than the weight: no vacuum at all stops it sooner already
            why = (
                f"the sleeve alone, without vacuum, stops the mass before that; from "
                f"{show(low, 'm/s')} on it runs that far"
            )
        reason = f"{apart(speed, low, 'm/s')} is too slow for {show(way, 'm')}: {why}"
        return {"reason": f"{reason}, or choose a shorter travel"}
    if high is not None and low is not None and low <= speed <= high:
        least = float(least_stiffness(brake.site.atmosphere, brake))
        reason = (
            f"rope and brake together give {show(spring_of(brake, rope), 'N/m')}: on a spring so "
            f"soft the mass stops or the brake snaps before {show(way, 'm')}; above "
            f"{show(least, 'N/m')} it cannot snap"
        )
        # the two speeds count on a mass that gets there
        return {"reason": reason, "least_speed": None, "greatest_speed": None}
    if high is not None and low is not None and high < low:
        # what full vacuum leaves over the weight cannot even take the drop into the rope
        return {"reason": _no_speed(mass, way, gravity), "least_speed": None,
                "greatest_speed": None}  # fmt: skip
    out: dict[str, object] = {}
    for far in np.linspace(way, brake.sheets.usable_travel, 200)[1:]:
        if _tuned(brake, mass, speed, float(far), rope, gravity) is not None:
            out["travel_needed"] = float(far)
            break
    for count in range(brake.sheets.count + 1, MOST_SHEETS):
        more = replace(brake, sheets=replace(brake.sheets, count=count))
        _, fastest = speed_range(more, mass, way, rope, gravity)
        if fastest is not None and fastest >= speed:
            out["sheets_needed"] = count
            break
    for count in range(2, MOST_BRAKES):
        shared = None if rope is None else rope / count
        _, fastest = speed_range(brake, mass / count, way, shared, gravity)
        if fastest is not None and fastest >= speed:
            out["brakes_needed"] = count
            break
    head = (
        f"the brake cannot hold {show(mass * gravity, 'N')} at {show(way, 'm')} of slip"
        if high is None
        else f"{apart(speed, high, 'm/s')} is too fast for {show(way, 'm')}: full vacuum stops up "
        f"to {show(high, 'm/s')}"
    )
    ways = []
    if "travel_needed" in out:
        ways.append(f"{show(float(out['travel_needed']), 'm')} of travel")  # type: ignore[arg-type]
    if "sheets_needed" in out:
        ways.append(f"{out['sheets_needed']} sheets")
    if "brakes_needed" in out:
        ways.append(f"{out['brakes_needed']} brakes side by side")
    none = (
        f"neither more travel nor up to {MOST_SHEETS - 1} sheets or {MOST_BRAKES - 1} brakes side "
        "by side"
    )
    return {**out, "reason": f"{head}; {' or '.join(ways) or none} would do"}


def _no_speed(mass: float, way: float, gravity: float) -> str:
    return (
        f"no vacuum stops {show(mass, 'kg')} after just {show(way, 'm')} at any speed: what holds "
        f"its weight of {show(mass * gravity, 'N')} there stops it sooner; choose a shorter travel"
    )


def apart(value: float, bound: float, unit: str) -> str:
    """The value with as many digits as it takes to tell it from the bound."""
    shown = [(show(value, unit, d), show(bound, unit, d)) for d in (4, 6, 9, 12, 17)]
    return next((ours for ours, theirs in shown if ours != theirs), shown[-1][0])
