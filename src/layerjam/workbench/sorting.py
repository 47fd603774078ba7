"""The dialog "What you dropped": a row a file with what is proposed, accepted by one click."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nicegui import run, ui

from layerjam.errors import LayerjamError
from layerjam.identify.provenance import rename_files
from layerjam.measure.conditions import LIST
from layerjam.measure.preview import Preview, preview
from layerjam.workbench.columns import ColumnTable
from layerjam.workbench.controls import with_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.proposals import (
    ASIDE,
    CLICKS,
    FACTS,
    FRICTION,
    NEEDED,
    Proposal,
    Said,
    proposal,
    together,
)
from layerjam.workbench.said import (
    ROLES,
    UNITS,
    check_edit,
    column_said,
    edits_of,
    negative_of,
    put_edits,
    sidecar_text,
    sign_turned,
)
from layerjam.workbench.spoken import on_page
from layerjam.workbench.tables import html
from layerjam.workbench.uploads import Upload
from layerjam.workbench.widgets import (
    Alert,
    button,
    dressed,
    field,
    heading,
    hint,
    one_line,
    select,
)

WHOLE = 12
"""Files that have fields of their own; the others stand in a table."""
SIDECAR = "its sidecar"
STATED = ("its sidecar", LIST, "the file's head")
"""Sources that the readers take by themselves."""
SOURCE = "dropped-source"
WORDS = {"vacuum": "Vacuum", "normal_force": "Normal force", "speed": "Crosshead speed"}
ASKED = {
    "vacuum": "Type the vacuum of this pull.",
    "normal_force": "Type the force that pressed the films together.",
}
DROPPED, YOURS = "What you dropped", "Your files"
EXPORTS = (
    "What a test machine exports is read as CSV, TSV, TXT, TRA, XLSX or ODS. A brake or a vacuum "
    "line is a TOML file."
)


class Sorting:
    """The dialog; `go(page)` opens a page after what was accepted."""

    def __init__(self, desk: Desk, go: Callable[[str], object]) -> None:
        self.desk, self.uploads, self._go = desk, desk.files, go
        self.proposals: list[Proposal] = []
        self.said: dict[str, dict[str, str]] = {}
        """{file's key: {"role" or a fact: what was chosen or typed here}}."""
        self.told: list[str] = []
        """Of files that are not used here: where they are read, or why they were not taken."""
        self._known: dict[tuple[str, str], Proposal] = {}
        self._turn = asyncio.Lock()
        self._open_columns: set[str] = set()
        self._problems: dict[str, str] = {}
        self.dialog = dressed(ui.dialog(), aria_label="Files")
        with self.dialog, ui.card().classes("dropped-card w-full gap-2"):
            self.title = heading(DROPPED, ident="dropped-title")
            self.box = dressed(ui.column(), "dropped", "w-full gap-3")
        self.dialog.on_value_change(lambda e: None if e.value else self._closed())

    def tell(self, sentence: str) -> None:
        """One more sentence of a file that is not used here."""
        self.told.append(on_page(sentence))

    async def show(self, *, empty: bool = False) -> None:
        """Propose for every file that waits, and open; where there is none only if `empty`.

        Empty it says how files come here.
        """
        # files that come one after the other: each is read once, and the last look counts
        async with self._turn:
            found = await run.io_bound(self._proposed)
        if found is None or self.uploads.closed:
            return
        found = [p for p in found if p.key in self.uploads.waiting]  # not what was just accepted
        gone = [p for p in found if p.kind != "measurement"]
        self.told += [on_page(f"{p.name}: {p.about}") for p in gone]
        self.uploads.remove(p.key for p in gone)
        self.proposals = together(p for p in found if p.kind == "measurement")
        self._fill()
        if self.proposals or self.told or empty:
            self.dialog.open()
        else:
            self.dialog.close()  # what came was neither to be asked about nor refused

    def _proposed(self) -> list[Proposal]:
        """In a thread: a proposal for each file that waits."""
        edits, made = edits_of(self.desk), []
        for upload in [f for f in list(self.uploads.files) if f.key in self.uploads.waiting]:
            said = edits.get(upload.key, {})
            text = sidecar_text(self.uploads.sidecars.get(upload.shown, ""), said)
            known = self._known.get((upload.key, text))
            if known is None:
                laid = self.uploads.with_sidecar(upload, text)
                known = proposal(upload.key, upload.shown, laid.path)
                known = _of_list(_in_users_words(known, upload), self.uploads.from_list)
                self._known[upload.key, text] = known
            if said.get("role") in ROLES:
                known = replace(known, role=Said(said["role"], "as you said before"))
            made.append(known)
        return made

    # what is shown

    def _fill(self) -> None:
        self.box.clear()
        usable = [p for p in self.proposals if not p.asks]
        ordered = sorted(self.proposals, key=lambda p: not self._lacking(p))
        self.title.set_text(DROPPED if self.proposals or self.told else YOURS)
        with self.box:
            if not self.proposals and not self.told:
                self._invite()
            if self.proposals:
                hint("Each proposal says where it comes from. Nothing is used before you accept.")
            for one in ordered[:WHOLE]:
                self._row(one)
            if ordered[WHOLE:]:
                self._table(ordered[WHOLE:])
            if self.told:
                heading("Not used here", 3)
                with dressed(ui.column(), "dropped-told", "gap-1 w-full", role="status"):
                    for sentence in dict.fromkeys(self.told):
                        ui.label(sentence).classes("text-sm break-words")
                    ui.label(EXPORTS).classes("text-xs opacity-80")
            self._trouble = Alert("dropped-problem")
            with ui.row().classes("w-full gap-2 justify-end"):
                if self.proposals:
                    button("Not now", self.dialog.close, "dropped-later", how="flat no-caps")
                    how = "unelevated no-caps color=primary"
                    text = "Use all" if len(usable) != 1 else "Use it"
                    button(text, self.accept, "dropped-use", "check", how=how)
                else:
                    how = "unelevated no-caps color=primary autofocus"
                    button("Close", self.dialog.close, "dropped-close", how=how)

    def _invite(self) -> None:
        """How files come here, and where those are that are used already."""
        ui.label("Drop files anywhere in this window, or choose them here.")
        hint(EXPORTS)
        choose = button("Choose files", None, "dropped-choose", "folder_open")
        choose.on("click", js_handler="() => layerjamPick()")
        if count := len(self.uploads.used):
            many = "1 file is used already" if count == 1 else f"{count} files are used already"
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{many}.")
                button("See it in the laboratory", self._see, "dropped-used", how="flat no-caps")

    def _see(self) -> None:
        self.dialog.close()
        self._go("laboratory")

    def _row(self, one: Proposal) -> None:
        role = self._role(one)
        with dressed(ui.column(), "dropped-file", "w-full gap-1 dropped-file"):
            with ui.row().classes("w-full items-baseline gap-2"):
                ui.label(one.name).classes("font-medium break-all")
                if one.synthetic:
                    ui.label("synthetic").classes("synthetic text-sm")
                why = f"{one.about}. {CLICKS[one.asks]}." if one.asks else one.about
                ui.label(on_page(why)).classes("text-sm" + (" no" if one.asks else " opacity-80"))
            with ui.row().classes("w-full items-start gap-3"):
                self._choice(one, role)
                asked = {NEEDED.get(role), one.asks, *self.said.get(one.key, {})}
                for fact in FACTS:
                    if fact == NEEDED.get(role) or (fact == "speed" and fact in asked):
                        self._fact(one, fact)
                toggle = partial(self._toggle, one.key)
                how = "flat dense no-caps icon-right=table_chart"
                button("Columns", toggle, "dropped-columns", how=how)
            if problem := self._problems.get(one.key, ""):
                dressed(ui.label(problem), "dropped-why", "text-negative text-sm", role="alert")
            if one.key in self._open_columns or one.asks:
                self._columns(one)

    def _choice(self, one: Proposal, role: str) -> None:
        def chosen(event: Any) -> None:
            self._set(one.key, "role", str(event.value))
            self._fill()

        with ui.column().classes("gap-0"):
            box = select(ROLES, "Used as", "dropped-role", chosen, value=role, classes="w-56")
            dressed(box, aria_label=f"{one.name} is used as")
            if "role" not in self.said.get(one.key, {}):
                ui.label(one.role.source).classes(f"text-xs opacity-80 {SOURCE}")

    def _fact(self, one: Proposal, fact: str) -> None:
        proposed = one.facts.get(fact, Said())
        now = self.said.get(one.key, {}).get(fact, proposed.text)
        with ui.column().classes("gap-0"):
            box = field(WORDS[fact], f"dropped-{fact}", now, classes="w-44")
            dressed(box, aria_label=f"{WORDS[fact]} of {one.name}")
            box.on_value_change(lambda e: self._set(one.key, fact, str(e.value or "")))
            box.on("keydown.enter", self.accept)
            if proposed.source:
                ui.label(proposed.source).classes(f"text-xs opacity-80 {SOURCE}")
            else:
                ui.label(f"stated nowhere: type it, in {UNITS[fact]}").classes(
                    f"text-xs no {SOURCE}"
                )

    def _table(self, files: Sequence[Proposal]) -> None:
        """The files beyond those with fields of their own."""
        rows = []
        for one in files:
            role = self._role(one)
            said = one.facts.get(NEEDED.get(role, ""), Said("–", ""))
            sources = "; ".join(dict.fromkeys(filter(None, (one.role.source, said.source))))
            rows.append([one.name, ROLES[role], said.text, sources])
        heads = ["File", "Used as", "Vacuum or force", "Taken from"]
        ui.html(html(heads, rows, (), "More files", "dropped-more"), sanitize=False)
        hint("They can be changed in the laboratory, one by one or many at once.")

    def _columns(self, one: Proposal) -> None:
        upload, said = self._upload(one.key), edits_of(self.desk).get(one.key, {})
        if upload is None:
            return
        try:
            shown = preview(upload.path)
        except LayerjamError as err:
            hint(rename_files(one_line(err), {upload.path.name: upload.shown}))
            return
        act, turn = partial(self._clicked, one, shown), partial(self._turned, one)
        ColumnTable(shown, negative_of(said), act, turn)

    # what the user does

    async def _clicked(
        self, one: Proposal, shown: Preview, index: int, role: str, unit: str
    ) -> None:
        upload = self._upload(one.key)
        if upload is None:
            return
        try:
            change = column_said(upload.path, shown, index, role, unit)
            check_edit(change)
        except LayerjamError as err:
            self._trouble.say(rename_files(one_line(err), {upload.path.name: upload.shown}))
            return
        await self._change(one.key, change)

    async def _turned(self, one: Proposal, role: str) -> None:
        said = edits_of(self.desk).get(one.key, {})
        await self._change(one.key, sign_turned(said, role))

    async def _change(self, key: str, change: Mapping[str, str]) -> None:
        if "vacuum" in change:
            self.said.get(key, {}).pop("vacuum", None)
        self._open_columns.add(key)
        put_edits(self.desk, {key: change})
        await self.show()

    def _toggle(self, key: str) -> None:
        self._open_columns ^= {key}
        self._fill()

    def _set(self, key: str, what: str, text: str) -> None:
        self.said.setdefault(key, {})[what] = text

    async def accept(self) -> None:
        """Use what is complete; what is not stays, and says what it lacks."""
        self._problems.clear()
        taken: dict[str, dict[str, str]] = {}
        for one in self.proposals:
            made = self._made(one)
            lacking = self._lacking(one)
            if not lacking:
                try:
                    check_edit(made)
                except LayerjamError as err:
                    lacking = one_line(err)
            if lacking:
                self._problems[one.key] = lacking
            else:
                taken[one.key] = made
        self.uploads.waiting -= set(taken)
        self.proposals = [p for p in self.proposals if p.key not in taken]
        if taken:
            put_edits(self.desk, taken)
            self.desk.files_changed()
        if self.proposals:
            self._fill()
            return
        self.dialog.close()
        if taken and self.desk.state.page != "pull":
            self._go("laboratory")

    def _made(self, one: Proposal) -> dict[str, str]:
        role, own = self._role(one), self.said.get(one.key, {})
        made = {"role": role}
        for fact in (NEEDED.get(role, ""), "speed"):
            said = one.facts.get(fact, Said())
            text = own.get(fact, said.text).strip()
            if fact and text and (text != said.text or said.source not in STATED):
                made[fact] = with_unit(text, UNITS[fact])
        return made

    def _role(self, one: Proposal) -> str:
        return self.said.get(one.key, {}).get("role", one.role.text)

    def _lacking(self, one: Proposal) -> str:
        """What keeps a file from being used as it stands here, in words; empty where nothing."""
        role, own = self._role(one), self.said.get(one.key, {})
        texts = {fact: own.get(fact, one.facts.get(fact, Said()).text) for fact in FACTS}
        if role == ASIDE:
            return ""
        if one.asks and not (one.asks == "speed" and texts["speed"]):
            return f"{CLICKS[one.asks]}."
        if role != FRICTION and self.desk.state.page == "pull":
            return ""  # that page asks for the vacuum of all files that do not state it
        return ASKED.get(one.lacks(role, texts), "")

    def _upload(self, key: str) -> Upload | None:
        return next((f for f in self.uploads.files if f.key == key), None)

    def _closed(self) -> None:
        self.told.clear()
        self.desk.files_changed()


def _in_users_words(one: Proposal, upload: Upload) -> Proposal:
    """A proposal whose words call the file as the user does."""
    names = {upload.path.name: upload.shown}
    about = str(rename_files(one.about, names)).removeprefix(f"{upload.shown}: ")
    return replace(one, about=about)


def _of_list(one: Proposal, from_list: Mapping[str, frozenset[str]]) -> Proposal:
    """A proposal that says what it takes from the list of all files, not from a sidecar."""
    mine = from_list.get(one.name, frozenset())
    facts = {
        fact: Said(said.text, LIST) if fact in mine and said.source == SIDECAR else said
        for fact, said in one.facts.items()
    }
    role = one.role
    if {"vacuum", "normal_force"} & mine and role.source.startswith(SIDECAR):
        role = Said(role.text, LIST + role.source.removeprefix(SIDECAR))
    return replace(one, facts=facts, role=role)
