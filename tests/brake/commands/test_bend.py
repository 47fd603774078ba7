"""`bend`: keys of the contract, what it says of its limits, and bad input."""

from __future__ import annotations

import json
import math

import pytest

import layerjam as lj
from layerjam.cli.main import main
from layerjam.core.errors import LayerjamError

FULL = 94.5e3


def keys_of(result: lj.Result) -> set[str]:
    return {w.key for w in result.warnings}  # type: ignore[attr-defined]


def test_a_bent_brake_agrees_with_the_laws() -> None:
    brake = lj.load("choi2018-kapton").brake
    made = lj.bend("choi2018-kapton", vacuum="94.5 kPa", angle="30deg", slip="10mm")
    angle = math.pi / 6
    assert made.moment == pytest.approx(float(lj.laws.turning_moment(angle, 0.01, FULL, brake)))
    assert made.moment_free == pytest.approx(made.turning_stiffness_free * angle)
    assert made.stiffness_ratio == pytest.approx(118.26, abs=0.01)
    assert made.straight_friction == pytest.approx(float(lj.sheet_friction(0.01, FULL, brake)))
    # 2.5 GPa over twice 69 MPa of 0.254 mm
    assert made.least_radius == pytest.approx(2.5e9 / 69e6 * 0.254e-3 / 2)
    assert made.joint_friction is None and made.amplification is None
    assert made.end_force_ratio is None
    assert "compressed-sheets-buckle" in keys_of(made)
    gentle = lj.bend("choi2018-kapton", vacuum=FULL, angle=0.01)
    assert "compressed-sheets-buckle" not in keys_of(gentle)


def test_over_a_joint() -> None:
    made = lj.bend(
        "choi2018-kapton", vacuum=FULL, angle=0.5, slip=0.02, radius=0.06, limb_friction=0.4
    )
    brake = lj.load("choi2018-kapton").brake
    outer = float(lj.laws.enclosure_force(0.02, FULL, brake)) / 2
    due = float(lj.laws.joint_friction(0.02, FULL, 0.5, 0.06, outer, brake))
    assert made.joint_friction == pytest.approx(due)
    assert made.amplification == pytest.approx(due / made.straight_friction)
    assert made.end_force_ratio == pytest.approx(math.exp(0.2))
    assert made.joint_friction_off is not None and 0 < made.joint_friction_off < due
    assert not keys_of(made) & {"arc-beyond-overlap", "joint-overloads-film"}
    far = lj.bend("choi2018-kapton", vacuum=FULL, angle=1.5, radius=0.06)
    assert {"arc-beyond-overlap", "joint-overloads-film"} <= keys_of(far)
    off = lj.bend("choi2018-kapton", vacuum=0.0, angle=0.5, radius=0.06)
    assert off.joint_friction == 0 and off.amplification is None and off.moment == off.moment_free


def test_bad_input_is_refused() -> None:
    for given in (
        {"angle": 0.0},
        {"angle": 4.0},
        {"angle": 0.5, "slip": 0.068},
        {"angle": 0.5, "slip": 0.1},
        {"angle": 0.5, "radius": 0.0},
        {"angle": 0.5, "limb_friction": 0.3},
    ):
        with pytest.raises(LayerjamError):
            lj.bend("choi2018-kapton", vacuum=FULL, **given)  # type: ignore[arg-type]
    with pytest.raises(LayerjamError):
        lj.bend("choi2018-kapton", vacuum=2e5, angle=0.5)


def test_two_sheets_have_no_compressed_one(capsys: pytest.CaptureFixture[str]) -> None:
    two = lj.load("choi2018-kapton").with_(count=2)
    made = lj.bend(two, vacuum=FULL, angle=0.5)
    assert made.buckling_moment is None
    assert main(["bend", "choi2018-kapton", "--vacuum", "50kPa", "--angle", "20deg", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["units"]["moment"] == "N m" and found["joint_friction"] is None
