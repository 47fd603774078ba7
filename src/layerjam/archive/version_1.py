"""Upgrade from version 1, which had one table for each kind of record."""

from __future__ import annotations

from typing import Any

from sqlalchemy import Connection, select, text

from layerjam.archive.pieces import Cited
from layerjam.archive.schema import (
    CITED,
    DERIVED_FROM,
    FILES,
    KINDS,
    METADATA,
    VERSIONS,
    WITHDRAWN,
    add_keys,
    cite,
    enter,
)

TYPED = {spec.view: kind for kind, spec in KINDS.items() if spec.view}
KEPT = {table.name: table for table in (FILES, CITED, WITHDRAWN, VERSIONS)}
ORDER = (
    *("derived_from", "cited", "withdrawn", "files", "runs", "calibrations"),
    *("sensor_calibrations", "boards", "brakes", "lines", "entries", "schema_version"),
)
"""Tables of version 1; those that refer to others come first."""


def move_typed_tables(db: Connection) -> None:
    """Upgrade tables of version 1 to version 2."""
    old = {name: _rows(db, name) for name in ORDER}
    for name in ORDER:
        db.execute(text(f"DROP TABLE {name}"))
    METADATA.create_all(db, checkfirst=False)
    kinds = {row["id"]: row["kind"] for row in old["entries"]}
    done_ids = set()
    for name in reversed(ORDER):
        for row in old[name] if name in TYPED or name == "files" else ():
            if row["id"] not in done_ids:
                done_ids.add(row["id"])
                origin = {key: row[key] for key in ("made_at", "software", "by")}
                enter(db, row["id"], kinds[row["id"]], origin, row)
    for name, table in KEPT.items():
        for row in old[name]:
            db.execute(table.insert().values(**row))
    for row in old["files"]:
        add_keys(db, row["id"], [row["sha256"]])
    links = {tuple(row) for row in db.execute(select(DERIVED_FROM))}
    for link in old["derived_from"]:
        if (link["child"], link["parent"], link["role"]) not in links:
            cite(db, link["child"], [Cited(link["parent"], link["role"], "")])


def _rows(db: Connection, table: str) -> list[dict[str, Any]]:
    """Return the rows of a table; SQLite stores a bool as 0 or 1."""
    rows = [dict(row) for row in db.execute(text(f"SELECT * FROM {table}")).mappings()]
    for row in rows:
        if row.get("simulated") is not None:
            row["simulated"] = bool(row["simulated"])
    return rows
