"""The board's end of the line: plain SCPI for whoever types, frames for gateway and driver."""

import frame
import scpi

from commands import tree

LONGEST = 1024
"""Bytes of a line at most."""
PLAIN = 0
"""Session of those who type without frames."""
QUIET = 200
"""Samples after a frame in which a plain line is a torn frame's rest, not a command."""
FULL = 4096
"""Bytes waiting to be sent at which nothing more is read."""
LATER = 16
"""Lines that may follow one that waits."""
STOPS = (b"OUTP OFF", b"OUTP 0", b"OUTPUT OFF", b"ABOR", b"ABORT")
"""Lines that are heard even then."""
CORRUPT, CORRUPT_WINDOW = 10, 1000
"""Number of bad frames, and of samples, that make an error."""


class Port:
    """Lines in, answers out; nothing is executed twice."""

    def __init__(self, bench) -> None:
        self.bench = bench
        self.root = tree(bench)
        self.inbox = bytearray()
        self.outbox = b""
        # number of bytes already sent; cutting them off after each write would copy the others
        self.taken = 0
        self.skipping = False
        self.done: dict[int, tuple[int, bytes, bytes]] = {}
        self.framed = -QUIET
        self.bad: list[int] = []
        # plain lines behind one that waits
        self.later: list[bytes] = []

    def full(self) -> bool:
        """Whether so much waits to be sent that nothing more should be read."""
        return len(self.outbox) - self.taken >= FULL

    def waiting(self) -> memoryview:
        """Return the bytes still to be sent."""
        return memoryview(self.outbox)[self.taken :]

    def took(self, count: int) -> None:
        """So many bytes of that are sent."""
        self.taken += count
        if self.taken == len(self.outbox):
            self.outbox, self.taken = b"", 0

    def put(self, data: bytes) -> None:
        """Something more to be sent."""
        if self.taken:
            self.outbox, self.taken = self.outbox[self.taken :], 0
        self.outbox += data

    def feed(self, data: bytes) -> None:
        """Take bytes from the line and answer every line that is whole."""
        inbox = self.inbox
        inbox.extend(data)
        begin = 0
        while True:
            end = inbox.find(b"\n", begin)
            if end < 0:
                break
            line = bytes(inbox[begin:end])
            begin = end + 1
            if self.skipping:
                self.skipping = False
                continue
            self.line(line)
        if begin:
            self.inbox = inbox = bytearray(inbox[begin:])
        if len(inbox) > LONGEST + frame.HEAD + 1:
            if not self.skipping:
                self.too_long(inbox[0] == 64)
            self.skipping = True
            self.inbox = bytearray()

    def line(self, line: bytes) -> None:
        """One line without its LF."""
        if line[:1] == b"@":
            parts = frame.unpack(line + b"\n")
            if parts is None:
                self.spoilt()
            else:
                self.framed = self.bench.count
                self.frame(*parts)
        elif self.bench.count - self.framed < QUIET:
            if line:  # a host that asks again ends what may be torn: mostly there is nothing
                self.spoilt()
        elif len(line) > LONGEST:
            self.too_long(False)
        else:
            self.plain(line[:-1] if line[-1:] == b"\r" else line)

    def plain(self, line: bytes) -> None:
        """Answer a plain line; behind one that waits it waits too, unless it stops something."""
        waits = self.bench.sessions[PLAIN].held is not None and line != frame.PENDING
        if waits and line.strip().upper() not in STOPS:
            if len(self.later) < LATER:
                self.later.append(line)
            else:
                self.bench.sessions[PLAIN].push(-363, "%d lines wait for *OPC? or *WAI" % LATER)
            return
        answer = self.execute(line, PLAIN)
        if answer and answer != frame.PENDING:
            self.put(answer + b"\n")

    def resume(self) -> None:
        """Go on with a plain line that waited, once nothing is pending, and those behind it."""
        session = self.bench.sessions[PLAIN]
        if session.held is not None and not self.bench.capture.busy():
            self.plain(frame.PENDING)
            while self.later and session.held is None:
                self.plain(self.later.pop(0))

    def frame(self, number: int, count: int, payload: bytes) -> None:
        """One frame: what was executed last is answered from store."""
        before = self.done.get(number)
        if before is not None and before[0] == count and before[1] == payload:
            self.put(before[2])
            return
        if payload:
            answer = self.execute(payload, number)
        else:
            answer = b""
            self.bench.leave(number)
        response = frame.pack(number, count, answer)
        self.done[number] = (count, payload, response)
        self.put(response)

    def execute(self, line: bytes, number: int) -> bytes:
        """The answer of one line, its error in the session's queue; PENDING if it waits."""
        session, pending = self.bench.sessions[number], None
        if line == frame.PENDING:
            pending, session.held = session.held, None
        if len(line) > LONGEST:
            session.push(-363, "a line has at most %d bytes" % LONGEST)
            return b""
        answer, error, commands = scpi.run(self.root, line, self.bench, session, pending)
        if error is not None:
            session.push(error.code, error.more)
        elif commands or session.held is None:  # asking again keeps nothing running
            self.bench.renew(session, commands)
        return answer if session.held is None else frame.PENDING

    def too_long(self, framed: bool) -> None:
        """A line without end is thrown away up to its LF."""
        if framed:
            self.spoilt()
        else:
            self.bench.sessions[PLAIN].push(-363, "a line has at most %d bytes" % LONGEST)

    def spoilt(self) -> None:
        """A frame that is not intact is not answered; ten of them in ten seconds are said."""
        sample = self.bench.count
        self.bad = self.bad[1 - CORRUPT :] + [sample]
        if len(self.bad) == CORRUPT and sample - self.bad[0] <= CORRUPT_WINDOW:
            self.bench.tell(126)
            self.bad = []
