"""What is written into the records: files with what they are, links between them, withdrawals."""

from __future__ import annotations

import getpass
import uuid
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from platform import node
from typing import Any

from sqlalchemy import Connection, Table, or_, select

from layerjam._version import __version__
from layerjam.archive.contents import read
from layerjam.archive.database import Database
from layerjam.archive.move import RecordsError
from layerjam.archive.names import named
from layerjam.archive.pieces import Content, Piece, storable
from layerjam.archive.schema import (
    BRAKES,
    CALIBRATIONS,
    CITED,
    DERIVED_FROM,
    ENTRIES,
    FILES,
    LINES,
    RUNS,
    SENSOR_CALIBRATIONS,
    TYPED,
    WITHDRAWN,
)
from layerjam.archive.times import now
from layerjam.errors import FileError, LayerjamError
from layerjam.identify.provenance import sha256
from layerjam.measure.sidecar import FOLDER, SIDECAR_ENDING


@dataclass
class Added:
    """What a call added.

    `ids` is {path: id}, `others` {id: what it is and which file it was in}, `refused` {path: why},
    `unlinked` (path, role, name, key) of what a file comes from and the records do not hold.
    """

    ids: dict[str, str] = field(default_factory=dict)
    others: dict[str, str] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    unlinked: list[tuple[str, str, str, str]] = field(default_factory=list)
    notes: list[tuple[str, str]] = field(default_factory=list)


def add(database: Database, paths: Iterable[str | Path], serial: str | None = None) -> Added:
    """Add files in one transaction; those that cannot be are refused and the others go in.

    `serial` is that of the one brake or line that is given. Raises RecordsError where the database
    takes nothing; then nothing was added.
    """
    made = Added()
    contents: list[Content] = []
    given = list(dict.fromkeys(map(str, paths)))
    if serial is not None and len(given) > 1:
        raise RecordsError("serial: it belongs to one brake or one line; add that one alone")
    for path in given:
        try:
            contents.append(_with_serial(read(path), serial))
        except LayerjamError as error:
            if isinstance(error, FileError) and error.path == path:
                made.refused[path] = error.reason
            else:
                made.refused[path] = str(error)
    if contents:
        with database.writing() as db:
            _add(db, contents, made)
    return made


def _with_serial(content: Content, serial: str | None) -> Content:
    """A brake or a line with the number that is stamped on it."""
    if serial is None:
        return content
    what = content.what
    if what is None or what.kind not in ("brake", "line"):
        raise FileError(content.path, "is no brake and no line, which alone have a serial number")
    return replace(
        content, what=replace(what, columns={**what.columns, "serial": storable(serial)})
    )


def _add(db: Connection, contents: Iterable[Content], made: Added) -> None:
    """Enter files one after the other, then link what is there now."""
    fresh: dict[str, str] = {}
    keys: set[str] = set()
    for content in contents:
        why = refusal(db, content)
        if why is not None:
            made.refused[content.path] = why
            continue
        entered = _Entering(db, content)
        made.ids[content.path] = entered.id
        made.others |= entered.others
        made.notes += [(content.path, note) for note in content.notes]
        fresh |= dict.fromkeys((entered.id, *entered.fresh), content.path)
        keys |= entered.keys
        _measured_under(db, content)
    for child, key, role, name in _cited(db, fresh, keys):
        parents = holders(db, key)
        for parent in parents:
            link(db, child, parent, role)
        if not parents and child in fresh:
            made.unlinked.append((fresh[child], role, name, key))


def _measured_under(db: Connection, content: Content) -> None:
    """Note that measurements which were added before the facts beside them come from these.

    The digest of the file beside them must be that of the measurement in the records.
    """
    file = content.file
    if file["kind"] != "facts":
        return
    wanted = [FILES.c.folder == file["folder"], FILES.c.host == node()]
    wanted.append(FILES.c.kind.in_(["data", "export"]))
    if file["name"] != FOLDER:
        wanted.append(FILES.c.name == file["name"].removesuffix(SIDECAR_ENDING))
    role = "conditions"
    for row in db.execute(select(FILES.c.id, FILES.c.name, FILES.c.sha256).where(*wanted)).all():
        there = Path(file["folder"]) / row.name
        said = select(CITED.c.child).where(
            CITED.c.child == row.id, CITED.c.key == file["sha256"], CITED.c.role == role
        )
        if db.execute(said).first() is None and _same(there, row.sha256):
            new = {"child": row.id, "key": file["sha256"], "role": role, "name": file["name"]}
            db.execute(CITED.insert().values(**new))


def _same(path: Path, digest: str) -> bool:
    """Whether a file is there and has this digest."""
    with suppress(OSError):
        return path.is_file() and sha256(str(path)) == digest
    return False


