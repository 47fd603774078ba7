"""`report`: which pulls calibrate, which validate, what is refused, and what the command takes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from laboratory.figures.brake_files import BRAKE, Campaign, campaign
from layerjam.cli.generate import repeat_options
from layerjam.core.command.declare import load_command
from layerjam.core.errors import FileError, FitError, LayerjamError, QuantityError
from layerjam.laboratory.commands.report import Report, report
from layerjam.laboratory.figures import brake_files as writer
from layerjam.laboratory.measure.sidecar import sidecar_path


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return campaign(tmp_path_factory.mktemp("campaign"))


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures and pages are looked at elsewhere."""
    monkeypatch.setattr(writer, "draw_all", lambda pictures, tell: {})
    monkeypatch.setattr(writer, "to_html", lambda shown, pictures, live: json.dumps(shown))
    monkeypatch.setattr(writer, "typeset_pdf", lambda shown, pictures: b"%PDF")


def run(out: Path, **given: Any) -> Report:
    return report(BRAKE, out=out / "out", date="2026-01-01", **given)


def names(answer: Report, role: str) -> set[str]:
    return {f.name for f in answer.record.files if f.role == role}


@pytest.mark.usefixtures("quick")
def test_pulls_alone_are_no_test_and_the_page_says_so(files: Campaign, tmp_path: Path) -> None:
    answer = run(tmp_path, pulls=files.pulls)
    assert answer.calibrated_on_the_same == [p.name for p in files.pulls]
    assert any("does not test the model" in w and "--holdout" in w for w in answer.warnings)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "Fit to the calibration pulls" in page and "This does not test the model" in page
    found = [c for c in answer.validation["checks"] if c["name"] == "independent"]
    assert [c["passed"] for c in found] == [False]


@pytest.mark.usefixtures("quick")
def test_one_pull_is_one_pull(files: Campaign, tmp_path: Path) -> None:
    """One pull has no scatter: its uncertainty is not stated, and never 0.000 %."""
    answer = run(tmp_path, pulls=files.pulls[:1], accept={})
    page = json.loads((tmp_path / "out" / "report.html").read_text())
    assert "Tested: 1 calibration pull, 1 validation pull at 1 condition." in page["lead"]
    factor = next(n for n in page["numbers"] if n["words"].startswith("scale factor a"))
    assert "uncertainty not stated" in factor["words"] and "±" not in factor["value"]
    whole = json.dumps(page, ensure_ascii=False)
    assert not re.search(r"(?<!\d)0\.000 %", whole)
    assert "For a complete budget, state: repeated pulls" in whole
    assert answer.verdict == "passed"


@pytest.mark.usefixtures("quick")
def test_some_of_the_same(files: Campaign, tmp_path: Path) -> None:
    answer = run(tmp_path, pulls=files.pulls, validate=[*files.validate, files.pulls[1]])
    assert answer.calibrated_on_the_same == [files.pulls[1].name]
    assert "1 of 9 pulls" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("holdout", "held"),
    [
        pytest.param(["46.1kPa"], lambda n: "46.1kPa" in n, marks=pytest.mark.slow),
        pytest.param(["19 mm/s"], lambda n: "19mms" in n, marks=pytest.mark.slow),
        (["repeat 1"], lambda n: n.endswith("-1.csv")),
        (["46.1kPa", "19mm/s"], lambda n: "46.1kPa" in n or "19mms" in n),
    ],
)
def test_holding_back(files: Campaign, tmp_path: Path, holdout: list[str], held: Any) -> None:
    every = [*files.pulls, *files.validate]
    answer = run(tmp_path, pulls=every, holdout=holdout)
    wanted = {p.name for p in every if held(p.name)}
    assert names(answer, "validation") == wanted
    assert names(answer, "calibration") == {p.name for p in every} - wanted
    assert answer.calibrated_on_the_same == []


@pytest.mark.usefixtures("quick")
def test_calibrate_on(files: Campaign, tmp_path: Path) -> None:
    every = [*files.pulls, *files.validate]
    answer = run(tmp_path, pulls=every, calibrate_on=files.pulls)
    assert names(answer, "calibration") == {p.name for p in files.pulls}
    assert names(answer, "validation") == {p.name for p in files.validate}


@pytest.mark.usefixtures("quick")
def test_whole_curves(files: Campaign, tmp_path: Path) -> None:
    answer = run(
        tmp_path, pulls=[*files.pulls, *files.validate], holdout=["repeat 2"], depth="curves"
    )
    assert answer.calibration["depth"] == "curves"
    numbers = {n["quantity"]: n["value"] for n in json.loads(
        (tmp_path / "out" / "results.json").read_text())["numbers"]}  # fmt: skip
    assert numbers["calibration: factor on the enclosure's force"] == pytest.approx(1, abs=0.1)
    assert numbers["calibration: scale factor a"] == pytest.approx(0.875, rel=0.05)


