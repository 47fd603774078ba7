"""Writing firmware and wiring to a board: an image by its boot loader, or files by its prompt.

The prompt is MicroPython's raw mode: Ctrl-A enters it and Ctrl-D runs the program. The board
returns "OK", the output, Ctrl-D, the traceback and Ctrl-D (MicroPython's documentation, "The
MicroPython Interactive Interpreter Mode").
"""

import glob
import hashlib
import json
import os
import re
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TypeVar

from layerjam.bench.rig import uf2
from layerjam.bench.rig.board import firmware_files
from layerjam.bench.rig.line import Ends, Line, LineError, Serial
from layerjam.bench.rig.outcomes import Flashed
from layerjam.bench.rig.wiring import load_wiring
from layerjam.core.errors import FileError, LayerjamError, QuantityError
from layerjam.core.system import report_failure

RAW, RUN, STOP, LEAVE = b"\x01", b"\x04", b"\x03", b"\x02"
READY = b"raw REPL; CTRL-B to exit\r\n>"
CHUNK = 128
"""Number of bytes sent at a time; a board's own buffer holds 512."""
WAIT = 10.0
PIECE = 512
"""Number of bytes of a file that each program sent to the prompt writes."""


class Prompt:
    """A board at its prompt; raises LineError if no board responds or a program fails."""

    def __init__(self, ends: Ends, name: str) -> None:
        self._ends, self._name, self._buffer = ends, name, b""
        ends.write(b"\r" + STOP + STOP)
        ends.write(b"\r" + RAW)
        self._read_until(READY, 2.0)

    def _read_until(self, end: bytes, wait: float) -> bytes:
        last = time.monotonic() + wait
        while end not in self._buffer:
            time_left = last - time.monotonic()
            if time_left <= 0:
                raise LineError(
                    f"{self._name}: neither the firmware nor MicroPython's prompt "
                    f"responds; received {self._buffer[-60:]!r}"
                )
            self._buffer += self._ends.read(time_left)
        data, _, self._buffer = self._buffer.partition(end)
        return data

    def start_program(self, program: str) -> None:
        """Start a program that does not return."""
        data = program.encode("utf-8")
        for start in range(0, len(data), CHUNK):
            self._ends.write(data[start : start + CHUNK])
        self._ends.write(RUN)

    def run_program(self, program: str) -> str:
        """Return the output of a program."""
        self.start_program(program)
        self._read_until(b"OK", WAIT)
        output = self._read_until(RUN, WAIT)
        wrong = self._read_until(RUN + b">", WAIT)
        if wrong:
            last = wrong.decode("utf-8", "replace").strip().splitlines()[-1]
            raise LineError(f"{self._name}: the board reports {last[:200]}")
        return output.decode("utf-8", "replace")

    def write_file(self, name: str, data: bytes) -> None:
        """Write a file and read it back; LineError if the board's file differs."""
        self.run_program(f"f=open({name!r},'wb')")
        for start in range(0, len(data), PIECE):
            self.run_program(f"f.write({data[start : start + PIECE]!r})")
        self.run_program("f.close()")
        content = self.run_program(
            f"import binascii\nwith open({name!r},'rb') as f:\n"
            f" while True:\n  b=f.read({PIECE})\n"
            "  if not b: break\n  print(binascii.hexlify(b).decode())\n"
        )
        if bytes.fromhex(content) != data:
            raise LineError(f"{self._name}: {name} on the board differs from the file sent")


PATIENCE = 20.0
"""Maximum time for a board to restart [s]."""
DRIVES = ("/media/*/*", "/run/media/*/*", "/Volumes/*", "/mnt/*", "[D-Z]:/")
MARK = "INFO_UF2.TXT"
"""File that identifies the boot loader's drive."""
CHIP = "RPI-RP2"
HELD = "try:\n import built\n print(built.FIRMWARE)\nexcept ImportError:\n print('none')"
T = TypeVar("T")


def firmware_hash(board: str) -> str:
    """Return the SHA-256 of the files that this package puts on a board."""
    return re.findall("FIRMWARE = '(.*)'", firmware_files(board)["built.py"])[0]


def read_image(path: Path, board: str) -> bytes:
    """Return the image in a file; raises FileError or ImageError if it does not fit the board."""
    with report_failure(path, "cannot be read"):
        image = path.read_bytes()
    program = uf2.decode_uf2(image, uf2.RP2040, str(path))
    if b"layerjam" not in program:
        raise uf2.ImageError(f"{path} contains no layerjam firmware; build it with `make firmware`")
    if firmware_hash(board).encode() not in program:
        raise uf2.ImageError(f"{path} is of a different version; rebuild it with `make firmware`")
    return image


