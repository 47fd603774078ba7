"""Failed checks of a build: exit code 4, no file, and acceptances that the folder states."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pypdfium2
import pytest

import layerjam as lj
from built_parts import KAPTON, some_brakes
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.device.workshop import Build
from layerjam.brake.mechanics.limits import clamp_stress, greatest_force
from layerjam.cli.main import main
from layerjam.core.errors import FileError, LayerjamError, QuantityError, UnknownNameError
from layerjam.workshop.commands.build import judge_build
from layerjam.workshop.fabricate.checks import seal_check
from layerjam.workshop.fabricate.choices import resolve_choices
from layerjam.workshop.fabricate.drawing import draw_build
from layerjam.workshop.fabricate.lengths import compute_lengths

THIN = KAPTON.with_(thickness="25.4 um")


def with_rows(*rows: str) -> BrakeFile:
    return BrakeFile.read("\n".join([KAPTON.text, "[build]", *rows, ""]), "mine.toml")


def row(found: lj.Result, key: str) -> dict:
    (one,) = (check for check in found.checks if check["key"] == key)
    return one


FAILING = {
    "sheets that tear": (THIN, "C7"),
    "a print that breaks": (with_rows('print_strength = "5 MPa"'), "C9"),
    "a seal that leaks": (with_rows('tie_tension = "2 N"'), "C11"),
}


@pytest.mark.parametrize("name", sorted(FAILING))
def test_what_breaks_or_leaks_is_not_written(name: str, tmp_path: Path) -> None:
    file, code = FAILING[name]
    found = lj.build(file, out=tmp_path / "x", no_step=True)
    assert (found.feasible, found.exit_code, found.verdict) == (False, 4, "failed")
    assert {one["name"] for one in found.failed_checks} == {code}
    assert (found.reason or "").startswith(f"{code}: ") and found.files == []
    assert {c["level"] for c in found.checks if c["code"] == code} >= {"failed"}
    assert list(tmp_path.iterdir()) == []


def test_the_stress_that_tears_thin_sheets_is_force_over_section() -> None:
    """Five sheets of one side, 13 mm wide less a hole of 3 mm."""
    found = judge_build(THIN)
    net, force = row(found, "sheet-net"), found.record.force
    assert net["value"] == pytest.approx(force / (5 * 10e-3 * 25.4e-6), rel=1e-9)
    assert net["value"] > 2.5 * net["limit"] and net["limit"] == 69e6


def test_an_accepted_failure_is_stated_by_every_page(tmp_path: Path) -> None:
    place = tmp_path / "thin"
    why = "only pulled by hand"
    found = lj.build(THIN, out=place, no_step=True, accept={"C7": why})
    assert (found.feasible, found.exit_code, found.verdict) == (True, 0, "accepted")
    listed = json.loads((place / "build.json").read_text("utf-8"))
    assert listed["verdict"] == "accepted" and listed["failed_checks"] == []
    (one,) = listed["accepted"]
    assert (one["check"], one["reason"]) == ("C7", why) and len(one["date"]) == 10
    assert "MPa" in one["finding"]
    assert any("C7" in w and why in w for w in listed["warnings"])
    for name in ("cut/sheet.dxf", "cut/sheet.svg", "cut/film-1.dxf"):
        assert f"Check C7 failed; accepted on {one['date']}: {why}" in (place / name).read_text()
    for name in ("assembly.pdf", "cut/pattern.pdf"):
        with pypdfium2.PdfDocument(place / name) as pages:
            words = " ".join(page.get_textpage().get_text_range() for page in pages)
        assert why in " ".join(words.split()), name


@pytest.mark.slow
def test_what_the_brakes_file_accepted_travels_into_the_folder(tmp_path: Path) -> None:
    text = KAPTON.text + (
        '\n[[accepted]]\ncheck = "repeats"\nreason = "new operator"\ndate = "2026-01-02"\n'
    )
    found = lj.build(BrakeFile.read(text, "mine.toml"), out=tmp_path / "x", no_step=True)
    listed = json.loads((tmp_path / "x" / "build.json").read_text("utf-8"))
    assert [one["check"] for one in listed["accepted"]] == ["repeats"]
    assert found.accepted == listed["accepted"] and listed["verdict"] == "accepted"
    assert "accepted on 2026-01-02: new operator" in (tmp_path / "x/cut/sheet.svg").read_text()


def test_acceptances_that_make_no_sense(tmp_path: Path, capsys) -> None:
    place = tmp_path / "x"
    with pytest.raises(QuantityError, match="check 'C11' has not failed; failed: C7"):
        lj.build(THIN, out=place, accept={"C11": "why not"})
    with pytest.raises(UnknownNameError, match="C77"):
        lj.build(THIN, out=place, accept={"C77": "why not"})
    narrow = KAPTON.with_(width="7 mm", screw_hole="3 mm")
    with pytest.raises(QuantityError, match="accept: C4: the brake cannot be drawn, 7 mm of width"):
        lj.build(narrow, out=place, accept={"C4": "why not"})
    words = ["build", "choi2018-kapton", "--out", str(place), "--no-step"]
    assert main([*words, "--accept", "C7"]) == 2
    assert "needs a check and a reason" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_command_line_has_the_exit_codes(tmp_path: Path, capsys) -> None:
    brake = tmp_path / "thin.toml"
    brake.write_text(THIN.render("thin"), "utf-8")
    words = ["build", str(brake), "--out", str(tmp_path / "x"), "--no-step"]
    assert main([*words, "--json"]) == 4
    said = json.loads(capsys.readouterr().out)
    assert said["feasible"] is False and said["verdict"] == "failed"
    assert [one["name"] for one in said["failed_checks"]] == ["C7"]
    assert main(words) == 4
    printed = capsys.readouterr().out
    assert "FAIL  C7" in printed and "FAILED: C7: sheets" in printed
    assert '--accept "C7=REASON"' in printed
    assert sorted(tmp_path.iterdir()) == [brake]


def test_the_load_path_decides_what_of_c7_applies() -> None:
    """Friction carries the paper's brake; with 20 times the force the screws must."""
    weak = judge_build(KAPTON)
    for key in ("sheet-bearing", "sheet-tearing"):
        found = row(weak, key)
        assert found["ok"] is None and found["level"] == "note"
        assert "friction in the clamp carries the load (C8)" in found["text"]
    tearing = row(weak, "sheet-tearing")
    assert tearing["value"] == pytest.approx(65.83e6, rel=1e-3)
    assert tearing["limit"] == pytest.approx(69e6 / math.sqrt(3))
    assert row(weak, "clamp-preload")["ok"] is True and weak.feasible
    strong = judge_build(KAPTON.with_(scale_factor=20.0))
    clamp, bearing = row(strong, "clamp-preload"), row(strong, "sheet-bearing")
    assert (clamp["ok"], clamp["level"]) == (False, "warning")
    assert (bearing["ok"], bearing["level"]) == (False, "failed")
    assert "the screw carries the load" in bearing["text"]
    assert [one["name"] for one in strong.failed_checks] == ["C7"] * 3


