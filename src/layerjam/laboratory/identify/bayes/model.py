"""Hierarchical model of many pulls: data, priors, likelihood.

Every curve has its own scale factor, stiffness, slack and residual. Scale factors and stiffnesses
scatter about those of the brake, and all curves share the multiplier of the enclosure force. Curves
of one mounting share part of that scatter.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import brake_force, force_at_elongation
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.mechanics.tracing import jax, jnp
from layerjam.core.errors import FitError
from layerjam.core.units import show
from layerjam.laboratory.identify.curves import Curve, select_fitted_part
from layerjam.laboratory.identify.pull.features import LINEAR
from layerjam.laboratory.identify.shape import change_shape
from layerjam.laboratory.measure.noise import noise_sd

RISE, SLIDE = 24, 72
"""Number of bins of equal elongation in the straight rise and in the sliding part."""
SLIDES = 1.25
"""Elongation at which sliding begins, relative to that at which the rise would reach the peak."""
FEWEST_BINS = 12
"""Minimum number of bins with samples in the sliding part."""
FLOOR = 2e-4
"""Minimum ratio of residual SD to maximum force; no load cell of a test machine is better."""
RULE = (
    f"each curve is reduced to at most {RISE} means over its rise ({LINEAR[0]:.0%} to "
    f"{LINEAR[1]:.0%} of the maximum force) and {SLIDE} over its sliding part (from {SLIDES:g} "
    "times the elongation at which the rise would reach the maximum force). The part between, "
    "where the sheets slip one after another, is excluded. Residuals of neighbouring means are "
    "correlated (first-order autoregressive, one coefficient for all curves); each curve has its "
    f"own SD of them, at least {FLOOR:.2%} of its maximum force"
)
Array = np.ndarray[Any, Any]
PriorNumbers = Mapping[str, tuple[Any, Any]]
"""(mean, SD) of every prior, on the scale on which it is normal."""


class Prior(NamedTuple):
    """Normal prior for a quantity or, with `log`, for its natural logarithm."""

    center: float
    """Median, in the quantity's unit."""
    sd: float
    """Standard deviation, of the logarithm if `log`, otherwise in the quantity's unit."""
    why: str
    unit: str = "1"
    log: bool = True

    def text(self) -> str:
        """Return the prior as text."""
        if not self.log:
            return f"{show(self.center, self.unit)} ± {show(self.sd, self.unit)}"
        return f"{show(self.center, self.unit)} within a factor of {np.exp(self.sd):.3g}"

    @property
    def place(self) -> float:
        """Mean on the scale of the normal distribution."""
        return float(np.log(self.center)) if self.log else self.center


def priors(brake: Brake, mounted: bool = False) -> dict[str, Prior]:
    """Return every prior of the model for a brake, keyed by quantity.

    Includes the scatter between mountings if `mounted`, that is, if curves share mountings.
    """
    stiffness = float(working_stiffness(brake))
    spring = Prior(stiffness, 0.7, "the brake file's value, possibly from another rig", "N/m")
    if brake.stiffness_measured is None:
        spring = Prior(
            stiffness / 2,
            1.2,
            ("half the sheets' own stiffness, because rigs are compliant"),
            "N/m",
        )
    moduli = (
        "moduli published for one silicone differ 1.6 and 2.3 times (catalogue: Ecoflex 00-50, "
        "00-30), its friction is taken as known within 1.5; the force goes with the root"
    )
    films = "the brake file's value; the paper's two films differ by a factor of 1.4"
    repeat = (
        "repeats agree within 3 to 8 % (paper, table I); wide enough that three repeats "
        "give about Student's interval"
    )
    slack = "the zero of each curve is already at the start of its rise"
    law = "fraction of the maximum force: from a good load cell to a law with a 10 % error"
    memory_note = "the logit of the correlation of neighbouring means: 0.05 to 0.95"
    mounting_prior = Prior(
        0.05, 2.0, "as between repeats: each mounting has its own grips and friction"
    )
    mounting_priors = {
        "scale_factor_mounting_sd": mounting_prior,
        "stiffness_mounting_sd": mounting_prior,
    }
    return {
        "scale_factor": Prior(float(brake.scale_factor), 0.5, films),
        "stiffness": spring,
        "enclosure_factor": Prior(1.0, 0.4, moduli),
        "scale_factor_sd": Prior(0.05, 2.0, repeat),
        "stiffness_sd": Prior(0.05, 2.0, "as for the scale factor"),
        "slack": Prior(0.0, 1e-4, slack, "m", log=False),
        "residual": Prior(0.005, 1.5, law),
        "correlation": Prior(0.0, 1.5, memory_note, log=False),
        **(mounting_priors if mounted else {}),
    }


