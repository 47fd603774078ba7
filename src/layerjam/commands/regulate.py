"""`regulate`: a regulator on a vacuum line, in closed loop with a noisy sensor."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from layerjam.commands.answer import Answer, Quantity, si
from layerjam.commands.recorded_step import Recorded, tuned_by
from layerjam.commands.vacuum_line import FLUIDS, AnyLine, line_at, target_of
from layerjam.control.closed_loop import ClosedLoop, FaultInjection, simulate
from layerjam.control.faults import injection_of
from layerjam.control.plant import plant_of
from layerjam.control.settings import Regulator, detection_times
from layerjam.errors import QuantityError, UnknownNameError
from layerjam.fluid.file import LineFile
from layerjam.fluid.line import Sensor
from layerjam.units import QuantitySpec, show, spec_of

FAULT_AT = QuantitySpec("s", "time at which the fault begins", hi=1e5)
DURATION = QuantitySpec("s", "time to simulate", open_lo=True, hi=1e5)
SEED = QuantitySpec("1", "seed of the sensor's noise", hi=2**63 - 1, whole=True)
UNITS = {
    "target": "Pa", "rise_time": "s", "overshoot": "Pa", "steady_error": "Pa", "ripple": "Pa",
    "pump_on": "s", "fault_time": "s", "reachable": "Pa", "gain": "1/Pa", "integral_time": "s",
    "time_constant": "s", "duration": "s", "sample_time": "s",
    "fault_at": "s", "said_after": "s",
}  # fmt: skip


def regulator_of(
    file: LineFile, at: float, *, safe_state: str, kind: str, fluid: str,
    sample_time: Quantity | None, sensor_range: Quantity | None, noise: Quantity | None,
    reversible: bool, least_run: Quantity | None,
) -> tuple[Regulator, list[str]]:  # fmt: skip
    """A regulator for a line, its leak and valve made linear at a vacuum [Pa]; what is assumed."""
    if fluid not in FLUIDS:
        raise UnknownNameError("fluid", fluid, FLUIDS)
    said = list(file.warnings())
    plant = plant_of(file.line, vacuum=at, water=fluid == "water")
    sensor = file.line.sensor
    if sensor is None and sensor_range is None:
        raise QuantityError(
            f"sensor: {file.name} has none; give --sensor-range, the greatest vacuum it shows"
        )
    shown = sensor or Sensor(range=1.0)
    if sensor_range is not None:
        shown = replace(shown, range=si(sensor_range, spec_of(Sensor, "range"), "sensor range"))
    if noise is not None:
        shown = replace(shown, noise=si(noise, spec_of(Sensor, "noise"), "noise"))
    if not plant.vent or file.line.valve is None:
        said.append(
            f"{file.name} has no valve: venting stands for its pumps run backwards, and a fault of "
            "the pump leaves it without release"
        )
    more: dict[str, Any] = {}
    if sample_time is not None:
        more["sample_time"] = si(sample_time, spec_of(Regulator, "sample_time"), "sample time")
    if least_run is not None:
        shortest = si(least_run, spec_of(Regulator, "minimum_on"), "least run")
        more |= {"minimum_on": shortest, "minimum_off": shortest}
    # without a valve there is no other way down
    backwards = reversible or (file.line.valve is None and plant.backwards > 0)
    made = Regulator(
        plant=plant, sensor=shown, kind=kind, safe_state=safe_state, reversible=backwards,
        tuned_at=at, **more,
    )  # fmt: skip
    return made, said


def regulate(
    line: AnyLine,
    *,
    target: Quantity,
    safe_state: str = "",
    kind: str = "pi",
    fluid: str = "air",
    duration: Quantity | None = None,
    sample_time: Quantity | None = None,
    sensor_range: Quantity | None = None,
    noise: Quantity | None = None,
    reversible: bool = False,
    least_run: Quantity | None = None,
    step: Recorded | None = None,
    fault: str | None = None,
    fault_at: Quantity | None = None,
    atmosphere: Quantity | None = None,
    seed: int = 0,
) -> Answer:
    """Bring a line to a vacuum and hold it there, in closed loop with a noisy sensor.

    `kind` is "bang-bang", "pi" or "scheduled"; `safe_state`, "release" or "hold", is where a fault
    ends and must be declared; `least_run` is the pump's shortest run and rest. `step` is a log of
    the real line at full pump: gains, detectors and the line simulated are then those it shows
    (`identified`, with 95 % intervals), and its scatter the noise unless given. Times are those of
    the true vacuum, not of the reading. `detection` has the worst time [s] until each fault is said
    at this vacuum (None: never). `fault`, one of `control.faults.PROVOKED`, breaks the line or
    sensor from `fault_at` on; `broken` is that in words, `said_after` the time until the detector
    answered (None: it said nothing, or before). `record` is (Regulator, ClosedLoop).
    """
    if (fault is None) != (fault_at is None):
        given, missing = ("fault", "fault_at") if fault_at is None else ("fault_at", "fault")
        raise QuantityError(f"{missing}: missing; {given} is given, and they go together")
    file = line_at(line, atmosphere)
    wanted = target_of(target, file.line)
    made, said = regulator_of(
        file, wanted, safe_state=safe_state, kind=kind, fluid=fluid, sample_time=sample_time,
        sensor_range=sensor_range, noise=noise, reversible=reversible,
        least_run=least_run,
    )  # fmt: skip
    found = None
    if step is not None:
        made, found, more = tuned_by(
            made, step, atmosphere=file.line.site.atmosphere, keep_noise=noise is not None
        )
        said += more
    constant = 1 / (made.plant.rate + made.plant.leak)
    length = 12 * constant if duration is None else si(duration, DURATION, "duration")
    injected, broken = _injected(fault, fault_at, made, wanted, length, file)
    SEED.check(float(seed), "seed")
    loop = simulate(made, [(length, wanted)], injected=injected, seed=seed)
    if fault is not None:
        said += _of_the_fault(fault, injected, loop)
    gains = made.gains()
    values = {
        "target": wanted,
        "kind": kind,
        "safe_state": safe_state,
        "outcome": loop.outcome,
        "rise_time": _finite(loop.rise_time),
        "overshoot": loop.overshoot,
        "steady_error": loop.steady_error,
        "ripple": loop.ripple,
        "pump_switches": loop.pump_switches,
        "vent_switches": loop.vent_switches,
        "pump_on": loop.pump_on,
        "fault_time": _finite(loop.fault_time),
        "fault": fault,
        "fault_at": None if fault is None else injected.at,
        "broken": broken,
        "said_after": _said_after(loop, injected),
        "reachable": made.plant.reach,
        "time_constant": constant,
        "gain": None if kind == "bang-bang" else gains.gain,
        "integral_time": None if kind == "bang-bang" else gains.integral_time,
        "sample_time": made.sample_time,
        "duration": length,
        "identified": None if found is None else {
            "rate": found.plant.rate,
            "pole": list(found.rate_interval),
            "reach": list(found.reach_interval),
            "noise": found.noise,
        },
        "detection": {k: _finite(v) for k, v in detection_times(made, wanted).items()},
    }  # fmt: skip
    return Answer(
        values=values, units=UNITS, warnings=said,
        record=(made, loop),
    )  # fmt: skip


def _injected(
    fault: str | None, at: Quantity | None, made: Regulator, target: float, length: float,
    file: LineFile,
) -> tuple[FaultInjection, str | None]:  # fmt: skip
    """What breaks, and in words; nothing without a fault."""
    if fault is None or at is None:
        return FaultInjection(), None
    begins = si(at, FAULT_AT, "fault_at")
    if begins >= length:
        raise QuantityError(
            f"fault_at: {show(begins, 's')} is not allowed; the run ends at {show(length, 's')}"
        )
    injected, words = injection_of(fault, begins, made, target)
    if file.line.valve is None and injected.pump < 1:
        # the pump run backwards is the only way down
        injected = replace(injected, vent=injected.pump)
    return injected, words


def _of_the_fault(fault: str, injected: FaultInjection, loop: ClosedLoop) -> list[str]:
    """What to say of a fault that was not said, or of an alarm before it."""
    if loop.fault_time < injected.at:
        return [f"{loop.outcome} was said at {show(loop.fault_time, 's')}, before the fault began"]
    if math.isfinite(loop.fault_time):
        return []
    off = float(loop.vacuum[-1] - loop.target[-1])
    full = "; it shows where the pump runs full, as in a rise, and here it hardly runs"
    more = {
        "pump-weak": full,
        "line-blocked": full,
        "pump-dead": full,
        "sensor-offset": "; an offset shows when the line is vented, and here it is held",
        "sensor-stuck": "; one number for long tells nothing of a sensor without noise that is at "
        "its target",
    }.get(fault, "")
    where = "above" if off > 0 else "below"
    return [
        f"{fault} was not said in the time simulated{more}; the vacuum ends "
        f"{show(abs(off), 'Pa')} {where} the target"
    ]


def _said_after(loop: ClosedLoop, injected: FaultInjection) -> float | None:
    passed = loop.fault_time - injected.at
    return passed if math.isfinite(passed) and passed >= 0 else None


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
