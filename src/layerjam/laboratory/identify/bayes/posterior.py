"""Draws of a Bayesian calibration: the brake, the next pull, their summary and their files."""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layerjam._version import __version__
from layerjam.brake.device.brake import Brake
from layerjam.brake.simulate.record import column
from layerjam.core.errors import MissingExtraError
from layerjam.core.evolve import evolve
from layerjam.core.store import accept_force_option, store_file
from layerjam.core.toml_files.table_text import comment
from layerjam.core.units import QuantitySpec
from layerjam.laboratory.identify.bayes.model import FLOOR, RULE, Prior
from layerjam.laboratory.identify.fit_checks import Check
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.measure.synthetic import SYNTHETIC

if TYPE_CHECKING:
    import xarray

LEVEL = 0.95
"""Probability of the intervals in a summary."""
Array = np.ndarray[Any, Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class Population:
    """Possible brakes, one per draw, shape (draws,), for predictions."""

    brake: Brake
    scale_factor: Array = column("1", "scale factor")
    stiffness: Array = column("N/m", "stiffness of brake and rig")
    enclosure_factor: Array = column("1", "factor on the enclosure's force")
    residual: Array = column("1", "SD of a measured curve about the law / its maximum force")

    def __len__(self) -> int:
        return len(self.scale_factor)

    def brakes(self) -> Brake:
        """Return all brakes as one whose values, of shape (draws, 1), broadcast against (n,)."""
        return change_shape(
            self.brake,
            self.scale_factor[:, None],
            self.stiffness[:, None],
            self.enclosure_factor[:, None],
        )


class Posterior(NamedTuple):
    """One value of a fit, in its SI unit.

    `low` and `high` bound its central 95 % interval. `r_hat` near 1 shows that the chains agree;
    `ess` is the equivalent number of independent draws. Both are None for derived values.
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
    """Draws of the posterior in SI units, shapes (chains, draws) and (chains, draws, curves).

    `scale_factor`, `stiffness` and `enclosure_factor` are those of the brake: medians over repeats,
    which share the enclosure. The `_sd` fields are the relative scatter between repeats (SD of the
    logarithm); those of mountings are None if no two curves share one. Pulls determine only the
    products of scale factor and kinetic friction, and of the enclosure's modulus and friction
    (proportional to `enclosure_factor` squared).
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
    residual: Array = column("1", "SD of each curve's residual / its maximum force")
    scale_factor_mounting_sd: Array | None = column(
        "1", "scatter of the scale factor between mountings, relative"
    )
    stiffness_mounting_sd: Array | None = column(
        "1", "scatter of the stiffness between mountings, relative"
    )
    divergences: int
    seed: int
    priors: dict[str, Prior]
    rule: str = RULE
    """Rule for reducing the curves, and the structure of their residuals."""
    checks: tuple[Check, ...] = ()
    synthetic: bool = False
    """Whether a program generated any of the files."""

    @property
    def is_trusted(self) -> bool:
        """Whether all checks passed."""
        return all(c.passed for c in self.checks)

    def columns(self) -> dict[str, tuple[Array, QuantitySpec]]:
        """Return {name: (draws, QuantitySpec)} of every quantity."""
        return {
            f.name: (getattr(self, f.name), f.metadata["quantity"])
            for f in fields(self)
            if "quantity" in f.metadata and getattr(self, f.name) is not None
        }

    def population(self) -> Population:
        """Return the brake's draws: the median over many repeats."""
        return Population(
            brake=self.brake,
            scale_factor=self.scale_factor.ravel(),
            stiffness=self.stiffness.ravel(),
            enclosure_factor=self.enclosure_factor.ravel(),
            residual=self._draw_residual_sd(),
        )

    def next_pull(self) -> Population:
        """Return the draws of a further pull, with the scatter of repeats; the same every time."""
        random = np.random.default_rng([self.seed, 1])
        brakes = self.population()
        z = random.standard_normal((2, len(brakes)))
        a, k = self.scatter("scale_factor").ravel(), self.scatter("stiffness").ravel()
        return evolve(
            brakes,
            scale_factor=brakes.scale_factor * np.exp(a * z[0]),
            stiffness=brakes.stiffness * np.exp(k * z[1]),
        )

    def scatter(self, name: str) -> Array:
        """Return the relative scatter of a further pull in its own mounting, (chains, draws)."""
        of_mountings = getattr(self, f"{name}_mounting_sd")
        of_repeats: Array = getattr(self, f"{name}_sd")
        return of_repeats if of_mountings is None else np.hypot(of_repeats, of_mountings)

    def _draw_residual_sd(self) -> Array:
        """Return the residual SD of a randomly chosen curve, for each draw."""
        flat = self.residual.reshape(-1, self.residual.shape[-1])
        places = np.random.default_rng([self.seed, 2]).integers(flat.shape[1], size=len(flat))
        return np.asarray(np.sqrt(flat[np.arange(len(flat)), places] ** 2 + FLOOR**2))

    def summary(self) -> dict[str, Posterior]:
        """Return the brake, the scatter between repeats and the next pull ("next_..."), by name."""
        out = {n: self._make_row(n, v, m) for n, (v, m) in self.columns().items() if v.ndim == 2}
        next_pull = self.next_pull()
        for name in ("scale_factor", "stiffness"):
            spec = QuantitySpec(out[name].unit, f"{name.replace('_', ' ')} of a further pull")
            prior = "the brake's value, with the scatter between repeats"
            out[f"next_{name}"] = _summarise_draws(
                getattr(next_pull, name), spec, None, None, prior
            )
        return out

    def _make_row(self, name: str, draws: Array, spec: QuantitySpec) -> Posterior:
        prior = self.priors[name]
        prior_text = prior.text() if name != "correlation" else prior.why
        return _summarise_draws(draws, spec, *chain_agreement(draws), prior_text)

    @accept_force_option
    def to_csv(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write the draws as CSV: a '#' header with rule, priors and checks, then SI columns."""
        import pandas

        flat = {f"{n} [{m.unit}]": v for n, (v, m) in self.columns().items() if v.ndim == 2}
        place: Array = np.indices(self.scale_factor.shape)
        columns: dict[str, Array] = {"chain": place[0], "draw": place[1], **flat}
        table = pandas.DataFrame({name: values.ravel() for name, values in columns.items()})
        head = "".join(comment(f"{key}: {value}") + "\n" for key, value in self.header().items())
        text = head + table.to_csv(index=False, lineterminator="\n")
        return store_file(path, text, overwrite)

    def header(self) -> dict[str, str]:
        """Return the entries of the CSV header above the draws."""
        out = {"made by": f"layerjam {__version__} Bayesian calibration", "seed": str(self.seed)}
        out["files"] = ", ".join(Path(p).name for p in self.paths)
        if self.synthetic:
            out["data"] = str(SYNTHETIC)
        out["rule"] = self.rule
        out |= {f"prior of {n}": f"{p.text()}; {p.why}" for n, p in self.priors.items()}
        marks = {True: "passed", False: "LOOK"}
        return out | {f"check {c.name}": f"{marks[c.passed]}: {c.sentence}" for c in self.checks}

    def to_xarray(self) -> "xarray.Dataset":
        """Return all draws, labelled; raises MissingExtraError if xarray is not installed."""
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

    @accept_force_option
    def to_netcdf(self, path: str | Path, *, overwrite: bool = False) -> Path:
        """Write all draws as NetCDF 3."""
        data = self.to_xarray()
        return store_file(path, lambda p: data.to_netcdf(p, engine="scipy"), overwrite)


def _summarise_draws(
    draws: Array, spec: QuantitySpec, r_hat: float | None, ess: float | None, prior: str
) -> Posterior:
    low, median, high = np.quantile(draws, [0.5 - LEVEL / 2, 0.5, 0.5 + LEVEL / 2])
    mean, sd = float(draws.mean()), float(draws.std(ddof=1))
    fields_ = (float(low), float(high), float(median), r_hat, ess, spec.unit, spec.text, prior)
    return Posterior(mean, sd, *fields_)


def chain_agreement(draws: Array) -> tuple[float, float]:
    """Return split R-hat and effective sample size of draws (chains, draws)."""
    from numpyro.diagnostics import effective_sample_size, split_gelman_rubin  # type: ignore[import-untyped]

    return float(split_gelman_rubin(draws)), float(effective_sample_size(draws))
