"""Checks of a build (C1 to C15): values and limits first, sentences only on request."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from layerjam.core.errors import Notice
from layerjam.core.verdict import Check as JudgedCheck
from layerjam.core.verdict import Level

ROUNDING = 1e-9
"""Relative rounding error by which a value may miss its limit."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """Check of a value against a limit, both in SI, for one brake or, as arrays, for many.

    `passes` states the outcome if given; otherwise value and limit determine it. `applies` is False
    if the check is not relevant. `otherwise` is the level of a failure: `refused` for geometry that
    cannot be drawn, `failed` for an overloaded part, which a person may accept.
    """

    code: str
    key: str
    """Name for use by programs."""
    words: Callable[[bool | None], str]
    """Function that returns the sentence for a value of `ok`."""
    value: Any = None
    limit: Any = None
    at_most: bool = True
    """Whether the limit is the largest value allowed; otherwise it is the smallest."""
    unit: str = "1"
    otherwise: Literal["refused", "failed", "warning"] = "warning"
    applies: Any = True
    fallback: Any = math.inf
    """Margin if the check does not apply: the margin of the alternative load path."""
    passes: Any = None

    def margin(self) -> Any:
        """Return the ratio of limit to load: 1 or more passes; infinite if there is no limit."""
        if self.passes is not None:
            return np.where(self.passes, math.inf, 0.0)
        if self.value is None or self.limit is None:
            return np.asarray(math.inf)
        load, limit = (self.value, self.limit) if self.at_most else (self.limit, self.value)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(np.asarray(load) <= 0, math.inf, np.divide(limit, load))
        return np.where(self.applies, share * (1 + ROUNDING), self.fallback)

    @property
    def ok(self) -> bool | None:
        """Whether one brake passes; None if the check does not apply or a value is missing."""
        is_known = self.passes is not None or None not in (self.value, self.limit)
        return bool(self.margin() >= 1) if is_known and self.applies else None

    @property
    def is_refused(self) -> bool:
        """Whether a failure means that the brake cannot be drawn."""
        return self.otherwise == "refused"

    @property
    def level(self) -> Level:
        """Level of the check in the verdict of the build."""
        if self.ok is None:
            return "note"
        return "passed" if self.ok else "warning" if self.otherwise == "warning" else "failed"

    @property
    def text(self) -> str:
        """Sentence with the finding, and the remedy if the check did not pass."""
        return self.words(self.ok)

    def row(self) -> dict[str, Any]:
        """Return the check's row in the JSON output."""
        return {
            "code": self.code,
            "ok": self.ok,
            "level": self.level,
            "text": self.text,
            "value": _finite_or_none(self.value),
            "limit": _finite_or_none(self.limit),
            "unit": self.unit,
            "key": self.key,
        }

    def to_judged_check(self) -> JudgedCheck:
        """Return the check for the verdict of a command, with its code as the name."""
        return JudgedCheck(
            name=self.code,
            level=self.level,
            sentence=self.text,
            value=_finite_or_none(self.value),
            limit=_finite_or_none(self.limit),
            unit=self.unit,
        )


def finding(code: str, key: str, text: str, **more: Any) -> Check:
    """Return a check whose sentence is the same whether or not it passes."""
    # a result with its checks crosses processes, as a lambda cannot
    return Check(code=code, key=key, words=partial(_ignore_outcome, text), **more)


def _ignore_outcome(text: str, ok: bool | None) -> str:
    return text


def _finite_or_none(value: Any) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def refusals(checks: Iterable[Check]) -> list[Check]:
    """Return the checks that keep the brake from being drawn."""
    return [check for check in checks if check.is_refused and check.ok is False]


def refusal_reason(checks: Iterable[Check]) -> str | None:
    """Return codes and sentences of checks as one sentence; None if there are no checks."""
    return "; ".join(f"{check.code}: {check.text}" for check in checks) or None


def warning_notices(checks: Iterable[Check]) -> list[Notice]:
    """Return a notice for each warning."""
    return [
        Notice(f"{check.code}: {check.text}", check.key)
        for check in checks
        if check.level == "warning"
    ]
