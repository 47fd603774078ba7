"""What the sliding part of a pull says of the scale factor, whatever its peak says."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from layerjam.device.brake import Brake
from layerjam.identify.calibration.pull_fit import PullFit
from layerjam.identify.checks import SMALL
from layerjam.identify.pull.features import FEWEST
from layerjam.identify.shape import with_shape
from layerjam.measure.trace import Array, block_means
from layerjam.mechanics.pull import brake_force

AFTER = 0.1
"""Part of the way from the peak to the end before the sliding part is compared with the peak."""
MEANS = 256
"""Means over neighbouring samples that stand for the sliding part: the law there is smooth."""


def after_peaks(
    fits: Sequence[PullFit | None], stiffness: float | None, brake: Brake
) -> list[float | None]:
    """By which part each sliding part's scale factor lies off its peak's; None where it is short.

    The force there is linear in the sheets' share and the enclosure's, both free, so that what the
    enclosure's numbers are off does not count. The first tenth of the way is left out: static
    friction fades in it. `stiffness` [N/m] serves pulls that tell none.
    """
    out: list[float | None] = [None] * len(fits)
    parts: list[tuple[int, PullFit, Array, Array]] = []
    for place, fit in enumerate(fits):
        spring = None if fit is None else fit.stiffness or stiffness
        if fit is None or spring is None:
            continue
        slip, force = _sliding(fit, spring)
        if len(slip) >= FEWEST:
            parts.append((place, fit, slip, force))
    if not parts:
        return out
    # few shapes, so that few are compiled
    size = max(4, 1 << (len(parts) - 1).bit_length())
    slips, column = np.zeros((size, MEANS)), np.ones((size, 1))
    vacuum, factor = column.copy(), column.copy()
    for row, (_, fit, slip, _) in enumerate(parts):
        slips[row, : len(slip)], vacuum[row] = slip, fit.vacuum
        factor[row] = fit.scale_factor * fit.growth
    spring = stiffness or brake.stiffness_measured or 1.0  # slip is given: it does not count
    loose, whole = (with_shape(brake, a, spring, 1.0) for a in (0.0 * factor, factor))
    enclosure = np.asarray(brake_force(slips, vacuum, loose))
    sheets = np.asarray(brake_force(slips, vacuum, whole)) - enclosure
    for row, (place, _, slip, force) in enumerate(parts):
        basis = np.stack([sheets[row, : len(slip)], enclosure[row, : len(slip)]])
        out[place] = _share(basis, force)
    return out


def _sliding(fit: PullFit, stiffness: float) -> tuple[Array, Array]:
    """Slip [m] and force [N] from some way after the peak on, means over neighbours."""
    u, force, begin = fit.pull.elongation, fit.pull.force, fit.pull.peak_elongation
    start = begin + AFTER * (float(u[-1]) - begin)
    # the branch rises, so that all from the first sample there on lies after it
    first = int(np.argmax(u >= start))
    u, force = block_means(u[first:], MEANS), block_means(force[first:], MEANS)
    return np.maximum(u - force / stiffness, 0.0), force


def _share(basis: Array, force: Array) -> float | None:
    """Factor on the sheets' own force less 1, by least squares; None where the noise leaves it."""
    inner = basis @ basis.T
    (sheets, both), (_, enclosure) = inner.tolist()
    apart = sheets * enclosure - both**2
    if not apart > 1e-6 * sheets * enclosure:
        return None
    right = basis @ force
    share = (enclosure * right[0] - both * right[1]) / apart
    other = (sheets * right[1] - both * right[0]) / apart
    rest = force - share * basis[0] - other * basis[1]
    error = np.sqrt(rest @ rest / (len(rest) - 2) * enclosure / apart)
    return float(share) - 1 if error < SMALL / 2 else None
