"""Force over mass: ours from the mass model, others from their sources, nothing invented."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.strategies import KAPTON

from layerjam.brake.device.brake import mass, sheet_mass
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, QuantityError, UnknownNameError
from layerjam.workshop.commands.compare import compare
from layerjam.workshop.commands.show import show
from layerjam.workshop.design.force_density import (
    added_sheet_effect,
    make_sheet_line,
    peak_force,
    set_sheet_count,
)
from layerjam.workshop.design.published import published_devices, read_published_devices

GOOD = """
[paper-sheet]
name = "a sheet"
class = "sheet"
words = "one more"
mass = { value = "0.4 g", source = "a paper" }
force = { value = "17.5 N", source = "a paper" }
[one]
name = "One"
class = "brake"
words = "2 kg, 3 N m"
mass = { value = "2 kg", source = "a sheet" }
torque = { value = "3 N m", source = "a sheet" }
lever = { value = "60 mm", source = "half of its diameter" }
[looked_for]
"other" = "nothing"
"""


def test_a_brake_stands_here_as_in_show() -> None:
    row = compare("choi2018-kapton").devices[0]
    shown = show("choi2018-kapton")
    assert row["mass"] == shown.mass and row["max_force"] == shown.max_force
    assert row["force_density"] == shown.force_density
    assert row["computed"] is True and row["vacuum"] == 101325.0


def test_every_row_has_mass_force_and_a_source() -> None:
    answer = compare()
    names = [r["name"] for r in answer.devices]
    assert len(set(names)) == len(names)
    for row in answer.devices:
        assert row["mass"] > 0 and row["max_force"] > 0
        assert row["force_density"] == pytest.approx(row["max_force"] / row["mass"], rel=1e-12)
        assert len(row["source"]) > 20
        assert row["source"].startswith("computed") == row["computed"]
    kinds = {r["kind"] for r in answer.devices}
    assert not kinds & set(answer.none_found)
    # the classes of Fig. 12 are there, drawn or missed
    said = kinds | set(answer.none_found)
    assert {"MR brake", "hydraulic shock absorber", "air dashpot", "electroadhesive clutch"} <= said


def test_stacked_brakes_keep_their_density_and_less_vacuum_loses_it() -> None:
    rows = compare("choi2018-kapton").devices
    one = rows[0]
    for row in (r for r in rows if r["brakes"] > 1):
        assert row["max_force"] == pytest.approx(row["brakes"] * one["max_force"])
        assert row["force_density"] == pytest.approx(one["force_density"])
    lower = [r for r in rows if r["computed"] and r["brakes"] == 1]
    order = sorted(lower, key=lambda r: r["vacuum"])
    assert np.all(np.diff([r["force_density"] for r in order]) > 0)


def test_one_more_sheet_against_the_paper() -> None:
    """Section III-F: 17.5 N and 0.4 g. An interface is 17.543 N; the sleeve grows by 2 wall t L."""
    force, weight = added_sheet_effect(KAPTON, 94.5e3)
    interface = 0.875 * 0.24 * 0.013 * 0.068 * 94.5e3
    # the sleeve's e^2/4c part of the peak is a root coefficient squared over n - 1 interfaces
    c = 0.875 * 0.24 * 0.013 * 94.5e3
    e_squared = 4 * (0.1e6 * 0.013 * 1e-3) * (0.80 * 0.013 * 94.5e3)
    lost = e_squared / (4 * c) * (1 / 10 - 1 / 11)
    assert force == pytest.approx(interface - lost, rel=1e-9)
    assert force == pytest.approx(17.5, abs=0.05)
    sleeve = 2 * 1e-3 * 0.254e-3 * 0.090 * KAPTON.enclosure.density
    assert weight == pytest.approx(sheet_mass(KAPTON) + sleeve, rel=1e-9)
    assert sheet_mass(KAPTON) == pytest.approx(0.4e-3, rel=5e-3)
    sheet = compare("choi2018-kapton").sheet
    assert (sheet["paper_force"], sheet["paper_mass"]) == (17.5, pytest.approx(0.4e-3))
    assert sheet["force_per_sheet"] == force and sheet["mass_per_sheet"] == weight
    assert sheet["vacuum"] == 94.5e3


def test_more_sheets_approach_the_density_of_a_sheet() -> None:
    line = make_sheet_line("kapton", KAPTON, 94.5e3)
    density = np.array(line.forces) / np.array(line.masses)
    assert np.all(np.diff(density) > 0)
    many = set_sheet_count(KAPTON, 10_000)
    interface = 0.875 * 0.24 * 0.013 * 0.068 * 94.5e3
    _, weight = added_sheet_effect(KAPTON, 94.5e3)
    assert peak_force(many, 94.5e3) / mass(many) == pytest.approx(interface / weight, rel=5e-3)
    assert line.sheets[0] == 11 and line.forces[0] == peak_force(KAPTON, 94.5e3)


def test_a_weighed_brake_gains_what_the_model_says() -> None:
    weighed = replace(KAPTON, weighed_mass=0.025)
    gain = mass(set_sheet_count(KAPTON, 21)) - mass(KAPTON)
    assert mass(set_sheet_count(weighed, 21)) == pytest.approx(0.025 + gain, rel=1e-12)


def test_vacuum_and_brakes_are_taken_as_given() -> None:
    answer = compare("choi2018-ptfe", "choi2018-kapton", vacuum="30 kPa")
    ours = [r for r in answer.devices if r["computed"] and r["brakes"] == 1]
    assert [r["vacuum"] for r in ours] == [30e3, 30e3, 20e3]
    assert ours[0]["name"].startswith("choi2018-ptfe")
    with pytest.raises(QuantityError, match="exceeds atmospheric pressure"):
        compare("choi2018-kapton", vacuum="120 kPa")
    with pytest.raises(UnknownNameError):
        compare("no-such-brake")
    high = compare("choi2018-kapton", atmosphere="70 kPa")
    assert high.devices[0]["vacuum"] == 70e3 and high.sheet["vacuum"] == 70e3


def test_friction_that_was_not_measured_is_said() -> None:
    rows = {r["name"].split(",")[0]: r for r in compare().devices if r["brakes"] == 1}
    assert "not measured" in rows["choi2018-polyester"]["note"]
    assert rows["choi2018-kapton"]["note"] == ""


def test_a_torque_becomes_a_force_at_its_lever() -> None:
    found = read_published_devices(GOOD, "x.toml")
    (one,) = found.devices
    assert one.force == pytest.approx(3 / 0.06) and one.density == pytest.approx(25)
    assert "half of its diameter" in one.source() and "'2 kg, 3 N m'" in one.source()
    assert found.sheet.force == 17.5


def test_the_catalogue_names_a_source_and_words_for_every_number() -> None:
    for device in (*published_devices().devices, published_devices().sheet):
        assert all(len(s.text) > 10 for s in device.sources.values()), device.name
        digits = f"{device.mass * (1e3 if device.mass < 1 else 1):g}"
        assert digits in device.words, device.name
        told = device.torque if device.torque is not None else device.force
        assert f"{told:g}" in device.words, device.name
        if device.lever is not None:
            assert f"D1 {2e3 * device.lever:g}" in device.words


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('words = "2 kg, 3 N m"\n', "", "no words"),
        ('class = "brake"\n', "", "no class"),
        ('lever = { value = "60 mm", source = "half of its diameter" }\n', "", "needs a mass"),
        ('mass = { value = "2 kg", source = "a sheet" }\n', "", "needs a mass"),
        ('"2 kg", source = "a sheet"', '"2 kg"', "names no source for mass"),
        ('"2 kg", source', '"0 kg", source', "mass"),
        ('"other" = "nothing"', '"brake" = "nothing"', "listed here and again"),
        ("[paper-sheet]", "[paper-leaf]", "is missing"),
        ('[one]\nname = "One"', '[one]\nforce = { value = "1 N", source = "x" }\nname = "One"',
         "needs a mass"),
        ("lever =", "leaver =", "lever"),
    ],
)  # fmt: skip
def test_a_catalogue_that_says_too_little_is_refused(old: str, new: str, said: str) -> None:
    assert old in GOOD
    with pytest.raises(FileError, match=said):
        read_published_devices(GOOD.replace(old, new), "x.toml")


@pytest.mark.slow
def test_the_picture_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from layerjam.workshop.figures.density_figures import draw_density, save

    answer = compare("choi2018-kapton", "choi2018-polyester")
    rows, lines, others = answer.record
    figure = draw_density(rows, lines, answer.sheet, list(others.looked_for))
    (axes,) = figure.axes
    words = " ".join(t.get_text() for t in axes.texts)
    assert axes.get_xscale() == axes.get_yscale() == "log"
    for row in rows:
        x, y = row["mass"] * 1e3, row["max_force"]
        drawn = [line for line in axes.lines if len(line.get_xdata()) == 1]
        assert any(
            line.get_xdata()[0] == pytest.approx(x) and line.get_ydata()[0] == pytest.approx(y)
            for line in drawn
        ), row["name"]
    assert "321 sheets" in words and "10 kN/kg" in words and "friction not measured" in words
    assert "MR brake" in figure._supxlabel.get_text().replace("\n", " ")
    save(figure, tmp_path / "d.svg")
    assert (tmp_path / "d.svg").stat().st_size > 1000


def test_the_brake_of_a_file_is_taken(tmp_path: Path) -> None:
    text = load("choi2018-kapton").text.replace("value = 11,", "value = 22,")
    (tmp_path / "wide.toml").write_text(text)
    row = compare(tmp_path / "wide.toml").devices[0]
    assert row["sheets"] == 22


def test_calibrated_beside_uncalibrated_is_said(tmp_path: Path) -> None:
    def said(*names: str | Path) -> list[str]:
        warnings = compare(*map(str, names)).warnings
        key = "calibrated-with-uncalibrated"
        return [str(w) for w in warnings if getattr(w, "key", "") == key]

    (both,) = said("choi2018-kapton", "choi2018-polyester", "choi2018-ptfe-fiberglass")
    calibrated, not_so = both.split("calibrated,")
    assert "choi2018-kapton" in calibrated
    assert "choi2018-polyester" in not_so and "choi2018-ptfe-fiberglass" in not_so
    assert not said("choi2018-kapton", "choi2018-ptfe")
    assert not said("choi2018-polyester", "choi2018-ptfe-fiberglass")
    # a factor that stands in a file without a word on where it comes from is none
    text = load("choi2018-ptfe").text
    own = tmp_path / "own.toml"
    start = text.index("[scale_factor]")
    end = text.index("\n\n", start)
    body, table = text[:start] + text[end:], text.index("\n[")
    own.write_text(body[:table] + "\nscale_factor = 1.24\n" + body[table:], encoding="utf-8")
    assert load(own).brake.scale_factor == 1.24
    assert said("choi2018-kapton", own)
    rows = {r["name"].split(",")[0]: r["calibrated"] for r in compare().devices if r["computed"]}
    assert rows["choi2018-kapton"] is True and rows["choi2018-polyester"] is False
