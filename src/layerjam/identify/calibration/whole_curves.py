"""Calibration by least squares over all curves at once: parameters, intervals, verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.identify.calibration.budget import (
    fitted_enclosure,
    scatter_line,
    scatter_words,
)
from layerjam.identify.calibration.influence import estimates
from layerjam.identify.calibration.least_squares import FREE, JointFit, fit_jointly
from layerjam.identify.calibration.mountings import find_mountings
from layerjam.identify.calibration.peaks import at_peaks, fits_of, pull_table, with_enclosure
from layerjam.identify.calibration.record import Calibration, calibrated, shape_sources
from layerjam.identify.calibration.speed_law import speed_sources
from layerjam.identify.calibration.verdict import (
    curve_checks,
    follow_law,
    identifiability,
    one_file,
)
from layerjam.identify.checks import interval_checks
from layerjam.identify.curves import Curve
from layerjam.identify.pull.features import LINEAR
from layerjam.identify.shape import SHAPE
from layerjam.identify.single_pulls import pull_checks
from layerjam.identify.speed import growth_in
from layerjam.records.source import Source
from layerjam.simulate.speed import follows_speed
from layerjam.units import show

WINDOW = (
    f"whole loading branch from {LINEAR[0]:.0%} of the greatest force on, least squares over all "
    "curves, slack of each curve free"
)
LOGARITHMIC = SHAPE[:2]
"""Estimated by their logarithm."""


def calibrate_curves(
    curves: Sequence[Curve],
    brake: Brake,
    free: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> Calibration:
    """Least squares over all `curves` at once.

    `free` names what else is fitted: "pressure_exponent", "speed", "force_offset" (of each curve).
    A speed law of the brake's own is kept where "speed" is not free, and replaced where it is.
    Raises FitError where the curves cannot tell what is asked for, or one does not follow the law.
    """
    unknown = [name for name in free if name not in FREE]
    if unknown:
        raise FitError(f"free: '{unknown[0]}' is not known; there are {', '.join(FREE)}")
    old = brake.speed_law
    if "speed" in free:
        brake = replace(brake, speed_law=None)
    fit = fit_jointly(curves, brake, free, progress)
    follow_law(fit, [c.path or c.name for c in curves])
    contrasts, method = _contrasts(fit, brake), "t, sandwich over curves (CR2)"
    method += ", degrees of freedom by Satterthwaite"
    expected = fit.design @ fit.population.estimate + fit.held
    mounted = find_mountings(curves, (fit.own.own[:, :3] - expected)[:, :2])
    told = estimates(
        fit.population,
        contrasts,
        curves,
        fit.groups,
        method,
        LOGARITHMIC,
        mountings=mounted.groups,
    )
    scatter = told.pop("scatter")["scale_factor"]
    rest = scatter_words(mounted.groups, len(curves))
    repeats = scatter_line(scatter, told["values"]["scale_factor"], rest)
    checks = curve_checks(fit, brake, told["values"], curves)
    single = one_file(told["leave_one_out"], told["intervals"])
    reference = None
    if "pressure_exponent" in fit.names:
        reference = brake.test_pressure or fit.reference_pressure
    count, alone = len(curves), fits_of(curves, brake)
    seen, fitted = with_enclosure(alone, brake, told["values"]["enclosure_factor"])
    pulls = pull_table(curves, seen, fitted, _expected(fit, curves, brake))
    interval = told["intervals"]["scale_factor"]
    half = None if interval is None else interval.half_width / told["values"]["scale_factor"]
    return Calibration(
        **told,
        **at_peaks(alone),
        pulls=pulls,
        contributions=(repeats, fitted_enclosure()),
        errors_rest_on=rest if count > 1 else "nothing: one pull says nothing about repeatability",
        checks=(
            *checks,
            *(() if single is None else (single,)),
            mounted.check,
            *interval_checks(told["values"], told["intervals"]),
            *pull_checks(pulls, half),
        ),
        curves=tuple(curves),
        mountings=mounted.groups,
        sources=_sources(fit, told["values"], told["standard_errors"], brake)
        | speed_sources(curves, fit, told["values"], told["standard_errors"], old),
        window=WINDOW,
        identifiability=identifiability(fit),
        reference_pressure=reference,
        reference_speed=fit.reference_speed,
        fit=fit,
    )


def _expected(fit: JointFit, curves: Sequence[Curve], brake: Brake) -> np.ndarray:
    """The scale factor that the fitted laws of vacuum and speed give each curve (curves,).

    Less exponent and speed law of the brake's own file, which a scale factor from a peak is
    without.
    """
    logs = (fit.design @ fit.population.estimate + fit.held)[:, 0]
    logs = logs - np.log([growth_in(brake, c.speed, c.path) for c in curves])
    if brake.pressure_exponent is not None and brake.test_pressure is not None:
        logs = logs - brake.pressure_exponent * np.log(fit.reduced.vacuum / brake.test_pressure)
    return np.exp(logs)


def _sources(
    fit: JointFit,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    brake: Brake,
) -> dict[str, tuple[float, Source]]:
    """What to write into a brake file: {path: (value, Source)}."""
    text, at = f"least squares over {len(fit.reduced)} whole pulls", ""
    if fit.reference_speed is not None:
        at = (
            f", at {show(fit.reference_speed, 'm/s')}; its logarithm changes by "
            f"{values['speed_slope']:+.3g} per decade of speed"
        )
    elif follows_speed(brake) and brake.speed_law is not None:
        at = f", at {show(brake.speed_law.test_speed, 'm/s')} by the file's [speed_law]"
    made = shape_sources(brake, values, errors, text, at=at)
    if "pressure_exponent" in values:
        exponent, error = values["pressure_exponent"], errors["pressure_exponent"]
        made["pressure_exponent"] = calibrated(exponent, text, error, "1")
        if brake.test_pressure is None:
            where = "where the scale factor holds: mean vacuum of the pulls, no friction test"
            made["test_pressure"] = calibrated(fit.reference_pressure, where, None, "Pa")
        if brake.mount.spacers is False:
            share = brake.vacuum_share or 1.0
            lowest = share * float(np.min(fit.reduced.vacuum))
            made["lowest_pressure"] = calibrated(lowest, "least of the pulls", None, "Pa")
    return made


def _contrasts(fit: JointFit, brake: Brake) -> dict[str, np.ndarray]:
    """The linear combination of the estimate behind each value; the scale factor as files hold it.

    Within the fit it stands at the pulls' mean vacuum, where it and the exponent do not disturb
    each other; a brake that states its friction test's pressure has it there.
    """
    contrasts = dict(zip(fit.names, np.eye(len(fit.names)), strict=True))
    if "pressure_exponent" in fit.names and brake.test_pressure is not None:
        moved = contrasts["scale_factor"].copy()
        ratio = brake.test_pressure / fit.reference_pressure
        moved[fit.names.index("pressure_exponent")] = np.log(ratio)
        contrasts["scale_factor"] = moved
    return contrasts
