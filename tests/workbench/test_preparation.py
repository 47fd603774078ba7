"""While the first result of an installation is computed, the frame states the step."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from layerjam.brake.device.load import load
from layerjam.workbench.pages.all import TABS
from layerjam.workbench.preparation import Preparation
from layerjam.workbench.shell import build_frame

from .conftest import running
from .standing import simulate_user


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
        async with simulate_user(lambda: build_frame("", TABS, preparation)) as user:
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


def test_the_brake_is_drawn_before_the_browser_has_loaded_any_code(chromium) -> None:
    async def fetch_page() -> str:
        preparation = Preparation(loading=lambda: None)
        async with simulate_user(lambda: build_frame("", TABS, preparation)) as user:
            return str((await user.http_client.get("/")).text)

    with ThreadPoolExecutor() as pool:  # Chromium's driver has a loop in this thread
        text = pool.submit(lambda: asyncio.run(fetch_page())).result()
    page = chromium.new_page()
    page.route("**/_nicegui/**", lambda route: route.abort())
    page.set_content(text, wait_until="domcontentloaded")
    assert page.get_by_text("Preparing, 1 of 1: loading").is_visible()
    drawing = page.get_by_test_id("frame-brake")
    assert drawing.bounding_box()["width"] > 300
    sheets = load("choi2018-kapton").brake.sheets.count
    assert drawing.locator(".sheet-left, .sheet-right").count() == sheets + 2  # also from above
    page.close()


SHOWN = """() => {
    const head = document.querySelector('.frame-head');
    const sheets = document.querySelectorAll('.frame-brake .sheet-left').length;
    const line = document.querySelector('.frame-preparing');
    const words = document.querySelector('[data-testid=start-words]');
    return head && head.getBoundingClientRect().width > 0
        && (sheets > 0 && line?.textContent.startsWith('Preparing, ')
            || words?.textContent.includes('resists a pull'));
}"""
"""Whether frame, drawing and step are visible, or the first result already is."""


@pytest.mark.slow
@pytest.mark.timing
def test_in_a_fresh_home_the_frame_appears_before_the_first_result(chromium, tmp_path) -> None:
    """`benchmarks/workbench.py` measures the time until then."""
    with running(home=tmp_path) as (place, _):
        page = chromium.new_page()
        page.goto(place, wait_until="commit")
        page.wait_for_function(SHOWN, timeout=90_000)
        page.get_by_text("resists a pull of up to").wait_for(timeout=90_000)
        page.close()