class Data(NamedTuple):
    """Reduced curves, the input of the likelihood; shapes (curves, bins) and (curves,)."""

    elongation: Any
    force: Any
    white: Any
    """Standard deviation of a bin's mean due to sample-to-sample noise [N]."""
    first: Any
    """True for the first bin of the rise and of the sliding part."""
    real: Any
    """False for padding bins."""
    vacuum: Any
    height: Any
    """Maximum force of each curve [N]."""


def reduce_curves(curves: Sequence[Curve]) -> Data:
    """Return the model's data from curves, reduced by `RULE`.

    Raises FitError for a curve without a vacuum or one that does not slide far enough.
    """
    shape = (len(curves), RISE + SLIDE)
    u, force, white = np.full(shape, 1e-3), np.zeros(shape), np.zeros(shape)
    first, real = np.ones(shape, bool), np.zeros(shape, bool)
    for row, curve in enumerate(curves):
        pieces = _split_curve(curve)
        n = sum(len(p[0]) for p in pieces)
        u[row, :n], force[row, :n] = (np.concatenate([p[i] for p in pieces]) for i in (0, 1))
        count = np.concatenate([p[2] for p in pieces])
        white[row, :n] = noise_sd(curve.force) / np.sqrt(count)
        first[row, :n] = np.concatenate([np.arange(len(p[0])) == 0 for p in pieces])
        real[row, :n] = True
    height = np.array([c.peak_force for c in curves])
    return Data(u, force, white, first, real, np.array([c.vacuum for c in curves]), height)


def _split_curve(curve: Curve) -> list[tuple[Array, Array, Array]]:
    """Return bin means of rise and sliding part, or of a whole curve without a straight rise."""
    if curve.vacuum <= 0:
        raise FitError.of(curve.path, f"a vacuum of {show(curve.vacuum, 'Pa')} jams no sheet")
    u, force = curve.elongation, curve.force
    part = select_fitted_part(curve)
    if curve.straight:
        rise = force[: int(np.argmax(force)) + 1]
        indices_below = np.flatnonzero(rise <= LINEAR[1] * curve.peak_force)
        end = int(indices_below[-1]) + 1 if len(indices_below) else 0
        is_sliding = u > SLIDES * curve.peak_force / curve.stiffness
        pieces = [
            _average_stretches(u[part.start : end], force[part.start : end], RISE),
            _average_stretches(u[is_sliding], force[is_sliding], SLIDE),
        ]
    else:
        pieces = [_average_stretches(u[part], force[part], SLIDE)]
    stretches = len(pieces[-1][0])
    if stretches < FEWEST_BINS:
        raise FitError.of(
            curve.path,
            f"has samples in only {stretches} of {SLIDE} intervals of sliding"
            f"; at least {FEWEST_BINS} are needed (pull further, or sample faster)",
        )
    return [p for p in pieces if len(p[0])]


def _average_stretches(u: Array, force: Array, bins: int) -> tuple[Array, Array, Array]:
    """Return means over the non-empty bins of equal width, and the number of samples in each."""
    if len(u) == 0:
        return u, force, u
    low, high = float(u.min()), float(u.max())
    place = ((u - low) / max(high - low, 1e-12) * bins).astype(int).clip(0, bins - 1)
    count = np.bincount(place, minlength=bins)
    filled_bins = count > 0
    mean_u = np.bincount(place, u, bins)[filled_bins] / count[filled_bins]
    return (
        mean_u,
        np.bincount(place, force, bins)[filled_bins] / count[filled_bins],
        count[filled_bins],
    )


