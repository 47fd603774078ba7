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
from layerjam.workbench.call import Call, DataFile, Subject
from layerjam.workbench.page import Notes, answered, checks
from layerjam.workbench.tables import html
from layerjam.workbench.uploads import LARGEST, Uploads
from layerjam.workbench.widgets import Alert, button, dressed, hint


@dataclass(frozen=True)
class Reading:
    """What the files say (`pull`) and how the brake compares (`validate`), or why not."""

    files: tuple[DataFile, ...] = ()
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

    @property
    def curves(self) -> Sequence[CurveError]:
        """The pulls compared; empty where there are none."""
        return () if self.compared is None else self.compared.record[1].curves


def laid_out(uploads: Uploads) -> tuple[DataFile, ...]:
    """The measurements as a call takes them, their sidecars written beside them."""
    given = dict(uploads.sidecars)
    return tuple(uploads.with_sidecar(f, given.get(f.shown, "")) for f in list(uploads.files))


def read(
    files: tuple[DataFile, ...], brake: Subject, vacuum: str, tell: Callable[[str, float], None]
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
    """The drop area, the files with what was understood of them, and the errors of the model."""

    def __init__(self, uploads: Uploads, changed: Callable[[], None]) -> None:
        self.uploads, self._changed = uploads, changed
        self._shown: Reading | None = None
        self._said = ""
        self._trouble = Alert("pull-file-problem", "text-sm")
        label = "Drop measured pulls here"
        area = ui.upload(
            multiple=True,
            max_file_size=LARGEST,
            label=label,
            auto_upload=True,
            on_multi_upload=self._came,
            on_rejected=lambda: self._trouble.say(f"a file has at most {LARGEST // 2**20} MB"),
        )
        self.area = dressed(area, "pull-drop", "w-full", "flat bordered", aria_label=label)
        ui.label(
            "Exports of a test machine, with NAME.csv.toml beside NAME.csv if there is one. They "
            "stay on this machine and are not in the link."
        ).classes("text-xs opacity-80")
        self.list = dressed(ui.column(), "pull-files", "w-full gap-1")

    async def _came(self, event: events.MultiUploadEventArguments) -> None:
        refused = [await self.uploads.receive(file) for file in event.files]
        self.area.reset()
        self._said = "; ".join(filter(None, refused))
        self._trouble.say(self._said)
        self._changed()

    def _remove(self, shown: str) -> None:
        self.uploads.remove(f.key for f in self.uploads.files if f.shown == shown)
        self._said = ""
        self._trouble.say("")
        self._changed()

    def fill(self, reading: Reading) -> None:
        """Show what was made of the files."""
        if reading is self._shown:
            return
        self._shown = reading
        self.list.clear()
        self._trouble.say("; ".join(filter(None, (self._said, reading.problem))))
        with self.list:
            for file in reading.files:
                self._file(file.shown, reading)
            for shown in self._alone(reading):
                ui.label(f"{shown}.toml waits for {shown}").classes("text-xs opacity-80")

    def _alone(self, reading: Reading) -> list[str]:
        """Sidecars whose measurement was not dropped."""
        return sorted({*self.uploads.sidecars} - {f.shown for f in reading.files})

    def _file(self, shown: str, reading: Reading) -> None:
        with ui.row().classes("w-full items-center justify-between no-wrap gap-1"):
            ui.label(shown).classes("text-sm font-medium").style("overflow-wrap: anywhere")
            look, gone = "flat round dense size=sm", partial(self._remove, shown)
            away = button("", gone, "pull-file-remove", "close", how=look)
            dressed(away, aria_label=f"Take {shown} away")
        for sentence in self._sentences(shown, reading):
            ui.label(sentence).classes("text-xs opacity-80")

    def _sentences(self, shown: str, reading: Reading) -> list[str]:
        """What was understood of one file, or why it was refused."""
        if reading.understood is None:
            return []
        said = [
            f"not used: {why}"
            for result in (reading.understood, reading.compared)
            for path, why in (result.refused.items() if result is not None else ())
            if path.startswith(shown)
        ]
        for path, sentences in reading.understood.understood.items():
            if path.split(", specimen ")[0] == shown:
                said.append("; ".join(sentences))
        return list(dict.fromkeys(said))


class Errors:
    """MAPE, RMSE and bias of every pull, and what the checks say."""

    def __init__(self) -> None:
        self.box = ui.column().classes("w-full gap-1 overflow-auto")
        self._shown: Reading | None = None

    def fill(self, reading: Reading) -> None:
        """Show them, nothing without files."""
        if reading is self._shown:
            return
        self._shown = reading
        self.box.clear()
        if reading.compared is None:
            return
        with self.box:
            hint(
                "Each file against the model at the vacuum of that file (dashed); below the curve "
                "what is left over, measured less model, over the part that is compared."
            )
            self._rows(reading.compared.files)
            checks(reading.compared)
            Notes().fill(list(dict.fromkeys(reading.compared.warnings)))

    def _rows(self, files: Sequence[Any]) -> None:
        heads = ["File", "Vacuum", "Speed", "MAPE", "RMSE", "Model − measured"]
        rows = []
        for row in files:
            vacuum, speed = show(row["vacuum"], "Pa"), show(row["speed"], "m/s", 3)
            error, bias = show(row["rmse"], "N", 3), show(row["bias"], "N", 3)
            mape, bias = f"{row['mape']:.2%}", bias.replace("-", "−")
            rows.append([row["path"], vacuum, speed, mape, error, bias])
        made = html(heads, rows, range(1, 6), "What is left over", "pull-errors")
        live.Table().set_content(made)
