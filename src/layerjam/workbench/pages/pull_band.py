"""The 95 % band of a pull of a tested brake: its pin, its tested part, and drawing."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from layerjam.brake.simulate.record import TensileRecord
from layerjam.core.drawing import style
from layerjam.core.errors import QuantityError
from layerjam.core.units import parse
from layerjam.workbench.call import Call
from layerjam.workbench.pins import BAND, make_call
from layerjam.workbench.state import Pin

if TYPE_CHECKING:
    from layerjam.brake.simulate.prediction import Prediction
    from layerjam.core.drawing.style import Figure

ASKED = {"vacuum", "speed", "elongation"}
"""Options of a pull that the law covers; a pull with others has no band."""
POINTS, SAMPLES = 16, 400
"""Number of elongations in each of three intervals, and of samples of the brake."""
NAME = "95 % of pulls"
"""Label of a band in a chart."""
WORDS = 0.35
"""Fraction of a figure's width that the name of a band occupies."""


class Band(NamedTuple):
    """95 % interval of the force of the next pull [N], at some elongations [m]."""

    elongation: np.ndarray
    low: np.ndarray
    high: np.ndarray
    tested_end: float
    """Elongation up to which tests cover the pull [m]: 0, or infinite for all of it."""


def is_covered(call: Call) -> bool:
    """Return whether the law covers a pull."""
    return call.name == "tensile" and call.options.keys() == ASKED


def compute_band(call: Call, record: TensileRecord) -> Band | None:
    """Return the band of a pull's `record`; None if untested or not covered by the law."""
    if not is_covered(call) or record.brake.valid_evidence("calibrate") is None:
        return None
    # import late, so that the first page is shown before the computing code is loaded
    from layerjam.brake.mechanics.effects import fix_speed
    from layerjam.brake.mechanics.pull import force_at_elongation
    from layerjam.brake.simulate.prediction import Prediction

    vacuum, speed = (
        parse(call.options[k], unit, k) for k, unit in (("vacuum", "Pa"), ("speed", "m/s"))
    )
    u = np.asarray(record.elongation, float)
    top = float(u[int(np.argmax(record.force))])
    # include the peak itself, where the force has a kink, with more points near it than beyond
    ends = 0.0, top, min(2 * top, (top + u[-1]) / 2), u[-1]
    stretches = [np.linspace(a, b, POINTS, endpoint=False) for a, b in pairwise(ends)]
    elongation = np.concatenate((*stretches, u[-1:]))
    slip, file = np.interp(elongation, u, record.slip), record.brake
    device = fix_speed(speed, file.brake)
    prediction = Prediction(file, vacuum, slip, speed, device, samples=SAMPLES)
    forces = force_at_elongation(elongation, vacuum, prediction.brakes)
    if not np.isfinite(forces).all():
        return None
    interval = prediction.interval(forces)
    tested_end = _find_tested_part(prediction, elongation, slip)
    return Band(elongation, interval["low"], interval["high"], tested_end)


def _find_tested_part(prediction: "Prediction", elongation: np.ndarray, slip: np.ndarray) -> float:
    """Return the elongation [m] up to which the conditions of a pull were tested."""
    if not prediction.basis.extrapolations:
        return float("inf")
    first, *others = prediction.basis.extrapolations
    if others or first.quantity != "slip":
        return 0.0
    return float(elongation[slip <= first.high].max(initial=0.0))


def compute_pinned_band(pin: Pin, result: Any) -> Band | None:
    """Return the band of a pinned pull, or None if the pin has none.

    Raises LayerjamError if a link contains invalid values.
    """
    if BAND not in pin.options:
        return None
    call = make_call(pin)
    if not is_covered(call):
        raise QuantityError("band: requires a pull with a vacuum, a speed and a travel only")
    return compute_band(call, result.record)


def draw_bands(figure: "Figure", bands: Sequence[Band]) -> None:
    """Draw the bands of pinned pulls in the figure of a pull; one label names them all."""
    axes, ends = figure.axes[0], list[tuple[float, float]]()
    for b in bands:
        x = b.elongation * 1e3
        style.add_band(axes, x, b.low, b.high, style.GREY)
        ends.append((float(b.high[x >= (1 - WORDS) * x[-1]].max()), float(x[-1])))
    y, x_end = max(ends)
    style.add_label(axes, x_end, y, f"band: {NAME}", ha="right", va="bottom")
