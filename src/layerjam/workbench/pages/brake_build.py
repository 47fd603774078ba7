"""The Build part of the Brake page: whether a brake can be built, and a workshop folder."""

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nicegui import run, ui

from layerjam.brake.device.workshop import CUTTERS
from layerjam.core.errors import MissingExtraError, count_text
from layerjam.core.units import show
from layerjam.workbench import live
from layerjam.workbench.alone import Tell, run_in_subprocess
from layerjam.workbench.answer import Answer
from layerjam.workbench.call import Call, Options, warning_key
from layerjam.workbench.controls import Choice, add_choice
from layerjam.workbench.more import OtherInputs
from layerjam.workbench.page import Box, Figures, Notes, Page, View
from layerjam.workbench.pages.brake_parts import Parts, PartsView, collect_parts
from layerjam.workbench.runner import Runner, add_progress_line
from layerjam.workbench.spoken import page_text
from layerjam.workbench.tables import Cell, html_table
from layerjam.workbench.uploads import zip_files
from layerjam.workbench.widgets import Alert, button, fold, hint, one_line, status
from layerjam.workshop.commands.build import Built, judge_build

NUMBERS = (
    "mass",
    "pin_to_pin",
    "overall_length",
    "film_area",
    "cut_length",
    "silicone_mass",
    "printed_volume",
    "preload",
    "torque",
)
FILE = "file"
CUTTER = Choice(
    "cutter",
    {FILE: "as in the brake file", **{word: word for word in CUTTERS}},
    FILE,
    "Cutting method",
    "How to cut the film: a cutting service, your own laser, or a knife",
)
COUPONS = Choice(
    "coupons",
    {"no": "no", "yes": "yes"},
    "no",
    "Test pieces",
    "A comb to measure the kerf, and strips to measure friction",
)
CONTROLS = ("cutter", "coupons", "out", "overwrite")
"""Inputs that have a control elsewhere, or none; the panel contains the others."""
DRAWN = Choice(
    "drawn",
    {"brake": "brake parts", "mould": "enclosure mould"},
    "brake",
    "Drawn",
    "Shown in the picture",
)
REFUSED = ("✗ refused", "no font-medium whitespace-nowrap")
WORDS: Mapping[bool | None, tuple[str, str]] = {
    True: ("✓ ok", "yes whitespace-nowrap"),
    False: ("! check", "no whitespace-nowrap"),
    None: ("– not checked", "opacity-80 whitespace-nowrap"),
}


@dataclass(frozen=True)
class BuildResult:
    """Verdict of a build (`answer.refusal` if a package is missing), and its drawn parts."""

    answer: Answer
    parts: Parts | None = None


@dataclass(frozen=True)
class Folder:
    """A folder as a ZIP archive, with its download name; empty if nothing was written."""

    name: str
    result: Built
    content: bytes = b""


