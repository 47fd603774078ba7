"""A requirement as a specification, and a design as a brake's file."""

from __future__ import annotations

from dataclasses import replace

import pytest

from layerjam.brake.commands.force import force
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, QuantityError
from layerjam.workshop.commands.compare import compare
from layerjam.workshop.commands.design import DesignResult, brake_of, design
from layerjam.workshop.commands.show import show
from layerjam.workshop.design.few_numbers import hold, stop
from layerjam.workshop.design.request import open_reader, read_request
from layerjam.workshop.design.specification import make_specification, read_spec
from layerjam.workshop.fabricate.lengths import compute_lengths
from workshop.design.problems import spec

KAPTON, PTFE = load("choi2018-kapton"), load("choi2018-ptfe")
HOLD = {"force": "300 N", "mass": "60 g", "width": "25 mm", "length": "175 mm"}
STOP = {"mass": "5 kg", "speed": "1 m/s", "travel": "50 mm", "force": "1 kN"}
SMALL = """
name = "small: / brake"
brake = "choi2018-kapton"
without = ["buildable", "drawn_mass"]
constraints = ["holding_force >= 300 N", "mass <= 60 g"]
objectives = ["minimise mass", "maximise energy_capacity"]
[[film]]
use = "choi2018-kapton"
[[film]]
use = "choi2018-ptfe"
[vary]
count = [11, 21, 31]
width = { from = "10 mm", to = "30 mm", step = "5 mm" }
vacuum = ["60 kPa", "90 kPa"]
"""


@pytest.fixture(scope="module")
def small() -> DesignResult:
    return design(read_spec(SMALL, "small", {}))


@pytest.mark.parametrize("file", [KAPTON, PTFE], ids=lambda f: f.name)
def test_a_requirement_is_a_specification_whose_grid_holds_what_is_asked(file):
    request = hold(file, file.name, **HOLD)
    asked = make_specification(request)
    assert read_request(open_reader(request.text(), "x")) == request
    rules = {c.name: c.limit for c in asked.constraints}
    assert rules == pytest.approx({"holding_force": 300, "mass": 0.06, "width": 0.025,
                                   "length": 0.175, "stress_margin": 2})  # fmt: skip
    sheets = file.brake.sheets
    # the widest and longest designs that are allowed are among them
    assert asked.grid.axes["width"].max() == pytest.approx(0.025)
    taken = compute_lengths(file.brake, file.making.build).overall / 1e3 - sheets.overlap
    assert asked.grid.axes["overlap"].max() + taken == pytest.approx(0.175)
    assert asked.grid.size < 2_000_000
    stops = read_spec(stop(file, file.name, **STOP).text(), "x", {})
    asked_stop = stops.evaluation.stop
    assert (asked_stop.mass, asked_stop.speed, asked_stop.travel, asked_stop.force) == (
        5,
        1,
        0.05,
        1000,
    )
    assert asked_stop.horizontal and stops.grid.size < 2_000_000


def test_a_requirement_of_the_users_own_brake_names_its_file():
    own = replace(KAPTON, name="mine")
    text = hold(own, "mine.toml", **HOLD, stress_margin=0).text()
    asked = read_spec(text, "x", {"mine.toml": own})
    assert asked.brake is own and "stress_margin" not in text
    with pytest.raises(FileError, match="unknown brake 'mine.toml'"):
        read_spec(text, "x", {})


@pytest.mark.parametrize(
    ("change", "words"),
    [({"force": "0 N"}, "force"), ({"mass": "60 mm"}, "mass"), ({"length": "30 mm"}, "too short"),
     ({"width": "-1 mm"}, "width")],
)  # fmt: skip
def test_requirements_that_are_none(change, words):
    with pytest.raises(QuantityError, match=words):
        hold(KAPTON, KAPTON.name, **{**HOLD, **change})
    with pytest.raises(QuantityError, match="speed"):
        stop(KAPTON, KAPTON.name, **{**STOP, "speed": "1 m"})


