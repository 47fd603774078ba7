"""Record of which quick test executes which line, for `tests/mutants.py`; also a pytest plugin.

The context of a line is a test, or a fixture that several tests share: all its tests depend on its
lines, although only the first of them executes these. Lines in other processes are not recorded.
"""

from __future__ import annotations

import ast
import difflib
import functools
import hashlib
import json
import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import coverage
import pytest

from mutant_draw import FOLDERS, ROOT, SOURCE, Mutant, read_sources

STORE = ROOT / "out" / "mutants"
"""Folder of records, one of each run of tests; later ones replace earlier ones of a test file."""
QUICK = ("-m", "not slow and not timing", "-o", "xfail_strict=false")
LEFT_OUT = ("tests/architecture", "tests/install", "tests/windows")
"""Folders of tests that read the source as text, or install it."""
COMPARERS = (
    "tests/brake/kernel/test_stack_loops.py::test_the_loops_in_c_are_those_of_python",
    "tests/brake/kernel/test_kernel.py::test_the_formulas_are_those_of_the_laws",
    "tests/bench/control/test_c_program.py::test_the_file_is_what_the_sources_print",
    "tests/brake/kernel/test_web.py",
    "tests/brake/kernel/test_shipped.py",
)
"""Tests that compare text or digests of sources."""
CONSTANTS = "tests/recorded/test_recorded.py::test_a_command_answers_as_recorded[constants]"
"""Test of what modules compute when imported; such lines are recorded for whoever imports first."""
PLACE = "LAYERJAM_MUTANT_MAP"
"""Environment variable: the folder of the record that a run of tests makes."""
WRAPPERS = {
    "brake/kernel/c/loops/": "bench/control/engine.py",
    "brake/kernel/c/shading/": "workshop/figures/picture_loops.py",
    "brake/kernel/c/stack": "brake/kernel/stack.py",
    "brake/kernel/c/": "brake/kernel/kernel.py",
}
"""Python modules whose tests execute the C files with these beginnings."""

IN_C = {
    "brake/mechanics/stack/": "brake/kernel/stack.py",
    "bench/control/": "bench/control/engine.py",
    "brake/mechanics/": "brake/kernel/kernel.py",
}
"""Modules whose tests execute what is printed as C from the Python files with these beginnings."""


