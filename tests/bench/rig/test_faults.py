"""The campaign on a virtual board: what is promised is kept, and what is not is seen."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import pytest

import layerjam as lj
from bench.rig.boards import Hal, Rig, firmware
from counts import cases
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.rig import board as boards
from layerjam.bench.rig import campaign as campaign_module
from layerjam.bench.rig import observer as observer_module
from layerjam.bench.rig.address import VIRTUAL, address_of
from layerjam.bench.rig.campaign import Bed, campaign, run_trial, select_faults, set_full_speed
from layerjam.bench.rig.kinds import DRIFTS, KINDS, NOT_HERE, NOTHING, SENSOR_GAP, SUPPLY_SAMPLES
from layerjam.bench.rig.observer import Observer, draw_plan
from layerjam.bench.rig.uneven import Uneven
from layerjam.bench.rig.virtual_plant import VirtualPlant, read_hardware
from layerjam.cli.main import main
from layerjam.core.errors import LayerjamError

CPYTHON = f"{VIRTUAL}&python=cpython"
BEHIND = read_hardware(address_of(VIRTUAL))
FEW = ["sensor-nan", "pump-dead", "vent-stuck-closed", "host-silent", "tick-late"]


@pytest.mark.parametrize(("address", "few"), [(CPYTHON, FEW[:1]), (VIRTUAL, FEW)])
def test_a_few_faults_are_safe_and_named_in_time(address: str, few: list[str]) -> None:
    done = campaign(address, only=few, runs=1, seed=3)
    assert [trial.plan.name for trial in done.trials] == [name for name in KINDS if name in few]
    for trial in done.trials:
        assert trial.is_met and trial.trouble == "", trial
        assert trial.safe_after is not None and trial.deadline is not None
        assert 0.0 <= trial.safe_after <= trial.deadline + 2e-6
    shut = next((trial for trial in done.trials if trial.plan.name == "vent-stuck-closed"), None)
    if shut is None:
        return
    assert shut.vacuum_after > 0.8 * shut.plan.case.target, "behind a closed valve it stays"
    assert shut.named_after is not None and shut.safe_after is not None
    assert shut.safe_after < shut.named_after


@pytest.mark.parametrize(
    ("name", "file", "was", "now"),
    [
        ("sensor-nan", "law.py", "fault = 1.0 * NOT_A_NUMBER", "fault = 0.0"),
        ("sensor-rail", "bench.py",
         "self.rest_outputs()\n        self.state, self.fault = FAULT, code",
         "self.state, self.fault = FAULT, code"),
        pytest.param("sensor-stuck", "law.py", "fault = 1.0 * STUCK", "fault = 0.0",
                     marks=pytest.mark.slow),
        pytest.param("line-blocked", "law.py", "fault = 1.0 * BLOCKED", "fault = 0.0",
                     marks=pytest.mark.slow),
        pytest.param("pump-dead", "law.py", "(NO_VACUUM if risen < none * owed else WEAK_PUMP)",
                     "HEALTHY", marks=pytest.mark.slow),
        pytest.param("e-stop", "bench.py", "self.latch_fault(123)", "pass",
                     marks=pytest.mark.slow),
        pytest.param("host-silent", "bench.py", "self.latch_fault(120)", "pass",
                     marks=pytest.mark.slow),
        pytest.param("tick-late", "bench.py", "self.latch_fault(121)", "pass",
                     marks=pytest.mark.slow),
        pytest.param("supply-low", "bench.py", "SUPPLY_SAMPLES = 3", "SUPPLY_SAMPLES = 5",
                     marks=pytest.mark.slow),
    ],
    ids=lambda value: value[:20],
)  # fmt: skip
def test_a_detector_that_is_switched_off_is_missed(
    name: str, file: str, was: str, now: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second one names its fault and leaves the outputs as they were: the plant's log knows."""
    sound = boards.firmware_files()
    assert was in sound[file]
    monkeypatch.setattr(
        boards, "firmware_files", lambda: {**sound, file: sound[file].replace(was, now)}
    )
    # while it pumps, the law also notices a sensor that sticks, and a pump without its supply
    done = campaign(CPYTHON, only=[name], runs=4 if name in ("sensor-stuck", "supply-low") else 1)
    assert not all(trial.is_met for trial in done.trials)


