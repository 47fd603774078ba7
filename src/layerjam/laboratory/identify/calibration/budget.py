"""Uncertainty budget of the scale factor: repeats, and inputs common to all pulls."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import scale_factor_of_peak
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.core.units import get, show
from layerjam.laboratory.identify.calibration.intervals import (
    combine_uncertainties,
    coverage_factor,
)
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.identify.statistics import OverRepeats

STEP = 1e-4
DIGITS = 2
"""Number of significant digits of an expanded uncertainty (GUM, 7.2.6)."""
GEOMETRY = {"sheets.width": "width of the sheets", "sheets.overlap": "overlap at rest"}
ENCLOSURE = "enclosure.force_uncertainty"


class Peak(NamedTuple):
    """Peak force [N] and vacuum [Pa] of one pull."""

    force: float
    vacuum: float


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """One line of a budget.

    `standard` is the relative standard uncertainty of the input, with `degrees` of freedom; None if
    nobody stated it and there is no default. `sensitivity` is the ratio of the relative change of
    the scale factor to that of the input. `basis` describes the origin of the value, `supply` the
    missing input (empty if none).
    """

    what: str
    basis: str
    standard: float | None
    sensitivity: float
    degrees: float = math.inf
    supply: str = ""

    @property
    def relative(self) -> float | None:
        """Contribution to the relative standard uncertainty of the scale factor."""
        return None if self.standard is None else abs(self.sensitivity) * self.standard


@dataclass(frozen=True, kw_only=True)
class Budget:
    """The contributions to the uncertainty of a scale factor `value`, and their combination.

    Uncertainties are relative to the value, and None if no contribution was stated.
    """

    contributions: tuple[Contribution, ...]
    value: float = 1.0

    def _combine(self) -> tuple[float, float, float] | tuple[None, None, None]:
        """Return (standard uncertainty, degrees of freedom, coverage factor)."""
        if not any(c.relative for c in self.contributions if not c.supply):
            return None, None, None
        parts = [(c.relative, c.degrees) for c in self.contributions]
        terms = [(u, degrees) for u, degrees in parts if u is not None]
        return (*combine_uncertainties(terms), coverage_factor(terms))

    @property
    def standard_uncertainty(self) -> float | None:
        """Standard uncertainty: the root of the sum of squares (GUM, 5.1.2)."""
        return self._combine()[0]

    @property
    def degrees_of_freedom(self) -> float | None:
        """Effective degrees of freedom (GUM, annex G.4.1)."""
        return self._combine()[1]

    @property
    def coverage_factor(self) -> float | None:
        """Ratio of expanded to standard uncertainty: Student's 95 % quantile (GUM, annex G.3.2)."""
        return self._combine()[2]

    @property
    def expanded_uncertainty(self) -> float | None:
        """Expanded uncertainty at 95 % coverage."""
        if self.standard_uncertainty is None or self.coverage_factor is None:
            return None
        return self.coverage_factor * self.standard_uncertainty

    @property
    def is_complete(self) -> bool:
        """Whether every contribution was stated."""
        return not self.missing

    @property
    def missing(self) -> tuple[str, ...]:
        """Inputs that the user must state to complete the budget."""
        return tuple(c.supply for c in self.contributions if c.supply)

    @property
    def headline(self) -> tuple[str, str] | None:
        """Value and expanded uncertainty as text, such as ("1.243", "0.022").

        The uncertainty has two significant digits; the value has as many decimal places (GUM,
        7.2.6). None if no contribution was stated.
        """
        if not self.expanded_uncertainty:
            return None
        return round_to_uncertainty(self.value, self.value * self.expanded_uncertainty)


def round_to_uncertainty(value: float, uncertainty: float) -> tuple[str, str]:
    """Return a value and its uncertainty (> 0), rounded to two significant digits of the latter."""
    places = DIGITS - 1 - math.floor(math.log10(uncertainty))
    # round first, so that 0.0996 becomes 0.10
    places = DIGITS - 1 - math.floor(math.log10(round(uncertainty, places)))
    text, uncertainty_text = (
        f"{round(x, places):.{max(places, 0)}f}" for x in (value, uncertainty)
    )
    return text, uncertainty_text


def name_scatter(mountings: Sequence[Sequence[int]], count: int) -> str:
    """Describe the scatter on which an interval is based, from `count` pulls in these mountings."""
    if len(mountings) == count:
        return "one pull" if count == 1 else f"the scatter between {count} pulls"
    return f"the scatter between {len(mountings)} mountings of {count} pulls"


def scatter_line(
    error_degrees: tuple[float, float] | None, value: float, basis: str
) -> Contribution:
    """Return the budget line of the scatter between pulls.

    `error_degrees` is the standard error of the scale factor `value` with its degrees of freedom;
    None if the pulls show no scatter.
    """
    error, degrees = error_degrees or (None, math.inf)
    return Contribution(
        what="repeats",
        basis=basis,
        standard=None if error is None else error / value,
        sensitivity=1.0,
        degrees=degrees,
        supply="repeated pulls (repeats)" if error is None else "",
    )


def enclosure_line(peaks: Sequence[Peak], brake: Brake) -> Contribution:
    """Return the budget line of an enclosure force read from the brake file, not fitted."""
    stronger = change_shape(brake, brake.scale_factor, brake.stiffness_measured, 1 + STEP)
    stated = brake.enclosure.force_uncertainty is not None
    words = "as stated in the brake file" if stated else "default: none in the brake file"
    return Contribution(
        what="enclosure's force",
        basis=f"relative SD {brake.enclosure.force_sd:.2g} ({words})",
        standard=brake.enclosure.force_sd,
        sensitivity=_factor_sensitivity(peaks, brake, variant=stronger),
        supply="" if stated else f"{ENCLOSURE} in the brake file, with its source (enclosure)",
    )


