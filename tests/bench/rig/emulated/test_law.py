"""Check 18: the law on the board gives CPython's numbers, to the last bit, over 1,200 steps."""

from __future__ import annotations

import struct
import sys

import pytest

from bench.rig.boards import regulator
from bench.rig.emulated.emulator import Emulated, missing
from layerjam.bench.control import law

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]
STEPS = 1200
ROUND = """
import hashlib, struct, binascii, law
n = {n}
raw = binascii.unhexlify("{law}")
v = struct.unpack("<%dd" % (len(raw) // 8), raw)
s, state, vacuum, seed, h = (v[:15], v[15:]), law.fresh(), 0.0, 1, hashlib.sha256()
for i in range(n):
    seed = (seed * 1103515245 + 12345) % 2147483648
    target = 60000.0 if i % 400 < 300 else 0.0
    state, pump, vent, fault = law.step(s, state, vacuum + seed % 97 * 0.37, target)
    vacuum += pump * 0.0044 * (95000.0 - vacuum) - (0.08 if vent else 0.00004) * vacuum
    h.update(struct.pack("<24d", *state[0], *state[1], pump, vent))
print(binascii.hexlify(h.digest()).decode())
"""


def test_the_law_is_the_same_to_the_last_bit() -> None:
    first, second = regulator().pack()
    text = ROUND.format(
        n=STEPS, law=struct.pack(f"<{len(first) + len(second)}d", *first, *second).hex()
    )
    said: list[str] = []
    kept = sys.modules.get("law")
    sys.modules["law"] = law
    try:
        exec(text, {"print": said.append})
    finally:
        del sys.modules["law"]
        if kept is not None:
            sys.modules["law"] = kept
    board = Emulated()
    board.boot()
    board.say("SYST:MAIN")
    seen = board.connected
    assert board.run(1.0, lambda: board.connected > seen)
    board.run(0.3)
    assert said[0] in board.executed(text, 20.0)
