"""The curve that goes with every `rise`, and a fall from a height that is tuned for."""

from __future__ import annotations

import numpy as np
import pytest

from layerjam.brake.commands.drop import drop
from layerjam.brake.commands.edit import edit_line
from layerjam.brake.commands.tuning import tune
from layerjam.brake.commands.vacuum_line import rise
from layerjam.core.errors import QuantityError


def test_water_rises_in_a_straight_line_to_the_target():
    made = rise("choi2018", target="60 kPa", fluid="water")
    curve = made.record
    low, high = (np.interp(part * 60e3, curve.vacuum[:2], curve.time[:2]) for part in (0.1, 0.9))
    assert high - low == pytest.approx(made.rise_time)
    assert curve.vacuum[-1] == made.target


def test_water_that_boils_ends_there():
    made = rise("choi2018", target="101 kPa", fluid="water")
    assert not made.feasible
    assert made.record.vacuum[-1] == made.reachable < made.target


def test_a_line_that_never_gets_there_shows_how_far_it_comes():
    weak = edit_line("choi2018", {"leak.laminar": "5 mL/s"}).record
    made = rise(weak, target="90 kPa")
    assert made.rise_time is None and not made.feasible
    vacuum = made.record.vacuum
    assert (np.diff(vacuum) >= -1e-6).all()
    assert vacuum[-1] == pytest.approx(made.reachable, rel=1e-3)


def test_a_fall_from_a_height_is_tuned_as_its_speed_is():
    case = {"mass": "1 kg", "travel": "40 mm", "rope_stiffness": "16.8 kN/m"}
    fallen = drop("choi2018-kapton", height="0.1 m", vacuum="tuned", **case)
    by_height = tune("choi2018-kapton", height="0.1 m", **case)
    assert fallen.speed == pytest.approx(np.sqrt(2 * 9.80665 * 0.1), rel=1e-4)
    assert by_height.values == tune("choi2018-kapton", speed=fallen.speed, **case).values
    assert by_height.vacuum == fallen.vacuum
    for wrong in ({}, {"speed": "1 m/s", "height": "1 m"}):
        with pytest.raises(QuantityError, match="speed and height"):
            tune("choi2018-kapton", **case, **wrong)
    with pytest.raises(QuantityError, match="horizontal"):
        tune("choi2018-kapton", **case, height="1 m", horizontal=True)
