"""Sets the peak force of a pull by hand; the vacuum or the number of sheets follows."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from nicegui import background_tasks, run, ui

from layerjam.brake.fluid.closed_forms import reachable_vacuum
from layerjam.brake.simulate.to_peak import ToPeak, find_sheet_count_for_peak, find_vacuum_for_peak
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.units import QuantitySpec, exact_text, show
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import (
    Choice,
    add_choice,
    add_unit,
    number_field,
    on_submit,
    read_word,
)
from layerjam.workbench.desk import Desk, resize_stack, set_sheets
from layerjam.workbench.widgets import dress, one_line, status

FOLLOWS = Choice(
    "follows",
    {"vacuum": "vacuum", "sheets": "sheets"},
    "vacuum",
    label="Adjusts the",
    help="Quantity that changes when you drag or type the peak",
)
MAX_SHEETS = 500
"""Largest number of sheets that the search tries."""
FORCE = QuantitySpec("N", "peak force of the pull", lo=0.0, example="150 N")


class PeakSetting:
    """A draggable marker at the peak of a chart, a field for the peak force, and the result."""

    def __init__(
        self, desk: Desk, page: str, call: Callable[[], Call], limit: Callable[[], float]
    ) -> None:
        """`call` is the displayed pull, `limit` the highest vacuum on the page [Pa]."""
        self._desk, self._page, self._now, self._most = desk, page, call, limit
        self._asked: float | None = None
        self._seeking = self._fills_later = False
        self._peak = 0.0

    def build(self) -> None:
        """Build a row with the field and the choice of quantity, and the sentence below."""
        with ui.row().classes("items-center gap-2"):
            ui.label("Peak").classes("text-sm").tooltip("Drag the peak in the chart, or type it")
            self.field = dress(number_field("Peak force to reach [N]", "w-28"), "pull-peak")
            self.field.props["suffix"] = "N"
            on_submit(self.field, self._on_type)
            with ui.row().classes("items-center"):
                add_choice(self._desk, self._page, FOLLOWS)
        self.message = status("pull-peak-said", "text-sm")
        self._desk.add_watcher(self._on_change)

    def attach_chart(self, chart: ui.echart) -> None:
        """Make the first point mark of a chart draggable."""
        chart.on("vnodeMounted", js_handler="(node) => layerjamPeaks(node)")
        chart.on("peak", self._on_drag)

    def fill(self, peak: float) -> None:
        """Show a peak force in the field [N]."""
        self._peak = peak
        if self._seeking:  # what is typed stays until its vacuum is known
            self._fills_later = True
            return
        text = f"{peak:.4g}"
        if self.field.value != text:
            self.field.show_text(text)

    def _on_type(self) -> None:
        text = str(self.field.value or "").strip()
        if text == f"{self._peak:.4g}":
            self.field.error = None
            return
        try:
            force = FORCE.read(add_unit(text, "N"), "Peak")
        except QuantityError as err:
            self.field.error = one_line(err)
            return
        self.field.error = None
        self.request_peak(force, is_final=True)

    def _on_drag(self, event: Any) -> None:
        force, is_done = event.args.get("force"), bool(event.args.get("done"))
        if isinstance(force, int | float) and math.isfinite(force) and force >= 0:
            # round to the digits shown on the page
            self.request_peak(float(f"{force:.4g}"), is_done)

    def request_peak(self, force: float, is_final: bool) -> None:
        """Adjust the selected quantity to reach a peak force [N].

        The latest request wins; the number of sheets changes only when the marker is released.
        """
        if read_word(self._desk, self._page, FOLLOWS) == "sheets" and not is_final:
            return
        self._asked = force
        if not self._seeking:
            self._seeking = True
            background_tasks.create(self._search_target(), name="layerjam peak")

    async def _search_target(self) -> None:
        try:
            while self._asked is not None:
                force, self._asked = self._asked, None
                by_sheets = read_word(self._desk, self._page, FOLLOWS) == "sheets"
                try:
                    result = await run.io_bound(self.search_setting, force, by_sheets)
                    if result is None:  # the program is stopping
                        return
                    self._apply_result(result, force, by_sheets)
                except LayerjamError as err:
                    self.message.set_text(one_line(err))
        finally:
            self._seeking = False
        if self._fills_later:  # the search may end with the vacuum that is shown already
            self._fills_later = False
            self.fill(self._peak)

    def limit(self) -> float:
        """Return the highest vacuum [Pa] that the site and the line allow."""
        return min(self._most(), float(reachable_vacuum(self._desk.line.line)))

    def search_setting(self, force: float, by_sheets: bool) -> ToPeak:
        """Return the vacuum or number of sheets for a peak force; runs in a thread."""
        call, file = self._now(), self._desk.brake
        if by_sheets:

            def peak_with_count(count: int) -> float:
                subject = Subject(file.name, resize_stack(file, count))
                return float(replace(call, subjects=(subject,)).run().peak_force)

            return find_sheet_count_for_peak(peak_with_count, force, MAX_SHEETS)

        def peak_at_vacuum(vacuum: float) -> float:
            options = {**call.options, "vacuum": exact_text(vacuum, "Pa")}
            return float(replace(call, options=options).run().peak_force)

        return find_vacuum_for_peak(peak_at_vacuum, force, self.limit())

    def _apply_result(self, result: ToPeak, force: float, by_sheets: bool) -> None:
        if result.value is None:
            self.field.set_value(f"{self._peak:.4g}")
        elif by_sheets:
            set_sheets(self._desk, int(result.value))
        else:
            # use whole pascals, so that the value is readable
            self._desk.put_setting(self._page, "vacuum", float(round(result.value)), follow=True)
        self.message.set_text(describe_result(result, force, by_sheets))

    def _on_change(self, change: str) -> None:
        """Clear the sentence when something else changes."""
        if change in ("settings", "undo", "brake", "line"):
            self.message.set_text("")


def describe_result(result: ToPeak, force: float, by_sheets: bool) -> str:
    """Return a sentence with the value for a target peak, or with the nearest possible peak."""
    peak, target = show(result.force, "N"), show(force, "N")
    place = f"{result.at:g} sheets" if by_sheets else show(result.at, "Pa")
    if result.value is not None and by_sheets:
        return f"{place}: a peak of {peak} at this vacuum, the closest to {target}."
    if result.value is not None:
        return f"A vacuum of {place} gives a peak of {peak}."
    quantity = "number of sheets" if by_sheets else "vacuum"
    if force < result.force:
        return (
            f"No {quantity} gives a peak of {target}; the lowest possible peak is {peak}, with "
            f"{place}."
        )
    return (
        f"No {quantity} up to {place} gives a peak of {target}; the highest possible peak is "
        f"{peak}."
    )
