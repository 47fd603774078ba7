"""Firmware onto a board: the port, the image and the board may each be the wrong one."""

from __future__ import annotations

import binascii
import contextlib
import io
import json
import os
import sys
import threading
import types
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

from bench.rig.boards import Hal, firmware
from layerjam.bench.rig import flash as flashing
from layerjam.bench.rig import uf2
from layerjam.bench.rig.board import firmware_files
from layerjam.bench.rig.line import LineError
from layerjam.cli.main import main
from layerjam.core.errors import FileError, LayerjamError, QuantityError, UnknownNameError

needs_port = pytest.mark.skipif(find_spec("serial") is None, reason="pyserial is not installed")
PICO = Path(flashing.__file__).parent / "boards" / "pico.toml"


class Board:
    """A board on a pty: the firmware, or MicroPython's raw prompt over a folder as its flash."""

    def __init__(self, folder: Path, held: str = "none") -> None:
        self.folder, self.held = folder, held
        tty = pytest.importorskip("tty", reason="this system has no pseudo-terminals")
        self.outer, self.inner = os.openpty()

        tty.setraw(self.inner)
        self.port = os.ttyname(self.inner)
        self.prompted = held == "none"
        self.drop = self.refuses = False
        self.resets: list[str] = []
        self.start()
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def start(self) -> None:
        self.code = firmware()
        board = self

        class Ours(Hal):
            def identity(self) -> tuple[str, str]:
                return "Raspberry Pi Pico", "E661"

            def enter_maintenance(self) -> None:
                if board.refuses:
                    raise board.code.scpi.ScpiError(-221, "not now")
                board.prompted = True
                raise board.code.main.Reset

        self.bench = self.code.bench.Bench(Ours())
        self.code.common.built.FIRMWARE = self.held
        self.lines = self.code.port.Port(self.bench)

    def serve(self) -> None:
        buffer = b""
        self.globals: dict[str, object] = {}
        while True:
            try:
                data = os.read(self.outer, 4096)
            except OSError:
                return
            if not self.prompted:
                try:
                    self.lines.process_bytes(data)
                    self.write(self.lines.outbox)
                except self.code.main.Reset:
                    pass
                self.lines.outbox = b""
                continue
            buffer += data
            if b"\r\x01" in buffer:
                buffer = buffer.split(b"\r\x01", 1)[1]
                self.write(b"raw REPL; CTRL-B to exit\r\n>")
            while b"\x04" in buffer:
                program, _, buffer = buffer.partition(b"\x04")
                self.execute(program.decode())
            if not self.prompted:
                buffer = b""

    def write(self, data: bytes) -> None:
        with contextlib.suppress(OSError):
            os.write(self.outer, data)

    def execute(self, program: str) -> None:
        said, wrong = io.StringIO(), ""

        def opened(name: str, how: str) -> object:
            return (self.folder / name).open(how)

        machine = types.SimpleNamespace(reset=self.reset, bootloader=self.boot)
        kept = {name: sys.modules.get(name) for name in ("machine", "built")}
        sys.modules["machine"] = machine  # type: ignore[assignment]
        sys.modules["built"] = types.SimpleNamespace(FIRMWARE=self.held)  # type: ignore[assignment]
        if self.held == "none":
            sys.modules["built"] = None  # type: ignore[assignment]
        self.globals.update(open=opened, print=lambda text: said.write(f"{text}\r\n"))
        try:
            exec(program, self.globals)
        except Exception as error:
            wrong = f"Traceback:\r\n{type(error).__name__}: {error}\r\n"
        finally:
            for name, module in kept.items():
                sys.modules.pop(name, None)
                if module is not None:
                    sys.modules[name] = module
        if self.prompted:
            self.write(b"OK" + said.getvalue().encode() + b"\x04" + wrong.encode() + b"\x04>")

    def reset(self) -> None:
        self.resets.append("reset")
        if (self.folder / "built.py").exists() and self.held == "none":
            held: dict[str, str] = {}
            exec((self.folder / "built.py").read_text("utf-8"), held)
            self.held = held["FIRMWARE"]
        self.start()
        self.prompted = False

    def boot(self) -> None:
        self.resets.append("bootloader")


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flashing, "PATIENCE", 1.0)


@pytest.fixture
def flash_folder(tmp_path: Path) -> Iterator[Path]:
    folder = tmp_path / "flash"
    folder.mkdir()
    yield folder


def good_image(path: Path) -> bytes:
    image = uf2.encode_uf2(b"layerjam " + flashing.firmware_hash("pico").encode(), uf2.RP2040)
    path.write_bytes(image)
    return image


@pytest.mark.slow
@needs_port
def test_a_board_with_plain_micropython_gets_all_files(flash_folder: Path) -> None:
    board = Board(flash_folder)
    done = flashing.flash(board.port, settings=PICO)
    written = {path.name: path.read_text("utf-8") for path in flash_folder.iterdir()}
    wired = json.loads(written.pop("wired.json"))
    assert written == firmware_files("pico") and wired["vent_gate"] == 17
    assert set(done.files) == {*firmware_files("pico"), "wired.json"} and done.verified
    assert done.identity is not None and ",Raspberry Pi Pico,E661," in done.identity