class Recorder:
    """Lines, durations and shared fixtures of the tests of one process."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.name = folder, f"{os.getpid()}-{uuid.uuid4().hex[:8]}"
        self.cover = coverage.Coverage(
            data_file=folder / f"part.{self.name}", source=[str(SOURCE)], config_file=False
        )
        self.cover.set_option("run:disable_warnings", ["trace-changed", "no-data-collected"])
        self.context = ""
        self.seconds: dict[str, float] = {}
        self.fixtures: dict[str, list[str]] = {}
        self.failed: set[str] = set()
        self.cover.start()

    def enter(self, context: str) -> str:
        """Record the lines for a context from now on; return the one before."""
        before, self.context = self.context, context
        self.cover.switch_context(context)
        return before

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        self.enter(item.nodeid)
        began = sum(os.times()[:4])  # of processor time, whatever else the machine does
        result = yield
        self.seconds[item.nodeid] = sum(os.times()[:4]) - began
        self.enter("")
        known = getattr(item, "_fixtureinfo", None)
        chains = [] if known is None else known.name2fixturedefs.values()
        self.fixtures[item.nodeid] = [name(one) for chain in chains for one in chain if shared(one)]
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[object]
    ) -> Generator[None, object, object]:
        before = self.enter(name(fixturedef)) if shared(fixturedef) else None
        try:
            return (yield)
        finally:
            if before is not None:
                self.enter(before)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.outcome != "passed":
            self.failed.add(report.nodeid)

    def pytest_sessionfinish(self) -> None:
        self.cover.stop()
        self.cover.save()
        tests = {
            test: {"seconds": round(self.seconds[test], 3), "fixtures": fixtures}
            for test, fixtures in self.fixtures.items()
            if test not in self.failed and not test.startswith(COMPARERS)
        }
        (self.folder / f"tests.{self.name}.json").write_text(json.dumps(tests), encoding="utf-8")


def shared(fixture: pytest.FixtureDef[object]) -> bool:
    return fixture.scope != "function"


def name(fixture: pytest.FixtureDef[object]) -> str:
    return f"fixture {fixture.baseid}::{fixture.argname}"


def pytest_configure(config: pytest.Config) -> None:
    if PLACE in os.environ:
        config.pluginmanager.register(Recorder(Path(os.environ[PLACE])), "mutant-recorder")


def digest_tests() -> dict[str, str]:
    """Return the digest of each file of tests, with the other files of its folder."""
    paths = sorted((ROOT / "tests").rglob("test_*.py"))
    files = {path.relative_to(ROOT).as_posix(): path for path in paths}
    return {
        file: hashlib.sha256(path.read_bytes() + helpers(path.parent)).hexdigest()
        for file, path in files.items()
        if not file.startswith(LEFT_OUT)
    }


@functools.cache
def helpers(folder: Path) -> bytes:
    """Return the content of the files in a folder that tests share."""
    if folder == ROOT / "tests":
        return b""
    kinds = (path for kind in ("*.py", "*.json") for path in sorted(folder.glob(kind)))
    return b"".join(path.read_bytes() for path in kinds if not path.name.startswith("test_"))


def record(paths: Sequence[str], jobs: int) -> None:
    """Run the tests in some files and folders, and store a record of them."""
    folder = STORE / f"unfinished-{os.getpid()}"
    folder.mkdir(parents=True)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "mutant_map", *QUICK]
    command += ["-n", str(jobs), "--dist", "worksteal"] if jobs > 1 else []
    command += [*paths, *(f"--ignore={one}" for one in LEFT_OUT)]
    places = {PLACE: str(folder), "PYTHONPATH": str(ROOT / "tests")}
    signal.signal(signal.SIGINT, signal.default_int_handler)  # else tests of Ctrl-C wait for ever
    with (STORE / "record.txt").open("w", encoding="utf-8") as log:
        subprocess.run(command, cwd=ROOT, env=os.environ | places, stdout=log, check=False)
    seal(folder, [f for f in digest_tests() if any(Path(f).is_relative_to(p) for p in paths)])
    number = 1 + max((int(path.name) for path in STORE.glob("[0-9]*")), default=0)
    folder.rename(STORE / str(number))


def seal(folder: Path, files: Iterable[str]) -> None:
    """Join the parts of a record, and add the sources and test files that it belongs to."""
    data = coverage.CoverageData(basename=str(folder / "lines"))
    for path in folder.glob("part.*"):
        part = coverage.CoverageData(basename=str(path))
        part.read()
        data.update(part)
        path.unlink()
    data.write()
    digests = digest_tests()
    known = {"sources": read_sources(), "files": {file: digests[file] for file in files}}
    (folder / "known.json").write_text(json.dumps(known), encoding="utf-8")


@dataclass(eq=False)
class Record:
    """One run of tests: its sources, its tests and the lines that each of them executed."""

    folder: Path
    sources: dict[str, str] = field(init=False)
    files: dict[str, str] = field(init=False)
    seconds: dict[str, float] = field(default_factory=dict)
    users: dict[str, set[str]] = field(default_factory=dict)
    """{fixture: tests that use it}"""

    def __post_init__(self) -> None:
        known = json.loads((self.folder / "known.json").read_text("utf-8"))
        self.sources, self.files = known["sources"], known["files"]
        self.data = coverage.CoverageData(basename=str(self.folder / "lines"))
        self.data.read()
        for path in self.folder.glob("tests.*.json"):
            for test, facts in json.loads(path.read_text("utf-8")).items():
                self.seconds[test] = facts["seconds"]
                for fixture in facts["fixtures"]:
                    self.users.setdefault(fixture, set()).add(test)

    def expand(self, contexts: Iterable[str]) -> set[str]:
        """Return the tests of some contexts."""
        tests: set[str] = set()
        for context in contexts:
            tests |= self.users.get(context, {context} if context in self.seconds else set())
        return tests

    @functools.cache  # noqa: B019
    def lines(self, file: str) -> dict[int, set[str]]:
        """Return the tests of each line of a file."""
        found = self.data.contexts_by_lineno(str(SOURCE / file))
        return {line: self.expand(contexts) for line, contexts in found.items()}

    @functools.cache  # noqa: B019
    def old_lines(self, file: str, source: str) -> dict[int, int]:
        """Return {line of a source: the same line of the recorded one}."""
        old = self.sources.get(file, "").splitlines()
        match = difflib.SequenceMatcher(None, source.splitlines(), old, autojunk=False)
        blocks = match.get_matching_blocks()
        return {a + i + 1: b + i + 1 for a, b, size in blocks for i in range(size)}

    def tests_of(self, mutant: Mutant, source: str) -> tuple[set[str], set[str]]:
        """Return the tests that execute a changed statement, and those that execute its file."""
        if not mutant.file.endswith(".py"):
            wrapper = wrapper_of(mutant.file)
            return set().union(*self.lines(wrapper).values()), set()
        every = self.lines(mutant.file)
        old = self.old_lines(mutant.file, source)
        first, last = mutant.statement
        numbers = {first, *range(max(first, mutant.line), last + 1), mutant.line}
        numbers |= import_lines(source).get(first, set())  # of a default: who calls the function
        direct = set().union(*(every.get(old.get(number, 0), set()) for number in numbers))
        printed = next((p for start, p in IN_C.items() if mutant.file.startswith(start)), "")
        in_c = set().union(*self.lines(printed).values()) if printed else set()
        if not direct:
            direct, in_c = in_c, set()
        return direct, set().union(in_c, *every.values()) - direct


@functools.cache
def import_lines(source: str) -> dict[int, set[int]]:
    """Return {first line of a statement that runs at import: lines of its body, of a function}."""
    found: dict[int, set[int]] = {}

    def add(statements: Sequence[ast.stmt]) -> None:
        for one in statements:
            is_function = isinstance(one, ast.FunctionDef)
            body = range(one.body[0].lineno, (one.end_lineno or 0) + 1) if is_function else ()
            found[one.lineno] = set(body)
            if isinstance(one, ast.ClassDef):
                add(one.body)

    add(ast.parse(source).body)
    return found


def wrapper_of(file: str) -> str:
    """Return the Python file whose tests execute a file."""
    return next((module for start, module in WRAPPERS.items() if file.startswith(start)), file)


@dataclass
class Map:
    """All records, of which later ones replace earlier ones of the same test file."""

    records: list[Record] = field(default_factory=list)

    @classmethod
    def read(cls) -> Map:
        folders = sorted(STORE.glob("[0-9]*"), key=lambda path: int(path.name))
        return cls([Record(folder) for folder in folders])

    def new_files(self) -> list[str]:
        """Return the test files that no record has as they are now."""
        known: dict[str, str] = {}
        for one in self.records:
            known |= one.files
        return [file for file, digest in digest_tests().items() if known.get(file) != digest]

    def tests_of(self, mutant: Mutant, source: str, most: float, extra: float) -> dict[str, float]:
        """Return tests and their durations [s]: nearest and fastest first, at most so many seconds.

        Up to `extra` seconds are for tests that execute other lines of the file: a line that runs
        only while JAX traces, or before a cache has its result, is recorded for one test alone.
        """
        near, far, seconds = set[str](), set[str](), dict[str, float]()
        replaced: set[str] = set()
        for one in reversed(self.records):
            direct, other = one.tests_of(mutant, source)
            valid = {test for test in one.seconds if test.partition("::")[0] not in replaced}
            if mutant.file.endswith(".py") and mutant.statement[0] in import_lines(source):
                direct = direct | {CONSTANTS}
            near |= direct & valid
            far |= other & valid
            seconds |= {test: one.seconds[test] + 0.02 for test in (direct | other) & valid}
            replaced |= set(one.files)
        chosen = take(sorted(near, key=lambda test: distance(test, mutant, seconds)), seconds, most)
        left = min(extra, most - sum(seconds[test] for test in chosen))
        chosen += take(sorted(far, key=lambda test: distance(test, mutant, seconds)), seconds, left)
        files = dict.fromkeys(test.partition("::")[0] for test in chosen)
        order = {file: number for number, file in enumerate(files)}
        chosen.sort(key=lambda test: order[test.partition("::")[0]])  # share imports and fixtures
        return {test: seconds[test] for test in chosen}


def take(tests: Sequence[str], seconds: dict[str, float], most: float) -> list[str]:
    chosen = []
    for test in tests:
        if seconds[test] <= most:
            chosen.append(test)
            most -= seconds[test]
    return chosen


def distance(test: str, mutant: Mutant, seconds: dict[str, float]) -> tuple[int, int, float]:
    """Return 0 for tests of the same folder, 1 for those of the same wing, 2 for others; names.

    Recorded numbers are as near as tests of the same folder: they are cheap and notice most.
    """
    place = Path(wrapper_of(mutant.file))
    path = Path(test.partition("::")[0].removeprefix("tests/"))
    folder = next((one for one in FOLDERS if place.as_posix().startswith(one)), place.parent)
    is_near = path.is_relative_to(folder) or path.parts[0] == "recorded"
    far = 0 if is_near else 2 - (path.parts[0] == place.parts[0])
    shares = bool(set(path.stem.split("_")) & set(place.stem.split("_")))
    return far, not shares, seconds[test]
