"""`follow`: the force of a sliding brake that follows a profile."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from layerjam.bench.commands.regulator import RegulatorSettings, make_regulator
from layerjam.brake.commands.arguments import Atmosphere, BrakeInput, Interval, Seed
from layerjam.brake.commands.lines import LineInput
from layerjam.brake.device.brake import Brake
from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED, DURATION, FORCE
from layerjam.core.command.declare import Help, command, options
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.results import Figure, fact, number, result
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.units import QuantitySpec, show
from layerjam.laboratory.measure.log import TIME, read_log
from layerjam.laboratory.measure.readers.header import Want

if TYPE_CHECKING:
    from layerjam.bench.control.follow import Bode, Following, ForceSpread

PROFILES = ("step", "sine", "rehabilitation")
PERIOD = replace(DURATION, text="period of the profile", example="10s")
SLIP_SPEED = replace(CROSSHEAD_SPEED, text="slip speed", lo=0.0, example="1mm/s")
MODEL_ERROR = QuantitySpec(
    "1",
    "ratio of the true friction to that assumed by the controller",
    lo=0.1,
    hi=10,
    example="1.1",
)
SLIP_NOISE = QuantitySpec("m", "standard deviation of a measured slip", hi=0.1, example="0.1mm")
FORCE_COLUMN = Want("force", "N", r"\b(force|load|kraft|f)\b", ("N", "kN"))
SLIP_COLUMN = Want("slip", "m", r"\b(slip|travel|weg|x|s)\b", ("mm", "m"), optional=True)
HELD_AT = 0.6
"""Fraction of atmospheric pressure at which leak and valve are linearised."""
FREQUENCIES = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
"""Frequencies tried [Hz], except those with fewer than twenty samples per period."""


@options
class ScheduledSettings(RegulatorSettings):
    """Settings of the controller; its gain follows the vacuum unless a different law is chosen."""

    kind: Annotated[Literal["bang-bang", "pi", "scheduled"], Help("Control law.")] = "scheduled"


@options
class Swing:
    """Generated profile that alternates between two forces while the brake slips steadily."""

    low: Annotated[float | None, FORCE, Help("Minimum force of the profile.")] = None
    high: Annotated[float | None, FORCE, Help("Maximum force of the profile.")] = None
    period: Annotated[float | None, PERIOD] = None
    duration: Annotated[float | None, DURATION] = None
    speed: Annotated[float | None, SLIP_SPEED] = None


@result
class FollowedForce(PredictionResult):
    """Accuracy of the followed force; `record` is (Following, Bode, ForceSpread)."""

    record: "tuple[Following, Bode | None, ForceSpread]"
    rms_error: float = number("N", "root mean square error of the force")
    greatest_error: float = number("N", "maximum error of the force")
    possible: float = fact(
        "fraction of the time in which brake and line can follow the profile",
        shown=lambda share: f"{share:.1%} of the time",
    )
    reasons: list[str] = fact("reason why they cannot at other times", listed=False)
    feasible: bool = fact(
        "whether the whole profile can be followed", shown=lambda yes: "" if yes else "no"
    )
    outcome: str = fact("state reported by the detector: HEALTHY, or the fault")
    greatest_vacuum: float = number("Pa", "highest vacuum")
    pump_switches: int = fact("number of times the pump was switched")
    vent_switches: int = fact("number of times the vent was switched")
    bandwidth: float | None = number(
        "Hz", ("frequency at which a sine of half the swing is reduced to 71 %")
    )
    bode: list[dict[str, float]] | None = fact("frequency response", listed=False)
    sample_time: float = number("s", "sampling interval")

    def lines(self) -> Iterator[str]:
        """Yield the parts of the profile that cannot be followed."""
        if self.reasons:
            yield from ("", *(f"cannot: {reason}" for reason in self.reasons))

    def draw(self) -> Figure:
        """Return the figure of target and true force, vacuum, and frequency response."""
        from layerjam.bench.figures import control_figures

        return control_figures.draw_tracking(*self.record)


@command("vacuum")
def follow(
    line: LineInput,
    brake: BrakeInput,
    *,
    profile: Annotated[
        str | Path,
        Help(
            "Profile of force versus time. A file also needs a slip column.",
            metavar="step|sine|rehabilitation|FILE",
        ),
    ],
    swing: Swing = Swing(),
    settings: ScheduledSettings = ScheduledSettings(),
    slip_noise: Annotated[float, SLIP_NOISE] = 0.0,
    model_error: Annotated[float, MODEL_ERROR] = 1.0,
    seed: Annotated[Seed, Help("Random seed for the sensor noise.")] = 0,
    atmosphere: Atmosphere = None,
    interval: Interval = "next",
) -> FollowedForce:
    """Make a sliding brake's force follow a profile, and report where this is impossible.

    The profile varies between the forces `low` and `high` with a `period` while the brake slips at
    `speed`, or it is a file with time, force and slip. The controller assumes the brake of the
    file. The next brake differs from it, so the intervals of the errors may lie above their values.
    """
    from layerjam.bench.control.follow import follow as run
    from layerjam.bench.control.follow import spread_force
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.brake.simulate.speed import list_pull_notices

    regulator, notices = make_regulator(line, HELD_AT * line.line.site.atmosphere, settings)
    if str(profile) in PROFILES:
        target, slip = _read_profile(str(profile), regulator.sample_time, swing)
    elif swing != Swing():
        names = ", ".join(vars(swing))
        raise QuantityError(f"{names}: only valid with {' or '.join(PROFILES)}")
    else:
        target, slip = _read_profile_file(profile, regulator.sample_time)
    device = brake.brake
    true = replace(device, scale_factor=device.scale_factor * model_error)
    record = run(regulator, device, target, slip, brake=true, slip_noise=slip_noise, seed=seed)
    paces = np.abs(np.gradient(slip, regulator.sample_time))
    frequencies = _find_response(regulator, device, true, target, slip, seed)
    greatest, is_mean = float(record.loop.vacuum.max()), interval == "mean"
    prediction = Prediction(brake, greatest, slip.max(), paces.max(), of_mean=is_mean)
    spread = spread_force(record, true, paces, prediction)
    return FollowedForce.create(
        *(record.loop, frequencies, regulator),
        **prediction.state(**spread.errors),
        rms_error=record.rms,
        greatest_error=float(np.abs(record.error).max()),
        possible=float(record.possible.mean()),
        reasons=list(record.reasons),
        feasible=bool(record.possible.all()),
        greatest_vacuum=greatest,
        bode=None if frequencies is None else _bode_rows(frequencies),
        warnings=[
            *brake.warnings(),
            *notices,
            *list_pull_notices(brake, float(paces.max())),
            *prediction.notices(),
        ],
        record=(record, frequencies, spread),
    )


def _find_response(
    regulator: Any, device: Brake, true: Brake, target: Any, slip: Any, seed: int
) -> "Bode | None":
    """Return the frequency response about the mean of a target [N]; None if it does not swing."""
    from layerjam.bench.control.follow import bode_response

    half = float(np.ptp(target)) / 2
    if not half > 0:
        return None
    return bode_response(
        regulator,
        device,
        slip=float(np.median(slip)),
        mean=float(target.min()) + half,
        amplitude=half,
        frequencies=[f for f in FREQUENCIES if f * regulator.sample_time < 0.05],
        brake=true,
        seed=seed,
        pace=float(np.median(np.abs(np.gradient(slip, regulator.sample_time)))),
    )


def _bode_rows(bode: "Bode") -> list[dict[str, float]]:
    names = ("frequency", "magnitude", "phase")
    columns = (bode.frequency, bode.magnitude, bode.phase)
    return [dict(zip(names, map(float, row), strict=True)) for row in zip(*columns, strict=True)]


def _read_profile(profile: str, dt: float, swing: Swing) -> tuple[Any, Any]:
    """Return the target force [N] and the slip [m] at each sample."""
    from layerjam.bench.control.follow import rehabilitation

    missing = [name for name, value in vars(swing).items() if value is None]
    if missing:
        raise QuantityError(f"{', '.join(missing)}: missing; required by the profile {profile}")
    low, high, period, length, speed = vars(swing).values()
    if high <= low:
        raise QuantityError.of(
            "high", (f"{show(high, 'N')} is not above the value of low, {show(low, 'N')}")
        )
    time = np.arange(round(length / dt)) * dt
    if len(time) < 2:
        raise QuantityError.of("duration", f"{show(length, 's')} is shorter than two samples")
    slip = speed * time
    if profile == "rehabilitation":
        return rehabilitation(time, low=low, high=high, period=period), slip
    wave = np.sin(2 * np.pi * time / period)
    shape = (1 + wave) / 2 if profile == "sine" else (wave < 0).astype(float)
    return low + (high - low) * shape, slip


def _read_profile_file(path: str | Path, dt: float) -> tuple[Any, Any]:
    """Return force and slip from a file of time, force and slip, interpolated linearly."""
    log = read_log(path, (TIME, FORCE_COLUMN, SLIP_COLUMN))
    if "slip" not in log:
        raise FileError(path, "has no slip column, but the force depends on the slip")
    time = log["time"] - log["time"][0]
    if len(time) < 2 or (np.diff(time) <= 0).any():
        raise FileError(path, "its time must increase from row to row")
    times = np.arange(round(float(time[-1]) / dt) + 1) * dt
    return np.interp(times, time, log["force"]), np.interp(times, time, log["slip"])
