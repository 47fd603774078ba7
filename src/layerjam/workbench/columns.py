"""The first rows of a file; a click on a column's header sets the column's role."""

from collections.abc import Callable
from functools import partial

from nicegui import ui

from layerjam.laboratory.measure.preview import COLUMN_LIMIT, Preview
from layerjam.workbench.widgets import button, dress

UNITS = {
    "force": ("N", "kN", "mN", "lbf", "gf", "kgf"),
    "elongation": ("mm", "m", "µm", "in"),
    "time": ("s", "ms", "min"),
    "vacuum": ("kPa", "mbar", "bar", "Pa"),
}
"""{role of a column: available units}."""
TURNED = ("force", "elongation")
FLAT = "flat dense no-caps"


class ColumnTable:
    """Rows with clickable headers; a choice calls `choose(index, role, unit)`.

    The role "" means that the column is ignored; reversing the sign calls `turn(role)`.
    """

    def __init__(
        self,
        preview: Preview,
        negative: frozenset[str],
        choose: Callable[[int, str, str], object],
        turn: Callable[[str], object],
    ) -> None:
        self.shown, self.negative, self._said, self._turned = preview, negative, choose, turn
        with ui.element("div").classes("plain-scroll w-full").props("tabindex=0"):
            table = ui.element("table").classes("plain-table columns-table")
            with dress(table, "columns", aria_label="First rows of the file"):
                with ui.element("thead"), ui.element("tr"):
                    for index in range(min(len(preview.names), COLUMN_LIMIT)):
                        self._build_header(index)
                with ui.element("tbody"):
                    for row in preview.rows:
                        with ui.element("tr"):
                            for cell in row[:COLUMN_LIMIT]:
                                with ui.element("td").classes("num"):
                                    ui.label(cell)
        if len(preview.names) > COLUMN_LIMIT:
            hidden = len(preview.names) - COLUMN_LIMIT
            ui.label(f"and {hidden} more columns").classes("text-xs opacity-80")

    def _build_header(self, index: int) -> None:
        name, unit = self.shown.names[index], self.shown.units[index]
        role, unit_used = self.shown.taken.get(index, ("", ""))
        with ui.element("th").props("scope=col"):
            if self.shown.ours:
                ui.label(f"{name} [{unit}]")
                return
            text = f"{name} [{unit}]" if unit else name
            head = button(text, None, f"column-{index}", look=f"{FLAT} icon-right=expand_more")
            sign_note = ", sign reversed" if role in self.negative else ""
            meaning = f"{role} in {unit_used}{sign_note}" if role else "not used"
            ui.label(meaning).classes("text-xs " + ("yes font-medium" if role else "opacity-80"))
            dress(head, aria_label=f"{text}: {meaning}. What is this column?")
            with head:
                menu = ui.menu().props("auto-close no-parent-event")
            head.on_click(partial(self._fill_menu, menu, index, role))

    def _fill_menu(self, menu: ui.menu, index: int, role: str) -> None:
        menu.clear()
        with menu, ui.column().classes("gap-1 q-pa-sm"):
            for role_name, units in UNITS.items():
                with ui.row().classes("items-center gap-1 no-wrap"):
                    ui.label(role_name).classes("text-sm").style("width:5.5em")
                    for unit in units:
                        act = partial(self._said, index, role_name, unit)
                        choice = button(unit, act, f"column-is-{role_name}-{unit}", look=FLAT)
                        dress(choice, aria_label=f"{role_name} in {unit}")
            with ui.row().classes("gap-1"):
                button("ignore", partial(self._said, index, "", ""), "column-ignore", look=FLAT)
                if role in TURNED:
                    button(
                        "reverse its sign", partial(self._turned, role), "column-turn", look=FLAT
                    )
        menu.open()
