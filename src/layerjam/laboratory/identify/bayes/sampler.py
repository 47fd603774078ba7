"""NUTS in blocks, started at the posterior's mode, whose curvature sets the scale.

The scales of the unknowns span six decades. They are sampled as `y`, with `flat = mode + root @ y`;
`root @ root.T` is the inverse curvature at the mode. The posterior is then round, and a few hundred
steps of adaptation suffice.
"""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.tracing import in_double_precision, jax, jnp
from layerjam.laboratory.identify.bayes.model import (
    CurveEstimates,
    Data,
    Guess,
    PriorNumbers,
    Sites,
    pack_sites,
    potential,
    scatter_indices,
    unpack_sites,
)

WARMUP = 300
"""Number of initial draws that adapt step and scale and are then discarded."""
BLOCK = 50
"""Number of draws between two progress reports."""
ACCEPT = 0.9
_DEPTH = 8
_STEP = 1e-5
_AT_ONCE = 16
_COMPILE = {"xla_llvm_disable_expensive_passes": True}
"""Compiler option that shortens compilation by a fifth; the code runs just as fast."""
_FLATTEST = 0.3
"""Lower limit of the curvature used at the mode: about that of the widest prior."""
Array = np.ndarray[Any, Any]


@functools.cache
def _compile_sampler(warmup: int) -> tuple[Any, ...]:
    """Return compiled functions: potential and slope, chain starts, and a block of draws."""
    from numpyro.infer.hmc import hmc  # type: ignore[import-untyped]

    def whiten_potential(center: Any, root: Any, *case: Any) -> Any:
        return lambda y: potential(center + root @ y, *case)

    begin, step = hmc(potential_fn_gen=whiten_potential, algo="NUTS")

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def start_chains(places: Any, keys: Any, *case: Any) -> Any:
        def start_chain(place: Any, key: Any) -> Any:
            return begin(
                place,
                warmup,
                dense_mass=False,
                target_accept_prob=ACCEPT,
                max_tree_depth=_DEPTH,
                model_args=case,
                rng_key=key,
            )

        return jax.vmap(start_chain)(places, keys)

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def draw_block(states: Any, *case: Any) -> Any:
        def advance_chain(state: Any, _: Any) -> Any:
            state = step(state, case, {})
            return state, (state.z, state.diverging)

        return jax.vmap(lambda s: jax.lax.scan(advance_chain, s, None, length=BLOCK))(states)

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def evaluate(points: Any, *case: Any) -> Any:
        return jax.lax.map(lambda p: jax.value_and_grad(potential)(p, *case), points)

    return evaluate, start_chains, draw_block


@in_double_precision
def evaluate_potential(points: Array, *case: Any) -> tuple[Array, Array]:
    """Return potential (n,) and slope (n, unknowns) at flat vectors, evaluated in equal batches."""
    evaluate = _compile_sampler(WARMUP)[0]
    padded_points = np.concatenate(
        [points, np.repeat(points[-1:], -len(points) % _AT_ONCE, axis=0)]
    )
    parts = [evaluate(part, *case) for part in padded_points.reshape(-1, _AT_ONCE, points.shape[1])]
    heights, slopes = (np.concatenate([np.asarray(x) for x in f]) for f in zip(*parts, strict=True))
    return heights[: len(points)], slopes[: len(points)]


@in_double_precision
def find_mode(flat: Array, *case: Any) -> tuple[Array, Array]:
    """Return the most probable flat vector at its scatter, and a square root of the covariance.

    It uses Newton's method with every curvature made positive. The scatter itself is fixed: in a
    joint mode of scatter and curves all curves are identical, which is a poor start.
    """
    free = np.ones(len(flat), bool)
    free[scatter_indices(case[0].mounting is not None)] = False
    parts = 0.5 ** np.arange(_AT_ONCE - 1)
    for _ in range(60):
        slope, curve = _compute_curvature(flat, *case)
        bend, base = np.linalg.eigh(curve[np.ix_(free, free)])
        step = np.zeros_like(flat)
        step[free] = -base @ ((base.T @ slope[free]) / np.maximum(np.abs(bend), _FLATTEST))
        tries = np.concatenate([flat[None], flat + parts[:, None] * step])
        heights, _ = evaluate_potential(tries, *case)
        best = int(np.nanargmin(heights))
        flat = tries[best]
        if heights[0] - heights[best] < 1e-3:
            break
    bend, base = np.linalg.eigh(_compute_curvature(flat, *case)[1])
    return flat, base / np.sqrt(np.maximum(np.abs(bend), _FLATTEST))


