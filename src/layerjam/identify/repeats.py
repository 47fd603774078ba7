"""Mean and 95 % interval over repeats: the repeat is the unit, its samples are not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

LEVEL = 0.95


@dataclass(frozen=True, kw_only=True)
class OverRepeats:
    """What `repeats` values of one quantity say, in the quantity's unit.

    `sd` is the sample standard deviation, `low` and `high` bound the mean with 95 % confidence by
    Student's t with `repeats` - 1 degrees of freedom; all four are None for one repeat.
    """

    mean: float
    sd: float | None
    standard_error: float | None
    low: float | None
    high: float | None
    repeats: int

    def interval_words(self) -> str:
        """The interval in words."""
        if self.low is None or self.high is None:
            return "one repeat"
        return f"95 % interval {self.low:.4g} to {self.high:.4g} (t, {self.repeats} repeats)"

    def as_dict(self) -> dict[str, float | int | None]:
        """The fields by name, for JSON."""
        return asdict(self) | {"level": LEVEL}


def over_repeats(values: Sequence[float]) -> OverRepeats:
    """Mean, SD, standard error and 95 % t interval of one value a repeat; at least one."""
    from scipy.special import stdtrit

    found = np.asarray(values, float)
    mean, count = float(found.mean()), len(found)
    if count < 2:
        return OverRepeats(
            mean=mean, sd=None, standard_error=None, low=None, high=None, repeats=count
        )
    sd = float(found.std(ddof=1))
    error = sd / count**0.5
    reach = float(stdtrit(count - 1, 0.5 + LEVEL / 2)) * error
    return OverRepeats(
        mean=mean, sd=sd, standard_error=error, low=mean - reach, high=mean + reach, repeats=count
    )
