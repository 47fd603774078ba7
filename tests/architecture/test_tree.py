"""What holds for every file of the tree: size, style, types, no host, no machine's path."""

from __future__ import annotations

import ast
import functools
import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import layerjam

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent
LARGEST = 450
SCREEN = 70
USER = Path(__file__).with_name("typed_user.py")
SCRIPT = """
import layerjam as lj

stop = lj.drop("choi2018-kapton", mass="1 kg", speed=2.5, vacuum="tuned", travel="40 mm")
reveal_type(stop)
reveal_type(stop.peak_force)
reveal_type(lj.force("choi2018-kapton", slip=[0.0, 0.02], vacuum="90 kPa").force)
reveal_type(lj.load("choi2018-kapton").brake.sheets.width)
reveal_type(lj.load("choi2018-kapton").with_(width="14 mm"))
reveal_type(stop.warnings)
reveal_type(stop.plot())
lj.drop("choi2018-kapton", mass=1, speed=2, vacuum=9e4, sensing=lj.Sensing(low_pass="400 Hz"))
lj.drop("choi2018-kapton", mass=[1.0], speed=2.5)
lj.drop("choi2018-kapton", weight="1 kg")
stop.peak_farce
"""
REVEALED = (
    "layerjam._StopResult",
    "float | None",
    "Any",
    "float",
    "layerjam.brake.device.brake_file.BrakeFile",
    "Sequence[layerjam.core.errors.Notice]",
    "matplotlib.figure.Figure",
)
WRONG = ("[arg-type]", "[call-arg]", "[attr-defined]")


@functools.cache
def tracked() -> list[Path]:
    """Files git knows or would take; all files where there is no git."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip("not a git checkout")
    found = [ROOT / name for name in done.stdout.split("\0") if name]
    return [path for path in found if path.is_file()]


def texts() -> dict[str, str]:
    out = {}
    for path in tracked():
        try:
            out[str(path.relative_to(ROOT))] = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
    return out


def test_no_file_is_too_long() -> None:
    names = [p for p in tracked() if p.suffix in (".py", ".j2") and p.parts[-1] != "lock"]
    assert len(names) > 60
    long = {str(p): n for p in names if (n := len(p.read_text("utf-8").splitlines())) > LARGEST}
    assert long == {}


def test_every_function_fits_a_screen() -> None:
    long = [
        f"{path.relative_to(ROOT)}: {node.name} has {lines}"
        for path in sorted((ROOT / "src").rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (lines := node.end_lineno - node.lineno + 1) > SCREEN  # type: ignore[operator]
    ]
    assert not long, long


def test_no_registry_host_and_no_path_of_one_machine() -> None:
    here = Path(__file__).relative_to(ROOT).as_posix()
    bad = re.compile(
        r"pypi\.org|pythonhosted|find-links|--index-url|extra-index|//[a-z0-9.-]*(?:artifactory|nexus|"
        r"devpi|mirror)|(?<![\w.])/(?:work|root|opt|home/\w+|Users/\w+)/"
    )
    allowed = ("--no-emit-find-links", "--no-emit-index-url")
    found = []
    for name, text in texts().items():
        if name == here:
            continue
        for number, line in enumerate(text.splitlines(), 1):
            plain = line
            for word in allowed:
                plain = plain.replace(word, "")
            if match := bad.search(plain):
                found.append(f"{name}:{number}: {match.group()}")
    assert found == []


LOCKS = (
    "requirements.lock",
    "tests/install/requirements.lock",
    "tests/interop/requirements.lock",
    "tests/bench/rig/checks/requirements.lock",
)


@pytest.mark.parametrize("name", LOCKS)
def test_the_lock_names_hashes_and_no_address(name: str) -> None:
    lock = (ROOT / name).read_text(encoding="utf-8")
    assert "://" not in lock and "@ " not in lock and "file:" not in lock
    wanted = re.findall(r"^[a-zA-Z0-9_.-]+==[^ ;\\]+", lock, re.MULTILINE)
    assert len(wanted) > 20 and len(wanted) == len(set(wanted))
    blocks = re.split(r"^(?=[a-zA-Z0-9])", lock, flags=re.MULTILINE)
    for block in (b for b in blocks if "==" in b.split("\n")[0]):
        assert re.search(r"--hash=sha256:[0-9a-f]{64}", block), block[:80]


def test_every_dependency_is_in_a_lock() -> None:
    """What only `make interop` or `make bench-checks` wants is in the lock of that target."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lock = "\n".join((ROOT / name).read_text(encoding="utf-8").lower() for name in LOCKS)
    asked = list(project["dependencies"])
    for extra in project["optional-dependencies"].values():
        asked += extra
    for line in asked:
        name = re.split(r"[\[<>=!~ ;]", line)[0].lower()
        if name == "layerjam":
            continue
        assert re.search(rf"^{re.escape(name)}==", lock, re.MULTILINE), name


