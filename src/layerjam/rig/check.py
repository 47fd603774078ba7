"""A first look at a bench's wiring: who moves what which way, how fast, and how tight the line is.

Pump and vent are driven by hand (`DIAG:DRIV`), never for longer than 5 s, without the law.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from layerjam.control.plant import Plant
from layerjam.errors import LayerjamError, QuantityError
from layerjam.rig.driver import Bench
from layerjam.rig.outcomes import Checked, Zero
from layerjam.units import show

VENTED, PUMPED, HELD = 1.5, 2.5, 1.5
"""Seconds of the board's time: vent open, pump on, both shut."""
BEGUN = 0.15
"""Seconds after a change of the outputs that no fit looks at: the sensor and the tube follow."""
MOVED = 300.0
"""Change [Pa] below which nothing has moved, and ten times the noise where that is more."""
RELEASED = 0.5
"""Share of the vacuum that an open vent leaves at most."""
SLOW, LEAKY = 0.7, 2.0
"""Share of the line's rate, and times its leak, at which a bench is not that line."""
TIGHT = 1e-3
"""Leak [1/s] that is never held against a line."""
ZEROED = 4.5
"""Seconds for which the vent is open before and while the zero is measured."""
STEADY = 20.0
"""Change [Pa] of the mean in half a second at most, and the scatter if that is more."""
FARTHEST = 0.05
"""Zero over the sensor's range at most."""
ATMOSPHERE = 101325.0
"""Range [Pa] that is assumed while the board has no regulator."""
PAUSE = 0.005
FAULTS = {
    "sensor-silent": "the sensor gives no reading",
    "pump-does-nothing": "with the pump on and the vent shut the reading does not move",
    "pump-reversed": "with the pump on the reading falls: pump or sensor is reversed",
    "vent-inverted": "the vacuum rises with the vent told to be open, and not with the vent told "
    "to be shut: OUTP:VENT:REST says the wrong thing, or the valve's ports are swapped",
    "vent-does-nothing": "with the vent open the vacuum stays",
}
TESTS = {
    1: "the sensor",
    2: "the settings",
    4: "the law's own check",
    8: "the supply",
    16: "the emergency stop",
    32: "the flash",
}
Array = np.ndarray[Any, np.dtype[np.float64]]


class LockedError(LayerjamError):
    """Another client commands the bench."""

    key = "locked"


def check_bench(
    bench: Bench, *, vent_rest: str | None = None, plant: Plant | None = None
) -> Checked:
    """Drive pump and vent for some seconds, and say what follows; the bench is SAFE afterwards.

    `vent_rest` is what the vent valve is without power, where the board does not know it; `plant`
    is what the line should be. Raises QuantityError where the rest is not known, LockedError where
    another client has the lock, InstrumentError where the board is not in SAFE.
    """
    with _locked(bench, vent_rest):
        made = _looked_at(bench)
    return _judged(made, plant)


@contextlib.contextmanager
def _locked(bench: Bench, vent_rest: str | None) -> Iterator[None]:
    """Lock the bench, declare the valve's rest if given, and switch the outputs off at last."""
    if vent_rest is None and bench.vent_rest is None:
        raise QuantityError.of(
            "vent rest",
            "the board does not know it; say what the valve is without power, open or closed",
        )
    if not bench.lock():
        raise LockedError(f"{bench.address} is locked by another client")
    try:
        if vent_rest is not None and bench.vent_rest != vent_rest:
            bench.vent_rest = vent_rest
        yield
    finally:
        bench.off()
        bench.unlock()


