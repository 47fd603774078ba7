"""Libraries that came with layerjam, are compiled here, or are missing."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from layerjam.brake.kernel import compiler, library
from layerjam.brake.kernel.compiler import KERNEL, LIBRARIES, LOOPS, TARGETS, find_on_path
from layerjam.brake.kernel.library import SWITCH, open_library, open_library_if_possible
from layerjam.core.errors import CompilerError, QuantityError
from layerjam.core.installation import install_command

ROOT = Path(__file__).parents[3]
MACHINE = (sys.platform, compiler.platform.machine())
pytestmark = pytest.mark.skipif(find_on_path() is None, reason="there is no C compiler here")


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine with neither compiler nor cache; its folder is for libraries of a wheel."""
    monkeypatch.setattr(compiler, "SHIPPED", tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.delenv(SWITCH, raising=False)
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(library, "_open_once", open_library)
    return tmp_path


@pytest.mark.parametrize("sources", LIBRARIES, ids=lambda sources: sources[0].stem)
def test_what_came_in_a_wheel_needs_no_compiler(
    sources: Sequence[Path], tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    path = tmp_path / compiler.engine_name(sources, (), MACHINE)
    command = [*(find_on_path() or ()), *compiler.FLAGS, "-shared", "-fPIC", "-o", str(path)]
    subprocess.run([*command, *map(str, sources), "-lm"], check=True)
    request.getfixturevalue("bare")
    assert open_library(sources)._name == str(path)


def test_a_damaged_one_is_compiled_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiler, "SHIPPED", tmp_path)
    (tmp_path / compiler.engine_name(LOOPS, (), MACHINE)).write_bytes(b"damaged")
    assert not open_library(LOOPS)._name.startswith(str(tmp_path))


def test_without_either_the_reason_is_printed(
    bare: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(CompilerError, match="no C compiler found"):
        open_library(LOOPS)
    assert open_library_if_possible(LOOPS, "tests run") is None
    assert capsys.readouterr().err == (
        "layerjam: tests run in Python, many times slower than in C: no C compiler found: install "
        f"gcc or clang, or {install_command('fmu')}\n"
    )


def test_an_unknown_setting_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SWITCH, "maybe")
    with pytest.raises(QuantityError, match="'maybe' is not allowed"):
        open_library_if_possible(LOOPS, "tests run")


def test_each_library_has_a_file_for_each_machine() -> None:
    names = [compiler.engine_name(s, (), machine) for s in LIBRARIES for machine in TARGETS]
    assert len(set(names)) == len(LIBRARIES) * len(TARGETS)
    assert LIBRARIES[0] == KERNEL


def test_the_build_hook_imports_what_exists() -> None:
    """The hook runs only in a build with ziglang, which the tests do not make."""
    tree = ast.parse((ROOT / "hatch_build.py").read_text("utf-8"))
    names = [
        alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == compiler.__name__
        for alias in node.names
    ]
    assert names
    assert all(hasattr(compiler, name) for name in names)
