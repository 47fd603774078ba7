"""Files dropped anywhere in the window, on any tab; each file's content determines its use."""

import asyncio
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import tomlkit
from nicegui import background_tasks, events, run, ui
from nicegui.elements.upload_files import FileUpload

from layerjam.core.errors import FileError, LayerjamError, count_text
from layerjam.core.toml_files.toml import MAX_BYTES, decode_toml, parse_toml
from layerjam.core.toml_files.writer import dump_toml
from layerjam.core.units import QuantitySpec, build, get_spec, show
from layerjam.laboratory.measure.conditions import LIST, parse_list
from layerjam.laboratory.measure.sidecar import FOLDER, Facts, format_facts, parse_facts
from layerjam.workbench.desk import Desk
from layerjam.workbench.kinds import detect_toml_kind
from layerjam.workbench.session import ENDING, parse_session
from layerjam.workbench.sorting import Sorting
from layerjam.workbench.uploads import (
    LARGEST,
    MAX_FILES,
    UploadError,
    Uploads,
    clean_name,
    is_sidecar,
)
from layerjam.workbench.widgets import button, dress, find_error, hint, one_line

AT_ONCE = 1000
"""Maximum number of files per drop; `Uploads` limits the total."""
SOON = 0.3
"""Files that arrive less than this time [s] after one another count as one drop."""
VEIL = "Drop files here: measurements, a brake or vacuum line (TOML), or a saved session"


