"""Compiled code is kept between processes, in the user's cache or where the user says."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import jax
import numpy as np
import platformdirs
import pytest

from layerjam.brake.mechanics import compilation, tracing
from layerjam.brake.mechanics.pull import brake_force, slip_at_elongation
from strategies import KAPTON

COUNT = """
import jax
requests, loaded = [], []
jax.monitoring.register_event_listener(
    lambda name, **_: requests.append(name) if name.endswith("compile_requests_use_cache")
    else loaded.append(name) if name.endswith("cache_hits") else None)
import layerjam as lj
print(lj.brake_cycle([0.0, 0.005, 0.01], 94.5e3, lj.load("choi2018-kapton")).force[-1])
print(len(requests), len(loaded))
"""
LINE = "layerjam: compiling, once per machine\n"
SETTINGS = ("jax_compilation_cache_dir", *compilation.THRESHOLDS)


def run_python(text: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A new process without settings of JAX's cache but those in `environment`."""
    env = {k: v for k, v in os.environ.items() if k.lower() not in SETTINGS}
    env |= {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), **environment}
    return subprocess.run(
        [sys.executable, "-c", text], env=env, capture_output=True, text=True, timeout=120,
        check=False,
    )  # fmt: skip


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache folder of the user, and JAX's settings as a new process has them."""
    # Windows itself names the folder, whatever the environment says
    cache = str(tmp_path / "home" / "layerjam")
    monkeypatch.setattr(platformdirs, "user_cache_dir", lambda _: cache)
    monkeypatch.setattr(compilation.tempfile, "gettempdir", lambda: str(tmp_path / "temporary"))
    monkeypatch.setattr(jax.monitoring, "register_event_duration_secs_listener", lambda _: None)
    before = {name: getattr(jax.config, name) for name in SETTINGS}
    for name, value in zip(SETTINGS, (None, 1.0, 0), strict=True):
        jax.config.update(name, value)
    yield tmp_path
    for name, value in before.items():
        jax.config.update(name, value)


def keep() -> tuple[bool, tuple[object, ...]]:
    kept = compilation.keep_compiled_code.__wrapped__()
    return kept, tuple(getattr(jax.config, name) for name in SETTINGS)


def is_private(folder: Path) -> bool:
    """Whether nobody else may open it; Windows keeps that in lists that a mode does not show."""
    return os.name == "nt" or folder.stat().st_mode & 0o077 == 0


@pytest.mark.slow
def test_a_second_process_loads_what_the_first_compiled(tmp_path: Path) -> None:
    home = {"XDG_CACHE_HOME": str(tmp_path)}
    first, second = (run_python(COUNT, **home) for _ in range(2))
    assert first.returncode == second.returncode == 0, first.stderr + second.stderr
    force, counts = first.stdout.splitlines()
    sliding = slip_at_elongation(0.01, 94.5e3, KAPTON)
    assert float(force) == pytest.approx(brake_force(sliding, 94.5e3, KAPTON), rel=1e-9)
    asked, loaded = map(int, counts.split())
    assert asked > loaded
    force_again, counts = second.stdout.splitlines()
    asked_again, loaded = map(int, counts.split())
    assert (force_again, asked_again) == (force, asked) and loaded == asked


@pytest.mark.slow
def test_a_folder_of_the_user_alone_is_used(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    done = run_python(
        COUNT,
        XDG_CACHE_HOME=str(tmp_path / "home"),
        JAX_COMPILATION_CACHE_DIR=str(mine),
        JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS="0",
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert any(mine.iterdir()) and not (tmp_path / "home" / "layerjam" / "compiled").exists()


def test_code_is_kept_in_the_users_cache(fresh: Path) -> None:
    folder = fresh / "home" / "layerjam" / "compiled"
    assert keep() == (True, (str(folder), 0.0, -1))
    assert is_private(folder)


def test_settings_of_the_user_stay(fresh: Path) -> None:
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 3.0)
    assert keep()[1][1:] == (3.0, -1)
    jax.config.update("jax_compilation_cache_dir", str(fresh / "mine"))
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", 0)
    assert keep() == (False, (str(fresh / "mine"), 3.0, 0))


def test_without_a_writable_home_the_temporary_folder_serves(fresh: Path) -> None:
    (fresh / "home").write_text("a file, not a folder")
    (fresh / "temporary").mkdir()
    kept, (folder, *_) = keep()
    assert kept and Path(str(folder)).parent == fresh / "temporary"
    assert is_private(Path(str(folder)))


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="folders have no owner here")
def test_a_folder_of_somebody_else_is_not_used(
    fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(compilation.os, "getuid", lambda: os.stat(fresh).st_uid + 1)
    assert keep() == (False, (None, 1.0, 0))


def test_seconds_of_compiling_are_announced_once(capsys: pytest.CaptureFixture[str]) -> None:
    compilation.announce_compilation.cache_clear()
    stopwatch = compilation._Stopwatch()
    for event, seconds, line in (
        (compilation.COMPILED, 1.5, ""),
        ("/jax/core/compile/jaxpr_trace_duration", 9.0, ""),
        (compilation.COMPILED, 5.0, LINE),
        (compilation.COMPILED, 5.0, ""),
    ):
        if line:  # reading kept code is part of the first time, and not compiling
            stopwatch.count(compilation.LOADED, 4.2)
            stopwatch.count(compilation.COMPILED, 4.0)
            assert capsys.readouterr().err == ""
        stopwatch.count(event, seconds)
        assert capsys.readouterr().err == line


def test_a_log_file_shows_the_announcement_while_the_process_compiles(tmp_path: Path) -> None:
    """A file buffers its text; who follows it should know at once why nothing happens."""
    compilation.announce_compilation.cache_clear()
    log = tmp_path / "log"
    with log.open("w", encoding="utf-8") as file, contextlib.redirect_stderr(file):
        compilation.announce_compilation()
        assert log.read_text(encoding="utf-8") == LINE


def test_events_have_the_names_that_jax_gives_them() -> None:
    seen: list[str] = []
    jax.monitoring.register_event_duration_secs_listener(lambda name, *_, **__: seen.append(name))
    try:
        jax.jit(lambda x: x * 3.25 + 1)(1.0)
    finally:
        jax._src.monitoring.unregister_event_duration_listener(
            jax._src.monitoring.get_event_duration_listeners()[-1]
        )
    assert compilation.COMPILED in seen


def sums_of_sines():
    """Return a function that is new each time, because JAX keeps the code of one that it knows."""

    def sums(x):
        return jax.lax.fori_loop(0, 9, lambda turn, total: total + jax.numpy.sin(turn * x), 0.0 * x)

    return sums


def test_few_and_many_numbers_are_computed_alike() -> None:
    """They are compiled by different options; the program for few is not used for many."""
    program = tracing.Program(sums_of_sines())
    many = np.linspace(0.0, 3.0, tracing.FEW + 1)
    each = [program(False, number) for number in many[::50]]
    assert program(False, many)[::50] == pytest.approx(each, rel=1e-12)
    assert program(False, many[:-1])[::50] == pytest.approx(each[:20], rel=1e-12)
    assert program._jitted._cache_size() == 1


def test_a_jax_without_the_option_compiles_as_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracing, "_UNFUSED", {"xla_no_such_option": False})
    program = tracing.Program(sums_of_sines())
    assert [program(False, x) for x in (0.0, 0.5)] == pytest.approx(
        [0.0, np.sin(0.5 * np.arange(9)).sum()], rel=1e-12
    )
