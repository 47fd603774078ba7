"""Files dropped anywhere in the window, on any tab: each goes where its content belongs."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tomlkit
from nicegui import background_tasks, events, run, ui
from nicegui.elements.upload_files import FileUpload

from layerjam.errors import FileError, LayerjamError
from layerjam.measure.conditions import LIST, parse_list
from layerjam.measure.sidecar import FOLDER, Facts, facts_text, values_of
from layerjam.records.toml import MAX_BYTES
from layerjam.units import QuantitySpec, build, show, spec_of
from layerjam.workbench.desk import Desk
from layerjam.workbench.kinds import toml_kind
from layerjam.workbench.session import ENDING, from_session
from layerjam.workbench.sorting import Sorting
from layerjam.workbench.uploads import LARGEST, MOST, Refused, Uploads, clean, is_sidecar
from layerjam.workbench.widgets import button, dressed, hint, one_line

AT_ONCE = 1000
"""Files that the browser offers in one go at most; what is kept is bounded by uploads."""
SOON = 0.3
"""Files that arrive within this time [s] of each other belong together."""
VEIL = "Drop here: measurements, a brake or a vacuum line as TOML, a saved session"


class Dropping:
    """The uploader of the whole page, the veil over it, and the dialog after it."""

    def __init__(self, desk: Desk, go: Callable[[str], object]) -> None:
        """`go(page)` opens a page."""
        self.desk, self.uploads, self.go = desk, desk.files, go
        self.sorting = Sorting(desk, go)
        self._soon: asyncio.TimerHandle | None = None
        self._brakes = 0
        self._came_list = False
        self._facts: dict[str, str] = {}
        """{name without .toml: sidecar that does not say of which file by its full name}."""
        ui.context.client.on_delete(self.uploads.close)
        ui.add_body_html(f'<div class="files-veil" aria-hidden="true"><span>{VEIL}</span></div>')
        self.zone = ui.upload(
            multiple=True,
            auto_upload=True,
            max_file_size=LARGEST,
            max_files=AT_ONCE,
            on_upload=self._take,
        )
        dressed(self.zone, "files", "files-dropped hidden")
        self.zone.on("rejected", self._rejected, js_handler="(e) => emit(layerjamRejected(e))")
        self.zone.on("failed", self._failed, js_handler="(e) => emit(layerjamFailed(e))")
        self.zone.on("finish", lambda: self.zone.run_method("removeUploadedFiles"))
        desk.watch(self._asked)

    def _asked(self, what: str) -> None:
        if what == "waiting":
            self._look()
        elif what == "choosing":
            background_tasks.create(self._sort(empty=True), name="layerjam files")

    async def _take(self, event: events.UploadEventArguments) -> None:
        name = clean(event.file.name)
        if is_list(name):
            why = await self._list(name, event.file)
        elif name.lower().endswith(ENDING):
            why = await self._session(name, event.file)
        elif name.lower().endswith(".toml"):
            why = await self._toml(name, event.file)
        else:
            why = await self._measured(event.file)
        if why:
            self.sorting.tell(why)
        self._look()

    async def _measured(self, file: FileUpload) -> str:
        return await self.uploads.receive(file, waits=True)

    async def _list(self, name: str, file: FileUpload) -> str:
        """Keep what a list says of many files; why not, where it is none."""
        try:
            self.uploads.listed = read_list(await file.read(), name)
        except LayerjamError as err:
            return one_line(err)
        self.uploads.from_list.clear()
        self._came_list = True
        return ""

    async def _session(self, name: str, file: FileUpload) -> str:
        """Put all that a saved session holds onto the desk; why not, where it is none."""
        try:
            data = await file.read()
            opened = await run.io_bound(from_session, data, name)
            if opened is None or self.uploads.closed:  # the program or the tab was ended meanwhile
                return ""
            state, files = opened
            for one in files:
                try:
                    self.uploads.bring(one.name, one.data, one.sidecar)
                except Refused as err:
                    self.sorting.tell(str(err))
            self.desk.put_state(state)
        except LayerjamError as err:
            return one_line(err)
        self.desk.files_changed()
        ui.notify(f"{name} was opened; undo takes it back", type="positive")
        self.go(state.page)
        return ""

    async def _toml(self, name: str, file: FileUpload) -> str:
        """Put a brake or a line on the desk, keep a sidecar; why not, where it is neither."""
        if file.size() > MAX_BYTES:
            return f"{name}: {file.size() / 1e6:.1f} MB is too large for a TOML file; 1 MB is read"
        data = await file.read()
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            return f"{name}: is no text in UTF-8, so it is no TOML file"
        kind = toml_kind(text)
        if kind in ("brake", "line"):
            return self._onto_desk(kind, name, text)
        if is_sidecar(name):
            try:
                self.uploads.take(name, data)
            except Refused as err:
                return str(err)
            self.desk.files_changed()
            return ""
        if kind == "sidecar":
            self._facts[name[: -len(".toml")]] = text
            return ""
        if kind == "specification":
            return f"{name}: is a design's specification; open it on the page Design"
        return f"{name}: has no key of a brake, a vacuum line or a sidecar NAME.csv.toml"

    def _onto_desk(self, kind: str, name: str, text: str) -> str:
        """The first brake is the one on the desk, a second one stands beside it."""
        what = kind
        if kind == "brake":
            if self._brakes == 2:
                return f"{name}: not taken, two brakes were dropped before it"
            what = "beside" if self._brakes else "brake"
        try:
            self.desk.put_file(what, text if "\n" in text else f"{text}\n")
        except LayerjamError as err:
            return f"{name}: {one_line(err)}"
        self._brakes += kind == "brake"
        now = {"brake": "the brake", "line": "the vacuum line", "beside": "compared with the brake"}
        ui.notify(f"{name} is now {now[what]}; undo takes it back", type="positive")
        return ""

    def _look(self) -> None:
        """Open the dialog once no more files come."""
        if self._soon is not None:
            self._soon.cancel()
        loop, client = asyncio.get_running_loop(), self.zone.client

        def open_it() -> None:
            if not client.is_deleted:
                background_tasks.create(self._sort(), name="layerjam files")

        self._soon = loop.call_later(SOON, open_it)

    async def _sort(self, *, empty: bool = False) -> None:
        self._brakes = 0
        with self.zone.client:
            self._attach()
            await self.sorting.show(empty=empty)

    def _attach(self) -> None:
        """Sidecars called after a file without its ending, and the one of the whole folder."""
        files = self.uploads.files
        for stem, text in self._facts.items():
            own = [f for f in files if Path(f.shown).stem == stem]
            if f"{stem}.toml" == FOLDER:
                own = [f for f in files if f.key in self.uploads.waiting]
            for one in own:
                self.uploads.sidecars[one.shown] = over(
                    self.uploads.sidecars.get(one.shown, ""), text
                )
            if not own:
                self.sorting.tell(
                    f"{stem}.toml: says what holds of a test, but no file here is called "
                    f"{stem}; call it NAME.csv.toml after the file NAME.csv"
                )
        self._facts.clear()
        taken, contradictions = attach(self.uploads)
        for sentence in contradictions:
            self.sorting.tell(sentence)
        if self._came_list:
            self._came_list = False
            lacking = len(self.uploads.listed) - len(taken)
            more = f"; {lacking} that it lists are not here yet" if lacking else ""
            many = "1 file" if len(taken) == 1 else f"{len(taken)} files"
            ui.notify(f"{LIST}: read for {many}{more}", type="positive")
            self.desk.files_changed()

    def _rejected(self, event: events.GenericEventArguments) -> None:
        *entries, last = event.args
        for why, name, size in entries:
            if why == "max-file-size":
                try:
                    self.uploads.room(str(name), int(size))
                except Refused as err:
                    self.sorting.tell(str(err))
            elif why == "max-files":
                self.sorting.tell(f"{clean(str(name))}: not taken, more than {AT_ONCE} at once")
            else:
                self.sorting.tell(f"{clean(str(name))}: not taken, it is being sent already")
        if int(last[2]) > len(entries):
            self.sorting.tell(f"{int(last[2]) - len(entries)} more were not taken")
        self._look()

    def _failed(self, event: events.GenericEventArguments) -> None:
        names, status = event.args
        why = {
            0: "could not be read by the browser; if it is a folder, drop the files in it",
            400: "its name cannot be sent; give it a shorter, plainer one",
            413: f"is too large: {LARGEST // 2**20} MB are the most",
        }.get(int(status), "could not be sent; drop it again")
        for name in names:
            self.sorting.tell(f"{clean(str(name))}: {why}")
        self.zone.reset()
        self._look()


class FilesHere:
    """On a page: that files can be dropped, a button to choose them, and those that wait."""

    def __init__(self, desk: Desk, page: str) -> None:
        self.desk = desk
        with dressed(ui.column(), f"{page}-drop", "files-here w-full gap-2"):
            ui.label("Drop files anywhere in this window").classes("font-medium")
            hint(
                "CSV, TSV, TXT, TRA, XLSX, ODS, and sidecars NAME.csv.toml, many at once. Up to "
                f"{MOST} files of {LARGEST // 2**20} MB; they stay on this computer, are known on "
                "every page and after a reload, are deleted when the browser's tab is closed, and "
                "are not in the link."
            )
            choose = button("Choose files", None, f"{page}-choose", "folder_open")
            choose.on("click", js_handler="() => layerjamPick()")
            how = "unelevated dense no-caps color=primary"
            self._waiting = button("", desk.ask_files, f"{page}-waiting", "help_outline", how=how)
        desk.watch(lambda what: self.fill() if what in ("files", "settings", "undo") else None)
        self.fill()

    def fill(self) -> None:
        """How many files wait to be accepted."""
        count = len(self.desk.files.waiting)
        many = "1 file waits" if count == 1 else f"{count} files wait"
        self._waiting.set_text(f"{many}: see what is proposed")
        self._waiting.set_visibility(count > 0)


def is_list(name: str) -> bool:
    """Whether a file is called as the commands look for it."""
    return clean(name).lower() == LIST


def read_list(data: bytes, name: str) -> dict[str, str]:
    """{file's name: its conditions as a sidecar's text} of a list.

    Raises FileError, with the line, for what is none.
    """
    if len(data) > MAX_BYTES:
        raise FileError(name, f"is larger than {MAX_BYTES // 1000} kB, too large for such a list")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FileError(name, "is no text in UTF-8") from None
    found = parse_list(text, name)
    return {clean(file): facts_text(build(Facts, said)) for file, said in found.items()}


def attach(uploads: Uploads) -> tuple[list[str], list[str]]:
    """(names of the files that the list speaks of, contradictions), their sidecars completed.

    A file's own sidecar counts where both say something; the commands refuse that, and here a
    sentence says it. What the list says stays known for files that come later.
    """
    taken, told = [], []
    for one in uploads.files:
        of_list = uploads.listed.get(one.shown)
        if of_list is None:
            continue
        taken.append(one.shown)
        if one.shown in uploads.from_list:
            continue
        own = uploads.sidecars.get(one.shown, "")
        said, stated = values_of(of_list, LIST), _stated(own)
        for key in said.keys() & stated.keys():
            if said[key] != stated[key]:
                told.append(
                    f"{one.shown}: its sidecar states {key.replace('_', ' ')} "
                    f"{_text(key, stated[key])}, {LIST} {_text(key, said[key])}; the sidecar counts"
                )
        uploads.from_list[one.shown] = frozenset(said.keys() - stated.keys())
        uploads.sidecars[one.shown] = over(own, of_list)
    return taken, told


def over(own: str, of_all: str) -> str:
    """A sidecar's text with what another one says besides; its own words count."""
    try:
        document, more = tomlkit.parse(own), tomlkit.parse(of_all)
    except tomlkit.exceptions.TOMLKitError:
        return own or of_all
    for key, value in more.items():
        if key not in document:
            document[key] = value
    return tomlkit.dumps(document)


def _stated(own: str) -> dict[str, Any]:
    """What a sidecar states; nothing where it is refused, which is said where it is read."""
    try:
        return values_of(own, "the sidecar")
    except LayerjamError:
        return {}


def _text(key: str, value: Any) -> str:
    spec = spec_of(Facts, key)
    return show(value, spec.unit) if isinstance(spec, QuantitySpec) else f"'{value}'"
