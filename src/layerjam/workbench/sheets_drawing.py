"""The stack from the side at one sample of a pull: which sheets slide, as SVG and in words."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from layerjam.device.sheets import Sheets
from layerjam.simulate.sheet_motion import SheetMotion
from layerjam.units import show

WIDE, CAP, EDGE = 860.0, 16.0, 8.0
"""Pixels of the drawing: its width, a cap's, and what is free around it."""
TALL, GAP = (9.0, 24.0), 7.0
"""A sheet's least and greatest height, and what stands between two of them [pixels]."""
MOST = 40
"""Sheets drawn at most."""
ROOM = 0.3
"""How far at most what happens before all slide is drawn, as a share of the overlap."""


@dataclass(frozen=True)
class Seen:
    """A pull that is looked at: its motion and its sheets, and how large movements are drawn."""

    motion: SheetMotion
    sheets: Sheets
    factor: float
    """By which movements are drawn larger while not every interface has slid."""
    near: float
    """Displacement of the moving cap [m] up to which that is so."""

    @classmethod
    def of(cls, motion: SheetMotion, sheets: Sheets) -> "Seen":
        """The pull, movements so large that the sheets' own show."""
        slid = np.asarray(np.maximum.accumulate(motion.sliding, axis=0).all(axis=1))
        first = int(np.argmax(slid)) if slid.any() else len(slid) - 1
        near = float(motion.cap[: first + 1].max())
        factor = rounded(ROOM * sheets.overlap / near) if near > 0 else 1.0
        return cls(motion, sheets, factor if factor > 1 else 1.0, near)

    def telling(self) -> int:
        """The sample that says most at first: some slide and others hold; else the peak."""
        sliding = self.motion.sliding
        mixed = np.flatnonzero(sliding.any(axis=1) & ~sliding.all(axis=1))
        return int(mixed[len(mixed) // 2]) if len(mixed) else int(np.argmax(self.motion.force))

    def scale(self, at: int) -> float:
        """How many times as large as they are movements are drawn at a sample."""
        return self.factor if self.motion.cap[at] <= self.near else 1.0

    def nearest(self, elongation: float, force: float) -> int:
        """The sample nearest to a point of the chart [m, N].

        Across counts more than up, but where the curve is steep up tells the samples apart.
        """
        motion = self.motion
        across = (motion.elongation - elongation) / max(float(np.ptp(motion.elongation)), 1e-12)
        up = (motion.force - force) / max(float(np.ptp(motion.force)), 1e-12)
        return int(np.argmin((10 * across) ** 2 + up**2))


def rounded(value: float) -> float:
    """The greatest 1, 2 or 5 times a power of ten that is not above a positive number."""
    if not value > 0:
        return 1.0
    ten = 10.0 ** math.floor(math.log10(value))
    return ten * max(k for k in (1, 2, 5) if k * ten <= value * (1 + 1e-12))


def runs(numbers: Sequence[int]) -> str:
    """Rising whole numbers in words: 1–3, 8 and 10."""
    ends = [k for k, (a, b) in enumerate(pairwise(numbers), 1) if b != a + 1]
    parts = [numbers[a:b] for a, b in pairwise([0, *ends, len(numbers)])]
    words = [str(p[0]) if len(p) == 1 else f"{p[0]}–{p[-1]}" for p in parts if p]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def said(seen: Seen, at: int) -> str:
    """What happens at a sample, in a sentence."""
    motion = seen.motion
    slides = motion.sliding[at]
    count, many = len(slides), int(slides.sum())
    begins = f"At {show(motion.elongation[at], 'm', 3)} and {show(motion.force[at], 'N', 3)}"
    if many == 0:
        return f"{begins}: no sheet slides on another, all {count} interfaces hold."
    if many == count:
        return f"{begins}: every sheet slides, at all {count} interfaces."
    which = runs([int(k) + 1 for k in np.flatnonzero(slides)])
    verb = "slides" if many == 1 else "slide"
    return (
        f"{begins}: {many} of {count} interfaces {verb} ({which}, from the top), the others hold."
    )


def scale_said(seen: Seen, at: int) -> str:
    """How large what is drawn is."""
    factor, count = seen.scale(at), len(seen.motion.moving)
    large = "to scale" if factor == 1 else f"{factor:.6g} times as large as they are"
    drawn = "" if count <= MOST else f" {MOST} of {count} sheets are drawn."
    return f"Movements are drawn {large}, thickness not to scale.{drawn}"


def drawing(seen: Seen, at: int) -> str:
    """The SVG: caps, sheets and interfaces; what slides is orange and hatched, what holds blue."""
    motion, sheets, factor = seen.motion, seen.sheets, seen.scale(at)
    rest = sheets.free_left + sheets.overlap + sheets.free_right
    room = max(float(motion.cap.max()), seen.factor * seen.near)
    per_metre = (WIDE - 2 * (EDGE + CAP)) / (rest + room)
    left = EDGE + CAP
    moved = factor * float(motion.cap[at])
    picked = np.unique(np.linspace(0, len(motion.moving) - 1, MOST).round().astype(int))
    each = min(max(200.0 / len(picked), TALL[0]), TALL[1])
    high = len(picked) * (each + GAP) - GAP
    body = [_cap(EDGE, high, "sheets-cap"), _cap(left + rest * per_metre, high, "sheets-ghost")]
    body.append(_cap(left + (rest + moved) * per_metre, high, "sheets-cap"))
    slides, spans = motion.sliding[at], []
    for row, k in enumerate(picked):
        own = factor * float(motion.sheets[at, k])
        from_, to = 0.0, sheets.free_left + sheets.overlap + own
        if motion.moving[k]:
            from_, to = sheets.free_left + own, rest + moved
        spans.append((left + from_ * per_metre, left + to * per_metre))
        kind = "slides" if slides[max(k - 1, 0) : k + 1].any() else "holds"
        body.append(_sheet(*spans[-1], EDGE + row * (each + GAP), each, kind))
    for row, (k, (one, other)) in enumerate(zip(picked, pairwise(spans), strict=False)):
        begin, end = max(one[0], other[0]), min(one[1], other[1])
        if end > begin:
            middle = EDGE + (row + 1) * (each + GAP) - GAP / 2
            body.append(_interface(begin, end, middle, bool(slides[k])))
    words = f"{said(seen, at)} {scale_said(seen, at)}"
    return (
        f'<svg class="sheets" viewBox="0 0 {WIDE:.0f} {high + 2 * EDGE:.0f}" role="img" '
        f'aria-label="The stack from the side. {words}">{HATCH}{"".join(body)}</svg>'
    )


HATCH = (
    '<defs><pattern id="sheets-hatch" width="7" height="7" patternUnits="userSpaceOnUse" '
    'patternTransform="rotate(45)"><path d="M0 0V7" class="sheets-stroke"/></pattern></defs>'
)


def key(kind: str) -> str:
    """A sheet that "holds" or "slides", for the drawing's key."""
    return f'<svg class="sheets-key">{_sheet(0.0, 26.0, 0.0, 12.0, kind)}</svg>'


def _sheet(x: float, end: float, y: float, high: float, kind: str) -> str:
    """What slides has a second mark beside its colour."""
    hatch = _rect(x, end, y, high, "sheet-hatch") if kind == "slides" else ""
    return _rect(x, end, y, high, f"sheet-{kind}") + hatch


def _rect(x: float, end: float, y: float, high: float, kind: str) -> str:
    return (
        f'<rect class="{kind}" x="{x:.2f}" y="{y:.2f}" width="{max(end - x, 0):.2f}" '
        f'height="{high:.2f}"/>'
    )


def _cap(x: float, high: float, kind: str) -> str:
    return _rect(x, x + CAP, EDGE - 4, high + 8, kind)


def _interface(begin: float, end: float, y: float, slides: bool) -> str:
    """A line where two sheets touch: dashed with an arrow where they slide."""
    if not slides:
        return f'<path class="touch-holds" d="M{begin:.2f} {y:.2f}H{end:.2f}"/>'
    x = (begin + end) / 2
    arrow = f'<path class="touch-arrow" d="M{x:.2f} {y - 4:.2f}l9 4l-9 4z"/>'
    return f'<path class="touch-slides" d="M{begin:.2f} {y:.2f}H{end:.2f}"/>{arrow}'
