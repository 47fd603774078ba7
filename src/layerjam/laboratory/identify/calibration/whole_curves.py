"""Calibration by least squares over all curves at once: parameters, intervals and verdict."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.errors import FitError
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.budget import (
    fitted_enclosure_line,
    name_scatter,
    scatter_line,
)
from layerjam.laboratory.identify.calibration.common import (
    check_zero,
    combine_common,
    describe_basis,
    list_common_lines,
)
from layerjam.laboratory.identify.calibration.forward import describe_test_speed, friction_growth
from layerjam.laboratory.identify.calibration.influence import make_estimates
from layerjam.laboratory.identify.calibration.least_squares import FREE, JointFit, fit_jointly
from layerjam.laboratory.identify.calibration.mountings import find_mountings
from layerjam.laboratory.identify.calibration.peaks import (
    calibrate_at_peaks,
    fit_curves,
    make_pull_table,
    scale_enclosure,
)
from layerjam.laboratory.identify.calibration.result import (
    Calibration,
    make_shape_sources,
    make_source,
)
from layerjam.laboratory.identify.calibration.speed_law import make_speed_sources
from layerjam.laboratory.identify.calibration.verdict import (
    check_curves,
    check_single_file,
    judge_identifiability,
    require_law_match,
)
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import Check, check_intervals
from layerjam.laboratory.identify.pull.features import LINEAR
from layerjam.laboratory.identify.pull_checks import check_single_pulls
from layerjam.laboratory.identify.shape import SHAPE

WINDOW = (
    f"whole loading branch above {LINEAR[0]:.0%} of the maximum force; least squares over all "
    "curves, with the slack of each curve free"
)
METHOD = "t, sandwich over curves (CR2), degrees of freedom by Satterthwaite"
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
    if unknown := [name for name in free if name not in FREE]:
        raise FitError(f"free: '{unknown[0]}' is unknown; choose from {', '.join(FREE)}")
    old = brake.speed_law
    if "speed" in free:
        brake = evolve(brake, speed_law=None)
    fit = fit_jointly(curves, brake, free, progress)
    require_law_match(fit, [c.path or c.name for c in curves])
    law = fit.design @ fit.population.estimate + fit.held
    mounting = find_mountings(curves, fit.own.own[:, :3] - law)
    zero_free = "force_offset" in free
    lines = list_common_lines(curves, brake, mounting, zero=not zero_free)
    shared_lines = (fitted_enclosure_line(), *lines)
    common = combine_common(shared_lines, mounting)
    fields = make_estimates(
        fit.population,
        _make_contrasts(fit, brake),
        curves,
        fit.groups,
        METHOD,
        LOGARITHMIC,
        mountings=mounting.groups,
        common_errors=common,
    )
    scatter, values = fields.pop("scatter"), fields["values"]
    basis = name_scatter(mounting.groups, len(curves))
    repeats = scatter_line(scatter["scale_factor"], values["scale_factor"], basis)
    rests_on = "nothing: one pull does not show repeatability"
    single_fits = fit_curves(curves, brake)
    peaks = scale_enclosure(single_fits, brake, values["enclosure_factor"])
    pulls = make_pull_table(curves, *peaks, _fit_law_factors(fit, curves, brake))
    return Calibration(
        **fields,
        **calibrate_at_peaks(single_fits),
        pulls=pulls,
        contributions=(repeats, *shared_lines),
        common_errors=common,
        errors_rest_on=describe_basis(basis, shared_lines) if len(curves) > 1 else rests_on,
        checks=(
            *_list_fit_checks(fit, brake, curves, fields, scatter),
            mounting.check,
            *(() if zero_free else (check_zero(curves),)),
            *check_intervals(values, fields["intervals"]),
            *check_single_pulls(pulls, _half_width(fields)),
        ),
        curves=tuple(curves),
        mountings=mounting.groups,
        sources=_make_brake_sources(fit, values, fields["standard_errors"], brake)
        | make_speed_sources(curves, fit, values, fields["standard_errors"], old),
        window=WINDOW,
        identifiability=judge_identifiability(fit),
        reference_pressure=_find_reference_pressure(fit, brake),
        reference_speed=fit.reference_speed,
        fit=fit,
    )


def _list_fit_checks(
    fit: JointFit,
    brake: Brake,
    curves: Sequence[Curve],
    fields: Mapping[str, Any],
    scatter: Mapping[str, tuple[float, float] | None],
) -> tuple[Check, ...]:
    """Return the checks of the fit, and that no single file determines it."""
    single_check = check_single_file(fields["leave_one_out"], scatter)
    checks = check_curves(fit, brake, fields["values"], curves)
    return (*checks, *(() if single_check is None else (single_check,)))


def _half_width(fields: Mapping[str, Any]) -> float | None:
    """Return the relative half-width of the scale factor's interval; None if it has none."""
    interval = fields["intervals"]["scale_factor"]
    return None if interval is None else interval.half_width / fields["values"]["scale_factor"]


def _find_reference_pressure(fit: JointFit, brake: Brake) -> float | None:
    """Return the pressure [Pa] of the scale factor if the exponent is fitted, otherwise None."""
    if "pressure_exponent" not in fit.names:
        return None
    return brake.test_pressure or fit.reference_pressure


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
    text = f"least squares over {len(fit.reduced)} whole pulls"
    condition = describe_test_speed(brake)
    if fit.reference_speed is not None:
        condition = (
            f", at {show(fit.reference_speed, 'm/s')}; its logarithm changes by "
            f"{values['speed_slope']:+.3g} per decade of speed"
        )
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
