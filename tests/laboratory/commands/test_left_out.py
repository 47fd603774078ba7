"""Files left out by hand: the reason stays with the result, the brake and the report."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import layerjam
from laboratory.campaigns import bench as virtual
from laboratory.figures.brake_files import draw_nothing
from layerjam.brake.device.load import load
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.laboratory.figures import brake_files as writer
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.identify.shape import change_shape
from strategies import KAPTON

BRAKE = "choi2018-kapton"


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures and PDF are looked at elsewhere."""
    monkeypatch.setattr(writer, "draw_all", draw_nothing)
    monkeypatch.setattr(writer, "typeset_pdf", lambda data, pictures: b"%PDF")


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Eight pulls; the sixth has another friction."""
    folder, random = tmp_path_factory.mktemp("pulls"), np.random.default_rng(5)
    out = []
    for number in range(8):
        factor = 0.9 * (1 + 0.01 * random.standard_normal()) * (1.2 if number == 5 else 1.0)
        trace = virtual.pull(
            change_shape(KAPTON, factor, 12e4, 1.0), 60e3, 0.013, 0.04, repeat=number
        )
        out.append(virtual.write_own(trace, folder / f"pull-{number}.csv"))
    return out


def test_an_odd_pull_is_named_left_out_and_remembered(files: list[Path], tmp_path: Path) -> None:
    whole = layerjam.calibrate(BRAKE, files)
    odd = [row["file"] for row in whole.pulls if row["odd"]]
    assert odd == ["pull-5.csv"] and not whole.excluded
    assert set(whole.units) <= set(whole.values)  # rows are SI, as those of the files
    assert "pull-5.csv" in str(whole).split("pull by pull")[1]
    keys = {getattr(w, "key", "") for w in whole.warnings}
    assert {"one-vacuum", "one-speed"} <= keys
    out, why = tmp_path / "brake.toml", "the grip slipped"
    kept = [f for f in files if f.name != "pull-5.csv"]
    less = layerjam.calibrate(BRAKE, files, exclude="pull-5.csv", because=why, out=out)
    assert less.scale_factor == layerjam.calibrate(BRAKE, kept).scale_factor
    digest = sha256(str(files[5]))
    one = {"file": str(files[5]), "because": why, "sha256": digest, "automatic": False}
    assert less.excluded == [one] and not less.refused and less.exit_code == 0
    assert not any(row["odd"] for row in less.pulls) and why in str(less)
    [noted] = load(out).notes["excluded"]
    assert noted == {"name": "pull-5.csv", "because": why, "sha256": one["sha256"]}
    again = layerjam.validate(out, files, exclude={str(files[5]): why})
    assert again.excluded == [one] and len(again.files) == 7 == len(again.pulls)
    assert [row["odd"] for row in layerjam.validate(out, files).pulls].count(True) == 1


def test_a_file_that_cannot_be_read_may_be_left_out(files: list[Path], tmp_path: Path) -> None:
    broken = tmp_path / "broken.csv"
    broken.write_text("no numbers")
    found = layerjam.calibrate(BRAKE, [*files, broken], exclude=[broken.name], because=["broken"])
    assert not found.refused and found.excluded[0]["file"] == str(broken)
    trace = virtual.pull(KAPTON, 60e3, 0.013, 0.04)
    traces = [replace(trace, path="a"), replace(trace, path="b", force=trace.force * 1.01)]
    made = layerjam.calibrate(BRAKE, traces, exclude={"b": "wet"})
    assert made.excluded == [{"file": "b", "because": "wet", "sha256": None, "automatic": False}]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"exclude": "pull-1.csv"}, "1 excluded, 0 reasons given"),
        ({"exclude": "pull-1.csv", "because": " "}, "is empty for pull-1.csv"),
        ({"because": "wet"}, "0 excluded, 1 reason given"),
        ({"exclude": "pull-9.csv", "because": "wet"}, "pull-9.csv is not one of the files given"),
        ({"exclude": ["pull-1.csv"] * 2, "because": ["a", "b"]}, "named twice"),
        ({"exclude": {f"pull-{n}.csv": "wet" for n in range(8)}}, "none is left"),
        ({"exclude": {"pull-1.csv": "a"}, "because": "b"}, "are already stored with the files"),
    ],
)
def test_what_cannot_be_left_out(files: list[Path], given: dict[str, object], words: str) -> None:
    with pytest.raises(QuantityError, match=words):
        layerjam.calibrate(BRAKE, files, **given)


def test_two_files_of_one_name_need_their_folder(files: list[Path], tmp_path: Path) -> None:
    other = virtual.write_own(virtual.pull(KAPTON, 50e3, 0.013, 0.04), tmp_path / files[0].name)
    with pytest.raises(QuantityError, match="is the name of several files"):
        layerjam.calibrate(BRAKE, [*files, other], exclude={files[0].name: "wet"})
    found = layerjam.calibrate(BRAKE, [*files, other], exclude={str(other): "wet"})
    assert found.excluded[0]["file"] == str(other)


def specimens(path: Path, labels: tuple[str, ...]) -> Path:
    """A file with a pull under each label, the second one with 1.2 times the friction."""
    random = np.random.default_rng(8)
    lines = []
    for number, label in enumerate(labels):
        factor = 0.9 * (1 + 0.01 * random.standard_normal()) * (1.2 if number == 1 else 1.0)
        trace = virtual.pull(
            change_shape(KAPTON, factor, 12e4, 1.0), 60e3, 0.013, 0.04, repeat=number
        )
        rows = zip(trace.time, 1e3 * trace.elongation, trace.force, strict=True)
        lines += [label, "Time (s),Extension (mm),Load (N)"]
        lines += [f"{t:.6f},{u:.6f},{f:.5f}" for t, u, f in rows] + [""]
    path.write_text("\n".join(lines))
    return path


def test_one_specimen_of_a_file_may_be_left_out(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Named as results name it; what is left is the file without its lines."""
    labels = tuple(f"Specimen A {n}" for n in range(1, 7))
    path, why = specimens(tmp_path / "x.csv", labels), "the grip slipped"
    given = {"vacuum": "60kPa", "speed": "13mm/s"}
    whole = layerjam.calibrate(BRAKE, path, **given)
    [odd] = [row["file"] for row in whole.pulls if row["odd"]]
    assert odd.startswith("x.csv, specimen ") and odd.endswith("A 2")
    out = tmp_path / "brake.toml"
    less = layerjam.calibrate(BRAKE, path, exclude=odd, because=why, out=out, **given)
    alone = tmp_path / "alone.csv"
    text = path.read_text().split("Specimen A 2\n")
    alone.write_text(text[0] + "Specimen A 3" + text[1].split("Specimen A 3")[1])
    rest = layerjam.calibrate(BRAKE, alone, **given)
    assert less.scale_factor == rest.scale_factor and len(less.pulls) == 5
    left = f"{path}{odd.removeprefix('x.csv')}"
    one = {"file": left, "because": why, "sha256": sha256(str(path)), "automatic": False}
    assert less.excluded == [one] and not less.refused and f"  {left}: {why}" in list(less.lines())
    assert load(out).notes["excluded"] == [{"name": odd, "because": why, "sha256": one["sha256"]}]
    assert layerjam.validate(out, path, exclude={left: why}, **given).excluded == [one]
    command = [BRAKE, str(path), "--vacuum", "60kPa", "--speed", "13mm/s", "--json"]
    both = ["--exclude", odd, "--because", why]
    assert main(["calibrate", *command, *both]) == 0
    assert json.loads(capsys.readouterr().out)["scale_factor"] == less.scale_factor
    page = tmp_path / "report"
    command = ["report", BRAKE, "--pulls", str(path), *command[2:], "--out", str(page)]
    assert main([*command, *both]) == 0
    assert f"{odd} (calibration): {why}" in (page / "report.html").read_text(encoding="utf-8")
    # traces that were read in Python are named alike
    from layerjam import read_traces

    traces = read_traces(path)
    found = layerjam.calibrate(BRAKE, traces, exclude={odd: why}, vacuum="60kPa")
    assert found.scale_factor == less.scale_factor and found.excluded == [one]


