"""A line on which bytes are lost, doubled and changed, both ways."""

from __future__ import annotations

import random
from typing import Any

import pytest

from layerjam.bench.rig.line import ChildEnds


class Worn(ChildEnds):
    """One byte in `one_in` goes wrong; `spoilt` counts them, `passed` all."""

    one_in = 1000
    kinds = ("changed", "lost", "doubled")

    def __init__(self, *parts: Any) -> None:
        super().__init__(*parts)
        self.draw = random.Random(24)
        self.passed = self.spoilt = 0

    def read(self, wait: float) -> bytes:
        return self.worn(super().read(wait))

    def write(self, data: bytes) -> None:
        super().write(self.worn(data))

    def worn(self, data: bytes) -> bytes:
        out = bytearray()
        for byte in data:
            self.passed += 1
            if self.draw.random() * self.one_in >= 1.0:
                out.append(byte)
                continue
            self.spoilt += 1
            kind = self.draw.choice(self.kinds)
            changed = byte ^ (1 << self.draw.randrange(8))
            out += bytes({"changed": [changed], "lost": [], "doubled": [byte, byte]}[kind])
        return bytes(out)


def lay(monkeypatch: pytest.MonkeyPatch) -> list[Worn]:
    """Every virtual board is behind such a line from now on; the lines made."""
    made: list[Worn] = []

    def worn(*parts: Any) -> Worn:
        made.append(Worn(*parts))
        return made[-1]

    monkeypatch.setattr("layerjam.bench.rig.child.ChildEnds", worn)
    return made
