"""What the parts of the page Design have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from layerjam.units import show
from layerjam.workbench.call import Call
from layerjam.workbench.controls import Control, number, slider
from layerjam.workbench.page import Page
from layerjam.workbench.waiting import Waiting

PAGE = "design"
STYLE = """
.design-spec textarea { font-family: ui-monospace, monospace; font-size: 0.8rem;
  line-height: 1.35; height: 340px; resize: vertical; white-space: pre; overflow-x: auto }
.design-picture { width: 100%; background: #fff; border-radius: 4px }
@media (min-width: 901px) { .design-side { width: 400px } }
.design-head > div { width: auto }
"""


class Host(Page):
    """The page that holds the parts."""

    waiting: Waiting
    """Says how far the open part is."""


class Part:
    """A part of the page: built once when first opened, computed only while it is open."""

    def __init__(self, page: Host) -> None:
        self.page, self.desk = page, page.desk
        self.built = False

    def build(self) -> None:
        """Fill the place."""
        raise NotImplementedError

    def calls(self) -> Sequence[Call]:
        """The questions behind what is shown."""
        raise NotImplementedError

    def compute(self) -> Any:
        """In a thread."""
        raise NotImplementedError

    def draw(self, found: Any) -> None:
        """What `compute` returned."""
        raise NotImplementedError

    def controls(self) -> dict[str, Control]:
        """The numbers it asks for, with the bounds of now."""
        return {}

    def value(self, key: str) -> float:
        """A control's value [SI]."""
        return number(self.desk, PAGE, self.controls()[key])

    def text(self, key: str) -> str:
        """A control's value as a verb takes it."""
        control = self.controls()[key]
        return control.text(number(self.desk, PAGE, control))

    def slider(self, key: str) -> None:
        """Its slider."""
        slider(self.desk, PAGE, self.controls()[key], lambda: self.controls()[key])


def said(value: Any, unit: str) -> str:
    """A number of an answer as it stands in a table."""
    if value is None or (isinstance(value, float) and value != value):
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return "; ".join(map(str, value)) or "none"
    return value if isinstance(value, str) else show(float(value), unit or "1")


def words(key: str) -> str:
    """A key as words."""
    return key.replace("_", " ")