def refusal(db: Connection, content: Content) -> str | None:
    """Why a file cannot be added, None where it can."""
    same = select(FILES.c.id, FILES.c.name, FILES.c.made_at).where(
        FILES.c.sha256 == content.file["sha256"]
    )
    what = content.what
    if what is not None and what.kind in ("brake", "line"):
        # a byte order mark makes other bytes of the same text
        table = TYPED[what.kind]
        same = (
            select(FILES.c.id, FILES.c.name, FILES.c.made_at)
            .select_from(FILES.outerjoin(table, FILES.c.id == table.c.id))
            .where(
                or_(
                    FILES.c.sha256 == content.file["sha256"],
                    table.c.sha256 == what.columns["sha256"],
                )
            )
        )
    found = db.execute(same).first()
    if found is not None:
        ident, name, made_at = found
        gone = _why_withdrawn(db, ident)
        more = f", and was withdrawn: {gone}" if gone else ""
        return f"is in the records already: {name}, added {made_at} as {ident}{more}"
    if what is not None and what.kind == "run" and what.columns["run_id"]:
        there = db.execute(
            select(RUNS.c.id, RUNS.c.file)
            .outerjoin(WITHDRAWN, WITHDRAWN.c.id == RUNS.c.id)
            .where(RUNS.c.run_id == what.columns["run_id"], WITHDRAWN.c.id.is_(None))
        ).first()
        if there is not None:
            return (
                f"is another state of a run that is in the records already: {there.file} as "
                f"{there.id}; withdraw that one first"
            )
    return None


def _why_withdrawn(db: Connection, ident: str) -> str | None:
    """Why a record was withdrawn, None where it was not."""
    found = db.execute(select(WITHDRAWN.c.why).where(WITHDRAWN.c.id == ident)).scalar()
    return None if found is None else str(found)


class _Entering:
    """One file as it goes into the tables; `others` are records inside it that are new.

    `fresh` are the ids of new records beside its own, `keys` what others may cite it by.
    """

    def __init__(self, db: Connection, content: Content) -> None:
        self.db, self.content = db, content
        self.others: dict[str, str] = {}
        self.fresh: list[str] = []
        self.keys: set[str] = {str(content.file["sha256"])}
        parents = {role: self._other(role) for role in content.others}
        self.id = self._own(parents)
        for role, parent in parents.items():
            if parent is not None:
                link(db, self.id, parent, role)
        self._cite(self.id, content.cited)

    def _own(self, parents: Mapping[str, str | None]) -> str:
        """Enter the file and the record that it is; its id."""
        content, what = self.content, self.content.what
        ident = None
        if what is None:
            ident = self._entry(str(content.file["kind"]))
        else:
            more: dict[str, Any] = {}
            if what.kind == "run":
                more = {role.replace(" ", "_"): parent for role, parent in parents.items()}
            ident = self._found(what) or self._record(what, more)
        there = {"host": node(), "simulated": None, **content.file}
        self.db.execute(FILES.insert().values(id=ident, **stamp(), **there))
        return ident

    def _other(self, role: str) -> str | None:
        """A record inside the file: the one that is there already, or a new one."""
        piece = self.content.others[role]
        more: dict[str, Any] = {}
        if piece.kind == "sensor calibration":
            board = self._found(self.content.others["board"])
            more = {"board": board}
            piece = replace(piece, columns={**piece.columns, **more})
        ident = self._found(piece)
        if ident is None:
            ident = self._record(piece, more)
            self.fresh.append(ident)
            self.others[ident] = f"{piece.kind} in {self.content.path}"
        return ident

    def _found(self, piece: Piece) -> str | None:
        """The id of a record that is there already, by what makes it this one."""
        columns = piece.columns
        table = TYPED[piece.kind]
        wanted: list[Any]
        if piece.kind in ("brake", "line"):
            ident = _first(self.db, table, table.c.sha256 == columns["sha256"])
            inside = self.content.what is not piece
            if ident is None and inside:
                same = table.c.rendered_sha256.in_([columns["sha256"], columns["rendered_sha256"]])
                ident = _first(self.db, table, same)
            return ident
        if piece.kind == "board":
            wanted = [table.c.serial == columns["serial"]]
        elif piece.kind == "sensor calibration":
            wanted = [
                SENSOR_CALIBRATIONS.c.board == columns["board"],
                SENSOR_CALIBRATIONS.c.said == columns["said"],
            ]
        elif piece.kind == "calibration":
            wanted = [CALIBRATIONS.c.sha256 == columns["sha256"]]
        else:
            return None
        return _first(self.db, table, *wanted)

    def _record(self, piece: Piece, more: Mapping[str, Any]) -> str:
        """Enter one record with a new id."""
        columns = {**piece.columns, **more}
        if piece.kind == "calibration":
            columns["brake"] = self._calibrated(piece)
        ident = self._entry(piece.kind)
        self.db.execute(TYPED[piece.kind].insert().values(id=ident, **stamp(), **columns))
        for name in ("sha256", "rendered_sha256", "run_id"):
            if columns.get(name):
                self.keys.add(columns[name])
        self._cite(ident, piece.cited)
        return ident

    def _calibrated(self, piece: Piece) -> str | None:
        """The brake that a calibration started from, where it is in the records."""
        key = next((c.key for c in piece.cited if c.role == "start"), None)
        found = [] if key is None else holders(self.db, key)
        return next((one for one in found if _first(self.db, BRAKES, BRAKES.c.id == one)), None)

    def _entry(self, kind: str) -> str:
        """A new id."""
        ident = str(uuid.uuid4())
        self.db.execute(ENTRIES.insert().values(id=ident, kind=kind))
        return ident

    def _cite(self, child: str, cited: Iterable[Any]) -> None:
        """Note what a record says it comes from."""
        unique = {(c.key, c.role): c.name for c in cited}
        for (key, role), name in unique.items():
            self.db.execute(CITED.insert().values(child=child, key=key, role=role, name=name))


