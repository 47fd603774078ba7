"""The code blocks of README and docs: found, run in order, and compared with what they show.

    python tests/docs/examples.py             check every page
    python tests/docs/examples.py --update    write what the commands and blocks print now

Kinds of block, and what is done with each:

    ```python     run; the blocks of one page share a namespace
                  after a line <!-- needs: PACKAGE --> only where that is installed
    ```text       what the python or c block before it prints
    ```console    `$ layerjam ...` lines are run, the lines below are what each prints, errors
                  included; a command that ends with another code says so: `# exit 2`
    ```sh         like console, without output; `make ...` and `pip ...` lines are not run
    ```toml       read as TOML; with title="NAME.toml" also written, and read as what it is
    ```csv        needs title="NAME"; written, and read as a measurement
    ```json       read as JSON
    ```xml        parsed
    ```c          needs title="FOLDER/NAME.c"; compiled in FOLDER with layerjam.c, and run

In shown output a line `...` stands for any number of lines. Every page runs in a folder of its
own that holds the practice files `make demo` leaves in out/demo/measurements.
"""

from __future__ import annotations

import contextlib
import importlib.util
import io
import json
import re
import shlex
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
FENCE = re.compile(r"^```([a-z]*)([^\n`]*)\n(.*?)^```[ ]*$", re.MULTILINE | re.DOTALL)
KINDS = {"python", "text", "xml", "console", "sh", "toml", "csv", "json", "diff", "c"}
NEEDS = re.compile(r"<!-- needs: ([\w.]+) -->\n\Z")
UNKNOWN = "what it prints is not known here"
"""Stands for the output of a C program where there is no compiler."""
NOT_RUN = ("make", "git", "pip", "source")


class Mismatch(AssertionError):
    """A block does not do what the page says."""


def script(path: Path) -> ModuleType:
    """A script of docs/ as a module."""
    spec = importlib.util.spec_from_file_location(f"docs_{path.stem}", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    kind: str
    title: str
    text: str
    line: int
    start: int
    """Where its text begins in the page."""
    needs: str = ""
    """A package without which a python block is not run."""


def pages() -> list[Path]:
    """Every page whose blocks are run; decisions are records, not instructions."""
    docs = [p for p in sorted((ROOT / "docs").rglob("*.md")) if "decisions" not in p.parts]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *docs]


def blocks(text: str) -> list[Block]:
    """The fenced blocks of a page; Mismatch for a kind nobody knows."""
    found = []
    for match in FENCE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        kind = match.group(1)
        if kind not in KINDS:
            raise Mismatch(f"line {line}: a block of kind '{kind}'; known are {sorted(KINDS)}")
        title = re.search(r'title="([^"]+)"', match.group(2))
        name = title.group(1) if title else ""
        needs = NEEDS.search(text[: match.start()])
        package = needs.group(1) if needs else ""
        found.append(Block(kind, name, match.group(3), line, match.start(3), package))
    if text.count("```") != 2 * len(found):
        raise Mismatch(f"{text.count('```')} fences for {len(found)} blocks")
    return found


def installed(package: str) -> bool:
    """Whether a package can be imported, and all above it."""
    parts = package.split(".")
    names = [".".join(parts[: i + 1]) for i in range(len(parts))]
    return all(importlib.util.find_spec(name) is not None for name in names)


def run_layerjam(words: list[str]) -> tuple[int, str]:
    """Exit code and everything a command prints but its progress, which a slow machine adds."""
    from layerjam.cli import generate as ticker
    from layerjam.cli.main import main

    said, patience = io.StringIO(), ticker.PATIENCE
    ticker.PATIENCE = threading.TIMEOUT_MAX
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = main(words)
    finally:
        ticker.PATIENCE = patience
    return code, said.getvalue()


def expand(words: list[str]) -> list[str]:
    """Patterns of file names, as a shell expands them."""
    out: list[str] = []
    for word in words:
        found = sorted(str(p) for p in Path().glob(word)) if "*" in word else []
        out += found or [word]
    return out


