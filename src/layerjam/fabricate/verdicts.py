"""What is said of one check: passed, not passed, or not checked, with its number and its limit."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any

from layerjam.errors import Notice


@dataclass(frozen=True, kw_only=True)
class Check:
    """One check of a build (C1 to C15); value and limit are in SI, in `unit`."""

    code: str
    ok: bool | None
    """None: not checked, for want of a limit or of data."""
    text: str
    """The sentence for people: what was found, and the remedy where it failed."""
    value: float | None = None
    limit: float | None = None
    unit: str = "1"
    refuses: bool = False
    """Whether a brake that does not pass cannot be built; otherwise it is warned of."""
    key: str = ""
    """What was checked, for programs."""

    def row(self) -> dict[str, Any]:
        """As the JSON holds it."""
        names = [f.name for f in fields(self) if f.name != "refuses"]
        return {name: getattr(self, name) for name in ("code", *names[1:])}


def refusals(checks: Iterable[Check]) -> list[Check]:
    """The checks for which the brake cannot be built."""
    return [check for check in checks if check.refuses and check.ok is False]


def notices(checks: Iterable[Check]) -> list[Notice]:
    """What is to be warned of."""
    return [
        Notice(f"{check.code}: {check.text}", check.key or check.code.lower())
        for check in checks
        if check.ok is False and not check.refuses
    ]