class Dropping:
    """The uploader for the whole page, its overlay, and the dialog that follows."""

    def __init__(self, desk: Desk, go: Callable[[str], object]) -> None:
        """`go(page)` opens a page."""
        self.desk, self.uploads, self.go = desk, desk.files, go
        self.sorting = Sorting(desk, go)
        self._soon: asyncio.TimerHandle | None = None
        self._brakes = 0
        self._came_list = False
        self._facts: dict[str, str] = {}
        """{name without .toml: sidecar text} of sidecars named without their files' extensions."""
        ui.context.client.on_delete(self.uploads.close)
        ui.add_body_html(f'<div class="files-veil" aria-hidden="true"><span>{VEIL}</span></div>')
        self.zone = ui.upload(
            multiple=True,
            auto_upload=True,
            max_file_size=LARGEST,
            max_files=AT_ONCE,
            on_upload=self._receive_file,
        )
        dress(self.zone, "files", "files-dropped hidden")
        self.zone.on("rejected", self._on_reject, js_handler="(e) => emit(layerjamRejected(e))")
        self.zone.on("failed", self._on_failure, js_handler="(e) => emit(layerjamFailed(e))")
        self.zone.on("finish", lambda: self.zone.run_method("removeUploadedFiles"))
        desk.add_watcher(lambda _: self._schedule_dialog(), "waiting")
        desk.add_watcher(lambda _: self._open_dialog(empty=True), "choosing")

    def _open_dialog(self, *, empty: bool = False) -> None:
        if not self.zone.client.is_deleted:
            background_tasks.create(self._show_dialog(empty=empty), name="layerjam files")

    async def _receive_file(self, event: events.UploadEventArguments) -> None:
        name = clean_name(event.file.name)
        if is_conditions_list(name):
            problem = await self._store_list(name, event.file)
        elif name.lower().endswith(ENDING):
            problem = await self._open_session(name, event.file)
        elif name.lower().endswith(".toml"):
            problem = await self._load_toml(name, event.file)
        else:
            problem = await self.uploads.receive_file(event.file, waits=True)
        if problem:
            self.sorting.add_sentence(problem)
        self._schedule_dialog()

    async def _store_list(self, name: str, file: FileUpload) -> str:
        """Store a list of conditions for many files; return the reason if it is invalid."""
        try:
            self.uploads.listed = read_conditions_list(await file.read(), name)
        except LayerjamError as err:
            return one_line(err)
        self.uploads.from_list.clear()
        self._came_list = True
        return ""

    async def _open_session(self, name: str, file: FileUpload) -> str:
        try:
            data = await file.read()
            session = await run.io_bound(parse_session, data, name)
            # the program or the tab was closed in the meantime
            if session is None or self.uploads.closed:
                return ""
            state, files = session
            for entry in files:
                try:
                    self.uploads.restore_file(entry.name, entry.data, entry.sidecar)
                except UploadError as err:
                    self.sorting.add_sentence(str(err))
            self.desk.restore_state(state)
        except LayerjamError as err:
            return one_line(err)
        self.desk.announce_files()
        ui.notify(f"{name} was opened; use Undo to go back", type="positive")
        self.go(state.page)
        return ""

    async def _load_toml(self, name: str, file: FileUpload) -> str:
        """Load a brake or a line, or store a sidecar; return the reason if the file is rejected."""
        if file.size() > MAX_BYTES:
            return f"{name}: {file.size() / 1e6:.1f} MB; the limit for a TOML file is 1 MB"
        data = await file.read()
        try:
            text = decode_toml(data, name)
            parse_toml(text, name)
        except FileError as err:
            return str(err)
        kind = detect_toml_kind(text)
        if kind in ("brake", "line"):
            return self._put_on_desk(kind, name, text)
        if is_sidecar(name):
            try:
                self.uploads.store_file(name, data)
            except UploadError as err:
                return str(err)
            self.desk.announce_files()
            return ""
        if kind == "sidecar":
            self._facts[name[: -len(".toml")]] = text
            return ""
        if kind == "specification":
            return f"{name} is a design specification; open it on the Design page"
        return f"{name} contains no field of a brake, vacuum line or NAME.csv.toml sidecar"

    def _put_on_desk(self, kind: str, name: str, text: str) -> str:
        """Put the first brake on the desk, and a second one next to it for comparison."""
        slot = kind
        if kind == "brake":
            if self._brakes == 2:
                return f"{name}: not used, because two brakes were already dropped"
            slot = "beside" if self._brakes else "brake"
        if problem := find_error(self.desk.put_file, slot, text if "\n" in text else f"{text}\n"):
            return f"{name}: {problem}"
        self._brakes += kind == "brake"
        labels = {
            "brake": "the brake",
            "line": "the vacuum line",
            "beside": "compared with the brake",
        }
        ui.notify(f"{name} is now {labels[slot]}; use Undo to go back", type="positive")
        return ""

    def _schedule_dialog(self) -> None:
        """Open the dialog once no more files arrive."""
        if self._soon is not None:
            self._soon.cancel()
        self._soon = asyncio.get_running_loop().call_later(SOON, self._open_dialog)

    async def _show_dialog(self, *, empty: bool = False) -> None:
        self._brakes = 0
        with self.zone.client:
            self._attach_sidecars()
            await self.sorting.show(empty=empty)

    def _attach_sidecars(self) -> None:
        """Attach sidecars whose names lack the file's extension, and the folder's sidecar."""
        files = self.uploads.files
        for stem, text in self._facts.items():
            targets = [f for f in files if Path(f.shown).stem == stem]
            if f"{stem}.toml" == FOLDER:
                targets = [f for f in files if f.key in self.uploads.waiting]
            for file in targets:
                self.uploads.sidecars[file.shown] = merge_sidecars(
                    self.uploads.sidecars.get(file.shown, ""), text
                )
            if not targets:
                self.sorting.add_sentence(
                    f"{stem}.toml describes a test, but no file here is named "
                    f"{stem}; rename it NAME.csv.toml to match the measurement NAME.csv"
                )
        self._facts.clear()
        names, contradictions = attach_conditions(self.uploads)
        for sentence in contradictions:
            self.sorting.add_sentence(sentence)
        if self._came_list:
            self._came_list = False
            lacking = len(self.uploads.listed) - len(names)
            note = f"; still missing: {lacking} of those listed" if lacking else ""
            count = count_text(len(names), "file")
            ui.notify(f"{LIST}: conditions read for {count}{note}", type="positive")
            self.desk.announce_files()

    def _on_reject(self, event: events.GenericEventArguments) -> None:
        *entries, last = event.args
        for cause, name, size in entries:
            if cause == "max-file-size":
                try:
                    self.uploads.check_room(str(name), int(size))
                except UploadError as err:
                    self.sorting.add_sentence(str(err))
            elif cause == "max-files":
                self.sorting.add_sentence(
                    f"{clean_name(str(name))}: not used, because at most {AT_ONCE} files can be "
                    "dropped at once"
                )
            else:
                self.sorting.add_sentence(
                    f"{clean_name(str(name))}: not used, because it is already being uploaded"
                )
        if int(last[2]) > len(entries):
            self.sorting.add_sentence(f"{int(last[2]) - len(entries)} more files were not used")
        self._schedule_dialog()

    def _on_failure(self, event: events.GenericEventArguments) -> None:
        names, status = event.args
        cause = {
            0: "could not be read by the browser; if it is a folder, drop its files instead",
            400: "its name cannot be sent; use a shorter name without special characters",
            413: f"is too large; the limit is {LARGEST // 2**20} MB",
        }.get(int(status), "could not be uploaded; drop it again")
        for name in names:
            self.sorting.add_sentence(f"{clean_name(str(name))}: {cause}")
        self.zone.reset()
        self._schedule_dialog()


