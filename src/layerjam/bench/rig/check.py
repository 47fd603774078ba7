"""Bench check of the wiring: direction and speed of pump and vent, leak, and sensor lag.

Pump and vent are driven directly (`DIAG:DRIV`) for at most 5 s, without the control law. The fits
follow `control/plant.py`: with the pump on, v = reach (1 - d), and with the vent open v is
proportional to d. Here d decays at the rate of the pump or the vent, behind a first-order lag.
"""

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from layerjam.bench.control.plant import Plant
from layerjam.bench.control.tolerances import Tolerances
from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.driver import Bench, InstrumentError
from layerjam.bench.rig.execute import QUICK
from layerjam.bench.rig.outcomes import Checked, Zero
from layerjam.bench.rig.telemetry import PERIOD, RECORD, unwrap_clock
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.units import parse, show

VENTED, PUMPED, HELD = 1.5, 2.5, 1.5
"""Durations [s of the board's clock]: vent open, pump on, pump off with the vent closed."""
EVEN = 0.3
"""Time [s] with the pump off and the vent closed after which the sensor shows the true vacuum."""
BEGUN = 0.15
"""Time [s] after an output change during which samples are excluded from the leak fit."""
ONSET = 0.6
"""Time [s] after the pump starts within which the lag is visible."""
SURE = 5e-3
"""Largest acceptable standard error [s] of a lag."""
MOVED = 300.0
"""Smallest change of the reading [Pa] that counts as a response; ten times the noise if larger."""
RELEASED = 0.5
"""Largest fraction of the vacuum that may remain after the vent has been open."""
LEFT = 0.1
"""Fraction of the initial vacuum below which samples are excluded from the vent fit."""
ALLOWED = Tolerances()
LEAKY = 2.0
"""Multiple of the line's leak above which a bench is reported to differ from the line."""
TIGHT = 1e-3
"""Leak [1/s] that is always acceptable."""
ZEROED = 4.5
"""Time [s] for which the vent is open before and while the zero is measured."""
STEADY = 20.0
"""Largest drift [Pa] between half-second means of a steady reading; the scatter if larger."""
FARTHEST = 0.05
"""Largest acceptable zero, relative to the sensor's range."""
ATMOSPHERE = 101325.0
"""Sensor range [Pa] assumed if the board has no controller."""
PAUSE = 0.005
FASTEST = 20.0
"""Highest speed of a virtual board that the check can follow."""
LONGEST = 1000
"""Number of samples after which the check stops waiting for the outputs to be driven."""
DRIVE = 3
"""Number of the state DRIVE in a sample: the outputs are driven directly."""
FAULTS = {
    "sensor-silent": "the sensor gives no reading",
    "pump-does-nothing": "with the pump on and the vent shut, the reading does not change",
    "pump-reversed": "with the pump on, the reading falls: the pump or the sensor is reversed",
    "vent-inverted": "the vacuum rises when the vent is commanded to open, but not when it is "
    "commanded to close: OUTP:VENT:REST is wrong, or the valve's ports are swapped",
    "vent-does-nothing": "with the vent open, the vacuum does not fall",
}
TESTS = {
    1: "the sensor",
    2: "the settings",
    4: "the control law",
    8: "the supply",
    16: "the emergency stop",
    32: "the flash",
}
Array = np.ndarray[Any, np.dtype[np.float64]]


class LockedError(LayerjamError):
    """Raised if another client has locked the bench."""

    key = "locked"


def limit_speed(text: str | Address) -> Address:
    """Return the address, with a virtual board's speed limited to what the check can follow."""
    address = address_of(text)
    if not address.simulated or 0 < parse(address.options.get("speed", "1"), "1", "") <= FASTEST:
        return address
    return replace(address, options={**address.options, "speed": f"{FASTEST:g}"})


def check_bench(
    bench: Bench,
    *,
    vent_rest: str | None = None,
    plant: Plant | None = None,
    lag: float = 0.0,
    tune: bool = False,
) -> Checked:
    """Drive pump and vent for a few seconds and return the findings; afterwards the bench is SAFE.

    `vent_rest` is the position of the unpowered vent valve, if the board has no setting for it.
    `plant` is the expected line, and `lag` [s] the expected lag of its sensor. With `tune`,
    differences from these are ignored, because the measured values will replace them. Raises
    QuantityError if the valve's position is not known or the outputs cannot be driven, LockedError
    if another client has the lock, InstrumentError if the board is not in SAFE.
    """
    with _lock_bench(bench, vent_rest):
        result = _inspect_bench(bench)
    return _judge_bench(result, plant, lag, tune)


