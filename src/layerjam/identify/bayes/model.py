"""The hierarchical model of many pulls: what its data are, its priors, its likelihood.

Every curve has its own scale factor, stiffness, slack and residual; scale factors and stiffnesses
scatter about the brake's, and all curves share the factor on the enclosure's force. Curves of one
mounting share a part of that scatter.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.identify.curves import Curve, fitted_part
from layerjam.identify.pull.features import LINEAR
from layerjam.identify.shape import with_shape
from layerjam.identify.stick_slip import noise_of
from layerjam.mechanics.pull import brake_force, force_at_elongation
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.units import show

RISE, SLIDE = 24, 72
"""Bins of equal elongation over the straight rise and over the sliding part."""
SLIDES = 1.25
"""Sliding counts from this times the elongation at which the rise would reach the peak."""
FEWEST_BINS = 12
"""Bins with samples that the sliding part needs."""
FLOOR = 2e-4
"""Least residual SD over the greatest force: no load cell of a test machine is better."""
RULE = (
    f"each curve is reduced to at most {RISE} means over its rise ({LINEAR[0]:.0%} to "
    f"{LINEAR[1]:.0%} of the greatest force) and {SLIDE} over its sliding part (from {SLIDES:g} "
    "times the elongation at which the rise would reach the greatest force); what lies between, "
    "where sheets let go one after another, is left out. Residuals of neighbouring means are "
    "correlated (first-order autoregressive, one coefficient for all curves); each curve has its "
    f"own SD of them, not less than {FLOOR:.2%} of its greatest force"
)
Array = np.ndarray[Any, Any]
Known = Mapping[str, tuple[Any, Any]]
"""(mean, SD) of every prior on the scale it is normal on."""


class Prior(NamedTuple):
    """A normal prior of a quantity, or (`log`) of its natural logarithm."""

    center: float
    """The median, in the quantity's unit."""
    sd: float
    """Of the logarithm where `log`, otherwise in the quantity's unit."""
    why: str
    unit: str = "1"
    log: bool = True

    def text(self) -> str:
        """The prior in words."""
        if not self.log:
            return f"{show(self.center, self.unit)} ± {show(self.sd, self.unit)}"
        return f"{show(self.center, self.unit)} within a factor of {np.exp(self.sd):.3g}"

    @property
    def place(self) -> float:
        """Mean on the scale it is normal on."""
        return float(np.log(self.center)) if self.log else self.center


def priors(brake: Brake, mounted: bool = False) -> dict[str, Prior]:
    """Every prior of the model, for a brake, by the name of its quantity; the only place.

    With those of the scatter between mountings if curves are `mounted` together.
    """
    stiffness = float(working_stiffness(brake))
    spring = Prior(stiffness, 0.7, "the brake file's, perhaps in another rig", "N/m")
    if brake.stiffness_measured is None:
        spring = Prior(stiffness / 2, 1.2, "half of the sheets' own: rigs are softer", "N/m")
    moduli = (
        "moduli published for one silicone differ 1.6 and 2.3 times (catalogue: Ecoflex 00-50, "
        "00-30), its friction is taken as known within 1.5; the force goes with the root"
    )
    films = "the brake file's; the paper's two films differ 1.4 times"
    repeat = (
        "films repeat within 3 to 8 % (paper, table I); so wide that three repeats give about "
        "Student's interval"
    )
    slack = "a curve's zero is already where its rise begins"
    law = "part of the greatest force: from a good load cell to a law that is 10 % off"
    alike = "the logit of the correlation of neighbouring means: 0.05 to 0.95"
    between = Prior(0.05, 2.0, "as between repeats: a mounting has its own grips and friction")
    shared = {"scale_factor_mounting_sd": between, "stiffness_mounting_sd": between}
    return {
        "scale_factor": Prior(float(brake.scale_factor), 0.5, films),
        "stiffness": spring,
        "enclosure_factor": Prior(1.0, 0.4, moduli),
        "scale_factor_sd": Prior(0.05, 2.0, repeat),
        "stiffness_sd": Prior(0.05, 2.0, "as for the scale factor"),
        "slack": Prior(0.0, 1e-4, slack, "m", log=False),
        "residual": Prior(0.005, 1.5, law),
        "correlation": Prior(0.0, 1.5, alike, log=False),
        **(shared if mounted else {}),
    }


class Data(NamedTuple):
    """Reduced curves, shapes (curves, bins) and (curves,); what the likelihood is given."""

    elongation: Any
    force: Any
    white: Any
    """Standard deviation of a bin's mean from the noise between samples [N]."""
    first: Any
    """True where a bin's residual has no neighbour before it."""
    real: Any
    """False for bins that only fill up the shape."""
    vacuum: Any
    height: Any
    """Greatest force of each curve [N]."""


