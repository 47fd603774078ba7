"""A failed check has consequences: exit 4, no file; an acceptance stays with the numbers."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

import layerjam as lj
from layerjam.cli.main import main
from layerjam.core.errors import FileError, QuantityError, UnknownNameError
from layerjam.core.verdict import (
    Acceptance,
    Check,
    interval_check,
    judge,
    read_acceptances,
    remaining,
)
from layerjam.laboratory.commands import calibration
from layerjam.laboratory.identify.calibration.peaks import calibrate_peaks

FAILS = Check(name="agreement", level="failed", sentence="the pulls disagree")
LOOKS = Check(name="plausible", level="warning", sentence="the scale factor is unusual")
PASSES = Check(name="shape", sentence="the curves agree")


def test_a_verdict_follows_from_the_levels_of_its_checks() -> None:
    assert judge([PASSES, LOOKS, None]).verdict == "passed"
    assert judge([PASSES, FAILS]).verdict == "failed"
    rows = judge([PASSES, FAILS]).failed_checks
    assert rows == [{"name": "agreement", "reason": "the pulls disagree"}]
    assert [c.passed for c in (PASSES, LOOKS, FAILS)] == [True, False, False]


def test_one_failed_check_is_accepted_by_its_name() -> None:
    verdict = judge([FAILS, PASSES], {"Agreement": "new operator"}, ["scale_factor"], "a.toml")
    (decision,) = verdict.decisions
    assert verdict.verdict == "accepted" and not verdict.failed
    assert (decision.check, decision.reason, decision.file) == (
        "agreement",
        "new operator",
        "a.toml",
    )
    second = Check(name="repeats", level="failed", sentence="they scatter")
    assert judge([FAILS, second], {"agreement": "why"}).verdict == "failed"


@pytest.mark.parametrize("name", ["shape", "plausible"])
def test_accepting_a_check_that_has_not_failed_is_an_error(name: str) -> None:
    with pytest.raises(QuantityError, match="has not failed; failed: agreement"):
        judge([FAILS, LOOKS, PASSES], {name: "why"})


def test_an_unknown_check_is_answered_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean agreement"):
        judge([FAILS], {"agrement": "why"})


@pytest.mark.parametrize("text", ["agreement", "=why", "agreement=", "agreement= "])
def test_an_acceptance_needs_a_name_and_a_reason(text: str) -> None:
    with pytest.raises(QuantityError, match="needs a check and a reason"):
        read_acceptances([text])
    with pytest.raises(QuantityError, match="twice"):
        read_acceptances(["repeats=a", "Repeats=b"])


@pytest.mark.parametrize(
    ("value", "low", "high", "fails"),
    [
        (1.0, 0.9, 1.1, False),
        (1.0, 0.76, 1.25, False),
        (1.0, 0.74, 1.26, True),
        (1.0, -0.1, 0.2, True),
        (1.0, 0.0, 0.2, True),
        (51.3, -55.0, 157.0, True),
    ],
)
def test_an_interval_that_reaches_zero_or_is_wide_fails(
    value: float, low: float, high: float, fails: bool
) -> None:
    assert (interval_check("scale factor", value, low, high).level == "failed") is fails


def test_an_acceptance_ends_with_a_measurement_from_as_many_files() -> None:
    one = Acceptance(check="a", reason="b", date="2026-11-24", numbers=("x", "y"), files=3)
    passed = judge([], numbers=("x", "y"), files=3)
    assert remaining([one], passed) == ()
    assert remaining([one]) == remaining([one], judge([], numbers=("x", "y"), files=2)) == (one,)
    assert remaining([one], judge([], numbers=("x",), files=9))[0].numbers == ("y",)
    assert remaining([one], removals=["x"])[0].numbers == ("y",)
    unknown = replace(one, files=0)
    assert remaining([unknown], judge([], numbers=("x", "y"), files=1)) == (unknown,)
    assert remaining([unknown], passed) == ()
    fails = Check(name="other", level="failed", sentence="no")
    assert remaining([one], judge([fails], numbers=("x", "y"), files=9)) == (one,)
    accepted = judge([fails], {"other": "c"}, numbers=("x", "y"), files=9)
    assert remaining([one], accepted) == (one,)
    again = judge([replace(fails, name="stage.A")], {"stage.a": "c"}, ("x", "y"), files=1)
    assert remaining([one], again) == ()
    whole = Acceptance(check="a", reason="b", date="2026-11-24")
    assert remaining([whole], passed) == (whole,)


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Calibrations by peaks with one more check, which fails."""
    import dataclasses

    def with_failure(*given: object) -> object:
        fit = calibrate_peaks(*given)  # type: ignore[arg-type]
        return dataclasses.replace(fit, checks=(*fit.checks, FAILS))

    monkeypatch.setattr(
        "layerjam.laboratory.identify.calibration.peaks.calibrate_peaks", with_failure
    )
    assert calibration  # the command looks the function up when it runs


