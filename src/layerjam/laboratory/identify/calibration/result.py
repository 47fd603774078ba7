"""Result of a calibration by any method, for the command, the figure, the report and the file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from layerjam.brake.device.brake import Brake
from layerjam.core.brief import brief
from layerjam.core.toml_files.source import Source
from layerjam.core.units import show
from layerjam.laboratory.identify.bayes.posterior import BayesFit
from layerjam.laboratory.identify.calibration.budget import ENCLOSURE, Contribution
from layerjam.laboratory.identify.calibration.influence import Covariance, Influence
from layerjam.laboratory.identify.calibration.intervals import Further, Interval
from layerjam.laboratory.identify.calibration.least_squares import JointFit
from layerjam.laboratory.identify.calibration.pull_fit import PullFit
from layerjam.laboratory.identify.calibration.verdict import Identifiability
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import Check
from layerjam.laboratory.identify.single_pulls import SinglePull


@brief
@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """Parameters in SI units, by name, with their statistics; None if unknown.

    `scale_factor` is valid with the brake file's kinetic friction; `enclosure_factor` multiplies
    the enclosure force (the root of the product of its modulus and friction). With a
    `pressure_exponent` the scale factor is that at `reference_pressure` [Pa]; with a `speed_slope`
    (change of ln(friction) per decade of speed) that at `reference_speed` [m/s].

    `intervals` and `bootstrap` are 95 % intervals from the scatter between pulls; `errors_rest_on`
    states the basis of `standard_errors`. `contributions` are the lines of the scatter, the
    enclosure, the mounting and the instruments in the budget of the scale factor. `common_errors`
    {value: relative standard uncertainty} are those that all pulls share. `leave_one_out` is the
    shift of each value without one file, `further` the effect of more pulls on its interval.
    `covariance` {value: {value: number}} has the squares of the intervals' standard errors on its
    diagonal; it is empty for one pull. `mountings` lists the indices of curves that share a
    mounting. `pulls` is the table of pulls, `fits` contains the results of single pulls with a
    peak. The values of the paper's eq. 8 and 9 and the peak are means over `fits`; those of eq. 9
    and the peak are None for pulls at different vacuums. `sources` is {path: (value, Source)} for a
    brake file; `window` describes the fitted section.
    """

    values: Mapping[str, float]
    standard_errors: Mapping[str, float | None]
    errors_rest_on: str
    intervals: Mapping[str, Interval | None]
    contributions: tuple[Contribution, ...]
    checks: tuple[Check, ...]
    curves: tuple[Curve, ...]
    mountings: tuple[tuple[int, ...], ...]
    pulls: tuple[SinglePull, ...]
    fits: tuple[PullFit, ...]
    scale_factor_eq8: float | None
    stiffness_eq9: float | None
    peak_force: float | None
    peak_elongation: float | None
    sources: Mapping[str, tuple[float, Source]]
    window: str
    covariance: Covariance = field(default_factory=dict)
    common_errors: Mapping[str, float] = field(default_factory=dict)
    bootstrap: Mapping[str, Interval | None] | None = None
    leave_one_out: Mapping[str, Influence] | None = None
    further: Mapping[str, Further | None] | None = None
    identifiability: Identifiability | None = None
    posterior: Mapping[str, Mapping[str, Any]] | None = None
    reference_pressure: float | None = None
    reference_speed: float | None = None
    fit: JointFit | BayesFit | None = None

    @property
    def scale_factor(self) -> float:
        """Scale factor a [-]."""
        return self.values["scale_factor"]

    @property
    def stiffness(self) -> float:
        """Stiffness k [N/m]."""
        return self.values["stiffness"]


def make_source(
    value: float, text: str, error: float | None, unit: str, word: str = "standard error"
) -> tuple[float, Source]:
    """Return a value with its source; `word` names the kind of `error`, in `unit`."""
    spread = "" if error is None else f"{word} {show(error, unit, 2)}"
    return float(value), Source(kind="calibrated", text=text, spread=spread)


def make_shape_sources(
    brake: Brake,
    values: Mapping[str, float],
    errors: Mapping[str, float | None],
    text: str,
    word: str = "standard error",
    condition: str = "",
) -> dict[str, tuple[float, Source]]:
    """Return {path: (value, Source)} of scale factor, stiffness and enclosure for a brake file.

    `text` states the method; `word` names the kind of `errors`. The enclosure's modulus and
    friction are scaled alike, because only their product is known.
    """
    factor, error = values["enclosure_factor"], errors["enclosure_factor"]
    source = Source(
        kind="calibrated",
        text=f"{text}; only the product of the enclosure's modulus and friction is known, so both "
        "are scaled",
        spread="" if error is None else f"{word} {error:.2g} of the factor {factor:.4g}",
    )
    friction = f"{text}, with kinetic friction {brake.film.kinetic:.4g}{condition}"
    a, k = "scale_factor", "stiffness"
    return {
        "scale_factor": make_source(values[a], friction, errors[a], "1", word),
        "stiffness_measured": make_source(values[k], text, errors[k], "N/m", word),
        "enclosure.modulus": (float(brake.enclosure.modulus * factor), source),
        "film.friction_on_silicone": (float(brake.film.friction_on_silicone * factor), source),
        **({} if error is None else {ENCLOSURE: make_source(error / factor, text, None, "1")}),
    }
