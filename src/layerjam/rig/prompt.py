"""MicroPython's prompt on a serial line, in its raw mode: programs and files to a board.

Ctrl-A begins the raw mode, Ctrl-D runs what was sent; "OK", the output, Ctrl-D, the traceback and
Ctrl-D come back (MicroPython's documentation, "The MicroPython Interactive Interpreter Mode").
"""

from __future__ import annotations

import time

from layerjam.rig.line import Ends, LineError

RAW, RUN, STOP, LEAVE = b"\x01", b"\x04", b"\x03", b"\x02"
READY = b"raw REPL; CTRL-B to exit\r\n>"
CHUNK = 128
"""Bytes sent at once; a board's own buffer takes 512."""
WAIT = 10.0
PIECE = 512
"""Bytes of a file in one program."""


class Prompt:
    """A board at its prompt; raises LineError where none answers or a program fails."""

    def __init__(self, ends: Ends, name: str) -> None:
        self._ends, self._name, self._buffer = ends, name, b""
        ends.write(b"\r" + STOP + STOP)
        ends.write(b"\r" + RAW)
        self._until(READY, 2.0)

    def _until(self, end: bytes, wait: float) -> bytes:
        """What came up to and without `end`."""
        last = time.monotonic() + wait
        while end not in self._buffer:
            left = last - time.monotonic()
            if left <= 0:
                raise LineError(
                    f"{self._name}: neither the firmware nor MicroPython's prompt answers, but "
                    f"{self._buffer[-60:]!r}"
                )
            self._buffer += self._ends.read(left)
        got, _, self._buffer = self._buffer.partition(end)
        return got

    def send(self, program: str) -> None:
        """Start a program that does not come back."""
        data = program.encode("utf-8")
        for at in range(0, len(data), CHUNK):
            self._ends.write(data[at : at + CHUNK])
        self._ends.write(RUN)

    def run(self, program: str) -> str:
        """What a program prints."""
        self.send(program)
        self._until(b"OK", WAIT)
        said = self._until(RUN, WAIT)
        wrong = self._until(RUN + b">", WAIT)
        if wrong:
            last = wrong.decode("utf-8", "replace").strip().splitlines()[-1]
            raise LineError(f"{self._name}: the board says {last[:200]}")
        return said.decode("utf-8", "replace")

    def put(self, name: str, data: bytes) -> None:
        """Write a file and read it back; LineError where the board does not hold what was sent."""
        self.run(f"f=open({name!r},'wb')")
        for at in range(0, len(data), PIECE):
            self.run(f"f.write({data[at : at + PIECE]!r})")
        self.run("f.close()")
        held = self.run(
            f"import binascii\nwith open({name!r},'rb') as f:\n"
            f" while True:\n  b=f.read({PIECE})\n"
            "  if not b: break\n  print(binascii.hexlify(b).decode())\n"
        )
        if bytes.fromhex(held) != data:
            raise LineError(f"{self._name}: {name} on the board is not what was sent")