def fitted_enclosure_line() -> Contribution:
    """Return the budget line of an enclosure whose force was fitted with the scale factor."""
    basis = "fitted to the pulls; included in the line above"
    return Contribution(what="enclosure's force", basis=basis, standard=0.0, sensitivity=0.0)


def make_budget(
    peaks: Sequence[Peak],
    brake: Brake,
    fitted_lines: Sequence[Contribution],
    sources: Mapping[str, Source],
    value: float = 1.0,
) -> Budget:
    """Return the uncertainty budget of a scale factor `value` determined from `peaks` of `brake`.

    `fitted_lines` are those of the calibration itself: scatter between pulls, enclosure, mounting
    and instruments. `sources` are those of the brake's geometry, whose `sd` is used. There is no
    friction line, because the budget is that of the product of scale factor and friction;
    `make_friction_lines` adds it.
    """
    lines = (*fitted_lines, *_geometry_lines(peaks, brake, sources))
    return Budget(contributions=lines, value=value)


def make_limit_lines(
    peaks: Sequence[Peak], brake: Brake, limits: Mapping[str, float | None]
) -> tuple[Contribution, Contribution]:
    """Return the budget lines of the load cell and the gauge, which affect all pulls alike.

    `limits` are the error limits of "load_cell" (relative to the reading) and "gauge" [Pa], assumed
    rectangular (GUM, 4.3.7).
    """
    inverse_vacuum = float(np.mean([1 / p.vacuum for p in peaks]))
    cell, gauge = limits.get("load_cell"), limits.get("gauge")
    place = "each pull's sidecar"
    return (
        _make_limit_line(
            "load cell",
            cell,
            _factor_sensitivity(peaks, brake, force=1 + STEP),
            f"load_cell_limit in {place}",
        ),
        _make_limit_line(
            "vacuum gauge",
            None if gauge is None else gauge * inverse_vacuum,
            _factor_sensitivity(peaks, brake, vacuum=1 + STEP),
            f"gauge_limit in {place}",
            "" if gauge is None else show(gauge, "Pa"),
        ),
    )


def make_friction_lines(
    kinetic: OverRepeats, limits: Mapping[str, float | None], exponent: float
) -> tuple[Contribution, ...]:
    """Return the lines that friction adds to the budget of the scale factor.

    `kinetic` is the friction of the tests. `limits` are the relative error limits of "load_cell",
    "normal_force" and "area" of the friction rig. The friction is the ratio of force to normal
    force, at a pressure of normal force per area. The pressure in a brake is higher: its friction
    is that of the tests times the ratio of pressures to the power `exponent`.
    """
    error, place = kinetic.standard_error, "each friction test's sidecar"
    inputs = {"load cell": -1.0, "normal force": 1.0 + exponent, "area": -exponent}
    names = {words: words.replace(" ", "_") for words in inputs}
    return (
        Contribution(
            what="friction tests",
            basis="one test" if error is None else "standard error over the tests",
            standard=None if error is None else error / kinetic.mean,
            sensitivity=-1.0,
            degrees=math.inf if error is None else kinetic.repeats - 1,
            supply="a second friction test (--friction)" if error is None else "",
        ),
        *(
            _make_limit_line(
                f"friction rig: {words}",
                limits.get(names[words]),
                sensitivity,
                f"{names[words]}_limit in {place}",
            )
            for words, sensitivity in inputs.items()
        ),
    )


def _make_limit_line(
    name: str, limit: float | None, sensitivity: float, key: str, words: str = ""
) -> Contribution:
    """Return the line of an input with a relative error `limit` (None if it is not stated).

    `key` is the option that states it; `words` is the limit as stated, if that was not relative. An
    input without effect need not be stated.
    """
    if limit is None and sensitivity == 0:
        reason = "no effect: friction is assumed independent of pressure"
        return Contribution(what=name, basis=reason, standard=0.0, sensitivity=0.0)
    stated = words or f"{100 * (limit or 0):.2g} %"
    return Contribution(
        what=name,
        basis="not stated" if limit is None else f"error limit {stated}",
        standard=None if limit is None else limit / sqrt(3),
        sensitivity=sensitivity,
        supply=f"{key} or in conditions.toml" if limit is None else "",
    )


def _geometry_lines(
    peaks: Sequence[Peak], brake: Brake, sources: Mapping[str, Source]
) -> Iterator[Contribution]:
    """Yield the lines of the brake's lengths, with their uncertainty from its file."""
    for path, words in GEOMETRY.items():
        name = path.partition(".")[2]
        longer = evolve(brake, sheets=evolve(brake.sheets, **{name: get(brake, path) * (1 + STEP)}))
        sd = sources[path].sd if path in sources else None
        yield Contribution(
            what=words,
            basis="not stated" if sd is None else f"relative SD {sd:.2g}, from the brake file",
            standard=sd,
            sensitivity=_factor_sensitivity(peaks, brake, variant=longer),
            supply=f"sd of {path} in the brake file" if sd is None else "",
        )


def _factor_sensitivity(
    peaks: Sequence[Peak],
    brake: Brake,
    *,
    force: float = 1.0,
    vacuum: float = 1.0,
    variant: Brake | None = None,
) -> float:
    """Return the mean relative change of the scale factor per relative change of an input.

    The input changes by `STEP`: `force` and `vacuum` are multipliers for those of the peaks, and
    `variant` is the changed brake.
    """
    forces, vacuums = np.array(peaks).T
    before = np.asarray(scale_factor_of_peak(forces, vacuums, brake))
    after = np.asarray(scale_factor_of_peak(forces * force, vacuums * vacuum, variant or brake))
    return float(np.mean(after / before - 1)) / STEP
