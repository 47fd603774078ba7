"""Nothing on a user's path needs POSIX: held by reading the source, since no Windows is here."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

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


def uses(path: Path) -> Iterator[str]:
    """POSIX's own that a file uses."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in MODULES)
        elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
            yield node.module
        elif isinstance(node, ast.Attribute) and ast.unparse(node) in CALLS:
            yield ast.unparse(node)


ASKED = {"os.name", "platform.machine", "platform.system", "sys.platform"}
"""What a file asks to know the system, besides `is_windows` of system.py."""


def asks(path: Path) -> bool:
    """Whether a file does something else on another system."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Attribute) and ast.unparse(node) in ASKED:
            return True
        if isinstance(node, ast.Call) and ast.unparse(node).startswith("ctypes.CDLL(None"):
            return True
        if isinstance(node, ast.Name) and node.id in ("is_windows", "WINDOWS"):
            return True
        if isinstance(node, ast.Constant) and str(node.value).startswith("/proc/"):
            return True
    return False


def test_the_page_lists_what_depends_on_the_system() -> None:
    page = (ROOT / "docs" / "contribute.md").read_text(encoding="utf-8")
    part = page.split("### What depends on the system")[1].split("\n### ")[0]
    listed = re.findall(r"^\| `([\w/]+\.py)` \|", part, re.M)
    found = {p.relative_to(SOURCE).as_posix() for p in FILES if asks(p)}
    assert sorted(listed) == sorted(found | {name for name, _ in ALLOWED})


def test_what_only_posix_has_is_asked_for_first() -> None:
    found = {(p.relative_to(SOURCE).as_posix(), name) for p in FILES for name in uses(p)}
    assert found == set(ALLOWED)


def test_what_only_posix_has_is_never_imported_with_a_file() -> None:
    for path in FILES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in tree.body:
            if isinstance(node, ast.Import):
                assert not MODULES & {alias.name for alias in node.names}, path


def texts(tree: ast.AST) -> Iterator[ast.Call]:
    """Calls that read or write a file's text."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        function = node.func
        if isinstance(function, ast.Attribute) and function.attr in ("read_text", "write_text"):
            yield node
        opens = isinstance(function, ast.Name) and function.id == "open"
        opens |= isinstance(function, ast.Attribute) and ast.unparse(function) == "os.fdopen"
        modes = [a for a in (*node.args[1:2], *(k.value for k in node.keywords if k.arg == "mode"))]
        binary = any(isinstance(m, ast.Constant) and "b" in str(m.value) for m in modes)
        if opens and not binary:
            yield node


def test_a_files_text_is_utf_8_whatever_the_machines_code_page() -> None:
    silent = [
        f"{path.relative_to(SOURCE)}, line {call.lineno}"
        for path in FILES
        for call in texts(ast.parse(path.read_text(encoding="utf-8")))
        if "encoding" not in {k.arg for k in call.keywords}
        and not any(
            isinstance(a, ast.Constant) and a.value in ("utf-8", "ascii") for a in call.args
        )
        and ast.unparse(call.func) not in ("formatter.write_text", "package.read_text")
    ]
    assert silent == []
