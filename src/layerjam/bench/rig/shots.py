"""Drop rig of a run: the accelerometer waits for drops from the first hold onwards.

Each record is written to the run's file as soon as it is complete. Meanwhile, the board's samples
wait in its ring for at most one second; ten seconds fit.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from layerjam.bench.rig.crosshead import notify_operator
from layerjam.bench.rig.driver import Bench
from layerjam.bench.rig.drop import (
    DELAY,
    arm,
    fall,
    pending_shot,
    prepare,
    read_capture,
    read_piece,
)
from layerjam.bench.rig.recorder import Recorder
from layerjam.bench.rig.run_file import RunFile
from layerjam.bench.rig.trigger import AFTER
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.simulate.procedure import Evacuate, Hold, Procedure, Pull, Return
from layerjam.brake.simulate.quantities import ARRIVAL_SPEED, MASS
from layerjam.core.errors import QuantityError
from layerjam.core.units import exact_text, show
from layerjam.laboratory.measure.shots import Shot

WRAP = 1 << 32
"""Range of the clock in which a board states the time of a trigger [us]."""
READY = "The accelerometer is armed: let the mass fall."


@dataclass(frozen=True, kw_only=True)
class DropRig:
    """A mass dropped on the brake, and the settings of its accelerometer.

    `capture` contains settings of `drop.prepare`. On a virtual board, a mass [kg] falls on the
    brake `file` at the start of each hold and arrives with `speed` [m/s]. For a real board, both
    are only stored in the file. `say` prompts a person to drop the mass.
    """

    capture: Mapping[str, Any] = field(default_factory=dict)
    file: BrakeFile | None = None
    mass: float | None = None
    speed: float | None = None
    rope_stiffness: float | None = None
    say: Callable[[str], None] = notify_operator

    def metadata(self) -> dict[str, str]:
        """Return the entries of the run file about the drop."""
        units = {"mass": "kg", "speed": "m/s", "rope_stiffness": "N/m"}
        values = {name: getattr(self, name) for name in units}
        return {
            f"drop_{name}": exact_text(value, units[name])
            for name, value in values.items()
            if value is not None
        }


@dataclass(frozen=True, kw_only=True)
class ShotSummary:
    """One record in the file: its size, and the time of its trigger [s]."""

    shot: int
    time: float
    samples: int
    rate: float
    whole: bool


def check_rig(rig: DropRig, bench: Bench, procedure: Procedure) -> None:
    """Raise QuantityError if a procedure has no hold for a drop, or if no mass is given."""
    hold_times = {
        step.text(): _hold_time(step) for step in procedure.steps if _hold_time(step) > 0.0
    }
    if not hold_times:
        raise QuantityError.of(
            "shot", "the mass falls during a hold, but the procedure has none; write 'hold 20 s'"
        )
    if bench.plant is None:
        return
    mass, speed = rig.mass, rig.speed
    if rig.file is None or mass is None or speed is None:
        raise QuantityError.of(
            "shot",
            "for a fall on a virtual board, state the mass and its speed on arrival "
            "(--mass 1kg --speed 2.5m/s)",
        )
    MASS.check(mass, "mass")
    ARRIVAL_SPEED.check(speed, "speed")
    move = next((s for s in procedure.steps if isinstance(s, Pull | Return)), None)
    if move is not None:
        raise QuantityError.of(
            "shot", f"'{move.text()}' is not possible: the virtual brake is mounted in the drop rig"
        )
    time_after = AFTER.si(rig.capture.get("after", 0.5), "after")
    least_time = DELAY + speed / rig.file.brake.site.gravity + time_after
    for text, lasting in hold_times.items():
        if lasting < least_time:
            raise QuantityError.of(
                "shot",
                f"'{text}' is too short: a fall that reaches {show(speed, 'm/s')} and its record "
                f"need {show(least_time, 's')}",
            )


def _hold_time(step: object) -> float:
    if isinstance(step, Evacuate):
        return step.hold
    return step.duration if isinstance(step, Hold) else 0.0


class Shots:
    """Accelerometer of one run."""

    def __init__(self, bench: Bench, file: RunFile, rig: DropRig) -> None:
        self._bench, self._file, self._rig = bench, file, rig
        self._taken: list[Shot] = []
        self._state = "IDLE"
        self._wanted = self._said = False

    def prepare(self) -> None:
        """Write the settings in SAFE; raises InstrumentError if the board has no accelerometer."""
        prepare(self._bench, **self._rig.capture)
        arm(self._bench)
        self._bench.tell("ABOR")

    def expect_drop(self) -> None:
        """Make the accelerometer wait for the next drop."""
        self._wanted, self._said = True, False
        self._arm_capture()

    @property
    def is_waiting(self) -> bool:
        """Return whether the accelerometer waits for a drop."""
        return self._state == "WAITING"

    @property
    def is_recording(self) -> bool:
        """Return whether a record has started but is not complete."""
        return self._state == "RUNNING"

    def release_mass(self) -> None:
        """Tell the operator to drop the mass; on a virtual board, drop it."""
        rig = self._rig
        if self._bench.plant is None:
            if not self._said:
                self._said = True
                self._file.add_note("prompt", READY)
                rig.say(READY)
            return
        if rig.file is None or rig.mass is None or rig.speed is None:
            return
        numbers: dict[str, Any] = {"mass": rig.mass, "speed": rig.speed}
        stop = fall(self._bench, rig.file, rope_stiffness=rig.rope_stiffness, **numbers)
        self._file.add_note("note", f"a virtual mass falls; computed outcome: {stop.outcome.name}")

    def poll_capture(self, recorder: Recorder) -> None:
        """Query the accelerometer once per block of samples; fetch and store a complete record."""
        if self._state == "IDLE":
            if self._wanted:
                self._arm_capture()
            return
        capture = read_capture(self._bench)
        self._state = capture.state
        if capture.state == "DONE":
            micros = capture.trigger_us - recorder.now
            shot = replace(
                pending_shot(self._bench, capture),
                number=len(self._taken) + 1,
                boot=recorder.boot or 0,
                trigger_us=recorder.now + (micros + WRAP // 2) % WRAP - WRAP // 2,
            )
            self._fetch_shot(shot)
            self._state = "IDLE"

    def _arm_capture(self) -> None:
        if self._state == "IDLE":
            arm(self._bench)
            self._state = "WAITING"

    def _fetch_shot(self, shot: Shot) -> None:
        """Store all samples of a record on disk, piece by piece."""
        self._file.add_shot(shot.row())
        self._taken.append(shot)
        while len(shot.counts) < shot.size:
            first = len(shot.counts)
            data = read_piece(self._bench, first, shot.size)
            self._file.add_shot_data(shot.number, first, data)
            counts = np.concatenate([shot.counts, np.frombuffer(data, "<i2")])
            shot = self._taken[-1] = replace(shot, counts=counts)
        text = f"shot {shot.number}: {shot.size} samples at {show(shot.rate, 'Hz')}"
        self._file.add_note("note", text, shot.trigger_us)

    def finish_capture(self, recorder: Recorder) -> None:
        """Finish when no more drops are expected and the outputs are off.

        A record that has started is kept.
        """
        self._wanted = False
        if self.is_waiting:
            self.poll_capture(recorder)
        if self.is_waiting:
            self._bench.tell("ABOR")
            self._state = "IDLE"

    def summary(self, first_us: int | None) -> tuple[ShotSummary, ...]:
        """Return the records in the file, with times [s] since a moment of the board's clock."""
        return tuple(
            ShotSummary(
                shot=shot.number,
                time=(shot.trigger_us - (first_us or 0)) * 1e-6,
                samples=len(shot.counts),
                rate=shot.rate,
                whole=len(shot.counts) == shot.size,
            )
            for shot in self._taken
        )
