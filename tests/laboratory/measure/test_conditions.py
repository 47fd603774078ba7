"""Vacuum and speed of a file: from its sidecar, from a list of the folder, from its name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.measure.test_machines import FORCE, ROWS, TIME, TRAVEL
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.read import read_trace

PATTERN = "pull_{vacuum}_{speed:mm/s}_*"


def pull(folder: Path, name: str = "pull_94.5kPa_13_2.csv", sidecar: str = "") -> Path:
    path = folder / name
    rows = [f"{t:.4f},{u:.5f},{f:.5f}" for t, u, f in ROWS]
    path.write_text("\n".join(["Time (s),Extension (mm),Load (N)", *rows, ""]), encoding="utf-8")
    if sidecar:
        path.with_name(path.name + ".toml").write_text(sidecar, encoding="utf-8")
    return path


def listed(folder: Path, text: str) -> None:
    (folder / "conditions.csv").write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "pattern", "vacuum", "speed"),
    [
        ("pull_94.5kPa_13_2.csv", PATTERN, 94.5e3, 0.013),
        ("pull_94p5kPa_0,5_2.csv", PATTERN, 94.5e3, 0.0005),
        ("80kPa 10mm-min.csv", "{vacuum} {speed:mm/min}mm-min", 80e3, 10e-3 / 60),
        ("Kapton 600 mbar.txt", "* {vacuum}", 60e3, None),
        ("a94_v5.csv", "a{vacuum:kPa}_v{speed:mm/s}.csv", 94e3, 0.005),
        ("pull_80kPa.csv", "friction_*|pull_{vacuum}*", 80e3, None),
        ("friction_3.csv", "friction_*|pull_{vacuum}*", None, None),
    ],
)
def test_a_name_after_its_pattern(name, pattern, vacuum, speed, tmp_path: Path) -> None:
    facts = read_trace(pull(tmp_path, name), ReadingOptions(names=pattern)).facts
    assert facts.vacuum == (vacuum and pytest.approx(vacuum, rel=1e-12))
    assert facts.speed == (speed and pytest.approx(speed, rel=1e-12))


@pytest.mark.parametrize(
    ("pattern", "words"),
    [
        ("pull_{vacuum}kPa", "its name does not follow the pattern.*separate two patterns by |"),
        ("a_{vacuum}|b_*", r"the pattern 'a_{vacuum}\|b_\*' \(--names\)$"),
        ("pull_*|friction_*", "contains no quantity"),
        ("pull_{vacum}_*", "did you mean vacuum"),
        ("pull_{vacuum:mm}_*", "'mm' is not a unit of vacuum"),
        ("pull_*", "contains no quantity"),
        ("pull_{vacuum}_{vacuum}_*", "appears twice"),
        ("pull_{speed}_*", "speed"),
        ("pull_{repeat:mm}_*", "'mm' is not a unit of repeat"),
    ],
)
def test_a_pattern_that_does_not_fit_is_refused(pattern: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(LayerjamError, match=words):
        read_trace(pull(tmp_path), ReadingOptions(names=pattern))


@pytest.mark.parametrize(
    "text",
    [
        "file,vacuum,speed\npull.csv,94.5 kPa,13 mm/s\n",
        "File;Vacuum (kPa);Speed (mm/s)\nother.csv;60;1\npull.csv;94,5;13\n",
        "file\tvacuum [kPa]\tspeed [mm/min]\tnote\npull.csv\t94.5\t780\tfirst of the day\n",
    ],
)
def test_one_list_for_a_folder(text: str, tmp_path: Path) -> None:
    listed(tmp_path, text)
    facts = read_trace(pull(tmp_path, "pull.csv")).facts
    assert facts.vacuum == pytest.approx(94.5e3, rel=1e-12)
    assert facts.speed == pytest.approx(0.013, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("file,vacuum\npull.csv,94.5\n", 2, "has no unit"),
        ("file,vacuum\npull.csv,500 kPa\n", 2, "vacuum"),
        ("file,vacum\npull.csv,9 kPa\n", 1, "did you mean vacuum"),
        ("name,vacuum\npull.csv,9 kPa\n", 1, "unknown column"),
        ("vacuum\n9 kPa\n", 1, "'file'"),
        ("file,vacuum\npull.csv,9 kPa\npull.csv,8 kPa\n", 3, "twice"),
    ],
)
def test_a_bad_list_is_refused_with_its_line(text: str, line, words, tmp_path: Path) -> None:
    listed(tmp_path, text)
    with pytest.raises(FileError, match=words) as err:
        read_trace(pull(tmp_path, "pull.csv"))
    assert err.value.line == line and err.value.path == str(tmp_path / "conditions.csv")


def test_what_contradicts_is_refused_and_what_agrees_is_not(tmp_path: Path) -> None:
    path = pull(tmp_path, sidecar='vacuum = "94.5 kPa"\n')
    assert read_trace(path, ReadingOptions(names=PATTERN)).facts.speed == pytest.approx(0.013)
    listed(tmp_path, "file,vacuum\npull_94.5kPa_13_2.csv,90 kPa\n")
    with pytest.raises(
        FileError, match=r"sidecar states vacuum 94\.5 kPa, but conditions\.csv states 90 kPa"
    ):
        read_trace(path)


def test_a_log_of_force_over_time_needs_the_speed(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{1000 * t:.0f},{f:.5f}" for t, _, f in ROWS]
    path.write_text("\n".join(["time_ms,force_N", *rows, ""]), encoding="utf-8")
    with pytest.raises(FileError, match="no elongation.*--speed"):
        read_trace(path)
    for options in (
        ReadingOptions(speed=0.013),
        ReadingOptions(speed=0.013, columns="time:ms,force:N"),
    ):
        trace = read_trace(path, options)
        np.testing.assert_allclose(trace.elongation, 0.013 * TIME, atol=1e-12)
        np.testing.assert_allclose(trace.force, FORCE, atol=1e-5)
        assert trace.facts.speed == 0.013
    path.with_name("log.csv.toml").write_text('speed = "13 mm/s"\n', encoding="utf-8")
    np.testing.assert_allclose(read_trace(path).elongation, TRAVEL / 1000, atol=1e-9)


def test_a_measured_elongation_outranks_the_speed(tmp_path: Path) -> None:
    trace = read_trace(pull(tmp_path), ReadingOptions(speed=0.001))
    np.testing.assert_allclose(trace.elongation, TRAVEL / 1000, atol=1e-9)
