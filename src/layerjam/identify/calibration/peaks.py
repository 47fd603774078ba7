"""Calibration from the peaks of pulls: exact form, and the paper's eq. 8 and 9 beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError
from layerjam.identify.calibration.influence import Move, bootstrap_intervals, moves
from layerjam.identify.calibration.intervals import Interval, Population, mean_interval
from layerjam.identify.calibration.over_curves import calibrated
from layerjam.identify.checks import (
    Check,
    agreement,
    end_of_curve,
    identifiable,
    no_trend,
    plausible,
    stiffness_possible,
)
from layerjam.identify.curves import levels
from layerjam.identify.pull.features import FALL, FEWEST, LINEAR, PullFeatures
from layerjam.identify.repeats import over_repeats
from layerjam.mechanics.enclosure import enclosure_at
from layerjam.mechanics.pull import (
    force_at_elongation,
    peak_vacuum,
    scale_factor_eq8,
    scale_factor_of_peak,
)
from layerjam.mechanics.stiffness import stiffness_before_slip
from layerjam.records.source import Source
from layerjam.units import show

WINDOW = (
    f"peak fitted from onset until the force has fallen by {FALL:.0%}; slope over "
    f"{LINEAR[0]:.0%} to {LINEAR[1]:.0%} of the greatest force"
)


@dataclass(frozen=True, kw_only=True)
class PullFit:
    """What one pull says."""

    scale_factor: float
    scale_factor_se: float
    stiffness: float
    scale_factor_eq8: float
    stiffness_eq9: float
    vacuum: float
    pull: PullFeatures


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """Scale factor [-] and stiffness [N/m] of a brake, means over pulls.

    Peak and eq. 9 are None over pulls at different vacuums: no pull had their mean. Standard errors
    are None where nothing estimates the noise; `errors_rest_on` says what they
    come from: the scatter between pulls, or (one pull) the noise within it, which says nothing
    about repeatability. `intervals` and `bootstrap` (95 %) rest on the scatter between pulls only
    and are None for one pull; `leave_one_out` says how far each value moves without one file.
    """

    scale_factor: float
    stiffness: float
    scale_factor_eq8: float
    stiffness_eq9: float | None
    peak_force: float | None
    peak_elongation: float | None
    scale_factor_se: float | None
    stiffness_se: float | None
    errors_rest_on: str
    fits: tuple[PullFit, ...]
    checks: tuple[Check, ...]
    intervals: Mapping[str, Interval | None]
    bootstrap: Mapping[str, Interval | None]
    leave_one_out: Mapping[str, tuple[Move, ...]]

    @property
    def files(self) -> tuple[str, ...]:
        """Paths of the pulls' files."""
        return tuple(f.pull.path for f in self.fits)

    def sources(self, old: BrakeFile) -> dict[str, tuple[float, Source]]:
        """What to write into a brake file: {path: (value, Source)}."""
        files = ", ".join(f.pull.path.rsplit("/", 1)[-1] for f in self.fits)
        friction = old.brake.film.kinetic
        peak = f"peak of {files}, with kinetic friction {friction:.4g}"
        slope = f"slope before onset of {files}"
        return {
            "scale_factor": calibrated(self.scale_factor, peak, self.scale_factor_se, "1"),
            "stiffness_measured": calibrated(self.stiffness, slope, self.stiffness_se, "N/m"),
        }


def fit_pull(pull: PullFeatures, vacuum: float, brake: Brake) -> PullFit:
    """Scale factor and stiffness of one pull at `vacuum` [Pa].

    Raises FitError where the pull has no peak, one below the enclosure's own force, or no
    straight rise before it.
    """
    if vacuum <= 0:
        raise FitError.of(pull.path, f"at {show(vacuum, 'Pa')} of vacuum no sheet is jammed")
    if not pull.has_peak:
        least = show(float(peak_vacuum(brake)), "Pa")
        raise FitError.of(
            pull.path,
            f"the force rises to the end, there is no peak to calibrate on (this "
            f"brake peaks above {least} of vacuum; was the travel long enough?)",
        )
    if not pull.straight:
        raise FitError.of(
            pull.path,
            "the force bends off long before its peak, so that no straight rise "
            "tells the stiffness (pull at more vacuum)",
        )
    if pull.peak_samples < FEWEST:
        raise FitError.of(
            pull.path,
            f"has {pull.peak_samples} samples between onset and a fall of {FALL:.0%} "
            f"from the peak; at least {FEWEST} are needed to calibrate on it",
        )
    factor = float(scale_factor_of_peak(pull.peak_force, vacuum, brake))
    if not np.isfinite(factor):
        root = float(enclosure_at(vacuum, brake).root)
        least = show(root * brake.sheets.overlap**0.5, "N")
        raise FitError.of(
            pull.path,
            f"a peak of {show(pull.peak_force, 'N')} is below {least}, the least that "
            "the enclosure's law allows at this vacuum",
        )
    step = pull.peak_force * 1e-6
    slope = (float(scale_factor_of_peak(pull.peak_force + step, vacuum, brake)) - factor) / step
    return PullFit(
        scale_factor=factor,
        scale_factor_se=abs(slope) * pull.peak_force_se,
        stiffness=pull.stiffness,
        scale_factor_eq8=float(
            scale_factor_eq8(pull.peak_force, pull.peak_elongation, vacuum, brake)
        ),
        stiffness_eq9=pull.peak_force / pull.peak_elongation,
        vacuum=vacuum,
        pull=pull,
    )


