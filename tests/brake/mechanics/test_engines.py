"""One answer from every engine: NumPy, JAX and the C kernel, for each law and family of brakes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest

import layerjam.jax  # noqa: F401
from layerjam import laws
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.hyperelastic import Hyperelastic
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.kernel.compiler import find_on_path
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.simulate.batch import batch
from layerjam.core.errors import QuantityError
from layerjam.core.units import quantity, record
from layerjam.laws import Stribeck, WetFilm
from strategies import KAPTON, one, random_brakes

BRAKES, POINTS = 25, 4
CLOSE = 1e-12
ROUNDING = 1e-16
"""Rounding [J] of a heat at zero friction, which is the difference of two works."""
Family = Callable[[int], Brake]
Numbers = tuple[np.ndarray, ...]


@record
class Warmth:
    """A further effect on the friction, as a user may write one."""

    rise: float = quantity("K", "temperature above that of the friction test", hi=200)

    def friction_factor(self, vacuum: Any, brake: Brake) -> Any:
        """Return the friction relative to that without the effect."""
        return 1 - 4e-3 * self.rise


def draw(seed: int, low: float, high: float) -> np.ndarray:
    return np.random.default_rng(seed).uniform(low, high, BRAKES)


def aged(seed: int) -> Brake:
    brakes = random_brakes(seed, BRAKES)
    film = replace(
        brakes.film, ageing=draw(seed, -0.01, 0.03), static_hold=draw(seed + 1, 1.0, 100.0)
    )
    return replace(brakes, film=film, effects=(Warmth(rise=draw(seed + 2, 0.0, 50.0)),))


def rubber(seed: int, **parts: Any) -> Brake:
    soft = Hyperelastic(strain=draw(seed, 2.0, 9.0), **parts)
    return replace(random_brakes(seed, BRAKES), hyperelastic=soft)


FAMILIES: dict[str, Family] = {
    "plain": lambda seed: random_brakes(seed, BRAKES),
    "spacers or a fan": lambda seed: random_brakes(seed, BRAKES, spacers=True),
    "pressure exponent": lambda seed: replace(
        random_brakes(seed, BRAKES, exponent=True), vacuum_share=draw(seed, 0.5, 1.0)
    ),
    "fan with an exponent": lambda seed: replace(
        random_brakes(seed, BRAKES, spacers=True, exponent=True),
        amplification_held=draw(seed, 1.0, 3.0),
        lowest_pressure=draw(seed + 1, 1e3, 4e4),
    ),
    "ageing and an effect": aged,
    "speed law": lambda seed: replace(
        random_brakes(seed, BRAKES),
        speed_law=SpeedLaw(
            power=draw(seed, 0.01, 0.5),
            test_speed=draw(seed + 1, 1e-3, 0.1),
            rest_speed=draw(seed + 2, 1e-3, 0.1),
        ),
    ),
    "rubber": lambda seed: rubber(
        seed, c10=draw(seed + 1, 1e4, 1e5), c01=draw(seed + 2, 1e3, 1e4), c20=draw(seed + 3, 0, 300)
    ),
    "rubber that softens": lambda seed: rubber(
        seed,
        mu1=draw(seed + 1, 1e4, 1e5),
        alpha1=draw(seed + 2, 2.0, 3.0),
        softening_r=draw(seed + 3, 1.2, 4.0),
        softening_m=draw(seed + 4, 1e3, 1e5),
        softening_beta=draw(seed + 5, 0.0, 1.0),
    ),
}
RANGES = {
    "slip": (0.0, 0.25), "elongation": (0.0, 0.2), "travel": (0.0, 0.2), "vacuum": (0.0, 1.1e5),
    "force": (0.0, 400.0), "mass": (0.05, 20.0), "speed": (0.0, 5.0), "spring": (3e3, 5e5),
    "gravity": (0.0, 12.0), "hold": (0.0, 1e5), "length": (0.01, 0.3), "deflection": (0.0, 0.02),
    "angle": (0.0, 3.0), "friction": (0.0, 1.0), "radius": (5e-3, 0.1), "tension": (0.0, 100.0),
    "heat": (0.0, 20.0), "allowed_rise": (1.0, 40.0), "film_coefficient": (1.0, 30.0),
    "static": (1.0, 20.0), "kinetic": (0.5, 15.0), "stiffness": (1e3, 1e5), "damping": (0.0, 5.0),
    "damping_ratio": (0.0, 1.0), "drop": (0.0, 5.0), "stribeck_speed": (1e-4, 1e-2),
    "exponent": (0.5, 2.0), "scale_factor": (0.5, 2.0),
}  # fmt: skip
OUTSIDE = (-1.0, 0.0, np.nan, np.inf)
MARCHING = {("speed law", "stop"), ("speed law", "tuned_vacuum")}
"""Laws that march for one family only: JAX runs them in both cases, and one takes minutes."""
MARCHES = ("brake_cycle", "enclosure_cycle", "stop_in_time")
LAWS = {
    name: law
    for name, law in vars(laws).items()
    if inspect.isfunction(law) and law.__module__.startswith("layerjam") and name not in MARCHES
}


def cases(name: str, seed: int) -> tuple[np.ndarray, ...]:
    """Arguments of a law except the brake, shape (BRAKES, POINTS) each; a fifth is outside."""
    rng = np.random.default_rng([seed, *name.encode()])
    shape, rows = (BRAKES, POINTS), []
    for parameter in inspect.signature(LAWS[name]).parameters:
        if parameter in ("brake", "curve", "film"):
            continue
        inside = rng.uniform(*RANGES[parameter], shape)
        rows.append(np.where(rng.random(shape) < 0.1, rng.choice(OUTSIDE, shape), inside))
    return tuple(rows)


CONSTANTS = {
    "curve": Stribeck(static=0.4, kinetic=0.3, speed=1e-3, exponent=1.5, viscous=0.1),
    "film": WetFilm(static=0.3, kinetic=0.1, speed=2e-3, adhesion=300.0, viscosity=500.0),
}


def call(name: str, numbers: tuple[Any, ...], brake: Brake) -> list[Any]:
    """Return the results of a law as a list of arrays."""
    given = iter(numbers)
    parts = inspect.signature(LAWS[name]).parameters
    args = [brake if p == "brake" else CONSTANTS.get(p) or next(given) for p in parts]
    result = LAWS[name](*args)
    return list(result) if isinstance(result, tuple) else [result]


def on_numpy(name: str, numbers: Numbers, brakes: Brake) -> list[np.ndarray]:
    """Return the results of a law for one brake after the other."""
    rows = [call(name, tuple(n[i] for n in numbers), one(brakes, i)) for i in range(BRAKES)]
    columns = zip(*rows, strict=True)
    return [np.stack([np.asarray(value, float) for value in column]) for column in columns]


@jax.jit
@jax.vmap
def on_jax(numbers: dict[str, Numbers], brake: Brake) -> dict[str, list[Any]]:
    """Return the results of all laws: one program for each family."""
    return {name: call(name, given, brake) for name, given in numbers.items()}


def differences(ours: Any, others: Any) -> np.ndarray:
    """Return relative differences; infinite where only one is a number."""
    ours, others = np.broadcast_arrays(np.asarray(ours, float), np.asarray(others, float))
    with np.errstate(invalid="ignore", divide="ignore"):
        apart = np.abs(ours - others) / np.maximum(np.abs(ours), np.abs(others))
    with np.errstate(invalid="ignore"):
        same = (ours == others) | (np.abs(ours - others) < ROUNDING)
    apart = np.where(same | (np.isnan(ours) & np.isnan(others)), 0.0, apart)
    return np.where(np.isnan(ours) != np.isnan(others), np.inf, apart)


def reports(results: dict[str, list[Any]], others: dict[str, list[Any]], seed: int) -> list[str]:
    """Return a line for each result of a law that differs by more than `CLOSE`."""
    lines = []
    for name, columns in results.items():
        for place, pair in enumerate(zip(columns, others[name], strict=True)):
            apart = differences(*pair)
            if apart.max() > CLOSE:
                at = np.unravel_index(apart.argmax(), apart.shape)
                case = [float(n[at]) for n in cases(name, seed)]
                lines.append(f"{name}[{place}] {apart.max():.1e} at {at}: {case}")
    return lines


@pytest.mark.parametrize(
    ("family", "left_out"),
    [
        pytest.param("plain", ("stop",), id="plain but stops"),  # see test_first_standstill
        *(pytest.param(f, (), id=f, marks=pytest.mark.slow) for f in FAMILIES),
    ],
)
def test_numpy_and_jax_return_the_same(family: str, left_out: tuple[str, ...]) -> None:
    """And no brake's answer in a batch depends on the brakes around it, bit for bit."""
    seed = list(FAMILIES).index(family)
    brakes, plain, numbers = FAMILIES[family](seed), {}, {}
    for name in LAWS:
        if (family, name) in MARCHING or name in left_out:
            continue
        given = cases(name, seed)
        try:
            plain[name] = on_numpy(name, given, brakes)
            numbers[name] = given
        except QuantityError as err:  # the law says that it does not apply
            with pytest.raises(QuantityError, match=re.escape(str(err)[:40])):
                jax.eval_shape(jax.vmap(lambda n, b, law=name: call(law, n, b)), given, brakes)
    traced = jax.device_get(on_jax(numbers, jax.tree.map(np.asarray, brakes)))
    assert not reports(plain, traced, seed)
    # every second brake gives its place to its neighbour
    rows = np.arange(BRAKES) - np.arange(BRAKES) % 2
    mixed = jax.tree.map(lambda leaf: np.asarray(leaf)[rows], (numbers, brakes))
    moved = jax.device_get(on_jax(*mixed))
    for name, columns in traced.items():
        for alone, among in zip(columns, moved[name], strict=True):
            assert np.array_equal(alone[::2], among[::2], equal_nan=True), name