class Sites(NamedTuple):
    """The model's unknowns on their normal scales: 6 shared numbers, and 4 for each curve.

    If curves share mountings, the scatter between mountings is also unknown.
    """

    log_a: Any
    log_k: Any
    log_f: Any
    log_sd_a: Any
    log_sd_k: Any
    logit: Any
    own_a: Any
    """Logarithm of each curve's scale factor; this and the next three have shape (..., curves)."""
    own_k: Any
    own_slack: Any
    """Slack of each curve, in prior SDs."""
    own_noise: Any
    """Logarithm of the ratio of the residual's SD to the maximum force."""
    log_mounting_sd_a: Any = None
    log_mounting_sd_k: Any = None


def scatter_indices(mounted: bool) -> list[int]:
    """Return the indices, in the flat vector, of the scatter of repeats and of mountings."""
    return [3, 4, *([-2, -1] if mounted else [])]


class CurveEstimates(NamedTuple):
    """Estimates of a quantity's logarithm from each curve alone: values and errors (curves,)."""

    place: Any
    error: Any


class Guess(NamedTuple):
    """Approximate values of the curves, which guide the sampler but do not affect the result."""

    a: CurveEstimates
    k: CurveEstimates
    mounting: Any = None
    """Whether curves share a mounting, shape (curves, curves); None if no two do."""


class _UnitMap(NamedTuple):
    """Map from standard normal numbers to the unknowns of one quantity, at a given scatter."""

    brake: Any
    brake_sd: Any
    own_pull: Any
    """Weight of the brake's value in each curve's own value."""
    own_sd: Any


def _make_unit_map(
    estimates: CurveEstimates, log_scatter: Any, log_shared: Any, guess: Guess, prior: Any
) -> _UnitMap:
    """Return the map, which is the exact conditional distribution if the curves' errors are normal.

    With mountings it is approximate, which is harmless, because any one-to-one map is valid.
    """
    scatter, error = jnp.exp(2 * log_scatter)[..., None], estimates.error**2
    variance, curves = scatter + error, 1.0
    if guess.mounting is not None:
        mounting_variance = jnp.exp(2 * log_shared)[..., None]
        scatter = scatter + mounting_variance
        variance = variance + mounting_variance
        curves = guess.mounting.sum(axis=-1)
        weight = 1 / (variance + (curves - 1) * mounting_variance)
    else:
        weight = 1 / variance
    precision = weight.sum(axis=-1) + prior[1] ** -2.0
    place = ((weight * estimates.place).sum(axis=-1) + prior[0] * prior[1] ** -2.0) / precision
    return _UnitMap(place, precision**-0.5, error / variance, jnp.sqrt(scatter * error / variance))


def _make_unit_maps(sites: Sites, guess: Guess, beliefs: PriorNumbers) -> tuple[_UnitMap, _UnitMap]:
    a, k = sites.log_mounting_sd_a, sites.log_mounting_sd_k
    return (
        _make_unit_map(guess.a, sites.log_sd_a, a, guess, beliefs["scale_factor"]),
        _make_unit_map(guess.k, sites.log_sd_k, k, guess, beliefs["stiffness"]),
    )


def unpack_sites(flat: Any, guess: Guess, beliefs: PriorNumbers) -> Sites:
    """Return the unknowns from flat vectors, shape (..., 6 + 4 curves), or 2 more with mountings.

    The flat vector contains the brake's and the curves' own values in units of their remaining
    spread, given the scatter between repeats. It is therefore independent of the scatter, so that a
    sampler does not get stuck at a small scatter but moves between small and large ones.
    """
    sites = _convert_raw_values(flat, guess)
    values = {}
    for unit_map, name in zip(_make_unit_maps(sites, guess, beliefs), "ak", strict=True):
        estimates = getattr(guess, name)
        brake = unit_map.brake + unit_map.brake_sd * getattr(sites, f"log_{name}")
        center = (1 - unit_map.own_pull) * estimates.place + unit_map.own_pull * brake[..., None]
        values[f"log_{name}"] = brake
        values[f"own_{name}"] = center + unit_map.own_sd * getattr(sites, f"own_{name}")
    return sites._replace(**values)


