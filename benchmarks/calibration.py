"""Calibrating on 36 curves of 40,000 samples at once, against one curve at a time in SciPy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.timing import Row, median
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.laboratory.campaigns import campaign as lab
from layerjam.laboratory.campaigns.faults import Faults
from layerjam.laboratory.campaigns.spec import Pulls, Spec, Truth
from layerjam.laboratory.identify.calibration.whole_curves import calibrate_curves
from layerjam.laboratory.identify.curves import Curve, make_curves
from layerjam.laboratory.identify.pull.features import pull_features
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.measure.trace import Trace

SAMPLES = 40_000
VACUUMS = (30e3, 60e3, 94.5e3)
SPEEDS = (5e-3, 13e-3)
REPEATS = 6


def pulled(brake: Brake, vacuum: float, speed: float, seed: int) -> Trace:
    """One pull to 40 mm on an ordinary machine, with `SAMPLES` samples."""
    spec = Spec(
        brakes=(Truth(brake=BrakeFile(name="bench", sources={}, text="", brake=brake)),),
        seed=seed,
        pulls=Pulls(vacuums=(vacuum,), speeds=(speed,), repeats=1, travel=0.04),
        machine=Faults(sampling_rate=speed / 0.04 * SAMPLES, force_noise=0.15, force_step=1e-3),
    )
    return lab.campaign(spec).traces()[0]


def campaign(brake: Brake) -> tuple[Curve, ...]:
    """Synthetic pulls, every repeat with its own friction, stiffness and sleeve."""
    random = np.random.default_rng(1)
    pulls = []
    for vacuum in VACUUMS:
        for speed in SPEEDS:
            for repeat in range(REPEATS):
                factor, spring, sleeve = 1 + 0.03 * random.standard_normal(3)
                real = change_shape(brake, 0.875 * factor, 131e3 * spring, 1.2 * sleeve)
                trace = pulled(real, vacuum, speed, repeat)
                pulls.append((trace, pull_features(trace), vacuum))
    return make_curves(pulls)


def with_curve_fit(curve: Curve, brake: Brake) -> object:
    """Factor, stiffness, sleeve and slack of one curve, as a user would fit it in SciPy."""
    from scipy.optimize import curve_fit

    def law(u: np.ndarray, a: float, k: float, sleeve: float, slack: float) -> np.ndarray:
        taut = np.maximum(u - slack, 0.0)
        return np.asarray(
            force_at_elongation(taut, curve.vacuum, change_shape(brake, a, k, sleeve))
        )

    start = (1.0, curve.stiffness, 1.0, 0.0)
    return curve_fit(law, curve.elongation, curve.force, p0=start, x_scale=(*start[:3], 1e-4),
                     method="trf")  # fmt: skip


def rows() -> list[Row]:
    """Seconds for the fit with intervals, bootstrap, leave-one-out and checks, and without."""
    brake = replace(load("choi2018-kapton").brake, scale_factor=1.0)
    curves = campaign(brake)
    whole = median(lambda: calibrate_curves(curves, brake), 7)
    more = median(lambda: calibrate_curves(curves, brake, ("pressure_exponent", "speed")), 5)
    single = len(curves) * median(lambda: with_curve_fit(curves[0], brake), 3)
    name = f"{len(curves)} curves of {SAMPLES:,} samples"
    return [
        Row(name, whole, 1.0, single, "one by one in SciPy curve_fit"),
        Row("  with pressure exponent and speed law", more, 1.0),
    ]
