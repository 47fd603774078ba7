"""Calibration from the peaks of pulls, by the exact law and by the paper's eq. 8 and 9."""

from collections.abc import Mapping, Sequence
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.enclosure import enclosure_law
from layerjam.brake.mechanics.pull import (
    brake_force,
    force_at_elongation,
    peak_vacuum,
    scale_factor_eq8,
    scale_factor_of_peak,
)
from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.errors import FitError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.units import show
from layerjam.laboratory.identify.calibration.budget import (
    Peak,
    enclosure_line,
    name_scatter,
    scatter_line,
)
from layerjam.laboratory.identify.calibration.common import (
    check_zero,
    combine_common,
    describe_basis,
    list_common_lines,
)
from layerjam.laboratory.identify.calibration.forward import (
    describe_test_speed,
    fix_friction_speed,
    friction_growth,
)
from layerjam.laboratory.identify.calibration.influence import estimate_covariance, make_estimates
from layerjam.laboratory.identify.calibration.intervals import Interval, Population
from layerjam.laboratory.identify.calibration.mountings import find_mountings
from layerjam.laboratory.identify.calibration.pull_fit import PullFit
from layerjam.laboratory.identify.calibration.result import Calibration, make_source
from layerjam.laboratory.identify.calibration.verdict import check_enclosures
from layerjam.laboratory.identify.curves import Curve, group_conditions, make_curve
from layerjam.laboratory.identify.fit_checks import (
    SMALL,
    Check,
    check_agreement,
    check_curve_end,
    check_intervals,
    check_no_trend,
    check_plausibility,
    check_stiffness,
    note_identifiability,
)
from layerjam.laboratory.identify.pull.features import FALL, FEWEST, LINEAR, SLOPE, PullFeatures
from layerjam.laboratory.identify.pull_checks import check_single_pulls
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.identify.single_pulls import (
    SinglePull,
    SlidingFit,
    make_single_pulls,
)
from layerjam.laboratory.measure.trace import Array, block_means

WINDOW = (
    f"peak fitted from onset until the force has fallen by {FALL:.0%}; slope over "
    f"{LINEAR[0]:.0%} to {LINEAR[1]:.0%} of the maximum force"
)
AFTER = 0.1
"""Fraction of the travel from peak to end that is left out of the comparison with the peak."""
MEANS = 256
"""Number of means over the sliding part, where the law is smooth."""


def fit_pull(pull: PullFeatures, vacuum: float, brake: Brake) -> PullFit:
    """Return scale factor and stiffness of one pull at `vacuum` [Pa].

    Raises FitError if the pull has no peak, a peak below the enclosure's own force, or a rise that
    bends long before the peak. A pull that rises within a few samples yields only a scale factor.
    """
    if vacuum <= 0:
        raise FitError.of(pull.path, f"a vacuum of {show(vacuum, 'Pa')} jams no sheet")
    if not pull.has_peak:
        peak_limit = show(float(peak_vacuum(brake)), "Pa")
        raise FitError.of(
            pull.path,
            f"the force rises to the end: there is no peak to calibrate on (this "
            f"brake peaks above a vacuum of {peak_limit}; was the travel long enough?)",
        )
    if not pull.straight and not pull.is_sparse:
        raise FitError.of(
            pull.path,
            "the curve bends long before its peak, so it has no linear rise for "
            "the stiffness (pull at a higher vacuum)",
        )
    if pull.peak_samples < FEWEST:
        raise FitError.of(
            pull.path,
            f"has {count_text(pull.peak_samples, 'sample')} between onset and a fall of {FALL:.0%} "
            f"from the peak; at least {FEWEST} are needed to calibrate on it",
        )
    factor = float(scale_factor_of_peak(pull.peak_force, vacuum, brake))
    if not np.isfinite(factor):
        root = float(enclosure_law(vacuum, brake).root)
        peak_limit = show(root * brake.sheets.overlap**0.5, "N")
        raise FitError.of(
            pull.path,
            f"a peak of {show(pull.peak_force, 'N')} is below {peak_limit}, the minimum that "
            "the enclosure's law allows at this vacuum",
        )
    step = pull.peak_force * 1e-6
    slope = (float(scale_factor_of_peak(pull.peak_force + step, vacuum, brake)) - factor) / step
    return PullFit(
        scale_factor=factor,
        scale_factor_se=abs(slope) * pull.peak_force_se,
        stiffness=pull.stiffness if pull.straight else None,
        scale_factor_eq8=float(
            scale_factor_eq8(pull.peak_force, pull.peak_elongation, vacuum, brake)
        ),
        stiffness_eq9=pull.peak_force / pull.peak_elongation if pull.straight else None,
        vacuum=vacuum,
        pull=pull,
    )


