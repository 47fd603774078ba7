"""Bench check of the wiring: direction and speed of pump and vent, and tightness of the line.

Pump and vent are driven directly (`DIAG:DRIV`) for at most 5 s, without the control law.
"""

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
"""Durations [s of the board]: vent open, pump on, both closed."""
BEGUN = 0.15
"""Time [s] after a change of the outputs that fits leave out: sensor and tube settle."""
MOVED = 300.0
"""Least change [Pa] that counts as motion; ten times the noise if that is more."""
RELEASED = 0.5
"""Largest share of the vacuum that an open vent leaves."""
SLOW, LEAKY = 0.7, 2.0
"""Share of the line's rate, and multiple of its leak, at which a bench differs from the line."""
TIGHT = 1e-3
"""Leak [1/s] that is always acceptable."""
ZEROED = 4.5
"""Time [s] for which the vent is open before and during the measurement of zero."""
STEADY = 20.0
"""Largest change [Pa] of the mean in half a second; the scatter if that is more."""
FARTHEST = 0.05
"""Largest zero over the sensor's range."""
ATMOSPHERE = 101325.0
"""Range [Pa] assumed if the board has no regulator."""
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
    """A bench that another client commands."""

    key = "locked"


def check_bench(
    bench: Bench, *, vent_rest: str | None = None, plant: Plant | None = None
) -> Checked:
    """Drive pump and vent for some seconds and return the findings; the bench is SAFE afterwards.

    `vent_rest` is the position of the vent valve without power, if the board does not know it.
    `plant` is the expected line. Raises QuantityError if the position is not known, LockedError if
    another client has the lock, InstrumentError if the board is not in SAFE.
    """
    with _lock_bench(bench, vent_rest):
        result = _inspect(bench)
    return _judge(result, plant)


@contextlib.contextmanager
def _lock_bench(bench: Bench, vent_rest: str | None) -> Iterator[None]:
    """Lock the bench, declare the valve's rest if given, and finally switch the outputs off."""
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
    """Open the vent for 4.5 s, take the mean of the last second as zero, and store it.

    The calibration's name gets the date. Raises QuantityError if the valve's rest is not known, or
    if the reading is not steady or exceeds 5 % of the sensor's range. Raises LockedError if another
    client has the lock, InstrumentError if the board is not in SAFE.
    """
    with _lock_bench(bench, vent_rest):
        times, readings = _drive(bench, 0.0, 1, ZEROED)
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
        old_name = name.partition("; zero ")[0]
        bench.calibration = offset, gain, f"{old_name[:22]}; zero {date}"
        bench.tell("SYST:SETT:STOR")
    return Zero(
        zero=reading,
        zero_scatter=scatter,
        sensor_offset=offset,
        date=date,
        simulated=bench.simulated,
    )


def _inspect(bench: Bench) -> Checked:
    self_test = int(bench.ask("*TST?"))
    values: dict[str, Any] = {"self_test": self_test, "feasible": False, "reason": None}
    values["simulated"] = bench.simulated
    values |= {"zero": None, "rate": None, "top": None, "leak": None}
    _, still = _drive(bench, 0.0, 1, VENTED)
    if not np.isfinite(still).all() or not len(still):
        return Checked(**values, wiring=("sensor-silent",))
    level = still[len(still) // 2 :]
    zero, noise = float(np.mean(level)), float(np.std(level))
    values["zero"] = zero
    least = max(MOVED, 10 * noise)
    rise, after = _pump(bench, 0)
    change = float(np.mean(after[1][-5:])) - zero
    if abs(change) < least:
        is_inverted = _rise_with_vent(bench, zero) > least
        return Checked(**values, wiring=("vent-inverted" if is_inverted else "pump-does-nothing",))
    if change < 0.0:
        return Checked(**values, wiring=("pump-reversed",))
    values |= _rates(rise, after, zero)
    if _releases(bench, zero, 1):
        return Checked(**values, wiring=())
    # a strong pump may keep a part of the vacuum while the vent is open
    is_inverted = _releases(bench, zero, 0)
    return Checked(**values, wiring=("vent-inverted" if is_inverted else "vent-does-nothing",))


def _drive(
    bench: Bench, pump: float, vent: int, seconds: float, *, limit: float | None = None
) -> tuple[Array, Array]:
    """Return times [s] and readings [Pa] while the outputs are driven, in the board's time.

    The board drives them for at most `limit` [s].
    """
    bench.tell(f"DIAG:DRIV {pump:g},{vent},{limit or seconds:g}")
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


def _pump(bench: Bench, vent: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the readings while the pump runs, and those with all closed after it."""
    bench.off()
    rise = _drive(bench, 1.0, vent, PUMPED, limit=5.0)
    return rise, _drive(bench, 0.0, 0, HELD)


def _rise_with_vent(bench: Bench, zero: float) -> float:
    """Return the vacuum [Pa] that the pump reaches with the vent commanded to open."""
    (_, readings), _ = _pump(bench, 1)
    return float(np.max(readings)) - zero


def _rates(
    rise: tuple[Array, Array], after: tuple[Array, Array], zero: float
) -> dict[str, float | None]:
    """Return rate and end of the pump from the shape of the rise, and the leak from the loss."""
    from scipy.optimize import curve_fit

    late, level = after[0] > BEGUN, after[1] - zero
    leak = 0.0
    if late.sum() >= 3:
        slope = float(np.polyfit(after[0][late], level[late], 1)[0])
        leak = max(-slope / float(level[late].mean()), 0.0)
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
    """Whether the vent, commanded to open (1) or close (0), releases the pump's vacuum."""
    bench.off()
    _drive(bench, 1.0, 1 - vent, 0.5 * PUMPED, limit=5.0)
    _, readings = _drive(bench, 0.0, vent, HELD)
    return len(readings) > 1 and float(readings[-1]) - zero < RELEASED * (float(readings[0]) - zero)


def _judge(data: Checked, plant: Plant | None) -> Checked:
    """Return the data with the reason why the bench cannot regulate this line, if any."""
    faulty = (name for bit, name in TESTS.items() if data.self_test & bit)
    reasons = [f"{name} fails the self-test" for name in faulty]
    reasons += [FAULTS[key] for key in data.wiring]
    if not reasons and (data.rate is None or data.leak is None):
        reasons = ["the rise of the vacuum does not fit a pump's curve"]
    if not reasons and data.rate is not None and data.leak is not None:
        if data.leak >= data.rate:
            reasons.append(
                f"the line leaks at {data.leak:.3g}/s, the pump fills it at {data.rate:.3g}/s"
            )
        if plant is not None and data.rate < SLOW * plant.joined.rate:
            reasons.append(
                f"the pump's rate is {data.rate:.3g}/s, and the line's {plant.joined.rate:.3g}/s"
            )
        if plant is not None and data.leak > max(LEAKY * plant.joined.leak, TIGHT):
            limit = plant.joined.leak
            reasons.append(f"the leak is {data.leak:.3g}/s, and the line's {limit:.3g}/s")
        if data.zero is not None and data.top is not None and abs(data.zero) > 0.05 * data.top:
            reasons.append(f"the reading with the vent open is {show(data.zero, 'Pa')}")
    return replace(data, feasible=not reasons, reason="; ".join(reasons) or None)
