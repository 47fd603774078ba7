"""Views of the records: all of them, one with its sources, or a check of the files."""

import json
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from platform import node
from typing import Any

from sqlalchemy import Connection, select

from layerjam.core.toml_files.toml import parse_toml
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.records.database import Database, RecordsError
from layerjam.laboratory.records.pieces import text_digest
from layerjam.laboratory.records.record_names import find_unlinked, resolve_record_id
from layerjam.laboratory.records.schema import DERIVED_FROM, ENTRIES, FILES, KINDS, WITHDRAWN

SAME_NATURE = {"measured", "start", "run", "calibration"}
"""Roles in which a synthetic source makes the derived record synthetic."""


@dataclass(frozen=True, kw_only=True)
class RecordView:
    """One record.

    `derived_from` lists all its sources, nearest first. `used_by` lists the records that are
    derived directly from it. `unlinked` lists cited sources that are not in the database.
    """

    record: dict[str, Any]
    derived_from: list[dict[str, Any]]
    used_by: list[dict[str, Any]]
    unlinked: list[dict[str, Any]]


@dataclass
class Verification:
    """Number of digests that were compared, and the rows of changed or missing files."""

    checked: int = 0
    changed: list[dict[str, Any]] = field(default_factory=list)
    missing: list[dict[str, Any]] = field(default_factory=list)


def list_rows(db: Connection) -> list[dict[str, Any]]:
    """Return a row for each record, oldest first."""
    names = ("id", "kind", "name", "made_at", "by", "simulated")
    others = (WITHDRAWN.c.why.label("withdrawn"), ENTRIES.c.content)
    columns = (*(ENTRIES.c[name] for name in names), *others)
    query = select(*columns).outerjoin(WITHDRAWN).order_by(ENTRIES.c.made_at, ENTRIES.c.id)
    records = [dict(row) for row in db.execute(query).mappings()]
    synthetic = _find_synthetic(db, (row["id"] for row in records if row["simulated"]))
    return [
        {
            **{key: value for key, value in row.items() if key != "content"},
            "simulated": row["id"] in synthetic,
            "accepted": _count_accepted(row["content"]),
        }
        for row in records
    ]


def _count_accepted(content: Mapping[str, Any] | None) -> int:
    """Return the number of accepted failed checks in the text of a brake or line."""
    text = str((content or {}).get("toml") or "")
    return len(parse_toml(text, "record")["accepted"]) if "[[accepted]]" in text else 0


def _find_synthetic(db: Connection, start: Iterable[str]) -> set[str]:
    """Return the records that are synthetic or simulated, or derived from such records."""
    children: dict[str, list[str]] = defaultdict(list)
    for row in db.execute(select(DERIVED_FROM)):
        if row.role in SAME_NATURE:
            children[row.parent].append(row.child)
    ids: set[str] = set()
    waiting = list(start)
    while waiting:
        ident = waiting.pop()
        if ident not in ids:
            ids.add(ident)
            waiting += children[ident]
    return ids


def show_record(database: Database, ident: str) -> RecordView:
    """Return one record, given the start of its id or its name; RecordsError if there is none."""
    with database.open_snapshot() as db:
        full_id = resolve_record_id(db, ident, database.where)
        if db is None:  # `resolve_record_id` has already rejected an unknown id
            raise RecordsError(f"{database.where}: there are no records yet")
        every = {row["id"]: row for row in list_rows(db)}
        parents: dict[str, list[Any]] = defaultdict(list)
        children = []
        links = db.execute(select(DERIVED_FROM)).all()
        for row in sorted(
            links, key=lambda row: (row.role, every[row.parent]["name"], every[row.child]["name"])
        ):
            parents[row.child].append(row)
            if row.parent == full_id:
                children.append({**_summarise_row(every[row.child]), "role": row.role})
        return RecordView(
            record=_make_record(db, every[full_id]),
            derived_from=list(_iterate_sources(full_id, parents, every)),
            used_by=children,
            unlinked=[
                {"name": c.name, "role": c.role, "key": c.key} for c in find_unlinked(db, full_id)
            ],
        )


