"""Random brakes: thousands at once as stacked leaves of one record, or one for hypothesis."""

from __future__ import annotations

import copy
import itertools
from typing import Any

import jax
import numpy as np
from hypothesis import strategies as st

import layerjam.jax  # noqa: F401
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.enclosure import Enclosure
from layerjam.brake.device.load import load
from layerjam.brake.device.mount import Mount, Site
from layerjam.brake.device.sheets import Film, Sheets
from layerjam.laboratory.identify.curves import Curve

KAPTON = load("choi2018-kapton").brake
PTFE = load("choi2018-ptfe").brake
BARE_CURVE = Curve(
    elongation=np.zeros(1),
    force=np.zeros(1),
    path="",
    vacuum=0.0,
    seating=None,
    **dict.fromkeys(("has_peak", "straight"), False),
    **dict.fromkeys(("stiffness", "stiffness_se", "noise", "origin", "seating_se"), 0.0),
    **{f"peak_{name}": 0.0 for name in ("force", "force_se", "elongation", "sample", "misfit")},
    **dict.fromkeys(("peak_samples", "rise_samples"), 0),
)
"""A pull whose own curve and features do not matter."""

seeds = st.integers(0, 2**32 - 1)


def _spread(rng: np.random.Generator, n: int, lo: float, hi: float) -> np.ndarray:
    return np.exp(rng.uniform(np.log(lo), np.log(hi), n))


def random_brakes(
    seed: int, n: int, *, exponent: bool = False, measured: bool = True, spacers: bool = False
) -> Brake:
    """`n` brakes in one record whose every leaf has shape (n,); all of them pass `validate`.

    A measured stiffness lies 1.2 to 50 times above the friction's slope c at full vacuum, so that
    none of them snaps. `spacers`: every fourth has some, the others fan out, with an exponent of
    their fan up to 2 and a slope up to 0.3.
    """
    rng = np.random.default_rng(seed)
    overlap = _spread(rng, n, 0.01, 0.2)
    left, right = _spread(rng, n, 1e-3, 0.05), _spread(rng, n, 1e-3, 0.05)
    count, width = rng.integers(2, 30, n), _spread(rng, n, 5e-3, 0.06)
    kinetic, scale = _spread(rng, n, 0.03, 0.8), _spread(rng, n, 0.4, 2.5)
    atmosphere = rng.uniform(6e4, 1.1e5, n)
    power = rng.uniform(-0.4, 0.8, n) if exponent else None
    test = _spread(rng, n, 2e3, 5e4) if exponent else None
    c = scale * kinetic * (count - 1) * width * atmosphere
    if exponent:
        c = c * (atmosphere / test) ** power
    stiffness = np.maximum(c * _spread(rng, n, 1.2, 50), 100.0)
    thickness = _spread(rng, n, 5e-5, 1e-3)
    if spacers:
        strength = rng.uniform(0.02, 2, n) / (scale * kinetic * (1 / left + 1 / right))
        thickness = np.minimum(strength / (count / 4) ** 2, 1.2 * np.minimum(left, right) / count)
        shortest = np.minimum(left, right)
        # no factor of such a fan falls faster than twice its own size over the free length
        stiffness = stiffness * 9 * (1 + 2 * overlap / shortest)
    return Brake(
        sheets=Sheets(
            count=count,
            width=width,
            thickness=thickness,
            length=overlap + np.maximum(left, right) + 0.02,
            overlap=overlap,
            free_left=left,
            free_right=right,
            usable_travel=overlap * rng.uniform(0.3, 1, n),
        ),
        film=Film(
            modulus=_spread(rng, n, 1e8, 1e10),
            density=_spread(rng, n, 900, 2500),
            static=kinetic * rng.uniform(1, 2, n),
            kinetic=kinetic,
            friction_on_silicone=_spread(rng, n, 0.05, 1.5),
        ),
        enclosure=Enclosure(
            wall=_spread(rng, n, 3e-4, 4e-3),
            modulus=_spread(rng, n, 2e4, 1e6),
            density=_spread(rng, n, 900, 1300),
        ),
        mount=Mount(
            clamped_length=np.full(n, 0.006),
            screw_hole=width / 4,
            screws=np.arange(n) % 3 + 1,
            spacers=np.arange(n) % 4 == 0 if spacers else None,
        ),
        fittings_mass=np.full(n, 0.012),
        scale_factor=scale,
        amplification_held=rng.uniform(1, 1.3, n) if spacers else None,
        stiffness_measured=stiffness if measured else None,
        pressure_exponent=power,
        test_pressure=test,
        site=Site(atmosphere=atmosphere, gravity=np.full(n, 9.81)),
    )


