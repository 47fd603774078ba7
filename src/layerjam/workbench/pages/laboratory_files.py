"""The laboratory's files: what each is used for, what the page adds to its sidecar, what it says.

What the user corrects stands in the desk by the file's digest, so that it can be undone, stands in
the link, and comes back when the same file is dropped again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from layerjam.errors import (
    FileError,
    FitError,
    LayerjamError,
    MissingExtraError,
    QuantityError,
)
from layerjam.identify.provenance import renamed
from layerjam.measure.options import KEYS, ReadingOptions
from layerjam.measure.readers.source import load_sources
from layerjam.measure.readers.unit_words import ROLES as ROLES_OF_PULLS
from layerjam.measure.sidecar import Facts, read_facts
from layerjam.measure.trace import Trace
from layerjam.units import show, spec_of
from layerjam.workbench.call import Call, DataFile, Options
from layerjam.workbench.desk import Desk
from layerjam.workbench.uploads import Upload, Uploads, sidecar_of
from layerjam.workbench.widgets import one_line

PAGE, FILES = "laboratory", "files"
ROLES = {
    "friction": "friction test",
    "calibrate": "pull to calibrate on",
    "validate": "pull to validate on",
    "aside": "leave out",
}
FACTS = ("vacuum", "normal_force")
"""Facts of the sidecar that the page asks for."""
MANY = ("negative", "column")
LINES, LETTERS = 12, 110
"""Of a file's beginning that are shown."""
CURVE = 400
"""Samples of a file's curve that are kept to be drawn."""
TONES = MappingProxyType({"understood": "#00684c", "refused": "#a63d00", "left out": "#5b6672"})
"""Colours under white letters, dark enough to read them; of what asks for something another one."""
Edits = dict[str, dict[str, str]]


def edits_of(desk: Desk) -> Edits:
    """{file's key: {what: text}}; what a link brought that is none is left out."""
    try:
        found = json.loads(str(desk.get(PAGE, FILES, "{}")))
    except (ValueError, RecursionError):
        return {}
    if not isinstance(found, dict):
        return {}
    known = {"role", *FACTS, *KEYS}
    return {
        str(key): {k: v for k, v in one.items() if k in known and isinstance(v, str)}
        for key, one in found.items()
        if isinstance(one, dict)
    }


def put_edits(desk: Desk, keys: Iterable[str], changes: Mapping[str, str]) -> None:
    """Change what is said of files, as one step of undo; an empty text takes back."""
    edits = edits_of(desk)
    for key in keys:
        one = {**edits.get(key, {}), **changes}
        edits[key] = {k: v for k, v in one.items() if v}
    text = json.dumps({k: v for k, v in edits.items() if v}, separators=(",", ":"))
    desk.put(PAGE, FILES, text)


def put_roles(desk: Desk, roles: Mapping[str, str]) -> None:
    """What each file is used for, as one step of undo."""
    edits = edits_of(desk)
    for key, role in roles.items():
        edits[key] = {**edits.get(key, {}), "role": role}
    desk.put(PAGE, FILES, json.dumps(edits, separators=(",", ":")))


def check_edit(changes: Mapping[str, str]) -> None:
    """Raise LayerjamError for a fact or an answer that is none."""
    for name in FACTS:
        if changes.get(name):
            spec_of(Facts, name).read(changes[name], name.replace("_", " "))
    ReadingOptions(**_answers(changes)).entries(ROLES_OF_PULLS)


def _answers(said: Mapping[str, str]) -> dict[str, Any]:
    """The answers among a file's settings, as the sidecar's [read] table holds them."""
    made: dict[str, Any] = {}
    for key in KEYS:
        text = said.get(key, "")
        if not text:
            continue
        if key in MANY:
            made[key] = [line for line in text.split("\n") if line]
        elif key == "specimen":
            if not text.isascii() or not text.isdigit() or len(text) > 6:
                raise QuantityError(f"specimen: '{text[:40]}' is not allowed; the first is 1")
            made[key] = int(text)
        else:
            made[key] = text
    return made


def sidecar_text(given: str, said: Mapping[str, str]) -> str:
    """The user's sidecar with what the page adds; the page's word counts. Broken TOML stays."""
    facts = {name: said[name] for name in FACTS if said.get(name)}
    answers = _answers(said)
    if not (facts or answers):
        return given
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        document = tomlkit.parse(given)
    except TOMLKitError:
        return given
    for name, value in facts.items():
        document[name] = value
    if answers:
        table = document.get("read")
        if not isinstance(table, dict):
            table = tomlkit.table()
            document["read"] = table
        for name, value in answers.items():
            table[name] = value
    return tomlkit.dumps(document)