@pytest.mark.skipif(find_on_path() is None, reason="no C compiler here")
@pytest.mark.parametrize("family", ["plain", "pressure exponent"])
def test_the_kernel_returns_the_same(family: str) -> None:
    """A pull from rest in one move: the kernel, and the closed forms in NumPy."""
    seed = list(FAMILIES).index(family)
    brakes = FAMILIES[family](seed)
    for index in range(BRAKES):
        brake = one(brakes, index)
        rng = np.random.default_rng(index)
        vacuum = float(rng.uniform(0, brake.site.atmosphere))
        if laws.least_stiffness(vacuum, brake) >= brake.stiffness_measured:
            continue
        kernel = Kernel(brake)
        kernel.start(vacuum)
        end = brake.sheets.overlap + laws.brake_force(0.0, vacuum, brake) / brake.stiffness_measured
        for share in (0.0, 0.3, 0.6, 0.9):
            kernel.start(vacuum)
            case = share * float(end), vacuum
            kernel.move(*case)
            ours = [
                law(*case, brake)
                for law in (laws.force_at_elongation, laws.slip_at_elongation, laws.pull_work)
            ]
            assert differences(ours, [kernel.force, kernel.slip, kernel.work]).max() <= CLOSE


@pytest.mark.skipif(find_on_path() is None, reason="no C compiler here")
def test_the_kernel_stops_as_the_law_does() -> None:
    brakes, given = FAMILIES["plain"](0), cases("stop", 0)
    names = [p for p in inspect.signature(laws.stop).parameters if p != "brake"]
    for index in range(BRAKES):
        brake, numbers = one(brakes, index), [n[index] for n in given]
        rows = batch(
            laws.stop,
            {name: ("case", row) for name, row in zip(names, numbers, strict=True)},
            brake=brake,
        )
        plain = laws.stop(*numbers, brake)
        for field, ours in plain._asdict().items():
            assert differences(ours, rows[field]).max() <= CLOSE, (field, index)


def history(seed: int) -> tuple[np.ndarray, np.ndarray]:
    path = np.cumsum(np.random.default_rng(seed).normal(5e-4, 1e-3, 64)).clip(0)
    return path, np.full(64, 4e4)


def march(name: str) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Return a marching law and its arguments except the brake."""
    if name == "stop_in_time":
        return laws.stop_in_time, (1.0, 2.0, 5e4, None, 15e3, None, 9.8, 1e-5, 20_000.0)
    return getattr(laws, name), history(1)


@pytest.mark.slow
@pytest.mark.parametrize("name", MARCHES)
def test_marching_laws_take_numbers_and_arrays_of_jax(name: str) -> None:
    law, case = march(name)
    plain = law(*case, KAPTON)
    traced = law(jax.numpy.asarray(case[0]), *case[1:], KAPTON)
    pairs = zip(jax.tree.leaves(plain), jax.tree.leaves(traced), strict=True)
    for ours, others in pairs:
        assert isinstance(ours, np.ndarray | np.generic) and isinstance(others, jax.Array)
        assert np.array_equal(ours, others, equal_nan=True)
