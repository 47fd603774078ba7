"""`regulate` with something broken: what is said, when, and what the safe state does."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from layerjam.bench.commands.regulate import regulate
from layerjam.bench.control.faults import OFFSET, PROVOKED, make_injection
from layerjam.bench.control.settings import SAFE_STATES
from layerjam.brake.commands.edit import edit_line
from layerjam.brake.fluid.line_file import load_line
from layerjam.cli.main import app
from layerjam.core.errors import QuantityError, UnknownNameError

SEEN = {"sensor_range": "103 kPa", "noise": "50 Pa", "duration": "20 s"}
LINE = edit_line("choi2018", takes={"valve": "festo-mha2-ms1h-3-2g-2"}).record
"""The paper's line with a vent valve."""
DURING_RISE = "0.5 s"
NAMES = {
    "pump-dead": {"NO_VACUUM", "WEAK_PUMP"}, "pump-weak": {"NO_VACUUM", "WEAK_PUMP"},
    "line-blocked": {"LINE_BLOCKED"}, "leak": {"NO_VACUUM", "WEAK_PUMP", "VACUUM_LOST"},
    "sensor-nan": {"NOT_A_NUMBER"},
    "sensor-stuck": {"SENSOR_STUCK", "NO_VACUUM", "WEAK_PUMP"},
}  # fmt: skip


def broken(fault, at, line=LINE, **more):
    return regulate(
        line, **({"target": "60 kPa", "safe_state": "release", **SEEN} | more),
        fault=fault, fault_at=at,
    )  # fmt: skip


@pytest.mark.parametrize("fault", list(NAMES))
def test_a_fault_during_the_rise_is_said_within_its_time_and_the_state_is_safe(fault):
    for safe in SAFE_STATES:
        made = broken(fault, DURING_RISE, safe_state=safe)
        assert made.outcome in NAMES[fault]
        assert made.said_after == pytest.approx(made.fault_time - 0.5)
        # whatever its name, not later than the longest of the names it may have
        assert 0 <= made.said_after <= max(made.detection[n] for n in NAMES[fault]) + 1e-9
        _, loop = made.record
        after = loop.time >= made.fault_time
        assert (loop.pump[after] == 0).all()
        assert (loop.vent[after] == (safe == "release")).all()
        if safe == "release":
            assert loop.vacuum[-1] < 1
        elif fault == "sensor-nan":
            # valves closed and a line without a leak: the vacuum stands
            assert loop.vacuum[-1] == pytest.approx(loop.vacuum[after][0])


def test_the_leak_takes_half_the_target_from_the_full_pump():
    made = broken("leak", "5 s", safe_state="hold")
    regulator, loop = made.record
    injected, _ = make_injection("leak", 5.0, regulator, made.target)
    rate, top, weight, leak, *_ = injected.break_plant(regulator.plant)
    half = made.target / 2
    assert rate * (top - weight * half) == pytest.approx(leak * half)
    after = loop.time > made.fault_time + 0.05
    # pump off: the leak alone empties the line exponentially
    rates = -np.diff(np.log(loop.vacuum[after][:20])) / regulator.sample_time
    assert rates == pytest.approx(leak, rel=1e-6)


def test_an_offset_is_held_without_a_word_and_the_answer_says_by_how_much():
    made = broken("sensor-offset", "5 s", line="choi2018")
    regulator, loop = made.record
    assert made.outcome == "HEALTHY" and made.said_after is None
    off = OFFSET * regulator.largest_zero
    late = loop.time > 15
    assert float(np.mean(loop.vacuum[late])) == pytest.approx(made.target - off, abs=60)
    sentence = made.checks[0]["sentence"]
    assert made.checks[0]["level"] == "warning" and made.exit_code == 0
    assert "was not reported" in sentence and "vented" in sentence


def test_a_pump_that_hardly_runs_hides_its_fault():
    made = broken("pump-weak", "10 s")
    assert made.outcome == "HEALTHY"
    assert "runs at full power, as during a rise" in made.checks[0]["sentence"]


def test_a_dead_pump_leaves_a_line_without_valve_without_release():
    made = broken("pump-dead", DURING_RISE, line="choi2018")
    _, loop = made.record
    assert made.outcome in NAMES["pump-dead"]
    at = np.searchsorted(loop.time, made.fault_time)
    assert loop.vent[-1] == 1
    assert loop.vacuum[-1] == pytest.approx(loop.vacuum[at])
    assert any("prevents release" in said for said in made.warnings)


def test_without_a_fault_nothing_changes():
    made = regulate("choi2018", target="60 kPa", safe_state="release", **SEEN)
    assert (made.fault, made.fault_at, made.broken, made.said_after) == (None,) * 4
    assert set(PROVOKED) >= set(NAMES)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"fault": "leak"}, "fault at: missing"),
        ({"fault_at": "3 s"}, "fault: missing"),
        ({"fault": "leak", "fault_at": "20 s"}, "the run ends at 20 s"),
        ({"fault": "leak", "fault_at": "-1 s"}, "fault at: -1 s"),
        ({"fault": "leak", "fault_at": "3 mm"}, "units of time"),
    ],
)
def test_what_is_refused(options, words):
    with pytest.raises(QuantityError, match=words):
        regulate(LINE, target="60 kPa", safe_state="hold", **SEEN, **options)
    with pytest.raises(UnknownNameError, match="did you mean pump-dead"):
        broken("pump_dead", "3 s")


def test_on_the_command_line():
    run = CliRunner().invoke(app, [
        "regulate", "choi2018", "--target", "60kPa", "--safe-state", "hold", "--sensor-range",
        "103kPa", "--fault", "sensor-nan", "--fault-at", "8s", "--json",
    ])  # fmt: skip
    assert run.exit_code == 0, run.output
    made = json.loads(run.stdout)
    assert made["outcome"] == "NOT_A_NUMBER"
    assert made["fault_at"] == 8.0 and made["said_after"] == pytest.approx(0, abs=0.011)
    assert load_line("choi2018").line.valve is None