@dataclass(frozen=True, eq=False)
class Row:
    """A file as the page shows it: understood, or refused with a reason."""

    upload: Upload
    role: str
    sidecar: str
    edited: bool
    facts: Facts = field(default_factory=Facts)
    understood: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    refused: str = ""
    traces: tuple[Trace, ...] = ()

    @property
    def data(self) -> DataFile:
        """The file as a call takes it."""
        return DataFile(self.upload.name, self.upload.path, self.sidecar, self.edited)

    @property
    def asks(self) -> str:
        """What is missing for its use."""
        if self.role in ("calibrate", "validate") and not self.refused:
            stated = [t.facts.vacuum for t in self.traces]
            return "vacuum?" if not stated or None in stated else ""
        if self.role == "friction" and not self.facts.normal_force:
            return "normal force?"
        return ""

    @property
    def good(self) -> bool:
        """Whether a step can use it."""
        return not self.refused and not self.asks and self.role != "aside"

    @property
    def vacuum(self) -> float | None:
        """What its sidecar or its own head states [Pa]."""
        return self.traces[0].facts.vacuum if self.traces else self.facts.vacuum

    @property
    def synthetic(self) -> bool:
        """Whether a program wrote it."""
        return any(t.facts.synthetic for t in self.traces) or self.facts.synthetic

    def cells(self) -> dict[str, str]:
        """What the table shows of it."""
        state = "left out" if self.role == "aside" else "understood"
        state = "refused" if self.refused else self.asks or state
        vacuum, force = self.vacuum, self.facts.normal_force
        return {
            "id": self.upload.key,
            "name": self.upload.name,
            "role": ROLES[self.role],
            "vacuum": "–" if vacuum is None else show(vacuum, "Pa"),
            "force": "–" if force is None else show(force, "N"),
            "state": state,
            "tone": TONES.get(state, "#8a4b00"),
            "refused": self.refused if len(self.refused) < 200 else self.refused[:199] + "…",
        }


class Reader:
    """Reads files for the table and remembers what it read."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str, str], Row] = {}

    def rows(
        self,
        uploads: Uploads,
        edits: Edits,
        tell: Callable[[str, float], None],
        standard: str = "paper",
    ) -> list[Row]:
        """A row for each file; writes the sidecars that have changed first."""
        files, given = list(uploads.files), dict(uploads.sidecars)
        kept: dict[tuple[str, str, str], Row] = {}
        made = []
        for count, upload in enumerate(files):
            said = edits.get(upload.key, {})
            try:
                text = sidecar_text(given.get(upload.name, ""), said)
            except LayerjamError:  # of a link: what cannot be is not written
                text = given.get(upload.name, "")
            _write(upload, text)
            role = said.get("role", "")
            key = (upload.digest, text, f"{role} {standard}")
            row = self._known.get(key)
            if row is None:
                tell(f"reading {upload.name}", count / len(files))
                row = _read(upload, text, role, text != given.get(upload.name, ""), standard)
            kept[key] = row
            made.append(row)
        self._known = kept
        return made


def _write(upload: Upload, text: str) -> None:
    beside = sidecar_of(upload.path)
    there = beside.read_text(encoding="utf-8") if beside.exists() else ""
    if there == text:
        return
    if text:
        beside.write_text(text, encoding="utf-8", newline="\n")
    else:
        beside.unlink(missing_ok=True)


OF_A_FILE = (FileError, FitError, QuantityError, MissingExtraError)
"""What reading one file may raise; any other error is not the file's fault."""


def _read(upload: Upload, sidecar: str, role: str, edited: bool, standard: str) -> Row:
    names = {upload.path.name: upload.name}
    row = Row(upload, role if role in ROLES else "calibrate", sidecar, edited)
    try:
        facts = read_facts(upload.path)
    except FileError as err:
        return replace(row, refused=renamed(str(err), names))
    if role not in ROLES:
        role = "friction" if facts.normal_force else "calibrate"
    row = replace(row, role=role, facts=facts)
    is_friction = role == "friction"
    said: Options = {"standard": standard} if is_friction else {}
    if is_friction and standard == "paper" and not facts.normal_force:
        said["normal_force"] = "1 N"  # the page asks for it; the traces do not depend on it
    call = Call("friction" if is_friction else "pull", options=said, files=(row.data,))
    try:
        result = call.run()
    except OF_A_FILE as err:
        return replace(row, refused=one_line(err).removeprefix(f"{upload.name}: "))
    traces = result.record[0] if is_friction else [t for t, _ in result.record]
    if is_friction and standard != "paper" and not facts.normal_force:
        facts = replace(facts, normal_force=result.record[1].normal_force)
    understood = dict.fromkeys(s for some in result.understood.values() for s in some)
    refused = "; ".join(f"{path}: {why}" for path, why in result.refused.items())
    return replace(
        row,
        facts=facts,
        understood=tuple(understood),
        warnings=tuple(w for t in traces for w in renamed(list(t.warnings), names)),
        refused="" if traces else refused,
        traces=tuple(t.thinned(CURVE) for t in traces),
    )


def beginning(upload: Upload) -> list[str]:
    """The first lines of a file, as text; a sentence where it is none."""
    try:
        sources = load_sources(upload.path)
    except LayerjamError as err:
        return [renamed(str(err), {upload.path.name: upload.name})]
    lines = []
    try:
        for _, text in sources[0].lines():
            plain = "".join(c if c.isprintable() or c == "\t" else " " for c in text)
            lines.append(plain[:LETTERS] + ("…" if len(plain) > LETTERS else ""))
            if len(lines) == LINES:
                break
    except LayerjamError as err:
        lines.append(renamed(str(err), {upload.path.name: upload.name}))
    return lines