def flash(
    port: str, *, board: str = "pico", image: Path | None = None, settings: Path | None = None
) -> Flashed:
    """Write firmware and wiring to a board; `port` is a serial port, or the boot loader's drive.

    The boot loader accepts an image. Without an image, the firmware's files are written to a board
    with plain MicroPython. `settings` is the TOML file of a wiring. Raises FileError, ImageError,
    LineError and QuantityError.
    """
    # check all arguments before anything is sent
    load_wiring(board)
    wiring = (
        None if settings is None else json.dumps(load_wiring(settings).firmware_pins()).encode()
    )
    image_data = None if image is None else read_image(image, board)
    digest = None if image_data is None else hashlib.sha256(image_data).hexdigest()
    if port.partition(":")[0] in ("sim", "tcp", "visa"):
        raise QuantityError.of("port", f"'{port[:80]}' is not a serial port of this machine")
    port = port.removeprefix("serial:")
    if os.path.isdir(port):
        if image_data is None or wiring is not None:
            raise QuantityError.of(
                "port", f"{port} is a drive: it takes an image; settings need the serial port"
            )
        write_image(image_data, Path(port))
        return Flashed(board=board, image_sha256=digest, files=(), verified=False, identity=None)
    files = tuple(write_files(port, board, image_data, wiring))
    if image_data is not None:
        write_image(image_data, retry_call(find_drive))
    identity, is_same_firmware = retry_call(lambda: check_identity(port, board))
    return Flashed(
        board=board, image_sha256=digest, files=files, verified=is_same_firmware, identity=identity
    )


def write_files(port: str, board: str, image: bytes | None, wiring: bytes | None) -> list[str]:
    """Write files, then restart the board or start its boot loader; return the files' names."""
    if read_greeting(port):
        enter_prompt(port)
    prompt, ends = retry_call(lambda: open_prompt(port))
    with closing(ends):
        installed_hash = prompt.run_program(HELD).strip()
        files = {} if wiring is None else {"wired.json": wiring}
        if image is None and installed_hash != firmware_hash(board):
            files.update((name, text.encode()) for name, text in firmware_files(board).items())
        for name, data in files.items():
            prompt.write_file(name, data)
        prompt.start_program(
            "import machine\n" + ("machine.bootloader()" if image else "machine.reset()") + "\n"
        )
        return list(files)


def open_prompt(port: str) -> tuple[Prompt, Serial]:
    """Return the prompt of a board at a port, and the port."""
    ends = Serial(port)
    try:
        return Prompt(ends, port), ends
    except LayerjamError:
        ends.close()
        raise


def read_greeting(port: str) -> str:
    """Return the firmware's response to `*IDN?`, or "" if the firmware is not running."""
    with closing(Line(Serial(port), port)) as line:
        try:
            response = line.ask(1, b"*IDN?", tries=2).decode("ascii", "replace")
        except LineError:
            return ""
    if not response.startswith("layerjam,"):
        raise LineError(f"{port}: expected a layerjam board, got {response[:60]!r}")
    return response


def enter_prompt(port: str) -> None:
    """Switch from running firmware to the prompt; raises LineError if this fails."""
    with closing(Line(Serial(port), port)) as line:
        try:
            line.ask(1, b"SYST:MAIN", tries=1)
            reason = line.ask(1, b"SYST:ERR?").decode("ascii", "replace")
        except LineError:
            return  # the board has restarted
    raise LineError(f"{port}: the board did not leave its firmware: {reason}")


def check_identity(port: str, board: str) -> tuple[str, bool]:
    """Return a running board's identity, and whether its firmware matches this package."""
    with closing(Line(Serial(port), port)) as line:
        identity = line.greet(2.0)
        firmware = line.ask(1, b"SYST:BOOT?").decode("ascii").split(",")[3].strip('"')
        return identity, bool(firmware) and firmware_hash(board).startswith(firmware)


def retry_call(ask: Callable[[], T]) -> T:
    """Repeat a call until a restarting board responds; return its result."""
    end = time.monotonic() + PATIENCE
    while True:
        try:
            return ask()
        except (FileError, LineError):
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


def find_drive() -> Path:
    """Return the boot loader's drive; raises LineError if there is none."""
    for pattern in DRIVES:
        for place in glob.glob(pattern):
            if (Path(place) / MARK).is_file():
                return Path(place)
    raise LineError("the boot loader's drive did not appear; mount it, and give its path as PORT")


def write_image(image: bytes, place: Path) -> None:
    """Copy an image to the boot loader's drive; raises FileError if `place` is not that drive."""
    try:
        text = (place / MARK).read_text("ascii", "replace")
    except OSError:
        raise FileError(place, f"is not a boot loader's drive: {MARK} is missing") from None
    if CHIP not in text:
        raise FileError(place, f"is the boot loader of a chip other than {CHIP}")
    with (
        report_failure(place, "does not accept the image"),
        (place / "layerjam.uf2").open("wb") as file,
    ):
        file.write(image)
        file.flush()
        os.fsync(file.fileno())
