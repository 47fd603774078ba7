"""What people see: tables that fit, help, completion, and the program as a process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from layerjam._version import __version__

from .conftest import Files, Run

pytestmark = pytest.mark.timing

KAPTON = "choi2018-kapton"
COMMANDS = ("new", "show", "force", "vacuum", "tensile", "friction", "calibrate", "validate",
            "reproduce")  # fmt: skip


def lines_of(command: str, files: Files, run: Run, tmp_path: Path) -> list[str]:
    words: dict[str, tuple[object, ...]] = {
        "show": ("show", "choi2018-polyester"),
        "force": ("force", KAPTON, "--slip", "64mm", "--vacuum", "94.5kPa"),
        "vacuum": ("vacuum", KAPTON, "--slip", "20mm", "--force", "400N"),
        "tensile": ("tensile", KAPTON, "--procedure",
                    "evacuate to 94.5 kPa and hold 5 s; cycle 9 times between 10 mm and 20 mm "
                    "at 13 mm/s".replace("cycle", "pull at 13 mm/s until 10 mm; cycle")),
        "friction": ("friction", *files.friction, "--normal-force", "2.45N"),
        "calibrate": ("calibrate", KAPTON, *files.pulls),
        "validate": ("validate", KAPTON, *files.validation),
        "new": ("new", "mine", "--from", KAPTON, "--out", tmp_path / "mine.toml"),
    }  # fmt: skip
    ran = run(*words[command])
    assert ran.err == ""
    return ran.out.splitlines()


@pytest.mark.parametrize("command", COMMANDS[:-1])
@pytest.mark.parametrize("columns", [pytest.param(80, marks=pytest.mark.slow), 60])
def test_tables_fit(
    run: Run, files: Files, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str,
    columns: int,
) -> None:  # fmt: skip
    monkeypatch.setenv("COLUMNS", str(columns))
    lines = lines_of(command, files, run, tmp_path)
    assert len(lines) > 1
    long = [line for line in lines if len(line) > columns]
    # a path is never broken, so that it can be copied
    ends = [line.split()[-1] for line in long]
    assert all(os.sep in end and len(end) > columns - 8 for end in ends), long
    assert not any("\t" in line or line != line.rstrip() for line in lines)


def test_people_see_units_and_the_numbers_of_the_json(run: Run) -> None:
    words = ("force", KAPTON, "--slip", "20mm", "--vacuum", "94.5kPa")
    shown = run(*words).out
    assert "force            133.9 N" in shown and "enclosure force  10.11 N" in shown
    shown = run("show", KAPTON).out
    for text in ("20 g", "808.1 kN/m", "131 kN/m", "60 mm", "7.032 J", "kN/kg"):
        assert text in shown, text
    assert "2.047 MN/m" in shown or "2047 kN/m" in shown
    assert "sources of the numbers" in shown and "section III-D" in shown


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself(run: Run, command: str) -> None:
    ran = run(command, "--help")
    assert ran.code == 0 and ran.err == "" and "--json" in ran.out
    assert run(command, "-h").out == ran.out


def test_help_lists_the_commands(run: Run) -> None:
    ran = run("help", "all")
    assert ran.code == 0 and all(f" {command} " in ran.out for command in COMMANDS)


def test_version(run: Run) -> None:
    ran = run("--version")
    assert (ran.code, ran.out, ran.err) == (0, f"layerjam {__version__}\n", "")


def program(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [str(Path(sys.executable).parent / "layerjam"), *words],
        capture_output=True, text=True, timeout=120, check=False,
        env={**os.environ, "PYTHONWARNINGS": "error", **environment},
    )  # fmt: skip


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell"])
def test_completion_scripts_print(shell: str) -> None:
    done = program("--show-completion", shell)
    assert done.returncode == 0 and "layerjam" in done.stdout and "COMPLETE" in done.stdout
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("shell", ["bash", pytest.param("zsh", marks=pytest.mark.slow), "fish"])
def test_completion_is_installed_once(shell: str, tmp_path: Path) -> None:
    own = "alias ll='ls -l'"  # without a line end
    (tmp_path / ".bashrc").write_text(own)
    for _ in range(2):
        done = program("--install-completion", HOME=str(tmp_path), SHELL=f"/bin/{shell}")
        assert done.returncode == 0 and str(tmp_path) in done.stdout
    files = {p.name: p.read_text() for p in tmp_path.rglob("*") if p.is_file()}
    assert sum("_LAYERJAM_COMPLETE" in text for text in files.values()) == 1
    for name, text in files.items():
        lines = text.splitlines()
        assert len(set(lines)) == len(lines) or not name.endswith("rc"), "each line once"
    assert files[".bashrc"].splitlines()[0] == own
    done = program("--install-completion", "tcsh", HOME=str(tmp_path))
    assert done.returncode == 2 and "bash, zsh, fish" in done.stderr
    done = program("--install-completion", "powershell", HOME=str(tmp_path), PATH=str(tmp_path))
    assert done.returncode == 2 and "does not name its profile" in done.stderr
    (tmp_path / "file").touch()
    done = program("--install-completion", shell, HOME=str(tmp_path / "file"))
    assert done.returncode == 2 and "cannot be written" in done.stderr
    assert "Traceback" not in done.stderr


def test_completion_knows_the_commands() -> None:
    done = program(_LAYERJAM_COMPLETE="bash_complete", COMP_WORDS="layerjam ten", COMP_CWORD="1")
    assert done.stdout.split() == ["plain,tensile"]


def test_as_a_process() -> None:
    words = ("force", KAPTON, "--slip", "20mm", "--vacuum", "94.5kPa", "--json")
    done = program(*words)
    assert done.returncode == 0 and done.stderr == ""
    assert done.stdout.startswith("{") and done.stdout.endswith("}\n")
    assert '"force": 133.942755' in done.stdout
    module = subprocess.run(
        [sys.executable, "-m", "layerjam.cli.main", *words],
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert module.stdout == done.stdout


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (("vacuum", KAPTON, "--slip", "20mm", "--force", "400N"), 1),
        (("force", KAPTON, "--slip", "20", "--vacuum", "94.5kPa"), 2),
    ],
)
def test_exit_codes_of_the_process(words: tuple[str, ...], code: int) -> None:
    done = program(*words)
    assert done.returncode == code
    assert "Traceback" not in done.stderr and done.stderr.count("\n") == (1 if code == 2 else 0)


def test_a_pipe_that_closes_is_no_error() -> None:
    for words, code in ((f"show {KAPTON}", 0),
                        (f"vacuum {KAPTON} --slip 20mm --force 400N", 1)):  # fmt: skip
        reading, writing = os.pipe()
        process = subprocess.Popen(
            [str(Path(sys.executable).parent / "layerjam"), *words.split()],
            stdout=writing, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        os.close(writing)
        os.close(reading)  # long before the first line is printed
        error = process.communicate(timeout=120)[1]
        assert (process.returncode, error) == (code, "")


def test_a_cache_nobody_may_write_does_not_matter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("JAX_COMPILATION_CACHE_DIR")
    (tmp_path / "cache").write_text("a file where a folder is due")
    done = program(
        "force", KAPTON, "--slip", "20mm", "--vacuum", "94.5kPa", "--json",
        XDG_CACHE_HOME=str(tmp_path / "cache"), HOME=str(tmp_path),
    )  # fmt: skip
    assert done.returncode == 0 and done.stderr == "" and "133.9427" in done.stdout
