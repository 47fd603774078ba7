"""What is written into the records: files with what they are, links between them, withdrawals."""

from __future__ import annotations

import getpass
import uuid
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from platform import node

from sqlalchemy import Connection, or_, select

from layerjam._version import __version__
from layerjam.archive.contents import read
from layerjam.archive.database import Database, RecordsError
from layerjam.archive.names import holder, resolve_record_id, unlinked
from layerjam.archive.pieces import Cited, Content, Piece, storable
from layerjam.archive.schema import (
    CITED,
    DERIVED_FROM,
    ENTRIES,
    FILES,
    KEYS,
    WITHDRAWN,
    add_keys,
    cite,
    enter,
    identity,
    utc_timestamp,
)
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
    """Enter files one after the other, then look which of their sources are missing."""
    fresh: dict[str, str] = {}
    for content in contents:
        why = refusal(db, content)
        if why is not None:
            made.refused[content.path] = why
            continue
        inside: dict[str, str] = {}
        ident = _enter_file(db, content, inside)
        made.ids[content.path] = ident
        made.others |= {one: f"{kind} in {content.path}" for one, kind in inside.items()}
        made.notes += [(content.path, note) for note in content.notes]
        fresh |= dict.fromkeys((ident, *inside), content.path)
        _cite_later_facts(db, content)
    for child, path in fresh.items():
        made.unlinked += [(path, one.role, one.name, one.key) for one in unlinked(db, child)]


def _cite_later_facts(db: Connection, content: Content) -> None:
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
    facts = Cited(file["sha256"], "conditions", file["name"])
    for row in db.execute(select(FILES.c.id, FILES.c.name, FILES.c.sha256).where(*wanted)).all():
        there = select(CITED.c.child).where(
            CITED.c.child == row.id, CITED.c.key == facts.key, CITED.c.role == facts.role
        )
        if db.execute(there).first() is None and _same(Path(file["folder"]) / row.name, row.sha256):
            cite(db, row.id, [facts])


def _same(path: Path, digest: str) -> bool:
    """Whether a file is there and has this digest."""
    with suppress(OSError):
        return path.is_file() and sha256(str(path)) == digest
    return False


def refusal(db: Connection, content: Content) -> str | None:
    """Return why a file cannot be added, or None if it can."""
    what = content.what
    same = [FILES.c.sha256 == content.file["sha256"]]
    if what is not None:  # a byte order mark makes other bytes of the same text
        same.append(FILES.c.id == _known(db, what))
    found = db.execute(select(FILES.c.id, FILES.c.name, FILES.c.made_at).where(or_(*same))).first()
    if found is not None:
        ident, name, made_at = found
        gone = _why_withdrawn(db, ident)
        more = f", and was withdrawn: {gone}" if gone else ""
        return f"is in the records already: {name}, added {made_at} as {ident}{more}"
    if what is not None and what.kind == "run" and what.columns["run_id"]:
        there = db.execute(
            select(ENTRIES.c.id, ENTRIES.c.name)
            .join(KEYS)
            .outerjoin(WITHDRAWN)
            .where(ENTRIES.c.kind == "run", KEYS.c.key == what.columns["run_id"])
            .where(WITHDRAWN.c.id.is_(None))
        ).first()
        if there is not None:
            return (
                f"is another state of a run that is in the records already: {there.name} as "
                f"{there.id}; withdraw that one first"
            )
    return None


def _why_withdrawn(db: Connection, ident: str) -> str | None:
    """Return the reason for which a record was withdrawn, or None."""
    found = db.execute(select(WITHDRAWN.c.why).where(WITHDRAWN.c.id == ident)).scalar()
    return None if found is None else str(found)


def _enter_file(db: Connection, content: Content, inside: dict[str, str]) -> str:
    """Enter a file and the record that it is; its id. `inside` gets {id: kind} of new others."""
    made = stamp()
    parents: dict[str, str] = {}
    for role, other in content.others.items():
        piece = other
        if piece.kind == "sensor calibration":
            piece = replace(piece, columns={**piece.columns, "board": parents["board"]})
        ident = _known(db, piece)
        if ident is None and piece.kind in ("brake", "line"):
            digests = (piece.columns[name] for name in ("sha256", "rendered_sha256"))
            ident = holder(db, piece.kind, *digests)
        if ident is None:
            ident = _enter(db, piece, made)
            inside[ident] = piece.kind
        parents[role] = ident
    file = {"host": node(), "simulated": None, **content.file}
    what = content.what or Piece(kind=str(file["kind"]), columns=file)
    if what.kind == "run":
        own = {role.replace(" ", "_"): parent for role, parent in parents.items()}
        what = replace(what, columns={**what.columns, **own})
    ident = _known(db, what) or _enter(db, what, made)
    db.execute(FILES.insert().values(id=ident, **made, **file))
    add_keys(db, ident, [file["sha256"]])
    cite(db, ident, [*content.cited, *(Cited(key, role, "") for role, key in parents.items())])
    return ident


def _known(db: Connection, piece: Piece) -> str | None:
    """The id of a record that is there already."""
    same = ENTRIES.c.identity == identity(piece.kind, piece.columns)
    return db.execute(select(ENTRIES.c.id).where(same)).scalar()


def _enter(db: Connection, piece: Piece, made: Mapping[str, str]) -> str:
    """Enter one record with a new id."""
    columns, ident = dict(piece.columns), str(uuid.uuid4())
    if piece.kind == "calibration":
        columns["brake"] = holder(
            db, "brake", *(one.key for one in piece.cited if one.role == "start")
        )
    enter(db, ident, piece.kind, made, columns)
    cite(db, ident, piece.cited)
    return ident


def stamp() -> dict[str, str]:
    """What every row says of its making."""
    return {"made_at": utc_timestamp(), "software": f"layerjam {__version__}", "by": user()}


def user() -> str:
    """Return the name of the user, or an empty text if the system knows none."""
    with suppress(OSError, KeyError, ImportError):
        return getpass.getuser()
    return ""


def withdraw(database: Database, ident: str, why: str) -> tuple[str, list[str]]:
    """Withdraw a record: it stays, and says when and why; its id, and the ids that rest on it.

    Raises RecordsError for an unknown record, one that was withdrawn before, or no reason.
    """
    if not why.strip():
        raise RecordsError("why: is empty; say in a few words what is wrong with the record")
    with database.reading() as db:
        resolve_record_id(db, ident, database.where)
    with database.writing() as db:
        whole = resolve_record_id(db, ident, database.where)
        before = _why_withdrawn(db, whole)
        if before is not None:
            raise RecordsError(f"{whole}: was withdrawn before, because: {before}")
        made = {"id": whole, "when": utc_timestamp(), "why": storable(why.strip()), "by": user()}
        db.execute(WITHDRAWN.insert().values(**made))
        children = select(DERIVED_FROM.c.child).where(DERIVED_FROM.c.parent == whole).distinct()
        return whole, sorted(str(row[0]) for row in db.execute(children))
