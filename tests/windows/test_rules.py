"""The file and console layers under Windows' rules, simulated: no Windows was at hand."""

from __future__ import annotations

import os
import shutil
import sys
import types
from pathlib import Path

import pytest

from layerjam.bench.rig import child, crosshead
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.board import connect
from layerjam.bench.rig.line import LineError, _describe_error
from layerjam.brake.device.load import load
from layerjam.brake.kernel import compiler
from layerjam.cli import main as command_line
from layerjam.cli.main import main
from layerjam.core import system
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.store import store_file
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.records.database import database_url
from windows.rules import Console, impose

BRAKE = "choi2018-kapton"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    impose(monkeypatch)
    return tmp_path


@pytest.mark.parametrize("page", ["cp437", "cp1252"])
def test_a_console_that_lacks_letters_gets_every_answer(
    page: str, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    console = Console(monkeypatch, page)
    for words in (
        ("--help",),
        ("show", BRAKE),
        ("show", "choi2018-ptfe"),
        ("force", BRAKE, "--slip", "20mm", "--vacuum", "94.5kPa"),
        ("force", BRAKE, "--slip", "20 µm", "--vacuum", "94.5kPa", "--json"),
        ("new", "mine", "--from", BRAKE, "--out", "mine.toml"),
        ("show", "mine.toml", "--json"),
        ("parts",),
        ("bend", "--help"),
    ):
        assert main(words) == 0, words
        out, err = console.said()
        assert out and err == "", (words, err)
    assert main(("force", "Bremse–µ", "--slip", "1mm", "--vacuum", "1kPa")) == 2
    assert "Bremse" in console.said()[1]


def test_the_rules_hold(here: Path) -> None:
    """What is imposed bites: otherwise nothing below would say anything."""
    made = here / "a.txt"
    made.write_text("one\ntwo\n", encoding="utf-8")
    assert made.read_bytes() == b"one\r\ntwo\r\n"
    with made.open("rb"):
        for act in (made.unlink, lambda: made.replace(here / "b.txt")):
            with pytest.raises(PermissionError):
                act()
    with pytest.raises(OSError, match="Invalid argument"):
        (here / "aux.txt").write_bytes(b"")
    with pytest.raises(ImportError):
        __import__("fcntl")
    (here / "folder").mkdir()
    (here / "other").mkdir()
    with pytest.raises(PermissionError):
        os.replace(here / "other", here / "folder")


NAMES = {
    "con.toml": "device name", "NUL": "device name", "com1.x.toml": "device name",
    "LPT9 .toml": "device name", "mine.toml.": "dot or a space", "a:b.toml": "':'",
    "what?.toml": "'[?]'",
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_windows_does_not_take_is_refused(name: str, here: Path) -> None:
    with pytest.raises(FileError, match=NAMES[name]):
        store_file(here / name, "text")
    assert not list(here.iterdir())


@pytest.mark.parametrize("name", ["console.toml", "com10.toml", "a.b.toml", "κ µ–.toml", ".x"])
def test_other_names_are_taken(name: str, here: Path) -> None:
    assert store_file(here / name, "text").read_bytes() == b"text"


def test_names_are_no_trouble_elsewhere(tmp_path: Path) -> None:
    assert store_file(tmp_path / "con.toml", "text").is_file()


def test_a_path_that_is_too_long_says_so(here: Path) -> None:
    with pytest.raises(FileError, match="exceeds the 259 characters"):
        store_file(here / ("x" * 150) / ("y" * 150), "text")


def test_a_file_that_another_program_has_open_stays(here: Path) -> None:
    path = store_file(here / "mine.toml", "before")
    with path.open("rb"), pytest.raises(FileError, match=r"Access is denied; .*spreadsheet"):
        store_file(path, "after", overwrite=True)
    assert [p.name for p in here.iterdir()] == ["mine.toml"] and path.read_bytes() == b"before"
    store_file(path, "after", overwrite=True)
    assert path.read_bytes() == b"after"


def test_a_pattern_is_ours_to_expand(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("b.csv", "a.csv"):
        (here / name).write_bytes(b"")
    words = ["pull", "*.csv", "--names", "{vacuum}_*", "sim:choi2018?speed=0", "none-*.csv"]
    assert command_line._expand_patterns(words) == ["pull", "a.csv", "b.csv", *words[2:]]
    monkeypatch.setattr(system, "WINDOWS", False)
    assert command_line._expand_patterns(words) == words


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "bom"])
def test_files_of_windows_programs_say_the_same(mark: bytes, here: Path) -> None:
    assert main(("new", "mine", "--from", BRAKE, "--out", "mine.toml")) == 0
    text = (here / "mine.toml").read_bytes()
    assert b"\r" not in text
    (here / "theirs.toml").write_bytes(mark + text.replace(b"\n", b"\r\n"))
    assert load(here / "theirs.toml").brake == load(here / "mine.toml").brake
    rows = "".join(f"{0.1 * i:.2f};{2 * i:.2f}\r\n" for i in range(40))
    (here / "p.csv").write_bytes(f"Prüfung\r\nWeg [mm];Kraft [N]\r\n{rows}".encode("cp1252"))
    (here / "p.csv.toml").write_bytes(mark + b'vacuum = "50 kPa"\r\nspeed = "1 mm/s"\r\n')
    trace = read_trace(here / "p.csv")
    assert len(trace.force) == 40 and abs(trace.force[-1] - 78.0) < 1e-9


def test_drive_letters_are_no_schemes() -> None:
    at = r"C:\lab\records.db"
    assert database_url(at).database == at and address_of("serial:COM12").where == "COM12"


def test_a_compilers_path_keeps_its_backslashes(monkeypatch: pytest.MonkeyPatch) -> None:
    text = r'"C:\Program Files\LLVM\bin\clang.exe" -O2'
    with monkeypatch.context() as patch:
        patch.setattr(os, "name", "nt")
        words = compiler._split_command(text)
    assert words == [r"C:\Program Files\LLVM\bin\clang.exe", "-O2"]


def test_why_a_port_does_not_open() -> None:
    said = OSError("could not open port 'COM3': PermissionError(13, 'Access is denied.', None, 5)")
    assert _describe_error(said) == "Access is denied"
    assert _describe_error(OSError(2, "could not open port /dev/x: ...")) == os.strerror(2)


def test_enter_is_asked_of_the_console(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = list("ab\r")
    fake = types.SimpleNamespace(kbhit=lambda: bool(keys), getwch=lambda: keys.pop(0))
    monkeypatch.setitem(sys.modules, "msvcrt", fake)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys, "stdin", types.SimpleNamespace(isatty=lambda: True))
    assert crosshead._is_enter_pressed() and not crosshead._is_enter_pressed()


def test_a_board_of_sockets(here: Path) -> None:
    line, board = connect("sim:choi2018?speed=0")
    assert board is not None and board.name == "CPython"
    ask = line.ask
    assert ask(1, b"OUTP:SAFE REL;VENT:REST OPEN;:SYST:LEAS 600") == b""
    boot = ask(1, b"SYST:BOOT?")
    ask(1, b"SYST:RES", tries=1)
    for _ in range(1000):
        if (now := ask(1, b"SYST:BOOT?")) != boot:
            break
    assert b"SOFT" in now and ask(1, b"SYST:ERR?").startswith(b"0,")
    process = board._child.process
    line.close()
    assert process.poll() == 0
    with pytest.raises(QuantityError, match="python=micropython needs pipes"):
        connect("sim:choi2018?python=micropython")


def test_a_board_that_does_not_call_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(child, "PATIENCE", 0.3)
    with pytest.raises(LineError, match="did not start"):
        child._use_sockets([sys.executable, "-c", "pass"], [], lambda: None)


@pytest.mark.slow
def test_the_main_job(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    console = Console(monkeypatch, "cp437")
    run = ("bench", "run", "sim:choi2018?speed=0", "--procedure", "evacuate to 40 kPa; vent",
           "--brake", BRAKE, "--line", "choi2018", "--safe-state", "release", "--vent-rest", "open",
           "--sensor-range", "103kPa", "--out", "run.ljrun")  # fmt: skip
    pulls = "practice/pull_choi2018-kapton_40kPa_*mms_1.*"
    force = ("force", BRAKE, "--slip", "20mm", "--vacuum", "50kPa", "--figure", "x.svg")
    for words in (
        ("lab", "practice", "--out", "practice"),
        ("calibrate", BRAKE, pulls, "--out", "fit.toml"),
        ("validate", "fit.toml", pulls),
        ("report", BRAKE, "--pulls", "practice/pull_choi2018-kapton_40kPa_19mms_1.csv",
         "--out", "report"),
        force, (*force, "--overwrite"),
        run,
        ("bench", "export", "run.ljrun", "--out", "run.csv"),
        ("publish", "campaign", "--brake", BRAKE, "--out", "dataset"),
        ("publish", "campaign", "--brake", BRAKE, "--out", "dataset", "--overwrite"),
        ("recompute", "dataset"),
        ("build", BRAKE, "--out", "made", "--no-step"),
        ("records", "add", "fit.toml", "--db", "lab.db"),
        ("records", "verify", "--db", "lab.db"),
    ):  # fmt: skip
        if words[0] == "publish" and not (here / "campaign").exists():
            (here / "campaign").mkdir()
            for file in here.glob("practice/*_40kPa_19mms_1.*"):
                shutil.copy(file, here / "campaign")
        monkeypatch.setattr(sys, "argv", ["layerjam", *words])
        code = main()
        out, err = console.said()
        assert code in ((0,) if words[0] == "recompute" else (0, 1, 3)), (words, out, err)
        assert "Traceback" not in err and out
    written = [p for p in here.rglob("*") if p.is_file() and p.suffix in {".csv", ".toml", ".svg"}]
    assert len(written) > 20
    assert not any(b"\r\r\n" in p.read_bytes() for p in written)
