"""A vacuum that is not safe at the stated confidence is a negative result, with its basis."""

from __future__ import annotations

import math
from statistics import NormalDist

import numpy as np
import pytest

import layerjam
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import Evidence, Part
from layerjam.core.evolve import evolve

SD, TESTED = 0.1, (20e3, 60e3)
STOP = {"mass": 1.0, "travel": 0.04, "rope_stiffness": 16.8e3}


@pytest.fixture(scope="module")
def tested() -> BrakeFile:
    """Kapton whose scale factor alone is uncertain, tested between two vacuums."""
    entry = Evidence(
        command="calibrate",
        date="2026-01-01",
        tests=5,
        names=("scale_factor",),
        exponent_sd=1e-9,
        ranges={"vacuum": TESTED, "slip": (0.0, 0.06), "speed": (1e-3, 10.0)},
        fitted={},
        parts=(Part("mean", ((SD**2,),)),),
    )
    return evolve(layerjam.load("choi2018-kapton"), evidence=(entry,))


def force_at(factor: float, slip: float, vacuum: float) -> float:
    """Force of the paper's brake, from its printed numbers alone (eq. 5 with the slip, 7)."""
    sheets = factor * 0.24 * 10 * 0.013 * (0.068 - slip) * vacuum
    strip = 100e3 * 0.013 * 1e-3
    return sheets + 2 * math.sqrt(strip * vacuum * 0.8 * 0.013 * slip)


@pytest.mark.parametrize("short", [0.05, 0.1])
def test_a_force_that_few_brakes_hold_has_no_safe_vacuum(tested: BrakeFile, short: float) -> None:
    target, full = force_at(0.875 * (1 - short), 0.02, 101325.0), 101325.0
    result = layerjam.vacuum(tested, slip=0.02, force=target)
    assert result.feasible and result.safe_vacuum is None and result.exit_code == 0
    enclosure = force_at(0.0, 0.02, full)
    ratio = (force_at(0.875, 0.02, full) - enclosure) / (target - enclosure)
    share = NormalDist().cdf(math.log(ratio) / SD)
    [note] = [w for w in result.warnings if w.key == "no-safe-vacuum"]
    shown = float(note.rpartition("it in ")[2].partition("%")[0]) / 100
    assert shown == pytest.approx(share, abs=0.006)
    safe = layerjam.vacuum(tested, slip=0.02, force=target, confidence=math.floor(50 * share) / 50)
    assert safe.safe_vacuum is not None and safe.exit_code == 0


def test_one_unsafe_element_is_named(tested: BrakeFile) -> None:
    forces = np.array([20.0, 0.95 * force_at(0.875, 0.02, 101325.0)])
    result = layerjam.vacuum(tested, slip=0.02, force=forces)
    assert result.feasible.all() and np.isnan(result.safe_vacuum).tolist() == [False, True]
    assert [w.key for w in result.warnings].count("no-safe-vacuum") == 1
    safe = layerjam.vacuum(tested, slip=0.02, force=forces[:1])
    assert "no-safe-vacuum" not in [w.key for w in safe.warnings]


def test_a_stop_that_no_vacuum_makes_safe_is_named(tested: BrakeFile) -> None:
    fastest = layerjam.tune(tested, speed=2.5, **STOP).greatest_speed
    result = layerjam.tune(tested, speed=0.99 * fastest, **STOP)
    assert result.feasible and result.safe_vacuum is None and result.exit_code == 0
    assert "no-safe-vacuum" in [w.key for w in result.warnings]
    slow = layerjam.tune(tested, speed=0.5 * fastest, **STOP)
    assert "no-safe-vacuum" not in [w.key for w in slow.warnings]


def test_the_reason_for_no_vacuum_rests_on_the_full_vacuum(tested: BrakeFile) -> None:
    for result in (
        layerjam.vacuum(tested, slip=0.02, force=500.0),
        layerjam.tune(tested, speed=9.0, **STOP),
    ):
        assert not result.feasible and result.basis == "extrapolated"
        [beyond] = result.extrapolated
        assert (beyond["quantity"], beyond["value"]) == ("vacuum", 101325.0)
    weak = layerjam.vacuum(tested, slip=0.02, force=0.0)
    assert weak.extrapolated[0]["value"] == 0.0
    mixed = layerjam.vacuum(tested, slip=0.02, force=np.array([50.0, 500.0]))
    assert mixed.basis == "extrapolated"


@pytest.mark.parametrize("speed", [0.5, 1.5])
@pytest.mark.parametrize("spacers", [True, False])
def test_the_safe_vacuum_is_the_one_of_the_brake_that_one_in_twenty_is_weaker_than(
    tested: BrakeFile, spacers: bool, speed: float
) -> None:
    """Without spacers each stop is a quadrature; at 0.5 m/s some samples are bisected."""
    brake = evolve(tested.brake, mount=evolve(tested.brake.mount, spacers=spacers))
    (tests,) = tested.evidence
    evidence = (evolve(tests, fitted={"mount.spacers": spacers}),)
    file, stop = evolve(tested, brake=brake, evidence=evidence), {**STOP, "speed": speed}
    result = layerjam.tune(file, **stop, searches=("safety",))
    factor = brake.scale_factor * math.exp(NormalDist().inv_cdf(0.05) * SD)
    weaker = evolve(file, brake=evolve(brake, scale_factor=factor), evidence=())
    needed = layerjam.tune(weaker, **stop, searches=("safety",)).vacuum
    assert result.safe_vacuum == pytest.approx(needed, rel=5e-3)
