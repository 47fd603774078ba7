"""`--film NAME` for one call, `catalogue`, and which of the compared brakes are calibrated."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import layerjam as lj
from layerjam.brake.commands.film import replace_film
from layerjam.cli.main import main
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.errors import UnknownNameError

KAPTON, PTFE = "choi2018-kapton", "choi2018-ptfe"
AT = {"slip": 0.02, "vacuum": 5e4}
PREDICTING = {
    *("force", "vacuum", "tensile", "show", "drop", "tune", "stick-slip", "bend", "array"),
}


def test_the_friction_is_that_of_the_film_with_factor_one() -> None:
    force = lj.force(KAPTON, film="ptfe", **AT)
    by_hand = 0.075 * 10 * 0.013 * (0.068 - 0.02) * 5e4
    assert force.sheet_friction == pytest.approx(by_hand, rel=1e-12)
    # the enclosure rubs on PTFE, as in the paper's brake of PTFE
    assert force.enclosure_force == pytest.approx(lj.force(PTFE, **AT).enclosure_force, rel=1e-12)
    assert any("film.kinetic" in w and "handbook" in w for w in force.warnings)
    assert lj.force(KAPTON, **AT).sheet_friction == pytest.approx(0.875 * 0.24 / 0.075 * by_hand)


def test_the_film_of_a_brake_brings_its_scale_factor() -> None:
    of_brake = lj.force(KAPTON, film=PTFE, **AT)
    assert of_brake.force == pytest.approx(lj.force(PTFE, **AT).force, rel=1e-12)
    same = lj.show(KAPTON, film=KAPTON)
    for key, value in lj.show(KAPTON).values.items():
        if isinstance(value, float):
            assert same.values[key] == pytest.approx(value, rel=1e-12), key


def test_spreads_sources_and_measurements_follow_the_film(tmp_path: Path) -> None:
    file = lj.load(KAPTON).with_(weighed_mass="20 g")
    new = replace_film(file, "ptfe")
    assert new.sources["film.kinetic"].spread == "0.05 to 0.10"
    assert new.sources["scale_factor"].kind == "assumed" and not new.is_calibrated
    sheets, film = file.brake.sheets, new.brake.film
    volume = sheets.count * sheets.length * sheets.width * sheets.thickness
    lighter = lj.laws.mass(file.brake) - lj.laws.mass(new.brake)
    by_hand = volume * (file.brake.film.density - film.density)
    assert lighter == pytest.approx(by_hand, rel=0.02)  # the holes and corners of a sheet
    mounts = [
        1 / f.brake.stiffness_measured - 1 / float(lj.laws.stiffness_before_slip(f.brake))
        for f in (file, new)
    ]
    assert mounts[0] == pytest.approx(mounts[1], rel=1e-9)
    path = file.save(tmp_path / "mine.toml")
    assert lj.force(KAPTON, film=str(path), **AT).force == pytest.approx(
        lj.force(KAPTON, **AT).force
    )


def test_every_predicting_command_has_the_option() -> None:
    having = {n for n in commands() if any(p.name == "film" for p in load_command(n).parameters)}
    assert having == PREDICTING
    with pytest.raises(UnknownNameError, match="unknown film 'ptf'; did you mean ptfe"):
        lj.force(KAPTON, film="ptf", **AT)


def test_the_catalogue_lists_every_name_with_a_source(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["catalogue", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    names = {key: {row["name"] for row in listed[key]} for key in listed if key[-1] == "s"}
    assert {KAPTON, PTFE} <= names["brakes"] and "choi2018" in names["lines"]
    assert {"wrist", "stop"} == names["designs"] and "smc-vt307v" in names["valves"]
    for film in names["films"]:
        assert lj.force(KAPTON, film=film, **AT).force > 0
    for key in ("brakes", "films", "lines", "pumps", "valves", "sensors"):
        assert all(row["source"] and row["title"] for row in listed[key]), key
    text = str(lj.catalogue())
    assert all(f"  {name}: " in text for key in names if key != "warnings" for name in names[key])


def test_the_catalogue_is_still_a_list_of_brakes() -> None:
    found = lj.catalogue()
    assert KAPTON in found and found[0] in [*found] and len(found) == len([*found]) == 6


def test_a_comparison_says_first_which_brakes_are_calibrated() -> None:
    mixed = lj.compare(KAPTON, "choi2018-polyester")
    first = str(mixed).splitlines()[0]
    assert first == "calibration  choi2018-kapton calibrated; choi2018-polyester not calibrated"
    assert lj.compare(KAPTON, PTFE).calibration is None
