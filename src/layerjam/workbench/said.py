"""What the user says of dropped files: use, conditions, columns.

It stands in the desk by the file's digest, so that it can be undone, stands in the link, and comes
back when the same file is dropped again. A command is given it as the file's sidecar.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from layerjam.errors import LayerjamError, QuantityError
from layerjam.measure.options import KEYS, ReadingOptions
from layerjam.measure.preview import Preview
from layerjam.measure.readers.unit_words import ROLES as ROLES_OF_PULLS
from layerjam.measure.sidecar import READ, Facts
from layerjam.units import spec_of
from layerjam.workbench.desk import Desk
from layerjam.workbench.proposals import (
    ASIDE,
    CALIBRATE,
    FACTS,
    FRICTION,
    VALIDATE,
    vacuum_of_column,
)

PAGE, FILES = "laboratory", "files"
ROLES = MappingProxyType(
    {
        FRICTION: "friction test",
        CALIBRATE: "pull to calibrate on",
        VALIDATE: "pull to validate on",
        ASIDE: "leave out",
    }
)
UNITS = MappingProxyType({"vacuum": "kPa", "normal_force": "N", "speed": "mm/s"})
"""Of a condition that is typed as a bare number."""
MANY = ("negative", "column")
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
    desk.put(PAGE, FILES, text, alone=True)


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
        if "columns" in answers:
            document[READ].pop("column", None)  # type: ignore[union-attr]
        document[READ].update(answers)  # type: ignore[union-attr]
    return tomlkit.dumps(document)


def column_said(path: Path, shown: Preview, index: int, role: str, unit: str) -> dict[str, str]:
    """What to change where the user says that a column is `role`; no role: it is not used.

    A column of vacuum gives the vacuum of the test, the median of its values. Raises LayerjamError.
    """
    if role == "vacuum":
        return {"vacuum": vacuum_of_column(path, index, unit, shown.names).text}
    return {"columns": shown.columns(index, role, unit), "column": ""}


def negative_of(said: Mapping[str, str]) -> frozenset[str]:
    """What is counted with the opposite sign."""
    return frozenset(line for line in said.get("negative", "").split("\n") if line)


def sign_turned(said: Mapping[str, str], role: str) -> dict[str, str]:
    """What to change where the sign of a quantity is turned, or turned back."""
    return {"negative": "\n".join(sorted(negative_of(said) ^ {role}))}
