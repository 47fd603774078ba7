"""The user's statements about dropped files: their use, conditions and columns.

The desk stores them by the file's digest. They can therefore be undone, are part of the link, and
apply again when the same file is dropped again. A command receives them as the file's sidecar.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.toml_files.writer import dump_toml
from layerjam.core.units import get_spec
from layerjam.laboratory.measure.options import KEYS, ReadingOptions
from layerjam.laboratory.measure.preview import Preview
from layerjam.laboratory.measure.readers.unit_words import ROLES as ROLES_OF_PULLS
from layerjam.laboratory.measure.sidecar import READ, Facts
from layerjam.workbench.desk import Desk
from layerjam.workbench.proposals import (
    ASIDE,
    CALIBRATE,
    FACTS,
    FRICTION,
    VALIDATE,
    column_vacuum,
)

PAGE, FILES = "laboratory", "files"
ROLES = {
    FRICTION: "friction test",
    CALIBRATE: "calibration pull",
    VALIDATE: "validation pull",
    ASIDE: "exclude",
}
UNITS = MappingProxyType({"vacuum": "kPa", "normal_force": "N", "speed": "mm/s"})
"""Unit of a condition that is typed as a bare number."""
LISTS = ("negative", "column")
Edits = dict[str, dict[str, str]]


def get_edits(desk: Desk) -> Edits:
    """Return {file's key: {entry: text}}; invalid entries from a link are omitted."""
    try:
        stored_edits = json.loads(str(desk.get(PAGE, FILES, "{}")))
    except (ValueError, RecursionError):
        return {}
    if not isinstance(stored_edits, dict):
        return {}
    keys = {"role", *FACTS, *KEYS}
    return {
        str(key): {k: v for k, v in edit.items() if k in keys and isinstance(v, str)}
        for key, edit in stored_edits.items()
        if isinstance(edit, dict)
    }


def put_edits(desk: Desk, changes: Mapping[str, Mapping[str, str]]) -> None:
    """Change metadata of files, by key, as one undo step; an empty text removes an entry."""
    edits = get_edits(desk)
    for key, change in changes.items():
        edit = {**edits.get(key, {}), **change}
        edits[key] = {k: v for k, v in edit.items() if v}
    text = json.dumps({k: v for k, v in edits.items() if v}, separators=(",", ":"))
    desk.put_setting(PAGE, FILES, text, single=True)


def check_edit(changes: Mapping[str, str]) -> None:
    """Raise LayerjamError for an invalid metadata entry or reading option."""
    facts, answers = _facts_and_answers(changes)
    for name, text in facts.items():
        get_spec(Facts, name).read(text, name.replace("_", " "))
    ReadingOptions(**answers).entries(ROLES_OF_PULLS)


def _facts_and_answers(edit: Mapping[str, str]) -> tuple[dict[str, str], dict[str, Any]]:
    """Return a file's statements for its sidecar: (top-level entries, [read] table)."""
    answers: dict[str, Any] = {key: edit[key] for key in KEYS if edit.get(key)}
    for key in LISTS:
        if key in answers:
            answers[key] = [line for line in answers[key].split("\n") if line]
    number = answers.get("specimen")
    if number is not None:
        if not number.isascii() or not number.isdigit() or len(number) > 6:
            raise QuantityError(f"specimen: '{number[:40]}' is not a positive integer")
        answers["specimen"] = int(number)
    return {name: edit[name] for name in FACTS if edit.get(name)}, answers


def sidecar_text(text: str, edit: Mapping[str, str]) -> str:
    """Return the user's sidecar with the page's additions, which take precedence.

    Invalid TOML is returned unchanged, and invalid values from a link are not written.
    """
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    try:
        facts, answers = _facts_and_answers(edit)
        document = tomlkit.parse(text)
    except (LayerjamError, TOMLKitError):
        return text
    if not (facts or answers):
        return text
    document.update(facts)
    if answers:
        if not isinstance(document.get(READ), dict):
            document[READ] = tomlkit.table()
        if "columns" in answers:
            document[READ].pop("column", None)  # type: ignore[union-attr]
        document[READ].update(answers)  # type: ignore[union-attr]
    return dump_toml(document, text)


def column_edit(path: Path, table: Preview, index: int, role: str, unit: str) -> dict[str, str]:
    """Return the changes that give a column a new `role`; "" excludes the column.

    A vacuum column sets the vacuum of the test to the median of its values. Raises LayerjamError.
    """
    if role == "vacuum":
        return {"vacuum": column_vacuum(path, index, unit, table.names).text}
    return {"columns": table.columns(index, role, unit), "column": ""}


def negated_columns(edit: Mapping[str, str]) -> frozenset[str]:
    """Return the quantities whose sign is reversed."""
    return frozenset(line for line in edit.get("negative", "").split("\n") if line)


def reverse_sign(edit: Mapping[str, str], role: str) -> dict[str, str]:
    """Return the changes that reverse the sign of a quantity."""
    return {"negative": "\n".join(sorted(negated_columns(edit) ^ {role}))}