def measure_zero(bench: Bench, *, vent_rest: str | None = None) -> Zero:
    """Open the vent for 4.5 s, take the mean of the last second for zero, and store it.

    The calibration's name gets the date. Raises QuantityError if the valve's rest is not known, if
    the reading is not steady or more than 5 % of the sensor's range, LockedError if another client
    has the lock, InstrumentError if the board is not in SAFE.
    """
    with _locked(bench, vent_rest):
        times, readings = _driven(bench, 0.0, 1, ZEROED)
        level = readings[times > ZEROED - 1.0]
        if len(level) < 10 or not np.isfinite(level).all():
            raise QuantityError.of("zero", FAULTS["sensor-silent"])
        reading, scatter = float(np.mean(level)), float(np.std(level))
        drift = float(np.mean(level[len(level) // 2 :]) - np.mean(level[: len(level) // 2]))
        if abs(drift) > max(STEADY, scatter):
            raise QuantityError.of(
                "zero",
                f"the reading changes by {show(drift, 'Pa', 3)} in half a second with the vent "
                "open; wait until the brake is vented",
            )
        offset, gain, name = bench.calibration
        limit = FARTHEST * (bench.sensor_range or ATMOSPHERE)
        if abs(reading) > limit:
            raise QuantityError.of(
                "zero",
                f"{show(reading, 'Pa', 4)} is not allowed; at most {show(limit, 'Pa', 4)} either "
                "way, 5 % of the sensor's range. Check the sensor, its port and its range",
            )
        bench.off()
        date = datetime.now(UTC).date().isoformat()
        offset += reading / gain
        kept = name.partition("; zero ")[0]
        bench.calibration = offset, gain, f"{kept[:22]}; zero {date}"
        bench.tell("SYST:SETT:STOR")
    return Zero(
        zero=reading,
        zero_scatter=scatter,
        sensor_offset=offset,
        date=date,
        simulated=bench.simulated,
    )


def _looked_at(bench: Bench) -> Checked:
    tested = int(bench.ask("*TST?"))
    found: dict[str, Any] = {"self_test": tested, "feasible": False, "reason": None}
    found["simulated"] = bench.simulated
    found |= {"zero": None, "rate": None, "top": None, "leak": None}
    _, still = _driven(bench, 0.0, 1, VENTED)
    if not np.isfinite(still).all() or not len(still):
        return Checked(**found, wiring=("sensor-silent",))
    level = still[len(still) // 2 :]
    zero, noise = float(np.mean(level)), float(np.std(level))
    found["zero"] = zero
    least = max(MOVED, 10 * noise)
    rise, after = _pumped(bench, 0)
    moved = float(np.mean(after[1][-5:])) - zero
    if abs(moved) < least:
        inverted = _risen(bench, zero) > least
        return Checked(**found, wiring=("vent-inverted" if inverted else "pump-does-nothing",))
    if moved < 0.0:
        return Checked(**found, wiring=("pump-reversed",))
    found |= _rates(rise, after, zero)
    if _releases(bench, zero, 1):
        return Checked(**found, wiring=())
    # an open vent may have left a part of the vacuum to a strong pump
    inverted = _releases(bench, zero, 0)
    return Checked(**found, wiring=("vent-inverted" if inverted else "vent-does-nothing",))


def _driven(
    bench: Bench, pump: float, vent: int, seconds: float, *, most: float | None = None
) -> tuple[Array, Array]:
    """Time [s] and reading [Pa] while the outputs are driven so, for so long of the board's time.

    They are driven for `most` [s], if nothing else comes.
    """
    bench.tell(f"DIAG:DRIV {pump:g},{vent},{most or seconds:g}")
    begin = -1
    times: list[float] = []
    readings: list[float] = []
    while True:
        parts = bench.ask("FETC:ALL?").split(",")
        number = int(parts[0])
        begin = number if begin < 0 else begin
        if parts[5] != "DRIVE" or number - begin >= 100 * seconds:
            break
        if not times or number / 100 > times[-1]:
            times.append(number / 100)
            value = float(parts[1])
            readings.append(value if abs(value) < 9.9e37 else np.nan)
        time.sleep(PAUSE)
    return np.array(times) - begin / 100, np.array(readings)


def _pumped(bench: Bench, vent: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """The readings while the pump runs, and those with all shut after it."""
    bench.off()
    rise = _driven(bench, 1.0, vent, PUMPED, most=5.0)
    return rise, _driven(bench, 0.0, 0, HELD)


def _risen(bench: Bench, zero: float) -> float:
    """Vacuum [Pa] that the pump brings with the vent told to be open."""
    (_, shown), _ = _pumped(bench, 1)
    return float(np.max(shown)) - zero


def _rates(
    rise: tuple[Array, Array], after: tuple[Array, Array], zero: float
) -> dict[str, float | None]:
    """Rate and end of the pump from the rise's slope and bend, the leak from what is lost after."""
    from scipy.optimize import curve_fit

    at, held = after[0] > BEGUN, after[1] - zero
    leak = 0.0
    if at.sum() >= 3:
        leak = max(-float(np.polyfit(after[0][at], held[at], 1)[0]) / float(held[at].mean()), 0.0)
    late = rise[0] > BEGUN
    times, values = rise[0][late], rise[1][late] - zero
    out: dict[str, float | None] = {"leak": leak, "rate": None, "top": None}
    if len(times) < 5:
        return out

    def curve(t: Array, begin: float, end: float, rate: float) -> Array:
        return end - (end - begin) * np.exp(-rate * t)

    guess = (float(values[0]), 1.3 * float(values.max()), 1.0 / PUMPED)
    try:
        (_, end, bend), _ = curve_fit(curve, times, values, guess, maxfev=2000)
    except RuntimeError:
        return out
    if not (bend > leak and end > 0.0):
        return out
    return {"leak": leak, "rate": float(bend - leak), "top": float(end * bend / (bend - leak))}


def _releases(bench: Bench, zero: float, vent: int) -> bool:
    """Whether the vent, told to be open (1) or shut (0), lets the pump's vacuum go."""
    bench.off()
    _driven(bench, 1.0, 1 - vent, 0.5 * PUMPED, most=5.0)
    _, shown = _driven(bench, 0.0, vent, HELD)
    return len(shown) > 1 and float(shown[-1]) - zero < RELEASED * (float(shown[0]) - zero)


def _judged(made: Checked, plant: Plant | None) -> Checked:
    """With the judgement: what keeps the bench from regulating this line."""
    why = [f"{name} fails the self-test" for bit, name in TESTS.items() if made.self_test & bit]
    why += [FAULTS[key] for key in made.wiring]
    if not why and (made.rate is None or made.leak is None):
        why = ["the rise of the vacuum is no curve of a pump"]
    if not why and made.rate is not None and made.leak is not None:
        if made.leak >= made.rate:
            why.append(
                f"the line leaks at {made.leak:.3g}/s, the pump fills it at {made.rate:.3g}/s"
            )
        if plant is not None and made.rate < SLOW * plant.joined.rate:
            why.append(
                f"the pump's rate is {made.rate:.3g}/s, and the line's {plant.joined.rate:.3g}/s"
            )
        if plant is not None and made.leak > max(LEAKY * plant.joined.leak, TIGHT):
            why.append(f"the leak is {made.leak:.3g}/s, and the line's {plant.joined.leak:.3g}/s")
        if made.zero is not None and made.top is not None and abs(made.zero) > 0.05 * made.top:
            why.append(f"the reading with the vent open is {show(made.zero, 'Pa')}")
    return replace(made, feasible=not why, reason="; ".join(why) or None)
