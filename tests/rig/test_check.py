"""The first look at a bench: rates against the plant's own, and each wrong wire by its name."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import layerjam.rig
from layerjam.cli.main import main
from layerjam.control.closed_loop import FaultInjection
from layerjam.errors import QuantityError
from layerjam.rig.check import LockedError, check_bench
from layerjam.rig.driver import Bench, InstrumentError
from layerjam.rig.plant import VirtualPlant

FAST = "sim:choi2018?speed=20&noise=15 Pa"


def plant_of(bench: Bench) -> VirtualPlant:
    made = bench.plant
    assert made is not None
    return made


@pytest.mark.parametrize("rest", ["open", pytest.param("closed", marks=pytest.mark.slow)])
def test_a_healthy_bench_has_the_plants_own_rates(rest: str) -> None:
    with layerjam.rig.open(f"{FAST}&rest={rest}") as bench:
        plant = plant_of(bench)
        leaky = replace(plant.behind.plant, leak=0.02)
        plant.behind = replace(plant.behind, plant=leaky)
        with pytest.raises(QuantityError, match="vent rest"):
            check_bench(bench)
        made = check_bench(bench, vent_rest=rest, plant=leaky)
        assert (made.self_test, made.wiring, made.feasible, made.reason) == (0, (), True, None)
        assert made.zero == pytest.approx(0.0, abs=30)
        assert made.rate == pytest.approx(leaky.rate, rel=0.05)
        assert made.leak == pytest.approx(0.02, abs=0.002)
        assert made.top == pytest.approx(leaky.top, rel=0.05)
        assert bench.state == "SAFE" and plant.outputs == (0.0, rest == "open")
        assert bench.ask("SYST:LOCK:OWN?") == '"NONE"'


@pytest.mark.parametrize(
    ("broken", "wrong"),
    [
        (FaultInjection(sensor="nan"), "sensor-silent"),
        pytest.param(FaultInjection(pump=0.0), "pump-does-nothing", marks=pytest.mark.slow),
        pytest.param(FaultInjection(pump=-0.2), "pump-reversed", marks=pytest.mark.slow),
        pytest.param(FaultInjection(vent=0.0), "vent-does-nothing", marks=pytest.mark.slow),
    ],
)
def test_each_wrong_wire_by_its_name(broken: FaultInjection, wrong: str) -> None:
    with layerjam.rig.open(FAST) as bench:
        plant_of(bench).injected = broken
        made = check_bench(bench, vent_rest="open")
        assert made.wiring == (wrong,) and not made.feasible and made.reason


@pytest.mark.slow
def test_a_valve_that_is_declared_the_wrong_way_round() -> None:
    with layerjam.rig.open(FAST + "&rest=closed") as bench:
        made = check_bench(bench, vent_rest="open")
        assert made.wiring == ("vent-inverted",)


@pytest.mark.slow
def test_another_line_is_none_of_this_rate() -> None:
    with layerjam.rig.open(FAST) as bench:
        plant = plant_of(bench).behind.plant
        made = check_bench(bench, vent_rest="open", plant=replace(plant, rate=2 * plant.rate))
        assert made.wiring == () and not made.feasible
        assert "rate" in (made.reason or "")


def test_who_has_the_lock_and_five_seconds_in_all() -> None:
    with layerjam.rig.open("sim:choi2018?speed=0") as bench:
        bench.vent_rest = "open"
        bench.tell("DIAG:DRIV 1,0,5")
        bench.tell("DIAG:DRIV 0,0,1")
        with pytest.raises(InstrumentError, match="s of driving are left") as info:
            bench.tell("DIAG:DRIV 0,0,5")
        assert info.value.code == -221
        link = bench._link  # another session of the same line
        assert link.line.ask(2, b"SYST:LOCK:REQ?") == b"1"  # type: ignore[attr-defined]
        with pytest.raises(LockedError):
            check_bench(bench)


@pytest.mark.slow
def test_as_it_is_typed(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "check", "sim:choi2018?speed=50", "--vent-rest", "open", "--json"]
    assert main([*words, "--line", "choi2018"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"self_test", "wiring", "leak", "rate", "feasible", "reason"} <= set(said)
    assert (said["units"]["rate"], said["units"]["leak"]) == ("1/s", "1/s")
    assert main(words[:3]) == 2