def command(line: str) -> str | None:
    """What a command line prints; None for one that is not run. Mismatch for a wrong exit code."""
    match = re.fullmatch(r"(.*?)(?:\s+#\s*exit (\d+))?", line.strip())
    assert match is not None
    words = shlex.split(match.group(1), comments=True)
    due = int(match.group(2) or 0)
    if words and words[0] in NOT_RUN:
        return None
    if not words or words[0] != "layerjam":
        raise Mismatch(f"'{line}' is no command the docs may show")
    code, said = run_layerjam(expand(words[1:]))
    if code != due:
        raise Mismatch(f"'{line}' ended with {code}, not {due}: {said}")
    return said


def same(shown: str, printed: str) -> bool:
    """Line by line; '...' stands for any number of lines."""
    pattern = "".join(
        r"(?:.*\n)*?" if line.strip() == "..." else re.escape(line.rstrip()) + r"[ ]*\n"
        for line in shown.strip("\n").split("\n")
    )
    return re.fullmatch(pattern, printed.strip("\n") + "\n") is not None


def renewed(shown: str, printed: str) -> str:
    """Shown output with its lines as they are printed now, found by their first words.

    Read the page afterwards: a sentence that goes on over several lines may lose one. Lines that
    are new between two shown ones become `...`.
    """

    def words(line: str) -> list[str]:
        return re.sub(r"[-\d.,%]+", "", line).split()[:3]

    lines, place, out = printed.strip("\n").split("\n"), 0, []
    for line in shown.strip("\n").split("\n"):
        label, starts = words(line), [words(other) for other in lines[place:]]
        if line.strip() == "...":
            out.append("...")
        elif label in starts:
            found = place + starts.index(label)
            out += (
                ["...", lines[found]] if found > place and out[-1:] != ["..."] else [lines[found]]
            )
            place = found + 1
    return "\n".join(out)


def console(text: str) -> Iterator[tuple[str, str]]:
    """(command, shown output) of a console block; a line that ends in \\ goes on."""
    current, shown = "", []
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("$ "):
            if current:
                yield current, "\n".join(shown)
            current, shown = line[2:], []
        elif current:
            shown.append(line)
        else:
            raise Mismatch(f"'{line}' stands before any command")
    yield current, "\n".join(shown)


def write_file(block: Block) -> None:
    """A titled block as a file, read back as what it claims to be."""
    from layerjam.brake.device.load import load
    from layerjam.brake.fluid.line_file import load_line
    from layerjam.laboratory.measure.readers.read import read_trace
    from layerjam.laboratory.measure.sidecar import read_facts
    from layerjam.workshop.design.specification import load_spec

    path = Path(block.title)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(block.text, encoding="utf-8")
    if block.kind == "csv":
        read_trace(path)
    elif path.suffixes[-2:] in ([".csv", ".toml"], [".TRA", ".toml"]):
        read_facts(path.with_suffix(""))
    elif "[pump]" in block.text:
        load_line(path)
    elif "objectives" in block.text:
        load_spec(path)
    else:
        load(path)


