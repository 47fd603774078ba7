"""Files a command writes: whole or not at all, never over an old one, and the same every time."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

import layerjam as lj
from layerjam.brake.simulate.record import read_header
from layerjam.core.command.index import commands
from layerjam.core.errors import FileError

from .conftest import Files, Run, contents

Refuses = Callable[..., str]
Words = tuple[str, ...]
KAPTON = "choi2018-kapton"
FORCE = ("force", KAPTON, "--slip", "20mm", "--vacuum", "94.5kPa")
PULL = ("tensile", KAPTON, "--vacuum", "94.5kPa", "--speed", "13mm/s", "--elongation", "40mm")
MAGIC = {"svg": b"<?xml", "png": b"\x89PNG", "pdf": b"%PDF"}
DRAWN = ("force", "vacuum", "tensile", "friction", "calibrate", "validate")
KINDS = {"force": "pdf", "friction": "png", "calibrate": "svg"}
"""Format of a command's figure in the quick tests."""
FIGURES = [
    pytest.param(command, kind, marks=[] if KINDS.get(command) == kind else pytest.mark.slow)
    for command in DRAWN
    for kind in MAGIC
]


def drawing(command: str, files: Files) -> tuple[object, ...]:
    return {
        "force": FORCE,
        "vacuum": ("vacuum", KAPTON, "--slip", "20mm", "--force", "100N"),
        "tensile": PULL,
        "friction": ("friction", *files.friction, "--normal-force", "2.45N"),
        "calibrate": ("calibrate", KAPTON, *files.pulls),
        "validate": ("validate", KAPTON, *files.validation),
    }[command]


@pytest.mark.parametrize(("command", "kind"), FIGURES)
def test_figures(run: Run, files: Files, tmp_path: Path, command: str, kind: str) -> None:
    made = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.{kind}"
        ran = run(*drawing(command, files), "--figure", path, "--json")
        assert (ran.code, ran.err) == (0, "")
        made.append(path.read_bytes())
        assert made[-1].startswith(MAGIC[kind]) and len(made[-1]) > 5000
    assert made[0] == made[1]
    assert sorted(contents(tmp_path)) == [f"one.{kind}", f"two.{kind}"]
    assert ran.json == run(*drawing(command, files), "--json").json


def test_a_figure_of_an_infeasible_force(run: Run, tmp_path: Path) -> None:
    words = ("vacuum", KAPTON, "--slip", "20mm", "--force", "400N", "--figure", tmp_path / "x.svg")
    assert run(*words).code == 1 and (tmp_path / "x.svg").exists()


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=[] if c in KINDS else pytest.mark.slow) for c in DRAWN]
)
def test_an_old_figure_stays(
    refuses: Refuses, run: Run, files: Files, tmp_path: Path, command: str
) -> None:
    path = tmp_path / "mine.svg"
    path.write_text("mine")
    words = (*drawing(command, files), "--figure", path)
    assert "already exists; --overwrite replaces it" in refuses(*words)
    assert run(*words, "--overwrite").code == 0 and path.read_bytes().startswith(MAGIC["svg"])


