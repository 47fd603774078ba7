"""What pulls the brake: a person, a machine by contacts, the virtual machine in the plant."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.rig.test_runs import RUN, ready
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.crosshead import CrossheadLostError, Manual, Trigger, Virtual, move_timeout
from layerjam.bench.rig.machine import VirtualMachine, check_brake
from layerjam.bench.rig.recorder import Block
from layerjam.bench.rig.stepped_brake import SteppedBrake
from layerjam.bench.rig.telemetry import RECORD
from layerjam.bench.rig.virtual_plant import VirtualPlant, read_hardware
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.mechanics.hysteresis import brake_cycle
from layerjam.brake.simulate.procedure import Pull, Return
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.laboratory.measure.runs import read_run

PULL = Pull(speed=13e-3, until=40e-3)


class Asked:
    """A bench that keeps what it is told."""

    plant, address = None, address_of("tcp:127.0.0.1:1")

    def __init__(self) -> None:
        self.told: list[str] = []

    def tell(self, line: str) -> None:
        self.told.append(line)


def with_flags(*flags: int) -> Block:
    rows = np.zeros(len(flags), RECORD)
    rows["flags"] = flags
    return Block(rows, np.arange(len(flags)))


def test_a_person_is_told_and_asked_twice(tmp_path: Path) -> None:
    """The marker stands in the samples from the first Enter to the second."""
    said: list[str] = []
    keys = itertools.chain([False, True, False, False, True], itertools.repeat(False))
    with ready() as bench:
        made = bench.run(
            "pull at 13 mm/s until 40 mm",
            out=tmp_path / "a.ljrun",
            crosshead=Manual(lambda: next(keys), said.append),
        )
    assert made.outcome == "FINISHED" and len(said) == 2
    assert "pull at 13 mm/s until 40 mm" in said[0] and "is at 40 mm" in said[1]
    run = read_run(made.file)
    marked = np.flatnonzero(run.columns["flags"] & 4)
    assert len(marked) > 20 and np.array_equal(np.diff(marked), np.ones(len(marked) - 1))
    assert marked[-1] < run.samples - 30 and "force" not in run.columns
    kinds = [kind for *_, kind, _ in run.events]
    assert kinds == ["step", "prompt", "answer", "prompt", "answer"]


def test_nobody_is_there(tmp_path: Path) -> None:
    def gone() -> bool:
        raise CrossheadLostError("nobody is at the keyboard")

    with ready() as bench:
        made = bench.run(
            "pull at 13 mm/s until 40 mm", out=tmp_path / "a.ljrun",
            crosshead=Manual(gone, lambda text: None),
        )  # fmt: skip
        assert bench.state == "SAFE"
    assert (made.outcome, made.reason) == ("CROSSHEAD_LOST", "nobody is at the keyboard")
    manual, asked = Manual(lambda: False, lambda text: None), Asked()
    manual.start_move(PULL, asked, lambda kind, text: None)  # type: ignore[arg-type]
    assert not manual.is_done(599)
    with pytest.raises(CrossheadLostError, match="600 s"):
        manual.is_done(601)


def test_two_contacts() -> None:
    machine, bench = Trigger(), Asked()
    note: Any = lambda kind, text: None  # noqa: E731
    machine.read_positions(with_flags(1, 1))
    machine.start_move(PULL, bench, note)  # type: ignore[arg-type]
    assert bench.told == ["OUTP:SYNC ON"] and not machine.is_done(3.0)
    machine.read_positions(with_flags(1, 17))
    assert machine.is_done(3.1)
    machine.end_move(bench)  # type: ignore[arg-type]
    machine.end_move(bench)  # type: ignore[arg-type]
    assert bench.told == ["OUTP:SYNC ON", "OUTP:SYNC OFF"]
    with pytest.raises(CrossheadLostError, match="before the machine was started"):
        machine.start_move(PULL, bench, note)  # type: ignore[arg-type]
    machine.read_positions(with_flags(0))
    machine.start_move(Return(speed=13e-3, to=0.0), bench, note)  # type: ignore[arg-type]
    with pytest.raises(CrossheadLostError, match="did not close"):
        machine.is_done(move_timeout(PULL, 0.0) + 0.1)
    assert move_timeout(PULL, 0.0) == pytest.approx(2 * 40 / 13 + 10)


def test_a_machine_started_and_ended_by_contacts(tmp_path: Path) -> None:
    """The machine is a few lines of the test: it closes its contact 200 samples after the start."""
    with ready() as bench:
        plant = bench.plant
        assert plant is not None
        started: list[int] = []

        class Machine(Trigger):
            def start_move(self, *given: Any) -> None:
                super().start_move(*given)
                started.append(plant.asked)
                plant.watch = close

        def close() -> None:
            plant.contact = plant.asked >= started[-1] + 200

        made = bench.run(
            "pull at 13 mm/s until 40 mm", out=tmp_path / "a.ljrun", crosshead=Machine()
        )
    run = read_run(made.file)
    flags, seq = run.columns["flags"], run.columns["seq"]
    closed, marked = seq[flags & 16 != 0], seq[flags & 4 != 0]
    assert made.outcome == "FINISHED" and closed[0] == started[0] + 199
    assert marked[0] <= started[0] and closed[0] < marked[-1]


def test_a_virtual_machine_needs_a_virtual_board_of_its_own() -> None:
    brake, line = load("choi2018-kapton").brake, load_line("choi2018").line
    with pytest.raises(QuantityError, match="'virtual' is not allowed"):
        Virtual(Asked(), brake, line)  # type: ignore[arg-type]
    with pytest.raises(QuantityError, match="overlap"):
        check_brake(brake, brake.sheets.overlap)


@pytest.mark.slow
def test_a_brake_pulled_sample_by_sample_is_the_brake_pulled_as_a_whole() -> None:
    draw = np.random.default_rng(5)
    moves = draw.uniform(0, 6e-3, 9) * np.resize([1, -0.6], 9)
    turns = np.concatenate([[0.0], np.cumsum(moves)])
    elongation = np.interp(np.linspace(0, 9, 200), np.arange(10), np.maximum(turns, 0.0))
    vacuum = 60e3 + draw.normal(0, 50, 200).cumsum()
    brake = load("choi2018-kapton").brake
    whole = brake_cycle(elongation, vacuum, brake)
    pulled = SteppedBrake(brake)
    # the whole history takes over its first vacuum at rest
    found = np.array([pulled.step_to(x, p) for x, p in zip(elongation, vacuum, strict=True)])
    assert np.allclose(found[:, 0], whole.force, rtol=1e-12, atol=1e-9)
    assert np.allclose(found[:, 1], whole.slip, rtol=1e-12, atol=1e-15)


@pytest.mark.slow
def test_a_slip_makes_the_chamber_larger() -> None:
    """A tight chamber, its pump off: p V^n stays, and the machine moves in the plant's time."""
    made = read_hardware(address_of("sim:choi2018"))
    line = load_line("choi2018").line
    area = 0.2 * line.chamber.volume / 40e-3
    line = replace(line, chamber=replace(line.chamber, volume_per_slip=area))
    plant = VirtualPlant(replace(made, plant=replace(made.plant, leak=0.0), normally_open=False))
    plant.machine = machine = VirtualMachine(load("choi2018-kapton").brake, line)
    plant.vacuum = plant.shown = 60e3
    atmosphere, n = line.site.atmosphere, line.polytropic
    machine.start_motion(40e-3, 13e-3)
    for _ in range(400):
        plant.advance(0.01)
        due = min(40e-3, 13e-3 * plant.time)
        assert machine.elongation == pytest.approx(due, abs=1e-12)
    larger = 1 + area * machine.slip / line.chamber.volume
    assert not machine.moving and larger > 1.15
    assert (atmosphere - plant.vacuum) * larger**n == pytest.approx(atmosphere - 60e3, rel=1e-9)
    assert plant.read_sensor()[0] == pytest.approx(plant.vacuum)
    # the pump now empties more: its rate is that of the larger chamber
    before = plant.vacuum
    plant.set_outputs(1.0, False)
    plant.advance(1e-4)
    slope = made.plant.rate / larger * (made.plant.top - before)
    assert (plant.vacuum - before) / 1e-4 == pytest.approx(slope, rel=1e-3)