def _first(db: Connection, table: Table, *wanted: Any) -> str | None:
    """The id of the first row that is as wanted."""
    found = db.execute(
        select(table.c.id).where(*wanted).order_by(table.c.made_at, table.c.id)
    ).scalar()
    return None if found is None else str(found)


def stamp() -> dict[str, str]:
    """What every row says of its making."""
    return {"made_at": now(), "software": f"layerjam {__version__}", "by": user()}


def user() -> str:
    """Who is at work, as the system knows; empty where it does not."""
    with suppress(OSError, KeyError, ImportError):
        return getpass.getuser()
    return ""


def _cited(
    db: Connection, fresh: Mapping[str, str], keys: Iterable[str]
) -> Iterator[tuple[str, str, str, str]]:
    """What new records cite, and what older ones cite of them: child, key, role, name."""
    columns = (CITED.c.child, CITED.c.key, CITED.c.role, CITED.c.name)
    found: dict[tuple[str, str, str], str] = {}
    for child in fresh:
        for row in db.execute(select(*columns).where(CITED.c.child == child)):
            found[row[0], row[1], row[2]] = row[3]
    for key in keys:
        for row in db.execute(select(*columns).where(CITED.c.key == key)):
            found[row[0], row[1], row[2]] = row[3]
    for (child, key, role), name in found.items():
        yield child, key, role, name


def holders(db: Connection, key: str) -> list[str]:
    """The records that a digest or the number of a run names.

    Several, where a brake came inside a run and as a file too, or a run in two states.
    """
    columns = (
        (FILES, FILES.c.sha256),
        (BRAKES, BRAKES.c.sha256),
        (LINES, LINES.c.sha256),
        (BRAKES, BRAKES.c.rendered_sha256),
        (LINES, LINES.c.rendered_sha256),
        (RUNS, RUNS.c.run_id),
    )
    found = [
        str(row.id)
        for table, column in columns
        for row in db.execute(
            select(table.c.id).where(column == key).order_by(table.c.made_at, table.c.id)
        )
    ]
    return list(dict.fromkeys(found))


def link(db: Connection, child: str, parent: str, role: str) -> None:
    """Note that one record was derived from another, once."""
    if child == parent:
        return
    row = {"child": child, "parent": parent, "role": role}
    there = select(DERIVED_FROM.c.child).where(*(DERIVED_FROM.c[k] == v for k, v in row.items()))
    if db.execute(there).first() is None:
        db.execute(DERIVED_FROM.insert().values(**row))


def withdraw(database: Database, ident: str, why: str) -> tuple[str, list[str]]:
    """Withdraw a record: it stays, and says when and why; its id, and the ids that rest on it.

    Raises RecordsError for an unknown record, one that was withdrawn before, or no reason.
    """
    if not why.strip():
        raise RecordsError("why: is empty; say in a few words what is wrong with the record")
    with database.reading() as db:
        named(db, ident, database.where)
    with database.writing() as db:
        whole = named(db, ident, database.where)
        before = _why_withdrawn(db, whole)
        if before is not None:
            raise RecordsError(f"{whole}: was withdrawn before, because: {before}")
        made = {"id": whole, "when": now(), "why": storable(why.strip()), "by": user()}
        db.execute(WITHDRAWN.insert().values(**made))
        children = select(DERIVED_FROM.c.child).where(DERIVED_FROM.c.parent == whole).distinct()
        return whole, sorted(str(row[0]) for row in db.execute(children))