def pack_sites(sites: Sites, guess: Guess, beliefs: PriorNumbers) -> Array:
    """Return the flat vector of unknowns; the inverse of `unpack_sites`."""
    values = {}
    for unit_map, name in zip(_make_unit_maps(sites, guess, beliefs), "ak", strict=True):
        estimates, brake = getattr(guess, name), getattr(sites, f"log_{name}")
        center = (1 - unit_map.own_pull) * estimates.place + unit_map.own_pull * brake
        values[f"log_{name}"] = (brake - unit_map.brake) / unit_map.brake_sd
        values[f"own_{name}"] = (getattr(sites, f"own_{name}") - center) / unit_map.own_sd
    parts = [x for x in sites._replace(**values) if x is not None]
    return np.concatenate([np.atleast_1d(np.asarray(x, float)) for x in parts])


def log_jacobian(flat: Any, guess: Guess, beliefs: PriorNumbers) -> Any:
    """Return the log determinant of the map from the flat vector to the unknowns."""
    ways = _make_unit_maps(_convert_raw_values(flat, guess), guess, beliefs)
    return sum(jnp.log(w.brake_sd) + jnp.log(w.own_sd).sum(axis=-1) for w in ways)


def _convert_raw_values(flat: Any, guess: Guess) -> Sites:
    mounted = guess.mounting is not None
    mounting_sds = [flat[..., -2], flat[..., -1]] if mounted else []
    curve_values = flat[..., 6 : -2 if mounted else None].reshape((*flat.shape[:-1], 4, -1))
    return Sites(
        *(flat[..., i] for i in range(6)),
        *(curve_values[..., i, :] for i in range(4)),
        *mounting_sds,
    )


def choose_start(data: Data, curves: Sequence[Curve], brake: Brake) -> Sites:
    """Return the start of the search: the law fitted to each sliding part, the file's enclosure.

    The scatter is so large that the curves do not affect one another.
    """
    center = priors(brake)["stiffness"].center
    spring = np.array([c.stiffness if c.straight else center for c in curves])
    vacuum = data.vacuum[:, None]
    slip = np.clip(data.elongation - data.force / spring[:, None], 0.0, None)
    is_late = data.real & (slip > 0.02 * brake.sheets.overlap)
    with_one = np.asarray(brake_force(slip, vacuum, brake))
    compliant = change_shape(brake, 0.0, brake.stiffness_measured, 1.0)
    sleeve = np.asarray(brake_force(slip, vacuum, compliant))
    sheets = np.where(is_late, with_one - sleeve, 0.0).sum(axis=1)
    sheet_force = np.where(is_late, data.force - sleeve, 0.0).sum(axis=1)
    ratio = np.divide(sheet_force, sheets, out=np.ones_like(sheet_force), where=sheets > 0)
    factor = np.log(brake.scale_factor * np.clip(ratio, 0.05, 20.0))
    zeros = np.zeros(len(curves))
    own_k = np.log(spring)
    log_scatter = np.log(0.3)
    return Sites(
        factor.mean(),
        own_k.mean(),
        0.0,
        log_scatter,
        log_scatter,
        0.0,
        factor,
        own_k,
        zeros,
        zeros + np.log(0.01),
    )


def law_forces(sites: Sites, slack_sd: Any, data: Data, brake: Brake) -> Any:
    """Return the law's force [N] in every bin, (curves, bins); zero before slack is taken up."""
    shaped = change_shape(
        brake, jnp.exp(sites.own_a)[:, None], jnp.exp(sites.own_k)[:, None], jnp.exp(sites.log_f)
    )
    taut = jnp.maximum(data.elongation - (slack_sd * sites.own_slack)[:, None], 0.0)
    return force_at_elongation(taut, data.vacuum[:, None], shaped)