def test_a_film_of_unknown_strength_must_be_held_by_friction() -> None:
    brake = KAPTON.brake.with_(scale_factor=20.0)
    found = judge_build(
        BrakeFile.from_record(replace(brake, film=replace(brake.film, strength=None)))
    )
    assert row(found, "sheet-bearing")["ok"] is None
    assert row(found, "clamp-preload")["level"] == "failed"


def test_the_default_neck_seals_every_brake_wider_than_20_mm() -> None:
    """Pressure of a band under tension T on a radius of curvature r: T over r and the width."""
    wide = 0
    for brake in (b for seed in (5, 6, 7) for b in some_brakes(seed, 60)):
        try:
            found = compute_lengths(brake, Build())
        except LayerjamError:
            continue
        wide += brake.sheets.width >= 0.02
        a, b = found.neck_a * 1e-3, found.neck_b * 1e-3
        flattest = max(a**2 / b, b**2 / a)
        assert Build().tie_tension / flattest / Build().tie_width >= 2 * brake.site.atmosphere
        assert seal_check(brake, Build(), found).ok
    assert wide >= 76


BLAMED = {
    "air_bore": 'air_bore = "9 mm"',
    "wall": 'wall = "7 mm"',
    "core_clearance": 'core_clearance = "1.5 mm"',
    "key_clearance": 'mould_bolt = "8 mm"\nkey_clearance = "2 mm"',
    "sprue": 'sprue = "6 mm"',
    "trim": 'trim = "3 mm"',
    "mould_wall": 'mould_wall = "1.2 mm"',
}


