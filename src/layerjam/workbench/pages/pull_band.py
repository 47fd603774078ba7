"""The 95 % band of a pull of a calibrated brake: range of validity, pin and drawing."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layerjam.errors import QuantityError
from layerjam.report import style
from layerjam.simulate.record import TensileRecord
from layerjam.units import parse
from layerjam.workbench.call import Call
from layerjam.workbench.desk import Desk
from layerjam.workbench.pins import BAND, make_call
from layerjam.workbench.state import Pin

if TYPE_CHECKING:
    from layerjam.identify.calibration.law_spread import LawError
    from layerjam.report.style import Figure

ASKED = {"vacuum", "speed", "travel"}
"""Options of a pull that the calibrated law covers; a pull with others has no band."""
POINTS = 40
"""Number of elongations in each of three intervals; it is fixed, so that the law compiles once."""

WORDS = 0.35
"""Fraction of a figure's width that the name of a band occupies."""


class Band(NamedTuple):
    """Half-width of the 95 % band around a force [N], at some elongations [m]."""

    elongation: np.ndarray
    half_width: np.ndarray
    pulls: int

    @property
    def name(self) -> str:
        """Label of the band in a chart."""
        return f"95 % of {self.pulls} pulls"


def law_error(desk: Desk, call: Call) -> "LawError | None":
    """Return the law error for a pull.

    None if this tab did not calibrate the brake, or if the law does not cover the pull.
    """
    spread = desk.laws.get(call.subjects[0].text)
    if spread is None or call.name != "tensile" or call.options.keys() != ASKED:
        return None
    vacuum, speed = _pull_condition(call)
    return spread.error_at(vacuum, speed) if vacuum > 0 else None


def compute_band(error: "LawError", record: TensileRecord, call: Call) -> Band | None:
    """Return the band of a pull's `record`; None if the law error is unknown at its vacuum."""
    u = np.asarray(record.elongation, float)
    top = float(u[int(np.argmax(record.force))])
    # include the peak itself, where the force has a kink, with more points near it than beyond
    ends = 0.0, top, min(2 * top, (top + u[-1]) / 2), u[-1]
    stretches = [np.linspace(a, b, POINTS, endpoint=False) for a, b in pairwise(ends)]
    elongation = np.concatenate((*stretches, u[-1:]))
    half = error.half_width(record.brake.brake, elongation, *_pull_condition(call))
    return Band(elongation, half, error.pulls) if np.isfinite(half).all() else None


def compute_pinned_band(pin: Pin, result: Any) -> Band | None:
    """Return the band of a pinned pull, or None if the pin has none.

    Raises LayerjamError if a link contains invalid values.
    """
    if BAND not in pin.options:
        return None
    # import late: it is slow, and only a pinned band needs it
    from layerjam.identify.calibration.law_spread import LawError

    call = make_call(pin)
    if call.options.keys() != ASKED:
        raise QuantityError("band: requires a pull with a vacuum, a speed and a travel only")
    return compute_band(LawError.read(str(pin.options[BAND])), result.record, call)


def draw_bands(figure: "Figure", bands: Sequence[tuple[Band, TensileRecord, str]]) -> None:
    """Draw bands in the figure of a pull, each around its own record and in its own colour.

    Bands from the same number of pulls share a label, above the end of the highest band.
    """
    axes, ends = figure.axes[0], dict[str, tuple[float, float]]()
    for b, record, color in bands:
        force = np.interp(b.elongation, record.elongation, record.force)
        x, low, high = b.elongation * 1e3, force - b.half_width, force + b.half_width
        style.add_band(axes, x, low, high, color)
        above = float(high[x >= (1 - WORDS) * x[-1]].max()), float(x[-1])
        ends[b.name] = max(ends.get(b.name, above), above)
    for name, (y, x_end) in ends.items():
        style.add_label(axes, x_end, y, f"band: {name}", ha="right", va="bottom")


def _pull_condition(call: Call) -> tuple[float, float]:
    vacuum, speed = call.options["vacuum"], call.options["speed"]
    return parse(vacuum, "Pa", "vacuum"), parse(speed, "m/s", "speed")
