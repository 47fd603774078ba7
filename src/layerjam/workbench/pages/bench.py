"""Bench: connect a real or a virtual board, hold a vacuum, run procedures and record them."""

import asyncio
import math
import shutil
import tempfile
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from nicegui import run, ui

from layerjam.bench.control.faults import PROVOKED
from layerjam.bench.figures.control_figures import bench_panes
from layerjam.bench.rig.driver import VENT_RESTS
from layerjam.bench.rig.execute import RunResult
from layerjam.bench.rig.export import export
from layerjam.brake.fluid.line_file import lines
from layerjam.core.errors import LayerjamError, are_text, count_text
from layerjam.core.units import show
from layerjam.workbench import live, takeaway
from layerjam.workbench.bench_session import (
    LEASE,
    BenchRecord,
    BenchState,
    Presence,
    Session,
    bench_regulator,
    hold_target,
    inject_fault,
)
from layerjam.workbench.charts import chart_options
from layerjam.workbench.controls import Choice, Control, add_choice, add_menu, control, map_keys
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Page
from layerjam.workbench.pages.vacuum import law_choice, safe_choice
from layerjam.workbench.widgets import (
    QUIET,
    Alert,
    button,
    chart,
    columns,
    dress,
    field,
    fold,
    hint,
    one_line,
    read_asset,
    status,
)

DRAWN, WINDOW = 0.2, 60.0
"""Interval between chart updates [s], and displayed time span [s]."""
BEAT = 250
"""Interval between the browser's reports that the page is open [ms]."""
KPA = 1e3
PROCEDURE = "evacuate to 40 kPa and hold 5 s; vent"
STATES: Mapping[str, str] = {
    "SAFE": "Safe state; nothing is running",
    "RUN": "The controller is running",
    "FAULT": "Fault; the bench is in its safe state",
    "DRIVE": "Outputs under manual control",
}
SIMULATED = (
    "A virtual board: the firmware is real, and the vacuum line is simulated. Nothing is measured."
)
NO_SAFE_STATE = "Choose the safe state after a fault: release or hold"
NO_VENT_REST = "Choose the position of the unpowered vent valve: open or closed"
NOT_YET = "Not connected. Connect the virtual board, or enter the address of your own board."
STEPS = (
    "Connect. The virtual board needs no hardware; your own board has an address such as "
    "serial:/dev/ttyACM0.",
    "Choose the safe state after a fault and the position of the unpowered vent valve.",
    "Hold a target and watch the vacuum follow, or run a procedure and save its recording.",
)
"""Instructions displayed before the first reading."""
WIRING = (
    "Wiring: the computer controls a board by USB. The board switches the pump and the vent "
    "valve and reads the pressure sensor. Air flows from the brake past the sensor and the valve "
    "to the pump. The emergency stop disconnects the pump and the valve from the 12 V supply."
)
GONE = (
    f"Keep this page open and in view: {LEASE:g} s after you close it, the bench goes to "
    "its safe state."
)


def rest_choice() -> Choice:
    """Return the choice of the unpowered vent valve's position; it has no default."""
    words = {"": "not chosen", **{state: state for state in VENT_RESTS}}
    meaning = "Position of the vent valve when unpowered. A board cannot move it during a reset."
    return Choice("vent_rest", words, "", label="Unpowered vent", help=meaning)


