"""The tables. A row is never changed nor taken away: the database itself refuses it.

Times are text, UTC in RFC 3339 with `Z`, for SQLite loses the zone of a time. An `id` is a UUID.
One record has one id in `entries` and in the tables that describe it: a brake's file has a row in
`brakes` and one in `files`.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy import (
    DDL,
    Boolean,
    Column,
    Float,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Table,
    Text,
    UniqueConstraint,
    event,
)

VERSION = 1
METADATA = MetaData()
NEVER = "a row of the records is never changed; withdraw the record instead"


def _table(name: str, *columns: Any) -> Table:
    """A table of records: id, when and by whom it was made, and its own columns."""
    return Table(
        name,
        METADATA,
        Column("id", Text, ForeignKey("entries.id"), primary_key=True),
        Column("made_at", Text, nullable=False),
        Column("software", Text, nullable=False),
        Column("by", Text, nullable=False),
        *columns,
    )


VERSIONS = Table(
    "schema_version",
    METADATA,
    Column("version", Integer, primary_key=True),
    Column("made_at", Text, nullable=False),
    Column("software", Text, nullable=False),
)
ENTRIES = Table(
    "entries",
    METADATA,
    Column("id", Text, primary_key=True),
    Column("kind", Text, nullable=False),
)
"""Every record; `kind` is brake, line, board, sensor calibration, run, calibration, data, facts or
export."""


def _made_of_text(name: str) -> Table:
    """Brakes or lines: `parent` is the digest of the text that this one was made from."""
    return _table(
        name,
        Column("name", Text, nullable=False),
        Column("serial", Text),
        Column("toml", Text, nullable=False),
        Column("sha256", Text, nullable=False, unique=True),
        Column("rendered_sha256", Text, nullable=False, index=True),
        Column("parent", Text),
    )


BRAKES = _made_of_text("brakes")
LINES = _made_of_text("lines")
BOARDS = _table(
    "boards",
    Column("serial", Text, nullable=False, unique=True),
    Column("model", Text),
    Column("firmware", Text),
)
SENSOR_CALIBRATIONS = _table(
    "sensor_calibrations",
    Column("board", Text, ForeignKey("boards.id"), nullable=False),
    Column("said", Text, nullable=False),
    Column("zero", Float),
    Column("gain", Float),
    Column("name", Text),
    UniqueConstraint("board", "said"),
)
RUNS = _table(
    "runs",
    Column("brake", Text, ForeignKey("brakes.id")),
    Column("line", Text, ForeignKey("lines.id")),
    Column("board", Text, ForeignKey("boards.id")),
    Column("sensor_calibration", Text, ForeignKey("sensor_calibrations.id")),
    Column("run_id", Text, index=True),
    Column("procedure", Text),
    Column("outcome", Text),
    Column("simulated", Boolean, nullable=False),
    Column("samples", Integer, nullable=False),
    Column("gaps", Integer, nullable=False),
    Column("started", Text),
    Column("ended", Text),
    Column("firmware", Text),
    Column("law_sha256", Text),
    Column("file_sha256", Text, nullable=False, unique=True),
    Column("file", Text, nullable=False),
    Column("settings_hex", Text),
    Column("safe_state", Text),
)
FILES = _table(
    "files",
    Column("sha256", Text, nullable=False, unique=True),
    Column("bytes", Integer, nullable=False),
    Column("kind", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("folder", Text, nullable=False),
    Column("host", Text, nullable=False),
    Column("simulated", Boolean),
)
"""`folder` and `host` say where it lay when it was added; `simulated` is NULL where nobody says."""
CALIBRATIONS = _table(
    "calibrations",
    Column("brake", Text, ForeignKey("brakes.id")),
    Column("kind", Text, nullable=False),
    Column("result", Text, nullable=False),
    Column("covariance", Text),
    Column("checks", Text),
    Column("result_toml", Text),
    Column("sha256", Text, nullable=False, unique=True),
    Column("simulated", Boolean),
)
"""`brake` is the one that was calibrated, where it was in the records then."""
DERIVED_FROM = Table(
    "derived_from",
    METADATA,
    Column("child", Text, ForeignKey("entries.id"), primary_key=True),
    Column("parent", Text, ForeignKey("entries.id"), primary_key=True),
    Column("role", Text, primary_key=True),
)
CITED = Table(
    "cited",
    METADATA,
    Column("child", Text, ForeignKey("entries.id"), primary_key=True),
    Column("key", Text, primary_key=True),
    Column("role", Text, primary_key=True),
    Column("name", Text, nullable=False),
    Index("cited_by_key", "key"),
)
"""What a record says it comes from: the digest of a file or text, or the number of a run. It is in
`derived_from` too as soon as that is in the records."""
WITHDRAWN = Table(
    "withdrawn",
    METADATA,
    Column("id", Text, ForeignKey("entries.id"), primary_key=True),
    Column("when", Text, nullable=False),
    Column("why", Text, nullable=False),
    Column("by", Text, nullable=False),
)
TYPED = {
    "brake": BRAKES,
    "line": LINES,
    "board": BOARDS,
    "sensor calibration": SENSOR_CALIBRATIONS,
    "run": RUNS,
    "calibration": CALIBRATIONS,
    "data": FILES,
    "facts": FILES,
    "export": FILES,
}
"""{kind of record: the table that describes it}."""

_FUNCTION = f"""
CREATE FUNCTION records_never_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION '{NEVER}'; END $$
"""


def _guard(table: Table) -> None:
    """Triggers that refuse a change of a table's rows, when the table is made."""
    for act in ("update", "delete"):
        head = f'CREATE TRIGGER "{table.name}_no_{act}" BEFORE {act.upper()} ON "{table.name}" '
        sqlite = DDL(head + f"BEGIN SELECT RAISE(ABORT, '{NEVER}'); END")
        postgres = DDL(head + "FOR EACH ROW EXECUTE FUNCTION records_never_change()")
        event.listen(table, "after_create", sqlite.execute_if(dialect="sqlite"))
        event.listen(table, "after_create", postgres.execute_if(dialect="postgresql"))


event.listen(METADATA, "before_create", DDL(_FUNCTION).execute_if(dialect="postgresql"))
for _each in METADATA.tables.values():
    _guard(_each)