def log_likelihood(residuals: Any, size: Any, phi: Any, data: Data) -> Any:
    """Return the log likelihood of residuals [N] (curves, bins): SD `size` [N], correlation phi.

    A residual less phi times the previous one has the variance size^2 (1 - phi^2) + `white`^2.
    """
    previous = jnp.concatenate([jnp.zeros_like(residuals[:, :1]), residuals[:, :-1]], axis=1)
    new = jnp.where(data.first, residuals, residuals - phi * previous)
    fresh = size[:, None] ** 2 * jnp.where(data.first, 1.0, 1 - phi**2) + data.white**2
    terms = -0.5 * (new**2 / fresh + jnp.log(fresh))
    return jnp.where(data.real, terms, 0.0).sum()


def prior_moments(brake: Brake, mounted: bool = False) -> dict[str, tuple[float, float]]:
    """Return {name: (mean, SD)} of the priors."""
    return {name: (p.place, p.sd) for name, p in priors(brake, mounted).items()}


def numpyro_model(data: Data, brake: Brake, beliefs: PriorNumbers, mounting: Any = None) -> None:
    """Define the model for NumPyro; `mounting` is that of a Guess."""
    import numpyro  # type: ignore[import-untyped]
    import numpyro.distributions as dist  # type: ignore[import-untyped]

    def sample_normal(site: str, name: str) -> Any:
        return numpyro.sample(site, dist.Normal(*beliefs[name]))

    log_a, log_k = sample_normal("log_a", "scale_factor"), sample_normal("log_k", "stiffness")
    log_f, logit = sample_normal("log_f", "enclosure_factor"), sample_normal("logit", "correlation")
    log_sd_a = sample_normal("log_sd_a", "scale_factor_sd")
    log_sd_k = sample_normal("log_sd_k", "stiffness_sd")
    count = data.vacuum.shape[0]

    def draw_curves(name: str, place: Any, log_sd: Any, quantity: str) -> Any:
        # the scatter between mountings is integrated out, so curves of one mounting are correlated
        if mounting is None:
            distribution = dist.Normal(place, jnp.exp(log_sd)).expand([count]).to_event(1)
        else:
            log_mounting_sd = sample_normal(f"log_mounting_sd_{name}", f"{quantity}_mounting_sd")
            square = jnp.exp(2 * log_sd) * jnp.eye(count) + jnp.exp(2 * log_mounting_sd) * mounting
            distribution = dist.MultivariateNormal(jnp.full(count, place), square)
        return numpyro.sample(f"own_{name}", distribution)

    own_a = draw_curves("a", log_a, log_sd_a, "scale_factor")
    own_k = draw_curves("k", log_k, log_sd_k, "stiffness")
    with numpyro.plate("curves", count):
        slack = numpyro.sample("own_slack", dist.Normal(0.0, 1.0))
        noise = sample_normal("own_noise", "residual")
    sites = Sites(log_a, log_k, log_f, log_sd_a, log_sd_k, logit, own_a, own_k, slack, noise)
    residuals = data.force - law_forces(sites, beliefs["slack"][1], data, brake)
    size = jnp.sqrt(jnp.exp(2 * noise) + FLOOR**2) * data.height
    phi = jax.nn.sigmoid(logit)
    numpyro.factor("residuals", log_likelihood(residuals, size, phi, data))


def potential(flat: Any, guess: Guess, data: Data, brake: Brake, beliefs: PriorNumbers) -> Any:
    """Return the negative log density of the posterior, up to a constant, at a flat vector."""
    from numpyro.infer.util import log_density  # type: ignore[import-untyped]

    sites = {n: x for n, x in unpack_sites(flat, guess, beliefs)._asdict().items() if x is not None}
    density, _ = log_density(numpyro_model, (data, brake, beliefs, guess.mounting), {}, sites)
    return -density - log_jacobian(flat, guess, beliefs)