def compiled(block: Block) -> str | None:
    """What a C program prints that is compiled with the kernel beside it; None without compiler."""
    from layerjam.brake.kernel.compiler import FLAGS, find_compiler
    from layerjam.core.errors import CompilerError

    source = Path(block.title)
    source.write_text(block.text, encoding="utf-8")
    program = source.with_suffix("").absolute()
    try:
        command = [*find_compiler(), *FLAGS, "-Wall", "-Wextra", "-Werror"]
    except CompilerError:
        return None
    command += [str(source), str(source.with_name("layerjam.c")), "-lm", "-o", str(program)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise Mismatch(done.stderr)
    return subprocess.run([program], capture_output=True, text=True, check=True).stdout


class Page:
    """Runs the blocks of one page in the present folder; `text` is the page, updated if asked."""

    def __init__(self, path: Path, update: bool = False) -> None:
        self.path, self.update = path, update
        self.text = path.read_text(encoding="utf-8")
        self.namespace: dict[str, Any] = {"__name__": path.stem}
        self.printed: str | None = None
        self.edits: list[tuple[int, int, str]] = []

    def run(self) -> None:
        """All blocks in order."""
        for block in blocks(self.text):
            try:
                self.block(block)
            except Mismatch as error:
                raise Mismatch(f"{self.path.name}, block at line {block.line}: {error}") from None
        for start, end, new in reversed(self.edits):
            self.text = self.text[:start] + new + self.text[end:]

    def block(self, block: Block) -> None:
        """One block."""
        before, self.printed = self.printed, None
        if block.needs and not installed(block.needs):
            self.printed = UNKNOWN
        elif block.kind == "python":
            out = io.StringIO()
            code = compile("\n" * block.line + block.text, str(self.path), "exec")
            with contextlib.redirect_stdout(out):
                exec(code, self.namespace)
            self.printed = out.getvalue()
        elif block.kind == "text":
            if before is None:
                raise Mismatch("a text block shows what a python block before it prints")
            if before != UNKNOWN:
                self.compare(block, block.text, before, 0)
        elif block.kind == "c":
            said = compiled(block)
            self.printed = UNKNOWN if said is None else said
        elif block.kind in ("console", "sh"):
            self.shell(block)
        elif block.kind == "json":
            json.loads(block.text)
        elif block.kind == "xml":
            ElementTree.fromstring(block.text)
        elif block.kind != "diff":  # one is applied by tests/core/command/test_one_more_command.py
            if block.kind == "toml":
                tomllib.loads(block.text)
            elif not block.title:
                raise Mismatch("a csv block needs a title, the name of the file")
            if block.title:
                write_file(block)

    def shell(self, block: Block) -> None:
        """The commands of a console or sh block."""
        if block.kind == "sh":
            for line in block.text.replace("\\\n", " ").splitlines():
                if line.strip() and not line.strip().startswith("#"):
                    command(line)
            return
        cursor = 0
        for line, shown in console(block.text):
            cursor = block.text.index("$ ", cursor) + 2
            said = command(line)
            if said is not None and shown.strip():
                cursor = self.compare(block, shown, said, cursor)

    def compare(self, block: Block, shown: str, printed: str, cursor: int) -> int:
        """Mismatch unless `shown` is what was printed; with `update` the page is changed.

        `cursor` is where in the block to look for it; gives the place behind it.
        """
        shown = shown.strip("\n")
        place = block.text.index(shown, cursor)
        if same(shown, printed):
            return place + len(shown)
        if self.update and "..." not in shown.split("\n"):
            new = "\n".join(line.rstrip() for line in printed.strip("\n").split("\n"))
            start = block.start + place
            self.edits.append((start, start + len(shown), new))
            return place + len(shown)
        new = renewed(shown, printed)
        if self.update and same(new, printed):
            start = self.text.index(shown, block.start + place)
            self.edits.append((start, start + len(shown), new))
            return place + len(shown)
        raise Mismatch(f"shown:\n{shown}\nprinted:\n{printed}")


def practice_files(folder: Path) -> None:
    """What `make demo` leaves in out/demo/measurements."""
    from layerjam.cli.demo import _write_test_files

    (folder / "out" / "demo").mkdir(parents=True)
    _write_test_files(folder / "out" / "demo" / "measurements")


def main() -> None:
    """Run every page, or those named; with --update write what is printed now."""
    import os
    import shutil
    import tempfile

    import jax

    from layerjam.brake.mechanics.compilation import announce_compilation

    os.environ["COLUMNS"] = "80"
    jax.config.update("jax_enable_x64", True)
    with contextlib.redirect_stderr(io.StringIO()):
        announce_compilation()  # once per process: the pages do not show it
    named = [Path(a).resolve() for a in sys.argv[1:] if not a.startswith("-")]
    with tempfile.TemporaryDirectory() as base:
        practice_files(Path(base) / "practice")
        for number, path in enumerate(named or pages()):
            folder = Path(base) / str(number)
            shutil.copytree(Path(base) / "practice", folder)
            os.chdir(folder)
            page = Page(path, update="--update" in sys.argv)
            page.run()
            if "--update" in sys.argv:
                path.write_text(page.text, encoding="utf-8")
            print(f"{path.relative_to(ROOT)}: {len(blocks(page.text))} blocks")
            os.chdir(base)


if __name__ == "__main__":
    main()
