"""A sampled posterior in the shape of the other calibrations over curves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.identify.calibration.intervals import Interval
from layerjam.identify.calibration.over_curves import OverCurves
from layerjam.identify.calibration.whole_curves import shape_sources
from layerjam.identify.curves import Curve
from layerjam.records.source import Source

if TYPE_CHECKING:
    from layerjam.identify.bayes.posterior import BayesFit

NAMES = ("scale_factor", "stiffness", "enclosure_factor")


@dataclass(frozen=True, kw_only=True, eq=False)
class BayesCalibration(OverCurves):
    """A sampled posterior in the shape of the other depths' results: means, SDs, 95 % intervals."""

    fit: BayesFit

    @property
    def posterior(self) -> dict[str, dict[str, Any]]:
        """Every number of the fit: mean, SD, 95 % interval, convergence, prior."""
        return {name: row._asdict() for name, row in self.fit.summary().items()}

    def sources(self, old: BrakeFile) -> dict[str, tuple[float, Source]]:
        """What to write into a brake file: {path: (value, Source)}."""
        text = f"mean of the Bayesian posterior over {len(self.curves)} whole pulls"
        errors = {name: self.standard_error(name) for name in self.values}
        return shape_sources(old.brake, self.values, errors, text, "standard deviation")


def calibrate_bayesian(
    curves: Sequence[Curve],
    brake: Brake,
    sampling: tuple[int, int, int],
    tell: Callable[[str, float], None],
) -> BayesCalibration:
    """Sample; `sampling` is (draws of a chain, chains, seed). MissingExtraError without NumPyro."""
    from layerjam.identify.bayes.fit import fit_bayes

    draws, chains, seed = sampling

    def progress(done: int, of: int) -> None:
        tell("sampling", done / of)

    found: BayesFit = fit_bayes(
        curves, brake, draws=draws, chains=chains, seed=seed, progress=progress
    )
    rows = {name: found.summary()[name] for name in NAMES}
    return BayesCalibration(
        values={name: row.mean for name, row in rows.items()},
        intervals={
            name: Interval(
                low=row.low,
                high=row.high,
                standard_error=row.sd,
                degrees_of_freedom=float("inf"),
                method="Bayesian posterior, central 95 %",
            )
            for name, row in rows.items()
        },
        checks=found.checks,
        curves=tuple(curves),
        fit=found,
        errors_rest_on=f"the posterior over {len(curves)} pull{'s' * (len(curves) > 1)}",
    )
