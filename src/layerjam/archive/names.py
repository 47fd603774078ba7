"""Which record is meant: by a name or an id, or by what others cite it by."""

from __future__ import annotations

from sqlalchemy import Connection, select

from layerjam.archive.database import RecordsError
from layerjam.archive.pieces import Cited
from layerjam.archive.schema import CITED, ENTRIES, KEYS, WITHDRAWN

SHORTEST = 4
"""Characters of an id that are needed at least to name a record."""


def resolve_record_id(db: Connection | None, text: str, where: str) -> str:
    """Return the id of the record that is meant: by the first characters of its id, or its name.

    If several have one name, the one that is not withdrawn counts. Raises RecordsError if none or
    several are meant.
    """
    found = [] if db is None else _by_id(db, text.strip().lower()) or _by_name(db, text)
    if not found:
        raise RecordsError(
            f"{where}: holds no record '{text[:80]}'; give a name, an id, or the first {SHORTEST} "
            "characters of one or more, as 'layerjam records list' shows them"
        )
    if len(found) > 1:
        raise RecordsError(
            f"'{text[:80]}' names several records ({', '.join(found[:3])}); give the id of one"
        )
    return found[0]


def _by_id(db: Connection, start: str) -> list[str]:
    """Ids that begin so."""
    if len(start) < SHORTEST or not set(start) <= set("0123456789abcdef-"):
        return []
    wanted = select(ENTRIES.c.id).where(ENTRIES.c.id.startswith(start)).limit(4)
    return list(db.execute(wanted).scalars())


def _by_name(db: Connection, name: str) -> list[str]:
    """Ids of records of this name; those that are not withdrawn if there are any."""
    found = set(db.execute(select(ENTRIES.c.id).where(ENTRIES.c.name == name)).scalars())
    gone = set(db.execute(select(WITHDRAWN.c.id)).scalars())
    return sorted(found - gone or found)


def holder(db: Connection, kind: str, *keys: str) -> str | None:
    """Return the first record of a kind that may be cited by one of these keys, or None."""
    wanted = select(ENTRIES.c.id).join(KEYS).where(ENTRIES.c.kind == kind, KEYS.c.key.in_(keys))
    return db.execute(wanted.order_by(ENTRIES.c.made_at, ENTRIES.c.id)).scalar()


def unlinked(db: Connection, child: str) -> list[Cited]:
    """Return what a record says it comes from and the records do not hold."""
    columns = (CITED.c.key, CITED.c.role, CITED.c.name)
    missing = select(*columns).outerjoin(KEYS, KEYS.c.key == CITED.c.key)
    wanted = missing.where(CITED.c.child == child, KEYS.c.id.is_(None)).order_by(CITED.c.name)
    return [Cited(*row) for row in db.execute(wanted)]
