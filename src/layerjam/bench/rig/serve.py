"""The gateway: shares one board's line among many clients, over TCP and as a serial port.

Each client that may send commands has its own session on the board. All others share one session,
which accepts only `OUTP OFF`, `ABOR`, `*IDN?`, `*OPC?`, `*OPT?` and `SYST:ERR?`. Lines are plain
SCPI. The gateway does not renew the board's lease for a client that is silent.
"""

import asyncio
import contextlib
import ipaddress
import os
import signal
import socket
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from layerjam.bench.rig.address import Address
from layerjam.bench.rig.board import connect
from layerjam.bench.rig.frame import PENDING
from layerjam.bench.rig.line import Line, LineError
from layerjam.bench.rig.link import POLL
from layerjam.bench.rig.token import DELAY, STOP, TRIES, Door, is_message, make_token
from layerjam.core.errors import FileError, QuantityError

PORT = 5025
"""Usual port of instruments with a raw SCPI socket."""
SESSIONS = 14
"""Largest number of clients that may command at the same time."""
GUEST = 15
"""Session on the board shared by all clients that may not command."""
GUESTS = 64
"""Largest number of clients that share it; one more disconnects the oldest."""
WAITING = 1024
"""Largest number of lines queued behind a waiting one; a client that sends more is disconnected."""
LONGEST = 1024
"""Longest line [bytes]; the board rejects a longer one with error -363."""
ENDLESS = 65536
"""Number of bytes without an LF after which a client is disconnected."""
IDLE = 3600.0
"""Silence after which a client is disconnected [s]."""


@dataclass(frozen=True)
class Listening:
    """Address of a gateway."""

    host: str
    port: int
    address: str
    identity: str
    pid: int
    pty: str | None

    @property
    def visa_resource(self) -> str:
        """Return PyVISA code that opens the gateway; without the terminations, queries time out."""
        # a gateway that listens on all addresses can be reached by this machine's name
        host = socket.gethostname() if self.host in ("0.0.0.0", "::", "") else self.host
        return (
            f'rm.open_resource("TCPIP::{host}::{self.port}::SOCKET", '
            r'read_termination="\n", write_termination="\n")'
        )


class Splitter:
    """Splitter of bytes into lines, which cuts off overlong lines."""

    def __init__(self) -> None:
        self._rest = b""
        self._skipped = 0

    def split_lines(self, data: bytes) -> list[bytes]:
        """Return the complete, non-empty lines, without LF or CR LF."""
        *complete, remainder = (self._rest + data).split(b"\n")
        lines = []
        for line in complete:
            if self._skipped:
                self._skipped = 0
                continue
            if line.removesuffix(b"\r"):
                lines.append(line.removesuffix(b"\r")[: LONGEST + 1])
        if self._skipped:
            self._skipped += len(remainder)
            remainder = b""
        elif len(remainder) > LONGEST + 1:
            lines.append(remainder[: LONGEST + 1])
            self._skipped, remainder = len(remainder), b""
        self._rest = remainder
        return lines

    @property
    def is_overlong(self) -> bool:
        """Whether a line without an LF is far too long."""
        return self._skipped > ENDLESS


@dataclass(eq=False)
class Client:
    """One connection, its permission, and its session on the board."""

    door: Door
    writer: asyncio.StreamWriter
    session: int = GUEST


class Gateway:
    """Connects clients to a board's line."""

    def __init__(self, line: Line, token: str = "") -> None:
        self.line = line
        self._token = token
        self._free = list(range(SESSIONS, 0, -1))
        self._guests: dict[Client, None] = {}
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="line")
        self._down = asyncio.get_running_loop().create_future()
        self._tasks: set[asyncio.Task[None]] = set()

    async def ask(self, session: int, text: bytes) -> bytes:
        """Return the board's response; if the line is down, stop the gateway."""
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._thread, self.line.ask, session, text)
        except LineError as error:
            if not self._down.done():
                self._down.set_exception(error)
            raise

    async def execute(
        self,
        session: int,
        line: bytes,
        later: list[bytes],
        more_lines: Callable[[int], Awaitable[list[bytes]]],
    ) -> bytes:
        """Return the board's response; if the line waits for a capture to end, wait too.

        Meanwhile, the client's new lines are appended to `later`, except stop commands, which are
        executed at once. `more_lines` returns new lines, given the number in `later`.
        """
        answer = await self.ask(session, line)
        while answer == PENDING:
            for new in await more_lines(len(later)):
                if STOP.fullmatch(new):
                    await self.ask(session, new)
                else:
                    later.append(new)
            answer = await self.ask(session, PENDING)
        return answer

    async def watch_line(self) -> None:
        """Wait until the board's line is down, then raise LineError."""
        await asyncio.shield(self._down)

    async def serve_guest(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection until it ends."""
        task = asyncio.current_task()
        if task is not None:
            self._tasks.add(task)
        client = Client(Door(self._token), writer)
        self._guests[client] = None
        if len(self._guests) > GUESTS:
            next(iter(self._guests)).writer.close()
        try:
            await self._serve_lines(client, reader)
        except (ConnectionError, LineError, TimeoutError, asyncio.CancelledError):
            pass  # the client or the board has disconnected, or the gateway is stopping
        finally:
            if task is not None:
                self._tasks.discard(task)
            self._guests.pop(client, None)
            writer.close()
            await self._end_session(client.session)

    async def _end_session(self, session: int) -> None:
        """End a client's session with its lock, lease, registers and queue."""
        if session != GUEST:
            with contextlib.suppress(LineError):
                await asyncio.shield(self.ask(session, b""))
            self._free.append(session)

    async def _serve_lines(self, client: Client, reader: asyncio.StreamReader) -> None:
        """Read lines and write responses one by one; HTTP in the first line ends the session."""
        door, writer = client.door, client.writer
        sock = writer.get_extra_info("socket")
        if sock is not None:
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        splitter, is_greeted = Splitter(), False

        async def more_lines(count: int) -> list[bytes]:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(POLL):
                    data = await reader.read(4096)
                if not data or count > WAITING:
                    raise ConnectionError
                return splitter.split_lines(data)
            return []

        while True:
            async with asyncio.timeout(IDLE):
                data = await reader.read(4096)
            if not data:
                return
            if sock is not None and hasattr(socket, "TCP_QUICKACK"):
                # the response to one line must be acknowledged before the next line is read
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            lines = splitter.split_lines(data)
            for line in lines:  # the queue grows while a line waits
                if not is_greeted and not is_message(line):
                    return
                is_greeted = True
                wrong = door.wrong
                if door.open and client.session == GUEST and self._free:
                    client.session = self._free.pop()
                    self._guests.pop(client, None)
                passes, answer = door.filter_line(line, client.session != GUEST)
                if passes:
                    answer = await self.execute(client.session, line, lines, more_lines)
                if answer:
                    writer.write(answer + b"\n")
                    await writer.drain()
                if door.wrong >= TRIES:
                    return
                if door.wrong > wrong:
                    await asyncio.sleep(DELAY * 2**wrong)
            if splitter.is_overlong:
                return

    async def serve_terminal(self, master: int) -> None:
        """Serve a pseudo-terminal in its own session while the gateway runs."""
        loop, splitter = asyncio.get_running_loop(), Splitter()
        os.set_blocking(master, False)
        session = self._free.pop()
        came = asyncio.Event()
        loop.add_reader(master, came.set)

        async def more_lines(count: int) -> list[bytes]:
            await asyncio.sleep(POLL)
            if count <= WAITING:  # the terminal keeps the unsent rest
                with contextlib.suppress(BlockingIOError):
                    return splitter.split_lines(os.read(master, 4096))
            return []

        try:
            while True:
                await came.wait()
                came.clear()
                with contextlib.suppress(BlockingIOError):
                    lines = splitter.split_lines(os.read(master, 4096))
                    for line in lines:
                        answer = await self.execute(session, line, lines, more_lines)
                        if answer:
                            await _write_fully(loop, master, answer + b"\n")
        finally:
            loop.remove_reader(master)

    async def shut_down(self) -> None:
        """Disconnect the clients, switch the outputs off and close the line."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        if not self._down.done():
            with contextlib.suppress(LineError):
                await self.ask(GUEST, b"OUTP OFF")
            self._down.cancel()
        self._thread.shutdown()


async def _write_fully(loop: asyncio.AbstractEventLoop, descriptor: int, data: bytes) -> None:
    """Write all data to a terminal that may be full."""
    while data:
        try:
            data = data[os.write(descriptor, data) :]
        except BlockingIOError:
            has_room = asyncio.Event()
            loop.add_writer(descriptor, has_room.set)
            try:
                await has_room.wait()
            finally:
                loop.remove_writer(descriptor)


def is_loopback(host: str) -> bool:
    """Return whether the address can be reached only from this machine."""
    with contextlib.suppress(ValueError):
        return ipaddress.ip_address(host).is_loopback
    return host == "localhost"


def serve(
    address: str | Address,
    announce: Callable[[Listening], None],
    *,
    port: int = PORT,
    host: str = "127.0.0.1",
    token_file: str | Path | None = None,
    pty: str | Path | None = None,
) -> None:
    """Serve a board until SIGTERM or SIGINT, then switch its outputs off.

    `announce` is called once, when clients can connect. Port 0 selects any free port. `pty` is the
    path of a link to create, through which clients can use the board as a serial port. Raises
    LineError if the board stops responding, FileError if the port or link is not available,
    QuantityError if other machines have access but no token file is given.
    """
    if not is_loopback(host) and token_file is None:
        raise QuantityError.of(
            "token file",
            f"missing; other machines can reach {host}; a token file (--token-file) keeps them out",
        )
    token = make_token(token_file) if token_file is not None else ""
    if pty is not None and not hasattr(os, "openpty"):
        raise QuantityError.of(
            "pty", ("this system has no pseudo-terminals; clients must use the TCP port")
        )
    if pty is not None and Path(pty).exists():
        raise FileError(pty, "already exists")
    line, _board = connect(address)
    try:
        asyncio.run(_run_gateway(line, announce, str(address), (host, port), token, pty))
    finally:
        line.close()


async def _run_gateway(
    line: Line,
    announce: Callable[[Listening], None],
    address: str,
    endpoint: tuple[str, int],
    token: str,
    pty: str | Path | None,
) -> None:
    gateway, loop = Gateway(line, token), asyncio.get_running_loop()
    host, port = endpoint
    end = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        try:
            loop.add_signal_handler(number, end.set)
        except NotImplementedError:  # the Windows event loop does not support signal handlers
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(end.set))
    try:
        server = await asyncio.start_server(gateway.serve_guest, host, port)
    except OSError as error:
        raise FileError(f"{host}:{port}", f"cannot listen: {error.strerror}") from None
    jobs = {asyncio.create_task(gateway.watch_line()), asyncio.create_task(end.wait())}
    with contextlib.ExitStack() as stack:
        if pty is not None:
            master = stack.enter_context(_open_terminal(Path(pty)))
            jobs.add(asyncio.create_task(gateway.serve_terminal(master)))
        identity = (await gateway.ask(GUEST, b"*IDN?")).decode("ascii", "replace")
        listens = server.sockets[0].getsockname()[1]
        link = None if pty is None else str(pty)
        announce(Listening(host, listens, address, identity, os.getpid(), link))
        finished_jobs, waiting = await asyncio.wait(jobs, return_when=asyncio.FIRST_COMPLETED)
        server.close()
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        await gateway.shut_down()
        for task in finished_jobs:
            task.result()


@contextlib.contextmanager
def _open_terminal(link: Path):  # type: ignore[no-untyped-def]
    """Open the master side of a pseudo-terminal; create `link`, which points to the slave side."""
    import tty

    master, slave = os.openpty()
    try:
        tty.setraw(slave)
        link.symlink_to(os.ttyname(slave))
        yield master
    except OSError as error:
        raise FileError(link, error.strerror or "cannot be created") from None
    finally:
        link.unlink(missing_ok=True)
        os.close(master)
        os.close(slave)