@pytest.fixture
def pulls(tmp_path: Path) -> list[str]:
    """Two pulls of the model, with sidecars."""
    paths = []
    for number, speed in enumerate(("13mm/s", "12mm/s")):
        path = tmp_path / f"pull-{number}.csv"
        pull = lj.tensile("choi2018-kapton", vacuum="80 kPa", speed=speed, travel="30 mm")
        pull.save(path)
        paths.append(str(path))
    return paths


def test_a_failed_check_exits_4_writes_nothing_and_its_acceptance_travels(
    failing: None, pulls: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, picture = tmp_path / "brake.toml", tmp_path / "fit.svg"
    words = ["calibrate", "choi2018-kapton", *pulls, "--vacuum", "80kPa", "--out", str(out)]
    assert main([*words, "--figure", str(picture), "--json"]) == 4
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "failed" and answer["scale_factor"] > 0
    assert answer["failed_checks"] == [{"name": "agreement", "reason": "the pulls disagree"}]
    assert {c["level"] for c in answer["checks"]} >= {"failed", "passed"}
    assert not out.exists() and not picture.exists()

    assert main([*words, "--accept", "agreement=new operator"]) == 0
    capsys.readouterr()
    (decision,) = lj.load(out).accepted
    assert (decision.check, decision.reason) == ("agreement", "new operator")
    assert set(decision.numbers) == {"scale_factor", "stiffness_measured"}

    assert main(["vacuum", str(out), "--slip", "20mm", "--force", "80N", "--json"]) == 0
    later = json.loads(capsys.readouterr().out)
    assert later["verdict"] == "accepted"
    (row,) = later["accepted"]
    assert (row["check"], row["reason"], row["file"]) == ("agreement", "new operator", str(out))
    assert any("new operator" in sentence for sentence in later["warnings"])

    assert main(["show", str(out)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert f"(failed check: agreement, accepted {decision.date})" in text

    assert main(["new", "next", "--from", str(out), "--out", str(tmp_path / "next.toml")]) == 0
    assert lj.load(tmp_path / "next.toml").accepted[0].reason == "new operator"
    assert main(["export", "c", str(out), "--out", str(tmp_path / "c")]) == 0
    header = (tmp_path / "c" / "brake.h").read_text()
    assert "new operator" in header


def test_a_new_fit_that_passes_ends_the_acceptance(
    pulls: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    first = tmp_path / "first.toml"
    text = lj.load("choi2018-kapton").text + (
        '\n[[accepted]]\ncheck = "agreement"\nreason = "r"\ndate = "2026-01-01"\n'
        'numbers = ["scale_factor", "stiffness_measured", "film.static"]\n'
    )
    first.write_text(text)
    out = tmp_path / "second.toml"
    assert main(["calibrate", str(first), *pulls, "--vacuum", "80kPa", "--out", str(out)]) == 0
    (left,) = lj.load(out).accepted
    assert left.numbers == ("film.static",)


def test_a_damaged_acceptance_is_refused_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "b.toml"
    path.write_text(lj.load("choi2018-kapton").text + '\n[[accepted]]\ncheck = "a"\n')
    with pytest.raises(FileError, match=r"line \d+: accepted: each \[\[accepted\]\]"):
        lj.load(path)
