"""Measured pulls on the page Pull: dropped in, understood, held against the brake."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from nicegui import events, ui

from layerjam.commands.answer import Answer
from layerjam.identify.provenance import renamed
from layerjam.identify.validation.metrics import CurveError
from layerjam.units import show
from layerjam.workbench import live
from layerjam.workbench.call import Call, DataFile, Subject
from layerjam.workbench.page import answered
from layerjam.workbench.tables import html
from layerjam.workbench.uploads import LARGEST, Refused, Uploads, sidecar_of


@dataclass(frozen=True)
class Reading:
    """What the files say (`pull`) and how the brake compares (`validate`), or why not."""

    files: tuple[DataFile, ...] = ()
    calls: tuple[Call, ...] = ()
    understood: Answer | None = None
    compared: Answer | None = None
    problem: str = ""
    lacking: bool = False
    """Whether a file does not say at which vacuum it was pulled."""

    def named(self, text: str) -> str:
        """A sentence with the user's names of the files."""
        return in_users_names(text, self.files)

    @property
    def curves(self) -> Sequence[CurveError]:
        """The pulls compared; empty where there are none."""
        return () if self.compared is None else self.compared.record[1].curves


def laid_out(uploads: Uploads) -> tuple[DataFile, ...]:
    """The measurements as a call takes them, their sidecars written beside them."""
    files = tuple(DataFile(f.name, f.path) for f in list(uploads.files))
    given = dict(uploads.sidecars)
    for file in files:
        if file.shown in given:
            sidecar_of(file.path).write_text(given[file.shown], encoding="utf-8")
    return files


def in_users_names(text: str, files: Sequence[DataFile]) -> str:
    """A sentence of a verb with the user's names where it has our paths."""
    made: str = renamed(text, {file.path.name: file.shown for file in files})
    return made


def read(
    files: tuple[DataFile, ...], brake: Subject, vacuum: str, tell: Callable[[str, float], None]
) -> Reading:
    """Both verbs on the files; refusals as words, in the user's names."""
    if not files:
        return Reading()
    pull = Call("pull", files=files)
    understood, problem = answered(pull, progress=tell)
    if understood is None:
        return Reading(files, (pull,), problem=in_users_names(problem, files))
    lacking = any(row["vacuum"] is None for row in understood.pulls)
    validate = Call("validate", (brake,), {"vacuum": vacuum} if lacking else {}, files)
    compared, problem = answered(validate, progress=tell)
    return Reading(
        files, (pull, validate), understood, compared, in_users_names(problem, files), lacking
    )


class Measured:
    """The drop area, the files with what was understood of them, and the errors of the model."""

    def __init__(self, uploads: Uploads, changed: Callable[[], None]) -> None:
        self.uploads, self._changed = uploads, changed
        self._shown: Reading | None = None
        self._said = ""
        label = "Drop measured pulls here"
        self.area = (
            ui.upload(
                multiple=True, max_file_size=LARGEST, label=label, auto_upload=True,
                on_multi_upload=self._came,
                on_rejected=lambda: self._say(f"a file has at most {LARGEST // 2**20} MB"),
            )
            .props(f'flat bordered aria-label="{label}" data-testid="pull-drop"')
            .classes("w-full")
        )  # fmt: skip
        ui.label(
            "Exports of a test machine, with NAME.csv.toml beside NAME.csv if there is one. They "
            "stay on this machine and are not in the link."
        ).classes("text-xs opacity-80")
        self._trouble = ui.label().classes("text-negative text-sm").props(
            'role="alert" data-testid="pull-file-problem"'
        )  # fmt: skip
        self._trouble.set_visibility(False)
        self.list = ui.column().classes("w-full gap-1").props('data-testid="pull-files"')

    async def _came(self, event: events.MultiUploadEventArguments) -> None:
        trouble = []
        for file in event.files:
            try:
                self.uploads.room(file.name, file.size())
                self.uploads.take(file.name, await file.read())
            except Refused as err:
                trouble.append(str(err))
        self.area.reset()
        self._said = "; ".join(trouble)
        self._say(self._said)
        self._changed()

    def _say(self, words: str) -> None:
        self._trouble.set_text(words)
        self._trouble.set_visibility(bool(words))

    def _remove(self, shown: str) -> None:
        self.uploads.remove(f.key for f in self.uploads.files if f.name == shown)
        self._said = ""
        self._say("")
        self._changed()

    def fill(self, reading: Reading) -> None:
        """Show what was made of the files."""
        if reading is self._shown:
            return
        self._shown = reading
        self.list.clear()
        self._say("; ".join(words for words in (self._said, reading.problem) if words))
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
            ui.button(icon="close", on_click=lambda: self._remove(shown)).props(
                f'flat round dense size=sm aria-label="Take {_attribute(shown)} away" '
                'data-testid="pull-file-remove"'
            )
        for sentence in self._sentences(shown, reading):
            ui.label(sentence).classes("text-xs opacity-80")

    def _sentences(self, shown: str, reading: Reading) -> list[str]:
        """What was understood of one file, or why it was refused."""
        if reading.understood is None:
            return []
        said = [
            f"not used: {reading.named(why)}"
            for answer in (reading.understood, reading.compared)
            for path, why in (answer.refused.items() if answer is not None else ())
            if reading.named(path).startswith(shown)
        ]
        for path, sentences in reading.understood.understood.items():
            if reading.named(path).split(", specimen ")[0] == shown:
                said.append("; ".join(sentences))
        return list(dict.fromkeys(said))


def _attribute(text: str) -> str:
    return "".join(c for c in text if c.isalnum() or c in " ._-")


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
        answer = reading.compared
        if answer is None:
            return
        with self.box:
            ui.label(
                "Each file against the model at the vacuum of that file (dashed); below the curve "
                "what is left over, measured less model, over the part that is compared."
            ).classes("text-sm opacity-80")
            heads = ["File", "Vacuum", "Speed", "MAPE", "RMSE", "Model − measured"]
            rows = [
                [
                    reading.named(row["path"]), show(row["vacuum"], "Pa"),
                    show(row["speed"], "m/s", 3), f"{row['mape']:.2%}", show(row["rmse"], "N", 3),
                    show(row["bias"], "N", 3).replace("-", "−"),
                ] for row in answer.files
            ]  # fmt: skip
            live.Table().set_content(
                html(heads, rows, (1, 2, 3, 4, 5), "What is left over", "pull-errors")
            )
            for check in answer.checks:
                mark = "✓" if check["passed"] else "look:"
                ui.label(f"{mark} {check['name']}: {check['sentence']}").classes("text-sm")
            for sentence in dict.fromkeys(answer.warnings):
                ui.label(f"Note: {reading.named(sentence)}").classes("text-sm opacity-80")
