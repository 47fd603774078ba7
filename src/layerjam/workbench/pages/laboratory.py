"""Laboratory: drop files, check and correct how they are read, and get a calibrated brake."""

from collections.abc import Sequence
from functools import lru_cache, partial
from typing import Any

from nicegui import ui

from layerjam.core.errors import LayerjamError, count_text
from layerjam.laboratory.measure.sidecar import SIDECAR_ENDING
from layerjam.workbench import spoken
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Options, parameters, warning_key
from layerjam.workbench.controls import Choice, add_choice, add_menu, make_choice
from layerjam.workbench.desk import Desk
from layerjam.workbench.dropping import DropHint
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Page
from layerjam.workbench.pages.laboratory_chain import (
    SAMPLE,
    STEPS,
    Campaign,
    Chain,
    StepResult,
    split_roles,
)
from layerjam.workbench.pages.laboratory_correct import CorrectionPanel
from layerjam.workbench.pages.laboratory_files import Row, make_practice_files, read_row, read_rows
from layerjam.workbench.pages.laboratory_results import Card, Table, headlines, show_step
from layerjam.workbench.said import get_edits, put_edits
from layerjam.workbench.uploads import MAX_FILES, UploadError, zip_files
from layerjam.workbench.widgets import Heroes, button, columns, dress, one_line

STANDARDS = {"paper": "as in the paper", "d1894": "ASTM D1894", "iso8295": "ISO 8295"}
METHODS = {"exact": "peaks", "curves": "whole curves", "bayesian": "Bayesian"}
STICK_SLIP = Choice(
    "judder",
    {"no": "not averaged", "yes": "midpoint of its envelope"},
    "no",
    label="Stick–slip",
    help="Whether the midpoint of stick–slip counts as kinetic friction",
)
FREE = Choice(
    "free",
    dict(spoken.FREE),
    "",
    label=spoken.OTHERWISE["free"],
    help="Quantities to fit to whole curves, in addition to friction",
)
BY_FILE = (
    *("negative", "column", "columns", "decimal", "specimen", "sheet", "names", "speed"),
    *("normal_force", "vacuum", "exclude", "because"),
)
"""Inputs that the page offers separately for each file: metadata, corrections and role."""
OWN_FRICTION = (*BY_FILE, "standard", "accept_stick_slip", "brake", "partial", "overwrite")
OWN_CALIBRATION = (*BY_FILE, "depth", "free", "partial", "overwrite")
OWN_REPORT = tuple(parameters("report").keys() - {"report_number", "customer"})
"""Inputs that have a control elsewhere, or none; the panels contain the others."""
LOOK = 0.2
"""Seconds between two updates of intermediate results."""
KINDS = {"report.pdf": "application/pdf", "report.html": "text/html"}