@pytest.mark.slow
def test_a_drift_is_doubted_by_the_board_when_the_plant_says_so(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Three openings in the plant's log are the board's bit 10; a slow drift has neither."""
    monkeypatch.setattr(observer_module, "LONGEST", 60.0)
    with Bed(set_full_speed(VIRTUAL)) as bed:
        for size, doubted in ((200.0, True), (5.0, False)):
            trial = run_trial(bed, draw_plan(bed.behind, "sensor-drift", 0, 0, size=size))
            bit = int(bed.get_bench()[0].ask("STAT:QUES?")) & 1024
            assert (trial.doubted_after is not None) == doubted == bool(bit), size
            assert trial.named is None and trial.safe_after is None and trial.is_met
            if doubted:  # what is missing has climbed, less what the vent did not yet give away
                case = trial.plan.case
                band = case.regulator.vent_threshold  # held is what is as near as this
                assert trial.lost_after is not None
                climbed = size * trial.lost_after - 0.1 * case.target
                assert -band - 250 <= climbed <= band + 250 + 2 * size


def test_a_real_line_differs_from_the_model_within_the_tolerances(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(campaign_module, "HEALTHY_RUNS", 2)
    said = lj.bench_faults(VIRTUAL, only=["pump-dead"], runs=1, seed=8, mismatch=True)
    assert (said.runs, said.healthy, said.false_faults, said.missed) == (3, 2, 0, 0)
    assert said.exit_code == 0 and replace(said, false_faults=1).exit_code == 1
    assert "no fault injected: 0 false faults in 2 runs" in list(said.lines())
    plans = [draw_plan(BEHIND, NOTHING, n, 0, mismatch=True) for n in range(300)]
    shares = [plan.behind.plant.rate / plan.case.regulator.plant.rate for plan in plans]
    zeros = [plan.behind.sensor.offset / plan.behind.sensor.range for plan in plans]
    lags = [plan.behind.sensor.lag for plan in plans]
    noises = [plan.behind.sensor.noise / BEHIND.sensor.noise for plan in plans]
    for values, low, high in (
        (shares, 0.8, 1.2), (zeros, -0.01, 0.01), (lags, 0.0, 0.05), (noises, 1.0, 4.0)
    ):  # fmt: skip
        reach = high - low
        assert low <= min(values) < low + 0.05 * reach and high - 0.05 * reach < max(values) <= high


def test_an_orifice_passes_less_than_in_proportion_at_a_high_vacuum() -> None:
    """ISO 6358 with b = 0.528, right at 60 kPa; ripple and dip of the pump over their means."""
    uneven = Uneven(
        right_at=60e3, ripple=0.3, frequency=5.0, phase=0.0, dip=0.5, lasting=0.1
    )  # fmt: skip
    x = (1 - 10e3 / 101325 - 0.528) / 0.472
    assert uneven.orifice_ratio(10e3) == pytest.approx(6 * math.sqrt(1 - x * x), rel=1e-9)
    assert uneven.orifice_ratio(60e3) == 1.0 and uneven.orifice_ratio(90e3) == pytest.approx(2 / 3)
    assert uneven.pump_ratio(0.05) == pytest.approx(0.5 * 1.3)
    assert uneven.pump_ratio(0.15) == pytest.approx(0.7)
    mean = sum(uneven.pump_ratio(0.2 + 0.2 * n / 1000) for n in range(1000)) / 1000
    assert mean == pytest.approx(1.0, abs=1e-3)


@pytest.mark.slow
def test_the_campaign_on_real_lines() -> None:
    """At most 1 % false faults, and every promise kept."""
    sound = [name for name in KINDS if name != "sensor-drift"]
    done = campaign(VIRTUAL, only=sound, runs=cases(5, 1), seed=5, mismatch=True)
    healthy = [trial for trial in done.trials if trial.plan.name == NOTHING]
    assert len(healthy) == cases(50, 10) and not any(trial.named for trial in healthy)
    assert [trial for trial in done.trials if not trial.is_met] == []


@pytest.mark.slow
@pytest.mark.parametrize("rest", ["open", pytest.param("closed", marks=pytest.mark.campaign)])
def test_every_fault_several_times(rest: str) -> None:
    sound = [name for name in KINDS if name != "sensor-drift"]
    done = campaign(f"{VIRTUAL}&rest={rest}", only=sound, runs=(runs := cases(10, 1)), seed=1)
    assert len(done.trials) == runs * len(sound)
    assert [trial for trial in done.trials if not trial.is_met] == []


def test_a_run_is_the_same_for_the_same_seed() -> None:
    one, same = (draw_plan(BEHIND, "leak", 7, 3) for _ in range(2))
    other = draw_plan(BEHIND, "leak", 8, 3)
    assert one == same and one.case.target != other.case.target
    plants = [draw_plan(BEHIND, "leak", n, 0).behind.plant for n in range(200)]
    for name in ("rate", "leak", "vent"):
        told, some = getattr(BEHIND.plant, name), [getattr(plant, name) for plant in plants]
        assert told / 1.4 <= min(some) < 0.75 * told and 1.35 * told < max(some) <= told * 1.4


def test_what_nobody_knows_is_refused() -> None:
    with pytest.raises(LayerjamError, match="pump-dead"):
        select_faults(["pump-ded"])
    assert select_faults(["core-locked"]) == [] and set(select_faults([])) == set(KINDS)
    with pytest.raises(LayerjamError, match="not a virtual board"):
        set_full_speed("tcp:127.0.0.1:5025")
    assert set_full_speed("sim:choi2018").options["speed"] == "0"
    assert set_full_speed("sim:choi2018?speed=5").options["speed"] == "5"


def test_the_firmware_keeps_what_is_promised_for_it() -> None:
    bench = firmware().bench
    assert (bench.SUPPLY_SAMPLES, bench.SENSOR_TOLERANCE) == (SUPPLY_SAMPLES, SENSOR_GAP)


def test_a_leak_takes_the_vacuum_out_of_its_band_in_time() -> None:
    """The closed form against steps of a plant that only leaks."""
    case = draw_plan(BEHIND, "pump-dead-holding", 0, 0).case
    plant = VirtualPlant(replace(BEHIND, plant=case.regulator.plant))
    plant.vacuum = case.vented_vacuum
    plant.set_outputs(0.0, True)
    while plant.vacuum > case.loss_threshold:
        plant.advance(0.01)
    lasts = case.fall_time(case.regulator.plant.leak, 0.0)
    assert plant.time == pytest.approx(lasts, abs=0.02) and lasts < math.inf
    assert case.fall_time(0.0, 0.0) == case.fall_time(1.0, 2 * case.target) == math.inf


def test_an_open_valve_shows_when_the_pump_looks_weak() -> None:
    """The closed form against steps of the strongest pump with the weakest vent open."""
    case = draw_plan(BEHIND, "vent-stuck-open", 0, 0).case
    made = case.strongest_plant
    plant = VirtualPlant(replace(BEHIND, plant=made))
    plant.set_outputs(1.0, False)
    assert plant.outputs == (1.0, True), "a valve that rests open, without power"
    before, share = 0.0, 1.0
    while share > case.regulator.weak_ratio / 2:
        before = plant.vacuum
        plant.advance(1e-4)
        share = (plant.vacuum - before) / (1e-4 * made.rate * (made.top - before))
    lasts = KINDS["vent-stuck-open"].deadline(case) - case.promised_times["WEAK_PUMP"]
    assert lasts == pytest.approx(plant.time, abs=1e-3)


def test_something_happens_between_two_samples() -> None:
    """The plant breaks at its moment: the pump stops a third of a sample in."""
    plant, half = VirtualPlant(BEHIND), VirtualPlant(BEHIND)
    for made in (plant, half):
        made.set_outputs(1.0, True)
    plant.schedule_action(0.0033, lambda: setattr(plant, "injected", FaultInjection(pump=0.0)))
    plant.advance(0.01)
    half.advance(0.0033)
    half.injected = FaultInjection(pump=0.0)
    half.advance(0.0067)
    assert plant.vacuum == pytest.approx(half.vacuum, rel=1e-12) and plant.time == half.time
    plant.estop = True
    plant.advance(1.0)
    assert plant.vacuum < 0.05 * half.vacuum, "without power the vent valve opens"


def test_the_observer_counts_what_stays_safe() -> None:
    """Outputs that were safe for a moment are not: the last time counts."""
    plan = draw_plan(BEHIND, "sensor-nan", 0, 0)
    plant = VirtualPlant(plan.behind)
    observer = Observer(plant, replace(plan, moment="pumping", level=0.0, phase=0.0))

    def sample(pump: float, power: bool) -> None:
        plant.advance(0.01)
        observer()
        plant.set_outputs(pump, power)

    for _ in range(4):
        sample(1.0, True)
    struck = observer.struck
    assert struck is not None and observer.event == struck and observer.safe_after is None
    sample(0.0, False)
    sample(1.0, True)
    sample(0.0, False)
    last = plant.time
    while not observer.done.is_set():
        sample(0.0, False)
    assert observer.safe_after == pytest.approx(last - struck, abs=1e-9) and last > struck + 0.02
    assert plant.time - struck < 3.0


def test_two_sensors_that_disagree_are_a_fault() -> None:
    class Two(Hal):
        other: float | None = None

        def read_second_sensor(self) -> float | None:
            return self.other

    hal = Two()
    rig = Rig(hal)
    rig.on(60e3)
    rig.run(10, talk=True)
    for other in (hal.vacuum + 5100.0, hal.vacuum - 5100.0):
        hal.other = other
        rig.run(0.1, talk=True)
        assert rig.bench.state == 1, "5 % of 103,421 Pa"
    hal.other = hal.vacuum + 5300.0
    rig.run(0.02, talk=True)
    hal.other = None
    rig.run(0.02, talk=True)
    assert rig.bench.state == 1, "not often enough in a row"
    hal.other = math.nan
    rig.run(0.03, talk=True)
    assert rig.say("OUTP:PROT:FAUL?") == '128,"SENSORS_DISAGREE"'
    assert (rig.hal.pump, rig.hal.power) == (0.0, 0)


def test_a_second_sensor_sees_a_drift_that_one_does_not() -> None:
    name = "sensor-drift"
    with Bed(set_full_speed(f"{CPYTHON}&second=1")) as bed:
        trial = run_trial(bed, draw_plan(bed.behind, name, 0, 0, size=200.0))
    assert trial.named == "SENSORS_DISAGREE" and trial.is_met
    assert trial.safe_after == pytest.approx(0.05 * 103421 / 200, rel=0.05)
    assert KINDS[name].deadline(draw_plan(BEHIND, name, 0, 0).case) == math.inf
    assert draw_plan(BEHIND, name, 0, 0).case.size in DRIFTS


def test_memory_is_counted_where_somebody_does() -> None:
    used = Rig().say("SYST:MEM?").split(",")
    assert used == ["9.91E37", "9.91E37"], "CPython does not"


ROW = {
    "fault", "text", "onset", "named", "safe_after", "named_after", "deadline", "met",
    "vacuum_after", "doubted_after", "runs", "missed", "worst_run",
}  # fmt: skip


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["bench", "faults", CPYTHON, "--only", "e-stop", "core-locked", "--runs", "2"]
    assert main([*words, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["runs"], said["missed"], said["complete"]) == (2, 0, True)
    assert set(said["left_out"]) == set(NOT_HERE)
    (row,) = said["faults"]
    assert set(row) == ROW and row["named"] == {"EMERGENCY_STOP": 2} and row["met"] is True
    assert said["units"]["safe_after"] == "s" and row["safe_after"] <= row["deadline"] == 0.02
    assert main(["bench", "faults", "--only", "nothing"]) == 2
    assert main(["bench", "faults", "serial:/dev/ttyACM0"]) == 2


def test_an_interrupt_ends_it_without_a_result() -> None:
    def progress(what: str, share: float) -> None:
        if share >= 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lj.bench_faults(CPYTHON, only=["e-stop"], runs=5, progress=progress)
    said = lj.bench_faults(CPYTHON, only=["e-stop"], runs=2)
    assert (said.runs, said.missed, said.complete, said.exit_code) == (2, 0, True, 0)
    assert said.faults[0]["runs"] == 2 and replace(said, missed=1).exit_code == 1
