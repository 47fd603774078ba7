"""Calibration by least squares over all curves at once: parameters, intervals and verdict."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.identify.calibration.budget import fitted_enclosure_line, name_scatter, scatter_line
from layerjam.identify.calibration.forward import friction_growth
from layerjam.identify.calibration.influence import make_estimates
from layerjam.identify.calibration.least_squares import FREE, JointFit, fit_jointly
from layerjam.identify.calibration.mountings import find_mountings
from layerjam.identify.calibration.peaks import (
    calibrate_at_peaks,
    fit_curves,
    make_pull_table,
    scale_enclosure,
)
from layerjam.identify.calibration.record import Calibration, make_shape_sources, make_source
from layerjam.identify.calibration.speed_law import make_speed_sources
from layerjam.identify.calibration.verdict import (
    check_curves,
    check_single_file,
    judge_identifiability,
    require_law_match,
)
from layerjam.identify.checks import check_intervals
from layerjam.identify.curves import Curve
from layerjam.identify.pull.features import LINEAR
from layerjam.identify.shape import SHAPE
from layerjam.identify.single_pulls import check_single_pulls
from layerjam.toml_files.source import Source
from layerjam.units import show

WINDOW = (
    f"whole loading branch above {LINEAR[0]:.0%} of the maximum force; least squares over all "
    "curves, with the slack of each curve free"
)
LOGARITHMIC = SHAPE[:2]
"""Parameters whose logarithm is estimated."""


def calibrate_curves(
    curves: Sequence[Curve],
    brake: Brake,
    free: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> Calibration:
    """Calibrate by least squares over all `curves` at once.

    `free` names further parameters: "pressure_exponent", "speed" (replaces the brake's speed law),
    "force_offset". Raises FitError if the curves do not determine them or do not follow the law.
    """
    unknown = [name for name in free if name not in FREE]
    if unknown:
        raise FitError(f"free: '{unknown[0]}' is unknown; choose from {', '.join(FREE)}")
    old = brake.speed_law
    if "speed" in free:
        brake = replace(brake, speed_law=None)
    fit = fit_jointly(curves, brake, free, progress)
    require_law_match(fit, [c.path or c.name for c in curves])
    contrasts, method = _make_contrasts(fit, brake), "t, sandwich over curves (CR2)"
    method += ", degrees of freedom by Satterthwaite"
    law = fit.design @ fit.population.estimate + fit.held
    mounting = find_mountings(curves, (fit.own.own[:, :3] - law)[:, :2])
    fields = make_estimates(
        fit.population,
        contrasts,
        curves,
        fit.groups,
        method,
        LOGARITHMIC,
        mountings=mounting.groups,
    )
    scatter = fields.pop("scatter")["scale_factor"]
    basis = name_scatter(mounting.groups, len(curves))
    repeats = scatter_line(scatter, fields["values"]["scale_factor"], basis)
    checks = check_curves(fit, brake, fields["values"], curves)
    single = check_single_file(fields["leave_one_out"], fields["intervals"])
    reference = None
    if "pressure_exponent" in fit.names:
        reference = brake.test_pressure or fit.reference_pressure
    count, single_fits = len(curves), fit_curves(curves, brake)
    peak_fits, fitted_brake = scale_enclosure(
        single_fits, brake, fields["values"]["enclosure_factor"]
    )
    pulls = make_pull_table(curves, peak_fits, fitted_brake, _fit_law_factors(fit, curves, brake))
    interval = fields["intervals"]["scale_factor"]
    half = None if interval is None else interval.half_width / fields["values"]["scale_factor"]
    return Calibration(
        **fields,
        **calibrate_at_peaks(single_fits),
        pulls=pulls,
        contributions=(repeats, fitted_enclosure_line()),
        errors_rest_on=basis if count > 1 else "nothing: one pull does not show repeatability",
        checks=(
            *checks,
            *(() if single is None else (single,)),
            mounting.check,
            *check_intervals(fields["values"], fields["intervals"]),
            *check_single_pulls(pulls, half),
        ),
        curves=tuple(curves),
        mountings=mounting.groups,
        sources=_make_brake_sources(fit, fields["values"], fields["standard_errors"], brake)
        | make_speed_sources(curves, fit, fields["values"], fields["standard_errors"], old),
        window=WINDOW,
        identifiability=judge_identifiability(fit),
        reference_pressure=reference,
        reference_speed=fit.reference_speed,
        fit=fit,
    )


def _fit_law_factors(fit: JointFit, curves: Sequence[Curve], brake: Brake) -> np.ndarray:
    """Return each curve's scale factor from the fitted laws of vacuum and speed, (curves,).

    As for a peak, it excludes the exponent and the speed law in the brake's own file.
    """
    logs = (fit.design @ fit.population.estimate + fit.held)[:, 0]
    logs = logs - np.log([friction_growth(brake, c.speed, c.path) for c in curves])
    if brake.pressure_exponent is not None and brake.test_pressure is not None:
        logs = logs - brake.pressure_exponent * np.log(fit.reduced.vacuum / brake.test_pressure)
    return np.exp(logs)


def _make_brake_sources(
    fit: JointFit,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    brake: Brake,
) -> dict[str, tuple[float, Source]]:
    text, condition = f"least squares over {len(fit.reduced)} whole pulls", ""
    if fit.reference_speed is not None:
        condition = (
            f", at {show(fit.reference_speed, 'm/s')}; its logarithm changes by "
            f"{values['speed_slope']:+.3g} per decade of speed"
        )
    elif law := brake.active_speed_law:
        condition = f", at {show(law.test_speed, 'm/s')} (brake's [speed_law])"
    sources = make_shape_sources(brake, values, errors, text, condition=condition)
    if "pressure_exponent" in values:
        exponent, error = values["pressure_exponent"], errors["pressure_exponent"]
        sources["pressure_exponent"] = make_source(exponent, text, error, "1")
        if brake.test_pressure is None:
            basis = "mean vacuum of the pulls, to which the scale factor refers; no friction test"
            sources["test_pressure"] = make_source(fit.reference_pressure, basis, None, "Pa")
        if brake.mount.spacers is False:
            share = brake.vacuum_share or 1.0
            lowest = share * float(np.min(fit.reduced.vacuum))
            sources["lowest_pressure"] = make_source(lowest, "lowest of the pulls", None, "Pa")
    return sources


def _make_contrasts(fit: JointFit, brake: Brake) -> dict[str, np.ndarray]:
    """Return each value as a combination of the estimates, the scale factor as in brake files.

    The fit's scale factor applies at the pulls' mean vacuum, where it is independent of the
    exponent. In the file it applies at the pressure of the brake's friction test, if stated.
    """
    contrasts = dict(zip(fit.names, np.eye(len(fit.names)), strict=True))
    if "pressure_exponent" in fit.names and brake.test_pressure is not None:
        contrast = contrasts["scale_factor"].copy()
        ratio = brake.test_pressure / fit.reference_pressure
        contrast[fit.names.index("pressure_exponent")] = np.log(ratio)
        contrasts["scale_factor"] = contrast
    return contrasts