class Laboratory(Page):
    """Page that calibrates a brake from dropped files; two files are enough."""

    name, title = "laboratory", "Laboratory"
    summary = "From measured files to a calibrated brake"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.uploads, self.chain = desk.files, Chain()
        labels = spoken.OTHERWISE
        self.standard = make_choice("friction", "standard", STANDARDS, label=labels["standard"])
        self.method = make_choice("calibrate", "depth", METHODS, label=labels["depth"])
        self.more = {
            "More options for friction tests": OtherInputs(self, "friction", OWN_FRICTION),
            "More options for the calibration": OtherInputs(self, "calibrate", OWN_CALIBRATION),
            "More options for the report": OtherInputs(self, "report", OWN_REPORT),
        }
        self.rows: list[Row] = []
        self._read = lru_cache(4 * MAX_FILES)(read_row)
        self._wanted: set[str] = set()
        """Actions requested with buttons: "sample", "report" or "practice"."""
        self._begun: object = None
        """Inputs of the current computation."""
        self._needs_roles = False
        """Whether new practice files still need to be assigned to calibration and validation."""
        self._rejected: list[str] = []
        self._saves_report = False
        """Whether the report in preparation is to be downloaded."""

    def build(self) -> None:
        """Build the drop area and settings on the left; files, results and report on the right."""
        ui.context.client.on_delete(self.close)
        side, main = columns(all_shown=True)
        with side:
            DropHint(self.desk, self.name)
            tip = (
                "A virtual laboratory campaign for the choi2018-kapton brake; none of it was "
                "measured"
            )
            text, practice = "Try with synthetic files", partial(self._request_action, "practice")
            key, look = "laboratory-practice", "flat dense no-caps"
            button(text, practice, key, "science", look=look, tip=tip)
            ui.separator()
            add_menu(self.desk, self.name, self.standard)
            add_choice(self.desk, self.name, STICK_SLIP)
            add_choice(self.desk, self.name, self.method)
            add_menu(self.desk, self.name, FREE)
            for title, inputs in self.more.items():
                inputs.build(title)
            self.add_alert()
        with main.classes("gap-4"):
            self.heroes = Heroes(self.name)
            synthetic = "Synthetic: a program wrote some of these files; they were not measured"
            self.banner = dress(ui.label(synthetic), "laboratory-synthetic", "synthetic")
            self.table = Table(
                self._on_choose, self._assign_roles, self._download_sidecars, self.uploads.refused
            )
            self.correct = CorrectionPanel(self.desk, self._on_remove)
            self.cards = [
                Card(self.desk, "friction", show_step),
                Card(self.desk, "calibrate", show_step, self._add_buttons),
                Card(self.desk, "validate", show_step),
                Card(self.desk, "report", self._show_report, self._add_report),
            ]
        self._fill_tables()
        ui.timer(LOOK, self._update_results)

    def _add_buttons(self) -> None:
        sample = partial(self._request_action, "sample")
        self.sample = _add_button("Sample", "casino", sample, "sample")
        self.take = _add_button("Use this brake on all pages", "move_up", self._use_brake, "take")
        self.toml = _add_button("TOML", "download", self._download_brake, "toml")

    def _add_report(self) -> None:
        begin = partial(self._request_action, "report")
        self.make = _add_button("Create the report", "description", begin, "make-report")

    def _show_report(self, step: StepResult) -> None:
        size = sum(map(len, step.pages.values()))
        words = [f"{count_text(len(step.pages), 'file')}, {size / 1e6:.1f} MB."]
        words += [w for w in step.result.warnings if warning_key(w) == "calibrated-on"]
        for check in step.result.failed_checks:
            words.append(f"Not written: check '{check['name']}' failed, {check['reason']}.")
        if step.result.pdf is None and not step.result.failed_checks:
            words.append("No PDF: the optional extra 'pdf' is not installed.")
        dress(ui.label(spoken.page_text(" ".join(words))), "laboratory-report-words", "opacity-80")

        def download_pages() -> None:
            ui.download.content(zip_files(step.pages), f"{step.call.out}.zip", "application/zip")

        if not step.pages:
            return
        with ui.row().classes("gap-2"):
            for name in (n for n in KINDS if n in step.pages):
                _add_button(
                    name, "download", partial(_download_page, step, name), name.replace(".", "-")
                )
            _add_button("All files (ZIP)", "folder_zip", download_pages, "report-zip")

    # ---- computation

    def campaign(self) -> Campaign:
        """Return a campaign with the current files and controls."""
        depth, free = self.word(self.method), self.word(FREE)
        options: Options = {
            "standard": self.word(self.standard),
            "accept_stick_slip": self.word(STICK_SLIP) == "yes",
            "depth": depth,
            "free": (free,) if free and depth == "curves" else (),
        }
        for inputs in self.more.values():
            options |= inputs.options()
        brake, folder = self.desk.brake_subject(), self.uploads.folder
        return Campaign(self.rows, brake, options, folder, self.runner.report_progress)

    def answers(self) -> Sequence[Answer]:
        """Return the answers of the displayed steps, in order, and of the report, if any."""
        runs = [self.chain.done.get(name) for name in (*STEPS, "report")]
        return [Answer(step.call, step.result) for step in runs if step and step.result is not None]

    def compute(self) -> list[Row]:
        """Read new files, then compute friction, calibration and validation as far as possible."""
        actions, self._wanted = self._wanted, set()
        self._begun = self._request_inputs()
        if "practice" in actions:
            self._load_practice_files()
        edits, standard = get_edits(self.desk), self.word(self.standard)
        self.rows = read_rows(
            self.uploads, edits, standard, self._read, self.runner.report_progress
        )
        if not self.rows:
            self.chain = Chain()
        elif not self._needs_roles:
            self.chain.run(self.campaign(), *actions)
        return self.rows

    def _load_practice_files(self) -> None:
        folder, tell = self.uploads.folder, self.runner.report_progress
        for name, data in make_practice_files(folder, tell).items():
            try:
                self.uploads.store_file(name, data)
            except UploadError as err:
                self._rejected.append(str(err))
        self._needs_roles = True

    def _request_inputs(self) -> object:
        """Return everything that the computation depends on."""
        state, files = self.desk.state, self.uploads
        return state.settings.get(self.name), state.brake, files.files_in_use, dict(files.sidecars)

    def refresh(self) -> None:
        """Request a new computation, and cancel a running one whose inputs are outdated."""
        if self.runner.running and self._request_inputs() != self._begun:
            self.runner.stop()
        super().refresh()

    def _show(self, result: Any, problem: str) -> None:
        # None means that the server is stopping
        if not self.uploads.closed and (problem or result is not None):
            super()._show(result, problem)
            if self.desk.state.page == self.name:  # a hidden page is filled when opened
                self._fill_tables()

    def draw(self, result: list[Row]) -> None:
        """Report rejected practice files, assign roles to the others, and download a new report."""
        if self._rejected:
            ui.notify("; ".join(self._rejected[:5]), type="warning")
        self._rejected.clear()
        if self._needs_roles:
            self._needs_roles = False
            self._assign_roles()
            self.refresh()
        report = self.chain.done.get("report")
        if self._saves_report and report is not None and report.pages:
            _download_page(report, next(name for name in KINDS if name in report.pages))
            ui.notify("The report was created and saved to your downloads", type="positive")
        self._saves_report = False

    def _update_results(self) -> None:
        if self.runner.running and self.desk.state.page == self.name:
            self._fill_tables()

    def _fill_tables(self) -> None:
        self.banner.set_visibility(any(r.is_synthetic for r in self.rows))
        self.table.fill(self.rows)
        self._on_choose(self.table.chosen)
        self.heroes.fill(headlines(self.chain))
        for card in self.cards:
            card.fill(self.chain)
        for control in (self.take, self.toml):
            control.set_visibility(self._calibration_step() is not None)
        self.sample.set_visibility(self.chain.messages.get("calibrate") == SAMPLE)
        self.make.set_enabled(any(r.is_usable for r in self.rows))

    def _calibration_step(self) -> StepResult | None:
        step = self.chain.done.get("calibrate")
        return None if step is None or step.brake is None else step

    # ---- user actions

    def _request_action(self, action: str) -> None:
        self._wanted.add(action)
        self._saves_report = action == "report"
        self.refresh()

    def _on_choose(self, keys: Sequence[str]) -> None:
        self.correct.fill([r for r in self.rows if r.upload.key in keys], self.dark)

    def _on_remove(self, keys: Sequence[str]) -> None:
        self.uploads.remove_files(keys)
        self.table.chosen = []
        self.desk.announce_files()

    def _assign_roles(self) -> None:
        put_edits(self.desk, split_roles(self.rows))

    def _download_sidecars(self) -> None:
        uploads = [r.upload for r in self.rows]
        files = {u.shown + SIDECAR_ENDING: u.sidecar.encode() for u in uploads if u.sidecar}
        if files:
            ui.download.content(zip_files(files), "sidecars.zip", "application/zip")
        else:
            ui.notify("none of these files has a sidecar")

    def _use_brake(self) -> None:
        calibration = self._calibration_step()
        if calibration is None or calibration.brake is None:
            return
        try:
            self.desk.put_brake(calibration.brake.text)
        except LayerjamError as err:
            ui.notify(one_line(err), type="warning")
            return
        ui.notify("The calibrated brake is now the current brake; use Undo to go back")

    def _download_brake(self) -> None:
        calibration = self._calibration_step()
        if calibration is not None and calibration.brake is not None:
            text = calibration.brake.text.encode()
            ui.download.content(text, calibration.call.out, "application/toml")

    def close(self) -> None:
        """Stop the computation when the tab is closed."""
        self.runner.stop()


def _download_page(report: StepResult, name: str) -> None:
    stem = report.call.out.removesuffix("-report")
    ui.download.content(report.pages[name], f"{stem}-{name}", KINDS[name])


def _add_button(text: str, icon: str, act: Any, key: str) -> ui.button:
    return button(text, act, f"laboratory-{key}", icon)
