"""Database of the records: a SQLite file, or a PostgreSQL server by URL."""

import contextlib
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import platformdirs
from sqlalchemy import (
    URL,
    Connection,
    Engine,
    create_engine,
    event,
    func,
    inspect,
    make_url,
    select,
    text,
)
from sqlalchemy.exc import ArgumentError, DBAPIError
from sqlalchemy.pool import NullPool

from layerjam._version import __version__
from layerjam.core.errors import FileError, LayerjamError, MissingExtraError
from layerjam.core.system import check_file_name
from layerjam.laboratory.records.pieces import Cited
from layerjam.laboratory.records.schema import (
    CITED,
    DERIVED_FROM,
    FILES,
    KINDS,
    METADATA,
    VERSION,
    VERSIONS,
    WITHDRAWN,
    add_keys,
    insert_citations,
    insert_record,
    utc_timestamp,
)

TYPED = {spec.view: kind for kind, spec in KINDS.items() if spec.view}
KEPT = {table.name: table for table in (FILES, CITED, WITHDRAWN, VERSIONS)}
ORDER = (
    *("derived_from", "cited", "withdrawn", "files", "runs", "calibrations"),
    *("sensor_calibrations", "boards", "brakes", "lines", "entries", "schema_version"),
)
"""Tables of version 1, ordered so that each precedes the tables to which it refers."""


def move_typed_tables(db: Connection) -> None:
    """Upgrade tables of version 1 to version 2."""
    old = {name: _read_table_rows(db, name) for name in ORDER}
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
                insert_record(db, row["id"], kinds[row["id"]], origin, row)
    for name, table in KEPT.items():
        for row in old[name]:
            db.execute(table.insert().values(**row))
    for row in old["files"]:
        add_keys(db, row["id"], [row["sha256"]])
    links = {tuple(row) for row in db.execute(select(DERIVED_FROM))}
    for link in old["derived_from"]:
        if (link["child"], link["parent"], link["role"]) not in links:
            insert_citations(db, link["child"], [Cited(link["parent"], link["role"], "")])


def _read_table_rows(db: Connection, table: str) -> list[dict[str, Any]]:
    """Return the rows of a table, with bools, which SQLite stores as 0 or 1."""
    rows = [dict(row) for row in db.execute(text(f"SELECT * FROM {table}")).mappings()]
    for row in rows:
        if row.get("simulated") is not None:
            row["simulated"] = bool(row["simulated"])
    return rows


PATIENCE = 60
"""Maximum wait for another writer [s]."""
REACHED = 10
"""Maximum wait for the first response of a server [s]."""
LOCK = 0x4C4A5243
"""Advisory lock for writers in PostgreSQL, so that one writes at a time, as in SQLite."""
POSTGRES = ("postgresql", "postgres", "postgresql+psycopg")
STEPS: dict[int, Callable[[Connection], None]] = {1: move_typed_tables}
"""{version: function that upgrades the tables from that version to the next}."""


class RecordsError(LayerjamError):
    """The database is not available or is not a database of records."""

    key = "records"


def default_database() -> Path:
    """Return the default file of the records."""
    return Path(platformdirs.user_data_dir("layerjam")) / "records.db"


def database_url(db: str | Path | None) -> URL:
    """Return the URL of a database, given as a URL or as the path of a SQLite file.

    Raises RecordsError for an unsupported URL, and MissingExtraError if psycopg is not installed.
    """
    if db is None:
        return URL.create("sqlite", database=str(default_database()))
    if not re.match(r"[\w+]{2,}:|:", str(db)):
        return URL.create("sqlite", database=str(db))
    hint = "use sqlite:///FILE, postgresql://USER@HOST/NAME, or the path of a file"
    try:
        url = make_url(str(db))
    except (ArgumentError, ValueError):
        raise RecordsError(f"db: is not the URL of a database; {hint}") from None
    if url.drivername in POSTGRES:
        with MissingExtraError.raise_if_missing("records in PostgreSQL (psycopg)", "postgres"):
            import psycopg  # noqa: F401
        return url.set(drivername="postgresql+psycopg")
    if url.drivername == "sqlite" and url.database and url.database != ":memory:":
        return url
    raise RecordsError(f"db: {url.render_as_string(hide_password=True)} cannot be used; {hint}")


