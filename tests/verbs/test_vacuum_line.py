"""`rise`: the answer in air and water, integrated and closed, and what is refused."""

from __future__ import annotations

import pytest

from layerjam.errors import FitError, QuantityError, UnknownNameError
from layerjam.fluid.file import read_line
from layerjam.verbs.vacuum_line import rise

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
    plain = rise(read_line(BENCH, "a"), target="50 kPa")
    assert plain.fall_by == "valve"
    text = BENCH.replace('volume = "12 mL"', 'volume = "12 mL"\nshrink = "1e-9 mL/kPa"')
    shrinking = rise(read_line(text, "a"), target="50 kPa")
    assert shrinking.closed_form is None
    assert shrinking.fall_time == pytest.approx(plain.fall_time, rel=1e-6)
    assert shrinking.rise_time == pytest.approx(plain.rise_time, rel=1e-6)


def test_what_cannot_be_reached_is_an_answer():
    answer = rise(read_line(BENCH, "a"), target="72 kPa")
    assert answer.feasible is False
    assert answer.rise_time is answer.fall_time is None
    assert "never reached: at 71.3" in answer.reason
    boils = rise("choi2018", target="100 kPa", fluid="water")
    assert "boils" in boils.reason


def test_altitude():
    high = rise("choi2018", target="60 kPa", atmosphere="70 kPa")
    low = rise("choi2018", target="60 kPa")
    assert high.rise_time > low.rise_time
    with pytest.raises(QuantityError, match="more than the atmosphere"):
        rise("choi2018", target="80 kPa", atmosphere="70 kPa")


def test_what_is_refused():
    with pytest.raises(FitError, match="chamber.compliance: bench has none"):
        rise(read_line(BENCH, "a"), target="50 kPa", fluid="water")
    with pytest.raises(UnknownNameError, match="fluid"):
        rise("choi2018", target="50 kPa", fluid="oil")
    with pytest.raises(QuantityError, match="target: 0"):
        rise("choi2018", target="0 kPa")
    with pytest.raises(QuantityError, match="no unit"):
        rise("choi2018", target="50")