def reduced(curves: Sequence[Curve]) -> Data:
    """The data of the model from curves, by `RULE`.

    Raises FitError for a curve without vacuum or one that does not slide long enough.
    """
    shape = (len(curves), RISE + SLIDE)
    u, force, white = np.full(shape, 1e-3), np.zeros(shape), np.zeros(shape)
    first, real = np.ones(shape, bool), np.zeros(shape, bool)
    for row, curve in enumerate(curves):
        pieces = _pieces(curve)
        n = sum(len(p[0]) for p in pieces)
        u[row, :n], force[row, :n] = (np.concatenate([p[i] for p in pieces]) for i in (0, 1))
        count = np.concatenate([p[2] for p in pieces])
        white[row, :n] = noise_of(curve.force) / np.sqrt(count)
        first[row, :n] = np.concatenate([np.arange(len(p[0])) == 0 for p in pieces])
        real[row, :n] = True
    height = np.array([c.pull.peak_force for c in curves])
    return Data(u, force, white, first, real, np.array([c.vacuum for c in curves]), height)


def _pieces(curve: Curve) -> list[tuple[Array, Array, Array]]:
    """Rise and sliding part as means over stretches; one piece where no rise is straight."""
    if curve.vacuum <= 0:
        raise FitError.of(curve.path, f"at {show(curve.vacuum, 'Pa')} of vacuum no sheet is jammed")
    pull, u, force = curve.pull, curve.elongation, curve.force
    begun = fitted_part(curve)
    if pull.straight:
        rise = force[: int(np.argmax(force)) + 1]
        below = np.flatnonzero(rise <= LINEAR[1] * pull.peak_force)
        end = int(below[-1]) + 1 if len(below) else 0
        slides = u > SLIDES * pull.peak_force / pull.stiffness
        pieces = [
            _means(u[begun.start : end], force[begun.start : end], RISE),
            _means(u[slides], force[slides], SLIDE),
        ]
    else:
        pieces = [_means(u[begun], force[begun], SLIDE)]
    found = len(pieces[-1][0])
    if found < FEWEST_BINS:
        raise FitError.of(
            curve.path,
            f"has {found} of {SLIDE} stretches with samples after it began to "
            f"slide; at least {FEWEST_BINS} are needed (pull further, or sample faster)",
        )
    return [p for p in pieces if len(p[0])]


def _means(u: Array, force: Array, bins: int) -> tuple[Array, Array, Array]:
    """Means over stretches of equal elongation, and their samples; empty ones are left out."""
    if len(u) == 0:
        return u, force, u
    low, high = float(u.min()), float(u.max())
    place = ((u - low) / max(high - low, 1e-12) * bins).astype(int).clip(0, bins - 1)
    count = np.bincount(place, minlength=bins)
    some = count > 0
    mean_u = np.bincount(place, u, bins)[some] / count[some]
    return mean_u, np.bincount(place, force, bins)[some] / count[some], count[some]


class Sites(NamedTuple):
    """The model's unknowns on the scales they are normal on: 6 numbers and 4 of each curve.

    If curves share mountings, the scatter between these too.
    """

    log_a: Any
    log_k: Any
    log_f: Any
    log_sd_a: Any
    log_sd_k: Any
    logit: Any
    own_a: Any
    """Logarithm of each curve's scale factor, (..., curves), as all below."""
    own_k: Any
    own_slack: Any
    """Over the prior's SD."""
    own_noise: Any
    """Logarithm of the residual's SD over the greatest force."""
    log_mounting_sd_a: Any = None
    log_mounting_sd_k: Any = None


def scatter_places(mounted: bool) -> list[int]:
    """Places of the scatter between repeats, and between mountings, in the flat vector."""
    return [3, 4, *([-2, -1] if mounted else [])]


class Told(NamedTuple):
    """What the curves alone tell of one quantity's logarithm: places and errors, (curves,)."""

    place: Any
    error: Any


class Guess(NamedTuple):
    """About where the curves' own values lie; they steer the sampler and change no result."""

    a: Told
    k: Told
    mounting: Any = None
    """Whether curves share a mounting, (curves, curves); None if no two do."""


class _Way(NamedTuple):
    """How the unknowns of one quantity follow from unit normal ones, at a scatter."""

    brake: Any
    brake_sd: Any
    own_pull: Any
    """Part by which a curve's own value is drawn to the brake's."""
    own_sd: Any


