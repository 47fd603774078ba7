"""Display of 95 % intervals, and of the word that a prediction rests on as a badge."""

from collections.abc import Mapping
from dataclasses import replace
from html import escape
from typing import Any

from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.wording import format_ends
from layerjam.workbench.spoken import typeset_text

DIGITS = 3
"""Significant digits of an interval, as of a large number."""
BASES: Mapping[str, str] = {
    "tested": "Tests of this brake cover these conditions",
    "extrapolated": "These conditions are outside the tested range",
    "handbook": "No test of this brake supports these numbers",
}
"""{word that a prediction rests on: its meaning}; others are not shown."""
SUBJECTS: Mapping[str, str] = {
    "next test": "95 % of further tests are within it, scatter between tests included",
    "mean": "The mean of many tests is within it with a probability of 95 %",
}
"""{what an interval contains: a sentence about it}."""


def find_interval(source: Any, key: str) -> Mapping[str, Any] | None:
    """Return the interval of a number of a result, or of a row of its tables, or None."""
    if isinstance(source, Mapping):
        intervals = source.get("intervals")
    else:
        intervals = getattr(source, "intervals", None)
    return (intervals or {}).get(key)


def without_intervals(result: Any) -> Any:
    """Return a result whose rows state its numbers only, for the narrow columns of a table."""
    return replace(result, intervals=None) if isinstance(result, PredictionResult) else result


def interval_text(
    source: Any, key: str, unit: str, reference: float | None = None, digits: int = DIGITS
) -> str:
    """Return such as "95 %: 81.4 N to 98.9 N" for a number of a result, or an empty text.

    The unit suits `reference`, which is the number itself.
    """
    ends = find_interval(source, key)
    return "" if ends is None else format_ends((ends["low"], ends["high"]), unit, reference, digits)


def interval_meaning(source: Any, key: str) -> str:
    """Return a sentence on what the interval of a number contains, or an empty text."""
    ends = find_interval(source, key)
    return "" if ends is None else SUBJECTS.get(str(ends.get("of")), "")


def basis_html(source: Any, ident: str, subject: str = "") -> str:
    """Return the word that a result rests on as a badge and its reason, or an empty text.

    The `subject` precedes the reason if the word is not about all numbers above it.
    """
    word = str(getattr(source, "basis", ""))
    if word not in BASES:
        return ""
    meaning = BASES[word]
    reason = typeset_text(getattr(source, "basis_reason", "") or meaning)
    reason = f"{subject}: {reason[:1].lower()}{reason[1:]}" if subject else reason
    reason = f"{reason[:1].upper()}{reason[1:]}"
    badge = f'<span class="basis" data-basis="{word}" title="{escape(meaning)}">{word}</span>'
    return f'<p class="basis-line" data-testid="{escape(ident)}">{badge} {escape(reason)}</p>'
