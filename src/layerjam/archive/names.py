"""What records are called, and which one is meant."""

from __future__ import annotations

from sqlalchemy import Connection, select

from layerjam.archive.move import RecordsError
from layerjam.archive.schema import (
    BOARDS,
    BRAKES,
    CALIBRATIONS,
    ENTRIES,
    FILES,
    LINES,
    RUNS,
    SENSOR_CALIBRATIONS,
    WITHDRAWN,
)

SHORTEST = 4
"""Characters of an id that are needed at least to name a record."""
NAMES = {
    BRAKES: BRAKES.c.name,
    LINES: LINES.c.name,
    BOARDS: BOARDS.c.serial,
    SENSOR_CALIBRATIONS: SENSOR_CALIBRATIONS.c.said,
    RUNS: RUNS.c.file,
    CALIBRATIONS: CALIBRATIONS.c.kind,
    FILES: FILES.c.name,
}
"""What a record is called, by its table."""


def named(db: Connection | None, said: str, where: str) -> str:
    """The id of the record that is meant: by the first characters of its id, or by its name.

    Of several with one name the one counts that is not withdrawn. Raises RecordsError where none
    or several are meant.
    """
    found = [] if db is None else _by_id(db, said.strip().lower()) or _by_name(db, said)
    if not found:
        raise RecordsError(
            f"{where}: holds no record '{said[:80]}'; give a name, an id, or the first {SHORTEST} "
            "characters of one or more, as 'layerjam records list' shows them"
        )
    if len(found) > 1:
        raise RecordsError(
            f"'{said[:80]}' names several records ({', '.join(found[:3])}); give the id of one"
        )
    return found[0]


def _by_id(db: Connection, start: str) -> list[str]:
    """Ids that begin so."""
    if len(start) < SHORTEST or not set(start) <= set("0123456789abcdef-"):
        return []
    wanted = select(ENTRIES.c.id).where(ENTRIES.c.id.startswith(start)).limit(4)
    return [str(row.id) for row in db.execute(wanted)]


def _by_name(db: Connection, said: str) -> list[str]:
    """Ids of records of this name; those that are not withdrawn where there are any."""
    found = {
        str(row.id)
        for table, name in NAMES.items()
        for row in db.execute(select(table.c.id).where(name == said))
    }
    gone = {str(row.id) for row in db.execute(select(WITHDRAWN.c.id))}
    return sorted(found - gone or found)
