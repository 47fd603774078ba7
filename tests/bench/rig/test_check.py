"""The first look at a bench: rates against the plant's own, and each wrong wire by its name."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import layerjam as lj
import layerjam.bench.rig
from layerjam.bench.control.closed_loop import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.plant import linearise_line as linear_plant
from layerjam.bench.rig.check import LockedError, check_bench, delayed_decay
from layerjam.bench.rig.driver import Bench, InstrumentError
from layerjam.bench.rig.virtual_plant import VirtualPlant
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from printed import split_command

FAST = "sim:choi2018?speed=20&noise=15 Pa"


def plant_of(bench: Bench) -> VirtualPlant:
    made = bench.plant
    assert made is not None
    return made


@pytest.mark.parametrize("rest", ["open", pytest.param("closed", marks=pytest.mark.slow)])
def test_a_healthy_bench_has_the_plants_own_rates(rest: str) -> None:
    with layerjam.bench.rig.open(f"{FAST}&rest={rest}") as bench:
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


# time constants of pump, leak, vent and sensor [s], greatest vacuum [Pa], noise [Pa]
PLANTS = [
    (2.0, 80.0, 0.4, 0.03, 95e3, 50.0),
    pytest.param(0.8, 20.0, 0.05, 0.0, 80e3, 15.0, marks=pytest.mark.slow),
    pytest.param(6.0, 200.0, 1.5, 0.08, 90e3, 30.0, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("pump", "leak", "vent", "lag", "top", "noise"), PLANTS)
def test_the_numbers_of_a_known_plant(
    pump: float, leak: float, vent: float, lag: float, top: float, noise: float
) -> None:
    with layerjam.bench.rig.open("sim:choi2018?speed=20") as bench:
        plant = plant_of(bench)
        real = Plant(rate=1 / pump, top=top, leak=1 / leak, vent=1 / vent)
        sensor = replace(plant.behind.sensor, lag=lag, noise=noise)
        plant.behind = replace(plant.behind, plant=real, sensor=sensor)
        made = check_bench(bench, vent_rest="open")
        assert made.wiring == () and made.expected is None
        assert made.rate == pytest.approx(1 / pump, rel=0.03)
        assert made.top == pytest.approx(top, rel=0.03)
        assert made.leak == pytest.approx(1 / leak, abs=2e-3)
        assert made.vent == pytest.approx(1 / vent, rel=0.03)
        assert made.lag == pytest.approx(lag, abs=3e-3)
        assert made.noise == pytest.approx(noise, rel=0.3)


@pytest.mark.parametrize("rate", [0.3, 4.0])
@pytest.mark.parametrize("lag", [0.0, 0.02, 0.25, 1.0])
def test_a_decay_behind_a_lag_is_that_of_small_steps(rate: float, lag: float) -> None:
    step, seen, shown = 1e-5, [], 1.0
    for n in range(100_000):
        if n % 1000 == 0:
            seen.append(shown)
        now = math.exp(-rate * step * n)
        shown = shown + step / lag * (now - shown) if lag else math.exp(-rate * step * (n + 1))
    times = np.arange(100) * 1e-2
    assert delayed_decay(times, rate, lag) == pytest.approx(seen, abs=1e-4)


def test_a_bench_outside_the_tolerances_is_named_and_tuned(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "measured.toml"
    words = ["bench", "check", "sim:choi2018?speed=0&vent=0.4s&leak=50s&noise=20Pa"]
    words += ["--vent-rest", "open", "--line", "choi2018", "--sensor-range", "103kPa"]
    assert main([*words, "--json"]) == 1, "infeasible"
    said = json.loads(capsys.readouterr().out)
    assert not said["feasible"] and "vent's rate is 2." in said["reason"]
    assert said["vent"] == pytest.approx(2.5, rel=0.05), "by fits of a noisy reading"
    assert said["expected"]["vent"] == pytest.approx(0.7495, rel=1e-3)
    assert said["next_step"].startswith("layerjam bench check ") and "--tune" in said["next_step"]
    assert main([*words, "--tune", str(file)]) == 0
    shown = re.findall(r"vent: measured ([\d.]+) 1/s", capsys.readouterr().out)
    assert [float(rate) for rate in shown] == pytest.approx([2.5], rel=0.05)
    tuned = lj.load_line(str(file))
    made = linear_plant(tuned.line, vacuum=60e3)
    assert made.rate == pytest.approx(3.33e-6 / 7.503e-6, rel=0.02), "ratio of pump flow to volume"
    assert (made.vent, made.leak) == pytest.approx((2.5, 0.02), rel=0.05)
    assert {tuned.sources[name].kind for name in ("pump.flow", "sensor.lag")} == {"synthetic"}
    measured = re.findall(r'value = "([\d.e-]+) .*kind = "synthetic"', file.read_text("utf-8"))
    digits = [number.partition("e")[0].replace(".", "").strip("0") for number in measured]
    assert len(digits) == 6 and max(map(len, digits)) == 4, "four significant digits"
    assert main([*words, "--tune", str(file)]) == 2, "an existing file is kept"


def test_what_tuning_needs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "check", "sim:choi2018?speed=0", "--vent-rest", "open", "--tune"]
    assert main([*words, str(tmp_path / "a.toml")]) == 2
    assert "--line" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "a.toml"), "--line", "choi2018"]) == 2
    assert "--sensor-range" in capsys.readouterr().err


@pytest.mark.slow
def test_a_bench_is_tuned_then_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    address = "sim:choi2018?speed=0&vent=0.4s&leak=50s&noise=20Pa"
    file = str(tmp_path / "other.toml")
    words = ["--vent-rest", "open", "--line"]
    check = ["bench", "check", address, *words, "choi2018", "--sensor-range", "103kPa"]
    monkeypatch.chdir(tmp_path)
    assert main(check) == 1, "the vent differs"
    # each command that is printed as the next is typed as it is
    for _ in range(2):
        typed = capsys.readouterr().out.partition("next:\n  layerjam ")[2].splitlines()[0]
        assert main(split_command(typed)) == 0, typed
    assert "FINISHED" in capsys.readouterr().out and Path("first-run.ljrun").is_file()
    # without a vacuum nothing is written
    assert main([*check, "--tune", file, "--vent-rest", "closed"]) == 1
    assert not Path(file).exists()
    capsys.readouterr()


@pytest.mark.slow
def test_a_zero_at_full_speed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "zero", "sim:choi2018?speed=0", "--vent-rest", "open", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["zero"] == pytest.approx(0.0, abs=1e-6)


def test_outputs_that_cannot_be_driven() -> None:
    bench = layerjam.bench.rig.open("sim:choi2018?speed=0")
    with bench, pytest.raises(QuantityError, match=r"too fast.*1 to 20"):
        check_bench(bench, vent_rest="open")
    with layerjam.bench.rig.open(FAST) as bench:
        plant = plant_of(bench)
        plant.schedule_action(0.5, lambda: setattr(plant, "supply_low", True))
        with pytest.raises(QuantityError, match=r"emergency stop.*12 V"):
            check_bench(bench, vent_rest="open")


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
    with layerjam.bench.rig.open(FAST) as bench:
        plant_of(bench).injected = broken
        made = check_bench(bench, vent_rest="open")
        assert made.wiring == (wrong,) and not made.feasible and made.reason


@pytest.mark.slow
def test_a_valve_that_is_declared_the_wrong_way_round() -> None:
    with layerjam.bench.rig.open(FAST + "&rest=closed") as bench:
        made = check_bench(bench, vent_rest="open")
        assert made.wiring == ("vent-inverted",)


@pytest.mark.slow
def test_another_line_is_none_of_this_rate() -> None:
    with layerjam.bench.rig.open(FAST) as bench:
        plant = plant_of(bench).behind.plant
        made = check_bench(bench, vent_rest="open", plant=replace(plant, rate=2 * plant.rate))
        assert made.wiring == () and not made.feasible
        assert "rate" in (made.reason or "")


def test_who_has_the_lock_and_five_seconds_in_all() -> None:
    with layerjam.bench.rig.open(FAST) as bench:
        bench.vent_rest = "open"
        bench.lease = 60.0
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
    words = ["bench", "check", "sim:choi2018?speed=0", "--vent-rest", "open", "--json"]
    assert main([*words, "--line", "choi2018"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert {"self_test", "wiring", "leak", "rate", "feasible", "reason"} <= set(said)
    assert (said["units"]["rate"], said["units"]["leak"]) == ("1/s", "1/s")
    assert main(words[:3]) == 2
