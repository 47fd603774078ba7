"""Measured pulls on the Pull page: reading, comparison with the brake, and pins."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from nicegui import ui

from layerjam.core.units import show
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.identify.pull.features import PullFeatures
from layerjam.laboratory.identify.validation.metrics import CurveError
from layerjam.laboratory.measure.trace import Trace
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, Pinned, try_call
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import Desk
from layerjam.workbench.dropping import DropHint
from layerjam.workbench.page import Box, Notes, show_checks
from layerjam.workbench.panel import Panel
from layerjam.workbench.proposals import ASIDE, FRICTION
from layerjam.workbench.said import get_edits, sidecar_text
from layerjam.workbench.spoken import page_text
from layerjam.workbench.state import MEASURED
from layerjam.workbench.tables import html_table
from layerjam.workbench.uploads import Upload
from layerjam.workbench.widgets import Alert, button, dress, hint


@dataclass(frozen=True)
class MeasuredPull:
    """A measured pull from a dropped file, not compared with a model."""

    file: Upload
    trace: Trace
    features: PullFeatures

    @property
    def label(self) -> str:
        """Label with the origin (measured or synthetic), the vacuum and the file."""
        word = "synthetic" if self.trace.synthetic else "measured"
        return f"{word}, {self.description}"

    @property
    def description(self) -> str:
        """Stated vacuum, and the user's name for the file."""
        vacuum = self.trace.facts.vacuum
        vacuum_text = "vacuum not stated" if vacuum is None else show(vacuum, "Pa", 3)
        specimen = f", specimen {self.trace.specimen}" if self.trace.specimen else ""
        return f"{vacuum_text}, {self.file.shown}{specimen}"


@dataclass(frozen=True)
class Reading:
    """Results of `pull` and `validate` for the files, or the reasons why these were rejected."""

    files: tuple[Upload, ...] = ()
    answers: tuple[Answer, ...] = ()
    lacks_vacuum: bool = False
    """Whether the vacuum of a file is missing."""

    @property
    def pull_result(self) -> Any:
        """Result of `pull`, or None."""
        return self.answers[0].result if self.answers else None

    @property
    def validation(self) -> Any:
        """Result of `validate`, or None."""
        return self.answers[1].result if len(self.answers) > 1 else None

    def shown_name(self, path: str) -> str:
        """Return a path with the user's name for the file."""
        name: str = rename_files(path, {file.path.name: file.shown for file in self.files})
        return name

    def sentences(self, name: str) -> list[str]:
        """Return sentences on how one file was read, or why it was rejected."""
        if self.pull_result is None:
            return []
        lines = [
            f"not used: {reason}"
            for result in (self.pull_result, self.validation)
            for path, reason in (result.refused.items() if result is not None else ())
            if path.startswith(name)
        ]
        for path, sentences in self.pull_result.understood.items():
            if path.split(", specimen ")[0] == name:
                lines.append("; ".join(sentences))
        return list(dict.fromkeys(lines))

    @cached_property
    def measured_pulls(self) -> Sequence[MeasuredPull]:
        """Every readable pull; a file may contain several."""
        files = {str(file.path): file for file in self.files}
        record = () if self.pull_result is None else self.pull_result.record
        return [
            MeasuredPull(files[trace.path], trace, summary.features) for trace, summary in record
        ]

    @property
    def curves(self) -> Sequence[CurveError]:
        """Pulls compared with the model; empty if there are none."""
        return () if self.validation is None else self.validation.record[1].curves


def find_pulls(desk: Desk) -> tuple[Upload, ...]:
    """Return those of the tab's files that may contain pulls, with their sidecars written."""
    uploads, edits, files = desk.files, get_edits(desk), []
    for upload in uploads.files_in_use:
        edit = edits.get(upload.key, {})
        if edit.get("role") not in (FRICTION, ASIDE):
            text = sidecar_text(uploads.sidecars.get(upload.shown, ""), edit)
            files.append(uploads.write_sidecar(upload, text))
    return tuple(files)


def read_pulls(
    files: tuple[Upload, ...], brake: Subject, vacuum: str, progress: Callable[[str, float], None]
) -> Reading:
    """Run `pull` and `validate` on the files; errors contain the user's file names."""
    if not files:
        return Reading()
    pull = try_call(Call("pull", files=files), progress=progress)
    if pull.result is None:
        return Reading(files, (pull,))
    lacking = any(row["vacuum"] is None for row in pull.result.pulls)
    validate = Call("validate", (brake,), {"vacuum": vacuum} if lacking else {}, files)
    return Reading(files, (pull, try_call(validate, progress=progress)), lacking)


