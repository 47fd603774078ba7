"""Measured files that are no measurement, through friction, calibrate and validate."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from .conftest import Files, Run

Refuses = Callable[..., str]
COMMANDS = {
    "friction": (("friction",), ("--normal-force", "2.45N")),
    "calibrate": (("calibrate", "choi2018-kapton"), ("--vacuum", "94.5kPa")),
    "validate": (("validate", "choi2018-kapton"), ("--vacuum", "94.5kPa")),
}
EACH = pytest.mark.parametrize("command", list(COMMANDS))


def table(n: int = 200, change: Callable[[np.ndarray], None] | None = None) -> np.ndarray:
    """Time, elongation and force of something like a pull."""
    u = np.linspace(0, 0.04, n)
    force = np.minimum(131e3 * u, 170 - 2000 * u) + 0.05 * np.sin(np.arange(n) * 2.4)
    rows = np.column_stack([u / 0.013, u, force])
    if change:
        change(rows)
    return rows


def own(rows: np.ndarray, head: str = "time [s],elongation [m],force [N]") -> str:
    return head + "\n" + "\n".join(",".join(f"{v:.9g}" for v in row) for row in rows) + "\n"


def backwards(rows: np.ndarray) -> None:
    rows[50, 0] = rows[20, 0]


def saturated(rows: np.ndarray) -> None:
    rows[:, 2] = np.minimum(rows[:, 2], 120.0)


def stuck(rows: np.ndarray) -> None:
    rows[:, 1] = 0.01


def not_a_number(rows: np.ndarray) -> None:
    rows[40, 2] = np.nan


def nothing(rows: np.ndarray) -> None:
    rows[:, 2] = 0.0


BAD = {
    "empty": ("", "empty"),
    "header only": ("time [s],elongation [m],force [N]\n", "no row"),
    "few rows": (own(table(5)), "5 rows"),
    "no format": ("dear diary,\ntoday I pulled a brake.\n" * 20, "not in a known format"),
    "binary": ("\x00\x01\x02" * 500, None),
    "no force": (own(table()[:, :2], "time [s],elongation [m]"), "force"),
    "no units": (own(table(), "time,elongation,force"), "unit"),
    "foreign unit": (own(table(), "time [s],elongation [m],force [furlong]"), "force"),
    "backwards": (own(table(change=backwards)), "time runs backwards"),
    "saturated": (own(table(change=saturated)), "saturated"),
    "stuck": (own(table(change=stuck)), "elongation never changes"),
    "nan": (own(table(change=not_a_number)), None),
    "nothing": (own(table(change=nothing)), "did not measure"),
}


@EACH
@pytest.mark.parametrize("what", list(BAD))
def test_one_bad_file_is_one_sentence(
    refuses: Refuses, tmp_path: Path, command: str, what: str
) -> None:
    text, why = BAD[what]
    path = tmp_path / "measured.csv"
    path.write_text(text)
    head, tail = COMMANDS[command]
    sentence = refuses(*head, path, *tail, "--json")
    assert sentence.startswith(f"{path}"), sentence
    assert why is None or why in sentence, sentence
    if what == "no format":
        for known in ("Bluehill", "testXpert", "layerjam"):
            assert known.lower() in sentence.lower(), sentence


@EACH
def test_a_cut_file_is_refused_or_used_and_said(
    run: Run, files: Files, tmp_path: Path, command: str
) -> None:
    """A Bluehill export that ends inside a number: the last row cannot be trusted."""
    source = files.bare_friction if command == "friction" else files.bare
    data = source.read_bytes().rstrip()
    path = tmp_path / "cut.csv"
    path.write_bytes(data[:-4])
    head, tail = COMMANDS[command]
    ran = run(*head, path, *tail, "--json")
    whole = run(*head, source, *tail, "--json")
    assert whole.code == 0
    if ran.code == 0:
        assert len(ran.json["warnings"]) > len(whole.json["warnings"])
    else:
        assert ran.code == 2 and ran.err.count("\n") == 1 and "cut.csv" in ran.err


@EACH
def test_absent_and_folders(refuses: Refuses, tmp_path: Path, command: str) -> None:
    head, tail = COMMANDS[command]
    assert "does not exist" in refuses(*head, tmp_path / "absent.csv", *tail)
    (tmp_path / "folder.csv").mkdir()
    assert "folder" in refuses(*head, tmp_path / "folder.csv", *tail)


@EACH
def test_a_broken_sidecar_names_its_line(
    refuses: Refuses, files: Files, tmp_path: Path, command: str
) -> None:
    path = tmp_path / "mine.csv"
    path.write_bytes((files.bare_friction if command == "friction" else files.bare).read_bytes())
    beside = tmp_path / "mine.csv.toml"
    head, tail = COMMANDS[command]
    for text, line, why in (
        ("repeat = 1\nvacuum = 94.5\n", 2, "has no unit"),
        ("vacum = '94.5 kPa'\n", 1, "vacuum"),
        ("repeat = 1\n\nspeed = ", 3, "is not valid TOML"),
    ):
        beside.write_text(text)
        sentence = refuses(*head, path, *tail)
        assert f"mine.csv.toml, line {line}" in sentence and why in sentence, sentence


@pytest.mark.parametrize("command", ["calibrate", "validate"])
def test_without_any_vacuum(refuses: Refuses, files: Files, command: str) -> None:
    sentence = refuses(command, "choi2018-kapton", files.bare)
    assert "bare.csv" in sentence and "--vacuum" in sentence and "bare.csv.toml" in sentence


@pytest.mark.parametrize("command", ["calibrate", "validate"])
@pytest.mark.parametrize(
    ("vacuum", "why"),
    [("94.5", "has no unit"), ("110kPa", "atmospheric"), ("-1kPa", "zero or")],
)
def test_a_bad_vacuum_for_files(
    refuses: Refuses, files: Files, command: str, vacuum: str, why: str
) -> None:
    sentence = refuses(command, "choi2018-kapton", files.bare, f"--vacuum={vacuum}")
    assert sentence.startswith("vacuum:") and why in sentence


def test_calibrating_at_zero_vacuum(refuses: Refuses, files: Files) -> None:
    sentence = refuses("calibrate", "choi2018-kapton", files.bare, "--vacuum", "0kPa")
    assert "jams no sheet" in sentence


def test_the_wrong_vacuum_shows_in_the_checks(run: Run, files: Files) -> None:
    ran = run("calibrate", "choi2018-kapton", files.bare, "--vacuum", "30kPa", "--json")
    verdicts = {c["name"]: c["passed"] for c in ran.json["checks"]}
    assert ran.code == 0 and verdicts["plausible"] is False


def test_friction_without_a_normal_force(refuses: Refuses, files: Files) -> None:
    assert "--normal-force" in refuses("friction", files.bare_friction)


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("--normal-force", "2.45"), "has no unit"),
        (("--normal-force", "0N"), "at least 0.1 mN"),
        (("--normal-force", "250 g"), "units of force"),
        (("--normal-force", "2.45N", "--from", "60mm", "--to", "50mm"), "from"),
        (("--normal-force", "2.45N", "--from", "40"), "has no unit"),
        (("--normal-force", "2.45N", "--to", "200mm"), "travel ends at"),
        (("--normal-force", "2.45N", "--brake", "choi2018-kapton"), "both"),
        (("--normal-force", "2.45N", "--brake", "nobody", "--out", "OUT"), "unknown brake"),
        (("--normal-force", "2.45N", "--out", "OUT"), "both"),
    ],
)
def test_friction_options(
    refuses: Refuses, files: Files, tmp_path: Path, words: tuple[str, ...], why: str
) -> None:
    placed = [str(tmp_path / "out.toml") if w == "OUT" else w for w in words]
    assert why in refuses("friction", files.friction[0], *placed)


def test_normal_forces_that_differ(refuses: Refuses, files: Files, tmp_path: Path) -> None:
    for number, newton in ((1, 2.45), (2, 4.9)):
        (tmp_path / f"{number}.csv").write_bytes(Path(files.friction[number]).read_bytes())
        (tmp_path / f"{number}.csv.toml").write_text(f'normal_force = "{newton} N"\n')
    sentence = refuses("friction", tmp_path / "1.csv", tmp_path / "2.csv")
    assert "2.45 N" in sentence and "4.9 N" in sentence


def test_all_files_bad_names_the_first_and_counts(refuses: Refuses, tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv", "c.csv"):
        (tmp_path / name).write_text("")
    paths = [tmp_path / n for n in ("a.csv", "b.csv", "c.csv")]
    sentence = refuses("calibrate", "choi2018-kapton", *paths, "--vacuum", "90kPa")
    assert "a.csv" in sentence and "2 more" in sentence
