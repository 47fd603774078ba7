"""Copies of the tree, in which `tests/mutants.py` runs the tests of one mutant at a time."""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from queue import Queue
from typing import Any

import mutant_map
from mutant_draw import ROOT, Mutant

SLOWER, START = 8.0, 60.0
"""Time limit of one run: START + SLOWER times the recorded durations [s]."""
PRINTED = ("brake/mechanics/", "bench/control/")
"""Folders of Python that is printed as C."""
PRINT = """
import runpy, sys
from layerjam.brake.kernel import web
stored = next(web.FOLDER.glob("*.wasm"))
sys.path.insert(0, "tests")
try:
    {has_printed} and runpy.run_path("tests/print_c.py", run_name="__main__")
except Exception:
    pass
stored.rename(web.find_stored_module())  # else every test of the live page fails
"""
SERVER = """
import json, os, sys
import jax, numpy, pandas, pytest, scipy.optimize, scipy.stats
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        os.setsid()
        for number, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)):
            os.dup2(os.open(os.devnull if number == 0 else "output.txt", flags), number)
        os.dup2(1, 2)
        status = int(pytest.main(json.loads(line)))
        sys.stdout.flush()
        os._exit(status)
    print(child, flush=True)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
"""
FIRST = "tests/brake/mechanics/test_closed_forms.py"
MARKS = ("FAILED", "ERROR ")
WHOLE = {
    "formulas.h": "brake/kernel/c/layerjam.c",
    "layerjam.h": "brake/kernel/c/layerjam.c",
    "history.h": "brake/kernel/c/history.c",
    "stop_formulas.h": "brake/kernel/c/stops.c",
    "stack_loops.h": "brake/kernel/c/stack.c",
}
"""The C file to compile for a header."""


@dataclass
class Result:
    """Outcome of one mutant: failed, endless, passed, slow or not compiled; its failed test."""

    mutant: Mutant
    outcome: str
    test: str = ""
    tests: int = 0
    seconds: float = 0.0