@pytest.mark.parametrize(
    ("words", "old"),
    [
        ((*FORCE, "--figure", "x.svg"), ("--force", "--replace")),
        (
            ("vacuum", KAPTON, "--slip", "20mm", "--force", "100N", "--figure", "x.svg"),
            ("--replace",),
        ),
        (("new", "x", "--from", KAPTON, "--out", "x.toml"), ("--force", "--replace")),
        ((*PULL, "--out", "x.csv"), ("--force", "--replace")),
    ],
    ids=("figure", "newtons", "file", "record"),
)
def test_former_names_of_overwrite_still_replace(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: Words, old: Words
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / words[-1]
    for name in old:
        path.write_text("mine")
        ran = run(*words, name)
        assert ran.code == 0 and path.stat().st_size > 400
        assert ran.err == f"layerjam: {name} is now called --overwrite\n"


def test_former_names_of_overwrite_are_hidden(run: Run) -> None:
    writes = 0
    for name in commands():
        shown = run(*name.split(), "--help").out
        assert "--replace" not in shown
        assert ("--force Q" in shown) == (name == "vacuum") and "--force  " not in shown
        writes += "--overwrite " in shown
    assert writes > 30


def test_python_takes_the_former_keyword_of_overwrite(tmp_path: Path) -> None:
    brake, pulled = tmp_path / "x.toml", lj.tensile(KAPTON, vacuum="9 kPa", speed=0.01, travel=0.02)
    for write in (
        partial(lj.new, "x", KAPTON, brake),
        partial(pulled.save, tmp_path / "x.json"),
        partial(pulled.save, tmp_path / "x.csv"),
        partial(pulled.plot, tmp_path / "x.svg"),
        partial(pulled.record.to_csv, tmp_path / "y.csv"),
        partial(pulled.record.save, tmp_path / "z.csv"),
        partial(lj.example_campaign, tmp_path / "spec.toml"),
    ):
        write()
        with pytest.raises(FileError, match="--overwrite replaces it"):
            write()
        write(overwrite=True)
        write(force=True)


@pytest.mark.parametrize("name", ["x.jpg", "x", "x.svg.exe", ".svg"])
def test_figure_endings(refuses: Refuses, tmp_path: Path, name: str) -> None:
    sentence = refuses(*FORCE, "--figure", tmp_path / name)
    assert ".svg, .png or .pdf" in sentence


@pytest.mark.parametrize("name", ["run.txt", "run.svg", "run"])
def test_record_endings(refuses: Refuses, tmp_path: Path, name: str) -> None:
    assert "use .csv or .nc" in refuses(*PULL, "--out", tmp_path / name)


def test_a_record_keeps_the_site(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    assert run(*PULL, "--atmosphere", "98.7654321kPa", "--out", path).code == 0
    file, text = read_header(path)
    assert file.brake.site.atmosphere == 98765.4321
    assert text == "evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm"


@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_an_old_record_stays(refuses: Refuses, run: Run, tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"run.{ending}"
    path.write_text("mine")
    assert "already exists" in refuses(*PULL, "--out", path)
    assert run(*PULL, "--out", path, "--overwrite").code == 0
    assert path.stat().st_size > 5000


def test_an_old_brake_stays(refuses: Refuses, run: Run, files: Files, tmp_path: Path) -> None:
    path = tmp_path / "old.toml"
    path.write_text("mine")
    for words in (
        ("new", "x", "--from", KAPTON, "--out", path),
        ("calibrate", KAPTON, *files.pulls, "--out", path),
        ("friction", *files.friction, "--normal-force", "2.45N", "--brake", KAPTON, "--out", path),
    ):
        path.write_text("mine")
        assert "already exists" in refuses(*words)
        assert run(*words, "--overwrite").code == 0 and "[sheets]" in path.read_text()


@pytest.mark.parametrize(
    "option", [("--figure", "x.svg"), ("--out", "x.csv")], ids=lambda o: o[0].strip("-")
)
def test_folders_that_are_not_there(
    refuses: Refuses, tmp_path: Path, option: tuple[str, str]
) -> None:
    sentence = refuses(*PULL, option[0], tmp_path / "nowhere" / option[1])
    assert "there is no folder" in sentence and "nowhere" in sentence
    (tmp_path / "file").write_text("")
    assert "there is no folder" in refuses(*PULL, option[0], tmp_path / "file" / option[1])


def test_a_bad_second_output_leaves_no_first_one(refuses: Refuses, tmp_path: Path) -> None:
    refuses(*PULL, "--out", tmp_path / "run.csv", "--figure", tmp_path / "nowhere" / "x.svg")
    refuses(*PULL, "--out", tmp_path / "run.csv", "--figure", tmp_path / "x.jpg")


def test_folders_nobody_may_write(
    refuses: Refuses, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Root may write everywhere, so the kernel's answer is played."""
    allowed = os.access
    monkeypatch.setattr(os, "access", lambda p, m: Path(p) != tmp_path and allowed(p, m))
    assert "read-only" in refuses(*PULL, "--out", tmp_path / "run.csv")
    assert "read-only" in refuses(*FORCE, "--figure", tmp_path / "x.svg")


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no /proc")
def test_a_folder_that_refuses(refuses: Refuses) -> None:
    for words in ((*PULL, "--out", "/proc/run.csv"), (*FORCE, "--figure", "/proc/x.svg")):
        assert "cannot be written" in refuses(*words)
    assert "cannot be created" in refuses("reproduce", "--out", "/proc/report")


@pytest.mark.parametrize("words", [PULL, FORCE], ids=lambda w: w[0])
def test_a_full_disk(
    refuses: Refuses, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)
    option = ("--out", tmp_path / "run.csv") if words is PULL else ("--figure", tmp_path / "x.svg")
    assert "No space left on device" in refuses(*words, *option)


def test_nothing_is_written_without_being_asked(
    run: Run, files: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    before = contents(files.bare.parent)
    for command in DRAWN:
        assert run(*drawing(command, files)).code == 0
    assert contents(tmp_path) == {} and contents(files.bare.parent) == before
