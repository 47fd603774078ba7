"""NUTS in blocks, from the mode of the posterior and with its curvature as the scale.

The unknowns differ by six decades in how well they are known. They are sampled as y, flat = mode +
root y, with root root' the inverse curvature at the mode: then the posterior is round, and a few
hundred steps adapt what is left.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from layerjam.device.brake import Brake
from layerjam.identify.bayes.model import (
    Data,
    Guess,
    Known,
    Sites,
    Told,
    packed,
    potential,
    scatter_places,
    unpacked,
)

WARMUP = 300
"""Draws that adapt step and scale, and are thrown away."""
BLOCK = 50
"""Draws between two reports of progress."""
FEWEST = 2 * BLOCK
"""Draws a chain needs for Ctrl-C to keep them."""
ACCEPT = 0.9
_DEPTH = 8
_STEP = 1e-5
_AT_ONCE = 16
_COMPILE = {"xla_llvm_disable_expensive_passes": True}
"""Compiled a fifth sooner, and as fast."""
_FLATTEST = 0.3
"""Least curvature believed at the mode: about that of the widest prior."""
Array = np.ndarray[Any, Any]


@functools.cache
def _engine(warmup: int) -> tuple[Any, ...]:
    """Compiled: potential and slope at many points, the chains' start, a block of draws."""
    from numpyro.infer.hmc import hmc  # type: ignore[import-untyped]

    def whitened(center: Any, root: Any, *case: Any) -> Any:
        return lambda y: potential(center + root @ y, *case)

    begin, step = hmc(potential_fn_gen=whitened, algo="NUTS")

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def started(places: Any, keys: Any, *case: Any) -> Any:
        def one(place: Any, key: Any) -> Any:
            return begin(
                place,
                warmup,
                dense_mass=False,
                target_accept_prob=ACCEPT,
                max_tree_depth=_DEPTH,
                model_args=case,
                rng_key=key,
            )

        return jax.vmap(one)(places, keys)

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def block(states: Any, *case: Any) -> Any:
        def one(state: Any, _: Any) -> Any:
            state = step(state, case, {})
            return state, (state.z, state.diverging)

        return jax.vmap(lambda s: jax.lax.scan(one, s, None, length=BLOCK))(states)

    @functools.partial(jax.jit, compiler_options=_COMPILE)
    def many(points: Any, *case: Any) -> Any:
        return jax.lax.map(lambda p: jax.value_and_grad(potential)(p, *case), points)

    return many, started, block


def values_at(points: Array, *case: Any) -> tuple[Array, Array]:
    """Potential (n,) and slope (n, unknowns) at flat vectors, some at a time: one compilation."""
    many = _engine(WARMUP)[0]
    filled = np.concatenate([points, np.repeat(points[-1:], -len(points) % _AT_ONCE, axis=0)])
    found = [many(part, *case) for part in filled.reshape(-1, _AT_ONCE, points.shape[1])]
    heights, slopes = (np.concatenate([np.asarray(x) for x in f]) for f in zip(*found, strict=True))
    return heights[: len(points)], slopes[: len(points)]


def mode(flat: Array, *case: Any) -> tuple[Array, Array]:
    """The most probable flat vector at its scatter between repeats, and the root of the spread.

    Newton's method with every curvature taken as positive. The scatter itself is held: a joint mode
    of scatter and curves lies where all curves are alike, which is no place to begin.
    """
    free = np.ones(len(flat), bool)
    free[scatter_places(case[0].mounting is not None)] = False
    parts = 0.5 ** np.arange(_AT_ONCE - 1)
    for _ in range(60):
        slope, curve = _bent(flat, *case)
        bend, base = np.linalg.eigh(curve[np.ix_(free, free)])
        step = np.zeros_like(flat)
        step[free] = -base @ ((base.T @ slope[free]) / np.maximum(np.abs(bend), _FLATTEST))
        tries = np.concatenate([flat[None], flat + parts[:, None] * step])
        heights, _ = values_at(tries, *case)
        best = int(np.nanargmin(heights))
        flat = tries[best]
        if heights[0] - heights[best] < 1e-3:
            break
    bend, base = np.linalg.eigh(_bent(flat, *case)[1])
    return flat, base / np.sqrt(np.maximum(np.abs(bend), _FLATTEST))


