"""Common parts of pages: controls, computation outside the event loop, results, copying."""

import asyncio
import contextlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nicegui import Client, app, background_tasks, run, ui

from layerjam.core.command.declare import load_command
from layerjam.core.command.predicted import PredictionResult
from layerjam.core.command.wording import format_words
from layerjam.core.errors import find_error_quantity
from layerjam.laboratory.commands.pull_by_pull import HEADS, TITLE, format_cells
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, collect_answers
from layerjam.workbench.call import Call, Options, result_fields
from layerjam.workbench.certainty import basis_html, interval_text
from layerjam.workbench.controls import Choice, Control, Slider, read_number, read_word
from layerjam.workbench.desk import Desk
from layerjam.workbench.live import Words
from layerjam.workbench.memory import tidy_after_result
from layerjam.workbench.runner import Runner, add_progress_line
from layerjam.workbench.spoken import typeset_text
from layerjam.workbench.tables import html_table
from layerjam.workbench.widgets import QUIET, Alert, dress, heading, hint, key_title


class ControlGroup:
    """Object with controls whose values the desk stores under `name`."""

    name = ""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        self.fields: dict[str, ui.input] = {}
        """{key of a quantity: its field, which shows errors about the quantity}."""

    def controls(self) -> Mapping[str, Control]:
        """Return the controls, with the bounds that the current brake and line set."""
        return {}

    def value(self, key: str) -> float:
        """Return a control's value [SI]."""
        return read_number(self.desk, self.name, self.controls()[key])

    def text(self, key: str) -> str:
        """Return a control's value as text for a command."""
        return self._control_text(self.controls()[key])

    def texts(self, *keys: str) -> Options:
        """Return {key: the control's value as text for a command}."""
        controls = self.controls()
        return {key: self._control_text(controls[key]) for key in keys}

    def _control_text(self, control: Control) -> str:
        return control.text(read_number(self.desk, self.name, control))

    def word(self, option: Choice) -> str:
        """Return the selected option."""
        return read_word(self.desk, self.name, option)

    def add_slider(self, key: str, is_shown: Callable[[], bool] | None = None) -> ui.column:
        """Add a control's slider; with `is_shown` it is visible only while that returns true."""
        with self.show_while(is_shown) as box:
            control = self.controls()[key]
            slider = Slider(self.desk, self.name, control, lambda: self.controls()[key])
        self.fields[key] = slider.field
        return box

    def enable_while(self, is_enabled: Callable[[], bool]) -> ui.column:
        """Add a column whose controls are enabled only while `is_enabled()` is true."""
        box = ui.column().classes("w-full gap-2")

        def update_box(_: str = "") -> None:
            if is_enabled():
                box.props(remove="inert")
            else:
                box.props("inert")

        self.desk.add_watcher(update_box)
        update_box()
        return box

    def show_while(self, is_shown: Callable[[], bool] | None) -> ui.column:
        """Add a column that is visible only while `is_shown()` is true."""
        box = ui.column().classes("w-full gap-2")
        if is_shown is not None:

            def update_box(_: str = "") -> None:
                box.set_visibility(is_shown())

            self.desk.add_watcher(update_box)
            update_box()
        return box


