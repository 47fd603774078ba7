"""What the records hold: all, one with what it comes from, and whether files are as they were."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from platform import node
from typing import Any

from sqlalchemy import Connection, select

from layerjam.archive.database import Database, RecordsError
from layerjam.archive.names import resolve_record_id, unlinked
from layerjam.archive.pieces import text_digest
from layerjam.archive.schema import DERIVED_FROM, ENTRIES, FILES, KINDS, WITHDRAWN
from layerjam.identify.provenance import sha256

SAME_NATURE = {"measured", "start", "run", "calibration"}
"""Roles in which what is synthetic makes synthetic what comes from it."""


@dataclass(frozen=True, kw_only=True)
class Shown:
    """One record.

    `derived_from` are all that it comes from, near ones first; `used_by` the next ones that come
    from it; `unlinked` what it names and the records do not hold.
    """

    record: dict[str, Any]
    derived_from: list[dict[str, Any]]
    used_by: list[dict[str, Any]]
    unlinked: list[dict[str, Any]]


@dataclass
class Verified:
    """How many digests were compared, and the rows of what is changed or missing."""

    checked: int = 0
    changed: list[dict[str, Any]] = field(default_factory=list)
    missing: list[dict[str, Any]] = field(default_factory=list)


def rows(db: Connection) -> list[dict[str, Any]]:
    """A row of every record, oldest first: id, kind, name, made_at, by, simulated, withdrawn."""
    names = ("id", "kind", "name", "made_at", "by", "simulated")
    columns = (*(ENTRIES.c[name] for name in names), WITHDRAWN.c.why.label("withdrawn"))
    ordered = select(*columns).outerjoin(WITHDRAWN).order_by(ENTRIES.c.made_at, ENTRIES.c.id)
    found = [dict(row) for row in db.execute(ordered).mappings()]
    synthetic = _synthetic(db, (row["id"] for row in found if row["simulated"]))
    return [{**row, "simulated": row["id"] in synthetic} for row in found]


def _synthetic(db: Connection, marked: Iterable[str]) -> set[str]:
    """Records that are synthetic or simulated: those marked, and what was made from them."""
    made: dict[str, list[str]] = defaultdict(list)
    for row in db.execute(select(DERIVED_FROM)):
        if row.role in SAME_NATURE:
            made[row.parent].append(row.child)
    found: set[str] = set()
    waiting = list(marked)
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting += made[one]
    return found


def show(database: Database, ident: str) -> Shown:
    """One record by its id, or the first characters of it; RecordsError if there is none."""
    with database.reading() as db:
        whole = resolve_record_id(db, ident, database.where)
        if db is None:  # which `resolve_record_id` has refused
            raise RecordsError(f"{database.where}: there are no records yet")
        every = {row["id"]: row for row in rows(db)}
        parents: dict[str, list[Any]] = defaultdict(list)
        children = []
        links = db.execute(select(DERIVED_FROM)).all()
        for row in sorted(
            links, key=lambda row: (row.role, every[row.parent]["name"], every[row.child]["name"])
        ):
            parents[row.child].append(row)
            if row.parent == whole:
                children.append({**_short(every[row.child]), "role": row.role})
        return Shown(
            record=_record(db, every[whole]),
            derived_from=list(_ancestors(whole, parents, every)),
            used_by=children,
            unlinked=[
                {"name": one.name, "role": one.role, "key": one.key} for one in unlinked(db, whole)
            ],
        )


def _short(row: Mapping[str, Any]) -> dict[str, Any]:
    """What names a record beside another."""
    return {key: row[key] for key in ("id", "kind", "name", "simulated", "withdrawn")}


def _ancestors(
    whole: str, parents: Mapping[str, Sequence[Any]], every: Mapping[str, Mapping[str, Any]]
) -> Iterator[dict[str, Any]]:
    """What a record comes from, near ones first; `child` is the one that comes from it."""
    seen: set[tuple[str, str, str]] = set()
    waiting = [whole]
    for child in waiting:
        for row in parents.get(child, ()):
            if (child, row.parent, row.role) not in seen:
                seen.add((child, row.parent, row.role))
                waiting.append(row.parent)
                yield {**_short(every[row.parent]), "role": row.role, "child": child}


def _record(db: Connection, row: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that the tables hold about one record."""
    own = ENTRIES.c.id == row["id"]
    software, content = db.execute(select(ENTRIES.c.software, ENTRIES.c.content).where(own)).one()
    file = db.execute(select(FILES).where(FILES.c.id == row["id"])).mappings().first()
    if not KINDS[row["kind"]].columns:
        content = {} if file is None else file
    made = {**row, "software": software}
    made |= {key: value for key, value in content.items() if key not in made}
    for key in ("result", "checks", "covariance"):
        if made.get(key):
            made[key] = _parsed(str(made[key]))
    if row["kind"] == "calibration":
        made["method"] = row["name"]
    keys = ("name", "folder", "host", "bytes", "sha256")
    made["added_from"] = None if file is None else {key: file[key] for key in keys}
    gone = db.execute(select(WITHDRAWN).where(WITHDRAWN.c.id == row["id"])).mappings().first()
    made["withdrawn"] = None if gone is None else {key: gone[key] for key in ("when", "why", "by")}
    return made


def _parsed(text: str) -> Any:
    """JSON as what it says, other text as it is."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def verify(database: Database, folders: Sequence[str | Path] = ()) -> Verified:
    """Compare every file that is not withdrawn with its digest, and every text in the tables.

    A file that is not where it was is looked for by its name in `folders`.
    """
    made = Verified()
    with database.reading() as db:
        if db is None:
            return made
        gone = {row.id for row in db.execute(select(WITHDRAWN.c.id))}
        files = [dict(row) for row in db.execute(select(FILES)).mappings()]
        texts = db.execute(select(ENTRIES).where(ENTRIES.c.kind.in_(["brake", "line"]))).all()
    for file in files:
        if file["id"] in gone:
            continue
        made.checked += 1
        state = _state(file, folders)
        if state:
            keys = ("id", "kind", "name", "folder", "host", "sha256")
            row = {key: file[key] for key in keys}
            (made.changed if state == "changed" else made.missing).append(row)
    for text in texts:
        made.checked += 1
        digest = text.content["sha256"]
        if text_digest(text.content["toml"]) != digest:
            about = {"id": text.id, "kind": text.kind, "name": text.name}
            made.changed.append({**about, "folder": None, "host": None, "sha256": digest})
    return made


def _state(file: Mapping[str, Any], folders: Sequence[str | Path]) -> str:
    """Whether a file is "changed" or "missing"; "" for one that is as it was."""
    own = Path(file["folder"]) / file["name"]
    found = {path: _digest(path) for path in (own, *(Path(f) / file["name"] for f in folders))}
    if file["sha256"] in found.values():
        return ""
    # the same path on another machine is another file
    here = file["host"] == node()
    return "changed" if here and found[own] is not None else "missing"


def _digest(path: Path) -> str | None:
    """SHA-256 of a file, or None if it cannot be read."""
    try:
        return sha256(str(path)) if path.is_file() else None
    except OSError:
        return None
