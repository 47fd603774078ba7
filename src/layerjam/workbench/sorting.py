"""The "Dropped files" dialog: one row per file with its proposal, accepted with one click."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from nicegui import run, ui

from layerjam.core.errors import LayerjamError
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.measure.conditions import LIST
from layerjam.laboratory.measure.preview import Preview, preview_file
from layerjam.workbench.columns import ColumnTable
from layerjam.workbench.controls import add_unit
from layerjam.workbench.desk import Desk
from layerjam.workbench.proposals import (
    ASIDE,
    CLICKS,
    FACTS,
    FRICTION,
    NEEDED,
    Proposal,
    SourcedValue,
    assign_roles,
    propose_use,
)
from layerjam.workbench.said import (
    ROLES,
    UNITS,
    check_edit,
    column_edit,
    get_edits,
    negated_columns,
    put_edits,
    reverse_sign,
    sidecar_text,
)
from layerjam.workbench.spoken import page_text
from layerjam.workbench.tables import html_table
from layerjam.workbench.uploads import Upload
from layerjam.workbench.widgets import (
    Alert,
    button,
    dress,
    field,
    find_error,
    heading,
    hint,
    one_line,
    select,
)

MAX_ROWS = 12
"""Maximum number of files with their own fields; a table lists the others."""
SIDECAR = "its sidecar"
STATED = ("its sidecar", LIST, "the file header")
"""Sources that the readers use by default."""
SOURCE = "dropped-source"
WORDS = {"vacuum": "Vacuum", "normal_force": "Normal force", "speed": "Crosshead speed"}
ASKED = {
    "vacuum": "Type the vacuum of this pull.",
    "normal_force": "Type the force that pressed the films together.",
}
DROPPED, YOURS = "Dropped files", "Your files"
EXPORTS = (
    "Test machine exports may be CSV, TSV, TXT, TRA, XLSX or ODS files. A brake or a "
    "vacuum line is a TOML file."
)


class Sorting:
    """The dialog; `go(page)` opens a page after files are accepted."""

    def __init__(self, desk: Desk, go: Callable[[str], object]) -> None:
        self.desk, self.uploads, self._go = desk, desk.files, go
        self.proposals: list[Proposal] = []
        self.said: dict[str, dict[str, str]] = {}
        """{file's key: {"role" or a metadata key: selected or typed text}}."""
        self.told: list[str] = []
        """Sentences about files that are not used here: a command to use instead, or a reason."""
        self._known: dict[tuple[str, str], Proposal] = {}
        self._turn = asyncio.Lock()
        self._open_columns: set[str] = set()
        self._problems: dict[str, str] = {}
        self.dialog = dress(ui.dialog(), aria_label="Files")
        with self.dialog, ui.card().classes("dropped-card w-full gap-2"):
            self.title = heading(DROPPED, ident="dropped-title")
            self.box = dress(ui.column(), "dropped", "w-full gap-3")
        self.dialog.on_value_change(lambda e: None if e.value else self._on_close())

    def add_sentence(self, sentence: str) -> None:
        """Add a sentence about a file that is not used here."""
        self.told.append(page_text(sentence))

    async def show(self, *, empty: bool = False) -> None:
        """Make proposals for all waiting files; open the dialog if there are any, or if `empty`.

        An empty dialog explains how to add files.
        """
        # files may arrive one after another: each is read once, and the last refresh shows all
        async with self._turn:
            proposals = await run.io_bound(self._propose_uses)
        if proposals is None or self.uploads.closed:
            return
        # leave out files that were accepted in the meantime
        proposals = [p for p in proposals if p.key in self.uploads.waiting]
        others = [p for p in proposals if p.kind != "measurement"]
        for about in dict.fromkeys(p.about for p in others):
            names = ", ".join(p.name for p in others if p.about == about)
            self.told.append(page_text(f"{names}: {about}"))
        self.uploads.refused |= {p.name: p.about for p in others if p.kind == "unknown"}
        self.uploads.remove_files(p.key for p in others)
        self.proposals = assign_roles(p for p in proposals if p.kind == "measurement")
        self._fill_rows()
        if self.proposals or self.told or empty:
            self.dialog.open()
        else:
            self.dialog.close()  # no file needs an answer, and none was rejected

    def _propose_uses(self) -> list[Proposal]:
        edits, result = get_edits(self.desk), []
        for upload in [f for f in list(self.uploads.files) if f.key in self.uploads.waiting]:
            edit = edits.get(upload.key, {})
            text = sidecar_text(self.uploads.sidecars.get(upload.shown, ""), edit)
            item = self._known.get((upload.key, text))
            if item is None:
                upload_copy = self.uploads.write_sidecar(upload, text)
                item = propose_use(upload.key, upload.shown, upload_copy.path)
                item = _cite_list(_use_shown_name(item, upload), self.uploads.from_list)
                self._known[upload.key, text] = item
            if edit.get("role") in ROLES:
                item = replace(item, role=SourcedValue(edit["role"], "your earlier choice"))
            result.append(item)
        return result

    # layout

    def _fill_rows(self) -> None:
        self.box.clear()
        usable = sum(not p.asks for p in self.proposals)
        rows = sorted(self.proposals, key=lambda p: not self._missing_entry(p))
        self.title.set_text(DROPPED if self.proposals or self.told else YOURS)
        with self.box:
            if not self.proposals and not self.told:
                self._build_invitation()
            if self.told:
                with dress(ui.column(), "dropped-told", "gap-1 w-full", role="status"):
                    heading("Not used here", 3)
                    for sentence in dict.fromkeys(self.told):
                        ui.label(sentence).classes("text-sm break-words")
                    ui.label(EXPORTS).classes("text-xs opacity-80")
            if self.proposals:
                hint("Each proposal states its source. Nothing is used until you accept it.")
            for item in rows[:MAX_ROWS]:
                self._build_row(item)
            if rows[MAX_ROWS:]:
                self._build_table(rows[MAX_ROWS:])
            self._trouble = Alert("dropped-problem")
            with ui.row().classes("w-full gap-2 justify-end dropped-acts"):
                if self.proposals:
                    button("Not now", self.dialog.close, "dropped-later", look="flat no-caps")
                    look = "unelevated no-caps color=primary"
                    text = f"Use {usable}" if usable != 1 else "Use this"
                    button(text, self.accept_files, "dropped-use", "check", look=look)
                else:
                    look = "unelevated no-caps color=primary autofocus"
                    button("Close", self.dialog.close, "dropped-close", look=look)

    def _build_invitation(self) -> None:
        ui.label("Drop files anywhere in this window, or choose them here.")
        hint(EXPORTS)
        choose = button("Choose files", None, "dropped-choose", "folder_open")
        choose.on("click", js_handler="() => layerjamPick()")
        if count := len(self.uploads.files_in_use):
            text = "1 file is already in use" if count == 1 else f"{count} files are already in use"
            with ui.row().classes("items-center gap-2"):
                ui.label(f"{text}.")
                button(
                    "Show in the laboratory", self._show_used, "dropped-used", look="flat no-caps"
                )

    def _show_used(self) -> None:
        self.dialog.close()
        self._go("laboratory")

    def _build_row(self, item: Proposal) -> None:
        role = self._chosen_role(item)
        with dress(ui.column(), "dropped-file", "w-full gap-1 dropped-file"):
            with ui.row().classes("w-full items-baseline gap-2"):
                ui.label(item.name).classes("font-medium break-all")
                if item.synthetic:
                    ui.label("synthetic").classes("synthetic text-sm")
                text = f"{item.about}. {CLICKS[item.asks]}." if item.asks else item.about
                ui.label(page_text(text)).classes(
                    "text-sm" + (" no" if item.asks else " opacity-80")
                )
            with ui.row().classes("w-full items-start gap-3"):
                self._build_role_choice(item, role)
                facts = {NEEDED.get(role), item.asks, *self.said.get(item.key, {})}
                for fact in FACTS:
                    if fact == NEEDED.get(role) or (fact == "speed" and fact in facts):
                        self._build_fact(item, fact)
                toggle = partial(self._toggle_file, item.key)
                look = "flat dense no-caps icon-right=table_chart"
                button("Columns", toggle, "dropped-columns", look=look)
            if problem := self._problems.get(item.key, ""):
                dress(ui.label(problem), "dropped-why", "text-negative text-sm", role="alert")
            if item.key in self._open_columns or item.asks:
                self._build_columns(item)

    def _build_role_choice(self, item: Proposal, role: str) -> None:
        def on_choose(event: Any) -> None:
            self._set_entry(item.key, "role", str(event.value))
            self._fill_rows()

        with ui.column().classes("gap-0"):
            box = select(ROLES, "Used as", "dropped-role", on_choose, value=role, classes="w-56")
            dress(box, aria_label=f"{item.name} is used as")
            if "role" not in self.said.get(item.key, {}):
                ui.label(item.role.source).classes(f"text-xs opacity-80 {SOURCE}")

    def _build_fact(self, item: Proposal, fact: str) -> None:
        value = item.facts.get(fact, SourcedValue())
        text = self.said.get(item.key, {}).get(fact, value.text)
        with ui.column().classes("gap-0"):
            box = field(WORDS[fact], f"dropped-{fact}", text, classes="w-44")
            dress(box, aria_label=f"{WORDS[fact]} of {item.name}")
            box.on_value_change(lambda e: self._set_entry(item.key, fact, str(e.value or "")))
            box.on("keydown.enter", self.accept_files)
            if value.source:
                ui.label(value.source).classes(f"text-xs opacity-80 {SOURCE}")
            else:
                ui.label(f"not stated: type it [{UNITS[fact]}]").classes(f"text-xs no {SOURCE}")

    def _build_table(self, files: Sequence[Proposal]) -> None:
        names: dict[tuple[str, ...], list[str]] = {}
        for item in files:
            role = self._chosen_role(item)
            value = item.facts.get(NEEDED.get(role, ""), SourcedValue("–", ""))
            sources = "; ".join(dict.fromkeys(filter(None, (item.role.source, value.source))))
            names.setdefault((ROLES[role], value.text, sources), []).append(item.name)
        rows = [[", ".join(equal), *cells] for cells, equal in names.items()]
        heads = ["File", "Used as", "Vacuum or force", "Source"]
        ui.html(html_table(heads, rows, (), "More files", "dropped-more"), sanitize=False)
        hint("Change these in the Laboratory, one by one or several at once.")

    def _build_columns(self, item: Proposal) -> None:
        upload, edit = self._find_upload(item.key), get_edits(self.desk).get(item.key, {})
        if upload is None:
            return
        try:
            table = preview_file(upload.path)
        except LayerjamError as err:
            hint(rename_files(one_line(err), {upload.path.name: upload.shown}))
            return
        act, turn = partial(self._on_click, item, table), partial(self._on_reverse, item)
        ColumnTable(table, negated_columns(edit), act, turn)

    # ---- user actions

    async def _on_click(
        self, item: Proposal, table: Preview, index: int, role: str, unit: str
    ) -> None:
        upload = self._find_upload(item.key)
        if upload is None:
            return
        try:
            change = column_edit(upload.path, table, index, role, unit)
            check_edit(change)
        except LayerjamError as err:
            self._trouble.show_error(rename_files(one_line(err), {upload.path.name: upload.shown}))
            return
        await self._change_edit(item.key, change)

    async def _on_reverse(self, item: Proposal, role: str) -> None:
        edit = get_edits(self.desk).get(item.key, {})
        await self._change_edit(item.key, reverse_sign(edit, role))

    async def _change_edit(self, key: str, change: Mapping[str, str]) -> None:
        if "vacuum" in change:
            self.said.get(key, {}).pop("vacuum", None)
        self._open_columns.add(key)
        put_edits(self.desk, {key: change})
        await self.show()

    def _toggle_file(self, key: str) -> None:
        self._open_columns ^= {key}
        self._fill_rows()

    def _set_entry(self, key: str, key_of: str, text: str) -> None:
        self.said.setdefault(key, {})[key_of] = text

    async def accept_files(self) -> None:
        """Use the files with complete metadata; the others remain and show what they lack."""
        self._problems.clear()
        edits: dict[str, dict[str, str]] = {}
        for item in self.proposals:
            edit = self._combined_edit(item)
            lacking = self._missing_entry(item) or find_error(check_edit, edit)
            if lacking:
                self._problems[item.key] = lacking
            else:
                edits[item.key] = edit
        self.uploads.waiting -= set(edits)
        for item in self.proposals:
            self.uploads.refused.pop(item.name, None)
        self.proposals = [p for p in self.proposals if p.key not in edits]
        if edits:
            put_edits(self.desk, edits)
            self.desk.announce_files()
        if self.proposals:
            self._fill_rows()
            return
        self.dialog.close()
        if edits and self.desk.state.page != "pull":
            self._go("laboratory")

    def _combined_edit(self, item: Proposal) -> dict[str, str]:
        role, typed_values = self._chosen_role(item), self.said.get(item.key, {})
        edit = {"role": role}
        for fact in (NEEDED.get(role, ""), "speed"):
            value = item.facts.get(fact, SourcedValue())
            text = typed_values.get(fact, value.text).strip()
            if fact and text and (text != value.text or value.source not in STATED):
                edit[fact] = add_unit(text, UNITS[fact])
        return edit

    def _chosen_role(self, item: Proposal) -> str:
        return self.said.get(item.key, {}).get("role", item.role.text)

    def _missing_entry(self, item: Proposal) -> str:
        """Return a request for the entry that a file's use lacks; empty if none is missing."""
        role, typed_values = self._chosen_role(item), self.said.get(item.key, {})
        texts = {
            fact: typed_values.get(fact, item.facts.get(fact, SourcedValue()).text)
            for fact in FACTS
        }
        if role == ASIDE:
            return ""
        if item.asks and not (item.asks == "speed" and texts["speed"]):
            return f"{CLICKS[item.asks]}."
        if role != FRICTION and self.desk.state.page == "pull":
            return ""  # that page asks for the vacuum of all files that do not state it
        return ASKED.get(item.missing_entry(role, texts), "")

    def _find_upload(self, key: str) -> Upload | None:
        return next((f for f in self.uploads.files if f.key == key), None)

    def _on_close(self) -> None:
        self.told.clear()
        self.desk.announce_files()


def _use_shown_name(item: Proposal, upload: Upload) -> Proposal:
    names = {upload.path.name: upload.shown}
    summary = str(rename_files(item.about, names)).removeprefix(f"{upload.shown}: ")
    return replace(item, about=summary)


def _cite_list(item: Proposal, from_list: Mapping[str, frozenset[str]]) -> Proposal:
    """Return the proposal, with the list of conditions named as the source of its metadata."""
    listed_facts = from_list.get(item.name, frozenset())
    facts = {
        fact: SourcedValue(value.text, LIST)
        if fact in listed_facts and value.source == SIDECAR
        else value
        for fact, value in item.facts.items()
    }
    role = item.role
    if {"vacuum", "normal_force"} & listed_facts and role.source.startswith(SIDECAR):
        role = SourcedValue(role.text, LIST + role.source.removeprefix(SIDECAR))
    return replace(item, facts=facts, role=role)
