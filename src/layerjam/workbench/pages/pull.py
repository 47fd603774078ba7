"""Pull: force versus elongation at a vacuum and a speed, with measured pulls for comparison."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import events, ui

from layerjam.brake.device.sheets import Sheets
from layerjam.brake.simulate.sheet_motion import SheetMotion
from layerjam.core.units import show
from layerjam.workbench import live, takeaway
from layerjam.workbench.answer import Answer, file_bytes
from layerjam.workbench.call import Call
from layerjam.workbench.controls import (
    Choice,
    Control,
    add_choice,
    control,
    map_keys,
    vacuum_control,
)
from layerjam.workbench.desk import Desk
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.outcomes import describe_pull, describe_stick_slip
from layerjam.workbench.page import Box, Figures, Notes, Page
from layerjam.workbench.pages import pull_band
from layerjam.workbench.pages.pull_chart import pull_chart, stick_slip_chart
from layerjam.workbench.pages.pull_files import (
    MeasuredFiles,
    PinFiles,
    Reading,
    collect_pinned_files,
    find_pulls,
    read_pulls,
    show_errors,
)
from layerjam.workbench.panel import Panel
from layerjam.workbench.peak import PeakSetting
from layerjam.workbench.pins import BAND
from layerjam.workbench.sheets_drawing import (
    PullView,
    describe_scale,
    draw_stack,
    legend_symbol,
    slip_sentence,
)
from layerjam.workbench.widgets import (
    Hero,
    Heroes,
    button,
    columns,
    dress,
    fold,
    heading,
    hint,
    predicted_hero,
    status,
)

if TYPE_CHECKING:
    from layerjam.brake.simulate.pull_spread import PullBand

STEPS = 400
"""Number of steps of the slider that moves along the pull."""
MM = 1e3
LEGEND = (("holds", "sticks on both sides"), ("slides", "slides on an adjacent sheet"))


class SheetBySheet(ui.column):
    """A side view of the stack at one elongation of the pull in the chart above."""

    def __init__(self, chart: ui.echart) -> None:
        super().__init__()
        self.classes("by-sheet w-full gap-1")
        self.chart, self.at = chart, 0
        self.seen: PullView | None = None
        self._motion: SheetMotion | None = None
        self._tied = False
        with self:
            heading("Sheet by sheet")
            hint("Point at the curve, or move along the pull with the slider or the arrow keys.")
            bar = live.Bar(min=0, max=STEPS, step=1, value=0)
            self.bar = dress(bar, "pull-along", look="dense", aria_label="Position along the pull")
            self.words = status("pull-sheets-said")
            self.drawn = dress(live.Table(), "pull-sheets", "w-full")
            with ui.row().classes("items-center gap-x-5 gap-y-1"):
                for kind, text in LEGEND:
                    with ui.row().classes("items-center gap-2 no-wrap"):
                        ui.html(legend_symbol(kind), sanitize=False).props("aria-hidden=true")
                        ui.label(text).classes("text-sm")
                self.scale = dress(live.Words(""), "pull-sheets-scale", "text-sm")
        # use the event's own value, because the server's value of the slider lags behind the
        # pointer
        self.bar.on("update:model-value", self._on_slider, throttle=0.05)
        self.bar.on("pointed", self._on_point)
        self.bar.on("blur", js_handler=f"() => layerjamUnmark({chart.id})")

    def fill(self, motion: SheetMotion | None, sheets: Sheets) -> None:
        """Show a new pull at the previous position; hide the view if there is no sheet motion."""
        self.set_visibility(motion is not None)
        if motion is None or motion is self._motion:
            return
        before, self._motion, self.seen = self.seen, motion, PullView.from_motion(motion, sheets)
        if before is None:
            index = self.seen.informative_sample()
        else:
            old = before.motion
            index = self.seen.nearest_sample(
                float(old.elongation[self.at]), float(old.force[self.at])
            )
        self._show_sample(index)
        if not self._tied:
            self._tied = True
            self.client.run_javascript(f"layerjamPointing({self.chart.id}, {self.bar.id})")

    def _show_sample(self, index: int) -> None:
        """Show a sample; the slider follows without an event to the server."""
        if self.seen is None:
            return
        self.at = index
        self.words.set_text(slip_sentence(self.seen, index))
        self.scale.set_text(describe_scale(self.seen, index))
        self.drawn.set_content(draw_stack(self.seen, index))
        place = round(STEPS * index / max(len(self.seen.motion.force) - 1, 1))
        self.client.run_javascript(f"layerjamAlong({self.bar.id}, {place})")

    def _on_point(self, event: events.GenericEventArguments) -> None:
        if self.seen is not None and (point := _parse_point(event.args)):
            index = self.seen.nearest_sample(point[0] / MM, point[1])
            if index != self.at:
                self._show_sample(index)

    def _on_slider(self, event: events.GenericEventArguments) -> None:
        """Show the sample at the slider's position, and move the chart's cursor there."""
        if self.seen is None or not isinstance(event.args, int | float):
            return
        motion = self.seen.motion
        index = round(event.args / STEPS * (len(motion.force) - 1))
        self._show_sample(min(max(index, 0), len(motion.force) - 1))
        x, y = float(motion.elongation[self.at]) * MM, float(motion.force[self.at])
        self.client.run_javascript(f"layerjamMark({self.chart.id}, {x!r}, {y!r})")


def _parse_point(args: Any) -> tuple[float, float] | None:
    """Return two numbers from the browser; None for anything else."""
    pair = args if isinstance(args, list) else [args]
    pair = pair[0] if len(pair) == 1 and isinstance(pair[0], list) else pair
    if len(pair) == 2 and all(isinstance(v, int | float) for v in pair):
        return float(pair[0]), float(pair[1])
    return None


STICK_SLIP = "judder"
"""Stored value of the stick–slip model; old links contain it."""
MODEL = Choice(
    "model",
    {"lumped": "lumped", "stack": "sheet by sheet", STICK_SLIP: "stick–slip"},
    "lumped",
    help="One friction force for all sheets, a spring for each sheet with friction at each "
    "interface, or a mass on a spring that sticks and slips",
)
PULLED = ("force_at_end", "work")
PIN_BAND = "Pin with uncertainty band"
SAW = (
    "force_high",
    "force_low",
    "slip_per_event",
    "events",
    "critical_speed",
    "stiffness_needed",
)


class Pull(Page):
    """Page to change the vacuum and watch the force curve follow."""

    name, title = "pull", "Pull"
    summary = "Force needed to pull the brake apart"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.uploads = desk.files
        self.more_of_pull = OtherInputs(self, "tensile", ("vacuum", "speed", "elongation", "model"))
        self.more_of_saw = OtherInputs(self, STICK_SLIP, ("vacuum", "speed", "damping"))
        self._read: tuple[object, Reading] = (None, Reading())
        self._whole: tuple[object, Any] = (None, None)
        self.panel = Panel(desk, self.name)
        self.panel.compute_extra = pull_band.compute_pinned_band
        self.peak = PeakSetting(desk, self.name, lambda: self.calls()[0], self._full_vacuum)

    def controls(self) -> Mapping[str, Control]:
        """Return the controls, with the bounds that the brake sets."""
        brake = self.desk.brake.brake
        inputs = self.more_of_saw if self._is_stick_slip() else self.more_of_pull
        full_vacuum, usable = inputs.atmosphere(brake.site.atmosphere), brake.sheets.usable_travel
        vacuum = vacuum_control("tensile", "vacuum", full_vacuum)
        lacking = "Vacuum for files that do not state one"
        return map_keys(
            vacuum,
            control("tensile", "speed", 0.001, (1e-4, 0.05)),
            control("tensile", "elongation", min(0.04, usable), (0.001, usable), key="travel"),
            control(STICK_SLIP, "damping", 0.0, (0.0, 100.0)),
            replace(vacuum, key="files_vacuum", label=lacking),
        )

    def build(self) -> None:
        """Build controls on the left and the curve on the right."""
        side, main = columns()
        with side:
            self.add_slider("vacuum")
            self.add_slider("speed")
            self.add_slider("travel", lambda: not self._is_stick_slip())
            self.add_slider("damping", self._is_stick_slip)
            add_choice(self.desk, self.name, MODEL)
            self.add_alert()
            with self.show_while(lambda: not self._is_stick_slip()):
                self.more_of_pull.build()
            with self.show_while(self._is_stick_slip):
                self.more_of_saw.build()
            self.measured = MeasuredFiles(self.desk)
            self.of_files = self.add_slider("files_vacuum")
        with main:
            self.heroes = Heroes(self.name)
            with ui.row().classes("w-full items-center gap-x-6 gap-y-1"):
                self.outcome = status("pull-outcome")
                self.panel.build_pins()
                act = partial(self.panel.pin_answer, **{BAND: pull_band.NAME})
                self.pin_band = button(PIN_BAND, act, "pull-pin-band", "push_pin")
                self.pin_band.set_visibility(False)
                self.pin_files = PinFiles(self.desk, self.panel)
            with self.show_while(lambda: not self._is_stick_slip()):
                self.peak.build()
            self.panel.build("pull-chart", "Force versus elongation")
            self.by_sheet = SheetBySheet(self.panel.chart)
            self.peak.attach_chart(self.panel.chart)
            with self.panel.build_exports():
                record = partial(self._download_result, f"tensile {STICK_SLIP}", "csv")
                button("record as CSV", record, "pull-record", look=takeaway.QUIET)
                compare = partial(self._download_result, "validate", "svg")
                self.compared = button("comparison as SVG", compare, "pull-comparison")
                self.compared.set_visibility(False)
            self.errors = Box(show_errors, "w-full gap-1 overflow-auto")
            with fold("More numbers", "pull-numbers"):
                with self.show_while(lambda: not self._is_stick_slip()):
                    self.pulled = Figures(self.name, "tensile", PULLED)
                with self.show_while(self._is_stick_slip):
                    self.saw = Figures("pull-saw", STICK_SLIP, SAW)
            self.notes = Notes()

    def _full_vacuum(self) -> float:
        return self.controls()["vacuum"].high

    def _is_stick_slip(self) -> bool:
        return self.word(MODEL) == STICK_SLIP

    def calls(self) -> Sequence[Call]:
        """Return the call for the pull."""
        subjects = (self.desk.brake_subject(),)
        inputs = self.texts("vacuum", "speed")
        if self._is_stick_slip():
            if self.value("damping"):
                inputs["damping"] = self.text("damping")
            return [Call(STICK_SLIP, subjects, {**inputs, **self.more_of_saw.options()})]
        inputs["elongation"] = self.text("travel")
        if self.word(MODEL) != "lumped":
            inputs["model"] = self.word(MODEL)
        return [Call("tensile", subjects, {**inputs, **self.more_of_pull.options()})]

    def answers(self) -> Sequence[Answer]:
        """Return the answers for the pull and for the measured files."""
        return [] if self.result is None else [self.result[0], *self.result[2].answers]

    def compute(self) -> Any:
        """Return the pull, the brake's properties (for the axis limit), the files, and the band."""
        (call,) = self.calls()
        saws = call.name == STICK_SLIP
        result = call.run(**({} if saws else {"progress": self.runner.report_progress}))
        if self._whole[0] != call.subjects[0].text:
            self._whole = (call.subjects[0].text, Call("show", call.subjects).run())
        pins, reading = self.panel.pinned_answers(call), self._read_files()
        band = pull_band.compute_band(call, result.record)
        if not saws:
            pins = (*collect_pinned_files(self.desk, reading), *pins)
        bands = [pin.more for pin in pins if pin.more]
        shade = partial(pull_band.draw_bands, bands=bands) if bands else None
        return Answer(call, result, pins=pins, finish=shade), self._whole[1], reading, band

    def _read_files(self) -> Reading:
        """Return the results of the files, computed again if files, brake or vacuum changed."""
        vacuum, files = self.text("files_vacuum"), find_pulls(self.desk)
        last_key, reading = self._read
        sidecars = tuple(self.uploads.sidecars)
        key = (files, sidecars, self.desk.state.brake, vacuum if reading.lacks_vacuum else "")
        if last_key != key:
            reading = read_pulls(
                files, self.desk.brake_subject(), vacuum, self.runner.report_progress
            )
            self._read = ((*key[:3], vacuum if reading.lacks_vacuum else ""), reading)
        return reading

    def draw(self, result: Any) -> None:
        """Draw the curve, and show numbers and notes."""
        answer, brake_facts, reading, band = result
        pull, saws = answer.result, answer.call.name == STICK_SLIP
        self.pin_files.fill(Reading() if saws else reading)
        self.pin_band.set_visibility(band is not None)
        self.of_files.set_visibility(reading.lacks_vacuum)
        self.compared.set_visibility(bool(reading.curves) and not saws)
        self.errors.set_visibility(not saws)
        self.panel.draw(answer, make_chart(answer, brake_facts, reading, band, self.dark))
        if not saws:
            self.peak.fill(pull.peak_force)
        (self.saw if saws else self.pulled).fill(pull)
        self.by_sheet.fill(None if saws else pull.motion, pull.record.brake.brake.sheets)
        self.heroes.fill(headlines(pull), pull)
        self.outcome.set_text(describe_stick_slip(pull) if saws else describe_pull(pull))
        self.measured.fill(reading)
        self.errors.fill(reading)
        self.notes.fill(pull.warnings)

    async def _download_result(self, command: str, ending: str) -> None:
        for answer in self.answers():
            if answer.call.name in command.split() and answer.result is not None:
                make = partial(file_bytes, answer.result, ending)
                await takeaway.save_result(make, f"{answer.name}.{ending}")