@needs_port
def test_a_board_with_our_image_gets_only_its_wiring(flash_folder: Path) -> None:
    board = Board(flash_folder, flashing.firmware_hash("pico"))
    done = flashing.flash(board.port, settings=PICO)
    assert (done.files, done.verified, board.resets) == (("wired.json",), True, ["reset"])


@needs_port
def test_as_it_is_typed(flash_folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    board = Board(flash_folder, flashing.firmware_hash("pico"))
    assert main(["bench", "flash", board.port, "--settings", str(PICO), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert set(said) == {
        "board", "image_sha256", "files", "verified", "identity", "units", "warnings"
    }  # fmt: skip
    assert (said["board"], said["image_sha256"], said["files"]) == ("pico", None, ["wired.json"])
    assert said["verified"] and said["identity"].startswith("layerjam,")
    assert main(["bench", "flash", "/dev/ttyNothing"]) == 2


@needs_port
def test_an_image_goes_by_the_drive_of_the_boot_loader(
    flash_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board(flash_folder, "another version")
    image = good_image(tmp_path / "a.uf2")
    with pytest.raises(LineError, match="as PORT"):
        flashing.flash(board.port, image=tmp_path / "a.uf2")
    drive = tmp_path / "drive"
    drive.mkdir()
    for said in (None, "Board-ID: OTHER"):
        if said:
            (drive / "INFO_UF2.TXT").write_text(said, encoding="ascii")
        with pytest.raises(FileError, match="boot loader"):
            flashing.flash(str(drive), image=tmp_path / "a.uf2")
    (drive / "INFO_UF2.TXT").write_text("UF2 Bootloader\nBoard-ID: RPI-RP2\n", encoding="ascii")
    done = flashing.flash(str(drive), image=tmp_path / "a.uf2")
    assert (drive / "layerjam.uf2").read_bytes() == image
    assert (done.verified, done.identity) == (False, None)
    (drive / "layerjam.uf2").unlink()
    monkeypatch.setattr(flashing, "DRIVES", (str(tmp_path / "d*"),))
    board.held, board.prompted = flashing.firmware_hash("pico"), True
    load = flashing.write_image

    def loaded(data: bytes, place: Path) -> None:
        load(data, place)
        board.reset()

    monkeypatch.setattr(flashing, "write_image", loaded)
    done = flashing.flash(board.port, image=tmp_path / "a.uf2", settings=PICO)
    assert (drive / "layerjam.uf2").read_bytes() == image
    assert done.verified and done.files == ("wired.json",)
    assert board.resets[-2:] == ["bootloader", "reset"]


@pytest.mark.slow
@needs_port
def test_a_board_that_is_busy_or_silent_or_another(
    flash_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board(flash_folder, "old")
    board.refuses = True
    with pytest.raises(LineError, match="not now"):
        flashing.flash(board.port, settings=PICO)
    outer, inner = os.openpty()
    with pytest.raises(LineError, match="neither the firmware nor"):
        flashing.flash(os.ttyname(inner), settings=PICO)
    os.close(outer)
    os.close(inner)
    with pytest.raises(FileError):
        flashing.flash("/dev/ttyNothing", settings=PICO)


@needs_port
def test_a_flash_that_keeps_something_else_is_seen(
    flash_folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = Board(flash_folder, flashing.firmware_hash("pico"))
    right = binascii.hexlify
    monkeypatch.setattr(binascii, "hexlify", lambda data: right(data)[:-2] + b"00")
    with pytest.raises(LineError, match=r"wired\.json on the board differs"):
        flashing.flash(board.port, settings=PICO)


def test_what_is_given_is_looked_at_first(tmp_path: Path) -> None:
    """Nothing of it reaches a port: there is none."""
    image = tmp_path / "a.uf2"
    for raw, says in (
        (b"text", "not a UF2 image"),
        (uf2.encode_uf2(b"layerjam", 0x12345678), "is for chip family"),
        (uf2.encode_uf2(b"MicroPython", uf2.RP2040), "no layerjam firmware"),
        (uf2.encode_uf2(b"layerjam", uf2.RP2040), "a different version"),
    ):
        image.write_bytes(raw)
        with pytest.raises(uf2.ImageError, match=says):
            flashing.flash("/dev/ttyNothing", image=image)
    with pytest.raises(FileError, match="cannot be read"):
        flashing.flash("/dev/ttyNothing", image=tmp_path / "none.uf2")
    with pytest.raises(UnknownNameError):
        flashing.flash("/dev/ttyNothing", board="pica")
    for port in ("sim:choi2018", "tcp:127.0.0.1:5025"):
        with pytest.raises(QuantityError, match="not a serial port"):
            flashing.flash(port)
    with pytest.raises(QuantityError, match="drive"):
        flashing.flash(str(tmp_path))
    with pytest.raises(LayerjamError):
        flashing.flash("/dev/ttyNothing", settings=image)