def _fit_curve(curve: Curve, brake: Brake) -> PullFit:
    growth = friction_growth(brake, curve.speed, curve.path)
    moving_brake = fix_friction_speed(brake, curve.speed, curve.path)
    return evolve(fit_pull(curve, curve.vacuum, moving_brake), growth=growth)


def fit_curves(curves: Sequence[Curve], brake: Brake) -> list[PullFit | None]:
    """Return the fit of each curve alone; None for curves that only a whole-curve fit can use."""
    fits: list[PullFit | None] = []
    for curve in curves:
        try:
            fits.append(_fit_curve(curve, brake))
        except FitError:
            fits.append(None)
    return fits


def stack_logarithms(fits: Sequence[PullFit | None]) -> np.ndarray:
    """Return ln of the scale factor and stiffness of each pull, (pulls, 2); NaN if unknown."""
    pairs = [(None, None) if f is None else (f.scale_factor, f.stiffness) for f in fits]
    return np.log(np.array([[np.nan if v is None else v for v in row] for row in pairs]))


def scale_enclosure(
    fits: Sequence[PullFit | None], brake: Brake, factor: float
) -> tuple[list[PullFit | None], Brake]:
    """Return fits and brake with the enclosure force multiplied by `factor`.

    A fit to the peak alone uses the enclosure in the file. An error of the enclosure also changes
    the scale factor, and more so at low vacuum.
    """
    spring = brake.stiffness_measured
    variant = change_shape(brake, brake.scale_factor, spring, factor)
    peak_fits = [f for f in fits if f is not None]
    if not peak_fits:
        return list(fits), variant
    peaks, vacuums = np.array([(f.pull.peak_force, f.vacuum) for f in peak_fits]).T
    # even if sheets fan out, friction at a pull's speed is that at the test speed times its growth
    growths = np.array([f.growth for f in peak_fits])
    factors = iter((np.asarray(scale_factor_of_peak(peaks, vacuums, variant)) / growths).tolist())
    updates = [None if f is None else evolve(f, scale_factor=next(factors)) for f in fits]
    return [f if f is not None and np.isfinite(f.scale_factor) else None for f in updates], variant


def make_pull_table(
    curves: Sequence[Curve],
    fits: Sequence[PullFit | None],
    brake: Brake,
    law_factors: Array | None = None,
) -> tuple[SinglePull, ...]:
    """Return the table of pulls with its outliers; `law_factors` is as in `make_single_pulls`."""
    stiffnesses = [f.stiffness for f in fits if f is not None and f.stiffness is not None]
    parts = fit_after_peaks(fits, float(np.mean(stiffnesses)) if stiffnesses else None, brake)
    return make_single_pulls(curves, fits, parts, law_factors)


def calibrate_at_peaks(all_fits: Sequence[PullFit | None]) -> dict[str, Any]:
    """Return the fields of a Calibration, from the pulls that have a peak."""
    fits = [f for f in all_fits if f is not None]
    vacuums = [f.vacuum for f in fits]
    has_one_vacuum = bool(fits) and np.ptp(vacuums) <= 0.01 * max(vacuums)

    def mean(values: Sequence[float | None], known: bool = has_one_vacuum) -> float | None:
        numbers = [v for v in values if v is not None]
        return float(np.mean(numbers)) if known and numbers else None

    return {
        "fits": tuple(fits),
        "scale_factor_eq8": mean([f.scale_factor_eq8 for f in fits], bool(fits)),
        "stiffness_eq9": mean([f.stiffness_eq9 for f in fits]),
        "peak_force": mean([f.pull.peak_force for f in fits]),
        "peak_elongation": mean([f.pull.peak_elongation for f in fits if f.pull.straight]),
    }


