"""The drop rig of a run: from its first hold on the accelerometer waits, and its records are kept.

A record goes into the run's file as soon as it is whole; the board's samples wait in its ring
meanwhile, a second of ten at most.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.errors import QuantityError
from layerjam.measure.shots import Shot
from layerjam.rig.crosshead import tell_person
from layerjam.rig.driver import Bench
from layerjam.rig.drop import DELAY, arm, capture_of, coming, fall, piece, prepare
from layerjam.rig.recorder import Recorder
from layerjam.rig.run_file import RunFile
from layerjam.rig.trigger import AFTER
from layerjam.simulate.procedure import Evacuate, Hold, Procedure, Pull, Return
from layerjam.simulate.quantities import ARRIVAL_SPEED, MASS
from layerjam.units import exact_text, show

if TYPE_CHECKING:
    from layerjam.device.file import BrakeFile

WRAP = 1 << 32
"""Of the clock on which a board states a trigger [us]."""
READY = "The accelerometer waits: let the mass fall."


@dataclass(frozen=True, kw_only=True)
class DropRig:
    """What falls on the brake, and how its accelerometer is read.

    `capture` are settings of `drop.prepare`. On a virtual board a mass [kg] falls on the brake
    `file` at the beginning of each hold and arrives with `speed` [m/s]; on a real one both are what
    a person says of the drop, and only kept. `say` shows a person when the mass
    may fall.
    """

    capture: Mapping[str, Any] = field(default_factory=dict)
    file: BrakeFile | None = None
    mass: float | None = None
    speed: float | None = None
    rope_stiffness: float | None = None
    say: Callable[[str], None] = tell_person

    def facts(self) -> dict[str, str]:
        """What the run file says of the drop."""
        units = {"mass": "kg", "speed": "m/s", "rope_stiffness": "N/m"}
        stated = {name: getattr(self, name) for name in units}
        return {
            f"drop_{name}": exact_text(value, units[name])
            for name, value in stated.items()
            if value is not None
        }


@dataclass(frozen=True, kw_only=True)
class Taken:
    """One record in the file: when it was triggered [s] and what came of it."""

    shot: int
    time: float
    samples: int
    rate: float
    whole: bool


def check_rig(rig: DropRig, bench: Bench, procedure: Procedure) -> None:
    """Raise QuantityError where a procedure has no moment for a drop, or nothing can fall."""
    holds = {step.text(): _hold(step) for step in procedure.steps if _hold(step) > 0.0}
    if not holds:
        raise QuantityError.of(
            "shot", "the mass falls in a hold, and the procedure has none; write 'hold 20 s'"
        )
    if bench.plant is None:
        return
    mass, speed = rig.mass, rig.speed
    if rig.file is None or mass is None or speed is None:
        raise QuantityError.of(
            "shot",
            "on a virtual board a mass must be stated and its speed on arrival, for it to "
            "fall (--mass 1kg --speed 2.5m/s)",
        )
    MASS.check(mass, "mass")
    ARRIVAL_SPEED.check(speed, "speed")
    moves = next((s for s in procedure.steps if isinstance(s, Pull | Return)), None)
    if moves is not None:
        raise QuantityError.of(
            "shot", f"'{moves.text()}' is not possible: the virtual brake hangs in the drop rig"
        )
    after = AFTER.si(rig.capture.get("after", 0.5), "after")
    needed = DELAY + speed / rig.file.brake.site.gravity + after
    for text, lasting in holds.items():
        if lasting < needed:
            raise QuantityError.of(
                "shot",
                f"'{text}' is too short: a fall to {show(speed, 'm/s')} and its record take "
                f"{show(needed, 's')}",
            )


def _hold(step: object) -> float:
    """How long a step holds [s]."""
    if isinstance(step, Evacuate):
        return step.hold
    return step.duration if isinstance(step, Hold) else 0.0


class Shots:
    """The accelerometer of one run."""

    def __init__(self, bench: Bench, file: RunFile, rig: DropRig) -> None:
        self._bench, self._file, self._rig = bench, file, rig
        self._taken: list[Shot] = []
        self._state = "IDLE"
        self._wanted = self._said = False

    def prepare(self) -> None:
        """Settings, in SAFE; raises InstrumentError where the board has no accelerometer."""
        prepare(self._bench, **self._rig.capture)
        arm(self._bench)
        self._bench.tell("ABOR")

    def expect(self) -> None:
        """From now on the accelerometer is to wait for the next drop."""
        self._wanted, self._said = True, False
        self._arm()

    @property
    def waiting(self) -> bool:
        """Whether it waits."""
        return self._state == "WAITING"

    @property
    def coming(self) -> bool:
        """Whether a record has begun and is not whole yet."""
        return self._state == "RUNNING"

    def let_fall(self) -> None:
        """Say that the mass may fall; on a virtual board it falls."""
        rig = self._rig
        if self._bench.plant is None:
            if not self._said:
                self._said = True
                self._file.note("prompt", READY)
                rig.say(READY)
            return
        if rig.file is None or rig.mass is None or rig.speed is None:
            return
        stop = fall(
            self._bench,
            rig.file,
            mass=rig.mass,
            speed=rig.speed,
            rope_stiffness=rig.rope_stiffness,
        )
        self._file.note("note", f"a virtual mass falls; computed: {stop.outcome.name}")

    def look(self, recorder: Recorder) -> None:
        """One look at the accelerometer, once a block; a whole record is fetched and kept."""
        if self._state == "IDLE":
            if self._wanted:
                self._arm()
            return
        found = capture_of(self._bench)
        self._state = found.state
        if found.state == "DONE":
            micros = found.trigger_us - recorder.now
            shot = replace(
                coming(self._bench, found),
                number=len(self._taken) + 1,
                boot=recorder.boot or 0,
                trigger_us=recorder.now + (micros + WRAP // 2) % WRAP - WRAP // 2,
            )
            self._fetch(shot)
            self._state = "IDLE"

    def _arm(self) -> None:
        if self._state == "IDLE":
            arm(self._bench)
            self._state = "WAITING"

    def _fetch(self, shot: Shot) -> None:
        """All samples of a record, on disk piece by piece."""
        self._file.add_shot(shot.row())
        self._taken.append(shot)
        while len(shot.counts) < shot.size:
            first = len(shot.counts)
            data = piece(self._bench, first, shot.size)
            self._file.add_shot_data(shot.number, first, data)
            counts = np.concatenate([shot.counts, np.frombuffer(data, "<i2")])
            shot = self._taken[-1] = replace(shot, counts=counts)
        said = f"shot {shot.number}: {shot.size} samples at {show(shot.rate, 'Hz')}"
        self._file.note("note", said, shot.trigger_us)

    def last(self, recorder: Recorder) -> None:
        """No drop is to come any more, and the outputs are off; what runs is still taken."""
        self._wanted = False
        if self.waiting:
            self.look(recorder)
        if self.waiting:
            self._bench.tell("ABOR")
            self._state = "IDLE"

    def taken(self, first_us: int | None) -> tuple[Taken, ...]:
        """What is in the file, by the time [s] from a moment of the board's clock on."""
        return tuple(
            Taken(
                shot=shot.number,
                time=(shot.trigger_us - (first_us or 0)) * 1e-6,
                samples=len(shot.counts),
                rate=shot.rate,
                whole=len(shot.counts) == shot.size,
            )
            for shot in self._taken
        )
