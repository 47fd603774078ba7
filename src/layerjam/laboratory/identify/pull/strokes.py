"""Strokes after the first rise: a second rise if the brake is switched on, and the return."""

from dataclasses import dataclass

import numpy as np

from layerjam.laboratory.identify.statistics import StraightLine, fit_line
from layerjam.laboratory.identify.stick_slip import Indices
from layerjam.laboratory.measure.noise import noise_sd
from layerjam.laboratory.measure.trace import Array

BLOCKS = 100
"""Number of equal parts of the travel to the peak, each with its mean force."""
LEAST_PARTS = 20
"""Minimum number of parts, of two samples each, that can show two rises."""
FEWEST = 3
"""Minimum number of initial samples whose mean is the force at the start."""
FLAT = 0.15
"""Largest slope between the rises, relative to the steepest part before and after."""
LONG = 0.15
"""Smallest fraction of the travel between the two rises."""
RAISED = 0.2
"""Smallest force before the only rise, relative to the peak, that hides the foot of the rise."""
FIRST, SECOND = 0.05, 0.2
"""Smallest fraction of the total force for each rise."""
CLEAR = 6.0
"""Smallest rise, in standard deviations of the mean over the initial samples."""
PART = (0.9, 0.2)
"""Range of the stiffness fit, relative to the force at the reversal."""
LEAST_WAY_BACK = 0.02
"""Smallest travel of a return, relative to the pull."""
FEWEST_BACK = 8
"""Minimum number of samples of a return."""


@dataclass(frozen=True, kw_only=True)
class SecondRise:
    """Second rise of a record: its start [m], and the forces [N] at its start and at its top.

    `index` is the sample at its start, in the loading branch.
    """

    start: float
    index: int
    force_before: float
    force_after: float


