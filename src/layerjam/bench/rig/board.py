"""A virtual board: the firmware's own files in a folder, run by MicroPython or CPython.

`firmware/` is not a package: its files are flat on a board, and layerjam's code must not import
them.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from layerjam.bench.control import law
from layerjam.bench.control.settings import FAULTS
from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.child import has_pipes, start_child
from layerjam.bench.rig.line import Line, Serial
from layerjam.bench.rig.virtual_plant import PlantThread, VirtualPlant, read_hardware
from layerjam.bench.rig.wiring import load_wiring
from layerjam.core.errors import LayerjamError, MissingExtraError, QuantityError

FOLDER = Path(__file__).parent
PATIENCE = 15.0
"""Maximum start-up time of a board [s]."""


def firmware_files(board: str = "") -> dict[str, str]:
    """Return {file name: text} of everything that runs on a board, including the control law.

    If `board` names a real board, a file with its pins is added.
    """
    files = {
        path.name: path.read_text("utf-8") for path in sorted((FOLDER / "firmware").glob("*.py"))
    }
    files["frame.py"] = (FOLDER / "frame.py").read_text("utf-8")
    files["law.py"] = Path(law.__file__).read_text("utf-8")
    if board:
        files["wired.py"] = (
            f'"""The pins of the board."""\n\nWIRED = {load_wiring(board).firmware_pins()!r}\n'
        )
    digest = hashlib.sha256("".join(name + text for name, text in sorted(files.items())).encode())
    names = {code: name for code, name in FAULTS.items() if code}
    files["built.py"] = (
        '"""Generated when the firmware is assembled."""\n\n'
        f"LAW = {law_hash()!r}\nFIRMWARE = {digest.hexdigest()!r}\nFAULTS = {names!r}\n"
    )
    return files


def law_hash() -> str:
    """Return the SHA-256 of the control law's source; a board reports its first eight digits."""
    return hashlib.sha256(Path(law.__file__).read_bytes()).hexdigest()


def write_firmware(folder: Path) -> None:
    """Write the firmware's files to one folder, laid out as on a board."""
    for name, text in firmware_files().items():
        (folder / name).write_text(text, encoding="utf-8")


def interpreter_command(python: str = "") -> list[str]:
    """Return the command that runs the firmware: MicroPython if installed, otherwise this Python.

    `python` selects the interpreter: "micropython" or "cpython".
    """
    local = Path(sys.executable).parent / "micropython"
    program = str(local) if local.exists() else shutil.which("micropython")
    if python == "micropython" and not has_pipes():
        raise QuantityError.of(
            "address", "python=micropython needs pipes that Windows lacks; omit it"
        )
    if python == "cpython" or (not python and (program is None or not has_pipes())):
        return [sys.executable, "-S", "-E", "-s", "-B"]
    if program is None:
        raise MissingExtraError("MicroPython", "bench")
    return [program]


class VirtualBoard:
    """A board whose firmware runs in a subprocess and whose plant runs in a thread.

    `name` is the interpreter. Raises MissingExtraError if a requested MicroPython is not installed.
    """

    def __init__(self, address: Address) -> None:
        hardware = read_hardware(address)
        python = address.options.get("python", "")
        if python not in ("", "micropython", "cpython"):
            raise QuantityError.of(
                "address", f"python={python[:40]} is not 'micropython' or 'cpython'"
            )
        command = interpreter_command(python)
        self.name = "MicroPython" if "micropython" in command[0] else "CPython"
        self.plant = VirtualPlant(hardware)
        self._folder: tempfile.TemporaryDirectory[str] | None = None
        self._folder = tempfile.TemporaryDirectory(prefix="layerjam-board-")
        write_firmware(Path(self._folder.name))
        words = [str(hardware.speed), f"SIM-{hardware.name}"]
        if "store" in address.options:
            words.append(os.path.abspath(address.options["store"]))
        main_file = str(Path(self._folder.name) / "main.py")
        self._child = start_child([*command, main_file], words, self.close)
        self._thread = PlantThread(self.plant, self._child)
        self._thread.start()
        self.line = Line(self._child.line, str(address))

    @property
    def ends(self) -> tuple[int, int]:
        """File descriptors of the line: the board's output and input."""
        return self._child.ends

    @property
    def pid(self) -> int:
        """Process ID of the firmware."""
        return self._child.process.pid

    def close(self) -> None:
        """Close the line; the board then makes its outputs safe and exits."""
        if self._folder is None:
            return
        self._child.hang_up()
        try:
            self._child.process.wait(2)
        except subprocess.TimeoutExpired:
            self._child.process.kill()
            self._child.process.wait()
        self._thread.join(2)
        self._folder.cleanup()
        self._folder = None


def connect(address: str | Address) -> tuple[Line, VirtualBoard | None]:
    """Return the line to the board at an address, and the virtual board if one is started for it.

    Raises LineError if no board responds, FileError if the port is not available.
    """
    target = address_of(address)
    if target.kind == "sim":
        board = VirtualBoard(target)
        line = board.line
    elif target.kind == "serial":
        board, line = None, Line(Serial(target.where), str(target))
    else:
        raise QuantityError.of(
            "address", f"{target} is not the address of a board; write 'serial:...' or 'sim:...'"
        )
    try:
        line.greet(PATIENCE)
    except LayerjamError:
        line.close()
        raise
    return line, board
