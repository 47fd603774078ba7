"""A million moves agree with the law, and none do once any line of a formula is changed."""

from __future__ import annotations

import re
import shutil

import numpy as np
import pytest

from brake.kernel.histories import history, most
from counts import cases
from layerjam.brake.device.load import load
from layerjam.brake.kernel import kernel as kernels
from layerjam.brake.kernel.compiler import SOURCES, find_compiler, run_compiler
from layerjam.brake.kernel.kernel import Kernel
from layerjam.brake.mechanics.hysteresis import brake_cycle
from strategies import one, random_brakes

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed"),
]
NAMES = ("choi2018-kapton", "choi2018-ptfe", "choi2018-polyester", "choi2018-ptfe-fiberglass")
RANDOM = tuple(range(12)), tuple(range(8))
SEEDS = cases(44, 8)


def law_of(brake, seed):
    """The history and what the law makes of it, up to where the sheets part."""
    path, vacuum = history(brake, seed)
    law = brake_cycle(path, vacuum, brake)
    void = np.asarray(law.separated) | np.asarray(law.overflow) | np.asarray(law.snapped)
    count = int((~np.logical_or.accumulate(void)).sum())
    return path, vacuum, np.asarray(law.force)[:count], np.asarray(law.heat)[:count]


def agrees(kernel, brake, known):
    path, vacuum, force, heat = known
    fast = kernel.cycle(path, vacuum)
    close = np.abs(fast.force[: len(force)] - force) <= max(1e-9, 1e-12 * force.max())
    warm = np.abs(fast.heat[: len(heat)] - heat) <= 1e-11 * max(1.0, most(brake) / 200)
    return bool(close.all() and warm.all())


@pytest.mark.parametrize("part", range(4))
def test_a_million_moves(part):
    """24 brakes, 44 histories each of 1,024 moves, or 8."""
    plain, bent = random_brakes(3, 12), random_brakes(4, 8, exponent=True)
    brakes = [load(name).brake for name in NAMES]
    brakes += [one(plain, i) for i in RANDOM[0]] + [one(bent, i) for i in RANDOM[1]]
    moves = 0
    for brake in brakes[part::4]:
        kernel = Kernel(brake)
        for seed in range(SEEDS):
            known = law_of(brake, seed)
            assert agrees(kernel, brake, known), (brake, seed)
            moves += len(known[2])
    assert moves > cases(240_000, 40_000)


SWAPS = ((" + ", " - "), (" - ", " + "), (" * ", " / "), (" / ", " * "), (" < ", " >= "))
SWAPS += ((" > ", " <= "), ("lj_max(", "lj_min("), ("lj_min(", "lj_max("), ("LJ(2)", "LJ(3)"))
EQUIVALENT = ("return (lj_enclosure){",)
"""A saturation that is too large sends the commonest slide the general way, to the same end."""


def mutants(text):
    """(line number, text) with one sign, comparison or number changed, one for each line."""
    lines = text.split("\n")
    for number, line in enumerate(lines):
        if not line.startswith("    ") or any(one in line for one in EQUIVALENT):
            continue
        for old, new in SWAPS:
            if old in line:
                changed = line.replace(old, new, 1)
                yield number, "\n".join([*lines[:number], changed, *lines[number + 1 :]])
                break


def test_a_changed_line_of_a_formula_is_noticed(tmp_path, monkeypatch):
    brakes = [load(name).brake for name in NAMES[:2]]
    known = [
        (b, seed, law_of(b, seed))
        for b in brakes
        for seed in (12, 13, 14, 15, 28, 29, 31, 7, 1, 5, 2)
    ]
    text = (SOURCES / "formulas.h").read_text("utf-8")
    for path in SOURCES.glob("*.[ch]"):
        shutil.copy(path, tmp_path)
    alive, made = [], 0
    for number, changed in mutants(text):
        (tmp_path / "formulas.h").write_text(changed, "utf-8")
        code = [str(tmp_path / path.name) for path in kernels.CODE]
        target = tmp_path / f"mutant{number}.so"
        run_compiler([*find_compiler(), "-std=c99", "-O0", "-shared", "-fPIC", *code], target)
        loaded = kernels.bind_library(target, "double")
        monkeypatch.setattr(kernels, "load_library", lambda precision, loaded=loaded: loaded)
        made += 1
        if all(agrees(Kernel(brake), brake, one) for brake, _, one in known):
            alive.append(re.sub(r"\s+", " ", changed.split("\n")[number]))
    assert made >= 4
    assert alive == [], "\n".join(alive)