def _compute_curvature(flat: Array, *case: Any) -> tuple[Array, Array]:
    """Return slope and curvature; finite differences are accurate enough to set a scale."""
    steps = _STEP * np.eye(len(flat))
    points = np.concatenate([flat[None], flat + steps, flat - steps])
    _, slopes = evaluate_potential(points, *case)
    curve = (slopes[1 : 1 + len(flat)] - slopes[1 + len(flat) :]) / (2 * _STEP)
    return slopes[0], (curve + curve.T) / 2


@in_double_precision
def find_start(
    first: Sites, data: Data, brake: Brake, beliefs: PriorNumbers, mounting: Array | None
) -> tuple[Array, Array, Guess]:
    """Return the mode, the square root of the covariance, and the estimates of each curve alone.

    It first fits every curve alone, with a wide scatter. It then fits all curves together, with the
    part of the scatter that exceeds the errors of the curves' values.
    """
    small_sites = np.full(len(first.own_a), 0.01)
    guess = Guess(
        CurveEstimates(first.own_a, small_sites), CurveEstimates(first.own_k, small_sites), mounting
    )
    if mounting is not None:
        first = first._replace(log_mounting_sd_a=first.log_sd_a, log_mounting_sd_k=first.log_sd_k)
    place, root = find_mode(pack_sites(first, guess, beliefs), guess, data, brake, beliefs)
    values = jax.tree.map(np.asarray, unpack_sites(place, guess, beliefs))
    # errors of the per-curve values: their change per unit along each column of the matrix root
    tops = [unpack_sites(place + column, guess, beliefs) for column in root.T]
    estimates = {}
    for name in ("own_a", "own_k"):
        shifts = np.array([np.asarray(getattr(t, name)) for t in tops]) - getattr(values, name)
        estimates[name] = CurveEstimates(getattr(values, name), np.sqrt((shifts**2).sum(axis=0)))
    guess = Guess(estimates["own_a"], estimates["own_k"], mounting)
    scatter = [np.log(_estimate_curve_scatter(t)) for t in guess[:2]]
    if mounting is not None:
        values = values._replace(log_mounting_sd_a=scatter[0], log_mounting_sd_k=scatter[1])
    together = values._replace(
        log_a=guess.a.place.mean(),
        log_k=guess.k.place.mean(),
        log_sd_a=scatter[0],
        log_sd_k=scatter[1],
    )
    return *find_mode(pack_sites(together, guess, beliefs), guess, data, brake, beliefs), guess


def _estimate_curve_scatter(estimate: CurveEstimates) -> float:
    """Return the SD between curves in excess of their errors, limited to plausible values."""
    if len(estimate.place) < 2:
        return 0.05
    excess = float(np.var(estimate.place, ddof=1) - np.mean(estimate.error**2))
    return float(np.clip(max(excess, 0.0) ** 0.5, 0.003, 0.5))


@in_double_precision
def sample_posterior(
    first: Sites,
    data: Data,
    brake: Brake,
    beliefs: PriorNumbers,
    *,
    draws: int,
    chains: int,
    seed: int,
    mounting: Array | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Sites, Array]:
    """Draw from the posterior by NUTS with parallel chains; the same seed produces the same draws.

    Returns the unknowns, shapes (chains, draws) and (chains, draws, curves), and whether a path
    diverged, shape (chains, draws). The search for the mode starts at `first`; `mounting` is that
    of a Guess.
    """
    data = Data(*(jnp.asarray(x) for x in data))
    center, root, guess = find_start(first, data, brake, beliefs, mounting)
    case = (jnp.asarray(center), jnp.asarray(root), guess, data, brake, beliefs)
    *_, start_chains, draw_block = _compile_sampler(WARMUP)
    # chains begin at different points of the posterior, so that R-hat can detect disagreement
    key, keys = jax.random.split(jax.random.PRNGKey(seed))
    places = jax.random.normal(key, (chains, len(center)))
    states = start_chains(places, jax.random.split(keys, chains), *case)
    total = WARMUP + -(-draws // BLOCK) * BLOCK
    blocks: list[tuple[Array, Array]] = []
    for count in range(BLOCK, total + 1, BLOCK):
        states, (y, divergent) = draw_block(states, *case)
        jax.block_until_ready(states)
        if count > WARMUP:
            blocks.append((np.asarray(y), np.asarray(divergent)))
        if progress is not None:
            progress(count, total)
    y, divergent = (np.concatenate(part, axis=1)[:, :draws] for part in zip(*blocks, strict=True))
    sites = unpack_sites(center + y @ root.T, guess, beliefs)
    return jax.tree.map(np.asarray, sites), divergent
