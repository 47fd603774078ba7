"""The board's loop: what it leaves to the collector, and what it sends."""

from __future__ import annotations

import hashlib
import json
import runpy
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import layerjam.bench.rig
from bench.rig.boards import Hal, Rig, firmware

BUILD = Path(layerjam.bench.rig.__file__).parent / "firmware" / "image" / "build.py"


@cache
def emptied() -> Any:
    """A port that has nothing to say: every test sends all it puts in."""
    return Rig().port


class Looped(Hal):
    """A board with a collector, whose line closes after some samples."""

    collects = True

    def __init__(self, samples: int, takes: int) -> None:
        super().__init__()
        self.last, self.takes = samples, takes
        self.collected_at: list[int] = []

    def collect(self) -> None:
        self.now += self.takes
        self.collected_at.append(self.wakes)

    def show_state(self, state: int, sync: int) -> None: ...

    def wait(self, due: int, reading: bool, sending: bool) -> bytes:
        if self.wakes == self.last:
            raise EOFError
        self.now = max(self.now, due)
        return b""


def test_garbage_is_collected_before_the_first_sample_and_every_half_second(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Else the collector came by itself, in the middle of the 33rd sample: 7 ms late."""
    for takes in (300, 9900):
        hal = Looped(120, takes)
        monkeypatch.setattr(firmware().main, "gc", hal)
        with pytest.raises(EOFError):
            firmware().main.run_loop(hal)
        assert hal.collected_at == [0, 50, 100]


@given(st.lists(st.one_of(st.binary(min_size=1, max_size=90), st.integers(0, 70)), max_size=30))
def test_what_is_said_goes_out_once_and_in_order(acts: list[bytes | int]) -> None:
    """However little the line takes at a time; a number is that little."""
    port = emptied()
    said = went = b""
    for act in [*acts, 10**6]:
        if isinstance(act, bytes):
            port.queue_bytes(act)
            said += act
        else:
            piece = bytes(port.unsent_bytes()[:act])
            went += piece
            port.drop_sent(len(piece))
        assert bytes(port.unsent_bytes()) == said[len(went) :] and said.startswith(went)
        assert bool(port.outbox) == (went != said)
    assert went == said


def test_a_line_that_takes_nothing_costs_no_copy() -> None:
    """The answer of 4.8 kB was copied a hundred times a second behind a host that does not read."""
    port = Rig().port
    port.queue_bytes(bytes(4800))
    held = port.outbox
    port.drop_sent(0)
    port.drop_sent(64)
    assert port.outbox is held and len(port.unsent_bytes()) == 4736
    assert port.is_full()
    port.drop_sent(700)
    assert not port.is_full()


def test_an_image_is_current_while_nothing_that_it_is_made_of_changes(tmp_path: Path) -> None:
    build: dict[str, Any] = runpy.run_path(str(BUILD))
    image, facts = tmp_path / "layerjam-pico.uf2", tmp_path / "layerjam-pico.json"
    assert not build["is_current"](tmp_path)
    image.write_bytes(b"image")
    said = {**build["source_hashes"](), "image_sha256": hashlib.sha256(b"image").hexdigest()}
    facts.write_text(json.dumps({**said, "seconds": 1.0}), encoding="utf-8")
    assert build["is_current"](tmp_path)
    for key in said:
        facts.write_text(json.dumps({**said, key: "another"}), encoding="utf-8")
        assert not build["is_current"](tmp_path), key
    facts.write_text(json.dumps(said), encoding="utf-8")
    image.write_bytes(b"another")
    assert not build["is_current"](tmp_path)
