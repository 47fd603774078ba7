"""Tables in Markdown, and the units and bounds of quantities for them."""

from __future__ import annotations

import re

from layerjam.core.units import QuantitySpec

NOTHING = "–"
SHARED = 3
"""Number of places with the same text from which it is written once for all."""


def row(*cells: str) -> str:
    """One line of a table."""
    return "| " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"


def table(head: tuple[str, ...], rows: list[str]) -> str:
    """A Markdown table."""
    return "\n".join([row(*head), row(*["---"] * len(head)), *rows])


def bounds_of(spec: QuantitySpec) -> str:
    """The bounds of a quantity, short enough for a column."""
    text = re.sub(r"^at least (.+) and at most (.+)$", r"\1 to \2", spec.limits())
    text = re.sub(r"^more than zero and at most (.+)$", r"above 0, to \1", text)
    return re.sub(r"^zero or more and at most (.+)$", r"0 to \1", text)


def unit(spec: QuantitySpec) -> str:
    """The SI unit, a dash for a pure number."""
    return NOTHING if spec.unit == "1" else spec.unit.replace("^3", "³").replace("^2", "²")
