"""The laboratory's table of files, and each step's numbers, checks, notes and figure."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from nicegui import events, ui

from layerjam.core.command.wording import format_words
from layerjam.workbench.call import result_fields, warning_key
from layerjam.workbench.certainty import interval_text
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Box, Notes, show_checks
from layerjam.workbench.pages.laboratory_chain import Chain, StepResult
from layerjam.workbench.pages.laboratory_files import Row
from layerjam.workbench.spoken import page_text
from layerjam.workbench.widgets import Hero, button, dress, heading, hint, key_title

CARDS = {
    "friction": (
        "Friction",
        "No friction test among the files: the friction in the brake file is used.",
    ),
    "calibrate": ("Calibration", "No calibration pull yet."),
    "validate": (
        "Validation",
        "No validation pull yet: reserve some pulls for validation, or drop more files.",
    ),
    "report": (
        "Report",
        "Friction, calibration and validation on a few pages, with the digest of every file.",
    ),
}
"""{step: (title, text while there is no result)}."""
COLUMNS = (
    ("name", "File"),
    ("role", "Used as"),
    ("vacuum", "Vacuum"),
    ("force", "Normal force"),
    ("state", "State"),
)
NO_FILES = "No files yet: drop some, or try synthetic ones"
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
ROW_CHECKBOX = """
<q-checkbox v-model="props.selected" dense :aria-label="'Choose ' + props.row.name"></q-checkbox>
"""


class Table:
    """Table of files with their uses; a panel below shows and corrects selected files."""

    def __init__(
        self,
        choose: Callable[[Sequence[str]], None],
        divide: Callable[[], None],
        sidecars: Callable[[], None],
        refused: Mapping[str, str],
    ) -> None:
        """`refused` is {name: reason} of dropped files that could not be read."""
        self._choose, self._refused = choose, refused
        self.chosen: list[str] = []
        self._shown: Sequence[Row] | None = None
        with ui.row().classes("w-full items-center justify-between"):
            self.count = dress(ui.label(NO_FILES), "laboratory-count", role="status")
            with ui.row().classes("gap-2") as self.more:
                text = "Calibrate at the highest vacuum"
                tip = "Validate on the pulls at other vacuums"
                button(text, divide, "laboratory-divide", "call_split", tip=tip)
                tip = "A NAME.toml sidecar for every file, with this page's settings (ZIP)"
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
            on_select=self._on_select,
        ).style("max-height: 340px")
        look = "flat bordered dense hide-bottom virtual-scroll"
        dress(self.table, "laboratory-files", "w-full", look)
        self.table.add_slot("header-selection", EVERY)
        self.table.add_slot("body-selection", ROW_CHECKBOX)
        self.table.add_slot("body-cell-state", STATE)
        self.table.add_slot("body-cell-name", NAME)
        self.table.on("rowClick", self._on_click, js_handler="(e, row) => emit(row.id)")

    def fill(self, rows: Sequence[Row]) -> None:
        """Show the current files; keep the selection."""
        if rows is self._shown:
            return
        self._shown = rows
        usable = sum(r.is_usable for r in rows)
        reasons = {row.upload.shown: row.refused for row in rows if row.refused}
        count = len(rows) + len(self._refused)
        reasons |= {name: f"{name}: {reason}" for name, reason in self._refused.items()}
        text = f"{count} {'file' if count == 1 else 'files'}, {usable} of them usable"
        if reasons:
            causes = dict.fromkeys(reason.partition(";")[0] for reason in reasons.values())
            text += f", {len(reasons)} refused: {'; '.join(causes)}"
        self.count.set_text(page_text(text) if count else NO_FILES)
        for part in (self.table, self.more):
            part.set_visibility(bool(rows))
        self.table.rows = [row.table_cells() for row in rows]
        self.chosen = [row.upload.key for row in rows if row.upload.key in self.chosen]
        self._update_selection()

    def _update_selection(self) -> None:
        self.table.selected = [c for c in self.table.rows if c["id"] in self.chosen]

    def _on_select(self, event: events.TableSelectionEventArguments) -> None:
        self.chosen = [str(c["id"]) for c in event.selection]
        self._choose(self.chosen)

    def _on_click(self, event: events.GenericEventArguments) -> None:
        key = str(event.args)
        self.chosen = [] if self.chosen == [key] else [key]
        self._update_selection()
        self._choose(self.chosen)


class Card:
    """One step on the page; `buttons` adds to its header, `show` displays its results below."""

    def __init__(
        self,
        desk: Desk,
        name: str,
        show: Callable[[StepResult], None],
        buttons: Callable[[], None] = lambda: None,
    ) -> None:
        self.desk, self.name, self._show_done = desk, name, show
        with dress(ui.card(), f"laboratory-{name}", "w-full", "flat bordered"):
            with ui.row().classes("w-full items-center justify-between"):
                heading(CARDS[name][0])
                with ui.row().classes("gap-2"):
                    buttons()
            self._box = Box(self._show, "w-full gap-2")

    def fill(self, chain: Chain) -> None:
        """Show the step's result, or the reason why there is none."""
        waits = chain.messages.get(self.name) or CARDS[self.name][1]
        self._box.fill(chain.done.get(self.name) or waits)

    def _show(self, content: StepResult | str) -> None:
        if isinstance(content, str):
            ui.label(page_text(content)).classes("opacity-80")
            return
        ident = f"laboratory-{self.name}"
        if content.problem:
            label = ui.label(page_text(content.problem))
            dress(label, f"{ident}-problem", "text-negative", role="alert")
        else:
            self._show_done(content)
        warnings = () if content.result is None else content.result.warnings
        keys = {content.notice, *(getattr(warning, "key", "") for warning in warnings)}
        for key, (text, settings) in REMEDIES.items():
            if key in keys:
                act = partial(self.desk.put_settings, "laboratory", settings)
                button(text, act, f"{ident}-remedy", "build")


