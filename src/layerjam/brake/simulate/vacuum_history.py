"""Changing vacuum, as samples in time."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from layerjam.brake.fluid.closed_forms import leak_down_time
from layerjam.brake.simulate.quantities import VACUUM
from layerjam.core.errors import QuantityError, explain_arguments
from layerjam.core.units import QuantitySpec, show

Array = np.ndarray[Any, np.dtype[np.float64]]
LEAK_SAMPLES = 2048
TIME = QuantitySpec("s", "time since the rope became taut", lo=-1e9, hi=1e9)


@explain_arguments
@dataclass(frozen=True, eq=False)
class History:
    """Changing vacuum: samples [Pa] and times since the rope is taut [s], interpolated linearly.

    Shape (N,) each, N >= 2, times rising. The vacuum is constant before the first and after the
    last sample. Raises QuantityError for other shapes, times that do not rise, and values that are
    negative or not finite.
    """

    time: Array = field(repr=False)
    vacuum: Array = field(repr=False)

    def __post_init__(self) -> None:
        for name in ("time", "vacuum"):
            try:
                values = np.array(getattr(self, name), float)
            except (TypeError, ValueError):
                raise QuantityError(f"history: {name} is not a row of numbers") from None
            object.__setattr__(self, name, values)
        time, vacuum = self.time, self.vacuum
        if time.ndim != 1 or time.shape != vacuum.shape or len(time) < 2:
            raise QuantityError(
                f"history: time has shape {time.shape}, vacuum {vacuum.shape}; pass two rows of "
                "the same length with at least two samples"
            )
        for values, spec, label in ((time, TIME, "time"), (vacuum, VACUUM, "vacuum")):
            invalid_indices = np.flatnonzero(~(np.isfinite(values) & (values >= spec.lo)))
            if len(invalid_indices):
                spec.check(
                    float(values[invalid_indices[0]]),
                    f"history: {label} of sample {invalid_indices[0] + 1}",
                )
        wrong_times = np.flatnonzero(np.diff(time) <= 0)
        if len(wrong_times):
            k = int(wrong_times[0]) + 1
            raise QuantityError(
                f"history: time of sample {k + 1}, {show(float(time[k]), 's')}, is not after "
                f"the previous one, {show(float(time[k - 1]), 's')}; times must increase"
            )

    @classmethod
    def leaking(
        cls, vacuum: float, leak_time: float, atmosphere: float, held: float = 0.0
    ) -> "History":
        """Return a leaking vacuum [Pa]; the line is shut off `held` [s] before the rope is taut.

        `leak_time` [s] is the volume of the chamber divided by the conductance of the leak. The
        samples follow `fluid.closed_forms.held_vacuum` to 1.2e-7 of `vacuum`, down to 2.4e-7.
        """
        if not vacuum > 0:
            return cls(np.array([-held, 1.0 - held]), np.full(2, vacuum))
        # equal steps of the square root approximate an exponential equally well everywhere
        vacuum_left = vacuum * np.linspace(1.0, 1.0 / LEAK_SAMPLES, LEAK_SAMPLES) ** 2
        return cls(
            leak_down_time(vacuum_left, vacuum, 1 / leak_time, atmosphere) - held, vacuum_left
        )

    def interpolate(self, time: Any) -> Array:
        """Return the vacuum [Pa] at times [s]."""
        return np.asarray(np.interp(time, self.time, self.vacuum))

    def check_site(self, atmosphere: float) -> None:
        """Raise QuantityError if the vacuum exceeds the atmosphere [Pa]."""
        excess = np.flatnonzero(self.vacuum > atmosphere)
        if len(excess):
            raise QuantityError(
                f"history: vacuum of sample {excess[0] + 1}, "
                f"{show(float(self.vacuum[excess[0]]), 'Pa', 6)}, exceeds atmospheric pressure, "
                f"{show(atmosphere, 'Pa', 6)}; reduce it"
            )

    def list_notices(self) -> list[str]:
        """Return a notice if the history does not begin at the instant when the rope is taut."""
        first, vacuum = float(self.time[0]), show(float(self.vacuum[0]), "Pa")
        if first > 0:
            return [
                f"the history begins {show(first, 's')} after the rope is taut; until then its "
                f"first vacuum, {vacuum}, is assumed"
            ]
        if first < 0:
            return [
                f"the history begins {show(-first, 's')} before the rope is taut; the drop starts "
                f"at time 0 of the history with {show(float(self.interpolate(0.0)), 'Pa')}"
            ]
        return []

    at, remarks = interpolate, list_notices  # former names
