"""`records`: brakes, measurements and calibrations in a database that is never overwritten."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, result
from layerjam.core.errors import MissingExtraError, Notice, count_text

RecordsDatabase = Annotated[
    str | None,  # a Path type would remove a slash from a URL
    Help(
        ("Records file, or URL of a PostgreSQL database. Default: a file in your data folder."),
        metavar="URL",
    ),
]
RecordId = Annotated[str, Help("ID, first characters of the ID, or name.", metavar="ID")]
SHORT = 8
"""Number of characters of an ID that are displayed."""


@result
class RecordsAdded(Result):
    """Records added."""

    ids: Mapping[str, str] = fact("ID of each file that was added", listed=False)
    also_added: Mapping[str, str] = fact("IDs of the records contained in them", listed=False)
    refused: Mapping[str, str] = fact("files not added, with reasons", listed=False)
    database: str = fact("location of the records")

    def lines(self) -> Iterator[str]:
        """Yield one line per record."""
        if self.ids:
            yield ""
        for path, ident in self.ids.items():
            yield f"{ident[:SHORT]}  {path}"
        for ident, text in self.also_added.items():
            yield f"{ident[:SHORT]}  {text}"


@result
class RecordsListed(Result):
    """All records."""

    rows_: Sequence[Mapping[str, Any]] = fact("one row per record", listed=False, key="rows")
    database: str = fact("location of the records")

    def lines(self) -> Iterator[str]:
        """Yield one line per record."""
        yield ""
        for row in self.rows_:
            yield _format_row(row)


@result
class RecordShown(Result):
    """One record and its sources."""

    record_: Mapping[str, Any] = fact("all information about the entry", listed=False, key="record")
    derived_from: Sequence[Mapping[str, Any]] = fact("sources of the entry", listed=False)
    used_by: Sequence[Mapping[str, Any]] = fact("entries derived from this one", listed=False)
    unlinked: Sequence[Mapping[str, Any]] = fact(
        "entries to which it refers, but which the records do not contain", listed=False
    )

    def rows(self) -> list[tuple[str, str]]:
        """Yield the known short fields."""
        texts = {key: _format_value(value) for key, value in self.record_.items()}
        return [
            (key.replace("_", " "), text)
            for key, text in texts.items()
            if text and "\n" not in text and len(text) < 200
        ]

    def lines(self) -> Iterator[str]:
        """Yield its sources, and the records derived from it."""
        parts = (("derived from", self.derived_from), ("used by", self.used_by))
        for title, records in parts:
            if records:
                yield from ("", title)
            for row in records:
                yield f"  {row['role']}: {_format_row(row)}"
        if self.unlinked:
            yield from ("", "not in the records")
        for row in self.unlinked:
            yield f"  {row['role']}: {row['name']} ({row['key'][:16]})"


@result
class RecordsVerified(Result):
    """Whether files are unchanged since they were added."""

    checked: int = fact("files and texts compared with their digests")
    changed: Sequence[Mapping[str, Any]] = fact("entries whose content has changed", listed=False)
    missing: Sequence[Mapping[str, Any]] = fact("files that cannot be found", listed=False)

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if a file has changed or is missing."""
        return 1 if self.changed or self.missing else 0

    def lines(self) -> Iterator[str]:
        """Yield one line for each changed file."""
        for word, records in (("changed", self.changed), ("missing", self.missing)):
            for row in records:
                folder = f", {row['folder']} on {row['host']}" if row["folder"] else ""
                yield f"{word}: {row['name']} ({row['id'][:SHORT]}{folder})"


@result
class RecordWithdrawn(Result):
    """A withdrawn record."""

    id: str = fact("ID of the entry")
    used_by: Sequence[str] = fact("IDs of the records derived from it", listed=False)