@pytest.mark.parametrize("name", sorted(BLAMED))
def test_the_error_names_what_was_typed_and_its_line(name: str) -> None:
    rows = BLAMED[name]
    with pytest.raises(FileError, match=rf"build\.{name}: ") as caught:
        judge_build(with_rows(rows))
    text = [*KAPTON.text.split("\n"), "[build]", *rows.split("\n")]
    *_, line = (k for k, words in enumerate(text, 1) if words.startswith(f"{name} = "))
    assert caught.value.line == line


SCREWS = ((3.2e-3, 6.5e-3, 5.03e-6), (4.3e-3, 8e-3, 8.78e-6), (5.3e-3, 9.5e-3, 14.2e-6))
"""Hole and clamped length [m] for M3, M4 and M5, and the thread's stress area [m²] (ISO 898-1)."""


def sensible_brakes(seed: int, count: int) -> list[BrakeFile]:
    """Brakes like those of the catalogue, in sizes that somebody would make.

    Whoever chose them left a margin of two on the film's strength, and took the smallest screws of
    class 8.8 that hold the sheets by friction.
    """
    rng = np.random.default_rng(seed)
    made: list[BrakeFile] = []
    while len(made) < count:
        file = load(("choi2018-kapton", "choi2018-polyester", "choi2018-ptfe")[len(made) % 3])
        overlap, free = float(rng.uniform(30e-3, 100e-3)), float(rng.uniform(8e-3, 15e-3))
        changes = {
            "count": int(rng.integers(4, 26)),
            "thickness": float(rng.choice([0.127e-3, 0.178e-3, 0.254e-3])),
            "width": float(rng.uniform(12e-3, 60e-3)),
            "overlap": overlap,
            "usable_travel": 0.8 * overlap,
            "free_left": free,
            "free_right": free,
        }
        for hole, clamped, area in SCREWS:
            sizes = {"length": overlap + free + clamped, "clamped_length": clamped}
            brake = file.brake.with_(**changes, **sizes, screw_hole=hole)
            force, screws = float(greatest_force(brake)), max(1, round(brake.sheets.width / 20e-3))
            strength = brake.film.strength
            weak = strength is not None and float(clamp_stress(force, brake)) > strength / 2
            holds = 2 * brake.film.kinetic * screws * 0.75 * 580e6 * area
            if force <= holds and not weak:
                made.append(file.with_(**changes, **sizes, screw_hole=hole))
                break
    return made


@pytest.mark.slow
def test_false_alarms_of_sensible_brakes() -> None:
    """The shares that the page on building states, of 120 brakes."""
    alarms: dict[str, int] = {}
    for file in sensible_brakes(17, 120):
        found = draw_build(file, resolve_choices(file), float(greatest_force(file.brake)))
        for code in {check.code for check in found.checks if check.level in ("warning", "failed")}:
            alarms[code] = alarms.get(code, 0) + 1
    hard = {code: n for code, n in alarms.items() if code not in ("C6", "C8", "C12", "C13", "C14")}
    assert sum(hard.values()) <= 6, alarms  # 5 %
    assert alarms.keys() <= {"C6", "C13", "C14", *hard}, alarms
    print(alarms)
