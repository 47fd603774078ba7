"""`export html`: its file, its digits in Node, its policy, and what it does not offer."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
import sys
from dataclasses import replace

import pytest

from brake.device.test_evidence import EVIDENCE
from interop.live_cases import as_program, check_answers, make_cases
from interop.test_refusals import ABSENT, file_of
from layerjam.brake.commands.edit import BRAKE_FIELDS
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.load import catalogue, load
from layerjam.cli.main import main
from layerjam.core.errors import FileError
from layerjam.core.units import show
from layerjam.core.verdict import Acceptance
from layerjam.workshop.commands.show import show as show_brake

pytest.importorskip("jinja2", reason="the extra report is not installed")

from layerjam.interop.commands.export import export_html
from layerjam.interop.html import make_html

LARGEST = 150_000


@pytest.mark.timing
def test_node_computes_the_digits_of_python():
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here")
    inputs = make_cases()
    assert sum(len(c["forces"]) for c in inputs["cases"]) == 1000
    run = subprocess.run(
        [node, "--input-type=module", "-"],
        input=as_program(inputs),
        capture_output=True,
        text=True,
        check=True,
    )
    check_answers(inputs, json.loads(run.stdout))


@pytest.mark.parametrize("name", sorted(catalogue()))
def test_every_brake_of_the_catalogue_is_one_small_file(name, tmp_path):
    made = export_html(name, out=tmp_path / "brake.html")
    text = (tmp_path / "brake.html").read_text("utf-8")
    assert made.live and made.bytes == len(text.encode()) <= LARGEST
    assert list(made.files) == ["brake.html"]
    assert not re.search(r"https?://(?!www\.w3\.org/2000/svg)|\bsrc=|@import|url\(", text)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', text)[1]
    assert policy.startswith("default-src 'none'; ") and "unsafe-inline" not in policy
    assert "unsafe-eval'" not in policy.replace("'wasm-unsafe-eval'", "")
    assert not re.search(r"<[^>]* style=", text) and not re.search(r"<[^>]* on\w+=", text)
    sources = {p: s for p, s in load(name).sources.items() if p in BRAKE_FIELDS}
    assert len(sources) > 10
    assert all(source.sentence() in html.unescape(text) for source in sources.values())


def test_equal_brakes_give_equal_bytes_and_a_rope_is_in_series():
    brake = load("choi2018-kapton")
    assert make_html(brake) == make_html(load("choi2018-kapton"))
    roped = make_html(brake, 16.8e3)
    stiffness = 1 / (1 / 131e3 + 1 / 16.8e3)
    assert repr(stiffness)[:12] in roped and "a rope of 16.8 kN/m in series" in roped


@pytest.mark.parametrize("law", ABSENT)
def test_a_law_that_the_kernel_lacks_is_not_offered_and_the_file_says_why(law, tmp_path, capsys):
    (tmp_path / "own.toml").write_text(file_of(law), encoding="utf-8")
    out = tmp_path / "brake.html"
    assert main(["export", "html", str(tmp_path / "own.toml"), "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["live"] is False and said["holds"] is None
    assert any(law in one for one in said["warnings"])
    text = out.read_text("utf-8")
    assert "is not offered for this brake" in text and law in text
    assert "<script" not in text and "script-src" not in text
    assert "default-src 'none'" in text


def test_titles_and_accepted_checks_are_on_the_page_as_text():
    brake = load("choi2018-kapton")
    object.__setattr__(brake, "title", "<script>alert(1)</script>")
    row = Acceptance(check="repeats", reason="new <b>operator</b>", date="2026-11-28")
    object.__setattr__(brake, "accepted", (row,))
    text = make_html(brake)
    assert text.count("<script") == 1 and "&lt;script&gt;alert" in text
    assert "new &lt;b&gt;operator&lt;/b&gt;" in text and "accepted, 1 failed check" in text


def test_the_numbers_have_intervals_and_the_page_states_what_was_tested():
    brake = load("choi2018-kapton")
    untested = make_html(brake)
    assert "Basis: handbook: no test of this brake." in untested
    assert "Tests of this brake cover" not in untested
    low, high = show_brake(brake).interval("holding_force")
    assert f"95 %: {show(low, 'N')} to {show(high, 'N')}" in untested
    spans = {"vacuum": (90e3, 95e3), "slip": (0.0, 0.03)}
    text = updated_text(brake, "own", {}, evidence=replace(EVIDENCE, ranges=spans))
    tested = make_html(BrakeFile.read(text, "own.toml"))
    assert "Tests of this brake cover vacuum 90 kPa to 95 kPa; slip 0 mm to 30 mm." in tested


def test_without_the_extra_nothing_is_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "jinja2", None)
    out = tmp_path / "brake.html"
    assert main(["export", "html", "choi2018-kapton", "--out", str(out)]) == 2
    assert '[report]"' in capsys.readouterr().err
    assert not out.exists()


def test_a_file_is_kept_unless_overwritten_and_a_soft_rope_is_warned_of(tmp_path, capsys):
    out = tmp_path / "brake.html"
    words = ["export", "html", "choi2018-kapton", "--out", str(out)]
    assert main([*words, "--rope-stiffness", "2kN/m", "--strict"]) == 1
    assert not out.exists()
    assert main(words) == 0
    before = out.read_bytes()
    with pytest.raises(FileError, match="already exists"):
        export_html("choi2018-ptfe", out=out)
    assert out.read_bytes() == before
    assert main([*words, "--overwrite", "--rope-stiffness", "2kN/m"]) == 0
    assert "would snap" in " ".join(capsys.readouterr().out.split())
    assert main([*words[:-1], str(tmp_path)]) == 2
    assert main([*words[:-1], str(tmp_path / "no" / "x.html")]) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["brake.html"]