def with_fields_of(brake: Brake, brakes: Brake) -> Brake:
    """The stack of brakes with just the fields that a brake states: JAX compiles once for both."""
    stated = {
        jax.tree_util.keystr(path): leaf
        for path, leaf in jax.tree_util.tree_leaves_with_path(brakes)
    }
    paths, tree = jax.tree_util.tree_flatten_with_path(brake)
    count = len(brakes.scale_factor)
    filled = [stated.get(jax.tree_util.keystr(path), np.full(count, leaf)) for path, leaf in paths]
    return jax.tree.unflatten(tree, filled)


def one(brakes: Brake, index: int) -> Brake:
    """Brake number `index` out of a stack, with plain Python numbers."""
    return jax.tree.map(lambda leaf: leaf[index].item(), brakes)


def points(seed: int, brakes: Brake) -> tuple[np.ndarray, np.ndarray]:
    """A slip within the overlap and a vacuum within the site's, one for each brake."""
    rng = np.random.default_rng(seed + 1)
    n = len(brakes.scale_factor)
    return (
        brakes.sheets.overlap * rng.uniform(1e-3, 0.999, n),
        brakes.site.atmosphere * rng.uniform(1e-3, 0.999, n),
    )


def unchecked(record: Any, **values: Any) -> Any:
    """The record with other values, beyond the bounds of a file too, as for a limit of a law."""
    other = copy.copy(record)
    other.__dict__.update(values)
    return other


def change(brake: Brake, **values: Any) -> Brake:
    """The brake with other values: ``change(brake, film__kinetic=0.1)``."""
    for path, value in values.items():
        head, _, key = path.partition("__")
        if key:
            inner = unchecked(getattr(brake, head), **{key: value})
            brake = unchecked(brake, **{head: inner})
        else:
            brake = unchecked(brake, **{head: value})
    return brake


def stretched(brake: Brake, length: float) -> Brake:
    """The same brake in a length unit `length` times smaller (1000: mm, N, MPa, N/mm, N mm)."""
    per_area, per_length = length**-2, 1 / length
    sheets = {
        key: getattr(brake.sheets, key) * length
        for key in ("width", "thickness", "length", "overlap", "free_left", "free_right")
    }
    sheets["usable_travel"] = brake.sheets.usable_travel * length
    stiffness, test = brake.stiffness_measured, brake.test_pressure
    return unchecked(
        brake,
        sheets=unchecked(brake.sheets, **sheets),
        film=unchecked(brake.film, modulus=brake.film.modulus * per_area),
        enclosure=unchecked(
            brake.enclosure,
            wall=brake.enclosure.wall * length,
            modulus=brake.enclosure.modulus * per_area,
        ),
        mount=unchecked(brake.mount, screw_hole=brake.mount.screw_hole * length),
        stiffness_measured=None if stiffness is None else stiffness * per_length,
        test_pressure=None if test is None else test * per_area,
        site=unchecked(brake.site, atmosphere=brake.site.atmosphere * per_area),
    )


def fine(*turns: float, n: int = 400) -> np.ndarray:
    """A path through the turning points, dense just after each of them (roots start there)."""
    s = np.linspace(0, 1, n + 1)[1:] ** 3
    legs = [np.array([turns[0]])]
    legs += [a + (b - a) * s for a, b in itertools.pairwise(turns)]
    return np.concatenate(legs)


def area(force: Any, way: Any) -> np.ndarray:
    """Running trapezoidal integral of force over way, starting at 0."""
    force, way = np.asarray(force), np.asarray(way)
    return np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(way))])


LENGTHS = (64, 4096, 16384)


def padded(
    path: Any, vacuum: Any, lengths: tuple[int, ...] = LENGTHS
) -> tuple[np.ndarray, np.ndarray, int]:
    """A history brought to one of few lengths by standing still: each length compiles once."""
    path = np.atleast_1d(np.asarray(path, float))
    vacuum = np.broadcast_to(np.asarray(vacuum, float), path.shape)
    length = next(size for size in lengths if size >= len(path))
    more = (0, length - len(path))
    return np.pad(path, more, "edge"), np.pad(vacuum, more, "edge"), len(path)
