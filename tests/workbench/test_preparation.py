"""While the first result of an installation is computed, the frame states the step."""

from __future__ import annotations

import asyncio
import threading

from nicegui.testing import user_simulation

from layerjam.workbench.pages.all import TABS
from layerjam.workbench.preparation import Preparation
from layerjam.workbench.shell import build_frame


def test_each_step_is_done_once_and_named() -> None:
    calls: list[str] = []

    def check() -> None:
        calls.append(preparation.text)

    preparation = Preparation(loading_code=lambda: calls.append("a"), first_pull=check)
    assert preparation.text == "Preparing, 1 of 2: loading code"
    preparation()
    preparation()
    assert calls == ["a", "Preparing, 2 of 2: first pull"] and preparation.text == ""


def test_the_frame_and_the_page_appear_while_the_first_result_is_prepared() -> None:
    may_go_on, begun = threading.Event(), threading.Event()

    def wait() -> None:
        begun.set()
        may_go_on.wait()

    preparation = Preparation(loading=lambda: None, computing=wait)

    async def use() -> None:
        async with user_simulation(lambda: build_frame("", TABS, preparation)) as user:
            await user.open("/")
            await user.should_see("layerjam")
            await user.should_see("Preparing, ")
            # the first page, with its drawing of the brake, does not wait for numbers
            await user.should_see("Drop a kilogram", retries=100)
            await user.should_see("Preparing, 2 of 2: computing", retries=100)
            assert begun.is_set()
            may_go_on.set()
            while preparation.text:
                await asyncio.sleep(0.01)
            await user.should_see("resists a pull of up to", retries=300)
            await user.should_not_see("Preparing, ", retries=100)

    try:
        asyncio.run(use())
    finally:
        may_go_on.set()
