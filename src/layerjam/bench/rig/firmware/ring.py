"""A ring of packed records: the last ten seconds of samples, kept until clients store them."""

import struct

LAYOUT = "<IIffHhBBBB"
NAMES = "seq,board_us,vacuum,target,raw,temperature,pump,flags,state,fault"
SIZE = struct.calcsize(LAYOUT)
"""Size of a record [bytes]."""
ROOM = 1000
BLOCK = 200
"""Largest number of records in one response."""


class Ring:
    """Records by their number `seq`, and the first unacknowledged record of each session."""

    def __init__(self, store=None, sessions: int = 16) -> None:
        self.store = bytearray(ROOM * SIZE) if store is None else store
        self.next = 0
        self.lost = 0
        """Number of records overwritten before an acknowledging session received them."""
        self.places = [-1] * sessions
        """First record that a session has not acknowledged; -1 before its first fetch."""
        self.recorders: list[int] = []
        """Sessions that acknowledge records; without any, nothing counts as lost."""
        self.begin = 0
        """First record that no session has acknowledged, where a new session begins."""
        self.slowest = 0
        """Position of the slowest recorder."""
        self.reader = -1
        """Session that last fetched records."""
        self.fetched = 0
        """Number of fetches by all sessions."""

    def store_record(self, *fields: object) -> bool:
        """Store one record by its number; return True if a recorder lost an old one."""
        struct.pack_into(LAYOUT, self.store, (self.next % ROOM) * SIZE, self.next, *fields)
        self.next += 1
        if not self.recorders or self.next - self.slowest <= ROOM:
            return False
        self.slowest += 1
        self.lost += 1
        return True

    def find_start(self, session: int) -> int:
        """Return the first stored record that a session has not acknowledged."""
        mine = self.places[session]
        return max(self.begin if mine < 0 else mine, self.next - ROOM)

    def fetch_records(self, count: int, session: int) -> bytes:
        """Return the oldest records that a session has not acknowledged, at most `count`."""
        self.reader = session
        self.fetched += 1
        first = self.places[session] = self.find_start(session)
        count = min(count, self.next - first)
        place = first % ROOM
        head = min(count, ROOM - place)
        records = memoryview(self.store)
        out = bytes(records[place * SIZE : (place + head) * SIZE])
        return out + bytes(records[: (count - head) * SIZE]) if head < count else out

    def acknowledge(self, seq: int, session: int) -> bool:
        """Move a session past the record `seq`; return False if the session has no such record."""
        if not self.find_start(session) <= seq < self.next:
            return False
        self.places[session] = seq + 1
        self.begin = max(self.begin, seq + 1)
        if session not in self.recorders:
            self.recorders.append(session)
        self.find_slowest()
        return True

    def find_slowest(self) -> None:
        """Find the slowest recorder."""
        self.slowest = min([self.find_start(session) for session in self.recorders] or [0])

    def end_session(self, session: int) -> None:
        """Remove a session; records that it did not fetch do not count as lost."""
        self.places[session] = -1
        if session in self.recorders:
            self.recorders.remove(session)
            self.find_slowest()
        if self.reader == session:
            self.reader = -1

    def is_nearly_full(self) -> bool:
        """Return whether the next records for the last reader will soon be overwritten."""
        return self.reader >= 0 and self.next - self.find_start(self.reader) > ROOM - BLOCK
