"""The last ten seconds of samples, until somebody has them safe: a ring of packed records."""

import struct

LAYOUT = "<IIffHhBBBB"
NAMES = "seq,board_us,vacuum,target,raw,temperature,pump,flags,state,fault"
SIZE = struct.calcsize(LAYOUT)
"""Bytes of a record."""
ROOM = 1000
BLOCK = 200
"""Records in one answer at most."""


class Ring:
    """Records by their number `seq`, and for each session the first not acknowledged."""

    def __init__(self, store=None, sessions: int = 16) -> None:
        self.store = bytearray(ROOM * SIZE) if store is None else store
        self.next = 0
        self.lost = 0
        """Records overwritten before a session that acknowledges had them."""
        self.places = [-1] * sessions
        """First record that a session has not acknowledged; -1 before it fetches."""
        self.recorders: list[int] = []
        """Sessions that acknowledge; without one, nothing counts as lost."""
        self.begin = 0
        """First record that no session has acknowledged: where a new one begins."""
        self.slowest = 0
        """Least place of the recorders."""
        self.reader = -1
        """Session that fetched last."""
        self.fetched = 0
        """Number of fetches of all sessions."""

    def put(self, *fields: object) -> bool:
        """Keep one record, its number put before the fields; True if a recorder lost an old one."""
        struct.pack_into(LAYOUT, self.store, (self.next % ROOM) * SIZE, self.next, *fields)
        self.next += 1
        if not self.recorders or self.next - self.slowest <= ROOM:
            return False
        self.slowest += 1
        self.lost += 1
        return True

    def place(self, session: int) -> int:
        """First record held that a session has not acknowledged."""
        mine = self.places[session]
        return max(self.begin if mine < 0 else mine, self.next - ROOM)

    def fetch(self, count: int, session: int) -> bytes:
        """The oldest records that a session has not acknowledged, `count` of them at most."""
        self.reader = session
        self.fetched += 1
        first = self.places[session] = self.place(session)
        count = min(count, self.next - first)
        place = first % ROOM
        head = min(count, ROOM - place)
        records = memoryview(self.store)
        out = bytes(records[place * SIZE : (place + head) * SIZE])
        return out + bytes(records[: (count - head) * SIZE]) if head < count else out

    def acknowledge(self, seq: int, session: int) -> bool:
        """Move a session past the record `seq`; False if that is not one of those it has left."""
        if not self.place(session) <= seq < self.next:
            return False
        self.places[session] = seq + 1
        self.begin = max(self.begin, seq + 1)
        if session not in self.recorders:
            self.recorders.append(session)
        self.pace()
        return True

    def pace(self) -> None:
        """Find the slowest recorder."""
        self.slowest = min([self.place(session) for session in self.recorders] or [0])

    def leave(self, session: int) -> None:
        """Forget a session: records that it did not take are not lost."""
        self.places[session] = -1
        if session in self.recorders:
            self.recorders.remove(session)
            self.pace()
        if self.reader == session:
            self.reader = -1

    def presses(self) -> bool:
        """Whether the records that the last reader is to fetch will soon be overwritten."""
        return self.reader >= 0 and self.next - self.place(self.reader) > ROOM - BLOCK