class Database:
    """A database that is opened for each transaction and closed after it."""

    def __init__(self, db: str | Path | None = None) -> None:
        self.url = database_url(db)
        self.file = Path(str(self.url.database)) if self.url.drivername == "sqlite" else None
        if self.file is not None:
            try:
                check_file_name(self.file)
            except FileError as error:
                raise RecordsError(str(error)) from None
        self.where = str(self.file or self.url.render_as_string(hide_password=True))
        self._engine = _make_engine(self.url)

    @contextlib.contextmanager
    def open_transaction(self) -> Iterator[Connection]:
        """Open a transaction for writing, after all others end; it is applied completely or not.

        Creates the database if it does not exist. Raises RecordsError.
        """
        with self._report_errors():
            if self.file is not None:
                self.file.parent.mkdir(parents=True, exist_ok=True)
            with self._engine.connect().execution_options(writes=True) as db, db.begin():
                if self.file is None:
                    db.execute(text(f"SET LOCAL lock_timeout = '{PATIENCE}s'"))
                    db.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
                _upgrade_tables(db, self.where)
                yield db

    @contextlib.contextmanager
    def open_snapshot(self) -> Iterator[Connection | None]:
        """Open a consistent snapshot of the records; None if there is no database yet."""
        if self.file is not None and not self.file.exists():
            yield None
            return
        with self._report_errors(), self._engine.connect() as db, db.begin():
            older = (_read_table_version(db, self.where) or VERSION) < VERSION
        if older:
            with self.open_transaction():
                pass
        with self._report_errors(), self._engine.connect() as db, db.begin():
            yield None if _read_table_version(db, self.where) is None else db

    @contextlib.contextmanager
    def _report_errors(self) -> Iterator[None]:
        """Convert errors of the database or the disk to a RecordsError of one sentence."""
        try:
            yield
        except DBAPIError as error:
            reason = " ".join(str(error.orig).split())[:300]
            raise RecordsError(f"{self.where}: the database reports: {reason}") from None
        except OSError as error:
            raise RecordsError(f"{self.where}: cannot be written: {error.strerror}") from None


def _read_table_version(db: Connection, place: str) -> int | None:
    """Return the version of the tables; None for an empty database.

    Raises RecordsError for tables of another program or a version that cannot be upgraded.
    """
    tables = set(inspect(db).get_table_names())
    if not tables:
        return None
    current = None
    if {VERSIONS.name, "entries"} <= tables:
        current = db.execute(select(func.max(VERSIONS.c.version))).scalar()
    if current is None:
        names = ", ".join(sorted(tables)[:3])
        raise RecordsError(
            f"{place}: contains other tables ({names}) but no records of layerjam; choose "
            "a different database"
        )
    if current > VERSION:
        raise RecordsError(
            f"{place}: its tables have version {current}, and this layerjam ({__version__}) "
            f"supports versions up to {VERSION}; update layerjam"
        )
    missing = [version for version in range(current, VERSION) if version not in STEPS]
    if missing:
        raise RecordsError(
            f"{place}: its tables have version {current}, and cannot be migrated from version "
            f"{missing[0]} to {VERSION}; use the version of layerjam that created them"
        )
    return int(current)


def _upgrade_tables(db: Connection, place: str) -> None:
    current = _read_table_version(db, place)
    if current is None:
        METADATA.create_all(db, checkfirst=False)
    for version in range(current or VERSION, VERSION):
        STEPS[version](db)
    if current != VERSION:
        origin = {"made_at": utc_timestamp(), "software": f"layerjam {__version__}"}
        db.execute(VERSIONS.insert().values(version=VERSION, **origin))


def _make_engine(url: URL) -> Engine:
    """Return an engine that enables the check of foreign keys in each SQLite connection."""
    if url.drivername != "sqlite":
        options = {"connect_timeout": REACHED}
        return create_engine(
            url, poolclass=NullPool, connect_args=options, isolation_level="READ COMMITTED"
        )
    engine = create_engine(url, poolclass=NullPool, connect_args={"timeout": PATIENCE})

    @event.listens_for(engine, "connect")
    def _set_up_connection(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # this module begins transactions itself
        connection.execute("PRAGMA foreign_keys = ON")
        connection.execute("PRAGMA synchronous = FULL")

    @event.listens_for(engine, "begin")
    def _begin(db: Connection) -> None:
        writes = db.get_execution_options().get("writes")
        db.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine
