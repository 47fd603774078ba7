"""Memory of a server that stays up: given back after a rest, never under a computation."""

from __future__ import annotations

import asyncio
import gc
import threading
import weakref

import jax
import jax.numpy as jnp

from layerjam.workbench.pages.laboratory import Laboratory
from layerjam.workbench.rest import REST, Work, settle
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
