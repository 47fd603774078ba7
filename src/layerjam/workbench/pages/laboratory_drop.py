"""Where files are dropped, what is said of those not taken, and practice files made here."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from nicegui import events, ui

from layerjam.measure.sidecar import SIDECAR_ENDING
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.uploads import LARGEST, MOST, Refused, Uploads, clean
from layerjam.workbench.widgets import button, dressed, hint, zone

AT_ONCE = 1000
"""Files that the browser offers in one go at most; what is kept is bounded by uploads."""
SENTENCES = 5
"""Of what was not taken, that are shown."""


class Dropped:
    """The drop zone and the sentences below it."""

    def __init__(self, uploads: Uploads, arrived: Callable[[], None]) -> None:
        """`arrived` is called when a file was taken."""
        self.uploads, self._arrived = uploads, arrived
        self._said: list[str] = []
        self.zone = ui.upload(
            multiple=True,
            auto_upload=True,
            max_file_size=LARGEST,
            max_files=AT_ONCE,
            on_upload=self._take,
        )
        zone(self.zone, "Drop measured files here", "laboratory-drop", "files-dropped")
        with self.zone.add_slot("list"):
            hint(
                "CSV, TSV, TXT, TRA, XLSX, ODS, and sidecars NAME.csv.toml, many at once. Up to "
                f"{MOST} files of {LARGEST // 2**20} MB; they stay on this computer, are deleted "
                "when the tab is closed, and are not part of the link."
            )
        self.zone.on("rejected", self._rejected, js_handler="(e) => emit(layerjamRejected(e))")
        self.zone.on("failed", self._failed, js_handler="(e) => emit(layerjamFailed(e))")
        self.zone.on("finish", lambda: self.zone.run_method("removeUploadedFiles"))
        pick = f"() => getElement({self.zone.id}).$refs.qRef.pickFiles()"
        choose = button("Choose files", None, "laboratory-choose", "folder_open")
        choose.on("click", js_handler=pick)
        self.box = dressed(ui.column(), "laboratory-told", "gap-1 w-full", role="status")
        ui.run_javascript(f"layerjamZone = {self.zone.id}")

    async def _take(self, event: events.UploadEventArguments) -> None:
        why = await self.uploads.receive(event.file)
        if why:
            self.say(why)
        else:
            self._arrived()

    def _rejected(self, event: events.GenericEventArguments) -> None:
        *entries, last = event.args
        for why, name, size in entries:
            if why == "max-file-size":
                try:
                    self.uploads.room(str(name), int(size))
                except Refused as err:
                    self.say(str(err))
            elif why == "max-files":
                self.say(f"{clean(str(name))}: not taken, more than {AT_ONCE} at once")
            else:
                self.say(f"{clean(str(name))}: not taken, it is being sent already")
        if int(last[2]) > len(entries):
            self.say(f"{int(last[2]) - len(entries)} more were not taken")

    def _failed(self, event: events.GenericEventArguments) -> None:
        names, status = event.args
        why = {
            0: "could not be read by the browser; if it is a folder, drop the files in it",
            400: "its name cannot be sent; give it a shorter, plainer one",
            413: f"is too large: {LARGEST // 2**20} MB are the most",
        }.get(int(status), "could not be sent; drop it again")
        for name in names:
            self.say(f"{clean(str(name))}: {why}")
        self.zone.reset()

    def say(self, sentence: str) -> None:
        """One more sentence of what was not taken."""
        self._said.append(sentence)
        shown = self._said[-SENTENCES:]
        self.box.clear()
        with self.box:
            if len(self._said) > len(shown):
                ui.label(f"{len(self._said) - len(shown)} more were not taken, and:")
            for one in shown:
                ui.label(one).classes("text-sm text-negative break-words")
            button("Dismiss", self._forget, "laboratory-dismiss", how="flat dense no-caps")

    def _forget(self) -> None:
        self._said.clear()
        self.box.clear()


def practice_files(folder: Path, tell: Callable[[str, float], None]) -> dict[str, bytes]:
    """Files of the built-in campaign of the virtual laboratory with their sidecars, by name."""
    place = folder / "practice"
    shutil.rmtree(place, ignore_errors=True)
    try:
        made = Call("lab", (Subject("practice"),)).run(out=place, progress=tell)
        found = {}
        for path in map(Path, made.files):
            for one in (path, path.with_name(path.name + SIDECAR_ENDING)):
                if one.exists():
                    found[one.name] = one.read_bytes()
        return found
    finally:
        shutil.rmtree(place, ignore_errors=True)
