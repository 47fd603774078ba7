"""Pull: force against elongation over vacuum, speed and model, with measured pulls over it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nicegui import ui

from layerjam.commands.answer import SPEED, TRAVEL, VACUUM, Answer
from layerjam.commands.stick_slip import DAMPING
from layerjam.errors import LayerjamError
from layerjam.units import QuantitySpec
from layerjam.workbench import live, tables, takeaway
from layerjam.workbench.call import Call
from layerjam.workbench.controls import Choice, Control, choice, number, slider, word
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Figures, Notes, Page
from layerjam.workbench.pages.pull_chart import pulled, saw
from layerjam.workbench.pages.pull_files import Errors, Measured, Reading, laid_out, read
from layerjam.workbench.rest import elsewhere
from layerjam.workbench.uploads import Uploads
from layerjam.workbench.waiting import Waiting

MODEL = Choice(
    "model",
    {"lumped": "lumped", "stack": "sheet by sheet", "judder": "judder"},
    "lumped",
    help="One friction for all sheets; every sheet a spring and every interface a friction; or a "
    "mass on a spring that sticks and slips, over time",
)
STYLE = """
.q-uploader__subtitle { display: none }
.q-uploader__list { min-height: 40px; padding: 4px }
"""
PULLED = [
    ("peak_force", "Peak force"), ("peak_elongation", "at elongation"),
    ("force_at_end", "Force at the end"), ("work", "Work"), ("dissipated_energy", "of it heat"),
    ("outcome", "Outcome"),
]  # fmt: skip
SAW = [
    ("outcome", "Outcome"), ("force_high", "Highest force, last slip"),
    ("force_low", "Lowest force"), ("amplitude", "Amplitude"), ("slip_per_event", "Slip of one"),
    ("period", "Every"), ("events", "Slips"), ("critical_speed", "Dies out above"),
    ("stiffness_needed", "Stiffness without it"),
]  # fmt: skip


class Pull(Page):
    """Drag the vacuum and watch the force curve rise."""

    name = "pull"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.uploads = Uploads()
        self._read: tuple[object, Reading] = (None, Reading())
        self._whole: tuple[object, Answer | None] = (None, None)

    def controls(self) -> dict[str, Control]:
        """Bounds that the brake sets."""
        brake = self.desk.brake.brake
        full, usable = brake.site.atmosphere, brake.sheets.usable_travel
        vacuum = QuantitySpec("Pa", VACUUM.text, 0.0, full)
        return {
            c.key: c
            for c in (
                Control("vacuum", vacuum, min(94.5e3, full), 0.0, full),
                Control("speed", SPEED, 0.001, 1e-4, 0.05),
                Control("travel", TRAVEL, min(0.04, usable), 0.001, usable, label="Elongation"),
                Control("damping", DAMPING, 0.0, 0.0, 100.0),
                Control("files_vacuum", vacuum, min(94.5e3, full), 0.0, full,
                        label="Vacuum of files that do not say it"),
            )
        }  # fmt: skip

    def build(self) -> None:
        """Controls left, curve right."""
        ui.add_css(tables.STYLE + STYLE)
        ui.context.client.on_delete(self.uploads.close)
        with ui.row().classes("w-full no-wrap items-start gap-6 page"):
            with ui.column().classes("side"):
                self._slider("vacuum")
                self._slider("speed")
                self.of_pull = self._slider("travel")
                self.of_saw = self._slider("damping")
                choice(self.desk, self.name, MODEL)
                self.problem_line()
                with ui.column() as self.pulled_figures:
                    self.pulled = Figures(self.name, PULLED)
                with ui.column() as self.saw_figures:
                    self.saw = Figures("pull-saw", SAW)
                self.measured = Measured(self.uploads, self.refresh)
                self.of_files = self._slider("files_vacuum")
            with ui.column().classes("main gap-2"):
                self.waiting = Waiting(self.name, self.runner)
                self.chart = ui.echart({}).classes("chart").props(
                    'data-testid="pull-chart" role="img" aria-label="Force over elongation"'
                )  # fmt: skip
                self._take_away()
                self.errors = Errors()
                self.notes = Notes()

    def _slider(self, key: str) -> ui.column:
        with ui.column().classes("w-full gap-0") as box:
            slider(self.desk, self.name, self.controls()[key], lambda: self.controls()[key])
        return box

    def _take_away(self) -> None:
        with ui.row().classes("items-center gap-2"):
            ui.label("Take away").classes("text-sm")
            for ending in takeaway.ENDINGS:
                ui.button(f"figure as {ending.upper()}",
                          on_click=lambda ending=ending: self.take("figure", ending)).props(
                    f'outline dense no-caps data-testid="pull-figure-{ending}"')  # fmt: skip
            ui.button("record as CSV", on_click=lambda: self.take("record", "csv")).props(
                'outline dense no-caps data-testid="pull-record"'
            )
            self.compared = ui.button(
                "comparison as SVG", on_click=lambda: self.take("comparison", "svg")
            ).props('outline dense no-caps data-testid="pull-comparison"')
            self.compared.set_visibility(False)

    def model(self) -> str:
        """lumped, stack or judder."""
        return word(self.desk, self.name, MODEL)

    def text(self, key: str) -> str:
        """A control's value as a verb takes it."""
        control = self.controls()[key]
        return control.text(number(self.desk, self.name, control))

    def pull_call(self) -> Call:
        """The pull that is drawn."""
        said: dict[str, str | float | bool] = {k: self.text(k) for k in ("vacuum", "speed")}
        if self.model() == "judder":
            if number(self.desk, self.name, self.controls()["damping"]):
                said["damping"] = self.text("damping")
            return Call("stick_slip", (self.desk.brake_subject(),), said)
        said["travel"] = self.text("travel")
        if self.model() != "lumped":
            said["model"] = self.model()
        return Call("tensile", (self.desk.brake_subject(),), said)

    def calls(self) -> Sequence[Call]:
        """The pull, and what the measured files were asked."""
        return [self.pull_call(), *self._read[1].calls]

    def compute(self) -> Any:
        """The pull, the brake's greatest force for the axis, and the measured files."""
        call = self.pull_call()
        more = {} if call.verb == "stick_slip" else {"progress": self.waiting.tell}
        answer = call.run(**more)
        if self._whole[0] != self.desk.state.brake:
            whole = Call("show", (self.desk.brake_subject(),)).run()
            self._whole = (self.desk.state.brake, whole)
        return answer, self._whole[1], self._files()

    def _files(self) -> Reading:
        """The files as they were read, or anew where files, brake or their vacuum changed."""
        vacuum = self.text("files_vacuum")
        known, reading = self._read
        files, sidecars = laid_out(self.uploads), tuple(self.uploads.sidecars.items())
        key = (files, sidecars, self.desk.state.brake, vacuum if reading.lacking else "")
        if known != key:
            reading = read(files, self.desk.brake_subject(), vacuum, self.waiting.tell)
            self._read = ((*key[:3], vacuum if reading.lacking else ""), reading)
        return reading

    def draw(self, result: Any) -> None:
        """Curve and numbers."""
        answer, whole, reading = result
        judders = "events" in answer.values
        self.of_pull.set_visibility(not judders)
        self.pulled_figures.set_visibility(not judders)
        self.of_saw.set_visibility(judders)
        self.saw_figures.set_visibility(judders)
        self.of_files.set_visibility(reading.lacking)
        self.compared.set_visibility(bool(reading.curves) and not judders)
        self.errors.box.set_visibility(not judders)
        made = (
            saw(answer, whole, self.dark) if judders else pulled(answer, whole, reading, self.dark)
        )
        live.draw(self.chart, made)
        (self.saw if judders else self.pulled).fill(answer)
        self.measured.fill(reading)
        self.errors.fill(reading)
        self.notes.fill(answer.warnings)

    async def take(self, what: str, ending: str) -> None:
        """Download a figure or the record of what is shown now."""
        if self.result is None:
            ui.notify("nothing is computed yet")
            return
        answer, _, reading = self.result
        try:
            content = await elsewhere(_file, what, ending, answer, reading)
        except LayerjamError as err:
            ui.notify(" ".join(str(err).split()), type="warning")
            return
        if content is None:  # the program is being ended
            return
        verb = "validate" if what == "comparison" else self.pull_call().verb
        ui.download.content(content, f"{self.desk.brake.name}-{verb}.{ending}")


def _file(what: str, ending: str, answer: Answer, reading: Reading) -> bytes:
    """The bytes that the command writes for the same question."""
    from layerjam.report import figures, stick_slip_figures

    if what == "record":
        return takeaway.record_bytes(answer.record, ending)
    if what == "comparison" and reading.compared is not None:
        file, result = reading.compared.record
        synthetic = any("synthetic" in w for w in reading.compared.warnings)
        return takeaway.figure_bytes(figures.validation(file, result, synthetic), ending)
    draw = stick_slip_figures.stick_slip if "events" in answer.values else figures.tensile
    return takeaway.figure_bytes(draw(answer.record), ending)
