"""The laboratory's files: what each is used for, what the page adds to its sidecar, what it says.

What the user corrects stands in the desk by the file's digest, so that it can be undone, stands in
the link, and comes back when the same file is dropped again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from itertools import islice
from types import MappingProxyType
from typing import Any

from layerjam.commands.declare import Progress
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
from layerjam.measure.sidecar import READ, Facts, read_facts
from layerjam.measure.trace import Trace
from layerjam.units import show, spec_of
from layerjam.workbench.call import Call, Options
from layerjam.workbench.desk import Desk
from layerjam.workbench.uploads import Upload, Uploads
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


def put_edits(desk: Desk, changes: Mapping[str, Mapping[str, str]]) -> None:
    """Change what is said of files by their keys, as one step of undo; an empty text takes back."""
    edits = edits_of(desk)
    for key, said in changes.items():
        one = {**edits.get(key, {}), **said}
        edits[key] = {k: v for k, v in one.items() if v}
    text = json.dumps({k: v for k, v in edits.items() if v}, separators=(",", ":"))
    desk.put(PAGE, FILES, text)


def check_edit(changes: Mapping[str, str]) -> None:
    """Raise LayerjamError for a fact or an answer that is none."""
    facts, answers = _facts_and_answers(changes)
    for name, text in facts.items():
        spec_of(Facts, name).read(text, name.replace("_", " "))
    ReadingOptions(**answers).entries(ROLES_OF_PULLS)


def _facts_and_answers(said: Mapping[str, str]) -> tuple[dict[str, str], dict[str, Any]]:
    """What is said of a file as its sidecar holds it: at the top, and in the table [read]."""
    answers: dict[str, Any] = {key: said[key] for key in KEYS if said.get(key)}
    for key in MANY:
        if key in answers:
            answers[key] = [line for line in answers[key].split("\n") if line]
    number = answers.get("specimen")
    if number is not None:
        if not number.isascii() or not number.isdigit() or len(number) > 6:
            raise QuantityError(f"specimen: '{number[:40]}' is not allowed; the first is 1")
        answers["specimen"] = int(number)
    return {name: said[name] for name in FACTS if said.get(name)}, answers


def sidecar_text(given: str, said: Mapping[str, str]) -> str:
    """The user's sidecar with what the page adds; the page's word counts.

    Broken TOML stays, and of a link what cannot be is not written.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        facts, answers = _facts_and_answers(said)
        document = tomlkit.parse(given)
    except (LayerjamError, TOMLKitError):
        return given
    if not (facts or answers):
        return given
    document.update(facts)
    if answers:
        if not isinstance(document.get(READ), dict):
            document[READ] = tomlkit.table()
        document[READ].update(answers)  # type: ignore[union-attr]
    return tomlkit.dumps(document)


@dataclass(frozen=True, eq=False)
class Row:
    """A file as the page shows it: understood, or refused with a reason."""

    upload: Upload
    role: str
    facts: Facts = field(default_factory=Facts)
    understood: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    refused: str = ""
    traces: tuple[Trace, ...] = ()

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
            "name": self.upload.shown,
            "role": ROLES[self.role],
            "vacuum": "–" if vacuum is None else show(vacuum, "Pa"),
            "force": "–" if force is None else show(force, "N"),
            "state": state,
            "tone": TONES.get(state, "#8a4b00"),
            "refused": self.refused if len(self.refused) < 200 else self.refused[:199] + "…",
        }


def rows_of(
    uploads: Uploads, edits: Edits, standard: str, read: Callable[..., Row], tell: Progress
) -> list[Row]:
    """A row for each file, from `read`, which may remember; their sidecars are written before."""
    files, made = list(uploads.files), []
    for count, upload in enumerate(files):
        said = edits.get(upload.key, {})
        text = sidecar_text(uploads.sidecars.get(upload.shown, ""), said)
        tell(f"reading {upload.shown}", count / len(files))
        made.append(read(uploads.with_sidecar(upload, text), said.get("role", ""), standard))
    return made


OF_A_FILE = (FileError, FitError, QuantityError, MissingExtraError)
"""What reading one file may raise; any other error is not the file's fault."""


def read_row(upload: Upload, role: str, standard: str) -> Row:
    """A file whose sidecar lies beside it, read for its use; one that fits where `role` is none."""
    row = Row(upload, role if role in ROLES else "calibrate")
    try:
        facts = read_facts(upload.path)
    except FileError as err:
        return replace(row, refused=_in_users_words(err, upload))
    if role not in ROLES:
        role = "friction" if facts.normal_force else "calibrate"
    row = replace(row, role=role, facts=facts)
    is_friction = role == "friction"
    said: Options = {"standard": standard} if is_friction else {}
    if is_friction and standard == "paper" and not facts.normal_force:
        said["normal_force"] = "1 N"  # the page asks for it; the traces do not depend on it
    call = Call("friction" if is_friction else "pull", options=said, files=(upload,))
    try:
        result = call.run()
    except OF_A_FILE as err:
        return replace(row, refused=one_line(err).removeprefix(f"{upload.shown}: "))
    traces = result.record[0] if is_friction else [t for t, _ in result.record]
    if is_friction and standard != "paper" and not facts.normal_force:
        facts = replace(facts, normal_force=result.record[1].normal_force)
    understood = dict.fromkeys(s for some in result.understood.values() for s in some)
    refused = "; ".join(f"{path}: {why}" for path, why in result.refused.items())
    return replace(
        row,
        facts=facts,
        understood=tuple(understood),
        warnings=tuple(_in_users_words(w, upload) for t in traces for w in t.warnings),
        refused="" if traces else refused,
        traces=tuple(t.thinned(CURVE) for t in traces),
    )


def _in_users_words(said: object, upload: Upload) -> str:
    """A sentence that calls the file as the user does."""
    return str(renamed(str(said), {upload.path.name: upload.shown}))


def beginning(upload: Upload) -> list[str]:
    """The first lines of a file, as text; a sentence where it is none."""
    lines = []
    try:
        for _, text in islice(load_sources(upload.path)[0].lines(), LINES):
            plain = "".join(c if c.isprintable() or c == "\t" else " " for c in text)
            lines.append(plain[:LETTERS] + ("…" if len(plain) > LETTERS else ""))
    except LayerjamError as err:
        lines.append(_in_users_words(err, upload))
    return lines
