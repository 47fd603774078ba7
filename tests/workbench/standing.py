"""A page of the workbench that stands in a simulated browser."""

from __future__ import annotations

from contextlib import asynccontextmanager

from nicegui.testing import user_simulation

from layerjam.workbench.pages.all import Tab
from layerjam.workbench.shell import build_frame


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
    async with user_simulation(lambda: build_frame(link, [tab], lambda: None)) as user:
        await user.open("/")
        yield user, pages