def make_chart(
    answer: Answer, brake_facts: Any, reading: Reading, band: "PullBand | None", dark: bool
) -> dict[str, Any]:
    """Return the chart of a pull, with or without stick–slip, and of its pinned curves."""
    name, pins = answer.call.name, answer.pins
    pins_shown = {pin.label: pin.answer.result for pin in pins if pin.answer.call.name == name}
    if name == STICK_SLIP:
        return stick_slip_chart(answer.result, brake_facts, dark, pins_shown)
    files = [pin.pin.subject for pin in pins if pin.pin and pin.answer.call.files]
    bands = {pin.label: pin.more for pin in pins if pin.more} | ({"": band} if band else {})
    return pull_chart(answer.result, brake_facts, reading, dark, pins_shown, files, bands)


def headlines(result: Any) -> list[Hero]:
    """Return the headline numbers of a pull: peak and heat, or those of stick–slip."""
    if result.command == STICK_SLIP or not hasattr(result, "peak_force"):
        swing = "–" if result.amplitude is None else f"± {show(result.amplitude, 'N')}"
        period = "–" if result.period is None else show(result.period, "s")
        speed_text = "–" if result.critical_speed is None else show(result.critical_speed, "m/s")
        return [
            Hero("amplitude", "Amplitude", swing),
            Hero("period", "Period", period),
            Hero("critical_speed", "Critical speed", speed_text),
        ]
    names = {
        "peak_force": "Peak force",
        "peak_elongation": "At an elongation of",
        "dissipated_energy": "Dissipated as heat",
    }
    return [predicted_hero(key, name, result, key) for key, name in names.items()]
