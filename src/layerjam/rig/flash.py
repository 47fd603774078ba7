"""Firmware and wiring onto a board: an image over its boot loader, files over its prompt.

The prompt is MicroPython's raw mode: Ctrl-A begins it, Ctrl-D runs what was sent; "OK", the output,
Ctrl-D, the traceback and Ctrl-D come back (MicroPython's documentation, "The MicroPython
Interactive Interpreter Mode").
"""

from __future__ import annotations

import glob
import hashlib
import json
import os
import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from layerjam.errors import FileError, LayerjamError, QuantityError
from layerjam.rig import uf2
from layerjam.rig.board import parts
from layerjam.rig.line import Ends, Line, LineError, Serial
from layerjam.rig.outcomes import Flashed
from layerjam.rig.wiring import load_wiring

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
        """Return the bytes up to `end`, without it."""
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
        """Return the output of a program."""
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


PATIENCE = 20.0
"""Seconds that a board may take to come back."""
DRIVES = ("/media/*/*", "/run/media/*/*", "/Volumes/*", "/mnt/*", "[D-Z]:/")
MARK = "INFO_UF2.TXT"
"""File that the boot loader's drive holds."""
CHIP = "RPI-RP2"
HELD = "try:\n import built\n print(built.FIRMWARE)\nexcept ImportError:\n print('none')"
T = TypeVar("T")


def firmware_hash(board: str) -> str:
    """SHA-256 of the files that this package puts on a board."""
    return re.findall("FIRMWARE = '(.*)'", parts(board)["built.py"])[0]


def image_of(path: Path, board: str) -> bytes:
    """An image that may go onto the board; FileError or ImageError for any other file."""
    try:
        image = path.read_bytes()
    except OSError as error:
        raise FileError(path, f"cannot be read: {error.strerror}") from None
    program = uf2.unpacked(image, uf2.RP2040, str(path))
    if b"layerjam" not in program:
        raise uf2.ImageError(f"{path} holds no firmware of layerjam; `make firmware` builds one")
    if firmware_hash(board).encode() not in program:
        raise uf2.ImageError(f"{path} holds firmware of another version; `make firmware` builds it")
    return image


def flash(
    port: str, *, board: str = "pico", image: Path | None = None, settings: Path | None = None
) -> Flashed:
    """Give a board its firmware and wiring; `port` is a serial port, or the boot loader's drive.

    With an image the boot loader takes it. Without one, a board with plain MicroPython gets the
    firmware's files. `settings` is a wiring's TOML file. Raises FileError, ImageError, LineError
    and QuantityError.
    """
    # everything that is given is looked at before anything is sent
    load_wiring(board)
    wired = None if settings is None else json.dumps(load_wiring(settings).wired()).encode()
    made = None if image is None else image_of(image, board)
    digest = None if made is None else hashlib.sha256(made).hexdigest()
    if port.partition(":")[0] in ("sim", "tcp", "visa"):
        raise QuantityError.of("port", f"'{port[:80]}' is no serial port of this machine")
    port = port.removeprefix("serial:")
    if os.path.isdir(port):
        if made is None or wired is not None:
            raise QuantityError.of(
                "port", f"{port} is a drive: it takes an image; settings need the serial port"
            )
        load(made, Path(port))
        return Flashed(board=board, image_sha256=digest, files=(), verified=False, identity=None)
    files = tuple(put_all(port, board, made, wired))
    if made is not None:
        load(made, found(drive, "the boot loader's drive did not appear; mount it, and give it"))
    identity, same = again(lambda: greeted(port, board))
    return Flashed(board=board, image_sha256=digest, files=files, verified=same, identity=identity)


def put_all(port: str, board: str, image: bytes | None, wired: bytes | None) -> list[str]:
    """Write files, then start the board anew or its boot loader; the names of what was written."""
    if greeting(port):
        to_prompt(port)
    prompt, ends = again(lambda: at_prompt(port))
    try:
        held = prompt.run(HELD).strip()
        files = {} if wired is None else {"wired.json": wired}
        if image is None and held != firmware_hash(board):
            files.update((name, text.encode()) for name, text in parts(board).items())
        for name, data in files.items():
            prompt.put(name, data)
        prompt.send(
            "import machine\n" + ("machine.bootloader()" if image else "machine.reset()") + "\n"
        )
        return list(files)
    finally:
        ends.close()


def at_prompt(port: str) -> tuple[Prompt, Serial]:
    """The prompt behind a port."""
    ends = Serial(port)
    try:
        return Prompt(ends, port), ends
    except LayerjamError:
        ends.close()
        raise


def greeting(port: str) -> str:
    """The firmware's `*IDN?`, empty where the firmware does not run."""
    line = Line(Serial(port), port)
    try:
        said = line.ask(1, b"*IDN?", tries=2).decode("ascii", "replace")
    except LineError:
        return ""
    finally:
        line.close()
    if not said.startswith("layerjam,"):
        raise LineError(f"{port}: {said[:60]!r} answers, no board of ours")
    return said


def to_prompt(port: str) -> None:
    """Ask a running firmware for its prompt; LineError where it refuses."""
    line = Line(Serial(port), port)
    try:
        line.ask(1, b"SYST:MAIN", tries=1)
        why = line.ask(1, b"SYST:ERR?").decode("ascii", "replace")
    except LineError:
        return  # it has started anew
    finally:
        line.close()
    raise LineError(f"{port}: the board does not leave its firmware: {why}")


def greeted(port: str, board: str) -> tuple[str, bool]:
    """(identity, whether its firmware is this package's) of a board that has started."""
    line = Line(Serial(port), port)
    try:
        identity = line.greet(2.0)
        firmware = line.ask(1, b"SYST:BOOT?").decode("ascii").split(",")[3].strip('"')
        return identity, bool(firmware) and firmware_hash(board).startswith(firmware)
    finally:
        line.close()


def again(ask: Callable[[], T]) -> T:
    """An answer of a board that is just starting."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return ask()
        except (FileError, LineError):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


def drive() -> Path | None:
    """The boot loader's drive, None while there is none."""
    for pattern in DRIVES:
        for place in glob.glob(pattern):
            if (Path(place) / MARK).is_file():
                return Path(place)
    return None


def found(look: Callable[[], Path | None], otherwise: str) -> Path:
    """What appears within PATIENCE."""
    end = time.monotonic() + PATIENCE
    while (place := look()) is None:
        if time.monotonic() > end:
            raise LineError(f"{otherwise} as PORT")
        time.sleep(0.2)
    return place


def load(image: bytes, place: Path) -> None:
    """Copy an image onto the boot loader's drive; FileError where that is another drive."""
    try:
        said = (place / MARK).read_text("ascii", "replace")
    except OSError:
        raise FileError(place, f"is no boot loader's drive: it holds no {MARK}") from None
    if CHIP not in said:
        raise FileError(place, f"is the boot loader of another chip than {CHIP}")
    try:
        with (place / "layerjam.uf2").open("wb") as file:
            file.write(image)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise FileError(place, f"does not take the image: {error.strerror}") from None
