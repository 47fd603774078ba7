"""Order of pulls: its sources, wear over it, and pulls that resemble the one before."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import layerjam as lj
from calibration_attacks import worn
from independent.pulls import BRAKE, SCALE_FACTOR, VACUUMS, repeats, write
from layerjam.laboratory.identify.curves import Turn
from layerjam.laboratory.identify.order import check_order, find_order
from layerjam.laboratory.identify.single_pulls import SinglePull
from layerjam.laboratory.measure.readers.started import find_start


def own_mountings(pulls):
    return [replace(p, facts={"mounting": str(n)} | dict(p.facts)) for n, p in enumerate(pulls, 1)]


def start_line(form: str, second: int) -> str:
    """Lines that state a moment of 28 November 2026, as machines write them."""
    moment = datetime(2026, 11, 28, 11, 50) + timedelta(seconds=second)
    return moment.strftime(form)


@pytest.mark.parametrize(
    "form",
    [
        "Date,2026-11-28\nStart time,%H:%M:%S",
        "Test date: %m/%d/%Y %I:%M:%S %p\nCalibrated: 2020-01-01 10:00:00",
        "Pr\u00fcfdatum;%d.%m.%Y %H:%M",
        "started %Y-%m-%dT%H:%M:%S+01:00",
        "sidecar %Y-%m-%d %H:%M:%S",
    ],
)
def test_order_is_that_of_start_times(tmp_path: Path, form: str) -> None:
    """Wear shows in the order of the start times, which the names of the files do not show."""
    random = np.random.default_rng(5)
    pulls = own_mountings(worn(random, VACUUMS, 4, 0.03))
    names = random.permutation(list("abcdefghijkl"))
    files = []
    for number, (pull, name) in enumerate(zip(pulls, names, strict=True)):
        line = start_line(form, 300 * number)
        date = {"date": f'"{line[8:]}"'} if form.startswith("sidecar") else {}
        dated = replace(pull, facts=dict(pull.facts) | date)
        [path] = write(tmp_path, [dated], seed=number, name=f"{name}.csv")
        if not form.startswith("sidecar"):
            path.write_text(f"{line}\n{path.read_text('utf-8')}", "utf-8")
        files.append(path)
    found = lj.calibrate(BRAKE, sorted(files))
    [wear] = [row for row in found.failed_checks if row["name"] == "wear"]
    assert "order of the start times" in wear["reason"]


@pytest.mark.parametrize("stated", ["repeat", "name", "mounting", "nothing"])
def test_order_is_that_of_repeats_mountings_or_names(tmp_path: Path, stated: str) -> None:
    random = np.random.default_rng(6)
    pulls, files = worn(random, VACUUMS, 4, 0.03), []
    names = random.permutation(list("abcdefghijkl"))
    for number, pull in enumerate(pulls):
        facts = {} if stated in ("name", "nothing") else {stated: str(1 + number % 4)}
        if stated == "mounting":  # a mounting for each vacuum
            facts = {stated: str(1 + number // 4)}
        name = f"{pull.vacuum / 1e3:.0f}kPa-{1 + number % 4}" if stated == "name" else names[number]
        files += write(tmp_path, [replace(pull, facts=facts)], seed=number, name=f"{name}.csv")
    given = files if stated == "mounting" else sorted(files)
    failed = {row["name"] for row in lj.calibrate(BRAKE, given).failed_checks}
    assert ("wear" in failed) == (stated != "nothing")


def place_pulls(*rows: Any) -> list[int]:
    pulls = [
        make_row(name, Turn(start, repeat, mounting)) for name, start, repeat, mounting in rows
    ]
    return find_order([pull.file for pull in pulls], pulls).places


def make_row(file: str, turn: Turn, vacuum: float = 80e3) -> SinglePull:
    numbers: dict[str, Any] = dict.fromkeys(
        ["vacuum_of_peak", "speed", "recorded_speed", "factor", "stiffness", "shape", "seating"]
    )
    return SinglePull(file=file, vacuum=vacuum, verdicts={}, sentence="", turn=turn, **numbers)


def test_sources_of_the_order() -> None:
    free = (None, None, None)
    assert place_pulls(("b-10.csv", *free), ("b-9.csv", *free), ("a-11.csv", *free)) == [1, 0, 2]
    assert place_pulls(("30kPa-1.csv", *free), ("60kPa-1.csv", *free)) == [0, 1]
    assert place_pulls(("x.csv", *free), ("y-1.csv", *free)) == [0, 1]
    assert place_pulls(("20240101.csv", *free), ("7.csv", *free)) == [0, 1]
    assert place_pulls(("1.csv", None, 2, None), ("2.csv", None, 1, None)) == [1, 0]
    assert place_pulls(("1.csv", 9.0, 1, None), ("2.csv", 5.0, 2, None)) == [1, 0]
    assert place_pulls(("1.csv", 9.0, 1, None), ("2.csv", None, 2, None)) == [0, 1]
    assert place_pulls(("b.csv", None, None, 2), ("a.csv", None, None, 1)) == [1, 0]


def test_wear_between_mountings_of_several_vacuums_fails() -> None:
    """Each of five mountings is pulled at three vacuums, and loses 4 % of its friction."""
    random = np.random.default_rng(7)
    rows, others = [], []
    for number in range(5):
        for vacuum in VACUUMS:
            factor, other = 0.96**number, 1 + 0.04 * random.standard_normal()
            for target, value in ((rows, factor), (others, other)):
                row = make_row("a.csv", Turn(mounting=number), vacuum)
                peak = vacuum * value * (1 + 0.01 * random.standard_normal())
                target.append(replace(row, vacuum_of_peak=peak, mounting=number))
    shuffled = [rows[place] for place in random.permutation(len(rows))]
    assert [c.level for c in check_order(shuffled) if c.name == "wear"] == ["failed"]
    assert all(c.passed for c in check_order(others) if c.name == "wear")


def test_mountings_that_resemble_the_one_before_widen_the_interval(tmp_path: Path) -> None:
    """A slow change of friction: the interval includes the scatter in full, not divided by 12."""
    wave = 1 + 0.02 * np.sin(np.arange(12) * 0.5)
    random = np.random.default_rng(8)
    pulls = list(repeats(random, (80e3,), 12, 0.0))
    slow = [replace(p, scale_factor=p.scale_factor * w) for p, w in zip(pulls, wave, strict=True)]
    mixed = [slow[n] for n in (0, 6, 1, 7, 2, 8, 3, 9, 4, 10, 5, 11)]
    found, other = (
        lj.calibrate(BRAKE, write(tmp_path / name, own_mountings(p)))
        for name, p in (("slow", slow), ("mixed", mixed))
    )
    [sentence] = [c["sentence"] for c in found.checks if c["name"] == "mountings"]
    assert "successive ones resemble each other" in sentence
    assert found.scale_factor == pytest.approx(other.scale_factor, rel=1e-3)
    error, less = (f.intervals["scale_factor"]["standard_error"] for f in (found, other))
    spread = float(np.std(wave, ddof=1)) * SCALE_FACTOR
    assert error**2 - less**2 == pytest.approx(spread**2, rel=0.1)


DAY = datetime(2026, 11, 28, tzinfo=UTC).timestamp()


@pytest.mark.parametrize(
    ("lines", "second"),
    [
        (["Date\t2026/11/28", "Time\t10:00:00,5"], 36000.5),
        (["28.11.2026 10:00"], 36000),
        (["Start of test: 28-11-2026", "Start of test: 9:05 PM"], 75900),
        (["11/28/2026 12:01:02 AM"], 62),
        (["2026-11-28T10:00:00.25+02:00"], 28800.25),
        (["2026-11-28"], None),
        (["31.02.2026 10:00"], None),
        (["28.11.2026", "duration 00:12:30"], None),
        (["exported 2026-11-28 10:00"], None),
        (["time (s),elongation (mm),force (N)", "v1.2.3", "1.2.2026.4 10:00:00:12"], None),
    ],
)
def test_start_times(lines: list[str], second: float | None) -> None:
    assert find_start(lines) == (None if second is None else DAY + second)
