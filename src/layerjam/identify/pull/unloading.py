"""What a pull shows on its return: stiffness, what is left of it, and the energy of the loop."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from layerjam.identify.straight import StraightLine, straight_line
from layerjam.measure.trace import Array

PART = (0.9, 0.2)
"""Of the force at the reversal: between them the stiffness is taken."""
LEAST_WAY_BACK = 0.02
"""A return shorter than this part of the pull is none."""
FEWEST = 8


@dataclass(frozen=True, kw_only=True)
class Unloading:
    """The unloading branch of a pull, SI units.

    `stiffness` is the slope just after the reversal [N/m], None where fewer than 4 samples lie on
    it. `residual_force` is the mean force over the last hundredth of the return [N].
    `residual_elongation` is how far from the onset of the pull the force meets its baseline again
    along that slope [m], None with it. `work` goes in on the way out [J], `returned` comes back;
    `loop`, their difference, is what the brake kept: dissipated if the return leads to the onset
    (`closed`).
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
    """The unloading of a whole record, arrays of shape (N,); None where it has none.

    `onset` is the elongation where the pull began [m], `baseline` the force there [N], `noise` one
    sample's standard deviation [N].
    """
    most, least = float(elongation.max()), float(elongation.min())
    turn = len(elongation) - 1 - int(np.argmax(elongation[::-1]))
    # the crosshead may stand there for a while
    first = int(np.argmax(elongation))
    back, fall = elongation[turn:], force[turn:]
    if len(back) < FEWEST or most - float(back.min()) < LEAST_WAY_BACK * (most - least):
        return None
    last = int(np.argmin(back)) + 1
    back, fall = back[:last], fall[:last]
    few = max(1, min(len(fall) // 50, 5))
    top = float(np.median(force[max(first - few, 0) : turn + 1]))
    steep = _steep(back, fall, top, baseline)
    out, pulled = elongation[: first + 1], force[: first + 1]
    work, returned = _area(out, pulled), -_area(back, fall)
    end = max(1, len(fall) // 100)
    return Unloading(
        stiffness=steep and steep.slope,
        stiffness_se=steep and steep.slope_se,
        force_at_reversal=top,
        elongation_at_reversal=most - onset,
        residual_force=float(fall[-end:].mean()),
        residual_elongation=None if steep is None else steep.meets(baseline) - onset,
        work=work,
        returned=returned,
        loop=work - returned,
        loop_se=noise * float(np.hypot(_weight(out), _weight(back))),
        closed=float(back[-1]) - onset <= 0.01 * (most - least),
    )


def _steep(back: Array, fall: Array, top: float, baseline: float) -> StraightLine | None:
    """The line through the beginning of the return; None where it has too few samples."""
    high, low = (baseline + part * (top - baseline) for part in PART)
    under, gone = np.flatnonzero(fall <= high), np.flatnonzero(fall <= low)
    if top <= baseline or not len(gone):
        return None
    part = slice(under[0], gone[0])
    line = straight_line(back[part], fall[part]) if gone[0] - under[0] >= 4 else None
    return line if line is not None and line.slope > 0 else None


def _area(x: Array, y: Array) -> float:
    return float(np.sum(np.diff(x) * (y[1:] + y[:-1])) / 2)


def _weight(x: Array) -> float:
    """Norm of the weights a trapezoidal sum gives its samples."""
    step = np.diff(x)
    return float(np.sqrt(np.sum((np.r_[step, 0.0] + np.r_[0.0, step]) ** 2))) / 2