@pytest.mark.usefixtures("quick")
def test_refused_files_are_named(files: Campaign, tmp_path: Path) -> None:
    bad = tmp_path / "bad.csv"
    bad.write_text("nothing here\n")
    answer = run(tmp_path, pulls=files.pulls, validate=[*files.validate, bad])
    assert list(answer.refused) == ["bad.csv"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert (
        "bad.csv" in page and answer.refused["bad.csv"] in json.loads(page)["parts"][0]["notes"][0]
    )
    whole = json.loads((tmp_path / "out" / "results.json").read_text())
    assert whole["refused"][0]["file"] == "bad.csv" and whole["refused"][0]["stage"] == "validation"
    with pytest.raises(FileError):
        report(BRAKE, out=tmp_path / "none", pulls=[bad])
    assert not (tmp_path / "none").exists()


@pytest.mark.usefixtures("quick")
def test_friction_goes_into_the_calibration(files: Campaign, tmp_path: Path) -> None:
    answer = run(tmp_path, friction=files.friction, pulls=files.pulls, validate=files.validate)
    brake = answer.record.brake
    assert brake.film.kinetic == pytest.approx(answer.friction["kinetic"])
    assert brake.scale_factor == pytest.approx(answer.calibration["scale_factor"])
    assert answer.record.file.name == BRAKE


@pytest.fixture(scope="module")
def gross(files: Campaign, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The friction tests, one with its forces divided by 1,000."""
    folder = tmp_path_factory.mktemp("gross")
    out = []
    for path in files.friction:
        for one in (path, sidecar_path(path)):
            (folder / one.name).write_bytes(one.read_bytes())
        out.append(folder / path.name)
    lines = out[0].read_text(encoding="utf-8").split("\n")
    head = next(i for i, line in enumerate(lines) if "(N)" in line)
    for i in range(head + 1, len(lines)):
        cells = lines[i].split(",")
        if len(cells) == 3:
            cells[2] = f'"{float(cells[2].strip(chr(34))) / 1000:.9f}"'
            lines[i] = ",".join(cells)
    out[0].write_text("\n".join(lines), encoding="utf-8")
    return out


@pytest.mark.usefixtures("quick")
def test_a_failed_check_writes_nothing(files: Campaign, gross: list[Path], tmp_path: Path) -> None:
    answer = run(tmp_path, friction=gross, pulls=files.pulls, normal_force="2.45 N")
    failed = {row["name"] for row in answer.failed_checks}
    assert answer.verdict == "failed" and "friction.repeats" in failed
    assert answer.report is answer.numbers is answer.results is None
    assert list(tmp_path.iterdir()) == []
    reasons = dict.fromkeys(failed, "demonstration")
    answer = run(tmp_path, friction=gross, pulls=files.pulls, normal_force="2.45 N", accept=reasons)
    assert answer.verdict == "accepted" and {a["check"] for a in answer.accepted} == failed
    page = json.loads((tmp_path / "out" / "report.html").read_text())
    assert page["verdicts"][0]["text"].startswith("Verdict: accepted")
    assert sum("demonstration" in line for line in page["banner"]) == len(failed)
    kinetic = next(n for n in page["numbers"] if n["words"].startswith("kinetic friction"))
    assert "±" not in kinetic["value"] and "not determined" in kinetic["words"]
    written = json.loads((tmp_path / "out" / "results.json").read_text())
    assert written["verdict"] == "accepted" and len(written["accepted"]) == len(failed)
    assert {a.check for a in answer.record.file.accepted} <= failed


@pytest.mark.usefixtures("quick")
def test_only_a_failed_check_is_accepted(files: Campaign, tmp_path: Path) -> None:
    with pytest.raises(QuantityError, match="has not failed"):
        run(tmp_path, pulls=files.pulls, accept={"plausible": "because"})
    with pytest.raises(LayerjamError, match="unknown check"):
        run(tmp_path, pulls=files.pulls, accept={"plausibel": "because"})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("given", "kind", "words"),
    [
        ({}, FitError, "nothing to report"),
        ({"holdout": ["46.1kPa"]}, QuantityError, "requires --pulls"),
        ({"pulls": "pulls", "holdout": ["a lot"]}, QuantityError, "'repeat 3'"),
        ({"pulls": "pulls", "holdout": ["12kPa"]}, FitError, "pulls is reserved"),
        ({"pulls": "pulls", "holdout": ["94.5kPa"]}, FitError, "pulls is to calibrate on"),
        ({"pulls": "pulls", "calibrate_on": "pulls"}, QuantityError, "none is left"),
        ({"pulls": "pulls", "calibrate_on": "pulls", "holdout": ["1kPa"]}, QuantityError, "one of"),
        ({"pulls": "pulls", "depth": "bayesian"}, LayerjamError, "unknown depth"),
    ],
)
def test_what_cannot_be(
    files: Campaign, tmp_path: Path, given: dict[str, Any], kind: type[LayerjamError], words: str
) -> None:
    given = {k: getattr(files, v) if isinstance(v, str) and hasattr(files, v) else v
             for k, v in given.items()}  # fmt: skip
    with pytest.raises(kind, match=words):
        run(tmp_path, **given)
    assert list(tmp_path.iterdir()) == []


def test_an_option_takes_all_words_up_to_the_next() -> None:
    many = {p.option for p in load_command("report").parameters if p.help.greedy}
    assert many == {"--friction", "--pulls", "--validate", "--calibrate-on", "--holdout"}
    given = ["kapton", "--pulls", "a", "b", "c", "--json", "--out", "d"]
    wanted = ["kapton", "--pulls", "a", "--pulls", "b", "--pulls", "c", "--json", "--out", "d"]
    assert repeat_options(given, many) == wanted
    assert repeat_options(["--pulls=a", "b"], many) == ["--pulls=a", "b"]
    assert repeat_options(["--pulls", "a", "--", "b"], many) == ["--pulls", "a", "--", "b"]
