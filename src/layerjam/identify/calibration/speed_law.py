"""The fitted change of friction with speed as the [speed_law] of a brake's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import log, log10

from layerjam.device.speed_law import SpeedLaw
from layerjam.errors import Notice
from layerjam.identify.calibration.least_squares import JointFit
from layerjam.identify.calibration.record import Calibration, calibrated
from layerjam.identify.curves import Curve
from layerjam.records.source import Source

REST = 1e-2
"""Rest speed over that of the slowest pull: among the pulls it bends the law by less than 1 %."""


def law_of(slope: float, reference: float, speeds: Sequence[float]) -> SpeedLaw | None:
    """The law that grows between the slowest and fastest of `speeds` [m/s] as the fit does.

    `slope` is the change of ln(friction) per decade of speed, the scale factor that at `reference`
    [m/s]. None for friction that falls with speed, or grows faster than the speed itself: no brake
    file holds that.
    """
    slow, fast = min(speeds), max(speeds)
    rest = REST * slow
    power = slope * log10(fast / slow) / log((rest + fast) / (rest + slow))
    if not 0 < power <= 1:
        return None
    return SpeedLaw(power=power, test_speed=reference, rest_speed=rest, fastest=fast)


def speed_sources(
    curves: Sequence[Curve],
    fit: JointFit,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    old: SpeedLaw | None,
) -> dict[str, tuple[float, Source]]:
    """What to write into a brake file: {path: (value, Source)}; empty where no speed was fitted.

    Where no law can be written an `old` one loses its power, for the factor is no longer its own.
    """
    if fit.reference_speed is None:
        return {}
    text = f"least squares over {len(curves)} whole pulls"
    speeds = [c.speed for c in curves if c.speed is not None]
    law = law_of(values["speed_slope"], fit.reference_speed, speeds)
    if law is None:
        if old is None:
            return {}
        none = "the fitted friction does not grow with speed as a brake file can hold"
        return {"speed_law.power": calibrated(0.0, f"{text}: {none}", None, "1")}
    error = errors["speed_slope"]
    spread = None if error is None else error * law.power / values["speed_slope"]
    where = "speed at which the scale factor holds: mean of the pulls"
    below = "a hundredth of the slowest pull; nothing was measured below that pull"
    return {
        "speed_law.power": calibrated(law.power, text, spread, "1"),
        "speed_law.test_speed": calibrated(law.test_speed, where, None, "m/s"),
        "speed_law.rest_speed": (law.rest_speed, Source(kind="assumed", text=below)),
        "speed_law.fastest": calibrated(max(speeds), "fastest of the pulls", None, "m/s"),
    }


def on_speed(found: Calibration) -> list[Notice]:
    """What a fit over speed says of the brake file's law."""
    if found.reference_speed is None:
        return []
    power = found.sources.get("speed_law.power")
    if power is None or power[0] == 0:
        words = (
            "the fitted friction falls with speed, or grows faster than it; no [speed_law] holds "
            "that, and the brake's friction counts as that at the reference speed"
        )
        return [Notice(words, "speed-law-not-fitted")]
    words = (
        "the [speed_law] of the calibrated brake rests on the speeds of these pulls; slower and "
        "faster than that it is extrapolated"
    )
    return [Notice(words, "speed-law-fitted")]