def calibrate(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> Calibration:
    """Calibrate on one or more pulls, each given with its vacuum [Pa].

    Standard errors are from the scatter between pulls; for one pull, from the noise within it,
    which does not show repeatability. Raises FitError for unusable pulls or if none has a
    stiffness.
    """
    return calibrate_peaks([make_curve(pull, vacuum) for pull, vacuum in pulls], brake)


def calibrate_peaks(curves: Sequence[Curve], brake: Brake) -> Calibration:
    """Calibrate like `calibrate`, but on pulls whose speed and specimen are also known."""
    if not curves:
        raise FitError("calibrate: no pull was given")
    a, k = "scale_factor", "stiffness"
    fits = [_fit_curve(c, brake) for c in curves]
    count, first = len(fits), fits[0]
    values_of: dict[str, list[float | None]] = {
        a: [f.scale_factor for f in fits],
        k: [f.stiffness for f in fits],
    }
    enclosure = enclosure_line([Peak(f.pull.peak_force, f.vacuum) for f in fits], brake)
    # the scale factor from a peak does not depend on speed, so pulls at one vacuum are one
    # condition
    mounting = find_mountings(curves, stack_logarithms(fits))
    shared_lines = (enclosure, *list_common_lines(curves, brake, mounting))
    common = combine_common(shared_lines, mounting)
    fields = _estimate_means(
        values_of,
        [evolve(c, speed=None) for c in curves],
        mounting.groups,
        common,
    )
    basis = describe_basis(name_scatter(mounting.groups, count), shared_lines)
    if count == 1:
        basis = "nothing: its rise or its peak has no noise"
        noise, error = first.pull.noise / first.pull.peak_force, first.pull.stiffness_se
        if noise > 1e-9 and error > 1e-9 * first.pull.stiffness:
            fields["standard_errors"] = {"scale_factor": first.scale_factor_se, "stiffness": error}
            basis = "the noise within one pull; repeatability is unknown"
    files = ", ".join(Path(f.pull.path).name for f in fits)
    values, errors = fields["values"], fields["standard_errors"]
    scatter = fields.pop("scatter")[a]
    repeats = scatter_line(scatter, values[a], name_scatter(mounting.groups, count))
    peak = f"peak of {files}, with kinetic friction {brake.film.kinetic:.4g}"
    peak += describe_test_speed(brake)
    file_names = ", ".join(Path(f.pull.path).name for f in fits if f.stiffness is not None)
    slope = f"slope before onset of {file_names}"
    pulls = make_pull_table(curves, fits, brake)
    return Calibration(
        **fields,
        **calibrate_at_peaks(fits),
        errors_rest_on=basis,
        contributions=(repeats, *shared_lines),
        common_errors=common,
        checks=(
            *check_calibration(fits, pulls, brake, fields["intervals"]["scale_factor"]),
            mounting.check,
            check_zero(curves),
            *check_intervals(values, fields["intervals"]),
        ),
        curves=tuple(curves),
        mountings=mounting.groups,
        pulls=pulls,
        sources={
            "scale_factor": make_source(values[a], peak, errors[a], "1"),
            "stiffness_measured": make_source(values[k], slope, errors[k], "N/m"),
        },
        window=WINDOW,
    )


def _estimate_means(
    values_of: Mapping[str, Sequence[float | None]],
    curves: Sequence[Curve],
    mountings: Sequence[Sequence[int]],
    common: Mapping[str, float],
) -> dict[str, Any]:
    """Return the result of `make_estimates` for each quantity, from the pulls that determine it.

    `common` {name: relative standard uncertainty} is common to all pulls.
    """
    fields: dict[str, Any] = {}
    for name, values in values_of.items():
        places = [place for place, v in enumerate(values) if v is not None]
        if not places:
            raise FitError(
                f"{name}: no pull determines it; each has fewer than {SLOPE} samples between "
                f"{LINEAR[0]:.0%} and {LINEAR[1]:.0%} of its maximum force. Add a pull at a lower "
                "speed or a higher sampling rate"
            )
        used = [curves[place] for place in places]
        number = {place: n for n, place in enumerate(places)}
        units = [[number[p] for p in group if p in number] for group in mountings]
        groups = sorted(group_conditions(used), key=lambda group: used[group[0]].vacuum)
        # plain means are least squares with equal weights
        statistics = make_estimates(
            join_means({name: [values[place] for place in places]}),
            {name: np.ones(1)},
            used,
            groups,
            "t over mountings" if len(mountings) < len(curves) else "t over pulls",
            mountings=[group for group in units if group],
            common_errors=common,
        )
        for key, by_name in statistics.items():
            fields.setdefault(key, {}).update(by_name)
    population = join_means(values_of).join_groups(mountings)
    unit = dict(zip(values_of, np.eye(len(values_of)), strict=True))
    has_both = (
        estimate_covariance(population, unit) if len(fields["covariance"]) == len(values_of) else {}
    )
    for name, second in permutations(has_both, 2):
        fields["covariance"][name][second] = has_both[name][second]
    if not has_both:
        fields["covariance"] = {}
    return fields


def join_means(values_of: Mapping[str, Sequence[float | None]]) -> Population:
    """Return the means of several quantities as one population; None marks an unknown value."""
    values = np.array(
        [[np.nan if v is None else v for v in column] for column in values_of.values()]
    ).T
    is_known = np.isfinite(values)
    means = np.nanmean(values, axis=0)
    return Population(
        estimate=means,
        design=is_known[:, :, None] * np.eye(len(means)),
        residual=np.where(is_known, values - means, 0.0),
    )


def check_calibration(
    fits: Sequence[PullFit],
    pulls: Sequence[SinglePull],
    brake: Brake,
    interval: Interval | None,
) -> tuple[Check, ...]:
    """Return all checks of a calibration; `interval` is that of the scale factor."""
    factors = [f.scale_factor for f in fits]
    stiffnesses = [f.stiffness for f in fits if f.stiffness is not None]
    factor, stiffness = float(np.mean(factors)), float(np.mean(stiffnesses))
    count_text = (
        "" if len(stiffnesses) == len(fits) else f" (from {len(stiffnesses)} of {len(fits)} pulls)"
    )
    fitted_brake = evolve(brake, stiffness_measured=stiffness)
    last = [
        (
            float(f.pull.elongation[-1]),
            f.vacuum,
            evolve(fitted_brake, scale_factor=factor * f.growth),
        )
        for f in fits
    ]
    ends = [float(force_at_elongation(*end_point)) for end_point in last]
    forces = [float(f.pull.force[-max(3, len(f.pull.force) // 200) :].mean()) for f in fits]
    end = check_curve_end(float(np.mean(ends)), float(np.mean(forces)))
    checks = [
        note_identifiability(brake),
        check_plausibility(factor),
        check_stiffness(stiffness, float(stiffness_before_slip(brake)), count_text),
        check_agreement(factors, [f.scale_factor_se for f in fits]),
        check_no_trend(factors, [f.vacuum for f in fits], "vacuum", "Pa"),
        *check_enclosures(pulls, brake.enclosure.force_sd),
        *check_single_pulls(pulls, None if interval is None else interval.half_width / factor, end),
    ]
    return tuple(c for c in checks if c is not None)


def fit_after_peaks(
    fits: Sequence[PullFit | None], stiffness: float | None, brake: Brake
) -> list[SlidingFit | None]:
    """Return the fit of each sliding part, relative to the fit of its peak.

    The force is linear in the contributions of sheets and enclosure. Both are free, so errors of
    the enclosure's parameters have no effect. The first tenth after the peak is excluded, because
    static friction fades there. `stiffness` [N/m] is used for pulls without a stiffness. None if
    the part is too short.
    """
    out: list[SlidingFit | None] = [None] * len(fits)
    parts: list[tuple[int, PullFit, Array, Array]] = []
    for place, fit in enumerate(fits):
        spring = None if fit is None else fit.stiffness or stiffness
        if fit is None or spring is None:
            continue
        slip, force = _select_sliding_part(fit, spring)
        if len(slip) >= FEWEST:
            parts.append((place, fit, slip, force))
    if not parts:
        return out
    # round the number of samples up, so that few shapes are compiled
    size = max(4, 1 << (len(parts) - 1).bit_length())
    slips, column = np.zeros((size, MEANS)), np.ones((size, 1))
    vacuum, factor = column.copy(), column.copy()
    for row, (_, fit, slip, _) in enumerate(parts):
        slips[row, : len(slip)], vacuum[row] = slip, fit.vacuum
        factor[row] = fit.scale_factor * fit.growth
    # the slip is given, so it is not a degree of freedom
    spring = stiffness or brake.stiffness_measured or 1.0
    enclosure_only, stiff = (change_shape(brake, a, spring, 1.0) for a in (0.0 * factor, factor))
    enclosure = np.asarray(brake_force(slips, vacuum, enclosure_only))
    sheets = np.asarray(brake_force(slips, vacuum, stiff)) - enclosure
    for row, (place, _, slip, force) in enumerate(parts):
        basis = np.stack([sheets[row, : len(slip)], enclosure[row, : len(slip)]])
        out[place] = _fit_sliding_part(basis, force)
    return out


def _select_sliding_part(fit: PullFit, stiffness: float) -> tuple[Array, Array]:
    """Return slip [m] and force [N] well after the peak, averaged over neighbouring samples."""
    u, force, begin = fit.pull.elongation, fit.pull.force, fit.pull.peak_elongation
    start = begin + AFTER * (float(u[-1]) - begin)
    # the branch rises, so every sample after the first one above the level is also above it
    first = int(np.argmax(u >= start))
    u, force = block_means(u[first:], MEANS), block_means(force[first:], MEANS)
    return np.maximum(u - force / stiffness, 0.0), force


def _fit_sliding_part(basis: Array, force: Array) -> SlidingFit | None:
    """Return the shares of sheets and enclosure by least squares; None if noise masks them."""
    inner = basis @ basis.T
    (sheets, both), (_, enclosure) = inner.tolist()
    determinant = sheets * enclosure - both**2
    if not determinant > 1e-6 * sheets * enclosure:
        return None
    right = basis @ force
    share = (enclosure * right[0] - both * right[1]) / determinant
    sleeve = (sheets * right[1] - both * right[0]) / determinant
    residuals = force - share * basis[0] - sleeve * basis[1]
    error = np.sqrt(residuals @ residuals / (len(residuals) - 2) * enclosure / determinant)
    return SlidingFit(float(share) - 1, float(sleeve)) if error < SMALL / 2 else None
