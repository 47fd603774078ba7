"""A virtual board on stdin and stdout, for socat; one byte in so many goes wrong, either way.

    python noisy_line.py SIM_ADDRESS BYTES COUNTS_FILE KIND...

KIND is changed, lost or doubled. Runs in the project's environment. The file holds
[bytes passed, bytes that went wrong] at the end.
"""

from __future__ import annotations

import json
import os
import random
import select
import sys
from pathlib import Path

from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.board import VirtualBoard


def main(address: str, one_in: int, counts: Path, kinds: list[str]) -> None:
    board, draw = VirtualBoard(address_of(address)), random.Random(24)
    incoming, outgoing = board.ends
    passed = spoilt = 0
    ways = {0: outgoing, incoming: 1}
    while ways:
        for end in select.select(list(ways), [], [])[0]:
            data = os.read(end, 4096)
            if not data:
                ways.clear()
                break
            out = bytearray()
            for byte in data:
                passed += 1
                if draw.random() * one_in >= 1.0:
                    out.append(byte)
                    continue
                spoilt += 1
                kind, changed = draw.choice(kinds), byte ^ (1 << draw.randrange(8))
                out += bytes({"changed": [changed], "lost": [], "doubled": [byte, byte]}[kind])
            os.write(ways[end], out)
            fresh = counts.with_suffix(".new")
            fresh.write_text(json.dumps([passed, spoilt]), encoding="utf-8")
            fresh.replace(counts)
    board.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4:])
