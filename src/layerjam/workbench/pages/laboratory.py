"""Laboratory: drop files in, see what was understood, correct it, and take a calibrated brake."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from functools import cache, partial
from typing import Any

from nicegui import app, ui

from layerjam.errors import LayerjamError
from layerjam.measure.sidecar import SIDECAR_ENDING
from layerjam.workbench.call import Call, key_of
from layerjam.workbench.controls import Choice, choice, chosen, menu
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Page
from layerjam.workbench.pages.laboratory_chain import (
    SAMPLE,
    Asked,
    Campaign,
    Chain,
    report,
    taken_roles,
)
from layerjam.workbench.pages.laboratory_correct import Correct
from layerjam.workbench.pages.laboratory_drop import Dropped, practice_files
from layerjam.workbench.pages.laboratory_files import Reader, Row, edits_of, put_roles
from layerjam.workbench.pages.laboratory_results import Card
from layerjam.workbench.pages.laboratory_steps import Done, stem_of
from layerjam.workbench.pages.laboratory_table import Table
from layerjam.workbench.rest import elsewhere
from layerjam.workbench.runner import Runner
from layerjam.workbench.uploads import Uploads, close_all, zipped
from layerjam.workbench.widgets import Alert, button, columns, dressed, hint, one_line

STEPS = ("friction", "calibrate", "validate")
STANDARDS = {"paper": "as the paper", "d1894": "ASTM D1894", "iso8295": "ISO 8295"}
METHODS = {"exact": "peaks", "curves": "whole curves", "bayesian": "Bayesian"}
STICK_SLIP = Choice(
    "judder",
    {"no": "not averaged", "yes": "its middle"},
    "no",
    label="Stick–slip",
    help="Whether the middle of stick–slip counts as kinetic friction (--accept-stick-slip)",
)
FREE = Choice(
    "free",
    {
        "": "nothing more",
        "pressure_exponent": "pressure exponent",
        "speed": "speed",
        "force_offset": "zero of the force",
    },
    "",
    label="Fit as well (whole curves)",
    help="--free of the command",
)
SOON = 0.3
"""Files that arrive within this time [s] of each other are read together."""


class Laboratory(Page):
    """Two files dropped here, and the brake is calibrated."""

    name = "laboratory"

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.uploads = Uploads()
        self.standard = chosen("friction", "standard", STANDARDS, label="Friction tests read")
        self.method = chosen("calibrate", "depth", METHODS, label="Calibrated on")
        self.reader, self.chain = Reader(), Chain()
        self.rows: list[Row] = []
        self.page: Done | None = None
        self._of: Any = None
        """What the report was made of: it goes when that changes."""
        self.job = ""
        """What the second runner does: "report" or "practice"."""
        self.jobs = Runner(self._job, self._job_done, elsewhere)
        self._busy = threading.Lock()
        self._progress = ("", 0.0)
        self._sample = False
        self._read: list[Row] | None = None
        """Files just read, to be shown before the rest is computed."""
        self._wait = 0.0
        self._divide_next = False

    def build(self) -> None:
        """Drop zone and settings left; files, results and report right."""
        ui.context.client.on_delete(self.close)
        _at_shutdown()
        side, main = columns()
        with side:
            self.dropped = Dropped(self.uploads, self._arrived)
            tip = (
                "A campaign of the virtual laboratory on the brake choi2018-kapton; nothing in it "
                "was measured"
            )
            text, practice = "Try with synthetic files", partial(self._begin, "practice")
            key, look = "laboratory-practice", "flat dense no-caps"
            button(text, practice, key, "science", how=look, tip=tip)
            ui.separator()
            menu(self.desk, self.name, self.standard)
            choice(self.desk, self.name, STICK_SLIP)
            choice(self.desk, self.name, self.method)
            menu(self.desk, self.name, FREE)
            self._progress_box()
            self.problem_line()
        with main.classes("gap-4"):
            synthetic = "Synthetic: files among these were written by a program, not measured"
            self.banner = dressed(ui.label(synthetic), "laboratory-synthetic", "synthetic")
            self.banner.set_visibility(False)
            self.table = Table(self._chosen, self._divide, self._sidecars)
            self.correct = Correct(self.desk, self._removed)
            self.cards = {
                name: Card(name, self._take_buttons if name == "calibrate" else lambda: None)
                for name in STEPS
            }
            self._report_card()
        ui.timer(0.2, self._tick)

    def _progress_box(self) -> None:
        with ui.column().classes("w-full gap-1") as self.working:
            self.doing = dressed(ui.label(""), "laboratory-doing", "text-sm", role="status")
            self.bar = ui.linear_progress(0.0, show_value=False)
            dressed(self.bar, how="instant-feedback", aria_label="Progress")
            button("Stop", self._stop, "laboratory-stop", "stop")
        self.working.set_visibility(False)

    def _take_buttons(self) -> None:
        self.sample = _button("Sample", "casino", self._begin_sampling, "sample")
        self.take = _button("Take this brake onto the desk", "move_up", self._take, "take")
        self.toml = _button("TOML", "download", self._download_brake, "toml")

    def _report_card(self) -> None:
        with dressed(ui.card(), "laboratory-report", "w-full", "flat bordered"):
            with ui.row().classes("w-full items-center justify-between"):
                dressed(ui.label("Report"), "", "text-lg font-medium", role="heading")
                begin = partial(self._begin, "report")
                self.make = _button("Make the report", "description", begin, "make-report")
            self.report_problem = Alert("laboratory-report-problem")
            words = hint(
                "Friction, calibration and validation on a few pages, with every file's digest."
            )
            self.report_words = dressed(words, "laboratory-report-words")
            with ui.row().classes("gap-2") as self.downloads:
                for name in ("report.pdf", "report.html"):
                    _button(name, "download", partial(self._download, name), name.replace(".", "-"))
                whole = partial(self._download, "")
                _button("All of it (ZIP)", "folder_zip", whole, "report-zip")
            self.downloads.set_visibility(False)

    # what is computed

    def campaign(self, rows: Sequence[Row], tell: Any) -> Campaign:
        """Files and controls of now."""
        free = self.word(FREE)
        asked = Asked(
            standard=self.word(self.standard),
            accept_stick_slip=self.word(STICK_SLIP) == "yes",
            depth=self.word(self.method),
            free=(free,) if free else (),
        )
        brake, name = self.desk.brake_subject(), self.desk.brake.name
        return Campaign(rows, brake, name, asked, self.uploads.folder, tell)

    def calls(self) -> Sequence[Call]:
        """The steps that are shown, in order, and the report where one was made."""
        made = [self.chain.done[name] for name in STEPS if name in self.chain.done]
        steps = [done.call for done in made if done.result is not None]
        return [*steps, self.page.call] if self.page is not None else steps

    def compute(self) -> list[Row]:
        """Read what is new, then friction, calibration and validation as far as files go."""
        with self._busy:
            standard = self.word(self.standard)
            rows = self.reader.rows(self.uploads, edits_of(self.desk), self._tell, standard)
            self._read = rows
            if rows:
                sample, self._sample = self._sample, False
                self.chain.run(self.campaign(rows, self._tell), sample)
            else:
                self.chain.done.clear()
            return rows

    def _tell(self, what: str, share: float) -> None:
        self._progress = (what, share)
        self.runner.tell(what, share)

    def _tell_of_job(self, what: str, share: float) -> None:
        self._progress = (what, share)
        self.jobs.tell(what, share)

    def refresh(self) -> None:
        """Ask anew; what is being computed from older inputs is given up."""
        if self.runner.running:
            self.runner.stop()
        super().refresh()

    def _show(self, result: Any, problem: str) -> None:
        if not self.uploads.closed and (problem or result is not None):  # None: the server ends
            super()._show(result, problem)
            self._fill_cards()

    def draw(self, result: list[Row]) -> None:
        """Table, chosen files and cards."""
        if self.page is not None and self._of != self._inputs(result):
            self.page = None
        self._fill_files(result)
        self._fill_cards()
        self.make.set_enabled(any(r.good for r in result))
        self._fill_report("")
        if self._divide_next and result:
            self._divide_next = False
            self._divide()

    def _fill_files(self, rows: list[Row]) -> None:
        self._read = None
        self.rows = rows
        self.banner.set_visibility(any(r.synthetic for r in rows))
        self.table.fill(rows)
        self._chosen(self.table.chosen)

    def _fill_cards(self) -> None:
        for name, card in self.cards.items():
            card.fill(self.chain.done.get(name), self.chain.instead.get(name, ""))
        fitted = self.chain.done.get("calibrate")
        ready = fitted is not None and bool(fitted.text)
        self.take.set_visibility(ready)
        self.toml.set_visibility(ready)
        self.sample.set_visibility(self.chain.instead.get("calibrate") == SAMPLE)

    # what the user does

    def _arrived(self) -> None:
        self._wait = SOON

    def _tick(self) -> None:
        if self._wait > 0:
            self._wait -= 0.2
            if self._wait <= 0:
                self.refresh()
        busy = self.runner.running or self.jobs.running
        self.working.set_visibility(busy and bool(self._progress[0]))
        if busy:
            what, share = self._progress
            self.doing.set_text(what)
            self.bar.set_value(round(share, 2))
            if self._read is not None:
                self._fill_files(self._read)
            self._fill_cards()
        else:
            self._progress = ("", 0.0)

    def _stop(self) -> None:
        self.runner.stop()
        self.jobs.stop()

    def _chosen(self, keys: Sequence[str]) -> None:
        self.correct.fill([r for r in self.rows if r.upload.key in keys], self.dark)

    def _removed(self, keys: Sequence[str]) -> None:
        self.uploads.remove(keys)
        self.table.chosen = []
        self.refresh()

    def _divide(self) -> None:
        put_roles(self.desk, taken_roles(self.rows))

    def _sidecars(self) -> None:
        files = {r.upload.name + SIDECAR_ENDING: r.sidecar.encode() for r in self.rows if r.sidecar}
        if files:
            ui.download.content(zipped(files), "sidecars.zip", "application/zip")
        else:
            ui.notify("none of these files has a sidecar")

    def _begin_sampling(self) -> None:
        self._sample = True
        self.refresh()

    def _take(self) -> None:
        fitted = self.chain.done.get("calibrate")
        if fitted is None or not fitted.text:
            return
        try:
            self.desk.put_brake(fitted.text)
        except LayerjamError as err:
            ui.notify(one_line(err), type="warning")
            return
        ui.notify("The calibrated brake is on the desk; undo takes it back")

    def _download_brake(self) -> None:
        fitted = self.chain.done.get("calibrate")
        if fitted is not None and fitted.text:
            ui.download.content(fitted.text.encode(), fitted.call.out, "application/toml")

    def _download(self, name: str) -> None:
        if self.page is None:
            return
        stem = stem_of(self.desk.brake.name)
        if name:
            kind = "application/pdf" if name.endswith("pdf") else "text/html"
            ui.download.content(self.page.pages[name], f"{stem}-{name}", kind)
        else:
            ui.download.content(zipped(self.page.pages), f"{stem}-report.zip", "application/zip")

    # report and practice files

    async def _begin(self, job: str) -> None:
        if self.jobs.running:
            ui.notify(f"the {self.job} is still being made")
            return
        self.job = job
        await self.jobs.ask()

    def _job(self) -> Any:
        with self._busy:
            if self.job == "practice":
                return practice_files(self.uploads.folder, self._tell_of_job)
            return report(self.campaign(self.rows, self._tell_of_job))

    def _job_done(self, result: Any, problem: str) -> None:
        if self.uploads.closed or not (problem or result):
            return
        if self.job == "report":
            self.page = None if problem else result
            self._of = self._inputs(self.rows)
            self._fill_report(problem)
        elif problem:
            ui.notify(problem, type="warning")
        else:
            self._divide_next = True
            self.dropped.take_all(result)

    def _fill_report(self, problem: str) -> None:
        self.report_problem.say(problem)
        self.downloads.set_visibility(self.page is not None)
        if self.page is not None and self.page.result is not None:
            size = sum(len(b) for b in self.page.pages.values())
            words = [f"{len(self.page.pages)} files, {size / 1e6:.1f} MB."]
            words += [w for w in self.page.result.warnings if key_of(w) == "calibrated-on"]
            if self.page.result.pdf is None:
                words.append("No PDF: the optional part 'pdf' is not installed.")
            self.report_words.set_text(" ".join(words))

    def _inputs(self, rows: Sequence[Row]) -> Any:
        """What a report depends on."""
        files = [(r.upload.digest, r.sidecar, r.role) for r in rows]
        return files, self.campaign(rows, None).asked, self.desk.state.brake

    def close(self) -> None:
        """The tab is gone: stop, and delete its files."""
        self._stop()
        self.uploads.close()


@cache
def _at_shutdown() -> None:
    """Delete all tabs' files when the server ends; said once."""
    app.on_shutdown(close_all)


def _button(text: str, icon: str, act: Any, key: str) -> ui.button:
    return button(text, act, f"laboratory-{key}", icon)
