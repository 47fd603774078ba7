"""Pull: force against elongation over vacuum, speed and model, with measured pulls over it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from nicegui import run, ui

from layerjam.errors import LayerjamError
from layerjam.report.style import BLUE, GREY
from layerjam.units import show
from layerjam.workbench import live, takeaway
from layerjam.workbench.call import Call
from layerjam.workbench.controls import Choice, Control, asked, by_key, choice, vacuum_asked
from layerjam.workbench.desk import Desk
from layerjam.workbench.heroes import Hero, Heroes
from layerjam.workbench.more import More
from layerjam.workbench.outcomes import of_pull, of_slide
from layerjam.workbench.page import Box, Figures, Notes, Page
from layerjam.workbench.pages import pull_band, pull_pins
from layerjam.workbench.pages.pull_chart import pulled, saw
from layerjam.workbench.pages.pull_files import Measured, Reading, laid_out, read, show_errors
from layerjam.workbench.pages.pull_sheets import SheetBySheet
from layerjam.workbench.peak import PeakSetting
from layerjam.workbench.pins import BAND, Pins
from layerjam.workbench.runner import waiting_line
from layerjam.workbench.widgets import button, chart, columns, fold, one_line, status

if TYPE_CHECKING:
    from layerjam.report.style import Figure

STICK_SLIP = "judder"
"""The word in links; they outlive names."""
MODEL = Choice(
    "model",
    {"lumped": "lumped", "stack": "sheet by sheet", STICK_SLIP: "stick–slip"},
    "lumped",
    help="One friction for all sheets; every sheet a spring and every interface a friction; or a "
    "mass on a spring that sticks and slips, over time",
)
PULLED = ("force_at_end", "work")
PIN_BAND = "Pin with its band"
SAW = (
    "force_high",
    "force_low",
    "slip_per_event",
    "events",
    "critical_speed",
    "stiffness_needed",
)


class Pull(Page):
    """Drag the vacuum and watch the force curve rise."""

    name, title = "pull", "Pull"
    about = "The force it takes to pull the brake apart"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.uploads = desk.files
        self.more_of_pull = More(self, "tensile", ("vacuum", "speed", "travel", "model"))
        self.more_of_saw = More(self, STICK_SLIP, ("vacuum", "speed", "damping"))
        self._read: tuple[object, Reading] = (None, Reading())
        self._whole: tuple[object, Any] = (None, None)
        self.pins = Pins(desk, self.name, self.pull_call)
        self.pins.besides = pull_band.of_pin
        self.peak = PeakSetting(desk, self.name, self.pull_call, self._full)

    def controls(self) -> Mapping[str, Control]:
        """Bounds that the brake sets."""
        brake = self.desk.brake.brake
        more = self.more_of_saw if self._saws() else self.more_of_pull
        full, usable = more.atmosphere(brake.site.atmosphere), brake.sheets.usable_travel
        vacuum = vacuum_asked("tensile", "vacuum", full)
        lacking = "Vacuum of files that do not say it"
        return by_key(
            vacuum,
            asked("tensile", "speed", 0.001, (1e-4, 0.05)),
            asked("tensile", "travel", min(0.04, usable), (0.001, usable), label="Elongation"),
            asked(STICK_SLIP, "damping", 0.0, (0.0, 100.0)),
            replace(vacuum, key="files_vacuum", label=lacking),
        )

    def build(self) -> None:
        """Controls left, curve right."""
        side, main = columns()
        with side:
            self.slider("vacuum")
            self.slider("speed")
            self.slider("travel", lambda: not self._saws())
            self.slider("damping", self._saws)
            choice(self.desk, self.name, MODEL)
            self.problem_line()
            with self.while_(lambda: not self._saws()):
                self.more_of_pull.build()
            with self.while_(self._saws):
                self.more_of_saw.build()
            self.measured = Measured(self.desk)
            self.of_files = self.slider("files_vacuum")
        with main:
            waiting_line(self.name, self.runner)
            self.heroes = Heroes(self.name)
            with ui.row().classes("w-full items-center gap-x-6 gap-y-1"):
                self.outcome = status("pull-outcome")
                self.pins.build()
                self.pin_band = button(PIN_BAND, self._pin_with_band, "pull-pin-band", "push_pin")
                self.pin_band.set_visibility(False)
                self.pin_files = pull_pins.PinFiles(self.desk, self.pins)
            with self.while_(lambda: not self._saws()):
                self.peak.build()
            self.chart = chart("pull-chart", "Force over elongation")
            self.by_sheet = SheetBySheet(self.chart)
            self.peak.on(self.chart)
            with takeaway.row(self.name, self.chart, self.taken):
                button("record as CSV", self._record, "pull-record", how=takeaway.QUIET)
                compare = self._comparison
                self.compared = button("comparison as SVG", compare, "pull-comparison")
                self.compared.set_visibility(False)
            self.errors = Box(show_errors, "w-full gap-1 overflow-auto")
            with fold("More numbers", "pull-numbers"):
                with self.while_(lambda: not self._saws()):
                    self.pulled = Figures(self.name, "tensile", PULLED)
                with self.while_(self._saws):
                    self.saw = Figures("pull-saw", STICK_SLIP, SAW)
            self.notes = Notes()

    def _full(self) -> float:
        """The greatest vacuum of the site [Pa]."""
        return self.controls()["vacuum"].high

    def _saws(self) -> bool:
        """Whether the pull sticks and slips."""
        return self.word(MODEL) == STICK_SLIP

    def pull_call(self) -> Call:
        """The pull that is drawn."""
        subjects = (self.desk.brake_subject(),)
        said = self.texts("vacuum", "speed")
        if self._saws():
            if self.value("damping"):
                said["damping"] = self.text("damping")
            return Call(STICK_SLIP, subjects, {**said, **self.more_of_saw.options()})
        said["travel"] = self.text("travel")
        if self.word(MODEL) != "lumped":
            said["model"] = self.word(MODEL)
        return Call("tensile", subjects, {**said, **self.more_of_pull.options()})

    def calls(self) -> Sequence[Call]:
        """The pull, and what the measured files were asked."""
        return [self.pull_call(), *self._read[1].calls]

    def compute(self) -> Any:
        """The pull, the brake's greatest force for the axis, and the measured files."""
        call = self.pull_call()
        more = {} if call.name == STICK_SLIP else {"progress": self.runner.tell}
        result = call.run(**more)
        if self._whole[0] != self.desk.state.brake:
            whole = Call("show", (self.desk.brake_subject(),)).run()
            self._whole = (self.desk.state.brake, whole)
        self.pins.compute(call)
        return call, result, self._whole[1], self._files(), self._band(call, result)

    def _band(self, call: Call, result: Any) -> pull_band.Band | None:
        """The 95 % of the pull that is shown, where they are known."""
        error = pull_band.known(self.desk, call)
        return None if error is None else pull_band.band(error, result.record, call)

    def _pin_with_band(self) -> None:
        error = pull_band.known(self.desk, self.pull_call())
        if error is not None:
            self.pins.pin(**{BAND: error.text()})

    def pinned(self) -> Mapping[str, Call]:
        """The calls behind the pinned curves."""
        files = {label: call for label, (call, _) in self._pinned_files().items()}
        return {**files, **self.pins.calls}

    def _pinned_files(self) -> dict[str, tuple[Call, Any]]:
        """The measured curves that are pinned and drawn, as calls with their results."""
        return {} if self._saws() else pull_pins.beside(self.desk, self._read[1])

    def _files(self) -> Reading:
        """The files as they were read, or anew where files, brake or their vacuum changed."""
        vacuum, files = self.text("files_vacuum"), laid_out(self.desk)
        known, reading = self._read
        sidecars = tuple(self.uploads.sidecars)
        key = (files, sidecars, self.desk.state.brake, vacuum if reading.lacking else "")
        if known != key:
            reading = read(files, self.desk.brake_subject(), vacuum, self.runner.tell)
            self._read = ((*key[:3], vacuum if reading.lacking else ""), reading)
        return reading

    def draw(self, result: Any) -> None:
        """Curve and numbers."""
        call, found, whole, reading, band = result
        saws = call.name == STICK_SLIP
        pinned = self.pins.drawn
        drawn = Reading() if saws else reading
        self.pin_files.fill(drawn)
        self.pin_band.set_visibility(band is not None)
        files = pull_pins.labels(self.desk, drawn)
        self.pins.fill(files)
        self.of_files.set_visibility(reading.lacking)
        self.compared.set_visibility(bool(reading.curves) and not saws)
        self.errors.set_visibility(not saws)
        if saws:
            live.draw(self.chart, saw(found, whole, self.dark, pinned))
        else:
            bands = {one.label: one.beside for one in self.pins.shown if one.beside}
            bands |= {"": band} if band else {}
            made = pulled(found, whole, reading, self.dark, pinned, files, bands)
            live.draw(self.chart, made)
            self.peak.fill(found.peak_force)
        (self.saw if saws else self.pulled).fill(found)
        self.by_sheet.fill(None if saws else found.motion, self.desk.brake.brake.sheets)
        self.heroes.fill(heroes(found))
        self.outcome.set_text(of_slide(found) if saws else of_pull(found))
        self.measured.fill(reading)
        self.errors.fill(reading)
        self.notes.fill(found.warnings)

    def taken(self) -> takeaway.Taken | None:
        """What the chart shows now."""
        if self.result is None:
            return None
        call, found, *_ = self.result
        name = f"{self.desk.brake.name}-{call.name}"
        beside = {**self._pinned_files(), **self.pins.beside}
        return takeaway.Taken(found, name, call, beside, self._shading())

    def _shading(self) -> Callable[[Figure], None] | None:
        """What draws the bands of the chart into its figure; None where there are none."""
        call, found, _, _, band = self.result
        own = [(band, found.record, BLUE)] if band else []
        kept = [(one.beside, one.result.record, GREY) for one in self.pins.shown if one.beside]
        shown = [] if call.name == STICK_SLIP else [*kept, *own]
        return partial(pull_band.shade, bands=shown) if shown else None

    async def _record(self) -> None:
        if self.result is not None:
            call, found, *_ = self.result
            await self._give(found, "csv", call.name)

    async def _comparison(self) -> None:
        if self.result is not None and self.result[3].compared:
            await self._give(self.result[3].compared, "svg", "validate")

    async def _give(self, shown: Any, ending: str, name: str) -> None:
        try:
            content = await run.io_bound(takeaway.file_bytes, shown, ending)
        except LayerjamError as err:
            ui.notify(one_line(err), type="warning")
            return
        if content is not None:  # None: the program is being ended
            ui.download.content(content, f"{self.desk.brake.name}-{name}.{ending}")


def heroes(found: Any) -> list[Hero]:
    """What a pull is looked at for: its peak and heat, or how it sticks and slips."""
    if found.command == STICK_SLIP or not hasattr(found, "peak_force"):
        swing = "–" if found.amplitude is None else f"± {show(found.amplitude, 'N')}"
        period = "–" if found.period is None else show(found.period, "s")
        fast = "–" if found.critical_speed is None else show(found.critical_speed, "m/s")
        return [
            ("amplitude", "Amplitude", swing),
            ("period", "Period", period),
            ("critical_speed", "Critical speed", fast),
        ]
    return [
        ("peak_force", "Peak force", show(found.peak_force, "N")),
        ("peak_elongation", "At an elongation of", show(found.peak_elongation, "m")),
        ("dissipated_energy", "Turned into heat", show(found.dissipated_energy, "J")),
    ]
