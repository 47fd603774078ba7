"""Where the records are: a file of SQLite, or a PostgreSQL server by URL."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import platformdirs
from sqlalchemy import URL, Connection, Engine, create_engine, event, make_url, text
from sqlalchemy.exc import ArgumentError, DBAPIError
from sqlalchemy.pool import NullPool

from layerjam.archive.move import RecordsError, brought_up, check_version, version_of
from layerjam.archive.schema import VERSION
from layerjam.errors import MissingExtraError

PATIENCE = 60
"""Seconds to wait for another writer."""
REACHED = 10
"""Seconds in which a server must answer at all."""
LOCK = 0x4C4A5243
"""PostgreSQL's advisory lock of the writers: one after the other, as with SQLite."""
POSTGRES = ("postgresql", "postgres", "postgresql+psycopg")


def default_file() -> Path:
    """Where the records are unless somebody says otherwise."""
    return Path(platformdirs.user_data_dir("layerjam")) / "records.db"


def url_of(db: str | Path | None) -> URL:
    """The database of a URL or of a path to a file of SQLite.

    Raises RecordsError for a URL of another kind, MissingExtraError without psycopg.
    """
    if db is None:
        return URL.create("sqlite", database=str(default_file()))
    if not re.match(r"[\w+]{2,}:|:", str(db)):
        return URL.create("sqlite", database=str(db))
    allowed = "use sqlite:///FILE, postgresql://USER@HOST/NAME, or the path of a file"
    try:
        url = make_url(str(db))
    except (ArgumentError, ValueError):
        raise RecordsError(f"db: this is no URL of a database; {allowed}") from None
    if url.drivername in POSTGRES:
        with MissingExtraError.without("records in PostgreSQL (psycopg)", "postgres"):
            import psycopg  # noqa: F401
        return url.set(drivername="postgresql+psycopg")
    if url.drivername == "sqlite" and url.database and url.database != ":memory:":
        return url
    raise RecordsError(f"db: {url.render_as_string(hide_password=True)} cannot be used; {allowed}")


class Database:
    """One database, opened for each transaction and closed after it."""

    def __init__(self, db: str | Path | None = None) -> None:
        self.url = url_of(db)
        self.file = Path(str(self.url.database)) if self.url.drivername == "sqlite" else None
        self.where = str(self.file or self.url.render_as_string(hide_password=True))
        self._engine = _engine(self.url)

    @contextlib.contextmanager
    def writing(self) -> Iterator[Connection]:
        """One transaction that writes, after all others: whole or not at all.

        Makes the database where there is none. Raises RecordsError.
        """
        with self._said():
            if self.file is not None:
                self.file.parent.mkdir(parents=True, exist_ok=True)
            with self._engine.connect().execution_options(writes=True) as db, db.begin():
                if self.file is None:
                    db.execute(text(f"SET LOCAL lock_timeout = '{PATIENCE}s'"))
                    db.execute(text("SELECT pg_advisory_xact_lock(:lock)"), {"lock": LOCK})
                brought_up(db, self.where)
                yield db

    @contextlib.contextmanager
    def reading(self) -> Iterator[Connection | None]:
        """A view of the records that does not move; None where there is no database yet."""
        if self.file is not None and not self.file.exists():
            yield None
            return
        if self._is_older():
            with self.writing():
                pass
        with self._said(), self._engine.connect() as db, db.begin():
            yield None if version_of(db, self.where) is None else db

    def _is_older(self) -> bool:
        """Whether the tables are of an older version; RecordsError for those that do not do."""
        with self._said(), self._engine.connect() as db, db.begin():
            found = version_of(db, self.where)
            if found is not None:
                check_version(found, self.where)
            return found is not None and found < VERSION

    @contextlib.contextmanager
    def _said(self) -> Iterator[None]:
        """What a database says that does not do as it should, as one sentence."""
        try:
            yield
        except DBAPIError as error:
            reason = " ".join(str(error.orig).split())[:300]
            raise RecordsError(f"{self.where}: the database says: {reason}") from None
        except OSError as error:
            raise RecordsError(f"{self.where}: cannot be written: {error.strerror}") from None


def _engine(url: URL) -> Engine:
    """SQLite checks foreign keys only where each connection asks it to."""
    if url.drivername != "sqlite":
        options = {"connect_timeout": REACHED}
        return create_engine(
            url, poolclass=NullPool, connect_args=options, isolation_level="READ COMMITTED"
        )
    engine = create_engine(url, poolclass=NullPool, connect_args={"timeout": PATIENCE})

    @event.listens_for(engine, "connect")
    def _connected(connection: Any, _record: Any) -> None:
        connection.isolation_level = None  # transactions begin where we say
        connection.execute("PRAGMA foreign_keys = ON")
        connection.execute("PRAGMA synchronous = FULL")

    @event.listens_for(engine, "begin")
    def _begun(db: Connection) -> None:
        writes = db.get_execution_options().get("writes")
        db.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")

    return engine
