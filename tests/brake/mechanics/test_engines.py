"""One answer from every engine: NumPy, JAX and the C kernel, for each law and family of brakes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from typing import Any

import jax
import numpy as np
import pytest

import layerjam.jax  # noqa: F401
from counts import FULL
from law_cases import (
    BRAKES,
    FAMILIES,
    LAWS,
    MARCHES,
    MARCHING,
    Numbers,
    call,
    cases,
    on_numpy,
)
from layerjam import laws
from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.compiler import find_on_path
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.simulate.batch import batch
from layerjam.core.errors import QuantityError
from strategies import KAPTON, one

CLOSE = 1e-12
COMBINED = ("fan with an exponent", "rubber")
"""Families whose parts are in others; the program of each takes minutes to compile."""
ALIKE = {
    "rubber that softens": ("time_at_slip", "speed_at_slip", "vacuum_eq10"),
    "spacers or a fan": ("time_at_slip", "speed_at_slip"),
}
"""Laws that a family shares with others but for its forces; they compile longest."""
ROUNDING = 1e-16
"""Rounding [J] of a heat at zero friction, which is the difference of two works."""


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


@pytest.mark.slow
@pytest.mark.parametrize("family", [f for f in FAMILIES if FULL or f not in COMBINED])
def test_numpy_and_jax_return_the_same(family: str) -> None:
    """And no brake's answer in a batch depends on the brakes around it, bit for bit."""
    seed = list(FAMILIES).index(family)
    brakes, plain, numbers = FAMILIES[family](seed), {}, {}
    for name in LAWS:
        if (family, name) in MARCHING or (not FULL and name in ALIKE.get(family, ())):
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
        assert differences(ours, others).max() <= CLOSE  # compiled with and without fusing
