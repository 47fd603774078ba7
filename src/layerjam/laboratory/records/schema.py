"""The tables of the records; the database itself rejects changes and deletions of rows.

`entries` contains every record of any kind, with its own data as JSON; a view shows each kind as a
table. `keys` contains the keys by which others may cite a record, `cited` the sources that a record
cites. The view `derived_from` joins both, so that a link appears as soon as both ends exist. Times
are text, UTC in RFC 3339 with `Z`, because SQLite stores no time zones. An `id` is a UUID.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    DDL,
    JSON,
    Boolean,
    Column,
    Connection,
    ForeignKey,
    Index,
    Integer,
    MetaData,
    Select,
    Table,
    Text,
    event,
    select,
)

from layerjam.laboratory.records.pieces import Cited

VERSION = 2
METADATA = MetaData()
NEVER = "a row of the records is never changed; withdraw the record instead"


def _origin_columns() -> Iterable[Column[Any]]:
    """Return columns for the time, program and user of a row."""
    return [Column(name, Text, nullable=False) for name in ("made_at", "software", "by")]


def _id_column(name: str) -> Column[Any]:
    return Column(name, Text, ForeignKey("entries.id"), primary_key=True)


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
    Column("name", Text, nullable=False),
    *_origin_columns(),
    Column("simulated", Boolean),
    Column("identity", Text, nullable=False, unique=True),
    Column("content", JSON, nullable=False),
)
"""Every record. `identity` distinguishes it from all others of its kind. `simulated` is NULL if
unknown, and `content` contains the columns of its kind."""
FILES = Table(
    "files",
    METADATA,
    _id_column("id"),
    *_origin_columns(),
    Column("sha256", Text, nullable=False, unique=True),
    Column("bytes", Integer, nullable=False),
    Column("kind", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("folder", Text, nullable=False),
    Column("host", Text, nullable=False),
    Column("simulated", Boolean),
)
"""Files that were added, with their records; `folder` and `host` were the location at that time."""
KEYS = Table("keys", METADATA, _id_column("id"), Column("key", Text, primary_key=True, index=True))
"""Digests of a record's file and text, a run's number, and the record's id."""
CITED = Table(
    "cited",
    METADATA,
    _id_column("child"),
    Column("key", Text, primary_key=True),
    Column("role", Text, primary_key=True),
    Column("name", Text, nullable=False),
    Index("cited_by_key", "key"),
)
"""Keys of a record's sources, which may be added later."""
WITHDRAWN = Table(
    "withdrawn",
    METADATA,
    _id_column("id"),
    Column("when", Text, nullable=False),
    Column("why", Text, nullable=False),
    Column("by", Text, nullable=False),
)
LINKS = (
    select(CITED.c.child, KEYS.c.id.label("parent"), CITED.c.role)
    .join(KEYS, KEYS.c.key == CITED.c.key)
    .where(KEYS.c.id != CITED.c.child)
    .distinct()
)
DERIVED_FROM = LINKS.subquery("derived_from")
"""Links between records: child, parent and role."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of record: its view and its columns, some of which name, identify or cite a record."""

    view: str | None = None
    columns: tuple[str, ...] = ()
    name_column: str = "name"
    identity: tuple[str, ...] = ("sha256",)
    keys: tuple[str, ...] = ()


TYPES = {
    "samples": "as_integer",
    "gaps": "as_integer",
    "zero": "as_float",
    "gain": "as_float",
    "simulated": "as_boolean",
}
"""{column: accessor in a view}; other columns are text."""
_BRAKE = Kind(
    view="brakes",
    columns=("name", "serial", "toml", "sha256", "rendered_sha256", "parent"),
    keys=("sha256", "rendered_sha256"),
)
"""`parent` is the digest of the text from which this text was derived."""
_FILE = Kind()
KINDS = {
    "brake": _BRAKE,
    "line": replace(_BRAKE, view="lines"),
    "board": Kind(
        view="boards",
        columns=("serial", "model", "firmware"),
        name_column="serial",
        identity=("serial",),
    ),
    "sensor calibration": Kind(
        view="sensor_calibrations",
        columns=("board", "said", "zero", "gain", "name"),
        name_column="said",
        identity=("board", "said"),
    ),
    "run": Kind(
        view="runs",
        columns=(
            *("brake", "line", "board", "sensor_calibration", "run_id", "procedure", "outcome"),
            *("simulated", "samples", "gaps", "started", "ended", "firmware", "law_sha256"),
            *("file_sha256", "file", "settings_hex", "safe_state"),
        ),
        name_column="file",
        identity=("file_sha256",),
        keys=("run_id",),
    ),
    "calibration": Kind(
        view="calibrations",
        columns=(
            *("brake", "kind", "result", "covariance", "checks", "result_toml", "sha256"),
            "simulated",
        ),
        name_column="kind",
    ),
    "data": _FILE,
    "facts": _FILE,
    "export": _FILE,
}
"""{kind of record: definition}. The `brake` of a calibration is the calibrated brake, if it was in
the database at that time. Data, metadata and exports have only their file."""


