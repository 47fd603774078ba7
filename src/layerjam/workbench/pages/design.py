"""Design: from a requirement to a brake, several as one, what others make, four machines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import ui

from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call
from layerjam.workbench.controls import Choice, choice
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Page
from layerjam.workbench.pages.design_arrays import Arrays
from layerjam.workbench.pages.design_density import Density
from layerjam.workbench.pages.design_machines import Machines
from layerjam.workbench.pages.design_need import NeedPart
from layerjam.workbench.pages.design_part import Part
from layerjam.workbench.runner import waiting_line

KINDS: dict[str, tuple[str, type[Part]]] = {
    "need": ("From a requirement", NeedPart),
    "arrays": ("Several as one", Arrays),
    "density": ("Force over mass", Density),
    "machines": ("Four machines", Machines),
}
WORDS = {key: words for key, (words, _) in KINDS.items()}
PART = Choice("part", WORDS, "need", help="What this page shows")


class Design(Page):
    """Four parts, one of them open; only the open one is computed."""

    name, title = "design", "Design"
    about = "From a requirement to a brake"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.parts = {key: kind(self) for key, (_, kind) in KINDS.items()}
        self.boxes: dict[str, ui.column] = {}

    def build(self) -> None:
        """The choice of a part, and the parts below it; each is built when first opened."""
        with ui.column().classes("w-full page gap-3"):
            with ui.row().classes("w-full items-center gap-6 design-head"):
                choice(self.desk, self.name, PART)
                self.problem_line()
            waiting_line(self.name, self.runner)
            for key in self.parts:
                self.boxes[key] = ui.column().classes("w-full gap-3")
                self.boxes[key].set_visibility(False)
        self.desk.watch(lambda _: self._open_part())
        self._open_part()

    def part(self) -> Part:
        """The one that is open."""
        return self.parts[self.word(PART)]

    def _open_part(self) -> None:
        now = self.word(PART)
        for key, box in self.boxes.items():
            box.set_visibility(key == now)
        if not self.parts[now].built:
            self.parts[now].built = True
            with self.boxes[now]:
                self.parts[now].build()

    def calls(self) -> Sequence[Call]:
        """The open part's calls."""
        return self.part().calls()

    def compute(self) -> Any:
        """The open part's results, and whose they are."""
        part = self.part()
        return part, part.compute()

    def answers(self) -> Sequence[Answer]:
        """What the open part shows."""
        return self.part().answers()

    def draw(self, result: Any) -> None:
        """Show them where the part is still open."""
        part, found = result
        if part is self.part():
            part.result = found
            part.draw(found)