def _bent(flat: Array, *case: Any) -> tuple[Array, Array]:
    """Slope and curvature, the latter from differences of slopes: exact enough for a scale."""
    steps = _STEP * np.eye(len(flat))
    points = np.concatenate([flat[None], flat + steps, flat - steps])
    _, slopes = values_at(points, *case)
    curve = (slopes[1 : 1 + len(flat)] - slopes[1 + len(flat) :]) / (2 * _STEP)
    return slopes[0], (curve + curve.T) / 2


def begun(
    first: Sites, data: Data, brake: Brake, known: Known, mounting: Array | None
) -> tuple[Array, Array, Guess]:
    """The mode, the root of the spread, and what each curve tells by itself.

    First every curve for itself, the scatter held wide; then all together, with the scatter that
    the curves' values show beyond their own errors.
    """
    flat = np.full(len(first.own_a), 0.01)
    guess = Guess(Told(first.own_a, flat), Told(first.own_k, flat), mounting)
    if mounting is not None:
        first = first._replace(log_mounting_sd_a=first.log_sd_a, log_mounting_sd_k=first.log_sd_k)
    place, root = mode(packed(first, guess, known), guess, data, brake, known)
    alone = jax.tree.map(np.asarray, unpacked(place, guess, known))
    # errors of the curves' own values: how far they move with a unit of every root's column
    tops = [unpacked(place + column, guess, known) for column in root.T]
    told = {}
    for name in ("own_a", "own_k"):
        moved = np.array([np.asarray(getattr(t, name)) for t in tops]) - getattr(alone, name)
        told[name] = Told(getattr(alone, name), np.sqrt((moved**2).sum(axis=0)))
    guess = Guess(told["own_a"], told["own_k"], mounting)
    scatter = [np.log(_scatter(t)) for t in guess[:2]]
    if mounting is not None:
        alone = alone._replace(log_mounting_sd_a=scatter[0], log_mounting_sd_k=scatter[1])
    together = alone._replace(
        log_a=guess.a.place.mean(),
        log_k=guess.k.place.mean(),
        log_sd_a=scatter[0],
        log_sd_k=scatter[1],
    )
    return *mode(packed(together, guess, known), guess, data, brake, known), guess


def _scatter(told: Told) -> float:
    """SD between curves beyond what their errors explain, kept within what repeats show."""
    if len(told.place) < 2:
        return 0.05
    beyond = float(np.var(told.place, ddof=1) - np.mean(told.error**2))
    return float(np.clip(max(beyond, 0.0) ** 0.5, 0.003, 0.5))


def sample(
    first: Sites,
    data: Data,
    brake: Brake,
    known: Known,
    *,
    draws: int,
    chains: int,
    seed: int,
    mounting: Array | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Sites, Array]:
    """Draws from the posterior, by NUTS, chains side by side; the same for the same seed.

    Returned are the unknowns, of shapes (chains, draws) and (chains, draws, curves), and (chains,
    draws) whether a path broke off. `first` is where the search for the mode begins, `mounting` as
    in a Guess. Ctrl-C keeps
    what is drawn, if that is at least `FEWEST` draws a chain; otherwise it goes on up.
    """
    data = Data(*(jnp.asarray(x) for x in data))
    center, root, guess = begun(first, data, brake, known, mounting)
    case = (jnp.asarray(center), jnp.asarray(root), guess, data, brake, known)
    *_, started, block = _engine(WARMUP)
    # chains begin apart, where the posterior's own draws lie, so that R-hat can tell
    one, keys = jax.random.split(jax.random.PRNGKey(seed))
    places = jax.random.normal(one, (chains, len(center)))
    states = started(places, jax.random.split(keys, chains), *case)
    whole = WARMUP + -(-draws // BLOCK) * BLOCK
    kept: list[tuple[Array, Array]] = []
    try:
        for done in range(BLOCK, whole + 1, BLOCK):
            states, (y, divergent) = block(states, *case)
            jax.block_until_ready(states)
            if done > WARMUP:
                kept.append((np.asarray(y), np.asarray(divergent)))
            if progress is not None:
                progress(done, whole)
    except KeyboardInterrupt:
        if len(kept) * BLOCK < FEWEST:
            raise
    y, divergent = (np.concatenate(part, axis=1)[:, :draws] for part in zip(*kept, strict=True))
    sites = unpacked(center + y @ root.T, guess, known)
    return jax.tree.map(np.asarray, sites), divergent