class MeasuredFiles:
    """Drop area, and a list of the files and how they were read."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        DropHint(desk, "pull")
        self._trouble = Alert("pull-file-problem", "text-sm")
        self.list = dress(Box(self._show_reading), "pull-files")

    def _remove_file(self, key: str) -> None:
        self.desk.files.remove_files([key])
        self.desk.announce_files()

    def fill(self, reading: Reading) -> None:
        """Show the results of the files."""
        if self.list.fill(reading):
            self._trouble.show_error("".join(answer.refusal for answer in reading.answers))

    def _show_reading(self, reading: Reading) -> None:
        for file in reading.files:
            with ui.row().classes("w-full items-center justify-between no-wrap gap-1"):
                ui.label(file.shown).classes("text-sm font-medium").style("overflow-wrap: anywhere")
                look, remove = "flat round dense size=sm", partial(self._remove_file, file.key)
                remove_button = button("", remove, "pull-file-remove", "close", look=look)
                dress(remove_button, aria_label=f"Remove {file.shown}")
            for sentence in reading.sentences(file.shown):
                ui.label(page_text(sentence)).classes("text-xs opacity-80")
        files = self.desk.files
        for name in sorted({*files.sidecars} - {f.shown for f in files.files}):
            ui.label(f"{name}.toml was added without {name}").classes("text-xs opacity-80")


def show_errors(reading: Reading) -> None:
    """Show each pull's MAPE, RMSE and bias, and the checks; show nothing without files."""
    if reading.validation is None:
        return
    hint(
        "Each file, with the model at its vacuum (dashed). Below the curve: the residual, "
        "measured minus model, over the compared range."
    )
    heads = ["File", "Vacuum", "Speed", "MAPE", "RMSE", "Model − measured"]
    rows = []
    for row in reading.validation.files:
        vacuum, speed = show(row["vacuum"], "Pa"), show(row["speed"], "m/s", 3)
        error, bias = show(row["rmse"], "N", 3), show(row["bias"], "N", 3)
        mape, bias = f"{row['mape']:.2%}", bias.replace("-", "−")
        rows.append([row["path"], vacuum, speed, mape, error, bias])
    table = html_table(heads, rows, range(1, 6), "Residuals", "pull-errors")
    live.Table().set_content(table)
    show_checks(reading.validation)
    Notes().fill(list(dict.fromkeys(reading.validation.warnings)))


TITLE = "Pin a measured curve"


def collect_pinned_files(desk: Desk, reading: Reading) -> tuple[Pinned, ...]:
    """Return the pinned measured curves whose files are present, each with its own answer."""
    by_key, pins = {pull.file.key: pull for pull in reversed(reading.measured_pulls)}, []
    for pin in desk.state.pins:
        pull = by_key.get(pin.subject) if pin.command == MEASURED else None
        if pull is not None:
            path, record = pull.file.path, reading.pull_result.record
            records = [pair for pair in record if Path(pair[0].path) == path]
            result = replace(reading.pull_result, record=records)
            pins.append(
                Pinned(pull.label, Answer(Call("pull", files=(pull.file,)), result), pin=pin)
            )
    return tuple(pins)


class PinFiles:
    """A button that pins a measured pull: the only one, or one selected from a menu."""

    def __init__(self, desk: Desk, panel: Panel) -> None:
        self._desk, self._panel = desk, panel
        self._names: Mapping[str, str] = {}
        self._shown: object = None
        self._button = button(TITLE, self._on_click, "pull-pin-file", "push_pin")
        with self._button:
            menu_props = f'no-parent-event auto-close role="region" aria-label="{TITLE}"'
            with ui.menu().props(menu_props) as self._menu:
                self._list = dress(ui.element("div"), role="menu", aria_label=TITLE)
        self._button.set_visibility(False)

    def fill(self, reading: Reading) -> None:
        """Show the current pulls; unchanged ones are not rebuilt."""
        pins = self._desk.state.files
        self._names = {pull.file.key: pull.description for pull in reversed(reading.measured_pulls)}
        content = (tuple(self._names.items()), pins)
        if content == self._shown:
            return
        self._shown = content
        self._button.set_visibility(len(self._names) > 1 or bool(self._names.keys() - {*pins}))
        self._list.clear()
        with self._list:
            for key, name in reversed(self._names.items()):
                text = f"✓ {name}" if key in pins else name
                item = ui.menu_item(text, partial(self._panel.pin_file, key))
                dress(item, f"pull-pin-file-{key}", role="menuitem")

    def _on_click(self) -> None:
        if len(self._names) == 1:
            self._panel.pin_file(next(iter(self._names)))
        else:
            self._menu.open()