@pytest.mark.parametrize(
    "command",
    [["ruff", "check", "src", "tests"], ["ruff", "format", "--check", "src", "tests"]],
    ids=["check", "format"],
)
def test_ruff(command: list[str]) -> None:
    done = subprocess.run(
        [str(BIN / command[0]), *command[1:], "--no-cache"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr


@pytest.mark.slow
def test_the_tree_and_a_users_script_are_typed(tmp_path: Path) -> None:
    """One run of mypy for both, for most of its time goes into reading the tree."""
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len(blocks) == 2
    (tmp_path / "readme.py").write_text("\n".join(blocks), encoding="utf-8")
    assert (ROOT / "src" / "layerjam" / "py.typed").is_file()
    done = subprocess.run(
        [str(BIN / "mypy"), "--cache-dir", str(ROOT / ".mypy_cache"),
         "src/layerjam", str(USER), str(tmp_path / "script.py"), str(tmp_path / "readme.py")],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    lines = done.stdout.splitlines()
    of_script = [line for line in lines if "script.py:" in line]
    notes = [line for line in of_script if "Revealed type" in line]
    errors = [line for line in of_script if "error:" in line]
    for found, due in ((notes, REVEALED), (errors, WRONG)):
        assert len(found) == len(due), done.stdout[-3000:] + done.stderr
        for line, expected in zip(found, due, strict=True):
            assert expected in line, line
    of_tree = [line for line in lines[:-1] if line not in of_script]
    assert of_tree == [], done.stdout[-3000:]
    assert lines[-1].startswith(f"Found {len(WRONG)} errors in 1 file"), lines[-1]


def test_the_users_code_names_everything() -> None:
    """Names of an attribute of `lj` in the code that both type checkers read."""
    used = {
        node.attr
        for node in ast.walk(ast.parse(USER.read_text(encoding="utf-8")))
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "lj"
    }
    assert set(dir(layerjam)) - used == {"__version__"}


@pytest.mark.slow
def test_pyright_reads_the_users_code(tmp_path: Path) -> None:
    """In its strict mode; `make lint` does not install pyright, for it is a program of Node."""
    pyright = shutil.which("pyright")
    if pyright is None:
        pytest.skip("pyright is not installed: pip install pyright")
    settings = {"extraPaths": [str(ROOT / "src")], "typeCheckingMode": "strict"}
    settings |= {"venvPath": str(BIN.parents[1]), "venv": BIN.parent.name}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings), encoding="utf-8")
    shutil.copy(USER, tmp_path)
    done = subprocess.run([pyright], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "0 errors" in done.stdout, done.stdout[-3000:] + done.stderr


def test_warnings_are_errors_for_every_test() -> None:
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    assert tools["pytest"]["ini_options"]["filterwarnings"] == ["error"]
    assert tools["mypy"]["strict"] is True
    lax = [
        one for one in tools["mypy"]["overrides"] if "layerjam.core.command" in str(one["module"])
    ]
    assert not lax  # the bodies of the commands are checked in full
    assert tools["ruff"]["line-length"] == 100
