"""The peak of a pull set by hand: the vacuum, or the number of sheets, follows."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nicegui import background_tasks, run, ui

from layerjam.errors import LayerjamError, QuantityError
from layerjam.fluid.closed_forms import reachable
from layerjam.simulate.to_peak import ToPeak, sheets_to_peak, vacuum_to_peak
from layerjam.units import QuantitySpec, exact_text, show
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import Choice, choice, number_field, on_typed, with_unit, word
from layerjam.workbench.desk import Desk, resized, with_sheets
from layerjam.workbench.widgets import dressed, one_line, status

FOLLOWS = Choice(
    "follows",
    {"vacuum": "vacuum", "sheets": "sheets"},
    "vacuum",
    label="sets the",
    help="What follows when the peak is dragged or typed",
)
MOST = 500
"""Sheets that are tried at most."""
FORCE = QuantitySpec("N", "peak force of the pull", lo=0.0, example="150 N")


class PeakSetting:
    """The marker of a chart's peak as a handle, a field for its force, and what follows."""

    def __init__(
        self, desk: Desk, page: str, now: Callable[[], Call], most: Callable[[], float]
    ) -> None:
        """`now` is the pull that is shown; `most` the greatest vacuum of the page [Pa]."""
        self._desk, self._page, self._now, self._most = desk, page, now, most
        self._asked: float | None = None
        self._seeking = False
        self._peak = 0.0

    def build(self) -> None:
        """The field and the switch, in one row, and the sentence."""
        with ui.row().classes("items-center gap-2"):
            ui.label("Peak").classes("text-sm").tooltip("Drag the peak in the chart, or type it")
            self.field = dressed(number_field("Peak force to reach [N]", "w-28"), "pull-peak")
            self.field.props["suffix"] = "N"
            on_typed(self.field, self._typed)
            with ui.row().classes("items-center"):
                choice(self._desk, self._page, FOLLOWS)
        self.said = status("pull-peak-said", "text-sm")
        self._desk.watch(self._changed)

    def on(self, chart: ui.echart) -> None:
        """The chart whose first mark is dragged."""
        chart.on("vnodeMounted", js_handler="(node) => layerjamPeaks(node)")
        chart.on("peak", self._dragged)

    def fill(self, peak: float) -> None:
        """The peak that is shown [N]."""
        self._peak = peak
        shown = f"{peak:.4g}"
        if self.field.value != shown and not self._seeking:
            self.field.set_value(shown)

    def _typed(self) -> None:
        text = str(self.field.value or "").strip()
        if text == f"{self._peak:.4g}":
            self.field.error = None
            return
        try:
            force = FORCE.read(with_unit(text, "N"), "Peak")
        except QuantityError as err:
            self.field.error = one_line(err)
            return
        self.field.error = None
        self.ask(force, done=True)

    def _dragged(self, event: Any) -> None:
        force, done = event.args.get("force"), bool(event.args.get("done"))
        if isinstance(force, int | float) and math.isfinite(force) and force >= 0:
            # to the digits that the page shows
            self.ask(float(f"{force:.4g}"), done)

    def ask(self, force: float, done: bool) -> None:
        """Let what is chosen follow a peak [N]; the latest wins, sheets once it is let go."""
        if word(self._desk, self._page, FOLLOWS) == "sheets" and not done:
            return
        self._asked = force
        if not self._seeking:
            self._seeking = True
            background_tasks.create(self._seek(), name="layerjam peak")

    async def _seek(self) -> None:
        try:
            while self._asked is not None:
                force, self._asked = self._asked, None
                by_sheets = word(self._desk, self._page, FOLLOWS) == "sheets"
                try:
                    found = await run.io_bound(self.found, force, by_sheets)
                    if found is None:  # the program is being ended
                        return
                    self._take(found, force, by_sheets)
                except LayerjamError as err:
                    self.said.set_text(one_line(err))
        finally:
            self._seeking = False

    def limit(self) -> float:
        """The greatest vacuum that site and line allow [Pa]."""
        return min(self._most(), float(reachable(self._desk.line.line)))

    def found(self, force: float, by_sheets: bool) -> ToPeak:
        """What gives the force; in a thread. Raises LayerjamError as the command does."""
        call, file = self._now(), self._desk.brake
        if by_sheets:

            def with_count(count: int) -> float:
                subject = Subject(file.name, resized(file, count))
                return float(replace(call, subjects=(subject,)).run().peak_force)

            return sheets_to_peak(with_count, force, MOST)

        def at_vacuum(vacuum: float) -> float:
            options = {**call.options, "vacuum": exact_text(vacuum, "Pa")}
            return float(replace(call, options=options).run().peak_force)

        return vacuum_to_peak(at_vacuum, force, self.limit())

    def _take(self, found: ToPeak, force: float, by_sheets: bool) -> None:
        if found.value is None:
            self.field.set_value(f"{self._peak:.4g}")
        elif by_sheets:
            with_sheets(self._desk, int(found.value))
        else:
            # whole pascals: what is set can be read
            self._desk.put(self._page, "vacuum", float(round(found.value)), follow=True)
        self.said.set_text(sentence(found, force, by_sheets))

    def _changed(self, what: str) -> None:
        """What was said holds until something else is moved."""
        if what in ("settings", "undo", "brake", "line"):
            self.said.set_text("")


def sentence(found: ToPeak, force: float, by_sheets: bool) -> str:
    """What follows from the asked peak, or that nothing gives it and how near one comes."""
    near, asked = show(found.force, "N"), show(force, "N")
    there = f"{found.at:g} sheets" if by_sheets else show(found.at, "Pa")
    if found.value is not None and by_sheets:
        return f"{there}: a peak of {near} at this vacuum, the nearest to {asked}."
    if found.value is not None:
        return f"A vacuum of {there} gives a peak of {near}."
    what = "number of sheets" if by_sheets else "vacuum"
    if force < found.force:
        return f"No {what} gives a peak of {asked}; the least is {near}, with {there}."
    return f"No {what} up to {there} gives a peak of {asked}; the greatest is {near}."
