"""Results of commands that predict: numbers with an interval for the next test, and a basis."""

from collections.abc import Mapping, Sequence
from dataclasses import Field
from typing import Any

from layerjam.core.command.results import Result, fact, result


@result
class PredictionResult(Result):
    """Base of results whose numbers have an interval, and whose `basis` is a word.

    `intervals` {key: {"low", "high", "level", "of"}} are for the next test, or for the mean of many
    tests; None marks an open end. `extrapolated` lists the conditions outside the tested range,
    each with `quantity`, `value`, `low` and `high` in SI.
    """

    intervals: Mapping[str, Mapping[str, Any]] | None = fact(
        "95 % intervals for the next test, scatter included", listed=False, default=None
    )
    basis: str | None = fact("tested, extrapolated or handbook", default=None)
    extrapolated: Sequence[Mapping[str, Any]] = fact(
        "conditions outside the tested range", listed=False, default=()
    )
    basis_reason: str = fact("reason for the basis", listed=False, default="")

    def interval(self, name: str) -> tuple[Any, Any]:
        """Return the 95 % interval of a number; None marks an open end.

        Raises UnknownNameError for a number without an interval.
        """
        ends = (self.intervals or {}).get(name)
        return super().interval(name) if ends is None else (ends["low"], ends["high"])

    def find_interval(self, f: Field[Any]) -> tuple[float | None, float | None]:
        """Return the interval of a number for the next test; None marks an open end."""
        ends = (self.intervals or {}).get(f.name)
        return super().find_interval(f) if ends is None else (ends["low"], ends["high"])

    def rows(self) -> list[tuple[str, str]]:
        """Return the rows, with the reason next to the basis."""
        return [
            (
                name,
                f"{text}: {self.basis_reason}" if name == "basis" and self.basis_reason else text,
            )
            for name, text in super().rows()
        ]
