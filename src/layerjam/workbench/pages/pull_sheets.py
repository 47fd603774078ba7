"""The stack under the cursor of a pull sheet by sheet: point at the curve, or walk along it."""

from __future__ import annotations

from typing import Any

from nicegui import events, ui

from layerjam.device.sheets import Sheets
from layerjam.simulate.sheet_motion import SheetMotion
from layerjam.workbench import live
from layerjam.workbench.sheets_drawing import Seen, drawing, key, said, scale_said
from layerjam.workbench.widgets import dressed, heading, hint, status

STEPS = 400
"""Steps of the slider along the pull."""
MM = 1e3
LEGEND = (("holds", "holds on both sides"), ("slides", "slides on a neighbour"))


class SheetBySheet(ui.column):
    """A side view of the stack at one elongation, for the chart above it."""

    def __init__(self, chart: ui.echart) -> None:
        super().__init__()
        self.classes("by-sheet w-full gap-1")
        self.chart, self.at = chart, 0
        self.seen: Seen | None = None
        self._motion: SheetMotion | None = None
        self._tied = False
        with self:
            heading("Sheet by sheet")
            hint("Point at the curve, or walk along the pull with this slider and its arrow keys.")
            bar = live.Bar(min=0, max=STEPS, step=1, value=0)
            self.bar = dressed(bar, "pull-along", how="dense", aria_label="Along the pull")
            self.words = status("pull-sheets-said")
            self.drawn = dressed(live.Table(), "pull-sheets", "w-full")
            with ui.row().classes("items-center gap-x-5 gap-y-1"):
                for kind, text in LEGEND:
                    with ui.row().classes("items-center gap-2 no-wrap"):
                        ui.html(key(kind), sanitize=False).props("aria-hidden=true")
                        ui.label(text).classes("text-sm")
                self.scale = dressed(live.Words(""), "pull-sheets-scale", "text-sm")
        # the event itself: the server's value of the slider does not follow the pointer
        self.bar.on("update:model-value", self._walked, throttle=0.05)
        self.bar.on("pointed", self._pointed)
        self.bar.on("blur", js_handler=f"() => layerjamUnmark({chart.id})")

    def fill(self, motion: SheetMotion | None, sheets: Sheets) -> None:
        """Another pull, looked at where the one before was; hidden where it has no sheets."""
        self.set_visibility(motion is not None)
        if motion is None or motion is self._motion:
            return
        before, self._motion, self.seen = self.seen, motion, Seen.of(motion, sheets)
        if before is None:
            at = self.seen.telling()
        else:
            old = before.motion
            at = self.seen.nearest(float(old.elongation[self.at]), float(old.force[self.at]))
        self._look(at)
        if not self._tied:
            self._tied = True
            self.client.run_javascript(f"layerjamPointing({self.chart.id}, {self.bar.id})")

    def _look(self, at: int) -> None:
        """Show a sample; the slider follows in the browser alone."""
        if self.seen is None:
            return
        self.at = at
        self.words.set_text(said(self.seen, at))
        self.scale.set_text(scale_said(self.seen, at))
        self.drawn.set_content(drawing(self.seen, at))
        place = round(STEPS * at / max(len(self.seen.motion.force) - 1, 1))
        self.client.run_javascript(f"layerjamAlong({self.bar.id}, {place})")

    def _pointed(self, event: events.GenericEventArguments) -> None:
        """The pointer stands at [mm, N] of the chart."""
        if self.seen is not None and (point := _point(event.args)):
            at = self.seen.nearest(point[0] / MM, point[1])
            if at != self.at:
                self._look(at)

    def _walked(self, event: events.GenericEventArguments) -> None:
        """The slider was moved: the chart's own cursor goes there."""
        if self.seen is None or not isinstance(event.args, int | float):
            return
        motion = self.seen.motion
        at = round(event.args / STEPS * (len(motion.force) - 1))
        self._look(min(max(at, 0), len(motion.force) - 1))
        x, y = float(motion.elongation[self.at]) * MM, float(motion.force[self.at])
        self.client.run_javascript(f"layerjamMark({self.chart.id}, {x!r}, {y!r})")


def _point(given: Any) -> tuple[float, float] | None:
    """Two numbers that the browser sent; None for anything else."""
    pair = given if isinstance(given, list) else [given]
    pair = pair[0] if len(pair) == 1 and isinstance(pair[0], list) else pair
    if len(pair) == 2 and all(isinstance(v, int | float) for v in pair):
        return float(pair[0]), float(pair[1])
    return None
