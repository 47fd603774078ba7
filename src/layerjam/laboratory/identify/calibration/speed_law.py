"""The fitted change of friction with speed, as the [speed_law] table of a brake file."""

from collections.abc import Mapping, Sequence
from math import log, log10

from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.core.errors import Notice
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.calibration.result import Calibration, make_source
from layerjam.laboratory.identify.curves import Curve

REST_RATIO = 1e-2
"""Ratio of rest speed to slowest speed; it changes the law at the pulls by less than 1 %."""


def make_speed_law(slope: float, reference: float, speeds: Sequence[float]) -> SpeedLaw | None:
    """Return a law with the fitted growth between the lowest and highest of `speeds` [m/s].

    `slope` is the change of ln(friction) per decade of speed; the scale factor is that at
    `reference` [m/s]. None if friction falls with speed or grows faster than it, because a brake
    file cannot state such a law.
    """
    slow, fast = min(speeds), max(speeds)
    rest_speed = REST_RATIO * slow
    power = slope * log10(fast / slow) / log((rest_speed + fast) / (rest_speed + slow))
    if not 0 < power <= 1:
        return None
    return SpeedLaw(power=power, test_speed=reference, rest_speed=rest_speed, fastest=fast)


def make_speed_sources(
    curves: Sequence[Curve],
    fit: JointFit,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    old: SpeedLaw | None,
) -> dict[str, tuple[float, Source]]:
    """Return {path: (value, Source)} for a brake file; empty if no speed was fitted.

    If no law can be written, the exponent of an `old` one is removed, as its factor was replaced.
    """
    if fit.reference_speed is None:
        return {}
    text = f"least squares over {len(curves)} whole pulls"
    speeds = [c.speed for c in curves if c.speed is not None]
    law = make_speed_law(values["speed_slope"], fit.reference_speed, speeds)
    if law is None:
        if old is None:
            return {}
        no_law_text = (
            "the fitted friction does not grow with speed in a form that a brake file can express"
        )
        return {"speed_law.power": make_source(0.0, f"{text}: {no_law_text}", None, "1")}
    error = errors["speed_slope"]
    spread = None if error is None else error * law.power / values["speed_slope"]
    basis = "speed at which the scale factor applies: mean of the pulls"
    source_text = "a hundredth of the slowest pull's speed; nothing was measured below it"
    return {
        "speed_law.power": make_source(law.power, text, spread, "1"),
        "speed_law.test_speed": make_source(law.test_speed, basis, None, "m/s"),
        "speed_law.rest_speed": (law.rest_speed, Source(kind="assumed", text=source_text)),
        "speed_law.fastest": make_source(max(speeds), "fastest of the pulls", None, "m/s"),
    }


def speed_notices(calibration: Calibration) -> list[Notice]:
    """Return the notices about the speed law in the brake file."""
    if calibration.reference_speed is None:
        return []
    power = calibration.sources.get("speed_law.power")
    if power is None or power[0] == 0:
        words = (
            "the fitted friction falls with speed, or grows more than in proportion to it; a "
            "[speed_law] cannot express that, so the brake uses the friction at the "
            "reference speed"
        )
        return [Notice(words, "speed-law-not-fitted")]
    words = (
        "the [speed_law] of the calibrated brake is based on the speeds of these pulls; "
        "outside them it is extrapolated"
    )
    return [Notice(words, "speed-law-fitted")]
