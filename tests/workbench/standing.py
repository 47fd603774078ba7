"""A page of the workbench that stands in a simulated browser."""

from __future__ import annotations

from contextlib import asynccontextmanager

from nicegui.testing import user_simulation

from layerjam.workbench.shell import frame


@asynccontextmanager
async def standing(kind, link=""):
    """(user, pages): the page of a class opened at a link; `pages` has it once it is built."""
    pages = []

    class Seen(kind):
        def __init__(self, desk):
            super().__init__(desk)
            pages.append(self)

    async with user_simulation(lambda: frame(link, [Seen], lambda: None)) as user:
        await user.open("/")
        yield user, pages
