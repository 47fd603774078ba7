"""Return stroke of the crosshead after a pull: stiffness, residual force and energy."""

from dataclasses import dataclass

import numpy as np

from layerjam.identify.straight import StraightLine, fit_line
from layerjam.measure.trace import Array

PART = (0.9, 0.2)
"""Range of the stiffness fit, relative to the force at the reversal."""
LEAST_WAY_BACK = 0.02
"""Smallest travel of a return, relative to the pull."""
FEWEST_BACK = 8
"""Minimum number of samples of a return."""


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
    turn = len(elongation) - 1 - int(np.argmax(elongation[::-1]))
    # the crosshead may pause at the reversal
    first = int(np.argmax(elongation))
    return_path, fall = elongation[turn:], force[turn:]
    if len(return_path) < FEWEST_BACK or longest - float(return_path.min()) < LEAST_WAY_BACK * (
        longest - shortest
    ):
        return None
    last = int(np.argmin(return_path)) + 1
    return_path, fall = return_path[:last], fall[:last]
    few = max(1, min(len(fall) // 50, 5))
    top = float(np.median(force[max(first - few, 0) : turn + 1]))
    steep = _fit_return(return_path, fall, top, baseline)
    out, pull_force = elongation[: first + 1], force[: first + 1]
    work, work_back = _compute_loop_area(out, pull_force), -_compute_loop_area(return_path, fall)
    end = max(1, len(fall) // 100)
    return Unloading(
        stiffness=steep and steep.slope,
        stiffness_se=steep and steep.slope_se,
        force_at_reversal=top,
        elongation_at_reversal=longest - onset,
        residual_force=float(fall[-end:].mean()),
        residual_elongation=None if steep is None else steep.meets(baseline) - onset,
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


def _compute_loop_area(x: Array, y: Array) -> float:
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1])) / 2)


def _weight_norm(x: Array) -> float:
    """Return the norm of the samples' weights in a trapezoidal sum."""
    step = np.diff(x)
    return float(np.sqrt(np.sum((np.r_[step, 0.0] + np.r_[0.0, step]) ** 2))) / 2
