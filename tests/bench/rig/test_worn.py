"""A line on which one byte in a thousand is lost, doubled or changed."""

from __future__ import annotations

import contextlib
import sqlite3
import time
from pathlib import Path

import numpy as np
import pytest

from bench.rig.test_runs import PROCEDURE, ready
from bench.rig.worn import lay
from layerjam.bench.rig import frame
from layerjam.bench.rig.line import WAIT, Line, LineError


class Said:
    """A board that says what it is told to, one text a question."""

    def __init__(self, *answers: bytes) -> None:
        self.answers, self.asked, self.waiting = list(answers), 0, b""

    def read(self, wait: float) -> bytes:
        data, self.waiting = self.waiting, b""
        if not data:
            time.sleep(wait)
        return data

    def write(self, data: bytes) -> None:
        self.asked += 1
        self.waiting += self.answers.pop(0) if self.answers else b""

    def close(self) -> None: ...


WHOLE = frame.pack(1, 1, b"7" * 90)


@pytest.mark.parametrize(
    "spoilt",
    [
        WHOLE.replace(b"7\n", b"8\n"),
        WHOLE[1:],
        WHOLE[:40] + WHOLE[41:],
        WHOLE[:-1],
        WHOLE.replace(b"@1010", b"@1014"),
        b"\n",
    ],
)
def test_a_spoilt_answer_is_asked_for_again_at_once(spoilt: bytes) -> None:
    """Changed, without its beginning, without a byte, without its end, said to be longer."""
    said, begun = Said(spoilt, spoilt, WHOLE), time.monotonic()
    assert Line(said, "a board").ask(1, b"MEAS:VAC?") == b"7" * 90
    assert said.asked == 3 and time.monotonic() - begun < 0.6 * WAIT


def test_a_late_answer_to_another_question_is_passed_over() -> None:
    said = Said(frame.pack(1, 9, b"old") + frame.pack(2, 1, b"theirs") + WHOLE)
    assert Line(said, "a board").ask(1, b"MEAS:VAC?") == b"7" * 90 and said.asked == 1


def test_a_silent_board_is_asked_once_in_half_a_second() -> None:
    said, begun = Said(), time.monotonic()
    with pytest.raises(LineError, match="does not respond within 1 × 0.5 s"):
        Line(said, "a board").ask(1, b"MEAS:VAC?", tries=1)
    assert said.asked == 1 and time.monotonic() - begun >= WAIT


@pytest.mark.slow
def test_a_run_ends_well_and_holds_each_sample_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Check 24. What the file holds is what the sensor gave, sample by sample."""
    lines = lay(monkeypatch)
    given: list[float] = []
    with ready("sim:choi2018?speed=1") as bench:
        plant = bench.plant
        assert plant is not None
        answer, behind = plant.make_board_data, plant.asked

        def kept(asks: int = 1, count: int = 0) -> bytes:
            said = answer(asks, count)
            if plant.asked == behind + len(given) + 1:
                given.append(plant._last)
            return said

        monkeypatch.setattr(plant, "make_board_data", kept)
        made = bench.run(PROCEDURE, out=tmp_path / "a.ljrun")
    assert (made.outcome, made.gaps, made.fault) == ("FINISHED", 0, None)
    assert all(step.reached for step in made.steps)
    assert lines[0].spoilt > 50 and lines[0].passed > 500 * lines[0].spoilt
    with contextlib.closing(sqlite3.connect(made.file)) as base:
        rows = base.execute("SELECT seq, vacuum FROM samples ORDER BY seq").fetchall()
    seq, vacuum = np.array(rows).T
    assert np.array_equal(np.diff(seq), np.ones(len(seq) - 1)) and len(seq) == made.samples > 700
    mine = seq >= behind
    due = np.array(given, np.float32)[(seq[mine] - behind).astype(int)]
    assert mine.sum() > 600 and np.array_equal(vacuum[mine], due)
