"""Samples of the board: every client has a place of its own in the ring."""

from __future__ import annotations

import random
import struct

from bench.rig.boards import Rig
from layerjam.bench.rig.telemetry import parse_records


def test_every_client_reads_all_samples_without_the_lock() -> None:
    """Two recorders and one that only looks: each has every sample once, none takes another's."""
    rig = Rig()
    rig.say("SYST:LOCK:REQ?", 1)
    held: dict[int, list[int]] = {2: [], 3: []}
    draw = random.Random(33)
    for session in held:  # both begin at the same place
        rig.say("FETC:STR? 1", session)
    for _ in range(60):
        rig.run(draw.uniform(0.01, 0.9))
        assert rig.say("FETC:STR? 3", 4)
        for session in held:
            if draw.random() < 0.6:
                block = rig.port.execute(b"FETC:STR? 200", session)
                held[session] += parse_records(block)["seq"].tolist()
                rig.say(f"STR:ACK {held[session][-1]}", session)
                assert rig.error(session) == 0
    for seqs in held.values():
        assert len(seqs) > 1000 and seqs == list(range(seqs[0], seqs[0] + len(seqs)))
    assert rig.say("STR:LOST?") == "0"


def test_the_ring_against_a_list() -> None:
    """Fetched and acknowledged at random against a plain list: nothing missing, nothing double."""
    rig, draw = Rig(), random.Random(5)
    rig.hal.steps = 1
    kept: list[int] = []
    for _ in range(150):
        rig.run(draw.choice([0.01, 0.1, 0.5, 1.0]) if draw.random() < 0.9 else 12.0)
        said = rig.port.execute(b"FETC:STR? %d" % draw.randrange(1, 201), 1)
        begin = 2 + int(said[1:2])
        data, size = said[begin:], rig.code.ring.SIZE
        assert int(said[2:begin]) == len(data)
        rows = [struct.unpack_from("<IIffHhBBBB", data, at) for at in range(0, len(data), size)]
        seqs = [row[0] for row in rows]
        assert seqs == list(range(seqs[0], seqs[0] + len(seqs)))
        if draw.random() < 0.8:
            rig.say(f"STR:ACK {seqs[-1]}", 1)
            kept += seqs
    assert len(kept) == len(set(kept)) and kept == sorted(kept)
    missing = kept[-1] - kept[0] + 1 - len(kept)
    assert missing == int(rig.say("STR:LOST?")) > 0
    assert int(rig.say("STAT:QUES:COND?")) & 2048
    rig.say(f"STR:ACK {kept[-1]}", 1)
    assert rig.error(1) in (127, -222) and rig.error(1) in (-222, 0)
