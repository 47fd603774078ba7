"""A page of the workbench that stands in a simulated browser."""

from __future__ import annotations

import gc
import re
from contextlib import asynccontextmanager

from nicegui import Client
from nicegui.testing import user_simulation

from layerjam.workbench.pages.all import Tab
from layerjam.workbench.shell import DARK, build_frame

LIGHT = {re.compile(r".*" + re.escape(DARK)): lambda _: False}
"""Answer of a browser with a light page, for which the frame waits two seconds else."""


@asynccontextmanager
async def simulate_user(built):
    """User of a simulated browser, for pages that `built()` builds."""
    async with user_simulation(built) as user:
        user.javascript_rules |= LIGHT
        try:
            yield user
        finally:  # Python 3.11 can lose a cancellation of the loop that sends updates
            for client in Client.instances.values():
                client.outbox.stop()


@asynccontextmanager
async def standing(kind, link=""):
    """(user, pages): the page of a class opened at a link; `pages` has it once it is built."""
    pages = []

    class Seen(kind):
        def __init__(self, desk):
            super().__init__(desk)
            pages.append(self)

    class Only(Tab):
        def load(self):
            return Seen

    tab = Only(kind.name, kind.__name__, "")
    gc.freeze()  # the simulation searches all garbage, of all tests before this one as well
    try:
        async with simulate_user(lambda: build_frame(link, [tab], lambda: None)) as user:
            await user.open("/")
            yield user, pages
    finally:
        gc.unfreeze()