REMEDIES = {
    "no-kinetic-friction": ("Use the midpoint of stick–slip", {"judder": "yes"}),
    "static-of-teeth": ("Evaluate the tests according to ASTM D1894", {"standard": "d1894"}),
}
"""{key of a notice: (text of a button, settings that the button applies)}."""


class NumberRow(NamedTuple):
    """A number of a step: its key, its name, its text and its 95 % interval, which may be empty."""

    key: str
    name: str
    text: str
    interval: str = ""


def result_numbers(result: Any) -> list[NumberRow]:
    """Return a step's numbers, with 95 % intervals if there are any."""
    rows, units = [], result.units
    for f in result.keys():  # noqa: SIM118
        value, unit, show_text = getattr(result, f.name), units.get(f.name), f.metadata["shown"]
        if f.name == "kinetic" and value is None:
            rows.append(NumberRow(f.name, "Kinetic", "stick–slip"))
        if unit is None or not f.metadata["listed"] or value is None:
            continue
        text = str(show_text(value)) if show_text else format_words(value, unit)
        interval = interval_text(result, f.name, unit, value, digits=4)
        rows.append(NumberRow(f.name, key_title(f.name), text, interval))
    before = getattr(result, "uncalibrated", None)
    if before:
        rows.append(NumberRow("before", "MAPE before calibration", f"{before['mape']:.2%}"))
    if hasattr(result, "uncalibrated"):
        rows.append(NumberRow("pulls", "Pulls", str(len(result.files))))
    return rows


HEROES = (
    ("validate", "mape", "Validation error"),
    ("calibrate", "mape", "Calibration error"),
    ("calibrate", "scale_factor", "Friction scale factor"),
    ("friction", "kinetic", "Kinetic friction"),
)
"""(step, key, name) of the large numbers."""


def headlines(chain: Chain) -> list[Hero]:
    """Return the headline numbers of the steps that have a result."""
    numbers = []
    for step, key, name in HEROES:
        done = chain.done.get(step)
        rows = [] if done is None or done.result is None else result_numbers(done.result)
        ident = f"hero-{step}-{key}"
        numbers += [Hero(ident, name, row.text, row.interval) for row in rows if row.key == key]
    return numbers


def show_step(step: StepResult) -> None:
    """Show a step's numbers, checks, figure and notes; the page already labels synthetic files."""
    name, result, meanings = step.call.name, step.result, result_fields(step.call.name)
    with ui.row().classes("w-full items-start gap-8"):
        with ui.grid(columns="auto auto").classes("gap-x-6 gap-y-1 items-baseline"):
            for key, words, value, interval in result_numbers(result):
                hint(words).tooltip(page_text(meanings.get(key, words)))
                ident = f"laboratory-{name}-{key.replace('_', '-')}"
                text = f"{value} ({interval})" if interval else value
                dress(ui.label(text), ident, "text-base font-medium")
        with ui.column().classes("gap-1").style("flex:1; min-width:280px"):
            show_checks(result)
    if step.picture:
        picture = ui.html(step.picture, sanitize=False)
        label = f"Figure: {CARDS[name][0]}"
        dress(picture, "", "figure", role="img", aria_label=label)
    rejections = [f"{path}: not used, {reason}" for path, reason in result.refused.items()]
    warnings = [w for w in result.warnings if warning_key(w) != "synthetic"]
    Notes().fill([*rejections, *dict.fromkeys(warnings)])
