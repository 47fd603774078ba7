"""The tables of the records. The database itself refuses to change or delete a row.

`entries` holds every record, whatever its kind, with its own facts as JSON; a view shows each kind
as a table of its own. `keys` holds what others may cite a record by, `cited` what a record says it
comes from. The view `derived_from` joins these two, so that a link is there as soon as both ends
are. Times are text, UTC in RFC 3339 with `Z`, because SQLite loses the zone of a time. An `id` is a
UUID.
"""

from __future__ import annotations

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

from layerjam.archive.pieces import Cited

VERSION = 2
METADATA = MetaData()
NEVER = "a row of the records is never changed; withdraw the record instead"


def _stamped() -> Iterable[Column[Any]]:
    """When, by what and by whom a row was made."""
    return [Column(name, Text, nullable=False) for name in ("made_at", "software", "by")]


def _entry(name: str) -> Column[Any]:
    """A record's id, as a part of the primary key."""
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
    *_stamped(),
    Column("simulated", Boolean),
    Column("identity", Text, nullable=False, unique=True),
    Column("content", JSON, nullable=False),
)
"""Every record. `identity` distinguishes it from all others of its kind; `simulated` is NULL if
nobody says; `content` has the columns of its kind."""
FILES = Table(
    "files",
    METADATA,
    _entry("id"),
    *_stamped(),
    Column("sha256", Text, nullable=False, unique=True),
    Column("bytes", Integer, nullable=False),
    Column("kind", Text, nullable=False),
    Column("name", Text, nullable=False),
    Column("folder", Text, nullable=False),
    Column("host", Text, nullable=False),
    Column("simulated", Boolean),
)
"""Files that were added, by the record they are: `folder` and `host` say where they were then."""
KEYS = Table("keys", METADATA, _entry("id"), Column("key", Text, primary_key=True, index=True))
"""Digests of a record's file and text, the number of a run, and its own id."""
CITED = Table(
    "cited",
    METADATA,
    _entry("child"),
    Column("key", Text, primary_key=True),
    Column("role", Text, primary_key=True),
    Column("name", Text, nullable=False),
    Index("cited_by_key", "key"),
)
"""Keys of the records that a record comes from; such a record may be added later."""
WITHDRAWN = Table(
    "withdrawn",
    METADATA,
    _entry("id"),
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
"""Which record was derived from which, and in what role."""


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of record: its view and columns, and which of them name, identify and cite one."""

    view: str | None = None
    columns: tuple[str, ...] = ()
    called: str = "name"
    identity: tuple[str, ...] = ("sha256",)
    keys: tuple[str, ...] = ()


TYPES = {
    "samples": "as_integer",
    "gaps": "as_integer",
    "zero": "as_float",
    "gain": "as_float",
    "simulated": "as_boolean",
}
"""{column: how a view reads it}; the others are text."""
_BRAKE = Kind(
    view="brakes",
    columns=("name", "serial", "toml", "sha256", "rendered_sha256", "parent"),
    keys=("sha256", "rendered_sha256"),
)
"""`parent` is the digest of the text that this one was made from."""
_FILE = Kind()
KINDS = {
    "brake": _BRAKE,
    "line": replace(_BRAKE, view="lines"),
    "board": Kind(
        view="boards",
        columns=("serial", "model", "firmware"),
        called="serial",
        identity=("serial",),
    ),
    "sensor calibration": Kind(
        view="sensor_calibrations",
        columns=("board", "said", "zero", "gain", "name"),
        called="said",
        identity=("board", "said"),
    ),
    "run": Kind(
        view="runs",
        columns=(
            *("brake", "line", "board", "sensor_calibration", "run_id", "procedure", "outcome"),
            *("simulated", "samples", "gaps", "started", "ended", "firmware", "law_sha256"),
            *("file_sha256", "file", "settings_hex", "safe_state"),
        ),
        called="file",
        identity=("file_sha256",),
        keys=("run_id",),
    ),
    "calibration": Kind(
        view="calibrations",
        columns=(
            *("brake", "kind", "result", "covariance", "checks", "result_toml", "sha256"),
            "simulated",
        ),
        called="kind",
    ),
    "data": _FILE,
    "facts": _FILE,
    "export": _FILE,
}
"""{kind of record: what it has}. The `brake` of a calibration is the one that was calibrated, if it
was in the records then. Data, facts and exports have nothing but their file."""


def utc_timestamp() -> str:
    """Return the moment, UTC in RFC 3339 to the millisecond: 2026-11-23T03:27:39.123Z."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def identity(kind: str, columns: Mapping[str, Any]) -> str:
    """Return the text that distinguishes a record from all others."""
    return " ".join([kind, *(str(columns[name]) for name in KINDS[kind].identity)])


def enter(
    db: Connection, ident: str, kind: str, made: Mapping[str, str], columns: Mapping[str, Any]
) -> None:
    """Write one record with its keys; `made` has when, by what and by whom it is made."""
    about = KINDS[kind]
    row = {
        "id": ident,
        "kind": kind,
        "name": columns[about.called],
        "simulated": columns.get("simulated"),
        "identity": identity(kind, columns),
        "content": {name: columns.get(name) for name in about.columns},
    }
    db.execute(ENTRIES.insert().values(**row, **made))
    add_keys(db, ident, [ident, *(columns[name] for name in about.keys)])


def add_keys(db: Connection, ident: str, keys: Iterable[str | None]) -> None:
    """Let others cite a record by these keys too."""
    there = {row.key for row in db.execute(select(KEYS.c.key).where(KEYS.c.id == ident))}
    for key in dict.fromkeys(keys):
        if key and key not in there:
            db.execute(KEYS.insert().values(id=ident, key=key))


def cite(db: Connection, child: str, cited: Iterable[Cited]) -> None:
    """Write what a record says it comes from."""
    unique = {(one.key, one.role): one.name for one in cited}
    for (key, role), name in unique.items():
        db.execute(CITED.insert().values(child=child, key=key, role=role, name=name))


def _view(name: str, query: Select[Any]) -> None:
    """Have a view made after the tables."""

    def create(_target: MetaData, db: Connection, **_: Any) -> None:
        columns = ", ".join(f'"{column.name}"' for column in query.selected_columns)
        text = query.compile(dialect=db.dialect, compile_kwargs={"literal_binds": True})
        db.exec_driver_sql(f'CREATE VIEW "{name}" ({columns}) AS {text}')

    event.listen(METADATA, "after_create", create)


def _of_kind(kind: str, about: Kind) -> Select[Any]:
    """Select the records of a kind with their content as columns."""
    common = [ENTRIES.c[name] for name in ("id", "made_at", "software", "by")]
    own = [
        getattr(ENTRIES.c.content[name], TYPES.get(name, "as_string"))().label(name)
        for name in about.columns
    ]
    return select(*common, *own).where(ENTRIES.c.kind == kind)


_FUNCTION = f"""
CREATE OR REPLACE FUNCTION records_never_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN RAISE EXCEPTION '{NEVER}'; END $$
"""


def _guard(table: Table) -> None:
    """Have triggers made with a table that refuse a change of its rows."""
    for act in ("update", "delete"):
        head = f'CREATE TRIGGER "{table.name}_no_{act}" BEFORE {act.upper()} ON "{table.name}" '
        sqlite = DDL(head + f"BEGIN SELECT RAISE(ABORT, '{NEVER}'); END")
        postgres = DDL(head + "FOR EACH ROW EXECUTE FUNCTION records_never_change()")
        event.listen(table, "after_create", sqlite.execute_if(dialect="sqlite"))
        event.listen(table, "after_create", postgres.execute_if(dialect="postgresql"))


event.listen(METADATA, "before_create", DDL(_FUNCTION).execute_if(dialect="postgresql"))
for _each in METADATA.tables.values():
    _guard(_each)
_view("derived_from", LINKS)
for _kind, _about in KINDS.items():
    if _about.view:
        _view(_about.view, _of_kind(_kind, _about))
