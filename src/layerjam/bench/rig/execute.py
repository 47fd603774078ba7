"""Running a procedure on a bench: carrying out and recording the same steps as the simulator.

Every run, even a failed one, ends with safe outputs and a closed file.
"""

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.bench.control.law import CLOSE
from layerjam.bench.control.settings import FAULTS
from layerjam.bench.rig.address import Address
from layerjam.bench.rig.crosshead import Crosshead, CrossheadLostError
from layerjam.bench.rig.driver import Bench, open_bench_as
from layerjam.bench.rig.line import LineError
from layerjam.bench.rig.recorder import (
    DISK_FULL,
    FINISHED,
    LINE_LOST,
    STOPPED,
    Block,
    Recorder,
    describe_bench,
)
from layerjam.bench.rig.run_file import RecordingError, RunFile
from layerjam.bench.rig.settling import Watch, last_vacuum, measure_scatter, steady_test
from layerjam.bench.rig.shots import DropRig, Shots, ShotSummary, check_rig
from layerjam.bench.rig.stop import Stop
from layerjam.brake.simulate.procedure import (
    Evacuate,
    Hold,
    Procedure,
    Pull,
    Return,
    Step,
    Vent,
    parse_procedure,
)
from layerjam.core.brief import brief
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.store import accept_force_option
from layerjam.core.units import show

NOT_REACHED, NOT_VENTED = "NOT_REACHED", "NOT_VENTED"
CROSSHEAD_LOST, FAULT = "CROSSHEAD_LOST", "FAULT"
EXTRA, TIMES = 10.0, 3.0
"""A run ends if its vacuum is not reached in EXTRA [s] plus TIMES the predicted rise time."""
AT_REST = 0.3
"""Duration of the samples before the start, which show the sensor's noise [s]."""
LAST = 0.5
"""Duration of the recording after the outputs are off [s]."""
STATES = {"SAFE": 0, "RUN": 1, "FAULT": 2}
LEASE = 2.0
"""Silence of this program after which the board switches to its safe state [s]."""
QUICK = 600.0
"""The same for a virtual board at a speed other than 1, by the board's clock [s]."""


class EndedError(Exception):
    """Raised if a procedure ends before its last step, with an `outcome`."""

    def __init__(self, outcome: str, reason: str) -> None:
        super().__init__(reason)
        self.outcome = outcome


@dataclass(frozen=True, kw_only=True)
class StepResult:
    """Result of one step; times [s] are on the file's clock, None if it did not begin or end."""

    text: str
    started: float | None = None
    ended: float | None = None
    reached: bool = False


@brief
@dataclass(frozen=True, kw_only=True)
class RunResult:
    """Outcome of a run."""

    outcome: str
    reason: str | None
    run_id: str
    samples: int
    gaps: int
    duration: float
    """Time [s] from the start to the last sample."""
    steps: tuple[StepResult, ...]
    fault: str | None
    fault_time: float | None
    file: Path
    simulated: bool
    shots: tuple[ShotSummary, ...] | None = None
    """Summaries of the accelerometer's records, or None if it was not used."""


