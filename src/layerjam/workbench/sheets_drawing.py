"""Side view of the stack at one sample of a pull: sliding sheets, as SVG and as text."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from layerjam.brake.device.sheets import Sheets
from layerjam.brake.simulate.sheet_motion import SheetMotion
from layerjam.core.units import show

WIDE, CAP, EDGE = 860.0, 16.0, 8.0
"""Width of the drawing, width of a cap, and margin [pixels]."""
TALL, GAP = (9.0, 24.0), 7.0
"""Minimum and maximum height of a sheet, and gap between sheets [pixels]."""
MAX_SHEETS = 40
"""Largest number of drawn sheets."""
ROOM = 0.3
"""Largest drawn displacement before all sheets slide, as a fraction of the overlap."""


@dataclass(frozen=True)
class PullView:
    """A pull to display: its motion, its sheets, and the magnification of movements."""

    motion: SheetMotion
    sheets: Sheets
    factor: float
    """Magnification of movements until every interface has slid."""
    small_range: float
    """Displacement of the moving cap [m] up to which movements are magnified."""

    @classmethod
    def from_motion(cls, motion: SheetMotion, sheets: Sheets) -> "PullView":
        """Return a view that magnifies movements enough to make those of the sheets visible."""
        slid = np.asarray(np.maximum.accumulate(motion.sliding, axis=0).all(axis=1))
        first = int(np.argmax(slid)) if slid.any() else len(slid) - 1
        small_range = float(motion.cap[: first + 1].max())
        factor = round_down(ROOM * sheets.overlap / small_range) if small_range > 0 else 1.0
        return cls(motion, sheets, factor if factor > 1 else 1.0, small_range)

    def informative_sample(self) -> int:
        """Return the most informative sample: one with partial slip, otherwise the peak."""
        sliding = self.motion.sliding
        frames = np.flatnonzero(sliding.any(axis=1) & ~sliding.all(axis=1))
        return int(frames[len(frames) // 2]) if len(frames) else int(np.argmax(self.motion.force))

    def magnification(self, index: int) -> float:
        """Return the magnification of movements at a sample."""
        return self.factor if self.motion.cap[index] <= self.small_range else 1.0

    def nearest_sample(self, elongation: float, force: float) -> int:
        """Return the sample nearest to a point of the chart [m, N].

        The horizontal distance has more weight; on steep parts, the vertical one distinguishes
        samples.
        """
        motion = self.motion
        horizontal = (motion.elongation - elongation) / max(float(np.ptp(motion.elongation)), 1e-12)
        vertical = (motion.force - force) / max(float(np.ptp(motion.force)), 1e-12)
        return int(np.argmin((10 * horizontal) ** 2 + vertical**2))


def round_down(value: float) -> float:
    """Return a positive number rounded down to 1, 2 or 5 times a power of ten."""
    if not value > 0:
        return 1.0
    ten = 10.0 ** math.floor(math.log10(value))
    return ten * max(k for k in (1, 2, 5) if k * ten <= value * (1 + 1e-12))


def format_runs(numbers: Sequence[int]) -> str:
    """Return ascending integers as text, such as "1–3, 8 and 10"."""
    ends = [k for k, (a, b) in enumerate(pairwise(numbers), 1) if b != a + 1]
    parts = [numbers[a:b] for a, b in pairwise([0, *ends, len(numbers)])]
    words = [str(p[0]) if len(p) == 1 else f"{p[0]}–{p[-1]}" for p in parts if p]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def slip_sentence(view: PullView, index: int) -> str:
    """Return the state of the stack at a sample, as a sentence."""
    motion = view.motion
    is_sliding = motion.sliding[index]
    count, slid = len(is_sliding), int(is_sliding.sum())
    begin = f"At {show(motion.elongation[index], 'm', 3)} and {show(motion.force[index], 'N', 3)}"
    if slid == 0:
        return f"{begin}: no sheet slides; all {count} interfaces stick."
    if slid == count:
        return f"{begin}: every sheet slides at all {count} interfaces."
    names = format_runs([int(k) + 1 for k in np.flatnonzero(is_sliding)])
    verb = "slides" if slid == 1 else "slide"
    return (
        f"{begin}: {slid} of {count} interfaces {verb} ({names}, from the top); the others stick."
    )


def describe_scale(view: PullView, index: int) -> str:
    """Return the scale of the drawing, as text."""
    factor, count = view.magnification(index), len(view.motion.moving)
    large = "to scale" if factor == 1 else f"{factor:.6g} times larger"
    note = "" if count <= MAX_SHEETS else f" {MAX_SHEETS} of {count} sheets are drawn."
    return f"Movements are drawn {large}; the thickness is not to scale.{note}"


def draw_stack(view: PullView, index: int) -> str:
    """Return the stack as SVG; sliding parts are orange and hatched, sticking parts blue."""
    motion, sheets, factor = view.motion, view.sheets, view.magnification(index)
    length = sheets.free_left + sheets.overlap + sheets.free_right
    travel = max(float(motion.cap.max()), view.factor * view.small_range)
    per_metre = (WIDE - 2 * (EDGE + CAP)) / (length + travel)
    left_edge = EDGE + CAP
    shift = factor * float(motion.cap[index])
    rows = np.unique(np.linspace(0, len(motion.moving) - 1, MAX_SHEETS).round().astype(int))
    height = min(max(200.0 / len(rows), TALL[0]), TALL[1])
    high = len(rows) * (height + GAP) - GAP
    body = [
        _cap_svg(EDGE, high, "sheets-cap"),
        _cap_svg(left_edge + length * per_metre, high, "sheets-ghost"),
    ]
    body.append(_cap_svg(left_edge + (length + shift) * per_metre, high, "sheets-cap"))
    is_sliding, spans = motion.sliding[index], []
    for row, k in enumerate(rows):
        displacement = factor * float(motion.sheets[index, k])
        left_end, right_end = 0.0, sheets.free_left + sheets.overlap + displacement
        if motion.moving[k]:
            left_end, right_end = sheets.free_left + displacement, length + shift
        spans.append((left_edge + left_end * per_metre, left_edge + right_end * per_metre))
        kind = "slides" if is_sliding[max(k - 1, 0) : k + 1].any() else "holds"
        body.append(_sheet_svg(*spans[-1], EDGE + row * (height + GAP), height, kind))
    for row, (k, (upper, lower)) in enumerate(zip(rows, pairwise(spans), strict=False)):
        begin, end = max(upper[0], lower[0]), min(upper[1], lower[1])
        if end > begin:
            middle = EDGE + (row + 1) * (height + GAP) - GAP / 2
            body.append(_interface_svg(begin, end, middle, bool(is_sliding[k])))
    words = f"{slip_sentence(view, index)} {describe_scale(view, index)}"
    return (
        f'<svg class="sheets" viewBox="0 0 {WIDE:.0f} {high + 2 * EDGE:.0f}" role="img" '
        f'aria-label="The stack from the side. {words}">{HATCH}{"".join(body)}</svg>'
    )


HATCH = (
    '<defs><pattern id="sheets-hatch" width="7" height="7" patternUnits="userSpaceOnUse" '
    'patternTransform="rotate(45)"><path d="M0 0V7" class="sheets-stroke"/></pattern></defs>'
)


def legend_symbol(kind: str) -> str:
    """Return the legend's symbol for a sheet that "holds" or "slides"."""
    return f'<svg class="sheets-key">{_sheet_svg(0.0, 26.0, 0.0, 12.0, kind)}</svg>'