@dataclass
class Farm:
    """Copies of the tree as it is now; each holds one mutant at a time."""

    place: Path
    sources: dict[str, str]
    jobs: int
    homes: Queue[Path] = field(default_factory=Queue)
    servers: dict[Path, Any] = field(default_factory=dict)
    """{copy: process that has loaded all packages but layerjam, and forks for each run}"""
    running: set[int] = field(default_factory=set)
    stopped: threading.Event = field(default_factory=threading.Event)
    unchanged: dict[str, bool] = field(default_factory=dict)
    """{test: whether it passes on an unchanged copy}"""

    def __post_init__(self) -> None:
        command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        names = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        compiled = ROOT / ".pytest_cache" / "compiled"
        (self.place / "cache" / "compiled").mkdir(parents=True)
        if compiled.exists():  # what the mutants compile stays out of the cache of the tests
            shutil.copytree(compiled, self.place / "cache" / "compiled", dirs_exist_ok=True)
        for number in range(self.jobs):
            home = self.place / f"copy{number}"
            for name in filter(None, names.stdout.split("\0")):
                if (ROOT / name).is_file():
                    (home / name).parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(ROOT / name, home / name)
            (home / ".pytest_cache").symlink_to(self.place / "cache")
            (home / ".venv").symlink_to(Path(sys.prefix))
            self.homes.put(home)

    def environment(self, home: Path) -> dict[str, str]:
        return os.environ | {
            "PYTHONPATH": str(home / "src"),
            "XDG_CACHE_HOME": str(self.place / "user"),
            "OMP_NUM_THREADS": "1",
            "OPENBLAS_NUM_THREADS": "1",
            "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false",
        }

    def start_server(self, home: Path) -> subprocess.Popen[str]:
        words, environment = [sys.executable, "-c", SERVER], self.environment(home)
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        return subprocess.Popen(words, cwd=home, env=environment, start_new_session=True, **pipes)

    def run_code(self, home: Path, code: str) -> str:
        """Return the output of a Python program, without limit of time."""
        command = [sys.executable, "-c", code]
        environment = self.environment(home)
        run = subprocess.run(
            command, cwd=home, env=environment, capture_output=True, text=True, check=False
        )
        return run.stdout

    def run_pytest(self, home: Path, words: Sequence[str], limit: float) -> tuple[int | None, str]:
        """Return the exit status of pytest, None if it took too long, and its output."""
        server = self.servers.get(home) or self.start_server(home)
        self.servers[home] = server
        assert server.stdin is not None and server.stdout is not None
        server.stdin.write(json.dumps(list(words)) + "\n")
        server.stdin.flush()
        child = int(server.stdout.readline())
        late = threading.Event()
        timer = threading.Timer(limit, lambda: (late.set(), end(child)))
        timer.start()
        self.running.add(child)
        status = int(server.stdout.readline())
        timer.cancel()
        end(child)  # what it has started and left
        self.running.discard(child)
        output = (home / "output.txt").read_text("utf-8", "replace")
        return None if late.is_set() else status, output

    def run_tests(self, home: Path, tests: Sequence[str], limit: float) -> tuple[str, str]:
        """Return the outcome and the first failed test, "" if the process died."""
        tests = list(tests)
        while tests:
            (home / "tests.txt").write_text("\n".join(tests), encoding="utf-8")
            words = ["-x", "-q", "-p", "no:cacheprovider", "-p", "no:rerunfailures"]
            words += ["--tb=no", "-rfE", *mutant_map.QUICK, "@tests.txt"]
            status, output = self.run_pytest(home, words, limit)
            missing = {test for test in tests if f"not found: {home / test}\n" in output}
            if status is None:
                return "slow", ""
            if status == 4 and missing:  # parameters that the change has renamed
                tests = [test for test in tests if test not in missing]
                continue
            if status in (0, 5):
                return "passed", ""
            lines = [line[6:].lstrip() for line in output.splitlines() if line[:6] in MARKS]
            named = [one for line in lines for one in tests if (line + " ").startswith(one + " ")]
            files = [line.partition(" - ")[0] for line in lines]
            return "failed", max(named, key=len, default=files[0] if files else "")
        return "passed", ""

    def is_sound(self) -> bool:
        """Return whether an unchanged copy imports itself, and a test of it passes."""
        home = self.homes.get()
        try:
            imported = self.run_code(home, "import layerjam; print(layerjam.__file__)")
            return str(home) in imported and self.run_tests(home, [FIRST], START)[0] == "passed"
        finally:
            self.homes.put(home)

    def try_out(self, mutant: Mutant, tests: dict[str, float]) -> Result:
        """Return the outcome of a mutant with some tests."""
        began, home = time.monotonic(), self.homes.get()
        outcome, test, names = "passed", "", list(tests)
        try:
            while names and not self.stopped.is_set():
                limit = START + SLOWER * sum(tests[name] for name in names)
                try:
                    if not self.change(home, mutant):
                        return Result(mutant, "not compiled")
                    outcome, test = self.run_tests(home, names, limit)
                finally:
                    self.restore(home, mutant)
                if outcome == "slow" and self.passes(home, names, limit / 4):
                    outcome = "endless"
                if outcome != "failed" or self.passes(home, [test] if test else names, limit):
                    break
                outcome = "passed"  # the same test fails without the change: once more without it
                names = [name for name in names if test and not name.startswith(test)]
            return Result(mutant, outcome, test, len(names), time.monotonic() - began)
        finally:
            self.homes.put(home)

    def passes(self, home: Path, tests: Sequence[str], limit: float) -> bool:
        """Return whether some tests pass on an unchanged copy, within a limit of time."""
        if len(tests) != 1:
            return self.run_tests(home, tests, limit)[0] == "passed"
        if tests[0] not in self.unchanged:
            if "::" in tests[0]:
                self.unchanged[tests[0]] = self.run_tests(home, tests, limit)[0] == "passed"
            else:  # a file that cannot be imported
                words = ["-q", "--collect-only", "-p", "no:cacheprovider", *tests]
                self.unchanged[tests[0]] = self.run_pytest(home, words, limit)[0] == 0
        return self.unchanged[tests[0]]

    def change(self, home: Path, mutant: Mutant) -> bool:
        """Write a mutant; return whether its C compiles."""
        text = mutant.apply(self.sources[mutant.file])
        self.write(home / "src" / "layerjam" / mutant.file, text)
        is_c = not mutant.file.endswith(".py")
        if is_c or mutant.file.startswith(PRINTED):
            self.run_code(home, PRINT.format(has_printed=not is_c))
        if not is_c:
            return True
        file = home / "src/layerjam" / WHOLE.get(Path(mutant.file).name, mutant.file)
        words = ["cc", "-std=c99", "-O0", "-fsyntax-only", str(file)]
        return subprocess.run(words, capture_output=True, check=False).returncode == 0

    def restore(self, home: Path, mutant: Mutant) -> None:
        self.write(home / "src" / "layerjam" / mutant.file, self.sources[mutant.file])
        if mutant.file.startswith((*PRINTED, "brake/kernel/c/")):
            folder = "src/layerjam/brake/kernel/c"
            shutil.rmtree(home / folder)
            shutil.copytree(ROOT / folder, home / folder)

    def write(self, path: Path, text: str) -> None:
        """Write a file with a new time, so that no compiled code of the old one is used."""
        later = path.stat().st_mtime + 2
        path.write_text(text, encoding="utf-8")
        os.utime(path, (later, later))

    def stop(self) -> None:
        """End all runs, and the processes that have loaded packages."""
        self.stopped.set()
        for child in list(self.running):
            end(child)
        for server in filter(None, self.servers.values()):
            server.terminate()
            server.communicate()  # closes its pipes


def end(group: int) -> None:
    """Kill a group of processes."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)