class Execution:
    """One procedure on one bench, recorded in one file."""

    def __init__(
        self,
        bench: Bench,
        procedure: Procedure,
        file: RunFile,
        crosshead: Crosshead | None,
        stop: Stop,
        watch: Callable[[Block], None],
        rig: DropRig | None = None,
    ) -> None:
        self.bench, self.procedure, self.file = bench, procedure, file
        self.crosshead, self.stop, self._told = crosshead, stop, watch
        self.recorder = Recorder(bench, file)
        self.shots = None if rig is None else Shots(bench, file, rig)
        self.watch = Watch.from_bench(bench)
        self.step_results = [StepResult(text=step.text()) for step in procedure.steps]
        self.fault: str | None = None
        self.fault_us: int | None = None
        self.first_us: int | None = None
        self._vacuum = self._noise = 0.0
        self._running = False

    def run(self) -> tuple[str, str | None]:
        """Return the outcome and, unless it is a success, the reason; the outputs are then off."""
        try:
            try:
                self._begin_run()
                for place, step in enumerate(self.procedure.steps):
                    self._run_step(place, step)
                return FINISHED, None
            finally:
                self._make_safe()
        except EndedError as end:
            return end.outcome, str(end)
        except RecordingError as error:
            return DISK_FULL, str(error)
        except LineError as error:
            return LINE_LOST, str(error)
        except CrossheadLostError as error:
            return CROSSHEAD_LOST, str(error)

    def _begin_run(self) -> None:
        """Measure the sensor's noise at rest, then start the law without a target."""
        self.bench.target = 0.0
        if self.shots is not None:
            self.shots.prepare()
        self.recorder.start_recording(self._read_positions)
        self.first_us = self.recorder.now
        readings: list[np.ndarray[Any, Any]] = []

        def store_vacuum(block: Block) -> bool:
            readings.append(block.rows["vacuum"])
            return False

        self._run_until(store_vacuum, AT_REST)
        self._noise = measure_scatter(np.concatenate(readings)) if readings else 0.0
        self.bench.output = True
        self._run_until(lambda block: bool((block.rows["state"] == STATES["RUN"]).any()), 1.0)

    def _run_step(self, place: int, step: Step) -> None:
        text, start = self.step_results[place].text, self._elapsed_time
        self.file.add_note("step", text, self.recorder.now)
        self.step_results[place] = StepResult(text=text, started=start)
        try:
            if isinstance(step, Evacuate):
                self._evacuate_chamber(step)
            elif isinstance(step, Vent):
                self._vent_chamber()
            elif isinstance(step, Hold):
                self._hold_target(step.duration)
            else:
                self._move_crosshead(step)
        finally:
            self.step_results[place] = replace(self.step_results[place], ended=self._elapsed_time)
        self.step_results[place] = replace(self.step_results[place], reached=True)

    def _evacuate_chamber(self, step: Evacuate) -> None:
        """Wait until the vacuum has been near its target for half a second, then hold it."""
        tolerance = max(CLOSE * step.to, self.watch.regulator[3])
        limit = TIMES * self.watch.rise_time(self._vacuum, step.to - tolerance) + EXTRA
        self.bench.target = step.to
        is_steady = steady_test(self.watch, step.to, self._noise, self.recorder.now)
        if not self._run_until(is_steady, limit, self._last_sample()):
            raise EndedError(
                NOT_REACHED,
                f"{show(step.to, 'Pa')} was not reached within {limit:.3g} s; the vacuum is "
                f"{show(self._vacuum, 'Pa', 4)}",
            )
        self._hold_target(step.hold)

    def _vent_chamber(self) -> None:
        """Wait until the reading is accepted as zero vacuum."""
        limit = 2 * self.watch.settle_time
        self.bench.target = 0.0
        zero = self.watch.zero
        if not self._run_until(
            lambda block: bool(last_vacuum(block) < zero), limit, self._last_sample()
        ):
            raise EndedError(
                NOT_VENTED,
                f"the vacuum is {show(self._vacuum, 'Pa', 4)} after {limit:.3g} s of venting; "
                f"expected less than {show(self.watch.zero, 'Pa', 4)}",
            )

    def _hold_target(self, duration: float) -> None:
        if duration <= 0:
            return
        if self.shots is not None:
            self.shots.expect_drop()
            while not self.shots.is_waiting:
                self._record_block()
            self.shots.release_mass()
            while self.recorder.is_behind(self._record_block()):
                pass  # the hold begins with the board's current sample
        self._run_until(lambda block: False, duration)

    def _move_crosshead(self, step: Pull | Return) -> None:
        crosshead = self.crosshead
        if crosshead is None:
            raise CrossheadLostError("the procedure moves a crosshead, but none is given")
        crosshead.start_move(step, self.bench, self.file.add_note)
        try:
            start = self.recorder.now
            while not crosshead.is_done((self.recorder.now - start) * 1e-6):
                self._record_block()
        finally:
            crosshead.end_move(self.bench)

    def _last_sample(self) -> int:
        """Return the number of the latest sample; a command just sent takes effect after it."""
        return int(self.bench.ask("FETC:ALL?").split(",")[0])

    def _run_until(self, is_done: Callable[[Block], bool], limit: float, after: int = -1) -> bool:
        """Record until `is_done`; return False after `limit` [s] of the board's clock.

        The time counts from sample `after`, because a delayed host first reads samples from before
        the command.
        """
        start = self.recorder.now
        while True:
            block = self._record_block()
            if len(block.rows) and is_done(block):
                return True
            if self.recorder.seq <= after:
                start = self.recorder.now
            if (self.recorder.now - start) * 1e-6 >= limit:
                return False

    def _record_block(self) -> Block:
        """Record one block, and end the run if one of its samples requires that."""
        if self.stop.asked:
            raise EndedError(STOPPED, "stopped by the operator")
        recorder, boot = self.recorder, self.recorder.boot
        block = recorder.record_block(self._read_positions)
        if boot is not None and recorder.boot != boot:
            raise EndedError(LINE_LOST, "the board was reset during the run")
        if len(block.rows):
            self._told(block)
            self._check_block(block)
            if self.shots is not None:
                self.shots.poll_capture(recorder)
        recorder.pause(block)
        return block

    def _read_positions(self, block: Block) -> list[tuple[int, float, float]]:
        if self.crosshead is None:
            return []
        return self.crosshead.read_positions(block)

    def _check_block(self, block: Block) -> None:
        """End the run on a fault, or if another client switched the outputs off."""
        self._vacuum = last_vacuum(block)
        state = block.rows["state"]
        faults = np.flatnonzero(state == STATES["FAULT"])
        if len(faults):
            self.fault_us = int(block.us[faults[0]])
            code = int(block.rows["fault"][faults[0]])
            self.fault = FAULTS.get(code) or self.bench.fault or f"{code}"
            self.file.add_note("fault", self.fault, self.fault_us)
            raise EndedError(
                f"{FAULT}:{self.fault}",
                f"the bench went to its safe state: {self.fault}; to clear it, run "
                f"'layerjam bench clear {self.bench.address}'",
            )
        if self._running and (state == STATES["SAFE"]).any():
            raise EndedError(STOPPED, "another client switched the outputs off")
        self._running = bool(state[-1] == STATES["RUN"])

    @property
    def _elapsed_time(self) -> float | None:
        return None if self.first_us is None else (self.recorder.now - self.first_us) * 1e-6

    def _make_safe(self) -> None:
        """Turn the outputs off, then record for half a second if the line and the disk allow it."""
        try:
            self.bench.off()
            self.bench.target = 0.0
            if self.crosshead is not None:
                self.crosshead.end_move(self.bench)
            shots, recorder = self.shots, self.recorder
            last, boot, end = self._last_sample(), recorder.boot, recorder.now + LAST * 1e6
            if shots is not None:
                shots.finish_capture(recorder)
            while recorder.now < end or (shots is not None and shots.is_recording):
                recorder.pause(recorder.record_block(self._read_positions))
                if recorder.seq <= last and recorder.boot == boot:
                    end = recorder.now + LAST * 1e6  # samples from before the outputs were off
                if shots is not None:
                    shots.poll_capture(recorder)
        except LayerjamError:
            # if the connection is lost, the lease acts; if the disk is full, nothing more can be
            # stored
            pass