def utc_timestamp() -> str:
    """Return the current time in UTC to the millisecond (RFC 3339): 2026-11-23T03:27:39.123Z."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def identity(kind: str, columns: Mapping[str, Any]) -> str:
    """Return the text that distinguishes a record from all others."""
    return " ".join([kind, *(str(columns[name]) for name in KINDS[kind].identity)])


def insert_record(
    db: Connection, ident: str, kind: str, origin: Mapping[str, str], columns: Mapping[str, Any]
) -> None:
    """Write one record with its keys; `origin` contains the time, the program and the user."""
    spec = KINDS[kind]
    row = {
        "id": ident,
        "kind": kind,
        "name": columns[spec.name_column],
        "simulated": columns.get("simulated"),
        "identity": identity(kind, columns),
        "content": {name: columns.get(name) for name in spec.columns},
    }
    db.execute(ENTRIES.insert().values(**row, **origin))
    add_keys(db, ident, [ident, *(columns[name] for name in spec.keys)])


def add_keys(db: Connection, ident: str, keys: Iterable[str | None]) -> None:
    """Add keys by which others may cite a record."""
    keys_before = {row.key for row in db.execute(select(KEYS.c.key).where(KEYS.c.id == ident))}
    for key in dict.fromkeys(keys):
        if key and key not in keys_before:
            db.execute(KEYS.insert().values(id=ident, key=key))


def insert_citations(db: Connection, child: str, cited: Iterable[Cited]) -> None:
    """Write the sources of a record."""
    unique = {(citation.key, citation.role): citation.name for citation in cited}
    for (key, role), name in unique.items():
        db.execute(CITED.insert().values(child=child, key=key, role=role, name=name))


def _create_view(name: str, query: Select[Any]) -> None:
    def create_view(_target: MetaData, db: Connection, **_: Any) -> None:
        columns = ", ".join(f'"{column.name}"' for column in query.selected_columns)
        text = query.compile(dialect=db.dialect, compile_kwargs={"literal_binds": True})
        db.exec_driver_sql(f'CREATE VIEW "{name}" ({columns}) AS {text}')

    event.listen(METADATA, "after_create", create_view)


def _select_kind(kind: str, spec: Kind) -> Select[Any]:
    """Return a query for the records of a kind, with their content as columns."""
    common = [ENTRIES.c[name] for name in ("id", "made_at", "software", "by")]
    columns = [
        getattr(ENTRIES.c.content[name], TYPES.get(name, "as_string"))().label(name)
        for name in spec.columns
    ]
    return select(*common, *columns).where(ENTRIES.c.kind == kind)


_FUNCTION = f"""
CREATE OR REPLACE FUNCTION records_never_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION '{NEVER}'; END $$
"""


def _create_guard(table: Table) -> None:
    """Create, with a table, triggers that reject changes to its rows."""
    for act in ("update", "delete"):
        head = f'CREATE TRIGGER "{table.name}_no_{act}" BEFORE {act.upper()} ON "{table.name}" '
        sqlite = DDL(head + f"BEGIN SELECT RAISE(ABORT, '{NEVER}'); END")
        postgres = DDL(head + "FOR EACH ROW EXECUTE FUNCTION records_never_change()")
        event.listen(table, "after_create", sqlite.execute_if(dialect="sqlite"))
        event.listen(table, "after_create", postgres.execute_if(dialect="postgresql"))


event.listen(METADATA, "before_create", DDL(_FUNCTION).execute_if(dialect="postgresql"))
for _table in METADATA.tables.values():
    _create_guard(_table)
_create_view("derived_from", LINKS)
for _kind, _spec in KINDS.items():
    if _spec.view:
        _create_view(_spec.view, _select_kind(_kind, _spec))
