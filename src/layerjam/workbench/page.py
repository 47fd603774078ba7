"""What every page has: controls, a computation off the event loop, results, things to copy."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from typing import Any

from nicegui import Client, background_tasks, ui

from layerjam.commands.answer import Answer
from layerjam.commands.results import Result
from layerjam.errors import LayerjamError
from layerjam.units import show
from layerjam.workbench.call import Call
from layerjam.workbench.desk import Desk
from layerjam.workbench.live import Words
from layerjam.workbench.rest import WORK, elsewhere, settle_later
from layerjam.workbench.runner import Runner


class Page:
    """A tab. A page fills its slot in `build`, answers in `compute`, draws in `draw`.

    `compute` runs in a thread and calls verbs only, through `calls`; `draw` runs on the event loop.
    """

    name = ""
    title = ""
    icon = ""
    """Of the tab where a page stands alone; else they are in `pages.all`."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.dark = False
        self.result: Any = None
        self.problem: ui.label | None = None
        self.built = False
        self.client: Client | None = None
        self.prepare: Callable[[], None] = lambda: None
        self.runner = Runner(self._answer, self._show, elsewhere)
        desk.watch(self._changed)

    @classmethod
    def load(cls) -> type[Page]:
        """Itself, where a page stands for its tab."""
        return cls

    def build(self) -> None:
        """Fill the slot; once, when the page is first opened."""
        raise NotImplementedError

    def calls(self) -> Sequence[Call]:
        """The questions behind what is shown, as they can be copied."""
        return ()

    def compute(self) -> Any:
        """Answers to the page's calls."""
        return [call.run() for call in self.calls()]

    def _answer(self) -> Any:
        self.prepare()
        return self.compute()

    def draw(self, result: Any) -> None:
        """Show what `compute` returned."""
        raise NotImplementedError

    def open(self) -> None:
        """Build if need be and bring up to date."""
        if not self.built:
            self.built = True
            self.client = ui.context.client
            self.client.on_delete(self.runner.stop)
            self.build()
        self.refresh()

    def refresh(self) -> None:
        """Ask anew, with the latest inputs."""
        if self.built and self.desk.state.page == self.name:
            background_tasks.create(self.runner.ask(), name=f"layerjam {self.name}")

    def _changed(self, what: str) -> None:
        if what != "page":
            self.refresh()

    def _show(self, result: Any, problem: str) -> None:
        if self.client is None or self.client.is_deleted:  # the tab was closed meanwhile
            return
        if self.problem is not None:
            self.problem.set_text(problem)
            self.problem.set_visibility(bool(problem))
        if not problem:
            self.result = result
            self.draw(result)
        if WORK.first(self.name):
            background_tasks.create(settle_later(), name="layerjam settles")

    def problem_line(self) -> None:
        """Where a refusal stands, in words."""
        self.problem = ui.label("").classes("text-negative").props(
            f'role="alert" data-testid="{self.name}-problem"'
        )  # fmt: skip
        self.problem.set_visibility(False)

    async def settled(self) -> None:
        """Wait until nothing is being computed (for tests)."""
        while self.runner._running:
            await asyncio.sleep(0.01)


def answered(call: Call, **more: Any) -> tuple[Answer | None, str]:
    """The answer, or the refusal in words: where one of several questions may be refused alone."""
    try:
        return call.run(**more), ""
    except LayerjamError as err:
        return None, " ".join(str(err).split())


class Figures:
    """A small table of numbers: names left, values right, told apart by key."""

    def __init__(self, page: str, rows: Sequence[tuple[str, str]]) -> None:
        """`rows` are (key of the answer, what it is called)."""
        self.rows = rows
        self._cells: dict[str, Words] = {}
        with ui.grid(columns="auto auto").classes("gap-x-6 gap-y-1 items-baseline"):
            for key, name in rows:
                ui.label(name).classes("text-sm opacity-80")
                self._cells[key] = Words("–").classes("text-base font-medium text-right").props(
                    f'data-testid="{page}-{key}"'
                )  # fmt: skip

    def fill(self, answer: Answer | Result) -> None:
        """The values of an answer with their units."""
        for key, cell in self._cells.items():
            value = answer.values.get(key)
            unit = answer.units.get(key, "1")
            number = isinstance(value, int | float) and not isinstance(value, bool)
            words = (
                {True: "yes", False: "no", None: "–"}.get(value, str(value)) if not number else ""
            )
            cell.set_text(show(value, unit) if number else words)  # type: ignore[arg-type]


class Notes:
    """The answer's warnings as quiet lines."""

    def __init__(self) -> None:
        self._box = ui.column().classes("gap-1 text-sm opacity-80")
        self._shown: tuple[str, ...] = ()

    def fill(self, warnings: Sequence[str]) -> None:
        """Show them; nothing moves where they have not changed."""
        if tuple(warnings) == self._shown:
            return
        self._shown = tuple(warnings)
        self._box.clear()
        with self._box:
            for sentence in warnings:
                ui.label(f"Note: {sentence}")
