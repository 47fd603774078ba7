"""The board's end of the line: plain SCPI for typed lines, frames for gateway and driver."""

import frame
import scpi
from commands import build_tree

LONGEST = 1024
"""Largest number of bytes in a line."""
PLAIN = 0
"""Session to which lines without frames belong."""
QUIET = 200
"""Number of samples after a frame during which a plain line counts as part of a broken frame."""
FULL = 4096
"""Number of unsent bytes at which the board stops reading."""
LATER = 16
"""Largest number of lines queued behind a waiting one."""
STOPS = (b"OUTP OFF", b"OUTP 0", b"OUTPUT OFF", b"ABOR", b"ABORT")
"""Lines that are executed even while an earlier line waits."""
CORRUPT, CORRUPT_WINDOW = 10, 1000
"""Number of damaged frames, within a window of samples, that causes an error."""


class Port:
    """The board's end of the line: reads lines, sends responses, executes a frame only once."""

    def __init__(self, bench) -> None:
        self.bench = bench
        self.root = build_tree(bench)
        self.inbox = bytearray()
        self.outbox = b""
        # number of bytes already sent; removing them after each write would mean copying the rest
        self.taken = 0
        self.skipping = False
        self.done: dict[int, tuple[int, bytes, bytes]] = {}
        self.framed = -QUIET
        self.bad: list[int] = []
        # plain lines received after one that waits
        self.later: list[bytes] = []

    def is_full(self) -> bool:
        """Return whether reading should stop, because too many bytes are unsent."""
        return len(self.outbox) - self.taken >= FULL

    def unsent_bytes(self) -> memoryview:
        """Return the bytes still to be sent."""
        return memoryview(self.outbox)[self.taken :]

    def drop_sent(self, count: int) -> None:
        """Record that `count` of these bytes have been sent."""
        self.taken += count
        if self.taken == len(self.outbox):
            self.outbox, self.taken = b"", 0

    def queue_bytes(self, data: bytes) -> None:
        """Queue data for sending."""
        if self.taken:
            self.outbox, self.taken = self.outbox[self.taken :], 0
        self.outbox += data

    def process_bytes(self, data: bytes) -> None:
        """Process bytes from the line, and respond to every complete line."""
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
            self.handle_line(line)
        if begin:
            self.inbox = inbox = bytearray(inbox[begin:])
        if len(inbox) > LONGEST + frame.HEAD + 1:
            if not self.skipping:
                self.reject_long_line(inbox[0] == 64)
            self.skipping = True
            self.inbox = bytearray()

    def handle_line(self, line: bytes) -> None:
        """Process one line without its LF."""
        if line[:1] == b"@":
            parts = frame.unpack(line + b"\n")
            if parts is None:
                self.count_spoilt_frame()
            else:
                self.framed = self.bench.count
                self.answer_frame(*parts)
        elif self.bench.count - self.framed < QUIET:
            if line:  # usually empty: a host that repeats a frame first ends any broken one
                self.count_spoilt_frame()
        elif len(line) > LONGEST:
            self.reject_long_line(False)
        else:
            self.answer_plain_line(line[:-1] if line[-1:] == b"\r" else line)

    def answer_plain_line(self, line: bytes) -> None:
        """Execute a plain line; if an earlier line waits, queue it unless it is a stop command."""
        waits = self.bench.sessions[PLAIN].held is not None and line != frame.PENDING
        if waits and line.strip().upper() not in STOPS:
            if len(self.later) < LATER:
                self.later.append(line)
            else:
                self.bench.sessions[PLAIN].push(-363, "%d lines wait for *OPC? or *WAI" % LATER)
            return
        answer = self.execute(line, PLAIN)
        if answer and answer != frame.PENDING:
            self.queue_bytes(answer + b"\n")

    def resume(self) -> None:
        """Resume a waiting plain line once no capture is pending, then execute the queued lines."""
        session = self.bench.sessions[PLAIN]
        if session.held is not None and not self.bench.capture.is_busy():
            self.answer_plain_line(frame.PENDING)
            while self.later and session.held is None:
                self.answer_plain_line(self.later.pop(0))

    def answer_frame(self, number: int, count: int, payload: bytes) -> None:
        """Process one frame; if it is a repetition, send the stored response again."""
        before = self.done.get(number)
        if before is not None and before[0] == count and before[1] == payload:
            self.queue_bytes(before[2])
            return
        if payload:
            answer = self.execute(payload, number)
        else:
            answer = b""
            self.bench.end_session(number)
        response = frame.pack(number, count, answer)
        self.done[number] = (count, payload, response)
        self.queue_bytes(response)

    def execute(self, line: bytes, number: int) -> bytes:
        """Return the response to one line, or PENDING; an error is added to the session's queue."""
        session, pending = self.bench.sessions[number], None
        if line == frame.PENDING:
            pending, session.held = session.held, None
        if len(line) > LONGEST:
            session.push(-363, "a line may have at most %d bytes" % LONGEST)
            return b""
        answer, error, commands = scpi.run_line(self.root, line, self.bench, session, pending)
        if error is not None:
            session.push(error.code, error.more)
        elif commands or session.held is None:  # a repeated query does not renew the lease
            self.bench.renew_lease(session, commands)
        return answer if session.held is None else frame.PENDING

    def reject_long_line(self, framed: bool) -> None:
        """Discard an overlong line up to its LF."""
        if framed:
            self.count_spoilt_frame()
        else:
            self.bench.sessions[PLAIN].push(-363, "a line may have at most %d bytes" % LONGEST)

    def count_spoilt_frame(self) -> None:
        """Ignore a damaged frame; report an error after ten of them within ten seconds."""
        sample = self.bench.count
        self.bad = self.bad[1 - CORRUPT :] + [sample]
        if len(self.bad) == CORRUPT and sample - self.bad[0] <= CORRUPT_WINDOW:
            self.bench.report_event(126)
            self.bad = []