@dataclass(frozen=True)
class _Parts:
    """Mean forces [N] of the initial samples and of equal parts of the travel to the peak.

    For each sample up to the peak, `part` is the index of the part to which it belongs; `few` is
    the number of initial samples.
    """

    mean: Array
    part: Indices
    few: int

    @classmethod
    def divide_record(cls, elongation: Array, force: Array) -> "_Parts | None":
        top = int(np.argmax(force))
        travel = float(elongation[top] - elongation[0])
        count = min(BLOCKS, (top + 1) // 2)
        if not travel > 0 or count < LEAST_PARTS:
            return None
        share = (elongation[: top + 1] - elongation[0]) / travel
        part = np.clip((share * count).astype(np.intp), 0, count - 1)
        samples = np.bincount(part, minlength=count)
        if samples.min() < 1:
            return None
        # a steep first rise may end within the first part
        width = max(FEWEST, int(np.median(samples)) // 20)
        mean = np.bincount(part, force[: top + 1], minlength=count) / samples
        return cls(np.r_[float(force[:width].mean()), mean], part, width)


def find_raised_lead(elongation: Array, force: Array) -> float | None:
    """Return the force [N] of a flat section before a single rise, if above a fifth of the peak.

    A stiffness is fitted from that level up, so such a section would be fitted as part of the rise.
    """
    parts = _Parts.divide_record(elongation, force)
    if parts is None:
        return None
    slope = np.diff(parts.mean)
    steep_indices = np.flatnonzero(slope >= FLAT * slope.max())
    lead = int(steep_indices[0]) if len(steep_indices) else 0
    mean = float(parts.mean[:lead].mean()) if lead else 0.0
    return mean if mean > RAISED * parts.mean[-1] else None


def find_second_rise(elongation: Array, force: Array) -> SecondRise | None:
    """Return the second rise of a loading branch, arrays of shape (N,); None if it has only one.

    A friction force has one rise, followed by sliding. Between two rises there is a section that is
    much flatter than the steepest parts before and after it.
    """
    parts = _Parts.divide_record(elongation, force)
    if parts is None:
        return None
    mean, threshold = parts.mean, CLEAR * noise_sd(force) / parts.few**0.5
    slope = np.diff(mean)
    steepest_before = np.maximum.accumulate(slope)
    steepest_after = np.maximum.accumulate(slope[::-1])[::-1]
    height = float(mean[-1] - mean[0])
    is_flat = slope < FLAT * np.minimum(steepest_before, steepest_after)
    edges = np.flatnonzero(np.diff(np.r_[False, is_flat, False].astype(int)))
    for begin, end in edges.reshape(-1, 2).tolist():
        first, second = float(mean[begin] - mean[0]), float(mean[-1] - mean[end])
        if (
            end - begin >= LONG * len(slope)
            and first > max(FIRST * height, threshold)
            and second > max(SECOND * height, threshold)
        ):
            index = int(np.argmax(parts.part >= end - 1))
            return SecondRise(
                start=float(elongation[index]),
                index=index,
                force_before=float(mean[end]),
                force_after=float(mean[-1]),
            )
    return None


@dataclass(frozen=True, kw_only=True)
class Unloading:
    """Unloading branch of a pull, in SI units.

    `stiffness` is the slope just after the reversal [N/m], or None if it has fewer than 4 samples.
    `residual_force` is the mean force over the last 1 % of the return [N]. `residual_elongation` is
    the distance from the onset to the point where that slope meets the baseline [m]. `work` is the
    work done during loading [J], `returned` the work recovered during the return [J]. `loop` is
    their difference, which is dissipated if the return reaches the onset (`closed`).
    """

    stiffness: float | None
    stiffness_se: float | None
    force_at_reversal: float
    elongation_at_reversal: float
    residual_force: float
    residual_elongation: float | None
    work: float
    returned: float
    loop: float
    loop_se: float
    closed: bool


def find_unloading(
    elongation: Array, force: Array, onset: float, baseline: float, noise: float
) -> Unloading | None:
    """Return the unloading in a whole record, arrays of shape (N,); None if it has none.

    `onset` is the elongation at which the pull began [m], `baseline` the force there [N], `noise`
    the standard deviation of one sample [N].
    """
    longest, shortest = float(elongation.max()), float(elongation.min())
    turn_index = len(elongation) - 1 - int(np.argmax(elongation[::-1]))
    # the crosshead may pause at the reversal
    first = int(np.argmax(elongation))
    return_path, fall = elongation[turn_index:], force[turn_index:]
    if len(return_path) < FEWEST_BACK or longest - float(return_path.min()) < LEAST_WAY_BACK * (
        longest - shortest
    ):
        return None
    last = int(np.argmin(return_path)) + 1
    return_path, fall = return_path[:last], fall[:last]
    width = max(1, min(len(fall) // 50, 5))
    top = float(np.median(force[max(first - width, 0) : turn_index + 1]))
    return_line = _fit_return(return_path, fall, top, baseline)
    out, pull_force = elongation[: first + 1], force[: first + 1]
    work = float(np.trapezoid(pull_force, out))
    work_back = -float(np.trapezoid(fall, return_path))
    end = max(1, len(fall) // 100)
    return Unloading(
        stiffness=return_line and return_line.slope,
        stiffness_se=return_line and return_line.slope_se,
        force_at_reversal=top,
        elongation_at_reversal=longest - onset,
        residual_force=float(fall[-end:].mean()),
        residual_elongation=None if return_line is None else return_line.meets(baseline) - onset,
        work=work,
        returned=work_back,
        loop=work - work_back,
        loop_se=noise * float(np.hypot(_weight_norm(out), _weight_norm(return_path))),
        closed=float(return_path[-1]) - onset <= 0.01 * (longest - shortest),
    )


def _fit_return(
    return_path: Array, fall: Array, top: float, baseline: float
) -> StraightLine | None:
    """Return the line fitted to the first part of the return; None if it has too few samples."""
    high, low = (baseline + part * (top - baseline) for part in PART)
    below_high, below_low = np.flatnonzero(fall <= high), np.flatnonzero(fall <= low)
    if top <= baseline or not len(below_low):
        return None
    part = slice(below_high[0], below_low[0])
    line = fit_line(return_path[part], fall[part]) if below_low[0] - below_high[0] >= 4 else None
    return line if line is not None and line.slope > 0 else None


def _weight_norm(x: Array) -> float:
    """Return the norm of the samples' weights in a trapezoidal sum."""
    step = np.diff(x)
    return float(np.sqrt(np.sum((np.r_[step, 0.0] + np.r_[0.0, step]) ** 2))) / 2
