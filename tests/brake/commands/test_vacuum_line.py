"""`rise`: the answer in air and water, integrated and closed, and what is refused."""

from __future__ import annotations

import pytest

from layerjam.brake.commands.vacuum_line import rise
from layerjam.brake.fluid.line_file import LineFile, load_line
from layerjam.brake.fluid.timing import suggest_changes
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError, UnknownNameError

BENCH = """name = "bench"
[chamber]
volume = "12 mL"
[pump]
flow = "20 mL/s"
ultimate = "30 kPa"
[valve]
conductance = "0.04 L/(s bar)"
"""


def test_the_papers_line():
    air, water = (rise("choi2018", target="94.5 kPa", fluid=f) for f in ("air", "water"))
    assert air.rise_time == pytest.approx(3.9, rel=0.01)
    assert air.closed_form == pytest.approx(air.rise_time, rel=1e-8)
    assert water.rise_time == pytest.approx(1.5, rel=0.01)
    assert air.time_constant == pytest.approx(2.2533, rel=1e-4)
    assert (air.fall_by, water.fall_by) == ("pumps run backwards",) * 2
    assert any("inferred" in w for w in air.warnings)


def test_fall_by_valve_integrated_where_no_closed_form_holds():
    plain = rise(LineFile.read(BENCH, "a"), target="50 kPa")
    assert plain.fall_by == "valve"
    text = BENCH.replace('volume = "12 mL"', 'volume = "12 mL"\nshrink = "1e-9 mL/kPa"')
    shrinking = rise(LineFile.read(text, "a"), target="50 kPa")
    assert shrinking.closed_form is None
    assert shrinking.fall_time == pytest.approx(plain.fall_time, rel=1e-6)
    assert shrinking.rise_time == pytest.approx(plain.rise_time, rel=1e-6)


def test_what_cannot_be_reached_is_an_answer():
    answer = rise(LineFile.read(BENCH, "a"), target="72 kPa")
    assert answer.feasible is False
    assert answer.rise_time is answer.fall_time is None
    assert "never reached: at 71.3" in answer.reason
    boils = rise("choi2018", target="100 kPa", fluid="water")
    assert "boils" in boils.reason


def test_altitude():
    high = rise("choi2018", target="60 kPa", atmosphere="70 kPa")
    low = rise("choi2018", target="60 kPa")
    assert high.rise_time > low.rise_time
    with pytest.raises(QuantityError, match="exceeds atmospheric pressure"):
        rise("choi2018", target="80 kPa", atmosphere="70 kPa")


def test_what_is_refused():
    with pytest.raises(QuantityError, match="chamber.compliance: not given"):
        rise(LineFile.read(BENCH, "a"), target="50 kPa", fluid="water")
    with pytest.raises(UnknownNameError, match="fluid"):
        rise("choi2018", target="50 kPa", fluid="oil")
    with pytest.raises(QuantityError, match="target: 0"):
        rise("choi2018", target="0 kPa")
    with pytest.raises(QuantityError, match="no unit"):
        rise("choi2018", target="50")


TUBED = BENCH + '[tube]\nlength = "2 m"\nbore = "2 mm"\n'


@pytest.mark.slow
def test_a_tubes_delay_and_lag_are_said_where_they_matter():
    long = rise(LineFile.read(TUBED, "a"), target="50 kPa")
    assert long.tube_delay == pytest.approx(2.0 / 290.1, rel=1e-3)
    assert 0 < long.tube_lag < 0.05 * long.rise_time
    assert long.warnings == []
    strong = rise(LineFile.read(TUBED.replace("20 mL/s", "2 L/s"), "a"), target="50 kPa")
    said = " ".join(strong.warnings)
    assert "its resistance causes a lag of" in said and "Reynolds number is" in said
    # so strong and wide that the wave counts; counted where the tube is in cells
    wide = TUBED.replace("20 mL/s", "2 L/s").replace('"2 mm"', '"8 mm"')
    assert "a pressure wave takes 6.895 ms" in str(
        rise(LineFile.read(wide, "a"), target="50 kPa").warnings
    )
    cells = rise(LineFile.read(wide + "cells = 4\n", "a"), target="50 kPa")
    assert "pressure wave" not in str(cells.warnings)
    assert cells.record.imbalance < 1e-10
    none = rise(LineFile.read(BENCH, "a"), target="50 kPa")
    assert none.tube_delay is none.tube_lag is None


def test_fall_integrated_beside_its_closed_form():
    for line in ("choi2018", LineFile.read(BENCH, "a")):
        answer = rise(line, target="60 kPa")
        assert answer.fall_time == pytest.approx(answer.closed_form_fall, rel=1e-6)
    leaky = rise(LineFile.read(BENCH + '[leak]\nlaminar = "0.1 mL/s"\n', "a"), target="60 kPa")
    assert leaky.closed_form_fall is None
    assert leaky.fall_time < rise(LineFile.read(BENCH, "a"), target="60 kPa").fall_time


def test_a_pump_alone_is_not_said_to_balance_a_leak():
    assert (
        "the pump reaches its ultimate pressure"
        in rise(LineFile.read(BENCH, "a"), target="72 kPa").reason
    )


def test_what_would_make_it_faster():
    line = load_line("choi2018").line
    found = dict(suggest_changes(line, 94.5e3))
    assert found["half the volume"] == pytest.approx(found["as it is"] / 2, rel=1e-8)
    assert found["four pumps"] == pytest.approx(found["as it is"] / 2, rel=1e-8)
    assert found["as it is"] / found["water"] == pytest.approx(2.6, rel=0.01)
    assert found["0.5 L reservoir"] < 0.1
    wet = dict(suggest_changes(line, 60e3, water=True))
    assert wet["half the compliance"] == pytest.approx(wet["as it is"] / 2)
    assert wet["air in place of water"] > wet["as it is"]
    assert "tube half as long" in dict(suggest_changes(LineFile.read(TUBED, "a").line, 50e3))
    assert suggest_changes(LineFile.read(BENCH, "a").line, 72e3) == []


@pytest.mark.parametrize("words", [["94.5kPa"], ["60kPa", "--fluid", "water"], ["101325Pa"]])
def test_the_figure(tmp_path, words):
    path = tmp_path / "rise.svg"
    assert main(["rise", "choi2018", "--target", *words, "--figure", str(path)]) == (
        1 if words == ["101325Pa"] else 0
    )
    assert path.stat().st_size > 10_000
