"""The last ten seconds of samples, until somebody has them safe: a ring of packed records."""

import struct

LAYOUT = "<IIffHhBBBB"
NAMES = "seq,board_us,vacuum,target,raw,temperature,pump,flags,state,fault"
SIZE = struct.calcsize(LAYOUT)
"""Bytes of a record."""
ROOM = 1000
MOST = 200
"""Records in one answer at most."""


class Ring:
    """Records by their number `seq`; `kept` is the oldest that was not acknowledged."""

    def __init__(self, store=None) -> None:
        self.store = bytearray(ROOM * SIZE) if store is None else store
        self.next = 0
        self.kept = 0
        self.lost = 0
        self.recorder = -1
        """Session that acknowledges; without one, nothing counts as lost."""
        self.reader = -1
        """Session that fetched last."""
        self.fetched = 0
        """How often anybody fetched."""

    def put(self, *fields: object) -> bool:
        """Keep one record, its number put before the fields; True where an old one was lost."""
        struct.pack_into(LAYOUT, self.store, (self.next % ROOM) * SIZE, self.next, *fields)
        self.next += 1
        if self.next - self.kept <= ROOM:
            return False
        self.kept += 1
        if self.recorder < 0:
            return False
        self.lost += 1
        return True

    def fetch(self, count: int, session: int) -> bytes:
        """So many records not yet acknowledged, the oldest first, or as many as there are."""
        self.reader = session
        self.fetched += 1
        count = min(count, self.next - self.kept)
        at = self.kept % ROOM
        head = min(count, ROOM - at)
        held = memoryview(self.store)
        out = bytes(held[at * SIZE : (at + head) * SIZE])
        return out + bytes(held[: (count - head) * SIZE]) if head < count else out

    def acknowledge(self, seq: int, session: int) -> bool:
        """Give up all records up to and with `seq`; False where that is not one of those held."""
        if not self.kept <= seq < self.next:
            return False
        self.kept = seq + 1
        self.recorder = session
        return True

    def leave(self, session: int) -> None:
        """The session that acknowledged is gone: what it did not take is no loss."""
        if self.recorder == session:
            self.recorder = -1
        if self.reader == session:
            self.reader = -1

    def presses(self) -> bool:
        """Whether what a session fetches is about to be written over."""
        return self.reader >= 0 and self.next - self.kept > ROOM - MOST
