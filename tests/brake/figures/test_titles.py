"""Titles of figures are words, not names of the code."""

from __future__ import annotations

import pytest

import layerjam as lj
from layerjam.brake.figures import titles
from layerjam.brake.simulate.record import Outcome

KAPTON = "choi2018-kapton"
STOP = {"mass": "1 kg", "speed": "2.5 m/s", "rope_stiffness": "16.8 kN/m"}


def title(result: object) -> str:
    return result.draw().axes[0].get_title(loc="left")  # type: ignore[attr-defined]


def test_a_stop_is_described_by_its_mass_speed_and_slip() -> None:
    tuned = lj.drop(KAPTON, vacuum="tuned", travel="40 mm", **STOP)
    assert title(tuned).startswith("Stop of 1 kg from 2.5 m/s: stopped after 40 mm")
    weak = lj.drop(KAPTON, vacuum="20 kPa", **STOP)
    words = "Stop of 1 kg from 2.5 m/s: still moving at the end of the travel, 60 mm"
    assert title(weak).replace("\n", " ").startswith(words)


def test_a_pull_is_described_by_its_end() -> None:
    pull = lj.tensile(KAPTON, vacuum="94.5 kPa", speed="13 mm/s", elongation="40 mm")
    assert title(pull).startswith("choi2018-kapton: pulled to 40 mm")
    slow = lj.stick_slip(KAPTON, vacuum="94.5 kPa", speed="1 mm/s", elongation="4 mm")
    words = {"JUDDERS": "the sheets stick and slip", "STEADY_SLIDING": "the sheets slide steadily"}
    assert title(slow).startswith(f"choi2018-kapton: {words[slow.outcome]}")
    pair = lj.array(KAPTON, parallel=2, until="5 mm", vacuum="94.5 kPa")
    assert title(pair).startswith("2 × 1 choi2018-kapton: pulled to 5 mm")


def test_a_controller_is_described_by_the_fault_it_detects() -> None:
    common = {"target": "60 kPa", "safe_state": "release", "sensor_range": "103 kPa"}
    assert title(lj.regulate("choi2018", **common)) == "Controller “pi” detects no fault"
    stuck = lj.regulate("choi2018", fault="pump-dead", fault_at=1.0, **common)
    assert title(stuck).startswith("Controller “pi” detects the fault “")


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_has_words(outcome: Outcome) -> None:
    found = [words[outcome] for words in (titles.DROPS, titles.PULLS) if outcome in words]
    assert found and all(outcome.value not in words for words in found)