class View(ControlGroup):
    """A page, or a part of one; `build` fills its slot once, when it is first opened.

    `compute` runs in a thread and runs commands only, through `calls`; `draw` runs on the event
    loop. The `result` passed between them contains its calls, so what is shown, copied and pinned
    belongs to one computation, even if the next one was stopped.
    """

    built = False
    result: Any = None

    def build(self) -> None:
        """Build the elements of the page."""
        raise NotImplementedError

    def calls(self) -> Sequence[Call]:
        """Return the calls for the current inputs."""
        return ()

    def compute(self) -> Any:
        """Return the answers to the calls."""
        return [Answer(call, call.run()) for call in self.calls()]

    def begin(self) -> Any:
        """Return the answers, or a `Part` that `draw_part` shows while the others are computed."""
        return self.compute()

    def answers(self) -> Sequence[Answer]:
        """Return the displayed answers, in order; may be empty."""
        return collect_answers(self.result)

    def calls_to_copy(self) -> tuple[Sequence[Call], Mapping[str, Call]]:
        """Return the calls of the displayed or requested answers, and those of the pins."""
        answers, pins = self.answers(), dict[str, Call]()
        for answer in answers:
            for label, call in answer.pinned_calls.items():
                pins[f"{label}, {call.name}" if label in pins else label] = call
        return [answer.call for answer in answers] or self.calls(), pins

    def draw(self, result: Any) -> None:
        """Show the result of `compute`."""
        raise NotImplementedError

    def draw_part(self, part: Any) -> None:
        """Show the part of the result with which `begin` begins, if it returns one."""


class Page(View):
    """A tab with a heading, `title`, and a sentence next to the heading, `summary`."""

    title = summary = ""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.dark = False
        self.problem: Alert | None = None
        self.client: Client | None = None
        self._wrong: list[ui.input] = []
        """Fields that show an error of the last computation."""
        self.place: ui.element | None = None
        """Element that contains the page; tasks show notices and start downloads in it."""
        self.prepare: Callable[[], None] = lambda: None
        self.runner = Runner(self._compute_answer, self._show, run.io_bound, self._show_part)
        self._shows_part = False
        desk.add_watcher(self._on_change)

    def _compute_answer(self) -> Any:
        self.prepare()
        return self.begin()

    def open(self) -> None:
        """Build the page if necessary, and update it."""
        if not self.built:
            self.built = True
            self.client, self.place = ui.context.client, ui.context.slot.parent
            self.client.on_delete(self.runner.stop)
            self._build_head()
            self.build()
        self.refresh()

    def _build_head(self) -> None:
        if self.title:
            with ui.row().classes("page-head"):
                heading(self.title, 1)
                hint(self.summary)
        add_progress_line(self.name, self.runner)

    def refresh(self) -> None:
        """Compute again with the latest inputs."""
        if self.built and self.desk.state.page == self.name:
            background_tasks.create(self.runner.request_result(), name=f"layerjam {self.name}")

    def _on_change(self, change: str) -> None:
        if change not in ("page", "waiting", "choosing"):
            self.refresh()

    def _is_gone(self) -> bool:
        """Return whether the tab was closed in the meantime, or the program ends."""
        return self.client is None or self.client.is_deleted or app.is_stopping

    def _show_part(self, part: Any) -> None:
        if not self._is_gone():
            self._shows_part = True
            with self.place or contextlib.nullcontext():
                self.draw_part(part)

    def _show(self, result: Any, problem: str) -> None:
        if self._is_gone():
            return
        refusals = [] if problem else [(a.quantity, a.refusal) for a in collect_answers(result)]
        self._show_problems([*refusals, (find_error_quantity(self.runner.error), problem)])
        if self.problem is not None:
            self.problem.show_error(problem)
        if not problem:
            self.result = result
        # after a stop, the part that was shown gives way to the last result
        if not problem or (self._shows_part and self.result is not None):
            with self.place or contextlib.nullcontext():
                self.draw(self.result)
        self._shows_part = False
        background_tasks.create(tidy_after_result(self.name), name="layerjam settles")

    def _show_problems(self, problems: Sequence[tuple[str | None, str]]) -> None:
        for field in self._wrong:
            field.error = None
        self._wrong = []
        for quantity, sentence in problems:
            key = (quantity or "").replace(" ", "_")
            if key in self.fields:
                self.fields[key].error = typeset_text(sentence)
                self._wrong.append(self.fields[key])

    def add_alert(self) -> None:
        """Create the line that shows why inputs are rejected."""
        self.problem = Alert(f"{self.name}-problem")

    async def wait_until_idle(self) -> None:
        """Wait until no computation is running (for tests)."""
        while self.runner.running:
            await asyncio.sleep(0.01)


