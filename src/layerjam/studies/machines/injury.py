"""Injury criteria of the standards; every constant has its source."""

import math

import numpy as np
import numpy.typing as npt

from layerjam.brake.simulate.accelerometer import LEAST_RATE, cfc_filter
from layerjam.laboratory.identify.logs.crash import head_injury_criterion

Array = npt.NDArray[np.float64]
BRIC_CRITICAL = (66.25, 56.45, 42.87)
"""Critical angular velocities [rad/s] about x, y and z: averages of those based on CSDM and MPS in
Takhounts et al. 2013 (Stapp 57), from elemance.com, knowledge base, "BrIC"."""
HIC_WINDOW = 0.015
"""Longest window [s] of HIC15, whose limit is 700 (49 CFR 571.208, law.cornell.edu)."""
_AIS2 = (0.602, 2.84)
"""Scale and shape of the risk of an AIS 2 injury as a function of BrIC, from the same page."""


def bric(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> float:
    """Return the brain injury criterion from the peak angular velocity [rad/s] about each axis."""
    parts = zip((x, y, z), BRIC_CRITICAL, strict=True)
    return math.sqrt(sum((speed / critical) ** 2 for speed, critical in parts))


def concussion_risk(value: float) -> float:
    """Return the probability of an AIS 2+ injury, given the BrIC (Takhounts et al. 2013)."""
    scale, shape = _AIS2
    return -math.expm1(-((value / scale) ** shape))


def hic15(acceleration: Array, dt: float) -> float:
    """Return HIC15 of the head's resultant acceleration [m/s^2], shape (N,), at equal steps [s]."""
    # ten samples per millisecond are enough, because windows are counted in samples
    stride = max(1, int(1e-4 / dt))
    return head_injury_criterion(acceleration[::stride], 1 / (dt * stride), HIC_WINDOW)[0]


def filter_signal(signal: Array, dt: float, cfc: float) -> Array:
    """Return a signal (N,) at equal steps [s] after the SAE J211-1 filter of a class.

    Raises QuantityError if the sampling rate is below ten times the class.
    """
    stride = max(1, int(1 / (dt * LEAST_RATE * cfc * 10)))
    slow_signal = cfc_filter(signal[::stride], 1 / (dt * stride), cfc)
    times = np.arange(len(signal)) * dt
    return np.interp(times, times[::stride], slow_signal)