def test_a_specimen_that_is_not_there(files: list[Path], tmp_path: Path) -> None:
    path = specimens(tmp_path / "x.csv", ("Specimen A 1", "Specimen A 2"))
    names = [row["specimen"] for row in layerjam.pull(path).pulls]
    for name, words in (
        ("x.csv, specimen B", "contains no specimen 'B': '"),
        ("pull-1.csv, specimen 1", "has only one specimen; exclude it by the file name alone"),
        ("y.csv, specimen 1", "is not one of the files given"),
    ):
        with pytest.raises(QuantityError, match=words):
            layerjam.calibrate(BRAKE, [*files, path], exclude={name: "wet"}, vacuum="60kPa")
    every = {f"x.csv, specimen {name}": "wet" for name in names}
    with pytest.raises(QuantityError, match="none is left"):
        layerjam.calibrate(BRAKE, path, exclude=every, vacuum="60kPa")
    found = layerjam.calibrate(BRAKE, [*files, path], exclude=every, vacuum="60kPa")
    assert found.scale_factor == layerjam.calibrate(BRAKE, files).scale_factor
    with pytest.raises(QuantityError, match="named twice"):
        layerjam.calibrate(BRAKE, files, exclude={"pull-1.csv": "a", str(files[1]): "b"})


def test_on_the_command_line_and_in_the_report(
    files: list[Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [str(f) for f in files]
    both = ["--exclude", "pull-5.csv", "--because", "the grip slipped"]
    both += ["--exclude", "pull-2.csv", "--because", "ölig"]
    assert main(["calibrate", BRAKE, *names, *both, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [e["because"] for e in printed["excluded"]] == ["the grip slipped", "ölig"]
    assert len(printed["pulls"]) == 6
    out = tmp_path / "report"
    command = ["report", BRAKE, "--pulls", *names, *both, "--out", str(out)]
    assert main(command) == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Left out and not used" in page and "pull-5.csv (calibration): the grip slipped" in page
    assert "<caption>Individual pulls</caption>" in page
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert {e["file"] for e in results["excluded"]} == {"pull-5.csv", "pull-2.csv"}
    assert "calibration pull: scale factor a" in (out / "numbers.csv").read_text(encoding="utf-8")
