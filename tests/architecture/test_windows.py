"""Nothing on a user's path needs POSIX: held by reading the source, since no Windows is here."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "layerjam"
FILES = [p for p in sorted(SOURCE.rglob("*.py")) if "firmware" not in p.parts]
MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}
CALLS = {
    "os.chown", "os.fchmod", "os.fork", "os.getuid", "os.kill", "os.killpg", "os.mkfifo",
    "os.openpty", "os.sched_getaffinity", "os.setsid", "os.symlink", "os.sysconf", "os.ttyname",
    "os.uname", "signal.SIGALRM", "signal.SIGHUP", "signal.SIGKILL", "signal.SIGUSR1",
    "signal.alarm", "signal.pause",
}  # fmt: skip
ALLOWED = {
    ("core/system.py", "fcntl"): "Windows has msvcrt",
    ("workbench/folders.py", "os.getuid"): "asked for by name first",
    ("bench/rig/serve.py", "tty"): "for --pty alone, which says that there are none",
    ("bench/rig/serve.py", "os.openpty"): "for --pty alone",
    ("bench/rig/serve.py", "os.ttyname"): "for --pty alone",
    ("brake/mechanics/compilation.py", "os.getuid"): "asked for by name first",
    ("core/threads.py", "os.sched_getaffinity"): "asked for by name first",
}
"""(file, what it uses): why that is no trouble elsewhere."""


class Found(NamedTuple):
    """What one file has of a system's own."""

    uses: set[str]
    """POSIX's own that it uses."""
    asks: bool
    """Whether it does something else on another system."""
    imports: set[str]
    """Modules that it imports at its top."""
    silent: list[int]
    """Lines that read or write a text without its encoding."""


ASKED = {"os.name", "platform.machine", "platform.system", "sys.platform"}
"""What a file asks to know the system, besides `is_windows` of system.py."""


def dotted(node: ast.AST) -> str:
    """`a.b` of an attribute of a name; empty for anything else."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return f"{node.value.id}.{node.attr}"
    return ""


def uses(node: ast.AST) -> Iterator[str]:
    """POSIX's own that a node uses."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names if alias.name in MODULES)
    elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
        yield node.module
    elif dotted(node) in CALLS:
        yield dotted(node)


def asks(node: ast.AST) -> bool:
    """Whether a node asks for the system."""
    if isinstance(node, ast.Call):
        return dotted(node.func) == "ctypes.CDLL" and "None" in map(ast.unparse, node.args[:1])
    if isinstance(node, ast.Constant):
        return str(node.value).startswith("/proc/")
    if isinstance(node, ast.Name):
        return node.id in ("is_windows", "WINDOWS")
    return dotted(node) in ASKED


def is_text(node: ast.AST) -> bool:
    """Whether a node is a call that reads or writes a file's text."""
    if not isinstance(node, ast.Call):
        return False
    function = node.func
    if isinstance(function, ast.Attribute) and function.attr in ("read_text", "write_text"):
        return True
    opens = isinstance(function, ast.Name) and function.id == "open"
    opens |= dotted(function) == "os.fdopen"
    modes = [a for a in (*node.args[1:2], *(k.value for k in node.keywords if k.arg == "mode"))]
    binary = any(isinstance(m, ast.Constant) and "b" in str(m.value) for m in modes)
    return opens and not binary


def is_silent(call: ast.Call) -> bool:
    """Whether a call of a text does not state its encoding."""
    stated = any(isinstance(a, ast.Constant) and a.value in ("utf-8", "ascii") for a in call.args)
    stated |= "encoding" in {k.arg for k in call.keywords}
    return not stated and dotted(call.func) not in ("formatter.write_text", "package.read_text")


def read(path: Path) -> Found:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    nodes = list(ast.walk(tree))
    return Found(
        uses={name for node in nodes for name in uses(node)},
        asks=any(map(asks, nodes)),
        imports={a.name for n in tree.body if isinstance(n, ast.Import) for a in n.names},
        silent=[n.lineno for n in nodes if is_text(n) and is_silent(n)],
    )


@pytest.fixture(scope="module")
def tree() -> dict[str, Found]:
    """What each file has, each read once."""
    return {path.relative_to(SOURCE).as_posix(): read(path) for path in FILES}


def test_the_page_lists_what_depends_on_the_system(tree: dict[str, Found]) -> None:
    page = (ROOT / "docs" / "contribute.md").read_text(encoding="utf-8")
    part = page.split("### What depends on the system")[1].split("\n### ")[0]
    listed = re.findall(r"^\| `([\w/]+\.py)` \|", part, re.M)
    found = {name for name, file in tree.items() if file.asks}
    assert sorted(listed) == sorted(found | {name for name, _ in ALLOWED})


def test_what_only_posix_has_is_asked_for_first(tree: dict[str, Found]) -> None:
    assert {(name, use) for name, file in tree.items() for use in file.uses} == set(ALLOWED)


def test_what_only_posix_has_is_never_imported_with_a_file(tree: dict[str, Found]) -> None:
    for name, file in tree.items():
        assert not MODULES & file.imports, name


def test_a_files_text_is_utf_8_whatever_the_machines_code_page(tree: dict[str, Found]) -> None:
    assert [f"{name}, line {line}" for name, file in tree.items() for line in file.silent] == []