def _sheet_svg(x: float, end: float, y: float, high: float, kind: str) -> str:
    hatch = _rectangle_svg(x, end, y, high, "sheet-hatch") if kind == "slides" else ""
    return _rectangle_svg(x, end, y, high, f"sheet-{kind}") + hatch


def _rectangle_svg(x: float, end: float, y: float, high: float, kind: str) -> str:
    return (
        f'<rect class="{kind}" x="{x:.2f}" y="{y:.2f}" width="{max(end - x, 0):.2f}" '
        f'height="{high:.2f}"/>'
    )


def _cap_svg(x: float, high: float, kind: str) -> str:
    return _rectangle_svg(x, x + CAP, EDGE - 4, high + 8, kind)


def _interface_svg(begin: float, end: float, y: float, slides: bool) -> str:
    """Return the line between two sheets as SVG: dashed, with an arrow, if they slide."""
    if not slides:
        return f'<path class="touch-holds" d="M{begin:.2f} {y:.2f}H{end:.2f}"/>'
    x = (begin + end) / 2
    arrow = f'<path class="touch-arrow" d="M{x:.2f} {y - 4:.2f}l9 4l-9 4z"/>'
    return f'<path class="touch-slides" d="M{begin:.2f} {y:.2f}H{end:.2f}"/>{arrow}'
