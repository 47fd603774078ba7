"""Checks of a build (C1 to C15): numbers with their limits first, sentences only if asked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from layerjam.errors import Notice
from layerjam.verdict import Check as JudgedCheck
from layerjam.verdict import Level

ROUNDING = 1e-9
"""Relative rounding by which a value may miss its limit."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """A value and its limit in SI, of one brake or arrays of many; `words` gives the sentence.

    `passes` decides where it is given, the two numbers otherwise. `applies` is False where the
    check says nothing. If it does not pass: geometry that cannot be drawn is `refused`, a part
    loaded beyond its strength has `failed` and somebody may accept it.
    """

    code: str
    key: str
    """Name for programs."""
    words: Callable[[bool | None], str]
    """Return the sentence, given `ok`."""
    value: Any = None
    limit: Any = None
    at_most: bool = True
    """Whether the limit is the greatest value allowed; otherwise it is the least."""
    unit: str = "1"
    otherwise: Literal["refused", "failed", "warning"] = "warning"
    applies: Any = True
    other: Any = math.inf
    """Margin if it does not apply: that of the load path which carries the load instead."""
    passes: Any = None

    def margin(self) -> Any:
        """Return how many times the value keeps its limit: 1 or more passes, infinite if unused."""
        if self.passes is not None:
            return np.where(self.passes, math.inf, 0.0)
        if self.value is None or self.limit is None:
            return np.asarray(math.inf)
        load, room = (self.value, self.limit) if self.at_most else (self.limit, self.value)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(np.asarray(load) <= 0, math.inf, np.divide(room, load))
        return np.where(self.applies, share * (1 + ROUNDING), self.other)

    @property
    def ok(self) -> bool | None:
        """Whether one brake passes; None if a limit or a datum is missing or it does not apply."""
        known = self.passes is not None or None not in (self.value, self.limit)
        return bool(self.margin() >= 1) if known and self.applies else None

    @property
    def refuses(self) -> bool:
        """Whether a brake that does not pass cannot be drawn."""
        return self.otherwise == "refused"

    @property
    def level(self) -> Level:
        """The level by which the verdict of the build judges it."""
        if self.ok is None:
            return "note"
        return "passed" if self.ok else "warning" if self.otherwise == "warning" else "failed"

    @property
    def text(self) -> str:
        """The sentence for people: the finding, and the remedy if it did not pass."""
        return self.words(self.ok)

    def row(self) -> dict[str, Any]:
        """Return the row of the JSON."""
        return {
            "code": self.code,
            "ok": self.ok,
            "level": self.level,
            "text": self.text,
            "value": _finite(self.value),
            "limit": _finite(self.limit),
            "unit": self.unit,
            "key": self.key,
        }

    def judged(self) -> JudgedCheck:
        """Return the check as every command's verdict takes it; its code is its name."""
        return JudgedCheck(
            name=self.code,
            level=self.level,
            sentence=self.text,
            value=_finite(self.value),
            limit=_finite(self.limit),
            unit=self.unit,
        )


def say(text: str, ok: bool | None) -> str:
    """Return the words of a check that says the same whether it passes or not."""
    return text


def _finite(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def refusals(checks: Iterable[Check]) -> list[Check]:
    """Return the checks because of which the brake cannot be drawn."""
    return [check for check in checks if check.refuses and check.ok is False]


def reason(checks: Iterable[Check]) -> str | None:
    """Return codes and sentences of checks as one sentence; None if there are none."""
    return "; ".join(f"{check.code}: {check.text}" for check in checks) or None


def notices(checks: Iterable[Check]) -> list[Notice]:
    """Return a notice for each warning."""
    return [
        Notice(f"{check.code}: {check.text}", check.key)
        for check in checks
        if check.level == "warning"
    ]
