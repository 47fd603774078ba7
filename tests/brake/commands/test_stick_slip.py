"""The command `stick-slip`: its numbers against the closed forms, and what it refuses."""

from __future__ import annotations

import math
from typing import Any

import pytest

from layerjam.brake.commands.stick_slip import stick_slip
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.stick_slip.laws import critical_speed, slow_saw
from layerjam.brake.mechanics.stiffness import stiffness_before_slip
from layerjam.core.errors import LayerjamError

FULL = "94.5kPa"


def test_kapton_saws() -> None:
    found = stick_slip("choi2018-kapton", vacuum=FULL, speed="1mm/s", travel="3mm")
    saw = slow_saw(found.static_force, found.kinetic_force, 131e3, found.mass, 1e-3)
    assert found.outcome == "JUDDERS" and found.events >= 2
    assert found.static_force == pytest.approx(233.9064, abs=1e-4)
    assert found.amplitude == pytest.approx((found.force_high - found.force_low) / 2, rel=1e-12)
    # within a slip or two of the start the closed form holds to a per cent
    assert found.force_high == pytest.approx(float(saw.force_high), rel=0.02)
    assert found.slip_per_event == pytest.approx(float(saw.slip), rel=0.02)
    assert found.period == pytest.approx(float(saw.period), rel=0.02)
    assert found.relative_amplitude == pytest.approx(1 / 3, rel=0.02)
    for key in ("critical_speed", "stable_speed", "stiffness_needed"):
        assert found.values[key] is None
    assert any("no damping" in w for w in found.warnings)
    assert any("half the brake's mass" in w for w in found.warnings)
    assert set(found.values) - {"outcome"} == set(found.units)


def test_damping_gives_a_critical_speed() -> None:
    given: dict[str, Any] = {"vacuum": FULL, "mass": "50 g", "damping": "8 N s/m"}
    found = stick_slip("choi2018-kapton", speed="1mm/s", travel="2mm", **given)
    expected = critical_speed(found.static_force, found.kinetic_force, 131e3, 0.05, 8.0)
    assert found.critical_speed == pytest.approx(float(expected), rel=1e-12)
    assert found.damping_ratio == pytest.approx(8 / (2 * math.sqrt(131e3 * 0.05)), rel=1e-12)
    # friction falls with slip, and with it the critical speed: a run just below it settles late
    fast = stick_slip("choi2018-kapton", speed=1.05 * found.critical_speed, **given)
    slow = stick_slip("choi2018-kapton", speed=0.5 * found.critical_speed, **given)
    late = stick_slip("choi2018-kapton", speed=0.9 * found.critical_speed, **given)
    assert late.outcome == "STEADY_SLIDING" and late.events > 0
    assert any("before settling" in w for w in late.warnings)
    assert (slow.outcome, fast.outcome) == ("JUDDERS", "STEADY_SLIDING")
    assert fast.amplitude == 0.0 and fast.slip_per_event is None


def test_the_stiffness_needed_brings_the_critical_speed_down() -> None:
    at = stick_slip("choi2018-kapton", vacuum=FULL, speed="0.4 m/s", mass="50 g", damping="8 N s/m")
    assert at.outcome == "JUDDERS" and at.stiffness_needed > at.stiffness
    stiff, ratio = at.stiffness_needed, at.damping_ratio
    own = float(stiffness_before_slip(load("choi2018-kapton").brake))
    again = stick_slip(
        "choi2018-kapton", vacuum=FULL, speed="0.42 m/s", mass="50 g",
        mount_stiffness=1 / (1 / stiff - 1 / own), damping=2 * ratio * math.sqrt(stiff * 0.05),
    )  # fmt: skip
    assert again.stiffness == pytest.approx(stiff, rel=1e-12)
    assert again.critical_speed == pytest.approx(0.4, rel=1e-9)
    assert again.outcome == "STEADY_SLIDING"


def test_static_equal_to_kinetic_does_not_stick() -> None:
    found = stick_slip(
        "choi2018-kapton", vacuum=FULL, speed="5mm/s", static=0.24, damping="5 N s/m"
    )
    assert found.outcome == "STEADY_SLIDING" and found.critical_speed == 0.0


def test_stuck() -> None:
    found = stick_slip("choi2018-kapton", vacuum=FULL, speed="1mm/s", travel="1mm")
    assert found.outcome == "STUCK" and found.amplitude is None
    assert found.force_high == pytest.approx(131.0, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"vacuum": "200kPa"}, "atmospheric"),
        ({"speed": "1"}, "no unit"),
        ({"speed": 0.0}, "speed of the crosshead"),
        ({"mass": "0 kg"}, "moving mass"),
        ({"damping": "-1 N s/m"}, "damping"),
        ({"damping": "5 N"}, "damping"),
        ({"stribeck_speed": "1 mm"}, "stribeck speed"),
        ({"static": 0.1}, "kinetic friction"),
        ({"slip": "68mm"}, "no overlap"),
        ({"slip": "70mm"}, "beyond the overlap"),
        ({"travel": "70mm"}, "exceeds the overlap"),
        ({"mount_stiffness": 0.0}, "mount"),
    ],
)
def test_bad_input(given: dict[str, Any], word: str) -> None:
    values: dict[str, Any] = {"vacuum": FULL, "speed": "1mm/s", **given}
    with pytest.raises(LayerjamError, match=word):
        stick_slip("choi2018-kapton", **values)
