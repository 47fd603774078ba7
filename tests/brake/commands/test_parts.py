"""`parts`: the catalogue as an answer, and on the command line."""

from __future__ import annotations

import json

import pytest

from layerjam.brake.commands.parts import parts
from layerjam.cli.main import main
from layerjam.core.errors import UnknownNameError


def test_all_of_them_with_units_and_sources():
    answer = parts()
    assert {"pumps", "valves", "sensors"} == set(answer.values)
    for entry in (*answer.pumps, *answer.valves, *answer.sensors):
        numbers = {**entry["numbers"], **entry["printed"]}
        assert set(numbers) == set(entry["sources"])
        assert set(numbers) <= set(answer.units)
    (valve,) = parts("festo-mh1-3-2").valves
    assert valve["missing"] == "conductance"
    assert "assumed" in valve["sources"]["critical_ratio"]


def test_one_by_name():
    answer = parts("smc-vt307v")
    assert (answer.pumps, answer.sensors, len(answer.valves)) == ([], [], 1)
    with pytest.raises(UnknownNameError, match="unknown part 'smc'"):
        parts("smc")


def printed(capsys, *words):
    assert main(["parts", *words]) == 0
    return capsys.readouterr().out


def test_for_people_and_machines(capsys):
    shown = printed(capsys)
    assert "smc-vt307v: SMC VT307V" in shown
    assert "assumed: critical ratio 0.528, delay 0 s" in shown
    assert "conductance not published" in shown
    assert "free flow 116.7 mL/s, ultimate vacuum 75 kPa" in shown
    told = printed(capsys, "dfr0523")
    assert "flow: 0.75 mL/s" in told and "GravityPump" in told
    found = json.loads(printed(capsys, "--json"))
    assert found["units"]["curve"] == "Pa, m^3/s"
    assert found["pumps"][0]["numbers"]["count"] == 2
