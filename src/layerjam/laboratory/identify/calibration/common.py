"""Uncertainties that all pulls share, so that their scatter does not show them.

They are the mounting, the instruments and the zero of the force. Each is a line of the budget of
the scale factor, and part of the intervals of all fitted values.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.core.verdict import Level
from layerjam.laboratory.identify.calibration.budget import Contribution, Peak, make_limit_lines
from layerjam.laboratory.identify.calibration.mountings import Mountings
from layerjam.laboratory.identify.curves import Curve
from layerjam.laboratory.identify.fit_checks import Check, check, format_percent
from layerjam.laboratory.identify.shape import SHAPE

MOUNTING, CELL, GAUGE, ZERO = "mounting", "load cell", "vacuum gauge", "zero of the force"
OTHERS: Mapping[str, Mapping[str, float]] = {
    CELL: dict(zip(SHAPE[1:], (1.0, 2.0), strict=True)),
    GAUGE: dict(zip(SHAPE[1:], (0.0, 1.0), strict=True)),
    ZERO: dict(zip(SHAPE[1:], (0.0, 4.0), strict=True)),
}
"""{line: {value: relative change per relative change of the input}} besides the scale factor.

A stiffness is a force over a length. The enclosure's force is the root of its factor times the
vacuum. A constant force resembles the sheets at first and the enclosure at the end of a pull, where
the enclosure has a sixth of the force.
"""
NOTED, TOO_LARGE = 0.02, 0.1
"""Force before the rise, relative to the peak, from which on it is a warning, and a failure."""


def list_common_lines(
    curves: Sequence[Curve], brake: Brake, mountings: Mountings, *, zero: bool = True
) -> tuple[Contribution, ...]:
    """Return the budget lines of everything that pulls share, except the enclosure's force.

    `zero` is False if the zero of the force was fitted.
    """
    peaks = [Peak(c.peak_force, c.vacuum) for c in curves]
    sd, offset = mountings.unseen.get(SHAPE[0]), abs(mean_offset(curves))
    lines = []
    if sd is not None:
        lines.append(
            Contribution(
                what=MOUNTING,
                basis=f"relative SD {sd:.2g}, because {mountings.reason}",
                standard=sd,
                sensitivity=1.0,
                supply=mountings.supply,
            )
        )
    lines += make_limit_lines(peaks, brake, find_widest_limits(curves))
    if zero and offset:
        basis = f"force before the rise, {offset:.2g} of the peak; a preload or a zero error"
        standard = offset / math.sqrt(3)
        lines.append(Contribution(what=ZERO, basis=basis, standard=standard, sensitivity=1.0))
    return tuple(lines)


def describe_basis(scatter: str, lines: Sequence[Contribution]) -> str:
    """Return the basis of the intervals: `scatter` and the lines that are stated."""
    parts = [f"{line.what}, {line.basis}" for line in lines if line.relative]
    return "; ".join([scatter, *parts])


def combine_common(lines: Sequence[Contribution], mountings: Mountings) -> dict[str, float]:
    """Return {value: relative standard uncertainty} that all pulls share, from their lines."""
    common = {SHAPE[0]: math.hypot(*(line.relative or 0.0 for line in lines))}
    for name in SHAPE[1:]:
        parts = [
            OTHERS[line.what][name] * line.standard
            for line in lines
            if line.what in OTHERS and line.standard
        ]
        common[name] = math.hypot(*parts, mountings.unseen.get(name, 0.0))
    return common


def find_widest_limits(curves: Sequence[Curve]) -> dict[str, float | None]:
    """Return the widest error limit of each instrument; None if a pull does not state it."""
    widest: dict[str, float | None] = {}
    for name in ("load_cell", "gauge"):
        limits = [curve.limits.get(name) for curve in curves]
        values = [limit for limit in limits if limit is not None]
        widest[name] = max(values) if values and len(values) == len(limits) else None
    return widest


def list_missing(lines: Sequence[Contribution]) -> list[str]:
    """Return the instruments whose error is not stated, and therefore not included."""
    return [line.what for line in lines if line.what in (CELL, GAUGE) and line.standard is None]


def mean_offset(curves: Sequence[Curve]) -> float:
    """Return the mean force before the rise, relative to the peak; 0 if no pull shows it."""
    shares = [c.baseline / c.peak_force for c in curves if c.baseline is not None]
    return float(np.mean(shares)) if shares else 0.0


def check_zero(curves: Sequence[Curve]) -> Check:
    """Check the force before the rise: its interpretation changes the scale factor by its share."""
    offset = mean_offset(curves)
    sentence = f"before the rise the force is {format_percent(offset)} of the peak"
    advice = (
        ": a preload or a zero error. The interval includes it; --tare subtracts it, if nothing "
        "pulled at the brake before"
    )
    level: Level = "failed" if abs(offset) >= TOO_LARGE else "warning"
    return check("zero", abs(offset) < NOTED, sentence, advice, level)
