"""`regulate`: a controller on a vacuum line, in closed loop with a noisy sensor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

from layerjam.bench.commands.regulator import (
    RecordedStep,
    RegulatorSettings,
    make_regulator,
    tune_from_step,
)
from layerjam.bench.control.settings import Regulator
from layerjam.brake.commands.arguments import Accept, Atmosphere, Seed, Target, check_vacuum
from layerjam.brake.commands.lines import LineInput
from layerjam.brake.fluid.line_file import LineFile
from layerjam.brake.simulate.quantities import DURATION
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Judged, fact, number, result
from layerjam.core.errors import QuantityError, make_notices
from layerjam.core.units import QuantitySpec, show
from layerjam.core.verdict import Check, check, judge

if TYPE_CHECKING:
    from layerjam.bench.control.closed_loop import ClosedLoop
    from layerjam.bench.control.faults import FaultInjection
    from layerjam.bench.control.tuning import Identified
    from layerjam.core.drawing.chart import Curve, Pane

FAULT_AT = QuantitySpec("s", "time at which the fault begins", hi=1e5, example="8s")
Fault = Literal[
    "pump-dead",
    "pump-weak",
    "line-blocked",
    "leak",
    "sensor-nan",
    "sensor-stuck",
    "sensor-offset",
]
RUNS_FULL = (
    "; it shows only if the pump runs at full power, as during a rise, but here it hardly runs"
)
UNSEEN = {
    "pump-weak": RUNS_FULL,
    "line-blocked": RUNS_FULL,
    "pump-dead": RUNS_FULL,
    "sensor-offset": "; an offset shows only if the line is vented, but here the vacuum is held",
    "sensor-stuck": "; a sensor without noise always shows a constant value at the target",
}
"""{fault: why the detector may miss it}."""


@result
class Regulation(Judged):
    """Performance in reaching and holding the vacuum; `record` is (Regulator, ClosedLoop).

    Times are those of the true vacuum, not of the reading.
    """

    record: tuple[Regulator, ClosedLoop]
    target: float = number("Pa", "target vacuum")
    kind: str = fact("control law")
    safe_state: str = fact("safe state after a fault")
    outcome: str = fact("state reported by the detector: HEALTHY, or the fault")
    rise_time: float | None = number("s", "time from 10 to 90 % of the target")
    overshoot: float = number("Pa", "largest excess of the vacuum over the target")
    steady_error: float | None = number("Pa", "mean error at the end of the run")
    ripple: float | None = number("Pa", "peak-to-peak vacuum at the end of the run")
    pump_switches: int = fact("number of times the pump was switched")
    vent_switches: int = fact("number of times the vent was switched")
    pump_on: float = number("s", "run time of the pump")
    fault_time: float | None = number("s", "time at which a fault was reported")
    fault: str | None = fact("injected fault")
    fault_at: float | None = number("s", "time at which the fault started")
    broken: str | None = fact("description of the fault")
    said_after: float | None = number("s", "detection time, from the start of the fault")
    reachable: float = number("Pa", "highest vacuum that the pump can hold")
    time_constant: float = number("s", "time constant of the line at the target")
    gain: float | None = number("1/Pa", "gain: pump command per unit of error")
    integral_time: float | None = number("s", "integral time")
    sample_time: float = number("s", "sampling interval")
    duration: float = number("s", "simulated time")
    identified: Mapping[str, Any] | None = fact(
        ("values from the step, with 95 % intervals"), listed=False
    )
    detection: Mapping[str, float | None] = fact(
        "longest detection time of each fault", listed=False
    )

    def lines(self) -> Iterator[str]:
        """Yield the results of the step, and the longest detection time of each fault."""
        if self.identified:
            low, high = self.identified["pole"]
            yield ""
            yield (
                f"step: rate {self.identified['rate']:.4g} 1/s; its pole with the leak: "
                f"95 % interval {low:.4g} to {high:.4g} 1/s"
            )
        yield from ("", "longest time until a fault is reported, at this vacuum")
        for name, time in self.detection.items():
            yield f"  {name}: {'not detected' if time is None else f'{time:.3g} s'}"

    def panes(self) -> Sequence[Pane]:
        """Return vacuum, reading and target versus time, and the pump command."""
        from layerjam.bench.figures import control_figures

        regulator, loop = self.record
        return control_figures.loop_panes(regulator, loop, self.fault_at)

    def overlay_curves(self) -> Sequence[Curve]:
        """Return the curve of vacuum [kPa] versus time [s]."""
        return super().overlay_curves()[:1]


@command("vacuum")
def regulate(
    line: LineInput,
    *,
    target: Annotated[Target, Help("Target vacuum.")],
    settings: RegulatorSettings = RegulatorSettings(),
    duration: Annotated[
        float | None, DURATION, Help("Time to simulate. Default: 12 time constants.")
    ] = None,
    recorded: RecordedStep = RecordedStep(),
    fault: Annotated[Fault | None, Help("Fault to inject.")] = None,
    fault_at: Annotated[float | None, FAULT_AT, Help("Time of the fault.")] = None,
    seed: Annotated[Seed, Help("Random seed for the sensor noise.")] = 0,
    accept: Accept = None,
    atmosphere: Atmosphere = None,
) -> Regulation:
    """Simulate the closed-loop control of a line to a vacuum, with a noisy sensor.

    With a recorded `step`, gains, detectors and the simulated line are identified from the log
    (`identified`), and its scatter is used as the noise unless that is given. `detection` is the
    longest detection time [s] of each fault at this vacuum (None: never detected). `fault` is
    injected into the line or the sensor at `fault_at`; `said_after` is None if it was not reported,
    or if it was reported before that time.
    """
    from layerjam.bench.control.checks import regulation_checks
    from layerjam.bench.control.closed_loop import simulate_run
    from layerjam.bench.control.detection import detection_times

    if (fault is None) != (fault_at is None):
        name, missing = ("fault", "fault at") if fault_at is None else ("fault at", "fault")
        raise QuantityError.of(missing, f"missing; required because {name} is given")
    check_vacuum(target, line.line, "target")
    law, notices = make_regulator(line, target, settings)
    step_fit = None
    if recorded.step is not None:
        law, step_fit, further = tune_from_step(
            law, recorded.step, recorded, line.line.site.atmosphere, settings.noise is not None
        )
        notices += make_notices(further)
    elif recorded != RecordedStep():
        raise QuantityError("reading, from, to: only valid with --step")
    constant = law.plant.time_constant(target)
    length = 12 * constant if duration is None else duration
    injection, fault_text = _make_fault_injection(fault, fault_at, law, target, length, line)
    loop = simulate_run(law, [(float(length), float(target))], injected=injection, seed=seed)
    checks = [*regulation_checks(law, target, loop)]
    if fault is not None:
        checks = [_check_fault_report(fault, injection, loop)]
    checks += [] if step_fit is None else step_fit.checks
    times = detection_times(law, target)
    detection_time = loop.fault_time - injection.at
    return Regulation.create(
        None if settings.kind == "bang-bang" else law.gains(),
        loop,
        law,
        judge(checks, accept),
        target=target,
        fault=fault,
        fault_at=fault_at,
        broken=fault_text,
        said_after=detection_time if detection_time >= 0 else None,
        reachable=law.plant.reach,
        time_constant=constant,
        duration=length,
        identified=None if step_fit is None else _identified_values(step_fit),
        detection={k: v if math.isfinite(v) else None for k, v in times.items()},
        warnings=notices,
        record=(law, loop),
    )


def _identified_values(fit: Identified) -> dict[str, Any]:
    return {
        "rate": fit.plant.rate,
        "pole": list(fit.rate_interval),
        "reach": list(fit.reach_interval),
        "noise": fit.noise,
    }


def _make_fault_injection(
    fault: str | None,
    start: float | None,
    regulator: Regulator,
    target: float,
    length: float,
    file: LineFile,
) -> tuple[FaultInjection, str | None]:
    from layerjam.bench.control.faults import FaultInjection, make_injection

    if fault is None or start is None:
        return FaultInjection(), None
    if start >= length:
        raise QuantityError.of(
            "fault at", f"{show(start, 's')} is not allowed; the run ends at {show(length, 's')}"
        )
    injection, words = make_injection(fault, start, regulator, target)
    if file.line.valve is None and injection.pump < 1:
        # the vacuum can be lowered only by running the pump backwards
        injection = replace(injection, vent=injection.pump)
    return injection, words


def _check_fault_report(fault: str, injection: FaultInjection, loop: ClosedLoop) -> Check:
    """Return the check that an injected fault is reported, but not before it begins."""
    if loop.fault_time < injection.at:
        sentence = (
            f"{loop.outcome} was reported at {show(loop.fault_time, 's')}, before the fault began"
        )
        return check("fault", False, sentence, level="failed")
    if math.isfinite(loop.fault_time):
        return check("fault", True, f"{loop.outcome} is reported after the fault began")
    offset = float(loop.vacuum[-1] - loop.target[-1])
    side = "above" if offset > 0 else "below"
    notice_text = (
        f"{fault} was not reported in the simulated time{UNSEEN.get(fault, '')}; the "
        f"vacuum ends {show(abs(offset), 'Pa')} {side} the target"
    )
    return check("fault", False, notice_text)
