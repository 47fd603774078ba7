"""The 95 % band of a pull of a tested brake: its pin, its tested part, and drawing."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.brake.simulate.record import TensileRecord
from layerjam.core.drawing import style
from layerjam.core.errors import QuantityError
from layerjam.workbench.call import Call
from layerjam.workbench.pins import BAND, make_call
from layerjam.workbench.state import Pin

if TYPE_CHECKING:
    from layerjam.brake.simulate.pull_spread import PullBand
    from layerjam.core.drawing.style import Figure

ASKED = {"vacuum", "speed", "elongation"}
"""Options of a pull that the law covers; a pull with others has no band."""
NAME = "95 % of pulls"
"""Label of a band in a chart."""
WORDS = 0.35
"""Fraction of a figure's width that the name of a band occupies."""


def is_covered(call: Call) -> bool:
    """Return whether the law covers a pull."""
    return call.name == "tensile" and call.options.keys() == ASKED


def compute_band(call: Call, record: TensileRecord) -> "PullBand | None":
    """Return the band of a pull's `record`; None if untested or not covered by the law."""
    if not is_covered(call) or record.brake.valid_evidence("calibrate") is None:
        return None
    # import late, so that the first page is shown before the computing code is loaded
    from layerjam.brake.simulate.pull_spread import find_pull_band

    band = find_pull_band(record)
    return None if band is None or not np.isfinite((band.low, band.high)).all() else band


def compute_pinned_band(pin: Pin, result: Any) -> "PullBand | None":
    """Return the band of a pinned pull, or None if the pin has none.

    Raises LayerjamError if a link contains invalid values.
    """
    if BAND not in pin.options:
        return None
    call = make_call(pin)
    if not is_covered(call):
        raise QuantityError("band: requires a pull with a vacuum, a speed and a travel only")
    return compute_band(call, result.record)


def draw_bands(figure: "Figure", bands: Sequence["PullBand"]) -> None:
    """Draw the bands of pinned pulls in the figure of a pull; one label names them all."""
    axes, ends = figure.axes[0], list[tuple[float, float]]()
    for b in bands:
        x = b.elongation * 1e3
        style.add_band(axes, x, b.low, b.high, style.GREY)
        ends.append((float(b.high[x >= (1 - WORDS) * x[-1]].max()), float(x[-1])))
    y, x_end = max(ends)
    style.add_label(axes, x_end, y, f"band: {NAME}", ha="right", va="bottom")