def _format_value(value: Any) -> str:
    """Return a value as text, empty if it is unknown or does not fit on a line."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {inner}" for key, inner in value.items() if inner is not None)
    return "" if value is None or isinstance(value, list) else str(value)


def _format_row(row: Mapping[str, Any]) -> str:
    words = [row["id"][:SHORT], row["kind"], row["name"]]
    if row.get("made_at"):
        words.append(row["made_at"])
    if row["simulated"]:
        words.append("synthetic")
    if row["accepted"]:
        words.append(f"accepted: {count_text(row['accepted'], 'failed check')}")
    if row["withdrawn"]:
        words.append(f"withdrawn: {row['withdrawn']}")
    return "  ".join(words)


def _open_database(db: str | None) -> Any:
    """Return the database; raises MissingExtraError if SQLAlchemy is missing."""
    package_extra = "postgres" if str(db).startswith("postgres") else "records"
    with MissingExtraError.raise_if_missing("a database of records (SQLAlchemy)", package_extra):
        import sqlalchemy  # noqa: F401
    from layerjam.laboratory.records.database import Database

    return Database(db)


@command("share", parent="records")
def records_add(
    files: Annotated[
        Sequence[str | Path] | str | Path,
        Help("Brakes, lines, runs, calibrations, measurements, sidecars.", metavar="FILE..."),
    ],
    *,
    db: RecordsDatabase = None,
    serial: Annotated[
        str | None, Help("Serial number, if only one brake or line is given.", metavar="TEXT")
    ] = None,
) -> RecordsAdded:
    """Add files to the records, linked to their sources.

    Links follow from digests inside the files. A file that is already in the records, or of an
    unsupported kind, is rejected; the others are added in one transaction. Raises RecordsError for
    the database; nothing is added then.
    """
    database = _open_database(db)
    from layerjam.laboratory.records.store import add

    paths = [files] if isinstance(files, str | Path) else list(files)
    result = add(database, paths, serial)
    return RecordsAdded.create(
        result,
        also_added=result.others,
        database=database.where,
        warnings=[
            *(Notice(f"{path}: {text}", "record") for path, text in result.notes),
            *(
                Notice(
                    f"{path}: derived from {name} ({role}, {key[:16]}), which is not in "
                    "the records; adding that file makes the link",
                    "not-linked",
                )
                for path, role, name, key in result.unlinked
            ),
        ],
    )


@command("share", parent="records")
def records_list(*, db: RecordsDatabase = None) -> RecordsListed:
    """List every record, oldest first.

    Raises RecordsError for the database.
    """
    database = _open_database(db)
    from layerjam.laboratory.records.view import list_rows

    with database.open_snapshot() as base:
        records = [] if base is None else list_rows(base)
    return RecordsListed(
        rows_=records, database=database.where, warnings=_no_records_notice(database, records)
    )


def _no_records_notice(database: Any, records: Sequence[Any]) -> list[Notice]:
    """Return a notice that there are no records yet, which reveals a mistyped name."""
    text = f"{database.where}: there are no records yet; create them with 'layerjam records add'"
    return [] if records else [Notice(text, "no-records")]


@command("share", parent="records")
def records_show(ident: RecordId, *, db: RecordsDatabase = None) -> RecordShown:
    """Show one record, its sources and the records derived from it.

    Raises RecordsError if no record or several records have that name.
    """
    database = _open_database(db)
    from layerjam.laboratory.records.view import show_record

    result = show_record(database, ident)
    return RecordShown.create(result, record_=result.record)


@command("share", parent="records")
def records_verify(
    folders: Annotated[
        Sequence[str | Path], Help("Folders in which to look for moved files.", metavar="FOLDER...")
    ] = (),
    *,
    db: RecordsDatabase = None,
) -> RecordsVerified:
    """Check whether every file is unchanged.

    Withdrawn files are not checked. The exit code is 1 if a file has changed or is missing. Raises
    RecordsError for the database.
    """
    database = _open_database(db)
    from layerjam.laboratory.records.view import verify_files

    result = verify_files(database, [folders] if isinstance(folders, str | Path) else list(folders))
    notices = _no_records_notice(database, [*range(result.checked)])
    return RecordsVerified.create(result, warnings=notices)


@command("share", parent="records")
def records_withdraw(
    ident: RecordId,
    *,
    why: Annotated[str, Help("Reason: the error in the record.", metavar="TEXT")],
    db: RecordsDatabase = None,
) -> RecordWithdrawn:
    """Withdraw a record; it is kept, with the reason.

    A file that was withdrawn cannot be added again. Raises RecordsError if there is no such record,
    or if it has already been withdrawn.
    """
    database = _open_database(db)
    from layerjam.laboratory.records.store import withdraw_record

    result, used_by = withdraw_record(database, ident, why)
    text = "records derived from it remain unchanged; see 'layerjam records show'"
    notices = [Notice(f"{len(used_by)} {text}", "used")] if used_by else []
    return RecordWithdrawn(id=result, used_by=used_by, warnings=notices)