def calibrate(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> Calibration:
    """Calibrate on one or several pulls, each given with its vacuum [Pa].

    Raises FitError for a pull that cannot be used.
    """
    if not pulls:
        raise FitError("calibrate: no pull was given")
    fits = tuple(fit_pull(pull, vacuum, brake) for pull, vacuum in pulls)
    factors = np.array([f.scale_factor for f in fits])
    springs = np.array([f.stiffness for f in fits])
    count = len(fits)
    factor_se, spring_se = (over_repeats(v.tolist()).standard_error for v in (factors, springs))
    if count > 1:
        rest = f"the scatter between {count} pulls"
    elif (
        fits[0].pull.noise > 1e-9 * fits[0].pull.peak_force
        and fits[0].pull.stiffness_se > 1e-9 * fits[0].pull.stiffness
    ):
        factor_se, spring_se = fits[0].scale_factor_se, fits[0].pull.stiffness_se
        rest = "the noise within one pull; says nothing about repeatability"
    else:
        rest = "nothing: the record is free of noise"
    values = {"scale_factor": float(factors.mean()), "stiffness": float(springs.mean())}
    vacuums = [f.vacuum for f in fits]
    each = np.column_stack([factors, springs])
    # plain means are a least squares in which every pull counts alike
    shared = Population(
        estimate=each.mean(axis=0),
        design=np.tile(np.eye(2), (count, 1, 1)),
        residual=each - each.mean(axis=0),
    )
    level = levels(vacuums)
    groups = [tuple(i for i, n in enumerate(level) if n == one) for one in sorted({*level})]
    contrasts = dict(zip(values, np.eye(2), strict=True))
    named = [Path(f.pull.path).name for f in fits]
    sets = [show(vacuums[group[0]], "Pa") for group in groups]
    alike = np.ptp(vacuums) <= 0.01 * max(vacuums)

    def mean(values: list[float]) -> float | None:
        return float(np.mean(values)) if alike else None

    return Calibration(
        **values,
        scale_factor_eq8=float(np.mean([f.scale_factor_eq8 for f in fits])),
        stiffness_eq9=mean([f.stiffness_eq9 for f in fits]),
        peak_force=mean([f.pull.peak_force for f in fits]),
        peak_elongation=mean([f.pull.peak_elongation for f in fits]),
        scale_factor_se=factor_se,
        stiffness_se=spring_se,
        errors_rest_on=rest,
        fits=fits,
        checks=calibration_checks(fits, brake),
        intervals={
            "scale_factor": mean_interval(factors.tolist()),
            "stiffness": mean_interval(springs.tolist()),
        },
        bootstrap=bootstrap_intervals(shared, groups, contrasts),
        leave_one_out=moves(shared, contrasts, named, dict(zip(sets, groups, strict=True))),
    )


def calibration_checks(fits: Sequence[PullFit], brake: Brake) -> tuple[Check, ...]:
    """All checks of a calibration."""
    factors = [f.scale_factor for f in fits]
    factor, stiffness = float(np.mean(factors)), float(np.mean([f.stiffness for f in fits]))
    calibrated = replace(brake, scale_factor=factor, stiffness_measured=stiffness)
    last = [(f, float(f.pull.elongation[-1])) for f in fits]
    ends = [float(force_at_elongation(u, f.vacuum, calibrated)) for f, u in last]
    measured = [float(f.pull.force[-max(3, len(f.pull.force) // 200) :].mean()) for f in fits]
    checks = [
        identifiable(brake),
        plausible(factor),
        stiffness_possible(stiffness, float(stiffness_before_slip(brake))),
        agreement(factors, [f.scale_factor_se for f in fits]),
        no_trend(factors, [f.vacuum for f in fits], "vacuum", "Pa"),
        end_of_curve(float(np.mean(ends)), float(np.mean(measured))),
    ]
    return tuple(c for c in checks if c is not None)