def _summarise_row(row: Mapping[str, Any]) -> dict[str, Any]:
    keys = ("id", "kind", "name", "simulated", "accepted", "withdrawn")
    return {key: row[key] for key in keys}


def _iterate_sources(
    ident: str, parents: Mapping[str, Sequence[Any]], rows: Mapping[str, Mapping[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield the sources of a record, nearest first; `child` is derived from the source."""
    links: set[tuple[str, str, str]] = set()
    waiting = [ident]
    for child in waiting:
        for row in parents.get(child, ()):
            if (child, row.parent, row.role) not in links:
                links.add((child, row.parent, row.role))
                waiting.append(row.parent)
                yield {**_summarise_row(rows[row.parent]), "role": row.role, "child": child}


def _make_record(db: Connection, row: Mapping[str, Any]) -> dict[str, Any]:
    has_same_id = ENTRIES.c.id == row["id"]
    software, content = db.execute(
        select(ENTRIES.c.software, ENTRIES.c.content).where(has_same_id)
    ).one()
    file = db.execute(select(FILES).where(FILES.c.id == row["id"])).mappings().first()
    if not KINDS[row["kind"]].columns:
        content = {} if file is None else file
    record = {**row, "software": software}
    record |= {key: value for key, value in content.items() if key not in record}
    for key in ("result", "checks", "covariance"):
        if record.get(key):
            record[key] = _parse_json(str(record[key]))
    if row["kind"] == "calibration":
        record["method"] = row["name"]
    keys = ("name", "folder", "host", "bytes", "sha256")
    record["added_from"] = None if file is None else {key: file[key] for key in keys}
    mark = db.execute(select(WITHDRAWN).where(WITHDRAWN.c.id == row["id"])).mappings().first()
    record["withdrawn"] = (
        None if mark is None else {key: mark[key] for key in ("when", "why", "by")}
    )
    return record


def _parse_json(text: str) -> Any:
    """Return the value of a JSON text, or any other text unchanged."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def verify_files(database: Database, folders: Sequence[str | Path] = ()) -> Verification:
    """Compare every file that is not withdrawn, and every text in the tables, with its digest.

    A file that has been moved is searched for by name in `folders`.
    """
    result = Verification()
    with database.open_snapshot() as db:
        if db is None:
            return result
        withdrawn_ids = {row.id for row in db.execute(select(WITHDRAWN.c.id))}
        files = [dict(row) for row in db.execute(select(FILES)).mappings()]
        texts = db.execute(select(ENTRIES).where(ENTRIES.c.kind.in_(["brake", "line"]))).all()
    for file in files:
        if file["id"] in withdrawn_ids:
            continue
        result.checked += 1
        state = _check_file_state(file, folders)
        if state:
            keys = ("id", "kind", "name", "folder", "host", "sha256")
            row = {key: file[key] for key in keys}
            (result.changed if state == "changed" else result.missing).append(row)
    for text in texts:
        result.checked += 1
        digest = text.content["sha256"]
        if text_digest(text.content["toml"]) != digest:
            entry = {"id": text.id, "kind": text.kind, "name": text.name}
            result.changed.append({**entry, "folder": None, "host": None, "sha256": digest})
    return result


def _check_file_state(file: Mapping[str, Any], folders: Sequence[str | Path]) -> str:
    """Return "changed", "missing" or, for an unchanged file, ""."""
    origin = Path(file["folder"]) / file["name"]
    digests = {
        path: _hash_file(path) for path in (origin, *(Path(f) / file["name"] for f in folders))
    }
    if file["sha256"] in digests.values():
        return ""
    # the same path on a different computer is a different file
    is_here = file["host"] == node()
    return "changed" if is_here and digests[origin] is not None else "missing"


def _hash_file(path: Path) -> str | None:
    try:
        return sha256(str(path)) if path.is_file() else None
    except OSError:
        return None
