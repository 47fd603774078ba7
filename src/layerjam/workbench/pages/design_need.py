"""Search for a brake: specification, search run and results."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache, partial
from html import escape
from typing import Any, NamedTuple

from nicegui import events, ui

from layerjam.brake.device.load import catalogue
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.units import exact_text, show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.controls import Control, control, map_keys
from layerjam.workbench.desk import read_device
from layerjam.workbench.page import Notes, Page
from layerjam.workbench.pages import design_front as front
from layerjam.workbench.pages.design_form import Form
from layerjam.workbench.pages.design_part import PAGE, Part, key_name
from layerjam.workbench.panel import Panel
from layerjam.workbench.runner import ComputationStopped
from layerjam.workbench.spoken import typeset_text
from layerjam.workbench.widgets import (
    Heroes,
    button,
    columns,
    dress,
    fold,
    hint,
    one_line,
    select,
    status,
)
from layerjam.workshop.commands.design import brake_of
from layerjam.workshop.design.design_file import plain_name
from layerjam.workshop.design.requirements import DesignSpecification
from layerjam.workshop.design.specification import example_texts, read_spec
from layerjam.workshop.design.verdict import describe_design
from layerjam.workshop.figures.design_figures import find_front_axes

LONGEST = 20_000
"""Maximum number of characters of a specification on the page; it must fit in a link."""
SHARE = 0.95
"""Share of brakes that meet all constraints, unless another is chosen."""
STOPPED = "Stopped. Press Search to restart."
EMPTY = "Set what the brake must do, then press Search."
CHANGED = "The requirement has changed since the search."
TABLES = (
    ("Comparison of designs", "comparison", True),
    ("All rows", "all_rows", False),
    ("Better designs that are excluded", "forbidden", False),
    ("Robustness of the selected design", "chances", False),
    ("Sensitivity of the selected design", "slopes", False),
)
"""(title, key, whether it is open at first) of each table."""


class SearchResult(NamedTuple):
    """An answer, or the reason why there is none, with the line of the specification."""

    answer: Answer | None = None
    problem: str = ""
    line: int | None = None
    pull: tuple[float, float] | None = None
    """Peak force and force at the end of travel, in a pull of the chosen design [N]."""

    @property
    def result(self) -> Any:
        """Result of the answer, or None."""
        return None if self.answer is None else self.answer.result

    @property
    def design(self) -> Any:
        """The result if a design meets the requirements, otherwise None."""
        return self.result if self.result is not None and self.result.feasible else None


@lru_cache(maxsize=8)
def read_specification(text: str, begin: str = "") -> DesignSpecification:
    """Return a specification from the page; raises FileError with the line number.

    No file is opened: a specification that starts from the current brake uses its text `begin`.
    """
    if len(text) > LONGEST:
        raise FileError("the specification", f"{len(text)} characters; the limit is {LONGEST}")
    brakes = {}
    if begin:
        with suppress(LayerjamError):
            file = read_device("brake", begin)
            brakes = {f"{file.name}.toml": file}
    return read_spec(text, "specification", brakes)


class NeedPart(Part):
    """Part with the specification on the left, and with the front and its designs on the right."""

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self.form = Form(self.desk, self._store_text)
        self._found: tuple[object, SearchResult] = (None, SearchResult())
        self._drawn: tuple[object, ...] = ()
        self._spec_seen = ""
        self.panel = Panel(self.desk, PAGE)

    # ---- requirement

    @property
    def is_requested(self) -> bool:
        """Whether a search was requested, on the page or by the link."""
        return self.desk.state.find_setting(PAGE, "spec") is not None

    def spec_text(self) -> tuple[str, str]:
        """Return the text of the last search, and its name if it is an example."""
        spec = str(self.desk.get(PAGE, "spec", ""))
        return (example_texts()[spec], spec) if spec in example_texts() else (spec, "")

    def start_brake(self) -> str:
        """Return the text of the brake on which the specification is based, as of the search."""
        return str(self.desk.get(PAGE, "begin", ""))

    def controls(self) -> Mapping[str, Control]:
        """Return the control for the share of brakes, which the next search uses."""
        label = "Share of brakes that meet the requirement"
        return map_keys(control("design", "confidence", SHARE, (0.5, 0.99), label=label))

    def share(self) -> float:
        """Return the share of brakes of the last search."""
        value = self.desk.get(PAGE, "share", SHARE)
        return float(value) if isinstance(value, int | float) else SHARE

    def spec(self) -> DesignSpecification:
        """Return the specification; raises FileError with the line number."""
        return read_specification(self.spec_text()[0], self.start_brake())

    def calls(self) -> Sequence[Call]:
        """Return the call for the search; a specification of the user's own is a file to save."""
        _, name = self.spec_text()
        if not self.is_requested:
            return []
        share = self.share()
        options = {} if share == SHARE else {"confidence": f"{share:g}"}
        if name:
            return [Call("design", (Subject(name),), options)]
        spec = self.spec()
        begin = self.start_brake()
        file = f"{spec.brake.name}.toml"
        needs = ((file, begin),) if begin and f'"{file}"' in spec.text else ()
        return [Call("design", (Subject(f"{plain_name(spec.name)}.toml", spec, needs),), options)]

    def _request_key(self) -> object:
        return self.spec_text(), self.start_brake(), self.share()

    def _displayed_result(self) -> Any:
        """Return the result whose front is displayed; None during a search."""
        return None if self.panel.shown is None else self.panel.shown.result

    def compute(self) -> SearchResult:
        """Return the result for the specification, from the cache if possible."""
        key = self._request_key()
        if self._found[0] != key:
            self._found = (key, self._run_search())
        return self._found[1]

    def _run_search(self) -> SearchResult:
        if not self.is_requested:
            return SearchResult()
        try:
            (call,) = self.calls()
            result = call.run(progress=self.page.runner.report_progress)
            answer = Answer(call, result, title=f"{plain_name(result.name)}-design")
            return SearchResult(answer, pull=pull_forces(result) if result.feasible else None)
        except FileError as err:
            return SearchResult(None, err.reason, err.line)
        except LayerjamError as err:
            return SearchResult(None, str(err))
        except ComputationStopped:
            return SearchResult(None, STOPPED)

    # ---- layout

    def build(self) -> None:
        """Build form and text on the left, front and tables on the right."""
        side, main = columns(all_shown=True)
        with side:
            self.form.build()
            self.add_slider("confidence")
            with ui.row().classes("items-center gap-2"):
                button("Search", self.start_search, f"{PAGE}-search", "search", look="no-caps")
            self.trouble = ui.html("", sanitize=False)
            dress(self.trouble, f"{PAGE}-spec-problem", "text-negative text-sm", role="alert")
            with fold("Requirement as TOML", f"{PAGE}-form-open"):
                self._build_specification()
        with main:
            with ui.column().classes("w-full items-start gap-3") as self.empty:
                self.advice = status(f"{PAGE}-advice", "text-lg", EMPTY)
                button("Search", self.start_search, f"{PAGE}-first", "search", look="no-caps")
            self.heroes = Heroes(PAGE)
            self.sentence = status(f"{PAGE}-sentence", "text-lg")
            self.verdict = dress(ui.label(""), f"{PAGE}-outcome", "text-sm", role="status")
            self.verdict.style("white-space: pre-line")
            with ui.column().classes("w-full gap-3") as self.results:
                self._build_results()
            self.results.set_visibility(False)
            self.notes_fold = fold("Notes", f"{PAGE}-notes")
            with self.notes_fold:
                self.notes = Notes()
        self.desk.add_watcher(self._on_change)
        if self.is_requested:
            self.form.follow_text(self.spec_text()[0])

    def _build_specification(self) -> None:
        text = self.spec_text()[0] if self.is_requested else self.form.text_written
        area = ui.textarea("Requirement (TOML)", value=text)
        label, look = "Specification as TOML", "outlined spellcheck=false wrap=off"
        self.editor = dress(area, f"{PAGE}-spec", "w-full design-spec", look, aria_label=label)
        dress(self.editor, maxlength=LONGEST).on("keydown.ctrl.enter", self.start_search)
        self.editor.on_value_change(lambda _: self._mark_outdated())
        self.editor.on("blur", lambda: self.form.follow_text(str(self.editor.value or "")))
        with ui.row().classes("items-center gap-2"):
            button("Save TOML", self.save_text, f"{PAGE}-save", "download")
            for name, text in example_texts().items():
                button(f"example {name}", partial(self.use_example, text), f"{PAGE}-example-{name}")
        hint(
            "Updated from the form. Refer to brakes, films and lines in the catalogue by name, and "
            "to the current brake as NAME.toml. No other file is read. Ctrl+Enter starts a search."
        )

    def _build_results(self) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self.over = {}
            for key, label in (("x", "Horizontal axis"), ("y", "Vertical axis")):
                on_select = partial(self._on_axis, key)
                self.over[key] = select({}, label, f"{PAGE}-{key}", on_select, classes="w-44")
            for arrow, direction, step in (("left", "previous", -1), ("right", "next", 1)):
                caption, look = f"{direction.capitalize()} design on the front", "flat round dense"
                act, icon = partial(self.select_neighbour, step), f"chevron_{arrow}"
                walker = button("", act, f"{PAGE}-{direction}", icon, look=look, tip=caption)
                dress(walker, aria_label=caption)
            text, look = "Use this brake on all pages", "no-caps dense"
            button(text, self.use_design, f"{PAGE}-take", "move_down", look=look)
        caption = "The Pareto front; use the buttons above to move along it"
        size = "width: 100%; height: max(400px, 50vh)"
        self.panel.build(f"{PAGE}-front", caption, size, self._on_click)
        self.looked = status(f"{PAGE}-picked", "font-medium")
        self.tables: dict[str, live.Table] = {}
        for title, key, is_open in TABLES:
            with fold(title, is_open=is_open):
                self.tables[key] = dress(live.Table(), f"{PAGE}-{key}", "w-full")
        self.panel.build_exports()

    def _on_change(self, change: str) -> None:
        if change == "undo" and self._spec_seen != self.spec_text()[0]:
            self._spec_seen = self.spec_text()[0]
            self.editor.set_value(self._spec_seen or self.form.text_written)
        if self.panel.shown is not None and self._found[0] != self._request_key():
            self._hide_front()
        self._mark_outdated()

    def _store_text(self, text: str) -> None:
        self.editor.set_value(text)

    def _mark_outdated(self) -> None:
        """Offer the search if none was requested, or if the requirement has changed since."""
        is_new = (
            self.editor.value != self.spec_text()[0] or self.value("confidence") != self.share()
        )
        self.advice.set_text(CHANGED if self.is_requested else EMPTY)
        self.empty.set_visibility(not self.is_requested or is_new)

    def _hide_front(self) -> None:
        self.panel.draw(None, None)
        self.result = None
        self.empty.set_visibility(False)
        self.heroes.fill([])
        self.sentence.set_text("Searching")
        self.verdict.set_text("")
        self.results.set_visibility(False)

    # ---- user actions

    def use_example(self, text: str) -> None:
        """Search with the text of an example."""
        self.editor.set_value(text)
        self.form.follow_text(text)
        self.start_search()

    def start_search(self, _: object = None) -> None:
        """Search for the requirement in the editor; earlier results are discarded."""
        text = str(self.editor.value or "")
        same = next((n for n, example in example_texts().items() if example == text), text)
        file = self.desk.brake
        is_own = self.desk.state.brake not in catalogue() and f'"{file.name}.toml"' in text
        self._found = (None, SearchResult())
        self._hide_front()
        self.desk.put_setting(PAGE, "picked", float(front.CHOSEN))
        if is_own:
            self.desk.put_setting(PAGE, "begin", self.desk.state.brake)
        if self.value("confidence") != self.share():
            self.desk.put_setting(PAGE, "share", self.value("confidence"))
        self.desk.put_setting(PAGE, "spec", same)
        self._spec_seen = self.spec_text()[0]
        self.page.refresh()

    def save_text(self) -> None:
        """Save the text in the editor as a file."""
        text, name = str(self.editor.value or ""), "specification"
        with suppress(LayerjamError):
            name = plain_name(read_specification(text, self.start_brake()).name)
        ui.download.content(text.encode(), f"{name}.toml", "application/toml")

    def select_design(self, number: int) -> None:
        """Select a different design."""
        self.desk.put_setting(PAGE, "picked", float(number))

    def _on_click(self, event: events.EChartPointClickEventArguments) -> None:
        value = event.value
        if isinstance(value, list) and len(value) > 2 and self._displayed_result() is not None:
            self.select_design(int(value[2]))

    def select_neighbour(self, step: int) -> None:
        """Select the design that is `step` positions further along the front."""
        result = self._displayed_result()
        if result is None:
            return
        numbers = front.front_indices(result)
        number, _ = front.pick_design(result, self.selection())
        place = numbers.index(number) if number in numbers else 0
        self.select_design(numbers[(place + step) % len(numbers)])

    def selection(self) -> int:
        """Return the stored index of the selected design."""
        value = self.desk.get(PAGE, "picked", float(front.CHOSEN))
        return int(value) if isinstance(value, int | float) else front.CHOSEN

    def _on_axis(self, key: str, event: events.ValueChangeEventArguments[Any]) -> None:
        result = self._displayed_result()
        if event.value and result is not None:
            usual = find_front_axes(result)[key == "y"]
            self.desk.put_setting(PAGE, key, "" if event.value == usual else str(event.value))

    def use_design(self) -> None:
        """Make the selected design the desk's brake."""
        result = self._displayed_result()
        if result is None:
            return
        number, design = front.pick_design(result, self.selection())
        try:
            file = brake_of(result, None if number == front.REFINED else number)
            self.desk.put_brake(file.text)
        except LayerjamError as err:
            ui.notify(one_line(err), type="warning")
            return
        count = int(design["series"] * design["parallel"])
        note = f"; the design has {count} of these" if count > 1 else ""
        ui.notify(
            f"{file.name} is now the current brake, used at {show(design['vacuum'], 'Pa')}{note}"
        )

    # ---- results

    def draw(self, outcome: SearchResult) -> None:
        """Show the outcome; unchanged parts are kept, outdated results are not shown."""
        key, of_now = self._found
        if of_now is not outcome or key != self._request_key():
            return
        self.trouble.set_content(describe_problem(outcome, self.spec_text()[0]))
        result = outcome.result
        self._mark_outdated()
        self.results.set_visibility(outcome.design is not None)
        self.verdict.set_text("" if result is None else typeset_text(front.outcome_text(result)))
        warnings = [] if result is None else result.warnings
        self.notes.fill(warnings)
        self.notes_fold.set_text(f"{len(warnings)} {'note' if len(warnings) == 1 else 'notes'}")
        self.notes_fold.set_visibility(bool(warnings))
        if outcome.design is None:
            self.heroes.fill([])
            self.sentence.set_text("")
            self.panel.draw(None, None)
            return
        names = self._update_axes(result)
        number, design = front.pick_design(result, self.selection())
        drawing_key = (names, number, self.page.dark)
        if self.panel.shown is outcome.answer and self._drawn == drawing_key:
            return
        self._drawn = drawing_key
        chart = front.front_chart(result, names, number, self.page.dark)
        self.panel.draw(outcome.answer, chart)
        source = front.find_predicted(result, design)
        self.heroes.fill(front.headlines(result, design), source)
        is_chosen = number == result.chosen["number"]
        self.sentence.set_text(
            front.forces_text(result, design, outcome.pull if is_chosen else None)
        )
        self.looked.set_text(f"Selected: {describe_design(design)}")
        for key, is_main in (("comparison", True), ("all_rows", False)):
            self.tables[key].set_content(front.comparison_table(result, number, is_main))
        tables = (front.exclusion_table, front.probability_table, front.sensitivity_table)
        for key, make in zip(("forbidden", "chances", "slopes"), tables, strict=True):
            self.tables[key].set_content(make(result))

    def _update_axes(self, result: Any) -> tuple[str, str]:
        """Return the quantities on the axes of the front, and update the menus."""
        names = front.find_axes(result)
        out = []
        for key, usual in zip(("x", "y"), find_front_axes(result), strict=True):
            setting = str(self.desk.get(PAGE, key, ""))
            name = setting if setting in names else usual
            out.append(name)
            labels = {**names, usual: key_name(usual)}
            if self.over[key].options != labels or self.over[key].value != name:
                self.over[key].set_options(labels, value=name)
        return out[0], out[1]


def describe_problem(outcome: SearchResult, text: str) -> str:
    """Return why there is no result, as HTML, with the line of the specification."""
    if not outcome.problem:
        return ""
    text_shown = escape(" ".join(outcome.problem.split()))
    rows = text.splitlines()
    if outcome.line is None or not 0 < outcome.line <= len(rows):
        return text_shown
    line = escape(rows[outcome.line - 1].strip()[:120])
    return f"Line {outcome.line}: <code>{line}</code><br>{text_shown}"


def pull_forces(result: Any) -> tuple[float, float] | None:
    """Return peak and final force of a pull of the chosen design [N]; None if it is rejected."""
    design = result.chosen
    try:
        file = brake_of(result, design["number"])
        options = {"vacuum": exact_text(design["vacuum"], "Pa"), "speed": "1 mm/s"}
        options["travel"] = exact_text(file.brake.sheets.usable_travel, "m")
        pull = Call("tensile", (Subject(f"{file.name}.toml", file),), options).run()
    except LayerjamError:
        return None
    return pull.peak_force * design["parallel"], pull.force_at_end * design["parallel"]