class DropHint:
    """Note on a page that files can be dropped, with buttons to choose and to accept files."""

    def __init__(self, desk: Desk, page: str) -> None:
        self.desk = desk
        with dress(ui.column(), f"{page}-drop", "files-here w-full gap-2"):
            ui.label("Drop files anywhere in this window").classes("font-medium")
            hint(
                "CSV, TSV, TXT, TRA, XLSX, ODS, and NAME.csv.toml sidecars, many at "
                f"once. Up to {MAX_FILES} files of {LARGEST // 2**20} MB. They stay on "
                "this computer. Every page can use them, even after a reload. They are "
                "deleted when you close the browser tab, and links do not include "
                "them."
            )
            choose = button("Choose files", None, f"{page}-choose", "folder_open")
            choose.on("click", js_handler="() => layerjamPick()")
            look = "unelevated dense no-caps color=primary"
            show = partial(desk.notify_watchers, "waiting")
            self._waiting = button("", show, f"{page}-waiting", "help_outline", look=look)
        desk.add_watcher(lambda _: self.update_count(), "files", "settings", "undo")
        self.update_count()

    def update_count(self) -> None:
        """Show the number of files that are waiting to be accepted."""
        count = len(self.desk.files.waiting)
        self._waiting.set_text(f"{count_text(count, 'file')} to sort: view the proposals")
        self._waiting.set_visibility(count > 0)


def is_conditions_list(name: str) -> bool:
    """Return whether a file has the name that the commands expect of a list of conditions."""
    return clean_name(name).lower() == LIST


def read_conditions_list(data: bytes, name: str) -> dict[str, str]:
    """Return {file name: its conditions as sidecar text} from a list of conditions.

    Raises FileError, with the line number, if the list is invalid.
    """
    if len(data) > MAX_BYTES:
        raise FileError(name, f"is larger than {MAX_BYTES // 1000} kB, the limit for such a list")
    entries = parse_list(decode_toml(data, name), name)
    return {clean_name(k): format_facts(build(Facts, values)) for k, values in entries.items()}


def attach_conditions(uploads: Uploads) -> tuple[list[str], list[str]]:
    """Complete sidecars from the list; return (names of listed files, contradictions).

    If the sidecar and the list state the same entry, the sidecar takes precedence and a notice
    reports this; the commands reject such a conflict. The list is kept for files that arrive later.
    """
    names, notes = [], []
    for file in uploads.files:
        of_list = uploads.listed.get(file.shown)
        if of_list is None:
            continue
        names.append(file.shown)
        if file.shown in uploads.from_list:
            continue
        text = uploads.sidecars.get(file.shown, "")
        list_values, values = parse_facts(of_list, LIST), _sidecar_values(text)
        for key in list_values.keys() & values.keys():
            if list_values[key] != values[key]:
                notes.append(
                    f"{file.shown}: its sidecar states {key.replace('_', ' ')} "
                    f"{_fact_text(key, values[key])}, but {LIST} states "
                    f"{_fact_text(key, list_values[key])}; the sidecar takes precedence"
                )
        uploads.from_list[file.shown] = frozenset(list_values.keys() - values.keys())
        uploads.sidecars[file.shown] = merge_sidecars(text, of_list)
    return names, notes


def merge_sidecars(text: str, of_all: str) -> str:
    """Return a sidecar's text, with the entries that only `of_all` contains added to it."""
    try:
        document, addition = tomlkit.parse(text), tomlkit.parse(of_all)
    except tomlkit.exceptions.TOMLKitError:
        return text or of_all
    for key, value in addition.items():
        if key not in document:
            document[key] = value
    return dump_toml(document, text)


def _sidecar_values(text: str) -> dict[str, Any]:
    """Return the values of a sidecar; empty if it is invalid, because its reader reports that."""
    try:
        return parse_facts(text, "the sidecar")
    except LayerjamError:
        return {}


def _fact_text(key: str, value: Any) -> str:
    spec = get_spec(Facts, key)
    return show(value, spec.unit) if isinstance(spec, QuantitySpec) else f"'{value}'"