def _way(told: Told, log_scatter: Any, log_shared: Any, guess: Guess, prior: Any) -> _Way:
    """Were the curves' values told by normal errors, these would be exact conditionals.

    With mountings only nearly so, which is as good: any unique map will do.
    """
    scatter, error = jnp.exp(2 * log_scatter)[..., None], told.error**2
    each, curves = scatter + error, 1.0
    if guess.mounting is not None:
        shared = jnp.exp(2 * log_shared)[..., None]
        scatter, each, curves = scatter + shared, each + shared, guess.mounting.sum(axis=-1)
        weight = 1 / (each + (curves - 1) * shared)
    else:
        weight = 1 / each
    whole = weight.sum(axis=-1) + prior[1] ** -2.0
    place = ((weight * told.place).sum(axis=-1) + prior[0] * prior[1] ** -2.0) / whole
    return _Way(place, whole**-0.5, error / each, jnp.sqrt(scatter * error / each))


def _ways(sites: Sites, guess: Guess, known: Known) -> tuple[_Way, _Way]:
    a, k = sites.log_mounting_sd_a, sites.log_mounting_sd_k
    return (
        _way(guess.a, sites.log_sd_a, a, guess, known["scale_factor"]),
        _way(guess.k, sites.log_sd_k, k, guess, known["stiffness"]),
    )


def unpacked(flat: Any, guess: Guess, known: Known) -> Sites:
    """The unknowns from flat vectors, shape (..., 6 + 4 curves), or 2 more with mountings.

    The flat vector holds the brake's and the curves' own values in units of what is left open at
    each scatter between repeats. So they do not depend on the scatter, and a sampler follows it
    from "all alike" to "nothing in common", where it would stick in the values themselves.
    """
    sites = _raw(flat, guess)
    made = {}
    for way, name in zip(_ways(sites, guess, known), "ak", strict=True):
        told = getattr(guess, name)
        brake = way.brake + way.brake_sd * getattr(sites, f"log_{name}")
        drawn = (1 - way.own_pull) * told.place + way.own_pull * brake[..., None]
        made[f"log_{name}"] = brake
        made[f"own_{name}"] = drawn + way.own_sd * getattr(sites, f"own_{name}")
    return sites._replace(**made)


def packed(sites: Sites, guess: Guess, known: Known) -> Array:
    """One flat vector; the inverse of `unpacked`."""
    made = {}
    for way, name in zip(_ways(sites, guess, known), "ak", strict=True):
        told, brake = getattr(guess, name), getattr(sites, f"log_{name}")
        drawn = (1 - way.own_pull) * told.place + way.own_pull * brake
        made[f"log_{name}"] = (brake - way.brake) / way.brake_sd
        made[f"own_{name}"] = (getattr(sites, f"own_{name}") - drawn) / way.own_sd
    parts = [x for x in sites._replace(**made) if x is not None]
    return np.concatenate([np.atleast_1d(np.asarray(x, float)) for x in parts])


def log_stretch(flat: Any, guess: Guess, known: Known) -> Any:
    """Logarithm of how much larger a step of the unknowns is than one of the flat vector."""
    ways = _ways(_raw(flat, guess), guess, known)
    return sum(jnp.log(w.brake_sd) + jnp.log(w.own_sd).sum(axis=-1) for w in ways)


def _raw(flat: Any, guess: Guess) -> Sites:
    mounted = guess.mounting is not None
    shared = [flat[..., -2], flat[..., -1]] if mounted else []
    own = flat[..., 6 : -2 if mounted else None].reshape((*flat.shape[:-1], 4, -1))
    return Sites(*(flat[..., i] for i in range(6)), *(own[..., i, :] for i in range(4)), *shared)


def start(data: Data, curves: Sequence[Curve], brake: Brake) -> Sites:
    """Where the search begins: the law through the sliding part of each curve, enclosure as stated.

    With a scatter so wide that every curve is free of the others.
    """
    center = priors(brake)["stiffness"].center
    spring = np.array([c.pull.stiffness if c.pull.straight else center for c in curves])
    vacuum = data.vacuum[:, None]
    slip = np.clip(data.elongation - data.force / spring[:, None], 0.0, None)
    late = data.real & (slip > 0.02 * brake.sheets.overlap)
    with_one = np.asarray(brake_force(slip, vacuum, brake))
    loose = with_shape(brake, 0.0, brake.stiffness_measured, 1.0)
    sleeve = np.asarray(brake_force(slip, vacuum, loose))
    sheets = np.where(late, with_one - sleeve, 0.0).sum(axis=1)
    rest = np.where(late, data.force - sleeve, 0.0).sum(axis=1)
    ratio = np.divide(rest, sheets, out=np.ones_like(rest), where=sheets > 0)
    factor = np.log(brake.scale_factor * np.clip(ratio, 0.05, 20.0))
    flat = np.zeros(len(curves))
    own_k = np.log(spring)
    wide = np.log(0.3)
    return Sites(
        factor.mean(), own_k.mean(), 0.0, wide, wide, 0.0, factor, own_k, flat, flat + np.log(0.01)
    )


