"""The record by DMA on a converter and a DMA that are a few lines of the test."""

from __future__ import annotations

import ctypes
import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.rig.test_image import Machine, hal, made_chip

ROOM = 16384
SENSOR = {"sensor_range": 1e5, "sensor_zero": 0.1, "sensor_full": 0.9}


class Registers(dict[int, int]):
    """The converter is always ready and its queue empty; `spilt` once it ran over."""

    spilt = False

    def __getitem__(self, at: int) -> int:
        if at == 0x4004C008:
            return 1 << 8 | (1 << 11 if self.spilt else 0)
        return self.get(at, 0) | (1 << 8 if at == 0x4004C000 else 0)


class Dma:
    """Channels of DMA with real addresses, and the converter that feeds them."""

    def __init__(self) -> None:
        self.channels: list[Any] = []
        self.running: Any = None
        self.input = -1
        outer = self

        class Channel(types.SimpleNamespace):
            def __init__(self) -> None:
                super().__init__(channel=3 + len(outer.channels), open=True)
                outer.channels.append(self)

            def pack_ctrl(self, **said: int) -> dict[str, int]:
                return said

            def config(self, *, read: int, write: int, count: int, ctrl: dict[str, int]) -> None:
                assert (read, ctrl["size"], ctrl["treq_sel"]) == (0x4004C00C, 1, 36)
                assert (ctrl["inc_read"], ctrl["inc_write"], ctrl["ring_sel"]) == (0, 1, 1)
                assert write % (1 << ctrl["ring_size"]) == 0
                self.write, self.count, self.left, self.ctrl = write, count, count, ctrl

            def active(self, on: int) -> None:
                outer.running = self if on else None

            def close(self) -> None:
                self.open = False

        self.DMA = Channel

    def convert(self, registers: Registers, counts: dict[int, int]) -> int:
        """One conversion of the next channel of the turn; which it was."""
        control = registers[0x4004C000]
        assert control & 9 == 9
        turns = [n for n in range(5) if control >> 16 >> n & 1]
        if self.input < 0:
            self.input = control >> 12 & 7
        was = self.input
        self.input = turns[(turns.index(was) + 1) % len(turns)]
        now = self.running
        ctypes.memmove(now.write, counts[was].to_bytes(2, "little"), 2)
        mask = (1 << now.ctrl["ring_size"]) - 1
        now.write = now.write & ~mask | (now.write + 2) & mask
        now.left -= 1
        if not now.left:
            (self.running,) = [c for c in self.channels if c.channel == now.ctrl["chain_to"]]
            self.running.left = self.running.count
        return was


@pytest.fixture(params=[False, True], ids=["supply", "supply and sensor"])
def chip(
    request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Machine:
    machine = made_chip(monkeypatch, tmp_path)
    if request.param:
        (tmp_path / "wired.json").write_text(json.dumps(SENSOR), encoding="utf-8")
    space = ctypes.create_string_buffer(1 << 16)
    begin = -(-ctypes.addressof(space) // (1 << 15)) * (1 << 15)

    class Piece:
        def __init__(self, at: int, size: int) -> None:
            self.at, self.size = at, size

        def __getitem__(self, part: slice) -> bytearray:
            first, last, _ = part.indices(self.size)
            return bytearray(ctypes.string_at(self.at + first, last - first))

    outside = types.SimpleNamespace(
        reserved_address=lambda name: begin if name == "FAST" else 0,
        map_memory=Piece,
        space=space,
    )
    machine.mem32 = Registers()
    machine.rp2 = Dma()
    address = types.SimpleNamespace(addressof=lambda made: made.buffer_info()[0])
    monkeypatch.setattr(sys.modules["converter"], "outside", outside)
    monkeypatch.setitem(sys.modules, "rp2", machine.rp2)
    monkeypatch.setitem(sys.modules, "uctypes", address)
    return machine


def test_the_record_is_the_accelerometers_and_the_rest_is_read_beside_it(chip: Machine) -> None:
    chip.counts = 50000
    made = hal()
    others = [2, 0] if made.other else [2]
    assert {27, 28} <= chip.analogue
    made.start_capture(8000)
    turn = 1 + len(others)
    assert made.capture_scale()[3] == pytest.approx(8000, rel=1e-5)
    assert 48e6 / (1 + chip.mem32.get(0x4004C010) / 256) == pytest.approx(8000 * turn, rel=1e-5)
    # what was there before holds until the first turns are through
    assert made.has_supply() and made.volts.read_mean(1) == pytest.approx(50000, abs=16)
    draw = np.random.default_rng(3)
    given: list[int] = []
    total = 0
    for looks in range(13):
        for _ in range(1400 * turn):
            counts = {1: int(draw.integers(4096)), 2: 2000 + looks, 0: 1000 + looks}
            if chip.rp2.convert(chip.mem32, counts) == 1:
                given.append(counts[1])
        total += 1400
        assert made.capture_count() == total
        first, last = (total - 100) % ROOM, total % ROOM
        if first < last:
            assert list(made.capture_part(first, last)) == given[-100:]
        assert made.volts.read_mean(1) == pytest.approx((2000 + looks) * 65535 / 4095)
        if made.other:
            assert made.other.read()[1] == int((1000 + looks) * 65535 / 4095)
    assert total > ROOM
    made.stop_capture()
    assert not any(channel.open for channel in chip.rp2.channels)
    assert chip.mem32.get(0x4004C000) == 1 and made.volts.read_mean(1) == 50000
    assert made.capture_count() == total


def test_numbers_that_were_lost_end_the_record(chip: Machine) -> None:
    made = hal()
    made.start_capture(500)
    assert made.capture_scale()[3] == pytest.approx(500, rel=1e-5)
    chip.mem32.spilt = True
    assert made.capture_count() == -1


def test_the_contact_closes_to_the_ground(chip: Machine) -> None:
    made = hal()
    chip.pins[21] = 1
    assert not made.is_contact_closed()
    chip.pins[21] = 0
    assert made.is_contact_closed()


def test_another_image_has_no_room_for_a_record(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    made_chip(monkeypatch, tmp_path)
    assert not hasattr(hal(), "start_capture")
