"""Common base of the parts of the Design page."""

from typing import Any

from layerjam.core.command.wording import format_words
from layerjam.workbench.page import Page, View
from layerjam.workbench.spoken import typeset_text

PAGE = "design"
NAMES = {
    "holding_force": "force at rest",
    "max_force": "peak force of a pull",
    "drawn_mass": "mass as drawn",
    "usable_travel": "travel",
    "energy_capacity": "energy",
}
"""Names of merits whose keys are unclear."""


class Part(View):
    """A part of the Design page, computed only while it is open."""

    name = PAGE

    def __init__(self, page: Page) -> None:
        super().__init__(page.desk)
        self.page = page


def cell_text(value: Any, unit: str) -> str:
    """Return a value from a result, formatted for a table."""
    if value is None or (isinstance(value, float) and value != value):
        return "–"
    if isinstance(value, list):
        return typeset_text("; ".join(map(str, value))) or "none"
    return format_words(value, unit)


def key_name(key: str) -> str:
    """Return the page's name for a key."""
    return NAMES.get(key) or typeset_text(key.replace("_", " "))
