"""Identification of a record by name, by id, or by a key that others cite."""

from sqlalchemy import Connection, select

from layerjam.laboratory.records.database import RecordsError
from layerjam.laboratory.records.pieces import Cited
from layerjam.laboratory.records.schema import CITED, ENTRIES, KEYS, WITHDRAWN

SHORTEST = 4
"""Minimum number of characters of an id that identify a record."""


def resolve_record_id(db: Connection | None, text: str, place: str) -> str:
    """Return the id of a record, given its name or the first characters of its id.

    If several have the same name, the one that is not withdrawn is used. Raises RecordsError if no
    record matches, or several do.
    """
    ids = [] if db is None else _find_by_id(db, text.strip().lower()) or _find_by_name(db, text)
    if not ids:
        raise RecordsError(
            f"{place}: contains no record '{text[:80]}'; use a name, an id, or at least the first "
            f"{SHORTEST} characters of an id, as listed by 'layerjam records list'"
        )
    if len(ids) > 1:
        raise RecordsError(
            f"'{text[:80]}' matches several records ({', '.join(ids[:3])}); use the id of one"
        )
    return ids[0]


def _find_by_id(db: Connection, start: str) -> list[str]:
    if len(start) < SHORTEST or not set(start) <= set("0123456789abcdef-"):
        return []
    query = select(ENTRIES.c.id).where(ENTRIES.c.id.startswith(start)).limit(4)
    return list(db.execute(query).scalars())


def _find_by_name(db: Connection, name: str) -> list[str]:
    """Return the ids of records with this name; withdrawn ones only if there are no others."""
    ids = set(db.execute(select(ENTRIES.c.id).where(ENTRIES.c.name == name)).scalars())
    withdrawn_ids = set(db.execute(select(WITHDRAWN.c.id)).scalars())
    return sorted(ids - withdrawn_ids or ids)


def find_by_key(db: Connection, kind: str, *keys: str) -> str | None:
    """Return the id of the first record of a kind that has one of these keys, or None."""
    query = select(ENTRIES.c.id).join(KEYS).where(ENTRIES.c.kind == kind, KEYS.c.key.in_(keys))
    return db.execute(query.order_by(ENTRIES.c.made_at, ENTRIES.c.id)).scalar()


def find_unlinked(db: Connection, child: str) -> list[Cited]:
    """Return the sources that a record cites but that are not in the database."""
    columns = (CITED.c.key, CITED.c.role, CITED.c.name)
    citations = select(*columns).outerjoin(KEYS, KEYS.c.key == CITED.c.key)
    query = citations.where(CITED.c.child == child, KEYS.c.id.is_(None)).order_by(CITED.c.name)
    return [Cited(*row) for row in db.execute(query)]