class BuildPart(View):
    """Part that shows checks and numbers immediately, but writes the folder only on request."""

    name = "brake"

    def __init__(self, page: Page) -> None:
        super().__init__(page.desk)
        self.page = page
        self.more = OtherInputs(page, "build", CONTROLS)
        self.maker = Runner(self.write_folder, self._on_folder_ready, run.io_bound)
        self.folder: Folder | None = None
        self._trouble = ""

    def build(self) -> None:
        """Build the choices, the verdict, the checks and the download."""
        ui.context.client.on_delete(self.maker.stop)
        with ui.row().classes("w-full items-start gap-6"):
            with ui.column().classes("gap-2 grow").style("min-width: 320px"):
                self.verdict = status("brake-build-verdict", "text-lg font-medium")
                self.reason = Alert("brake-build-reason", "text-sm")
                add_choice(self.desk, self.name, CUTTER)
                add_choice(self.desk, self.name, COUPONS)
                self.more.build()
                with ui.row().classes("w-full items-center gap-3"):
                    act, text = self.download, "Workshop folder (ZIP)"
                    self.button = button(text, act, "brake-build-download", "folder_zip")
                    hint("Patterns, parts to print, mould, instructions and parts list")
                add_progress_line("brake-build", self.maker)
                self.trouble = Alert("brake-build-problem", "text-sm")
                self.after = status("brake-build-after", "text-sm")
            with ui.column().style("width: 280px; flex: none"):
                self.figures = Figures("brake-build", "build", NUMBERS)
        with ui.column().classes("w-full gap-1") as self.picture:
            add_choice(self.desk, self.name, DRAWN)
            self.view = PartsView("brake-build-scene")
        self.table = live.Table()
        self.notes = Notes()
        with fold("Assumptions", "brake-build-assumed") as self.assumed:
            self.list = Box(_list_assumptions)

    def call(self) -> Call:
        """Return the call that writes the folder."""
        options: Options = {}
        if self.word(CUTTER) != FILE:
            options["cutter"] = self.word(CUTTER)
        if self.word(COUPONS) == "yes":
            options["coupons"] = True
        options |= self.more.options()
        return Call("build", (self.desk.brake_subject(),), options, out=self.stem)

    @property
    def stem(self) -> str:
        """Name of the folder."""
        return f"{self.desk.brake.name}-build"

    def calls(self) -> Sequence[Call]:
        """Return the call that writes the folder, as a list."""
        return [self.call()]

    def compute(self) -> BuildResult:
        """Return the verdict and the drawn parts; no file is written."""
        call, mould = self.call(), self.word(DRAWN) == "mould"
        try:
            result = call.run(function=judge_build)
        except MissingExtraError as error:
            return BuildResult(Answer(call, refusal=one_line(error)))
        parts = collect_parts(result.record, mould) if result.feasible else None
        return BuildResult(Answer(call, result), parts)

    def draw(self, build: BuildResult) -> None:
        """Show the verdict."""
        result = build.answer.result
        self.after.set_text("")
        self.picture.set_visibility(build.parts is not None)
        if build.parts is not None:
            self.view.show(build.parts, self.page.dark)
        self.button.set_enabled(result is not None and result.feasible)
        if result is None:
            self.verdict.set_text("")
            self.reason.show_error(build.answer.refusal)
            return
        can = "It can be built as drawn" if result.feasible else "It cannot be built as drawn"
        self.verdict.set_text(can)
        self.reason.show_error(result.reason or "")
        self.figures.fill(result)
        self.table.set_content(checks_table(result))
        keys = {check["key"] for check in result.checks}
        self.notes.fill([w for w in result.warnings if warning_key(w) not in keys])
        self.assumed.set_text(f"Assumptions ({len(result.assumptions)})")
        self.list.fill(result.assumptions)

    async def download(self) -> None:
        """Write the folder and send it to the browser."""
        if self.maker.running:
            return
        self.folder, self._trouble = None, ""
        self.trouble.show_error("")
        self.after.set_text("")
        await self.maker.request_result()
        if self.page.client is None or self.page.client.is_deleted:
            return
        self.trouble.show_error(self._trouble)
        folder = self.folder
        if folder is not None and folder.content:
            ui.download.content(folder.content, f"{folder.name}.zip", "application/zip")
            size = f"{len(folder.content) / 1e6:.1f} MB"
            files = count_text(len(folder.result.files), "file")
            self.after.set_text(f"{files} in {folder.name}.zip, {size}")
        elif folder is not None:
            self.trouble.show_error(folder.result.reason or "")

    def write_folder(self) -> Folder:
        """Return the folder that the command writes; a subprocess frees the memory it needs."""
        call = self.call()
        result = call.run(function=judge_build)
        if not result.feasible:
            return Folder(call.out, result)
        return run_in_subprocess(make_folder, call, progress=self.maker.report_progress)

    def _on_folder_ready(self, folder: Folder | None, problem: str) -> None:
        self.folder, self._trouble = folder, problem


def make_folder(call: Call, progress: Tell) -> Folder:
    """Return the folder that a call writes, as a ZIP archive."""
    with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
        place = Path(folder) / "build"
        result = call.run(out=place, progress=progress)
        files = {f"{call.out}/{name}": (place / name).read_bytes() for name in result.files}
    return Folder(call.out, result, zip_files(files))


def checks_table(result: Built) -> str:
    """Return an HTML table with the verdict, value and limit of each check."""
    rows: list[list[Cell]] = []
    for check in result.checks:
        numbers = [_format_number(check[key], check["unit"]) for key in ("value", "limit")]
        refuses = f"{check['code']}: {check['text']}" in (result.reason or "")
        word = REFUSED if refuses else WORDS[check["ok"]]
        rows.append([word, check["code"], *numbers, check["text"]])
    heads = ["Verdict", "Check", "Number", "Limit", "Result"]
    return html_table(heads, rows, (2, 3), "Build checks", "brake-build-checks")


def _format_number(value: float | None, unit: str) -> str:
    """Return the value of a check as text; a number without a unit becomes a percentage."""
    if value is None:
        return "–"
    return f"{round(value, 3) + 0.0:.1%}" if unit == "1" else show(value, unit, 4)


def _list_assumptions(assumptions: Sequence[Any]) -> None:
    for sentence in assumptions:
        ui.label(page_text(str(sentence))).classes("text-sm")
