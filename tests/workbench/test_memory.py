"""Memory of a server that runs for weeks: closed tabs are released, the collector runs."""

from __future__ import annotations

import asyncio
import gc
import tracemalloc
import weakref

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from nicegui import Client

from layerjam.cli.start import SELDOM
from layerjam.workbench import memory
from layerjam.workbench.desk import Desk
from layerjam.workbench.memory import forget_tab, freeze_modules, tidy_after_result
from layerjam.workbench.pages.laboratory import Laboratory
from layerjam.workbench.pages.pull import Pull
from workbench.standing import standing


def compiled() -> jax.stages.Wrapped:
    function = jax.jit(lambda x: x + 1.0)
    function(jnp.ones(3))
    assert function._cache_size() == 1
    return function


def test_compiled_code_goes_with_the_last_tab(monkeypatch):
    function = compiled()
    monkeypatch.setattr(Client, "instances", {"closed": None, "open": None})
    forget_tab()
    assert function._cache_size() == 1
    monkeypatch.setattr(Client, "instances", {"closed": None})
    forget_tab()
    assert function._cache_size() == 0
    assert float(function(jnp.ones(3))[0]) == 2.0


def test_what_has_settled_is_not_gone_through_again():
    try:
        freeze_modules()
        assert gc.get_freeze_count() > 1000
        assert gc.get_count()[2] == 0 and len(gc.get_objects(2)) < 1000
    finally:
        gc.unfreeze()


def test_memory_is_tidied_only_while_nobody_moves_anything(monkeypatch):
    """A full search pauses every tab, so it waits for the end of a drag."""
    done = []

    async def note(work):
        done.append(work)

    async def move(times):
        await asyncio.gather(*(tidy_after_result("pull") for _ in range(times)))

    monkeypatch.setattr(memory, "IDLE_TIME", 0.02)
    monkeypatch.setattr(memory.run, "io_bound", note)
    monkeypatch.setattr(memory, "_frozen_pages", set())
    monkeypatch.setattr(gc, "get_count", lambda: (0, 0, memory.PARTIAL_SEARCHES))
    asyncio.run(move(5))
    assert done == [freeze_modules]
    asyncio.run(move(5))
    assert done == [freeze_modules, gc.collect]
    monkeypatch.setattr(gc, "get_count", lambda: (0, 0, memory.PARTIAL_SEARCHES - 1))
    asyncio.run(move(5))
    assert len(done) == 2


def test_once_settled_the_collector_looks_more_often():
    before = gc.get_threshold()
    gc.set_threshold(*SELDOM)
    try:
        freeze_modules()
        assert gc.get_threshold() == memory.WHILE_MOVING < SELDOM
    finally:
        gc.unfreeze()
        gc.set_threshold(*before)


def test_a_tab_that_is_gone_is_let_go_of():
    async def come_and_go() -> weakref.ref:
        async with standing(Laboratory) as (user, pages):
            while not (pages and pages[0].built):
                await asyncio.sleep(0.05)
            await pages[0].wait_until_idle()
            seen = weakref.ref(pages.pop().desk)
            assert seen() is not None
            freeze_modules()
            user.client.delete()
            return seen

    seen = asyncio.run(come_and_go())
    gc.unfreeze()  # as with the last tab: objects that `freeze_modules` had put aside
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
            page.uploads.store_file(f"{name}.toml", b'vacuum = "94.5 kPa"\n')
            tracemalloc.start()  # once more: what the first file loads is not the file's
            page.uploads.store_file(name, data)
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
