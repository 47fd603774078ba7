"""A virtual board on stdin and stdout, for socat; one byte in so many is another one, either way.

    python noisy_line.py SIM_ADDRESS BYTES COUNTS_FILE

Runs in the project's environment. The file holds [bytes passed, bytes changed] at the end.
"""

from __future__ import annotations

import json
import os
import random
import select
import sys
from pathlib import Path

from layerjam.rig.address import address_of
from layerjam.rig.board import VirtualBoard


def main(address: str, one_in: int, counts: Path) -> None:
    board, draw = VirtualBoard(address_of(address)), random.Random(24)
    incoming, outgoing = board.ends
    passed = changed = 0
    ways = {0: outgoing, incoming: 1}
    while ways:
        for end in select.select(list(ways), [], [])[0]:
            data = bytearray(os.read(end, 4096))
            if not data:
                ways.clear()
                break
            for at in range(len(data)):
                passed += 1
                if draw.random() * one_in < 1.0:
                    data[at] ^= 1 << draw.randrange(8)
                    changed += 1
            os.write(ways[end], data)
            fresh = counts.with_suffix(".new")
            fresh.write_text(json.dumps([passed, changed]), encoding="utf-8")
            fresh.replace(counts)
    board.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]))
