"""Memory of a server that stays up: given back after a rest, never under a computation."""

from __future__ import annotations

import asyncio
import gc
import mmap
import sys
import threading
import tracemalloc
import weakref
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from layerjam.cli.start import SELDOM
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.laboratory import Laboratory
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.rest import REST, Work, _only_read, leave_code, settle
from workbench.standing import standing


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def compiled() -> jax.stages.Wrapped:
    function = jax.jit(lambda x: x + 1.0)
    function(jnp.ones(3))
    assert function._cache_size() == 1
    return function


def test_what_was_compiled_is_given_back_once_after_a_rest():
    clock = Clock()
    work, function = Work(clock), compiled()
    with work.going_on():
        clock.now = 10.0
    clock.now = 10.0 + 0.99 * REST
    assert not work.give_back() and function._cache_size() == 1
    clock.now = 10.0 + REST
    assert work.first("pull") and not work.first("pull")
    assert work.give_back() and function._cache_size() == 0
    assert work.first("pull")  # compiled anew, there is something to settle again
    clock.now += 10 * REST
    assert not work.give_back()  # nothing was computed since
    assert float(function(jnp.ones(3))[0]) == 2.0
    with work.going_on():
        pass
    clock.now += REST
    assert work.give_back()


def test_nothing_is_given_back_under_a_computation():
    clock = Clock()
    work = Work(clock)
    began, go_on = threading.Event(), threading.Event()

    def compute() -> None:
        with work.going_on():
            began.set()
            go_on.wait(10)

    thread = threading.Thread(target=compute)
    thread.start()
    assert began.wait(10)
    clock.now = 5 * REST  # it has run for long, and still does
    assert not work.give_back()
    go_on.set()
    thread.join()
    assert not work.give_back()  # the rest begins when it ends
    clock.now += REST
    assert work.give_back()


def test_a_computation_that_fails_counts_as_ended():
    clock = Clock()
    work = Work(clock)
    try:
        with work.going_on():
            raise ValueError
    except ValueError:
        clock.now = REST
    assert work.give_back()


def test_what_has_settled_is_not_gone_through_again():
    try:
        settle()
        assert gc.get_freeze_count() > 1000
        assert gc.get_count()[2] == 0 and len(gc.get_objects(2)) < 1000
    finally:
        gc.unfreeze()


def test_once_settled_the_collector_looks_as_often_as_usual():
    before = gc.get_threshold()
    gc.set_threshold(*SELDOM)
    try:
        settle()
        assert gc.get_threshold() == (700, 10, 10)
    finally:
        gc.unfreeze()
        gc.set_threshold(*before)


def test_a_tab_that_is_gone_is_let_go_of():
    async def come_and_go() -> weakref.ref:
        async with standing(Laboratory) as (user, pages):
            while not (pages and pages[0].built):
                await asyncio.sleep(0.05)
            await pages[0].settled()
            seen = weakref.ref(pages.pop().desk)
            assert seen() is not None
            settle()
            user.client.delete()
            return seen

    seen = asyncio.run(come_and_go())
    gc.unfreeze()  # as `give_back` does: what `settle` had put aside
    gc.collect()
    assert seen() is None


def pull(rows: int) -> bytes:
    """A pull of so many samples, 100 N/mm up to 150 N and 2 N/mm down."""
    elongation = np.linspace(0.0, 20.0, rows)
    force = 150.0 * np.minimum(elongation / 1.5, 1.0) - 2.0 * np.maximum(elongation - 1.5, 0.0)
    lines = np.char.mod("%.5f,", elongation) + np.char.mod("%.4f", force)
    return "\n".join(["Extension (mm),Load (N)", *lines]).encode()


@pytest.mark.slow
@pytest.mark.parametrize("kind", [Pull, Laboratory])
def test_of_a_large_file_a_page_keeps_what_it_draws(kind):
    """Neither its text nor all its samples: five files of 60 MB would be half a gigabyte."""
    page, large = kind(Desk()), pull(200_000)
    try:
        for name, data in (("small.csv", pull(2_000)), ("large.csv", large)):
            page.uploads.take(f"{name}.toml", b'vacuum = "94.5 kPa"\n')
            tracemalloc.start()  # once more: what the first file loads is not the file's
            page.uploads.take(name, data)
            found = page.compute()
            gc.collect()
            kept = tracemalloc.get_traced_memory()[0]
            tracemalloc.stop()
    finally:
        tracemalloc.stop()
        page.uploads.close()
    assert found
    samples = 200_000 * 2 * 8
    assert kept < min(len(large), samples) / 2


def resident(kind: str) -> int:
    """MB of a kind that this process holds."""
    lines = Path("/proc/self/status").read_text("utf-8").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(kind)) // 1024


@pytest.mark.skipif(sys.platform != "linux", reason="what a process holds is Linux's to say")
def test_what_was_only_read_is_left_and_read_again(tmp_path):
    function, content = compiled(), bytes(range(256)) * 2**18
    own = bytearray(content)  # no file has it: left, it would be zeros
    (tmp_path / "code").write_bytes(content)
    with (tmp_path / "code").open("rb") as file:
        code = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    with code:
        assert code[:] == content
        before, anonymous = resident("RssFile:"), resident("RssAnon:")
        leave_code()
        assert resident("RssFile:") < before - 60  # of 64
        assert resident("RssAnon:") > anonymous - 20
        assert code[:] == content and own == content
    assert float(function(jnp.ones(3))[0]) == 2.0
    assert float(jax.jit(lambda x: jnp.sin(x) ** 2 + 1.0)(0.0)) == 1.0


@pytest.mark.skipif(sys.platform != "linux", reason="what a process holds is Linux's to say")
def test_to_leave_what_was_read_takes_no_memory_of_its_own():
    """Of thousands of parts, each with a kB of facts, one is held at a time."""
    protections = (mmap.PROT_READ, mmap.PROT_READ | mmap.PROT_WRITE)
    held = [mmap.mmap(-1, mmap.PAGESIZE, prot=protections[n % 2]) for n in range(4000)]
    parts = Path("/proc/self/smaps").read_bytes().count(b"VmFlags:")
    assert parts > 2000
    tracemalloc.start()
    try:
        leave_code()
        assert tracemalloc.get_traced_memory()[1] < 400_000
    finally:
        tracemalloc.stop()
        for part in held:
            part.close()


def test_what_was_written_to_or_may_be_is_not_left():
    text = """\
10000-13000 r-xp 00000000 08:01 7 /lib/code.so
Rss:                  12 kB
Anonymous:             0 kB
VmFlags: rd ex mr mw me
13000-14000 r--p 00003000 08:01 7 /lib/code.so
Anonymous:             4 kB
14000-15000 rw-p 00004000 08:01 7 /lib/code.so
Anonymous:             0 kB
15000-16000 r--p 00000000 00:00 0
Anonymous:             0 kB
16000-17000 r-xp 00000000 00:00 0                  [vdso]
Anonymous:             0 kB
17000-19000 r--s 00000000 08:01 8 /a name with spaces
Anonymous:             0 kB
"""
    assert list(_only_read(text.splitlines())) == [(0x10000, 0x3000), (0x17000, 0x2000)]