@pytest.fixture(scope="module")
def pulled(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    path = tmp_path_factory.mktemp("pull") / "a.ljrun"
    procedure = "evacuate to 60 kPa and hold 1 s; pull at 2 mm/s until 10 mm; return at 13 mm/s " \
        "to 0 mm; vent"  # fmt: skip
    words = [*RUN, "--procedure", procedure, "--crosshead", "virtual", "--out", str(path)]
    with pytest.MonkeyPatch.context() as patch:
        said: list[str] = []
        patch.setattr("builtins.print", lambda *words, **more: said.append(str(words[0])))
        assert main([*words, "--json"]) == 0
    yield json.loads(said[-1])


@pytest.mark.slow
def test_a_pull_on_the_virtual_bench_calibrates_to_the_brake_itself(
    pulled: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert (pulled["outcome"], pulled["gaps"]) == ("FINISHED", 0)
    run, pull, back = read_run(pulled["file"]), pulled["steps"][1], pulled["steps"][2]
    time, elongation = run.columns["time"], run.columns["elongation"]
    assert np.isfinite(elongation).all() and elongation.max() == pytest.approx(10e-3)
    moving = np.flatnonzero(np.diff(elongation) > 0)
    pace = np.diff(elongation)[moving[1:-1]] / np.diff(time)[moving[1:-1]]
    assert np.allclose(pace, 2e-3) and elongation[time > back["ended"]].max() == 0
    # against the law along the same history, in one go
    force = brake_cycle(elongation, run.columns["vacuum"], load("choi2018-kapton").brake).force
    assert np.abs(force - run.columns["force"]).max() < 0.2
    out = tmp_path / "pull.csv"
    span = ["--from", f"{pull['started']} s", "--to", f"{pull['ended']} s"]
    assert main(["bench", "export", pulled["file"], "--out", str(out), *span]) == 0
    capsys.readouterr()
    assert main(["calibrate", "choi2018-kapton", str(out), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    brake = load("choi2018-kapton").brake
    assert found["scale_factor"] == pytest.approx(brake.scale_factor, rel=0.003)
    assert found["stiffness"] == pytest.approx(brake.stiffness_measured, rel=0.01)
    assert any("synthetic" in text for text in found["warnings"])