@contextlib.contextmanager
def _lock_bench(bench: Bench, vent_rest: str | None) -> Iterator[None]:
    """Lock the bench, set the valve's rest position if given, and leave the outputs off."""
    if limit_speed(bench.address) != bench.address:
        raise QuantityError.of(
            "address",
            f"{bench.address} is too fast; the check can follow a virtual bench only at speeds "
            f"of 1 to {FASTEST:g}",
        )
    if vent_rest is None and bench.vent_rest is None:
        raise QuantityError.of(
            "vent rest",
            "not stored on the board; give --vent-rest, the position of the valve without "
            "power: open or closed",
        )
    if not bench.lock():
        raise LockedError(f"{bench.address} is locked by another client")
    lease = bench.lease
    try:
        if bench.plant is not None:
            bench.lease = QUICK
        if vent_rest is not None and bench.vent_rest != vent_rest:
            bench.vent_rest = vent_rest
        yield
    finally:
        bench.off()
        bench.lease = lease
        bench.unlock()


def measure_zero(bench: Bench, *, vent_rest: str | None = None) -> Zero:
    """Open the vent for 4.5 s, use the mean of the last second as the zero, and store it.

    The date is added to the calibration's name. Raises QuantityError if the valve's rest position
    is not known, or if the reading is not steady or exceeds 5 % of the sensor's range. Raises
    LockedError if another client has the lock, InstrumentError if the board is not in SAFE.
    """
    with _lock_bench(bench, vent_rest):
        times, readings = _drive_outputs(bench, 0.0, 1, ZEROED)
        level = readings[times > ZEROED - 1.0]
        if not np.isfinite(level).all():
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
                f"{show(reading, 'Pa', 4)} is not allowed; it must be within "
                f"±{show(limit, 'Pa', 4)}, 5 % of the sensor's range. Check sensor, port and range",
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