def check_procedure(bench: Bench, procedure: Procedure, crosshead: Crosshead | None) -> None:
    """Raise QuantityError if a bench cannot carry out a procedure."""
    reachable = bench.reach
    for step in procedure.steps:
        if isinstance(step, Evacuate) and step.to > reachable:
            raise QuantityError.of(
                "procedure",
                f"'{step.text()}' is not possible: the controller of {bench.address} "
                + (f"reaches only {show(reachable, 'Pa', 4)}" if reachable else "is not set"),
            )
        if isinstance(step, Pull | Return) and crosshead is None:
            raise QuantityError.of("crosshead", f"missing; '{step.text()}' needs one")


@accept_force_option
def execute(
    bench: Bench,
    procedure: Procedure | str,
    *,
    out: str | Path,
    crosshead: Crosshead | None = None,
    meta: Mapping[str, object] | None = None,
    overwrite: bool = False,
    stop: Stop | None = None,
    watch: Callable[[Block], None] = lambda block: None,
    rig: DropRig | None = None,
    say: Callable[[str], None] = lambda sentence: None,
) -> RunResult:
    """Carry out a procedure on a bench that has a controller and a safe state, and record it.

    `meta` contains further entries for the file (brake_toml, line_toml). Raises QuantityError or
    ProcedureError for an impossible procedure, InstrumentError if the bench does not start,
    FileError if the file cannot be written. No file remains if the run is rejected. Ctrl-C, SIGTERM
    and `stop` end the run with OPERATOR_STOPPED. `watch` receives every block of samples after it
    is on disk. With a `rig`, the accelerometer's records of drops are stored in the file. `say`
    receives a sentence that states the lease.
    """
    steps = parse_procedure(procedure) if isinstance(procedure, str) else procedure
    check_procedure(bench, steps, crosshead)
    if rig is not None:
        check_rig(rig, bench, steps)
    entries = {"kind": "run", "procedure": steps.text(), **describe_bench(bench), **(meta or {})}
    entries |= {} if rig is None else rig.metadata()
    with stop or Stop() as stop:
        if not bench.lock():
            owner = bench.ask("SYST:LOCK:OWN?")
            raise QuantityError.of("bench", f"is locked by another client (session {owner})")
        lease_before = bench.lease
        plant = bench.plant
        bench.lease = LEASE if plant is None or plant.behind.speed == 1.0 else QUICK
        say(
            f"lease {bench.lease:g} s: if this program is silent for longer, the "
            f"outputs go to the safe state ({bench.safe_state})"
        )
        try:
            file = RunFile.create(out, entries, overwrite)
            try:
                result = _run_and_close(
                    bench, file, Execution(bench, steps, file, crosshead, stop, watch, rig)
                )
            except BaseException:
                file.close()
                raise
        finally:
            # restore the lease and release the lock if the connection still works
            with contextlib.suppress(LayerjamError):
                bench.lease = lease_before
                bench.unlock()
    return result


