"""Measured pulls on the page Pull: dropped in, understood, held against the brake."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from nicegui import events, ui

from layerjam.identify.provenance import renamed
from layerjam.identify.validation.metrics import CurveError
from layerjam.units import show
from layerjam.workbench import live
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.page import Box, Notes, answered, checks
from layerjam.workbench.tables import html
from layerjam.workbench.uploads import LARGEST, Upload, Uploads
from layerjam.workbench.widgets import Alert, button, dressed, hint, zone


@dataclass(frozen=True)
class Reading:
    """What the files say (`pull`) and how the brake compares (`validate`), or why not."""

    files: tuple[Upload, ...] = ()
    calls: tuple[Call, ...] = ()
    understood: Any = None
    compared: Any = None
    problem: str = ""
    lacking: bool = False
    """Whether a file does not say at which vacuum it was pulled."""

    def named(self, path: str) -> str:
        """The user's name of a file."""
        made: str = renamed(path, {file.path.name: file.shown for file in self.files})
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

    @property
    def curves(self) -> Sequence[CurveError]:
        """The pulls compared; empty where there are none."""
        return () if self.compared is None else self.compared.record[1].curves


def laid_out(uploads: Uploads) -> tuple[Upload, ...]:
    """The measurements as a call takes them, their sidecars written beside them."""
    given = dict(uploads.sidecars)
    return tuple(uploads.with_sidecar(f, given.get(f.shown, "")) for f in list(uploads.files))


def read(
    files: tuple[Upload, ...], brake: Subject, vacuum: str, tell: Callable[[str, float], None]
) -> Reading:
    """Both commands on the files; refusals as words, in the user's names."""
    if not files:
        return Reading()
    pull = Call("pull", files=files)
    understood, problem = answered(pull, progress=tell)
    if understood is None:
        return Reading(files, (pull,), problem=problem)
    lacking = any(row["vacuum"] is None for row in understood.pulls)
    validate = Call("validate", (brake,), {"vacuum": vacuum} if lacking else {}, files)
    compared, problem = answered(validate, progress=tell)
    return Reading(files, (pull, validate), understood, compared, problem, lacking)


class Measured:
    """The drop area, and the files with what was understood of them."""

    def __init__(self, uploads: Uploads, changed: Callable[[], None]) -> None:
        self.uploads, self._changed = uploads, changed
        self._said = ""
        self._trouble = Alert("pull-file-problem", "text-sm")
        label = "Drop measured pulls here"
        area = ui.upload(
            multiple=True,
            max_file_size=LARGEST,
            auto_upload=True,
            on_multi_upload=self._came,
            on_rejected=lambda: self._trouble.say(f"a file has at most {LARGEST // 2**20} MB"),
        )
        self.area = zone(area, label, "pull-drop")
        ui.label(
            "Exports of a test machine, with NAME.csv.toml beside NAME.csv if there is one. They "
            "stay on this machine and are not in the link."
        ).classes("text-xs opacity-80")
        self.list = dressed(Box(self._show), "pull-files")

    async def _came(self, event: events.MultiUploadEventArguments) -> None:
        refused = [await self.uploads.receive(file) for file in event.files]
        self.area.reset()
        self._said = "; ".join(filter(None, refused))
        self._trouble.say(self._said)
        self._changed()

    def _remove(self, key: str) -> None:
        self.uploads.remove([key])
        self._said = ""
        self._trouble.say("")
        self._changed()

    def fill(self, reading: Reading) -> None:
        """Show what was made of the files."""
        if self.list.fill(reading):
            self._trouble.say("; ".join(filter(None, (self._said, reading.problem))))

    def _show(self, reading: Reading) -> None:
        for file in reading.files:
            with ui.row().classes("w-full items-center justify-between no-wrap gap-1"):
                ui.label(file.shown).classes("text-sm font-medium").style("overflow-wrap: anywhere")
                look, gone = "flat round dense size=sm", partial(self._remove, file.key)
                away = button("", gone, "pull-file-remove", "close", how=look)
                dressed(away, aria_label=f"Take {file.shown} away")
            for sentence in reading.sentences(file.shown):
                ui.label(sentence).classes("text-xs opacity-80")
        for name in sorted({*self.uploads.sidecars} - {f.shown for f in reading.files}):
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