class Bench(Page):
    """Page that connects and controls one bench."""

    name, title = "bench", "Bench"
    summary = "A real or virtual board that holds the vacuum"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.law, self.safe, self.rest = law_choice(), safe_choice(), rest_choice()
        words = {name: f"{name.replace('-', ' ')}: {text}" for name, text in PROVOKED.items()}
        self.broken = Choice("broken", {"none": "none", **words}, "none", label="Fault")
        self.present = Presence()
        self.session: Session | None = None
        self.folder: Path | None = None
        self.done: RunResult | None = None
        self._drawn: Any = None
        self.taken: BenchRecord | None = None
        self.required: list[tuple[Choice, str, Alert]] = []
        """(choice, request, line that shows the request) of each choice without a default."""

    def controls(self) -> Mapping[str, Control]:
        """Return the controls for the target and the sensor."""
        full_vacuum = self.desk.line.line.site.atmosphere
        target = control(
            "rise", "target", min(40e3, 0.6 * full_vacuum), (0.01 * full_vacuum, 0.99 * full_vacuum)
        )
        return map_keys(
            target.narrow_bounds(high=full_vacuum),
            control("regulate", "sensor_range", 103e3, (10e3, 200e3)),
        )

    def build(self) -> None:
        """Build the connection and the target on the left, the readings on the right."""
        side, main = columns()
        with side:
            self._build_connection()
            for item, words in ((self.safe, NO_SAFE_STATE), (self.rest, NO_VENT_REST)):
                add_choice(self.desk, self.name, item)
                self.required.append((item, words, Alert(f"bench-{item.key}-problem", "text-sm")))
            add_choice(self.desk, self.name, self.law)
            self.add_slider("target")
            with ui.row().classes("gap-2"):
                button("Hold the target", self._hold_target, "bench-on", "play_arrow")
                props = "dense no-caps color=negative padding='4px 10px'"
                button("Off", self._switch_off, "bench-off", "stop", look=props)
                button("Clear fault", self._clear_fault, "bench-clear")
            self.add_alert()
            with fold("Run a procedure and record it", "bench-procedure-fold", is_open=True):
                self.procedure = field("Procedure", "bench-procedure", PROCEDURE, example=PROCEDURE)
                with ui.row().classes("gap-2"):
                    act = self._run_procedure
                    button("Run and record", act, "bench-run", "fiber_manual_record")
                    button("Stop", self._stop_run, "bench-stop")
            with fold("Sensor of a real board", "bench-sensor"):
                hint("Required if the line file specifies no sensor. A virtual board has one.")
                self.add_slider("sensor_range")
            with ui.column().classes("w-full") as self.breaking, fold("Inject a fault"):
                add_menu(self.desk, self.name, self.broken)
        with main:
            self.banner = status("bench-simulated", "text-sm font-medium")
            with ui.row().classes("items-baseline gap-6"):
                self.number = status("bench-vacuum", "text-4xl font-medium tabular-nums")
                self.words = status("bench-state", "text-lg", NOT_YET)
            with ui.row().classes("w-full no-wrap beside items-start gap-6") as self.steps:
                self._build_first_steps()
            label = "Vacuum and target over the last minute"
            self.curve = chart("bench-chart", label, "width: 100%; height: max(280px, 42vh)")
            self.watched = takeaway.add_exports(self.name, self.curve, lambda: self.taken)
            self.facts = status("bench-facts", QUIET)
            self.outcome = status("bench-outcome", "text-base")
            with ui.row().classes("gap-2") as self.keep:
                button("Run file", partial(self._download_run, ".ljrun"), "bench-file", "download")
                button("CSV", partial(self._download_run, ".csv"), "bench-csv", "download")
            self.keep.set_visibility(False)
            hint(GONE)
        ui.on("layerjam_beat", lambda _: self.present.record_heartbeat())
        ui.run_javascript(f"setInterval(() => emitEvent('layerjam_beat'), {BEAT})")
        self.timer = ui.timer(DRAWN, self._draw_live)
        if self.client is not None:
            self.client.on_delete(self._release_bench)
        self._update_controls()

    def _build_first_steps(self) -> None:
        with ui.column().classes("gap-2 items-start").style("flex: 1"):
            with dress(ui.element("ol"), "bench-steps", "list-decimal pl-6"):
                for step in STEPS:
                    with dress(ui.element("li"), classes="py-1"):
                        ui.label(step)
            with ui.row().classes("gap-2"):
                text, look = "Connect the virtual board", "no-caps"
                button(text, self._connect_bench, "bench-first", "link", look=look)
                tip = "Wiring of a Raspberry Pi Pico with every part, as SVG"
                act = partial(takeaway.save_result, circuit_diagram, "wiring.svg", "image/svg+xml")
                button("Circuit diagram", act, "bench-circuit", "download", tip=tip)
        picture = ui.html(read_asset("pages/bench_wiring.html"), sanitize=False)
        dress(picture, "bench-wiring", "figure", role="img", aria_label=WIRING).style("flex: 1")

    def _build_connection(self) -> None:
        line = self.desk.state.line if self.desk.state.line in lines() else "choi2018"
        self.address = field(
            "Address", "bench-address", f"sim:{line}", example="serial:/dev/ttyACM0",
            tip="sim:LINE is a virtual board; serial:PORT a board; tcp:HOST:5025 a gateway",
        )  # fmt: skip
        with ui.row().classes("gap-2"):
            self.link = button("Connect", self._connect_bench, "bench-connect", "link")
            self.unlink = button(
                "Disconnect", self._disconnect_bench, "bench-disconnect", "link_off"
            )
        hint("sim:LINE is a virtual board with a line from the catalogue; it needs no hardware.")

    def _update_controls(self) -> None:
        is_connected = self.session is not None
        self.link.set_enabled(not is_connected)
        self.unlink.set_enabled(is_connected)
        self.address.set_enabled(not is_connected)
        virtual = self.session is not None and self.session.bench.plant is not None
        self.breaking.set_visibility(virtual)
        begun = is_connected or self.taken is not None
        self.steps.set_visibility(not begun)
        self.watched.set_visibility(begun)
        if not begun:
            self._draw_target()

    def _draw_target(self) -> None:
        ages, target = (-WINDOW, 0.0), self.value("target")
        panes = bench_panes(
            *(ages, (math.nan, math.nan), (target, target)),
            x_range=ages,
            x="time before now [s]",
        )
        live.draw_chart(self.curve, chart_options(panes, self.dark))

    def compute(self) -> Any:
        """Send the settings to the bench: the target while one is held, and the injected fault."""
        session = self.session
        if session is None or not session.looks or session.running is not None:
            return None
        if session.looks[-1].state == "RUN":
            session.request_action(partial(hold_target, **self._bench_settings())).result(10)
        if session.bench.plant is not None:
            settings = self._bench_settings(with_rest=False)
            session.request_action(
                partial(inject_fault, fault=self.word(self.broken), **settings)
            ).result(10)
        return None

    def _bench_settings(self, *, with_rest: bool = True) -> dict[str, Any]:
        target = self.value("target")
        safe_state = self.word(self.safe) or ("release" if not with_rest else "")
        regulator = bench_regulator(
            str(self.address.value), self.desk.line, target, safe_state, self.word(self.law),
            self.value("sensor_range"),
        )  # fmt: skip
        rest_option = {"rest": self.word(self.rest)} if with_rest else {}
        return {"regulator": regulator, "target": target, **rest_option}

    def draw(self, result: Any) -> None:
        """Draw the target before the first reading; the readings are drawn as they arrive."""
        for item, _, alert in self.required:
            if self.word(item):
                alert.show_error("")
        if self.session is None and self.taken is None:
            self._draw_target()

    async def _try_call(self, act: Callable[[], Any]) -> Any:
        """Run an action in a thread and return its result; if rejected, show the reason."""
        if self.problem is not None:
            self.problem.show_error("")
        try:
            result = await run.io_bound(act)
            return await asyncio.wrap_future(result) if isinstance(result, Future) else result
        except LayerjamError as error:
            if self.problem is not None:
                self.problem.show_error(one_line(error))
            return None

    async def _connect_bench(self) -> None:
        self.present.record_heartbeat()
        address, target = str(self.address.value).strip(), self.value("target")
        self.link.set_enabled(False)
        self.session = await self._try_call(partial(Session.connect, address, self.present, target))
        gone = self.client is None or self.client.is_deleted
        if self.session is not None and gone:
            self._release_bench()
        self._update_controls()

    def _disconnect_bench(self) -> None:
        if self.session is not None:
            self.session.close()
        self.session = None
        self._update_controls()

    def _release_bench(self) -> None:
        if self.session is not None:
            self.session.close()
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)

    async def _request_bench(self, act: Callable[[Any], Any]) -> Any:
        session = self.session
        if session is None:
            if self.problem is not None:
                self.problem.show_error("No board is connected")
            return None
        return await self._try_call(lambda: session.request_action(act))

    async def _connected_settings(self) -> dict[str, Any] | None:
        """Return the settings and connect the bench; if a setting is missing, request it."""
        for item, words, alert in self.required:
            alert.show_error("" if self.word(item) else words)
        if not all(self.word(item) for item, *_ in self.required):
            return None
        settings: dict[str, Any] | None = await self._try_call(self._bench_settings)
        if settings is not None and self.session is None:
            await self._connect_bench()
        return settings

    async def _hold_target(self) -> None:
        settings = await self._connected_settings()
        if settings is not None and self.session is not None:
            await self._request_bench(partial(hold_target, **settings))

    async def _switch_off(self) -> None:
        self._stop_run()
        await self._request_bench(lambda bench: bench.off())

    async def _clear_fault(self) -> None:
        await self._request_bench(lambda bench: bench.clear())

    def _stop_run(self) -> None:
        session = self.session
        if session is not None and session.running is not None:
            session.running.request_stop()

    async def _run_procedure(self) -> None:
        settings, session = await self._connected_settings(), self.session
        if session is None or settings is None:
            return
        if self.folder is None:
            self.folder = Path(tempfile.mkdtemp(prefix="layerjam-workbench-"))
        regulator, vent_rest = settings["regulator"], settings["rest"]

        def declare_settings(bench: Any) -> None:
            bench.off()
            bench.safe_state, bench.vent_rest = regulator.safe_state, vent_rest
            bench.regulator = regulator

        meta: dict[str, object] = {
            "line_toml": self.desk.line.text,
            "brake_toml": self.desk.brake.text,
        }
        out = self.folder / "run.ljrun"

        def start_recording() -> Future[RunResult]:
            session.request_action(declare_settings).result(10)
            return session.record_run(str(self.procedure.value), out, meta)

        self.outcome.set_text("Running …")
        self.done = await self._try_call(start_recording)
        self.outcome.set_text(_run_sentence(self.done) if self.done is not None else "")
        self.keep.set_visibility(self.done is not None)

    async def _download_run(self, ending: str) -> None:
        if self.done is None:
            return
        file = self.done.file
        if ending == ".ljrun":
            ui.download.content(file.read_bytes(), file.name, "application/vnd.sqlite3")
            return
        out = file.with_suffix(ending)
        if await self._try_call(partial(export, file, out, overwrite=True)) is not None:
            ui.download.content(out.read_bytes(), out.name, "text/csv")

    def _draw_live(self) -> None:
        session = self.session
        if session is None or self.desk.state.page != self.name:
            if session is None and self._drawn is not None:
                self._drawn = None
                self.words.set_text(NOT_YET)
                self.number.set_text("")
            return
        if session.lost:
            self.words.set_text(f"Connection lost: {session.lost}")
            self._disconnect_bench()
            return
        looks = list(session.looks)
        if not looks or looks[-1] is self._drawn:
            return
        self._drawn = looks[-1]
        self.banner.set_text(SIMULATED if session.bench.simulated else "")
        self._show_message(looks[-1])
        end = looks[-1].time
        window = [look for look in looks if look.time >= end - WINDOW]
        self.taken = BenchRecord(window, session.bench.simulated)
        ages = [look.time - end for look in window]
        series = {**self.taken.columns, "time": ages, "x": "time before now [s]"}
        panes = bench_panes(**series, x_range=(-WINDOW, 0))
        live.draw_chart(self.curve, chart_options(panes, self.dark))

    def _show_message(self, look: BenchState) -> None:
        vacuum = "no reading" if look.vacuum is None else f"{look.vacuum / KPA:.1f} kPa"
        self.number.set_text(vacuum)
        state = STATES.get(look.state, look.state)
        self.words.set_text(f"{state}: {look.fault}" if look.fault else state)
        vent = "open" if look.vent else "closed"
        self.facts.set_text(f"Target {show(look.target, 'Pa')}, pump {look.pump:.0%}, vent {vent}")


def circuit_diagram() -> str:
    """Return a Pico's wiring as SVG; raises MissingExtraError if schemdraw is not installed."""
    from layerjam.bench.figures.wiring_diagram import draw_wiring
    from layerjam.bench.rig.circuit import load_circuit

    return draw_wiring(load_circuit("pico"))


def _run_sentence(result: RunResult) -> str:
    gaps = f"{are_text(result.gaps, 'sample')} missing" if result.gaps else "no sample is missing"
    samples = count_text(result.samples, "sample")
    counts = f"Its file contains {samples}, some from before the start; {gaps}."
    if result.reason is None:
        return f"All steps completed in {result.duration:.1f} s. {counts}"
    return f"Ended after {result.duration:.1f} s: {result.reason}. {counts}"