class Figures:
    """A small table of numbers: names on the left, values on the right, identified by key.

    A predicted number has its 95 % interval below it, and the table ends with what they rest on.
    """

    def __init__(self, page: str, command: str, keys: Sequence[str], **names: str) -> None:
        """Show the `keys` of the command's result; `names` renames keys that are unclear alone."""
        self._cells: dict[str, Words] = {}
        self._intervals: dict[str, Words] = {}
        self._ident = f"{page}-{command}-basis"
        meanings = result_fields(command)
        self._basis: live.Table | None = None
        is_predicted = issubclass(load_command(command).result, PredictionResult)
        with ui.grid(columns="auto auto").classes("figures gap-x-6 gap-y-1 items-baseline"):
            for key in keys:
                name = names.get(key) or key_title(key)
                label = ui.label(name).classes(QUIET)
                if key in meanings:
                    label.tooltip(typeset_text(meanings[key]))
                ident = f"{page}-{key}"
                self._cells[key] = dress(Words("–"), ident, "text-base font-medium text-right")
                if is_predicted:
                    self._intervals[key] = dress(Words(""), f"{ident}-interval", "interval")
            if is_predicted:
                self._basis = live.Table().classes("basis-box")

    def fill(self, result: Any, skip_keys: Sequence[str] = ()) -> None:
        """Show the numbers of a result with their units, except `skip_keys`, which do not apply."""
        values, units = result.values, result.units
        for key, cell in self._cells.items():
            value, unit = None if key in skip_keys else values.get(key), units.get(key, "1")
            cell.set_text("–" if value is None else format_words(value, unit))
            if key in self._intervals:
                text = "" if value is None else interval_text(result, key, unit, value, digits=4)
                self._intervals[key].set_text(text)
        if self._basis is not None:
            self._basis.set_content(basis_html(result, self._ident))


class Box(ui.column):
    """A column that `show` fills; unchanged content is not rebuilt."""

    def __init__(self, show: Callable[[Any], None], classes: str = "w-full gap-1") -> None:
        super().__init__()
        self.classes(classes)
        self._show_in_it = show
        self._shown: Any = None

    def fill(self, item: Any) -> bool:
        """Show an item, and return whether it differs from the previous one."""
        if item is self._shown:
            return False
        self._shown = item
        self.clear()
        with self:
            self._show_in_it(item)
        return True


class Notes:
    """The warnings of a result as unobtrusive lines."""

    def __init__(self) -> None:
        self._box = ui.column().classes(f"gap-1 {QUIET}")
        self._lines: list[Words] = []

    def fill(self, warnings: Sequence[str]) -> None:
        """Show the warnings; lines are added and removed only if their number changes."""
        for line in self._lines[len(warnings) :]:
            line.delete()
        del self._lines[len(warnings) :]
        with self._box:
            self._lines += [Words("") for _ in warnings[len(self._lines) :]]
        for line, sentence in zip(self._lines, warnings, strict=True):
            line.set_text(f"Note: {sentence}")


TONES = {
    "passed": ("yes", "✓ ok"),
    "note": ("yes", "note"),
    "warning": ("no", "✗ check"),
    "failed": ("no", "✗ failed"),
}
"""{level of a check: (style, label)}."""


def show_checks(result: Any) -> None:
    """Show the table of pulls and the checks; parts missing from the result are omitted."""
    pulls = result.values.get("pulls", ())
    if len(pulls) > 1:
        heads = [name.capitalize() for name in HEADS]
        live.Table().set_content(
            html_table(heads, map(format_cells, pulls), range(6), TITLE, "pull-by-pull")
        )
    for check in result.values.get("checks", ()):
        with ui.row().classes("no-wrap gap-2 items-baseline"):
            tone, word = TONES[check["level"]]
            ui.label(word).classes(f"{tone} font-medium whitespace-nowrap")
            text = typeset_text(f"{check['name']}: {check['sentence']}")
            ui.label(text).classes("text-sm")
