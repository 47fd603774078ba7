"""From a need to a brake: a specification, the search, and what it found."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from html import escape
from typing import Any, NamedTuple

from nicegui import events, ui

from layerjam.commands.answer import Answer
from layerjam.commands.design import brake_of
from layerjam.design.requirements import DesignSpecification
from layerjam.design.specification import examples, read_spec
from layerjam.design.verdict import named
from layerjam.device.file import BrakeFile
from layerjam.device.load import catalogue
from layerjam.errors import FileError, LayerjamError
from layerjam.units import show
from layerjam.workbench import live, takeaway
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import read_any_brake
from layerjam.workbench.page import Notes
from layerjam.workbench.pages import design_front as front
from layerjam.workbench.pages.design_form import Form
from layerjam.workbench.pages.design_part import PAGE, Host, Part, words
from layerjam.workbench.rest import elsewhere
from layerjam.workbench.runner import Stopped

LONGEST = 20_000
"""Characters of a specification on the page; the link has to hold it."""
FIRST = "wrist"
STOPPED = "Stopped. Search begins it anew."


class Found(NamedTuple):
    """An answer, or why there is none and at which line."""

    answer: Any = None
    problem: str = ""
    line: int | None = None


class NeedPart(Part):
    """The specification left, the front and the designs right."""

    def __init__(self, page: Host) -> None:
        super().__init__(page)
        self.form = Form(self.desk, self.written)
        self._read: tuple[object, DesignSpecification | None] = (None, None)
        self._found: tuple[object, Found] = (None, Found())
        self._drawn: tuple[object, ...] = ()

    # ---- what is asked

    def spec_text(self) -> tuple[str, str]:
        """(text, its name where it is an example's) that was last searched."""
        said = str(self.desk.get(PAGE, "spec", FIRST))
        return (examples()[said], said) if said in examples() else (said, "")

    def beside(self) -> dict[str, BrakeFile]:
        """The brake of the desk that the specification begins from, as it was then."""
        text = str(self.desk.get(PAGE, "begin", ""))
        try:
            file = read_any_brake(text) if text else None
        except LayerjamError:
            return {}
        return {} if file is None else {f"{file.name}.toml": file}

    def spec(self) -> DesignSpecification:
        """The specification; raises FileError with the line."""
        text, _ = self.spec_text()
        key = (text, self.desk.get(PAGE, "begin", ""))
        if self._read[0] != key or self._read[1] is None:
            self._read = (key, read(text, self.beside()))
        assert self._read[1] is not None
        return self._read[1]

    def calls(self) -> Sequence[Call]:
        """The search; an own specification is the file that can be saved."""
        _, name = self.spec_text()
        if name:
            return [Call("design", (Subject(name),))]
        spec = self.spec()
        return [Call("design", (Subject(f"{front.file_name(spec)}.toml", spec),))]

    def compute(self) -> Found:
        """The answer to the specification; nothing twice, and nothing anew that was stopped."""
        key = (self.spec_text(), self.desk.get(PAGE, "begin", ""))
        if self._found[0] != key:
            self._found = (key, self._search())
        return self._found[1]

    def _search(self) -> Found:
        try:
            answer = self.calls()[0].run(progress=self.page.waiting.tell)
        except FileError as err:
            return Found(None, err.reason, err.line)
        except LayerjamError as err:
            return Found(None, str(err))
        except Stopped:
            return Found(None, STOPPED)
        return Found(answer)

    # ---- what stands on the page

    def build(self) -> None:
        """Specification, then front and tables."""
        with ui.row().classes("w-full no-wrap items-start gap-6 page"):
            with ui.column().classes("side design-side"):
                self._specification()
            with ui.column().classes("main gap-3"):
                self.verdict = ui.label("").style("white-space: pre-line").props(
                    f'role="status" data-testid="{PAGE}-outcome"'
                )  # fmt: skip
                with ui.column().classes("w-full gap-3") as self.results:
                    self._results()
                self.results.set_visibility(False)
                self.notes = Notes()
        self.desk.watch(lambda what: self._fill() if what == "undo" else None)

    def _specification(self) -> None:
        with ui.row().classes("items-center gap-2"):
            ui.label("Begin from").classes("text-sm")
            for name in examples():
                ui.button(f"example {name}", on_click=partial(self.begin, name)).props(
                    f'outline dense no-caps data-testid="{PAGE}-example-{name}"'
                )
        self.form.build()
        self.editor = ui.textarea("What is wanted (TOML)", value=self.spec_text()[0]).props(
            f'outlined data-testid="{PAGE}-spec" spellcheck="false" maxlength={LONGEST} '
            'aria-label="Specification as TOML" wrap="off"'
        ).classes("w-full design-spec")  # fmt: skip
        self.editor.on("keydown.ctrl.enter", self.search)
        self.trouble = ui.html("", sanitize=False).classes("text-negative text-sm").props(
            f'role="alert" data-testid="{PAGE}-spec-problem"'
        )  # fmt: skip
        with ui.row().classes("items-center gap-2"):
            ui.button("Search", icon="search", on_click=self.search).props(
                f'no-caps data-testid="{PAGE}-search"'
            ).tooltip("Ctrl Enter in the text")
            ui.button("Save TOML", icon="download", on_click=self.save).props(
                f'outline dense no-caps data-testid="{PAGE}-save"'
            )
        ui.label(
            "Brakes, films and lines of the catalogue by name; the desk's own brake as "
            "NAME.toml. No file is opened from here."
        ).classes("text-sm opacity-80")

    def _results(self) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self.over = {
                key: ui.select({}, label=label, on_change=partial(self._seen_over, key))
                .props(f'dense outlined options-dense data-testid="{PAGE}-{key}" '
                       f'aria-label="{label}"').classes("w-44")
                for key, label in (("x", "Across"), ("y", "Up"))
            }  # fmt: skip
            for icon, what, step in (("chevron_left", "Previous design on the front", -1),
                                     ("chevron_right", "Next design on the front", 1)):  # fmt: skip
                ui.button(icon=icon, on_click=partial(self.walk, step)).props(
                    f'flat round dense aria-label="{what}" '
                    f'data-testid="{PAGE}-{"next" if step > 0 else "previous"}"'
                ).tooltip(what)
            ui.button("Put this brake on the desk", icon="move_down", on_click=self.take).props(
                f'no-caps dense data-testid="{PAGE}-take"'
            )
        self.chart = ui.echart({}, on_point_click=self._clicked).classes("chart").style(
            "height: 400px"
        ).props(
            f'data-testid="{PAGE}-front" role="img" aria-label="The front; the buttons above walk '
            'along it"'
        )  # fmt: skip
        self.looked = (
            live.Words("")
            .classes("font-medium")
            .props(f'role="status" data-testid="{PAGE}-picked"')
        )
        self.tables: dict[str, live.Table] = {}
        for key, title, is_open in (
            ("comparison", "Designs side by side", True),
            ("forbidden", "Better, but forbidden", True),
            ("chances", "Robustness of the chosen design", False),
            ("slopes", "What changes what, at the chosen design", False),
        ):
            with (
                ui.expansion(title, value=is_open)
                .classes("w-full")
                .props('dense header-class="font-medium"')
            ):
                self.tables[key] = live.Table().classes("w-full").props(
                    f'data-testid="{PAGE}-{key}"'
                )  # fmt: skip
        with ui.row().classes("items-center gap-2"):
            ui.label("Take away").classes("text-sm")
            for ending in takeaway.ENDINGS:
                ui.button(f"figure as {ending.upper()}", on_click=partial(self.figure, ending)
                ).props(f'outline dense no-caps data-testid="{PAGE}-figure-{ending}"')  # fmt: skip

    def _fill(self) -> None:
        """The editor after undo."""
        self.editor.set_value(self.spec_text()[0])

    # ---- what the user does

    def begin(self, name: str) -> None:
        """One of the examples, searched."""
        self.written(examples()[name])

    def written(self, text: str) -> None:
        """A text that was not typed, searched."""
        self.editor.set_value(text)
        self.search()

    def search(self, _: object = None) -> None:
        """Search for what stands in the editor; what was found before is forgotten."""
        text = str(self.editor.value or "")
        same = next((n for n, shipped in examples().items() if shipped == text), text)
        file = self.desk.brake
        own = self.desk.state.brake not in catalogue() and f'"{file.name}.toml"' in text
        self._found = (None, Found())
        self.verdict.set_text("Searching")
        self.desk.put(PAGE, "picked", float(front.CHOSEN))
        if own:
            self.desk.put(PAGE, "begin", self.desk.state.brake)
        self.desk.put(PAGE, "spec", same)
        self.page.refresh()

    def save(self) -> None:
        """The text in the editor as a file."""
        text = str(self.editor.value or "")
        try:
            name = front.file_name(read(text, self.beside()))
        except LayerjamError:
            name = "specification"
        ui.download.content(text.encode(), f"{name}.toml", "application/toml")

    def pick(self, number: int) -> None:
        """Look at another design."""
        self.desk.put(PAGE, "picked", float(number))

    def _clicked(self, event: events.EChartPointClickEventArguments) -> None:
        value = event.value
        if isinstance(value, list) and len(value) > 2:
            self.pick(int(value[2]))

    def walk(self, step: int) -> None:
        """The next design along the front."""
        answer = self._found[1].answer
        if answer is None or not answer.feasible:
            return
        numbers = front.along(answer)
        number, _ = front.picked(answer, self.wanted())
        place = numbers.index(number) if number in numbers else 0
        self.pick(numbers[(place + step) % len(numbers)])

    def wanted(self) -> int:
        """The number of the design looked at, as it was put."""
        value = self.desk.get(PAGE, "picked", float(front.CHOSEN))
        return int(value) if isinstance(value, int | float) else front.CHOSEN

    def _seen_over(self, key: str, event: events.ValueChangeEventArguments[Any]) -> None:
        answer = self._found[1].answer
        if event.value and answer is not None and answer.feasible:
            usual = front.axes(answer)[key == "y"]
            self.desk.put(PAGE, key, "" if event.value == usual else str(event.value))

    def take(self) -> None:
        """The design looked at becomes the desk's brake."""
        answer = self._found[1].answer
        if answer is None or not answer.feasible:
            return
        number, design = front.picked(answer, self.wanted())
        try:
            file = brake_of(answer, None if number == front.REFINED else number)
            self.desk.put_brake(file.text)
        except LayerjamError as err:
            ui.notify(" ".join(str(err).split()), type="warning")
            return
        count = int(design["series"] * design["parallel"])
        many = f"; the design is {count} of them" if count > 1 else ""
        ui.notify(f"{file.name} is on the desk, used at {show(design['vacuum'], 'Pa')}{many}")

    async def figure(self, ending: str) -> None:
        """The figure that `design --figure` writes."""
        answer = self._found[1].answer
        if answer is None or not answer.feasible:
            return
        from layerjam.report.design_figures import front as drawn

        content = await elsewhere(lambda: takeaway.figure_bytes(drawn(answer), ending))
        if content is not None:
            name = front.file_name(answer.record.spec)
            ui.download.content(content, f"{name}-design.{ending}")

    # ---- what is shown

    def draw(self, found: Found) -> None:
        """The outcome; what has not changed stays as it is."""
        self.trouble.set_content(problem(found, self.spec_text()[0]))
        answer = found.answer
        fine = answer is not None and bool(answer.feasible)
        self.results.set_visibility(fine)
        self.verdict.set_text("" if answer is None else front.verdict(answer))
        self.notes.fill([] if answer is None else answer.warnings)
        if answer is None or not fine:
            self._drawn = ()
            return
        names = self._axes(answer)
        number, design = front.picked(answer, self.wanted())
        now = (id(answer), names, number, self.page.dark)
        if now == self._drawn:
            return
        fresh = now[0] != (self._drawn or (0,))[0]
        self._drawn = now
        live.draw(self.chart, front.front_chart(answer, names, number, self.page.dark))
        self.looked.set_text(f"Looked at: {named(design)}")
        self.tables["comparison"].set_content(front.comparison(answer, number))
        if fresh:
            for key, made in (("forbidden", front.forbidden), ("chances", front.chances),
                              ("slopes", front.slopes)):  # fmt: skip
                self.tables[key].set_content(made(answer))

    def _axes(self, answer: Answer) -> tuple[str, str]:
        """What the front is seen over now; the menus follow."""
        known = front.drawable(answer)
        out = []
        for key, usual in zip(("x", "y"), front.axes(answer), strict=True):
            wanted = str(self.desk.get(PAGE, key, ""))
            name = wanted if wanted in known else usual
            out.append(name)
            shown = {**known, usual: words(usual)}
            if self.over[key].options != shown or self.over[key].value != name:
                self.over[key].set_options(shown, value=name)
        return out[0], out[1]


def read(text: str, beside: dict[str, BrakeFile]) -> DesignSpecification:
    """A specification from the page: no file is opened; raises FileError."""
    if len(text) > LONGEST:
        raise FileError("the specification", f"{len(text)} characters; at most {LONGEST} are read")
    return read_spec(text, "specification", beside)


def problem(found: Found, text: str) -> str:
    """Why there is no answer, with the line it is about."""
    if not found.problem:
        return ""
    said = escape(" ".join(found.problem.split()))
    rows = text.splitlines()
    if found.line is None or not 0 < found.line <= len(rows):
        return said
    line = escape(rows[found.line - 1].strip()[:120])
    return f"Line {found.line}: <code>{line}</code><br>{said}"