def _run_and_close(bench: Bench, file: RunFile, running: Execution) -> RunResult:
    try:
        outcome, reason = running.run()
    except LayerjamError:
        if running.step_results[0].started is None:
            file.discard()  # reject before anything has been done
        raise
    if reason is not None:
        file.add_note("note", reason, running.recorder.now)
    samples, gaps, _ = file.counts()
    meta = file.meta
    first, fault = running.first_us, running.fault_us
    file.close(outcome)
    return RunResult(
        outcome=outcome,
        reason=reason,
        run_id=meta["run_id"],
        samples=samples,
        gaps=gaps,
        duration=0.0 if first is None else (running.recorder.now - first) * 1e-6,
        steps=tuple(running.step_results),
        fault=running.fault,
        fault_time=None if first is None or fault is None else (fault - first) * 1e-6,
        file=file.path,
        simulated=meta["simulated"] != "0",
        shots=None if running.shots is None else running.shots.summary(first),
    )


class ProcedureBench(Bench):
    """A bench whose method `run` carries out a procedure; returned by `layerjam.bench.rig.open`."""

    run = execute


def open_procedure_bench(address: str | Address) -> ProcedureBench:
    """Return the bench at an address; see `layerjam.bench.rig.driver.open_bench`."""
    return open_bench_as(address, ProcedureBench)
