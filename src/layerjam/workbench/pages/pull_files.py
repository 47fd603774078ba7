"""Measured pulls on the page Pull: dropped in, understood, held against the brake, and pinned."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from nicegui import ui

from layerjam.identify.provenance import rename_files
from layerjam.identify.pull.features import PullFeatures
from layerjam.identify.validation.metrics import CurveError
from layerjam.measure.trace import Trace
from layerjam.units import show
from layerjam.workbench import live
from layerjam.workbench.answer import Answer, Pinned, answered
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import Desk
from layerjam.workbench.dropping import FilesHere
from layerjam.workbench.page import Box, Notes, checks
from layerjam.workbench.panel import Panel
from layerjam.workbench.proposals import ASIDE, FRICTION
from layerjam.workbench.said import edits_of, sidecar_text
from layerjam.workbench.spoken import on_page
from layerjam.workbench.state import MEASURED
from layerjam.workbench.tables import html
from layerjam.workbench.uploads import Upload
from layerjam.workbench.widgets import Alert, button, dressed, hint


@dataclass(frozen=True)
class MeasuredPull:
    """A pull of a dropped file as it was measured, without any model."""

    file: Upload
    trace: Trace
    features: PullFeatures

    @property
    def label(self) -> str:
        """That it was measured, or that a program wrote it; at which vacuum; the file."""
        word = "synthetic" if self.trace.synthetic else "measured"
        return f"{word}, {self.about}"

    @property
    def about(self) -> str:
        """The vacuum that file or sidecar state, and the user's name of the file."""
        vacuum = self.trace.facts.vacuum
        stated = "vacuum not stated" if vacuum is None else show(vacuum, "Pa", 3)
        specimen = f", specimen {self.trace.specimen}" if self.trace.specimen else ""
        return f"{stated}, {self.file.shown}{specimen}"


@dataclass(frozen=True)
class Reading:
    """What the files say (`pull`) and how the brake compares (`validate`), or why not."""

    files: tuple[Upload, ...] = ()
    answers: tuple[Answer, ...] = ()
    lacking: bool = False
    """Whether a file does not say at which vacuum it was pulled."""

    @property
    def understood(self) -> Any:
        """The result of `pull`."""
        return self.answers[0].result if self.answers else None

    @property
    def compared(self) -> Any:
        """The result of `validate`."""
        return self.answers[1].result if len(self.answers) > 1 else None

    def named(self, path: str) -> str:
        """The user's name of a file."""
        made: str = rename_files(path, {file.path.name: file.shown for file in self.files})
        return made

    def sentences(self, shown: str) -> list[str]:
        """What was understood of one file, or why it was refused."""
        if self.understood is None:
            return []
        said = [
            f"not used: {why}"
            for result in (self.understood, self.compared)
            for path, why in (result.refused.items() if result is not None else ())
            if path.startswith(shown)
        ]
        for path, sentences in self.understood.understood.items():
            if path.split(", specimen ")[0] == shown:
                said.append("; ".join(sentences))
        return list(dict.fromkeys(said))

    @cached_property
    def measured(self) -> Sequence[MeasuredPull]:
        """Every pull that was understood, from its onset on; a file may hold several."""
        files = {str(file.path): file for file in self.files}
        record = () if self.understood is None else self.understood.record
        return [MeasuredPull(files[trace.path], trace, one.features) for trace, one in record]

    @property
    def curves(self) -> Sequence[CurveError]:
        """The pulls compared; empty where there are none."""
        return () if self.compared is None else self.compared.record[1].curves


def laid_out(desk: Desk) -> tuple[Upload, ...]:
    """The pulls among the tab's files as a call takes them, their sidecars written beside them."""
    uploads, edits, made = desk.files, edits_of(desk), []
    for one in uploads.used:
        said = edits.get(one.key, {})
        if said.get("role") not in (FRICTION, ASIDE):
            text = sidecar_text(uploads.sidecars.get(one.shown, ""), said)
            made.append(uploads.with_sidecar(one, text))
    return tuple(made)


def read(
    files: tuple[Upload, ...], brake: Subject, vacuum: str, tell: Callable[[str, float], None]
) -> Reading:
    """Both commands on the files; refusals as words, in the user's names."""
    if not files:
        return Reading()
    pull = answered(Call("pull", files=files), progress=tell)
    if pull.result is None:
        return Reading(files, (pull,))
    lacking = any(row["vacuum"] is None for row in pull.result.pulls)
    validate = Call("validate", (brake,), {"vacuum": vacuum} if lacking else {}, files)
    return Reading(files, (pull, answered(validate, progress=tell)), lacking)


