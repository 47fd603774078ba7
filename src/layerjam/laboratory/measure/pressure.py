"""Absolute pressure of a log, and the readings of its column that physics allows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.core.errors import FileError, FitError
from layerjam.core.units import show
from layerjam.laboratory.measure.log import Log, find_reference
from layerjam.laboratory.measure.options import REFERENCES
from layerjam.laboratory.measure.trace import Array

BELOW_ZERO = 0.01
"""Largest negative absolute pressure that a sensor's error explains, relative to the atmosphere."""
ABOVE_ATMOSPHERE = 5e3
"""Largest negative vacuum [Pa] that a sensor's error explains."""
Test = Callable[[Array], object]
"""Function that raises FitError for an absolute pressure that a test cannot have."""


@dataclass(frozen=True)
class Pressure:
    """Pressure of a log: `value` [Pa], shape (N,), in the reference `reading` of its column."""

    value: Array
    reading: str
    atmosphere: float
    notices: list[str]

    @property
    def absolute(self) -> Array:
        """Absolute pressure [Pa], shape (N,)."""
        around = self.atmosphere
        by_kind = {"absolute": self.value, "gauge": around + self.value}
        return by_kind.get(self.reading, around - self.value)

    @property
    def vacuum(self) -> Array:
        """Pressure below atmospheric [Pa], shape (N,)."""
        by_kind = {"vacuum": self.value, "gauge": -self.value}
        return by_kind.get(self.reading, self.atmosphere - self.value)


def read_absolute(
    log: Log, reading: str | None, atmosphere: float, zero: float = 0.0, test: Test | None = None
) -> Pressure:
    """Return the absolute pressure of a log; `reading` is the user's reference, or None.

    `atmosphere` [Pa] is that of the site, `zero` [Pa] the sensor's reading there. `test` raises
    FitError for a pressure that contradicts the test, such as one that rises while a pump runs.
    Raises FileError if the reference is unknown or impossible; it names those that are possible.
    """
    column, value = log.taken["pressure"], log["pressure"] - zero
    stated_reading = find_reference(column)
    reads = {kind: Pressure(value, kind, atmosphere, list(log.notices)) for kind in REFERENCES}

    def list_possible(is_suitable: Test | None) -> list[str]:
        return [kind for kind, read in reads.items() if not _explain_impossible(read, is_suitable)]

    kind = reading or stated_reading
    if kind is None:
        raise FileError(
            log.path,
            f"does not state whether the pressure in '{column.name[:60]}' is absolute, above "
            "atmospheric pressure (gauge) or below it (vacuum); state it",
            how=_format_hint(list_possible(test) or list_possible(None) or REFERENCES),
            asks="reading",
        )
    fault = _explain_impossible(reads[kind], test)
    if fault is not None:
        can_exist = _explain_impossible(reads[kind], None) is None
        possible = list_possible(test) or ([] if can_exist else list_possible(None))
        lowest_gauge = -float(value.min())
        if (
            kind == "vacuum" and ABOVE_ATMOSPHERE < lowest_gauge < value.max()
        ):  # the log is mostly vacuum
            fault += "; check the sensor's zero, its reading at atmospheric pressure"
            possible = []
        name = f"column '{column.name[:60]}'"
        raise FileError(
            log.path,
            f"{name} cannot be read as {kind}: {fault}; state what it is"
            if possible
            else f"{name}: {fault}",
            how=_format_hint(possible) if possible else "",
            asks="reading" if possible else "",
        )
    read = reads[kind]
    if stated_reading not in (None, kind):
        sentence = (
            f"{log.name}: its column states {stated_reading}, but --reading {kind} takes precedence"
        )
        read.notices.append(sentence)
    return read


def _explain_impossible(pressure: Pressure, test: Test | None) -> str | None:
    """Return why a pressure cannot have its reference, or None."""
    low, high = float(pressure.absolute.min()), float(pressure.absolute.max())
    around = pressure.atmosphere
    if low < -BELOW_ZERO * around:
        return f"its absolute pressure falls to {show(low, 'Pa')}: check its unit and zero"
    if pressure.reading == "vacuum" and high > around + ABOVE_ATMOSPHERE:
        return f"its vacuum falls to {show(around - high, 'Pa')}, far above atmospheric pressure"
    try:
        if test is not None:
            test(np.maximum(pressure.absolute, 1.0))
    except FitError as error:
        return str(error)
    return None


def _format_hint(readings: Sequence[str]) -> str:
    return f" ({' or '.join(f'--reading {reading}' for reading in readings)})"
