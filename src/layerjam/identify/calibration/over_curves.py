"""What every calibration over whole curves says, however it was fitted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from layerjam.identify.calibration.intervals import Interval
from layerjam.identify.checks import Check
from layerjam.identify.curves import Curve
from layerjam.records.source import Source
from layerjam.units import show


@dataclass(frozen=True, kw_only=True, eq=False)
class OverCurves:
    """Parameters in SI units with their 95 % intervals, None where nothing tells one."""

    values: Mapping[str, float]
    intervals: Mapping[str, Interval | None]
    checks: tuple[Check, ...]
    curves: tuple[Curve, ...]
    errors_rest_on: str

    @property
    def scale_factor(self) -> float:
        """a [-]."""
        return self.values["scale_factor"]

    @property
    def stiffness(self) -> float:
        """k [N/m]."""
        return self.values["stiffness"]

    @property
    def files(self) -> tuple[str, ...]:
        """Paths of the curves' files."""
        return tuple(c.path for c in self.curves)

    def standard_error(self, name: str) -> float | None:
        """Of a parameter: from the scatter between curves, or the posterior's deviation."""
        found = self.intervals.get(name)
        return None if found is None else found.standard_error


def calibrated(
    value: float, text: str, error: float | None, unit: str, word: str = "standard error"
) -> tuple[float, Source]:
    """A value for a brake file with its source; `word` says what `error` is, in `unit`."""
    spread = "" if error is None else f"{word} {show(error, unit, 2)}"
    return float(value), Source(kind="calibrated", text=text, spread=spread)
