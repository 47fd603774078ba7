"""Calibration by least squares over all curves at once: parameters, intervals, verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import FitError
from layerjam.identify.calibration.influence import Move, bootstrap_intervals, moves
from layerjam.identify.calibration.intervals import Interval, quantile
from layerjam.identify.calibration.least_squares import FREE, JointFit, fit_jointly
from layerjam.identify.calibration.over_curves import OverCurves, calibrated
from layerjam.identify.calibration.verdict import (
    Identifiability,
    curve_checks,
    identifiability,
    one_file,
)
from layerjam.identify.curves import Curve, condition_words
from layerjam.identify.pull.features import LINEAR
from layerjam.records.source import Source
from layerjam.units import show

WINDOW = (
    f"whole loading branch from {LINEAR[0]:.0%} of the greatest force on, least squares over all "
    "curves, slack of each curve free"
)
FEWEST_DEGREES = 0.5
"""Degrees of freedom below which no interval is stated."""
LOGARITHMIC = ("scale_factor", "stiffness")
"""Estimated by their logarithm."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CurvesCalibration(OverCurves):
    """What all curves say together, SI units.

    `scale_factor` goes with the brake file's kinetic friction; `enclosure_factor` multiplies the
    enclosure's force (the root of the product of its modulus and friction). With a
    `pressure_exponent` the scale factor is that at `reference_pressure` [Pa]; with a `speed_slope`
    (change of ln(friction) per decade of speed) that at `reference_speed` [m/s]. `intervals` and
    `bootstrap` are 95 %; an interval is None where no repeats tell it.
    """

    bootstrap: Mapping[str, Interval | None]
    leave_one_out: Mapping[str, tuple[Move, ...]]
    identifiability: Identifiability
    reference_pressure: float | None
    reference_speed: float | None
    fit: JointFit

    def sources(self, old: BrakeFile) -> dict[str, tuple[float, Source]]:
        """What to write into a brake file: {path: (value, Source)}."""
        text = f"least squares over {len(self.curves)} whole pulls"
        errors = {name: self.standard_error(name) for name in self.values}
        made = shape_sources(old.brake, self.values, errors, text, "standard error", self._at())
        if "pressure_exponent" in self.values and self.reference_pressure is not None:
            exponent, error = self.values["pressure_exponent"], errors["pressure_exponent"]
            made["pressure_exponent"] = calibrated(exponent, text, error, "1")
            if old.brake.test_pressure is None:
                where = "where the scale factor holds: mean vacuum of the pulls, no friction test"
                made["test_pressure"] = calibrated(self.reference_pressure, where, None, "Pa")
        return made

    def _at(self) -> str:
        if self.reference_speed is None:
            return ""
        slope = self.values["speed_slope"]
        return (
            f", at {show(self.reference_speed, 'm/s')}; its logarithm changes by {slope:+.3g} per "
            "decade of speed, which no brake file holds"
        )


def shape_sources(
    brake: Brake,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    text: str,
    word: str,
    at: str = "",
) -> dict[str, tuple[float, Source]]:
    """Scale factor, stiffness and enclosure for a brake file: {path: (value, Source)}.

    `text` says how they were found, `word` what `errors` are. The enclosure's modulus and
    friction are scaled alike, since only their product is known.
    """
    factor, error = values["enclosure_factor"], errors["enclosure_factor"]
    both = Source(
        kind="calibrated",
        text=f"{text}; only the product of the enclosure's modulus and friction is known, so both "
        "are scaled",
        spread="" if error is None else f"{word} {error:.2g} of the factor {factor:.4g}",
    )
    friction = f"{text}, with kinetic friction {brake.film.kinetic:.4g}{at}"
    return {
        "scale_factor": calibrated(
            values["scale_factor"], friction, errors["scale_factor"], "1", word
        ),
        "stiffness_measured": calibrated(
            values["stiffness"], text, errors["stiffness"], "N/m", word
        ),
        "enclosure.modulus": (float(brake.enclosure.modulus * factor), both),
        "film.friction_on_silicone": (float(brake.film.friction_on_silicone * factor), both),
    }


def calibrate_curves(
    curves: Sequence[Curve],
    brake: Brake,
    free: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> CurvesCalibration:
    """Least squares over all `curves` at once.

    `free` names what else is fitted: "pressure_exponent", "speed", "force_offset" (of each curve).
    Raises FitError where the curves cannot tell what is asked for.
    """
    unknown = [name for name in free if name not in FREE]
    if unknown:
        raise FitError(f"free: '{unknown[0]}' is not known; there are {', '.join(FREE)}")
    fit = fit_jointly(curves, brake, free, progress)
    contrasts = _contrasts(fit, brake)
    values: dict[str, float] = {}
    intervals: dict[str, Interval | None] = {}
    for name, contrast in contrasts.items():
        at = float(contrast @ fit.population.estimate)
        values[name] = float(np.exp(at)) if name in LOGARITHMIC else at
        intervals[name] = _interval(name, at, fit.population.standard_error(contrast))
    drawn = bootstrap_intervals(fit.population, fit.groups, contrasts)
    resampled = {name: _natural(name, values[name], found) for name, found in drawn.items()}
    left = moves(
        fit.population,
        contrasts,
        [c.name for c in curves],
        {condition_words(curves[group[0]]): group for group in fit.groups},
        {name: values[name] for name in LOGARITHMIC},
    )
    checks = [*curve_checks(fit, brake, values, [c.speed for c in curves])]
    greatest = {name: (m[0].left_out, m[0].by) for name, m in left.items() if m}
    single = one_file(greatest, intervals)
    exponent = "pressure_exponent" in values
    reference = brake.test_pressure if exponent and brake.test_pressure else fit.reference_pressure
    count = len(curves)
    return CurvesCalibration(
        values=values,
        intervals=intervals,
        bootstrap=resampled,
        leave_one_out=left,
        identifiability=identifiability(fit),
        reference_pressure=reference if exponent else None,
        reference_speed=fit.reference_speed,
        checks=tuple([*checks, single] if single is not None else checks),
        curves=tuple(curves),
        fit=fit,
        errors_rest_on=f"the scatter between {count} pulls"
        if count > 1
        else "nothing: one pull says nothing about repeatability",
    )


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


def _interval(name: str, at: float, error: tuple[float, float] | None) -> Interval | None:
    """From the standard error and degrees of freedom on the scale of the fit."""
    if error is None or error[1] < FEWEST_DEGREES:
        return None
    wide = quantile(error[1]) * error[0]
    found = Interval(
        low=at - wide,
        high=at + wide,
        standard_error=error[0],
        degrees_of_freedom=error[1],
        method="t, sandwich over curves (CR2), degrees of freedom by Satterthwaite",
    )
    return _natural(name, float(np.exp(at)) if name in LOGARITHMIC else at, found)


def _natural(name: str, value: float, found: Interval | None) -> Interval | None:
    """An interval of the estimate as one of the value."""
    if found is None:
        return None
    if name in LOGARITHMIC:
        return replace(
            found,
            low=float(np.exp(found.low)),
            high=float(np.exp(found.high)),
            standard_error=value * found.standard_error,
        )
    return replace(found, low=max(found.low, 0.0)) if name == "enclosure_factor" else found
