"""`lab`: from a campaign's file to practice files, and from those with our own commands on."""

from __future__ import annotations

import glob
import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from layerjam.cli import main as entry
from layerjam.core.errors import FileError, QuantityError
from layerjam.laboratory.campaigns.spec import Faults, FrictionTests, Practice, Pulls, Spec, Truth
from layerjam.laboratory.campaigns.text import example_spec
from layerjam.laboratory.commands.lab import lab, lab_example
from printed import split_command

SPEC = Spec(
    brakes=(Truth(brake="choi2018-kapton", scale_factor=0.95, stiffness=110e3),),
    pulls=Pulls(vacuums=(50e3, 94.5e3), speeds=(7e-3, 19e-3), repeats=2),
    friction=FrictionTests(repeats=3, force_noise=1e-3),
    machine=Faults(sampling_rate=200.0, force_noise=0.1, force_step=1e-3, travel_step=1e-7),
)


def unfolded(words: Sequence[str]) -> list[str]:
    """Words with a shell's patterns replaced by the files they name."""
    return [f for w in words for f in (sorted(glob.glob(w)) if "*" in w else [w])]


def test_the_answer(tmp_path: Path) -> None:
    answer = lab(SPEC, out=tmp_path / "d")
    assert (answer.friction_tests, answer.pulls, answer.faulty, answer.seed) == (3, 8, 0, 1)
    assert len(answer.files) == 11 and all(Path(f).is_file() for f in answer.files)
    assert answer.samples == sum(len(t) for t in answer.record.traces())
    assert Path(answer.truth).is_file()
    assert any("synthetic" in w for w in answer.warnings)
    assert lab(SPEC, out=tmp_path / "e", seed=9).seed == 9
    with pytest.raises(QuantityError, match="seed"):
        lab(SPEC, out=tmp_path / "f", seed=-1)
    with pytest.raises(FileError, match="is not empty"):
        lab(SPEC, out=tmp_path / "d")
    (tmp_path / "d" / "old.csv").write_text("")
    again = lab(SPEC, out=tmp_path / "d", overwrite=True)
    assert any("1 other file in" in w for w in again.warnings)


@pytest.mark.parametrize("layouts", [("own",), ("bluehill", "testxpert", "mts")])
def test_the_commands_it_prints_find_the_truth(layouts: tuple[str, ...], tmp_path: Path) -> None:
    spec = replace(SPEC, files=replace(SPEC.files, layouts=layouts))
    folder = tmp_path / "with a blank"
    answers = []
    for line in lab(spec, out=folder).next:
        words = unfolded(split_command(line)[1:])
        assert entry.main([*words, "--json"]) == 0
        answers.append(words)
    names = [words[0] for words in answers]
    assert names == ["friction", "calibrate", "validate"]
    files = [sum(str(folder) in w and ".toml" not in w for w in words) for words in answers]
    assert files == [3, 4, 4]


def test_the_whole_way_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    assert entry.main(["lab", "--example"]) == 0
    text = capsys.readouterr().out
    assert text == lab_example()
    spec = tmp_path / "SPEC.toml"
    spec.write_text(text.replace('sampling_rate = "500 Hz"', 'sampling_rate = "50 Hz"'))
    folder = tmp_path / "d"
    assert entry.main(["lab", str(spec), "--out", str(folder), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert list(answer) == [
        "folder", "files", "friction_tests", "pulls", "samples", "faulty", "seed", "truth", "next",
        "stopped", "units", "warnings",
    ]  # fmt: skip
    assert answer["pulls"] == 18 and len(answer["files"]) == 21 and answer["faulty"] == 1
    assert entry.main(["lab", str(spec), "--out", str(folder)]) == 2
    assert "is not empty; use --overwrite" in capsys.readouterr().err
    assert entry.main(["lab", str(spec), "--out", str(folder), "--overwrite", "--seed", "3"]) == 0
    shown = capsys.readouterr().out
    assert "21, each with its sidecar" in shown and "layerjam calibrate" in shown
    for wrong, words in (
        ([], "SPEC and --out are needed"),
        ([str(spec)], "SPEC and --out are needed"),
        (["--example", "--out", "x"], "does not end in .toml"),
        (["--example", "practice"], "only with --out and --overwrite"),
        (["--example", "--out", str(spec)], "already exists; --overwrite"),
        ([str(tmp_path / "no.toml"), "--out", str(tmp_path / "e")], "No such file"),
    ):
        assert entry.main(["lab", *wrong]) == 2
        assert words in capsys.readouterr().err
    assert not (tmp_path / "e").exists()


def test_the_built_in_campaign_is_the_example(tmp_path: Path) -> None:
    lab_example(tmp_path / "s.toml")
    made = [
        lab(spec, out=tmp_path / name)
        for spec, name in (("practice", "a"), (tmp_path / "s.toml", "b"))
    ]
    one, two = ([Path(f).read_bytes() for f in a.files] for a in made)
    assert one == two


def test_stopped_by_the_keyboard(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    def stop(self: object, what: str, share: float) -> None:
        if share > 0.5:
            raise KeyboardInterrupt

    monkeypatch.setattr("layerjam.cli.generate.Ticker.__call__", stop)
    spec = tmp_path / "s.toml"
    spec.write_text(lab_example())
    assert entry.main(["lab", str(spec), "--out", str(tmp_path / "d")]) == 130
    assert capsys.readouterr().err.splitlines()[-1] == "layerjam: stopped"
    assert not (tmp_path / "d").exists()


def test_files_that_will_be_refused_are_announced(tmp_path: Path) -> None:
    spec = replace(SPEC, practice=Practice(cut_off=2, saturated=1))
    answer = lab(spec, out=tmp_path / "d")
    assert answer.faulty == 3
    assert "3 of the pull files have a fault" in (tmp_path / "d" / "README.txt").read_text()


def test_the_example_teaches(tmp_path: Path) -> None:
    answer = lab(example_spec(), out=tmp_path)
    calibrate = unfolded(split_command(answer.next[1])[1:])
    friction = unfolded(split_command(answer.next[0])[1:])
    assert entry.main([*friction, "--json"]) == 0
    assert entry.main([*calibrate, "--partial", "--json"]) in (0, 3)
