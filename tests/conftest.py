"""Double precision and repeatable random examples for every test."""

from __future__ import annotations

import ctypes
import gc
import itertools
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

# two processes of tests share the cores, and threads of BLAS would wait for each other in loops;
# set before NumPy is loaded
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import jax
import pytest
from hypothesis import settings
from hypothesis.internal.conjecture import providers

from layerjam.core.store import Appearing

# what one process has compiled no other need; most of a test's time is compiling
COMPILED = Path(__file__).parents[1] / ".pytest_cache" / "compiled"
CACHE = {
    "jax_compilation_cache_dir": str(COMPILED),
    "jax_persistent_cache_min_compile_time_secs": 0.05,
    "jax_persistent_cache_min_entry_size_bytes": -1,
}
jax.config.update("jax_enable_x64", True)
for name, value in CACHE.items():
    jax.config.update(name, value)
    os.environ[name.upper()] = str(value)

settings.register_profile("quick", derandomize=True, deadline=None, max_examples=60, database=None)
settings.register_profile("deep", deadline=None, max_examples=2000, database=None)
# random examples depend neither on the numbers in the source nor on what other tests have imported
providers._get_local_constants = lambda: providers._local_constants
settings.load_profile(os.environ.get("LAYERJAM_HYPOTHESIS", "quick"))


MOST_MEMORY = 2_000_000_000
"""Bytes of a worker beyond which compiled functions are given up; the cache on disk has them."""


@pytest.fixture(autouse=True, scope="module")
def _memory() -> Iterator[None]:
    """What one module has compiled does not stay in memory to the end of all tests."""
    yield
    if resident() > MOST_MEMORY:
        jax.clear_caches()
        gc.collect()
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # glibc's alone
        if trim is not None:
            trim(0)


@pytest.fixture(autouse=True)
def _no_interrupt() -> Iterator[None]:
    """An interrupt that one test sends is not lost in the next one."""
    yield
    Appearing.reset()


def resident() -> int:
    """Bytes of memory that this process holds; zero where the system does not say."""
    statm = Path("/proc/self/statm")
    if not (statm.exists() and hasattr(os, "sysconf")):  # Wine shows /proc to Windows' Python
        return 0
    return int(statm.read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")


MOST_RERUNS = 3
"""Number of repeated tests beyond which a run fails, even if all of them then pass."""
BROWSER = {"tab", "chromium", "workbench"}
"""Fixtures that start a browser or a server; a test with one is marked `browser` and `timing`."""

QUICK = "not slow"
"""Choice of tests that compile for seconds and compute for milliseconds."""


def pytest_configure(config: pytest.Config) -> None:
    """Compile without optimizing in the quick tests; the long ones compile as users do."""
    if config.option.markexpr.startswith(QUICK):
        jax.config.update("jax_disable_most_optimizations", True)
        os.environ["JAX_DISABLE_MOST_OPTIMIZATIONS"] = "1"
        flags = os.environ.get("XLA_FLAGS", "")
        os.environ["XLA_FLAGS"] = f"{flags} --xla_cpu_use_fusion_emitters=false"


BOARD = "tests/bench/rig/"
"""Folder of the tests with a virtual board in a process of its own."""


@pytest.hookimpl(tryfirst=True)  # before -m selects by the markers
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark long tests and those with a browser or a board; rerun those marked `timing` once."""
    reruns = config.pluginmanager.hasplugin("rerunfailures")
    for item in items:
        if item.get_closest_marker("campaign") is not None:
            item.add_marker("slow")
        if BROWSER & set(getattr(item, "fixturenames", ())):
            item.add_marker("browser")
            item.add_marker("timing")
        if BOARD in item.path.as_posix():
            item.add_marker("timing")
        if reruns and item.get_closest_marker("timing") is not None:
            item.add_marker(pytest.mark.flaky(reruns=1))


def pytest_collection_finish() -> None:
    """Leave what exists before the first test out of every later search for garbage."""
    gc.collect()
    gc.freeze()


def find_reruns(config: pytest.Config) -> list[str]:
    """Return the names of the tests that were repeated; empty in the workers of a run."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    return [] if reporter is None else [r.nodeid for r in reporter.stats.get("rerun", [])]


def add_times(stats: dict[str, list[object]]) -> Counter[str]:
    """Return the seconds that the tests of each folder took, summed over the workers."""
    times: Counter[str] = Counter()
    for report in itertools.chain.from_iterable(stats.values()):
        if isinstance(report, pytest.TestReport):
            times[report.nodeid.rpartition("/")[0].removeprefix("tests/")] += report.duration
    return times


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the time of each folder, and every rerun with its name and error."""
    times = add_times(terminalreporter.stats).most_common()
    parts = [f"{folder} {seconds:.0f} s" for folder, seconds in times if seconds >= 1]
    terminalreporter.line(f"\ntime of each folder: {', '.join(parts) or 'less than 1 s'}")
    repeated = terminalreporter.stats.get("rerun", [])
    if repeated:
        terminalreporter.section(f"tests that were run twice: {len(repeated)}")
    for report in repeated:
        crash = getattr(report.longrepr, "reprcrash", None)
        reason = str(crash.message if crash else report.longrepr).splitlines()
        terminalreporter.line(f"{report.nodeid}: {reason[0] if reason else 'no reason'}")
    if len(repeated) > MOST_RERUNS:
        terminalreporter.line(f"the run failed: more than {MOST_RERUNS} tests were run twice")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session) -> None:
    """Fail a run in which more tests than `MOST_RERUNS` were repeated."""
    if len(find_reruns(session.config)) > MOST_RERUNS and session.exitstatus == 0:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
