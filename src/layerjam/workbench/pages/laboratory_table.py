"""The table of the laboratory's files."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nicegui import events, ui

from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.widgets import button, dressed

COLUMNS = (
    ("name", "File"),
    ("role", "Used as"),
    ("vacuum", "Vacuum"),
    ("force", "Normal force"),
    ("state", "State"),
)
NO_FILES = "No files yet: drop some, or try with synthetic ones"
STATE = """
<q-td :props="props" style="white-space:normal"><q-badge :label="props.value"
 :style="{padding:'4px 6px', color:'#fff', background:props.row.tone}"></q-badge>
<div v-if="props.row.refused" class="text-caption">{{ props.row.refused }}</div></q-td>
"""
NAME = """
<q-td :props="props" style="white-space:normal; overflow-wrap:anywhere; min-width:190px">
{{ props.value }}</q-td>
"""
EVERY = """
<q-checkbox v-model="props.selected" dense aria-label="Choose all files"></q-checkbox>
<span class="sr-only">Chosen</span>
"""
ONE = """
<q-checkbox v-model="props.selected" dense :aria-label="'Choose ' + props.row.name"></q-checkbox>
"""


class Table:
    """Files with what they are used for; those ticked are shown and corrected below."""

    def __init__(
        self,
        choose: Callable[[Sequence[str]], None],
        divide: Callable[[], None],
        sidecars: Callable[[], None],
    ) -> None:
        self._choose = choose
        self.chosen: list[str] = []
        self._shown: Sequence[Row] | None = None
        with ui.row().classes("w-full items-center justify-between"):
            self.count = dressed(ui.label(NO_FILES), "laboratory-count", role="status")
            with ui.row().classes("gap-2") as self.more:
                text, tip = "Calibrate on the highest vacuum", "and validate on the pulls at others"
                button(text, divide, "laboratory-divide", "call_split", tip=tip)
                tip = "NAME.toml of every file with what is set here, as a ZIP"
                button("Sidecars", sidecars, "laboratory-sidecars", "download", tip=tip)
        columns = [
            {"name": k, "label": label, "field": k, "align": "left", "sortable": True}
            for k, label in COLUMNS
        ]
        self.table = ui.table(
            columns=columns,
            rows=[],
            row_key="id",
            selection="multiple",
            pagination=0,
            on_select=self._selected,
        ).style("max-height: 340px")
        look = "flat bordered dense hide-bottom virtual-scroll"
        dressed(self.table, "laboratory-files", "w-full", look)
        self.table.add_slot("header-selection", EVERY)
        self.table.add_slot("body-selection", ONE)
        self.table.add_slot("body-cell-state", STATE)
        self.table.add_slot("body-cell-name", NAME)
        self.table.on("rowClick", self._clicked, js_handler="(e, row) => emit(row.id)")

    def fill(self, rows: Sequence[Row]) -> None:
        """Show the files of now; ticks stay."""
        if rows is self._shown:
            return
        self._shown = rows
        good = sum(r.good for r in rows)
        self.count.set_text(f"{len(rows)} files, {good} of them usable" if rows else NO_FILES)
        for part in (self.table, self.more):
            part.set_visibility(bool(rows))
        self.table.rows = [row.cells() for row in rows]
        self.chosen = [row.upload.key for row in rows if row.upload.key in self.chosen]
        self._tick()

    def _tick(self) -> None:
        self.table.selected = [c for c in self.table.rows if c["id"] in self.chosen]

    def _selected(self, event: events.TableSelectionEventArguments) -> None:
        self.chosen = [str(c["id"]) for c in event.selection]
        self._choose(self.chosen)

    def _clicked(self, event: events.GenericEventArguments) -> None:
        key = str(event.args)
        self.chosen = [] if self.chosen == [key] else [key]
        self._tick()
        self._choose(self.chosen)