def test_no_margin_where_no_strength_is_known():
    film = replace(KAPTON.brake.film, strength=None)
    weak = replace(KAPTON, brake=replace(KAPTON.brake, film=film))
    with pytest.raises(QuantityError, match="unknown"):
        hold(weak, weak.name, **HOLD)
    assert "stress_margin" not in hold(weak, weak.name, **HOLD, stress_margin=0).text()


def test_no_file_is_opened_where_none_is_given(tmp_path):
    own = tmp_path / "own.toml"
    own.write_text(KAPTON.text)
    for name in (own.as_posix(), "own.toml", "/etc/passwd", "../x.toml"):
        for line in (f'brake = "{name}"', f'brake = "choi2018-kapton"\nline = "{name}"',
                     f'brake = "choi2018-kapton"\n[[film]]\nuse = "{name}"'):  # fmt: skip
            with pytest.raises(FileError, match="unknown"):
                read_spec(f'objectives = ["minimise mass"]\n{line}\n', tmp_path / "spec.toml", {})


def test_a_design_as_a_brake_gives_the_numbers_of_the_search(small):
    rows = {d["number"]: d for d in [*small.front, small.chosen, small.runner_up] if d}
    assert {d["film"] for d in rows.values()}
    for number, row in list(rows.items())[::3]:
        file = BrakeFile.read(brake_of(small, number).text, "x")
        (told,) = compare(file, vacuum=row["vacuum"]).devices[:1]
        assert told["mass"] == pytest.approx(row["mass"], rel=1e-9)
        assert told["max_force"] == pytest.approx(row["max_force"], rel=1e-9)
        shown = show(file)
        assert shown.stiffness_measured == pytest.approx(row["stiffness"], rel=1e-9)
        held = shown.holding_force * row["vacuum"] / file.brake.site.atmosphere
        assert held == pytest.approx(row["holding_force"], rel=1e-9)


def test_the_design_between_the_steps_likewise(small):
    file = brake_of(small)
    told = compare(file, vacuum=small.refined["vacuum"]).devices[0]
    assert told["mass"] == pytest.approx(small.refined["mass"], rel=1e-9)
    assert told["max_force"] == pytest.approx(small.refined["max_force"], rel=1e-9)
    assert file.name.endswith("-refined") and "/" not in file.name


def test_what_was_measured_on_another_brake_is_said_to_be_assumed(small):
    file = brake_of(small, small.chosen["number"])
    kinds = {p: s.kind for p, s in file.sources.items()}
    assert {kinds[p] for p in ("scale_factor", "stiffness_measured", "fittings_mass")} == {
        "assumed"
    }
    assert kinds["sheets.width"] == "inferred" and kinds["film.static"] == "paper"
    assert any("scale_factor" in w and "assumed" in w for w in file.warnings())
    assert force(file, slip="1 mm", vacuum="90 kPa").warnings


def test_numbers_that_are_no_design(small):
    for number in (-1, small.designs, 1.5):
        with pytest.raises(QuantityError, match="number"):
            brake_of(small, number)


def test_a_brake_that_tears_is_given_only_where_that_was_accepted():
    """Stress by hand: a (n - 1) mu P W L2 over n/2 sections W t, of a film of 2 MPa."""
    weak = KAPTON.with_(strength="2 MPa")
    vary = "count = { from = 10, to = 14, step = 2 }"
    text = spec(vary, ["holding_force >= 100 N"], ["minimise mass"])
    asked = read_spec(text.replace("choi2018-kapton", "weak.toml"), "x", {"weak.toml": weak})
    torn = design(asked)
    [failed] = torn.failed_checks
    assert (failed["name"], torn.exit_code, torn.verdict) == ("sheet strength", 4, "failed")
    number = torn.chosen["number"]
    with pytest.raises(QuantityError, match="check 'sheet strength' failed"):
        brake_of(torn, number)
    accepted = design(asked, accept={"sheet strength": "a weaker film for a test"})
    brake = brake_of(accepted, number).brake
    sheets, film = brake.sheets, brake.film
    friction = brake.scale_factor * film.kinetic * (sheets.count - 1) * torn.chosen["vacuum"]
    friction *= sheets.width * sheets.overlap
    assert friction / (sheets.count / 2 * sheets.width * sheets.thickness) > 1.5 * film.strength