def forces(sites: Sites, slack_sd: Any, data: Data, brake: Brake) -> Any:
    """The law's force [N] in every bin, shape (curves, bins); zero before the slack is taken up."""
    shaped = with_shape(
        brake, jnp.exp(sites.own_a)[:, None], jnp.exp(sites.own_k)[:, None], jnp.exp(sites.log_f)
    )
    taut = jnp.maximum(data.elongation - (slack_sd * sites.own_slack)[:, None], 0.0)
    return force_at_elongation(taut, data.vacuum[:, None], shaped)


def log_likelihood(rest: Any, size: Any, phi: Any, data: Data) -> Any:
    """Of residuals [N] (curves, bins) with stationary SD `size` [N] (curves,) and correlation phi.

    What a residual adds to its neighbour's has the variance size^2 (1 - phi^2), and that of the
    mean's own noise on top.
    """
    before = jnp.concatenate([jnp.zeros_like(rest[:, :1]), rest[:, :-1]], axis=1)
    new = jnp.where(data.first, rest, rest - phi * before)
    fresh = size[:, None] ** 2 * jnp.where(data.first, 1.0, 1 - phi**2) + data.white**2
    each = -0.5 * (new**2 / fresh + jnp.log(fresh))
    return jnp.where(data.real, each, 0.0).sum()


def known_of(brake: Brake, mounted: bool = False) -> dict[str, tuple[float, float]]:
    """The priors as the model takes them."""
    return {name: (p.place, p.sd) for name, p in priors(brake, mounted).items()}


def model(data: Data, brake: Brake, known: Known, mounting: Any = None) -> None:
    """The model as NumPyro takes it; `mounting` as in a Guess."""
    import numpyro  # type: ignore[import-untyped]
    import numpyro.distributions as dist  # type: ignore[import-untyped]

    def normal(site: str, name: str) -> Any:
        return numpyro.sample(site, dist.Normal(*known[name]))

    log_a, log_k = normal("log_a", "scale_factor"), normal("log_k", "stiffness")
    log_f, logit = normal("log_f", "enclosure_factor"), normal("logit", "correlation")
    log_sd_a = normal("log_sd_a", "scale_factor_sd")
    log_sd_k = normal("log_sd_k", "stiffness_sd")
    count = data.vacuum.shape[0]

    def own(name: str, place: Any, log_sd: Any, quantity: str) -> Any:
        # the scatter between mountings is integrated out: curves of one are correlated
        if mounting is None:
            scattered = dist.Normal(place, jnp.exp(log_sd)).expand([count]).to_event(1)
        else:
            shared = normal(f"log_mounting_sd_{name}", f"{quantity}_mounting_sd")
            square = jnp.exp(2 * log_sd) * jnp.eye(count) + jnp.exp(2 * shared) * mounting
            scattered = dist.MultivariateNormal(jnp.full(count, place), square)
        return numpyro.sample(f"own_{name}", scattered)

    own_a = own("a", log_a, log_sd_a, "scale_factor")
    own_k = own("k", log_k, log_sd_k, "stiffness")
    with numpyro.plate("curves", count):
        slack = numpyro.sample("own_slack", dist.Normal(0.0, 1.0))
        noise = normal("own_noise", "residual")
    sites = Sites(log_a, log_k, log_f, log_sd_a, log_sd_k, logit, own_a, own_k, slack, noise)
    rest = data.force - forces(sites, known["slack"][1], data, brake)
    size = jnp.sqrt(jnp.exp(2 * noise) + FLOOR**2) * data.height
    phi = jax.nn.sigmoid(logit)
    numpyro.factor("residuals", log_likelihood(rest, size, phi, data))


def potential(flat: Any, guess: Guess, data: Data, brake: Brake, known: Known) -> Any:
    """Negative logarithm of the posterior's density, up to a constant, at a flat vector."""
    from numpyro.infer.util import log_density  # type: ignore[import-untyped]

    sites = {n: x for n, x in unpacked(flat, guess, known)._asdict().items() if x is not None}
    density, _ = log_density(model, (data, brake, known, guess.mounting), {}, sites)
    return -density - log_stretch(flat, guess, known)
