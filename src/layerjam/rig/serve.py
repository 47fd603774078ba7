"""The gateway: one board's line for many clients, over TCP and as a serial port.

Each client that may command has a session of its own on the board. All others share one, in which
only `OUTP OFF`, `ABOR`, `*IDN?` and `SYST:ERR?` are heard. Lines are plain SCPI. The gateway keeps
nothing running for a client: if it is silent, the board's lease ends.
"""

from __future__ import annotations

import asyncio
import contextlib
import ipaddress
import os
import signal
import socket
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from layerjam.errors import FileError, QuantityError
from layerjam.rig.address import Address
from layerjam.rig.board import connect
from layerjam.rig.line import Line, LineError
from layerjam.rig.token import DELAY, TRIES, Door, is_message, token_of

PORT = 5025
"""What instruments with a raw SCPI socket listen on."""
SESSIONS = 14
"""Clients that may command at the same time."""
GUEST = 15
"""Session of the board that all other clients share."""
GUESTS = 64
"""Such clients at most; one more closes the oldest."""
LONGEST = 1024
"""Bytes of a line at most; a longer one is refused by the board, -363."""
ENDLESS = 65536
"""Bytes without an LF after which a client is closed."""
IDLE = 3600.0
"""Seconds after which a silent client is closed."""


@dataclass(frozen=True)
class Listening:
    """Where a gateway can be reached."""

    host: str
    port: int
    address: str
    identity: str
    pid: int
    pty: str | None

    @property
    def visa(self) -> str:
        """The line of PyVISA that opens it; without the terminations every answer times out."""
        # a gateway on all addresses is reached by this machine's name
        host = socket.gethostname() if self.host in ("0.0.0.0", "::", "") else self.host
        return (
            f'rm.open_resource("TCPIP::{host}::{self.port}::SOCKET", '
            r'read_termination="\n", write_termination="\n")'
        )


class Splitter:
    """Lines out of bytes; of a line too long the beginning, once, and then nothing to its LF."""

    def __init__(self) -> None:
        self._rest = b""
        self._skipped = 0

    def feed(self, data: bytes) -> list[bytes]:
        """The whole lines, without LF or CR LF, empty ones left out."""
        *whole, rest = (self._rest + data).split(b"\n")
        lines = []
        for line in whole:
            if self._skipped:
                self._skipped = 0
                continue
            if line.removesuffix(b"\r"):
                lines.append(line.removesuffix(b"\r")[: LONGEST + 1])
        if self._skipped:
            self._skipped += len(rest)
            rest = b""
        elif len(rest) > LONGEST + 1:
            lines.append(rest[: LONGEST + 1])
            self._skipped, rest = len(rest), b""
        self._rest = rest
        return lines

    @property
    def endless(self) -> bool:
        """Whether no LF has come for far too long."""
        return self._skipped > ENDLESS


@dataclass(eq=False)
class Client:
    """One connection: what it may do, and its session of the board."""

    door: Door
    writer: asyncio.StreamWriter
    session: int = GUEST


class Gateway:
    """Clients on one side, a board's line on the other."""

    def __init__(self, line: Line, token: str = "") -> None:
        self.line = line
        self._token = token
        self._free = list(range(SESSIONS, 0, -1))
        self._guests: dict[Client, None] = {}
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="line")
        self._down = asyncio.get_running_loop().create_future()
        self._tasks: set[asyncio.Task[None]] = set()

    async def ask(self, session: int, text: bytes) -> bytes:
        """The board's answer; a line that is down ends the gateway."""
        loop = asyncio.get_running_loop()
        try:
            return await loop.run_in_executor(self._thread, self.line.ask, session, text)
        except LineError as error:
            if not self._down.done():
                self._down.set_exception(error)
            raise

    async def down(self) -> None:
        """Wait until the board's line is down; raises LineError then."""
        await asyncio.shield(self._down)

    async def client(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection to its end."""
        task = asyncio.current_task()
        if task is not None:
            self._tasks.add(task)
        client = Client(Door(self._token), writer)
        self._guests[client] = None
        if len(self._guests) > GUESTS:
            next(iter(self._guests)).writer.close()
        try:
            await self._serve(client, reader)
        except (ConnectionError, LineError, TimeoutError, asyncio.CancelledError):
            pass  # the client or the board is gone, or the gateway ends
        finally:
            if task is not None:
                self._tasks.discard(task)
            self._guests.pop(client, None)
            writer.close()
            await self._leave(client.session)

    async def _leave(self, session: int) -> None:
        """End a client's session: lock, lease, registers and queue."""
        if session != GUEST:
            with contextlib.suppress(LineError):
                await asyncio.shield(self.ask(session, b""))
            self._free.append(session)

    def _admit(self, client: Client) -> None:
        """Give a client that may command a session of its own, if one is free."""
        if client.door.open and client.session == GUEST and self._free:
            client.session = self._free.pop()
            self._guests.pop(client, None)

    async def _serve(self, client: Client, reader: asyncio.StreamReader) -> None:
        """Lines in, answers out, one after the other. A first line of HTTP ends it."""
        door, writer = client.door, client.writer
        sock = writer.get_extra_info("socket")
        if sock is not None:
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        splitter, greeted = Splitter(), False
        while True:
            async with asyncio.timeout(IDLE):
                data = await reader.read(4096)
            if not data:
                return
            if sock is not None and hasattr(socket, "TCP_QUICKACK"):
                # a client that sends a line and then another waits for the first one's receipt
                sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_QUICKACK, 1)
            for line in splitter.feed(data):
                if not greeted and not is_message(line):
                    return
                greeted = True
                wrong = door.wrong
                self._admit(client)
                passes, answer = door.through(line, client.session != GUEST)
                if passes:
                    answer = await self.ask(client.session, line)
                if answer:
                    writer.write(answer + b"\n")
                    await writer.drain()
                if door.wrong >= TRIES:
                    return
                if door.wrong > wrong:
                    await asyncio.sleep(DELAY * 2**wrong)
            if splitter.endless:
                return

    async def terminal(self, master: int) -> None:
        """Serve a pseudo-terminal for as long as the gateway runs, in one session of its own."""
        loop, splitter = asyncio.get_running_loop(), Splitter()
        os.set_blocking(master, False)
        session = self._free.pop()
        came = asyncio.Event()
        loop.add_reader(master, came.set)
        try:
            while True:
                await came.wait()
                came.clear()
                with contextlib.suppress(BlockingIOError):
                    for line in splitter.feed(os.read(master, 4096)):
                        answer = await self.ask(session, line)
                        if answer:
                            await _write(loop, master, answer + b"\n")
        finally:
            loop.remove_reader(master)

    async def end(self) -> None:
        """Clients are closed, outputs switched off, the line given back."""
        for task in list(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        if not self._down.done():
            with contextlib.suppress(LineError):
                await self.ask(GUEST, b"OUTP OFF")
            self._down.cancel()
        self._thread.shutdown()


async def _write(loop: asyncio.AbstractEventLoop, descriptor: int, data: bytes) -> None:
    """All of it into a terminal that may be full."""
    while data:
        try:
            data = data[os.write(descriptor, data) :]
        except BlockingIOError:
            room = asyncio.Event()
            loop.add_writer(descriptor, room.set)
            try:
                await room.wait()
            finally:
                loop.remove_writer(descriptor)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach it."""
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

    `announce` is called once, when clients may come; port 0 takes a free one. `pty` is the path
    of a link to a serial port that is made. Raises LineError where the board stops answering,
    FileError where port or link cannot be had, QuantityError for another host without a token.
    """
    if not is_loopback(host) and token_file is None:
        raise QuantityError.of(
            "token file",
            f"missing; {host} can be reached by others, and a file made by --token-file keeps "
            "them out",
        )
    token = token_of(token_file) if token_file is not None else ""
    if pty is not None and not hasattr(os, "openpty"):
        raise QuantityError.of("pty", "this system has no pseudo-terminals; clients take the port")
    if pty is not None and Path(pty).exists():
        raise FileError(pty, "is there already")
    line, _board = connect(address)
    try:
        asyncio.run(_run(line, announce, str(address), (host, port), token, pty))
    finally:
        line.close()


async def _run(
    line: Line,
    announce: Callable[[Listening], None],
    address: str,
    at: tuple[str, int],
    token: str,
    pty: str | Path | None,
) -> None:
    gateway, loop = Gateway(line, token), asyncio.get_running_loop()
    host, port = at
    ended = asyncio.Event()
    for number in (signal.SIGTERM, signal.SIGINT):
        try:
            loop.add_signal_handler(number, ended.set)
        except NotImplementedError:  # the loop of Windows has none
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(ended.set))
    try:
        server = await asyncio.start_server(gateway.client, host, port)
    except OSError as error:
        raise FileError(f"{host}:{port}", f"cannot be listened on: {error.strerror}") from None
    jobs = {asyncio.create_task(gateway.down()), asyncio.create_task(ended.wait())}
    with contextlib.ExitStack() as stack:
        if pty is not None:
            master = stack.enter_context(_terminal(Path(pty)))
            jobs.add(asyncio.create_task(gateway.terminal(master)))
        identity = (await gateway.ask(GUEST, b"*IDN?")).decode("ascii", "replace")
        listens = server.sockets[0].getsockname()[1]
        announce(
            Listening(
                host, listens, address, identity, os.getpid(), None if pty is None else str(pty)
            )
        )
        done, waiting = await asyncio.wait(jobs, return_when=asyncio.FIRST_COMPLETED)
        server.close()
        for task in waiting:
            task.cancel()
        await asyncio.gather(*waiting, return_exceptions=True)
        await gateway.end()
        for task in done:
            task.result()


@contextlib.contextmanager
def _terminal(link: Path):  # type: ignore[no-untyped-def]
    """The master of a pseudo-terminal whose other side `link` names."""
    import tty

    master, slave = os.openpty()
    try:
        tty.setraw(slave)
        link.symlink_to(os.ttyname(slave))
        yield master
    except OSError as error:
        raise FileError(link, error.strerror or "cannot be made") from None
    finally:
        link.unlink(missing_ok=True)
        os.close(master)
        os.close(slave)