def _inspect_bench(bench: Bench) -> Checked:
    self_test = int(bench.ask("*TST?"))
    values: dict[str, Any] = {"self_test": self_test, "feasible": False, "reason": None}
    values["simulated"] = bench.simulated
    values |= dict.fromkeys(("zero", "noise", "rate", "top", "leak", "vent", "lag", "expected"))
    _, vent_readings = _drive_outputs(bench, 0.0, 1, VENTED)
    if not np.isfinite(vent_readings).all():
        return Checked(**values, wiring=("sensor-silent",))
    level = vent_readings[len(vent_readings) // 2 :]
    zero, noise = float(np.mean(level)), float(np.std(level))
    values |= {"zero": zero, "noise": noise}
    threshold = max(MOVED, 10 * noise)
    rise, decay = _measure_pump(bench, 0)
    change = float(np.mean(decay[1][-5:])) - zero
    if abs(change) < threshold:
        (_, readings), _ = _measure_pump(bench, 1)  # with the vent commanded to open
        is_inverted = float(np.max(readings)) - zero > threshold
        return Checked(**values, wiring=("vent-inverted" if is_inverted else "pump-does-nothing",))
    if change < 0.0:
        return Checked(**values, wiring=("pump-reversed",))
    values |= _fit_pump((rise[0], rise[1] - zero), (decay[0], decay[1] - zero))
    height, times, fall = _measure_release(bench, zero, 1)
    if fall[-1] < RELEASED * height:
        values["vent"] = _fit_vent(times, fall, height, values["leak"], values["lag"])
        return Checked(**values, wiring=())
    # a strong pump may maintain part of the vacuum while the vent is open
    height, _, fall = _measure_release(bench, zero, 0)
    is_inverted = fall[-1] < RELEASED * height
    return Checked(**values, wiring=("vent-inverted" if is_inverted else "vent-does-nothing",))


def _drive_outputs(
    bench: Bench, pump: float, vent: int, seconds: float, *, limit: float | None = None
) -> tuple[Array, Array]:
    """Drive the outputs; return the time [s] since the first driven sample and each reading [Pa].

    The board drives the outputs for at most `limit` [s]. Raises QuantityError if it stops before
    `seconds` have passed, or if samples are missing.
    """
    last = int(bench.ask("FETC:ALL?").split(",")[0])
    bench.tell(f"DIAG:DRIV {pump:g},{vent},{limit or seconds + 10 * PERIOD * 1e-6:g}")
    blocks, count = [], 0
    try:
        while count < seconds * 1e6 / PERIOD:
            rows = bench.samples(200)
            is_driven = (rows["state"] == DRIVE) & (rows["seq"] > last)
            is_driven &= (rows["flags"] & 1 == vent) & (rows["pump"] == round(255 * pump))
            if len(rows):
                bench.acknowledge(int(rows["seq"][-1]))
                blocks.append(rows[is_driven])
                count += int(is_driven.sum())
                is_over = count or rows["seq"][-1] > last + LONGEST
                if is_over and not is_driven[-1]:
                    break
            time.sleep(PAUSE)
    except InstrumentError:
        count = 0  # the records to acknowledge have already been overwritten
    rows = np.concatenate(blocks) if blocks else np.empty(0, RECORD)
    if count < seconds * 1e6 / PERIOD or (np.diff(rows["seq"].astype(int)) != 1).any():
        raise QuantityError.of(
            "bench",
            f"pump and vent were driven for only {count * PERIOD * 1e-6:.2f} s without a gap, but "
            f"the check needs {seconds:g} s; release the emergency stop and check the 12 V. For a "
            f"virtual bench behind 'bench serve', use a speed of 1 to {FASTEST:g}",
        )
    times = unwrap_clock(rows["board_us"], rows["seq"])
    return (times - times[0]) * 1e-6, rows["vacuum"].astype(float)


def _measure_pump(bench: Bench, vent: int) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return the readings while the pump runs, and those after it stops with the vent closed."""
    bench.off()
    rise = _drive_outputs(bench, 1.0, vent, PUMPED, limit=5.0)
    return rise, _drive_outputs(bench, 0.0, 0, HELD)


def delayed_decay(time: Array, rate: float, lag: float) -> Array:
    """Return exp(-rate time), which begins at 1, as seen through a first-order lag [s]."""
    x = rate * lag
    if x < 1e-9:
        return np.exp(-rate * time)
    x += 1e-6 * (abs(x - 1.0) < 1e-6)  # at this point the singularity is removable
    response: Array = np.exp(-rate * time) - x * np.exp(-time * rate / x)
    return response / (1.0 - x)


def _fit_pump(rise: tuple[Array, Array], after: tuple[Array, Array]) -> dict[str, float | None]:
    """Return the leak after the pump stops, and the rate, final vacuum and lag of the rise.

    The lag is fitted only to the start of the rise, where the pump's flow curve matters least.
    Values that cannot be fitted are None.
    """
    is_late = after[0] > BEGUN
    slope = float(np.polyfit(after[0][is_late], after[1][is_late], 1)[0])
    leak = round(max(-slope / float(after[1][is_late].mean()), 0.0), 6)
    out: dict[str, float | None] = {"leak": leak, "rate": None, "top": None, "lag": None}

    def curve(t: Array, end: float, pole: float, lag: float) -> Array:
        return end * (1.0 - delayed_decay(t, pole, lag))

    guess = (1.3 * float(rise[1].max()), 1.0 / PUMPED, 0.01)
    fit = _fit_curve(curve, *rise, guess)
    if fit is None or not fit[0][1] > leak:
        return out
    end, pole, _ = fit[0]
    out |= {"rate": pole - leak, "top": end * pole / (pole - leak)}
    early = rise[0] < ONSET
    fit = _fit_curve(
        lambda t, size, lag: curve(t, size * end, pole, lag),
        rise[0][early], rise[1][early], (1.0, 0.01),
    )  # fmt: skip
    if fit is not None and fit[1][1] < SURE:
        out["lag"] = round(fit[0][1], 4)
    return out


def _measure_release(bench: Bench, zero: float, vent: int) -> tuple[float, Array, Array]:
    """Return the vacuum reached [Pa], and the times [s] and vacuums [Pa] after the vent command.

    A `vent` of 1 commands the vent to open, 0 to close; during pumping it gets the opposite
    command.
    """
    bench.off()
    _drive_outputs(bench, 1.0, 1 - vent, 0.5 * PUMPED, limit=5.0)
    _, vent_readings = _drive_outputs(bench, 0.0, 1 - vent, EVEN, limit=3.0)
    times, fall = _drive_outputs(bench, 0.0, vent, HELD)
    return float(np.mean(vent_readings[-5:])) - zero, times, fall - zero


def _fit_vent(
    times: Array, fall: Array, level: float, leak: float | None, lag: float | None
) -> float | None:
    """Return the decay rate [1/s] added by the open vent; None if the samples cannot resolve it."""
    shows = int(np.argmax(fall < LEFT * level)) or len(fall)
    fit = _fit_curve(
        lambda t, size, pole: size * delayed_decay(t, pole, lag or 0.0),
        times[:shows], fall[:shows], (level, 1.0 / max(times[shows // 2], 1e-3)),
    )  # fmt: skip
    return None if fit is None else max(fit[0][1] - (leak or 0.0), 0.0)


def _fit_curve(
    curve: Callable[..., Array], times: Array, values: Array, guess: tuple[float, ...]
) -> tuple[list[float], list[float]] | None:
    """Return positive parameters of a curve and their standard errors; None if the fit fails."""
    from scipy.optimize import curve_fit

    if len(times) <= len(guess):
        return None
    try:
        parameters, spread = curve_fit(curve, times, values, guess, bounds=(0.0, np.inf))
    except RuntimeError:
        return None
    return parameters.tolist(), np.sqrt(np.diag(spread)).tolist()


def _judge_bench(data: Checked, plant: Plant | None, lag: float, tune: bool) -> Checked:
    """Return the data with the expected values and any reasons why the bench cannot regulate."""
    faulty = (name for bit, name in TESTS.items() if data.self_test & bit)
    reasons = [f"{name} fails the self-test" for name in faulty]
    reasons += [FAULTS[key] for key in data.wiring]
    if not reasons and (data.rate is None or data.leak is None):
        reasons = ["the rise of the vacuum does not match the curve of a pump"]
    line_values = None
    if plant is not None:
        model = plant.lumped_plant
        line_values = {key: getattr(model, key) for key in ("rate", "top", "leak", "vent")}
        line_values["lag"] = lag + plant.tube_lag
    if not reasons and data.rate is not None and data.leak is not None:
        if data.leak >= data.rate:
            reasons.append(
                f"the line leaks at {data.leak:.3g}/s, but the pump's rate is {data.rate:.3g}/s"
            )
        reasons += [] if tune or line_values is None else _describe_differences(data, line_values)
        if data.zero is not None and data.top is not None and abs(data.zero) > 0.05 * data.top:
            reasons.append(f"the reading with the vent open is {show(data.zero, 'Pa')}, not zero")
    reason = "; ".join(reasons) or None
    return replace(data, feasible=not reasons, reason=reason, expected=line_values)


def _describe_differences(data: Checked, line_values: dict[str, float]) -> Iterator[str]:
    """Yield a sentence for each value that differs from the line's by more than is tolerated."""
    for name, value, share in (
        ("pump's rate", "rate", ALLOWED.pump),
        ("vent's rate", "vent", ALLOWED.vent),
    ):
        rate, nominal = getattr(data, value), line_values[value]
        if rate is not None and abs(rate - nominal) > share * nominal:
            yield (
                f"the {name} is {rate:.3g}/s, but the line's is {nominal:.3g}/s; the detectors "
                f"allow a difference of {share:.0%}"
            )
    limit = max(line_values["lag"], ALLOWED.lag)
    if data.lag is not None and data.lag > limit + SURE:
        yield f"the lag is {show(data.lag, 's')}; the detectors allow at most {show(limit, 's')}"
    if data.leak is not None and data.leak > max(LEAKY * line_values["leak"], TIGHT):
        yield f"the leak is {data.leak:.3g}/s, but the line's is {line_values['leak']:.3g}/s"
