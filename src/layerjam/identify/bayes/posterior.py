"""Draws of a Bayesian calibration: the brake, the next pull, their summary and their files."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layerjam._version import __version__
from layerjam.device.brake import Brake
from layerjam.device.load import write_whole
from layerjam.errors import MissingExtraError
from layerjam.identify.bayes.model import FLOOR, RULE, Prior
from layerjam.identify.checks import Check
from layerjam.identify.shape import with_shape
from layerjam.measure.synthetic import SYNTHETIC
from layerjam.records.table_text import comment
from layerjam.simulate.record import column
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    import xarray

LEVEL = 0.95
"""Of the intervals in a summary."""
Array = np.ndarray[Any, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class Population:
    """Possible brakes, one a draw, shape (draws,): what predictions are made from."""

    brake: Brake
    scale_factor: Array = column("1", "scale factor")
    stiffness: Array = column("N/m", "stiffness of brake and rig")
    enclosure_factor: Array = column("1", "factor on the enclosure's force")
    residual: Array = column("1", "SD of a measured curve about the law, over its greatest force")

    def __len__(self) -> int:
        return len(self.scale_factor)

    def brakes(self) -> Brake:
        """All brakes as one, leaves of shape (draws, 1): laws broadcast them against (n,)."""
        return with_shape(
            self.brake,
            self.scale_factor[:, None],
            self.stiffness[:, None],
            self.enclosure_factor[:, None],
        )


class Posterior(NamedTuple):
    """One number of a fit, in its SI unit.

    `low` and `high` bound its central 95 % interval. `r_hat` near 1 says that the chains agree,
    `ess` how many independent draws they are worth; both are None for what is derived from others.
    """

    mean: float
    sd: float
    low: float
    high: float
    median: float
    r_hat: float | None
    ess: float | None
    unit: str
    spec: str
    prior: str


@dataclass(frozen=True, kw_only=True, eq=False)
class BayesFit:
    """Draws of the posterior, shapes (chains, draws) and (chains, draws, curves), SI units.

    `scale_factor`, `stiffness` and `enclosure_factor` are the brake's (medians over repeats, the
    enclosure is shared), the `_sd` the scatter between repeats, relative (SD of the logarithm);
    those of mountings are None if no two curves share one.
    Pulls tell only the products of scale factor and kinetic friction, and of the enclosure's
    modulus and friction (which goes as `enclosure_factor` squared).
    """

    brake: Brake
    paths: tuple[str, ...]
    vacuum: tuple[float, ...]
    scale_factor: Array = column("1", "scale factor of the brake, median over repeats")
    stiffness: Array = column("N/m", "stiffness of brake and rig, median over repeats")
    enclosure_factor: Array = column("1", "factor on the enclosure's force")
    scale_factor_sd: Array = column("1", "scatter of the scale factor between repeats, relative")
    stiffness_sd: Array = column("1", "scatter of the stiffness between repeats, relative")
    correlation: Array = column("1", "correlation of neighbouring residuals")
    curve_scale_factor: Array = column("1", "scale factor of each curve")
    curve_stiffness: Array = column("N/m", "stiffness of each curve")
    slack: Array = column("m", "elongation of each curve before its rise begins")
    residual: Array = column("1", "SD of each curve's residual over its greatest force")
    scale_factor_mounting_sd: Array | None = column(
        "1", "scatter of the scale factor between mountings, relative"
    )
    stiffness_mounting_sd: Array | None = column(
        "1", "scatter of the stiffness between mountings, relative"
    )
    divergences: int
    seed: int
    asked: int
    """Draws a chain that were asked for; fewer are held after Ctrl-C."""
    priors: dict[str, Prior]
    rule: str = RULE
    """How curves were reduced and their residuals understood."""
    checks: tuple[Check, ...] = ()
    synthetic: bool = False
    """Whether a program wrote any of the files."""

    @property
    def trusted(self) -> bool:
        """All checks passed."""
        return all(c.passed for c in self.checks)

    def columns(self) -> dict[str, tuple[Array, QuantitySpec]]:
        """{name: (draws, QuantitySpec)} of every quantity."""
        return {
            f.name: (getattr(self, f.name), f.metadata["quantity"])
            for f in fields(self)
            if "quantity" in f.metadata and getattr(self, f.name) is not None
        }

    def population(self) -> Population:
        """The brake itself: what it is on the median of many repeats."""
        return Population(
            brake=self.brake,
            scale_factor=self.scale_factor.ravel(),
            stiffness=self.stiffness.ravel(),
            enclosure_factor=self.enclosure_factor.ravel(),
            residual=self._residual(),
        )

    def next_pull(self) -> Population:
        """One more pull: the brake with the scatter between repeats; the same at every call."""
        random = np.random.default_rng([self.seed, 1])
        here = self.population()
        z = random.standard_normal((2, len(here)))
        a, k = self.scatter("scale_factor").ravel(), self.scatter("stiffness").ravel()
        return replace(
            here,
            scale_factor=here.scale_factor * np.exp(a * z[0]),
            stiffness=here.stiffness * np.exp(k * z[1]),
        )

    def scatter(self, name: str) -> Array:
        """Relative scatter of a further pull in a mounting of its own, (chains, draws)."""
        shared = getattr(self, f"{name}_mounting_sd")
        own: Array = getattr(self, f"{name}_sd")
        return own if shared is None else np.hypot(own, shared)

    def _residual(self) -> Array:
        """A residual's SD for each draw, of a curve picked at random."""
        flat = self.residual.reshape(-1, self.residual.shape[-1])
        picked = np.random.default_rng([self.seed, 2]).integers(flat.shape[1], size=len(flat))
        return np.asarray(np.sqrt(flat[np.arange(len(flat)), picked] ** 2 + FLOOR**2))

    def summary(self) -> dict[str, Posterior]:
        """The brake, the scatter between repeats, and the next pull ("next_..."), by name."""
        out = {n: self._row(n, v, m) for n, (v, m) in self.columns().items() if v.ndim == 2}
        after = self.next_pull()
        for name in ("scale_factor", "stiffness"):
            spec = QuantitySpec(out[name].unit, f"{name.replace('_', ' ')} of one more pull")
            told = "the brake's, with the scatter between repeats"
            out[f"next_{name}"] = _posterior(getattr(after, name), spec, None, None, told)
        return out

    def _row(self, name: str, draws: Array, spec: QuantitySpec) -> Posterior:
        prior = self.priors[name]
        told = prior.text() if name != "correlation" else prior.why
        return _posterior(draws, spec, *agreement_of(draws), told)

    def to_csv(self, path: str | Path, *, force: bool = False) -> Path:
        """Write the draws as CSV: a '#' header with rule, priors and checks, then SI columns."""
        import pandas

        flat = {f"{n} [{m.unit}]": v for n, (v, m) in self.columns().items() if v.ndim == 2}
        place: Array = np.indices(self.scale_factor.shape)
        named: dict[str, Array] = {"chain": place[0], "draw": place[1], **flat}
        table = pandas.DataFrame({name: values.ravel() for name, values in named.items()})
        head = "".join(comment(f"{key}: {value}") + "\n" for key, value in self.header().items())
        text = head + table.to_csv(index=False, lineterminator="\n")
        return write_whole(path, text, force)

    def header(self) -> dict[str, str]:
        """What stands above the draws."""
        out = {"made by": f"layerjam {__version__} Bayesian calibration", "seed": str(self.seed)}
        out["files"] = ", ".join(Path(p).name for p in self.paths)
        if self.synthetic:
            out["data"] = str(SYNTHETIC)
        out["rule"] = self.rule
        out |= {f"prior of {n}": f"{p.text()}; {p.why}" for n, p in self.priors.items()}
        marks = {True: "passed", False: "LOOK"}
        return out | {f"check {c.name}": f"{marks[c.passed]}: {c.sentence}" for c in self.checks}

    def to_xarray(self) -> xarray.Dataset:
        """All draws, labelled; MissingExtraError without xarray."""
        with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
            import xarray
        dims = ("chain", "draw", "curve")
        data = {
            n: (dims[: v.ndim], v, {"units": m.unit, "long_name": m.text})
            for n, (v, m) in self.columns().items()
        }
        data["vacuum"] = (("curve",), np.array(self.vacuum), {"units": "Pa"})
        coords = {"curve": [Path(p).name for p in self.paths]}
        return xarray.Dataset(data, coords=coords, attrs=self.header())

    def to_netcdf(self, path: str | Path, *, force: bool = False) -> Path:
        """Write all draws as NetCDF 3."""
        data = self.to_xarray()
        return write_whole(path, lambda p: data.to_netcdf(p, engine="scipy"), force)


def _posterior(
    draws: Array, spec: QuantitySpec, r_hat: float | None, ess: float | None, prior: str
) -> Posterior:
    low, median, high = np.quantile(draws, [0.5 - LEVEL / 2, 0.5, 0.5 + LEVEL / 2])
    mean, sd = float(draws.mean()), float(draws.std(ddof=1))
    of = (float(low), float(high), float(median), r_hat, ess, spec.unit, spec.text, prior)
    return Posterior(mean, sd, *of)


def agreement_of(draws: Array) -> tuple[float, float]:
    """Split R-hat and effective sample size of draws (chains, draws)."""
    from numpyro.diagnostics import (  # type: ignore[import-untyped]
        effective_sample_size,
        split_gelman_rubin,
    )

    return float(split_gelman_rubin(draws)), float(effective_sample_size(draws))
