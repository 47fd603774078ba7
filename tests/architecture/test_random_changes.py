"""`make mutants`: what it draws, which tests it selects, and what it notices."""

from __future__ import annotations

import ast
import os
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("coverage")  # only where all packages of the lock are installed
import mutant_map
import mutants
from mutant_draw import (
    FOLDERS,
    Mutant,
    draw,
    mutate,
    mutate_c,
    mutate_python,
    read_sources,
)
from mutant_farm import Farm

TEST = "tests/brake/fluid/test_pump_curve.py"
FILE = "brake/fluid/pump_curve.py"


@pytest.fixture(scope="module")
def sources() -> dict[str, str]:
    return read_sources()


@pytest.fixture(scope="module")
def every(sources: dict[str, str]) -> list[Mutant]:
    return mutate(sources)


@pytest.mark.slow
def test_a_seed_draws_the_same_sample(every: list[Mutant]) -> None:
    assert draw(every, 50, 7) == draw(every[::-1], 50, 7)
    assert draw(every, 20, 7) == draw(every, 50, 7)[:20]
    assert not set(draw(every, 50, 7)) & set(draw(every, 50, 8))


@pytest.mark.slow
def test_each_folder_has_mutants(every: list[Mutant]) -> None:
    counts = Counter(mutant.folder for mutant in every)
    assert set(counts) == set(FOLDERS) and min(counts.values()) > 200
    assert len(set(every)) == len(every)


@pytest.mark.slow
def test_every_mutant_changes_its_file_and_parses(
    every: list[Mutant], sources: dict[str, str]
) -> None:
    for mutant in draw(every, 60, 1):
        source = sources[mutant.file]
        changed = mutant.apply(source)
        assert mutant.changed_line(source) != source.splitlines()[mutant.line - 1].strip(), mutant
        if mutant.file.endswith(".py"):
            assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse(source)), mutant


def test_only_code_of_c_is_changed() -> None:
    text = "#define A (1 + 2)\n/* 1 + 2 */ // 4 - 5\n  double x[3];\n"
    text += 'puts("6 * 7"); y = -a * *p - 8e-3;\n'
    assert [one.apply(text).splitlines()[3][15:] for one in mutate_c("a.c", text)] == [
        "y =  a * *p - 8e-3;",
        "y = -a / *p - 8e-3;",
        "y = -a * *p + 8e-3;",
        "y = -a * *p - (8e-3 + 1);",
    ]


def test_a_statement_ends_before_its_body() -> None:
    text = "if (\n    a < 1\n):\n    b = 2\n"
    assert {m.text: m.statement for m in mutate_python("a.py", text)} == {
        "(a >= 1)": (1, 3),
        "(2)": (1, 3),
        "(3)": (4, 4),
    }


@pytest.mark.parametrize(
    ("part", "low", "high"), [(0, 0.0, 0.0370), (90, 0.8256, 0.9448), (100, 0.9630, 1.0)]
)
def test_the_interval_is_that_of_wilson(part: int, low: float, high: float) -> None:
    assert mutants.wilson(part, 100) == pytest.approx((low, high), abs=5e-5)


def test_lines_follow_a_changed_source() -> None:
    record = object.__new__(mutant_map.Record)
    record.sources = {"a.py": "x = 1\ny = 2\nz = 3\n"}
    assert record.old_lines("a.py", "# new\nx = 1\ny = 5\nz = 3\n") == {2: 1, 4: 3}


@pytest.mark.slow
@pytest.mark.timing
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the copies' processes are forked")
def test_a_planted_change_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, sources: dict[str, str]
) -> None:
    """A record of one file of tests selects those that execute the line; one of them fails."""
    monkeypatch.setattr(mutant_map, "STORE", tmp_path)
    mutant_map.record([TEST], 1)
    known = mutant_map.Map.read()
    assert TEST not in known.new_files()
    changes = list(mutate_python(FILE, sources[FILE]))
    lines = sources[FILE].splitlines()
    planted = next(m for m in changes if "flow_after - flow_before" in lines[m.line - 1])
    tests = known.tests_of(planted, sources[FILE], 30.0, 0.0)
    assert tests and all(test.startswith(TEST) for test in tests)
    (tmp_path / "farm").mkdir()
    farm = Farm(tmp_path / "farm", sources, 1)
    result = farm.try_out(planted, tests)
    assert (result.outcome, result.test in tests) == ("failed", True)
    source = sources[FILE].encode()
    same = replace(planted, text=source[planted.start : planted.end].decode())
    assert farm.try_out(same, {result.test: 1.0}).outcome == "passed"
    farm.stop()
    assert not farm.running and "unfinished" not in str(list(tmp_path.iterdir())), sys.prefix