class Measured:
    """Where files come from, and those that are pulls with what was understood of them."""

    def __init__(self, desk: Desk) -> None:
        self.desk = desk
        FilesHere(desk, "pull")
        self._trouble = Alert("pull-file-problem", "text-sm")
        self.list = dressed(Box(self._show), "pull-files")

    def _remove(self, key: str) -> None:
        self.desk.files.remove([key])
        self.desk.files_changed()

    def fill(self, reading: Reading) -> None:
        """Show what was made of the files."""
        if self.list.fill(reading):
            self._trouble.say("".join(answer.refusal for answer in reading.answers))

    def _show(self, reading: Reading) -> None:
        for file in reading.files:
            with ui.row().classes("w-full items-center justify-between no-wrap gap-1"):
                ui.label(file.shown).classes("text-sm font-medium").style("overflow-wrap: anywhere")
                look, gone = "flat round dense size=sm", partial(self._remove, file.key)
                away = button("", gone, "pull-file-remove", "close", how=look)
                dressed(away, aria_label=f"Take {file.shown} away")
            for sentence in reading.sentences(file.shown):
                ui.label(on_page(sentence)).classes("text-xs opacity-80")
        files = self.desk.files
        for name in sorted({*files.sidecars} - {f.shown for f in files.files}):
            ui.label(f"{name}.toml waits for {name}").classes("text-xs opacity-80")


def show_errors(reading: Reading) -> None:
    """MAPE, RMSE and bias of every pull, and what the checks say; nothing without files."""
    if reading.compared is None:
        return
    hint(
        "Each file against the model at the vacuum of that file (dashed); below the curve what is "
        "left over, measured less model, over the part that is compared."
    )
    heads = ["File", "Vacuum", "Speed", "MAPE", "RMSE", "Model − measured"]
    rows = []
    for row in reading.compared.files:
        vacuum, speed = show(row["vacuum"], "Pa"), show(row["speed"], "m/s", 3)
        error, bias = show(row["rmse"], "N", 3), show(row["bias"], "N", 3)
        mape, bias = f"{row['mape']:.2%}", bias.replace("-", "−")
        rows.append([row["path"], vacuum, speed, mape, error, bias])
    made = html(heads, rows, range(1, 6), "What is left over", "pull-errors")
    live.Table().set_content(made)
    checks(reading.compared)
    Notes().fill(list(dict.fromkeys(reading.compared.warnings)))


TITLE = "Pin a measured curve"


def pinned_files(desk: Desk, reading: Reading) -> tuple[Pinned, ...]:
    """The measured curves that are pinned and there, each with its file's own answer."""
    named, made = {one.file.key: one for one in reversed(reading.measured)}, []
    for pin in desk.state.pins:
        one = named.get(pin.subject) if pin.command == MEASURED else None
        if one is not None:
            path, record = one.file.path, reading.understood.record
            own = [pair for pair in record if Path(pair[0].path) == path]
            result = replace(reading.understood, record=own)
            made.append(Pinned(one.label, Answer(Call("pull", files=(one.file,)), result), pin=pin))
    return tuple(made)


class PinFiles:
    """A button that pins a dropped pull: at once where there is one, else one of a list."""

    def __init__(self, desk: Desk, panel: Panel) -> None:
        self._desk, self._panel = desk, panel
        self._names: Mapping[str, str] = {}
        self._shown: object = None
        self._button = button(TITLE, self._asked, "pull-pin-file", "push_pin")
        with self._button:
            where = f'no-parent-event auto-close role="region" aria-label="{TITLE}"'
            with ui.menu().props(where) as self._menu:
                self._list = dressed(ui.element("div"), role="menu", aria_label=TITLE)
        self._button.set_visibility(False)

    def fill(self, reading: Reading) -> None:
        """Show the pulls of now; nothing moves where they are the same."""
        kept = self._desk.state.files
        self._names = {one.file.key: one.about for one in reversed(reading.measured)}
        shown = (tuple(self._names.items()), kept)
        if shown == self._shown:
            return
        self._shown = shown
        self._button.set_visibility(len(self._names) > 1 or bool(self._names.keys() - {*kept}))
        self._list.clear()
        with self._list:
            for key, name in reversed(self._names.items()):
                text = f"✓ {name}" if key in kept else name
                item = ui.menu_item(text, partial(self._panel.pin_file, key))
                dressed(item, f"pull-pin-file-{key}", role="menuitem")

    def _asked(self) -> None:
        if len(self._names) == 1:
            self._panel.pin_file(next(iter(self._names)))
        else:
            self._menu.open()
