"""Samples of the board: every client has a place of its own in the ring."""

from __future__ import annotations

import random

from layerjam.rig.telemetry import records
from rig.boards import Rig


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
                held[session] += records(block)["seq"].tolist()
                rig.say(f"STR:ACK {held[session][-1]}", session)
                assert rig.error(session) == 0
    for seqs in held.values():
        assert len(seqs) > 1000 and seqs == list(range(seqs[0], seqs[0] + len(seqs)))
    assert rig.say("STR:LOST?") == "0"
