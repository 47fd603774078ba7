"""Versions of the tables: an empty database gets them, an older one is brought up, others refused.

A step goes from one version to the next, in one transaction with all others.
"""

from __future__ import annotations

from collections.abc import Callable

from sqlalchemy import Connection, func, inspect, select

from layerjam._version import __version__
from layerjam.archive.schema import METADATA, VERSION, VERSIONS
from layerjam.archive.times import now
from layerjam.errors import LayerjamError

STEPS: dict[int, Callable[[Connection], None]] = {}
"""{version: what brings the tables of that version to the next}."""


class RecordsError(LayerjamError):
    """A database of records that cannot be had, or is none."""

    key = "records"


def version_of(db: Connection, where: str) -> int | None:
    """The version of the tables, None for an empty database; RecordsError for another's."""
    tables = set(inspect(db).get_table_names())
    if VERSIONS.name in tables and "entries" in tables:
        found = db.execute(select(func.max(VERSIONS.c.version))).scalar()
        if found is not None:
            return int(found)
    if tables:
        some = ", ".join(sorted(tables)[:3])
        raise RecordsError(
            f"{where}: holds other tables ({some}), no records of layerjam; name another database"
        )
    return None


def check_version(found: int, where: str) -> None:
    """Raise RecordsError for tables that this program cannot read as they are."""
    if found > VERSION:
        raise RecordsError(
            f"{where}: its tables have version {found}, and this layerjam ({__version__}) knows "
            f"versions up to {VERSION}; update layerjam"
        )
    missing = [version for version in range(found, VERSION) if version not in STEPS]
    if missing:
        raise RecordsError(
            f"{where}: its tables have version {found}, and no step leads from version "
            f"{missing[0]} to {VERSION}; use the layerjam that made them"
        )


def brought_up(db: Connection, where: str) -> None:
    """Make the tables, or bring older ones up; inside a transaction of the caller."""
    found = version_of(db, where)
    if found is None:
        METADATA.create_all(db, checkfirst=False)
        _state(db, VERSION)
        return
    check_version(found, where)
    for version in range(found, VERSION):
        STEPS[version](db)
        _state(db, version + 1)


def _state(db: Connection, version: int) -> None:
    """Note that the tables have this version now."""
    made = {"version": version, "made_at": now(), "software": f"layerjam {__version__}"}
    db.execute(VERSIONS.insert().values(**made))
