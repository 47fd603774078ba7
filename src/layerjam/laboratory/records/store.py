"""Additions to the database: files with their records, links between them and withdrawals."""

import getpass
import uuid
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from platform import node

from sqlalchemy import Connection, or_, select

from layerjam._version import __version__
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.measure.sidecar import FOLDER, SIDECAR_ENDING
from layerjam.laboratory.records.contents import read_content
from layerjam.laboratory.records.database import Database, RecordsError
from layerjam.laboratory.records.pieces import Cited, Content, Piece, clean_text
from layerjam.laboratory.records.record_names import find_by_key, find_unlinked, resolve_record_id
from layerjam.laboratory.records.schema import (
    CITED,
    DERIVED_FROM,
    ENTRIES,
    FILES,
    KEYS,
    WITHDRAWN,
    add_keys,
    identity,
    insert_citations,
    insert_record,
    utc_timestamp,
)


@dataclass
class Additions:
    """Result of an addition.

    `ids` is {path: id}, `others` {id: kind and file}, `refused` {path: reason}. `unlinked` lists
    (path, role, name, key) of sources that are not in the database.
    """

    ids: dict[str, str] = field(default_factory=dict)
    others: dict[str, str] = field(default_factory=dict)
    refused: dict[str, str] = field(default_factory=dict)
    unlinked: list[tuple[str, str, str, str]] = field(default_factory=list)
    notes: list[tuple[str, str]] = field(default_factory=list)


def add(database: Database, paths: Iterable[str | Path], serial: str | None = None) -> Additions:
    """Add files in one transaction; rejected files do not affect the others.

    `serial` is the serial number of the brake or line, which must then be the only file. Raises
    RecordsError if the database cannot be written; then nothing is added.
    """
    result = Additions()
    contents: list[Content] = []
    names = list(dict.fromkeys(map(str, paths)))
    if serial is not None and len(names) > 1:
        raise RecordsError("serial: it belongs to one brake or one line; add that one alone")
    for path in names:
        try:
            contents.append(_add_serial(read_content(path), serial))
        except LayerjamError as error:
            if isinstance(error, FileError) and error.path == path:
                result.refused[path] = error.reason
            else:
                result.refused[path] = str(error)
    if contents:
        with database.open_transaction() as db:
            _add_contents(db, contents, result)
    return result


def _add_serial(content: Content, serial: str | None) -> Content:
    if serial is None:
        return content
    piece = content.piece
    if piece is None or piece.kind not in ("brake", "line"):
        raise FileError(content.path, "is not a brake or a line: only these have a serial number")
    return replace(
        content, piece=replace(piece, columns={**piece.columns, "serial": clean_text(serial)})
    )


def _add_contents(db: Connection, contents: Iterable[Content], result: Additions) -> None:
    fresh: dict[str, str] = {}
    for content in contents:
        problem = find_refusal_reason(db, content)
        if problem is not None:
            result.refused[content.path] = problem
            continue
        content_ids: dict[str, str] = {}
        ident = _enter_file(db, content, content_ids)
        result.ids[content.path] = ident
        result.others |= {c: f"{kind} in {content.path}" for c, kind in content_ids.items()}
        result.notes += [(content.path, note) for note in content.notes]
        fresh |= dict.fromkeys((ident, *content_ids), content.path)
        _cite_later_facts(db, content)
    for child, path in fresh.items():
        result.unlinked += [(path, c.role, c.name, c.key) for c in find_unlinked(db, child)]


def _cite_later_facts(db: Connection, content: Content) -> None:
    """Link new metadata to their measurement if it was added before.

    The file next to the metadata must still have the digest of the measurement in the database.
    """
    file = content.file
    if file["kind"] != "facts":
        return
    terms = [FILES.c.folder == file["folder"], FILES.c.host == node()]
    terms.append(FILES.c.kind.in_(["data", "export"]))
    if file["name"] != FOLDER:
        terms.append(FILES.c.name == file["name"].removesuffix(SIDECAR_ENDING))
    facts = Cited(file["sha256"], "conditions", file["name"])
    for row in db.execute(select(FILES.c.id, FILES.c.name, FILES.c.sha256).where(*terms)).all():
        link = select(CITED.c.child).where(
            CITED.c.child == row.id, CITED.c.key == facts.key, CITED.c.role == facts.role
        )
        if db.execute(link).first() is None and _has_digest(
            Path(file["folder"]) / row.name, row.sha256
        ):
            insert_citations(db, row.id, [facts])


def _has_digest(path: Path, digest: str) -> bool:
    with suppress(OSError):
        return path.is_file() and sha256(str(path)) == digest
    return False


def find_refusal_reason(db: Connection, content: Content) -> str | None:
    """Return the reason why a file cannot be added, or None."""
    piece = content.piece
    conditions = [FILES.c.sha256 == content.file["sha256"]]
    if piece is not None:  # a byte-order mark changes the bytes but not the text
        conditions.append(FILES.c.id == _find_existing_id(db, piece))
    row = db.execute(
        select(FILES.c.id, FILES.c.name, FILES.c.made_at).where(or_(*conditions))
    ).first()
    if row is not None:
        ident, name, made_at = row
        reason = _find_withdrawal_reason(db, ident)
        detail = f", and was withdrawn: {reason}" if reason else ""
        return f"is already in the records: {name}, added {made_at} as {ident}{detail}"
    if piece is not None and piece.kind == "run" and piece.columns["run_id"]:
        run = db.execute(
            select(ENTRIES.c.id, ENTRIES.c.name)
            .join(KEYS)
            .outerjoin(WITHDRAWN)
            .where(ENTRIES.c.kind == "run", KEYS.c.key == piece.columns["run_id"])
            .where(WITHDRAWN.c.id.is_(None))
        ).first()
        if run is not None:
            return (
                f"is a different state of a run that is already in the records: {run.name} as "
                f"{run.id}; withdraw that one first"
            )
    return None


def _find_withdrawal_reason(db: Connection, ident: str) -> str | None:
    reason = db.execute(select(WITHDRAWN.c.why).where(WITHDRAWN.c.id == ident)).scalar()
    return None if reason is None else str(reason)


def _enter_file(db: Connection, content: Content, inside: dict[str, str]) -> str:
    """Enter a file and its record, and return its id; add {id: kind} of others to `inside`."""
    origin = make_stamp()
    parents: dict[str, str] = {}
    for role, content_piece in content.others.items():
        piece = content_piece
        if piece.kind == "sensor calibration":
            piece = replace(piece, columns={**piece.columns, "board": parents["board"]})
        ident = _find_existing_id(db, piece)
        if ident is None and piece.kind in ("brake", "line"):
            digests = (piece.columns[name] for name in ("sha256", "rendered_sha256"))
            ident = find_by_key(db, piece.kind, *digests)
        if ident is None:
            ident = _enter_piece(db, piece, origin)
            inside[ident] = piece.kind
        parents[role] = ident
    file = {"host": node(), "simulated": None, **content.file}
    record = content.piece or Piece(kind=str(file["kind"]), columns=file)
    if record.kind == "run":
        links = {role.replace(" ", "_"): parent for role, parent in parents.items()}
        record = replace(record, columns={**record.columns, **links})
    ident = _find_existing_id(db, record) or _enter_piece(db, record, origin)
    db.execute(FILES.insert().values(id=ident, **origin, **file))
    add_keys(db, ident, [file["sha256"]])
    insert_citations(
        db, ident, [*content.cited, *(Cited(key, role, "") for role, key in parents.items())]
    )
    return ident


def _find_existing_id(db: Connection, piece: Piece) -> str | None:
    has_same_identity = ENTRIES.c.identity == identity(piece.kind, piece.columns)
    return db.execute(select(ENTRIES.c.id).where(has_same_identity)).scalar()


def _enter_piece(db: Connection, piece: Piece, origin: Mapping[str, str]) -> str:
    columns, ident = dict(piece.columns), str(uuid.uuid4())
    if piece.kind == "calibration":
        columns["brake"] = find_by_key(
            db, "brake", *(source.key for source in piece.cited if source.role == "start")
        )
    insert_record(db, ident, piece.kind, origin, columns)
    insert_citations(db, ident, piece.cited)
    return ident


def make_stamp() -> dict[str, str]:
    """Return the time, program and user to be stored in every row."""
    return {"made_at": utc_timestamp(), "software": f"layerjam {__version__}", "by": user_name()}


def user_name() -> str:
    """Return the name of the user, empty if the system does not know it."""
    with suppress(OSError, KeyError, ImportError):
        return getpass.getuser()
    return ""


def withdraw_record(database: Database, ident: str, reason: str) -> tuple[str, list[str]]:
    """Mark a record as withdrawn; return its id and the ids of records derived from it.

    Raises RecordsError for an unknown or already withdrawn record, or without a reason.
    """
    if not reason.strip():
        raise RecordsError("why: is empty; write in a few words what is wrong with the record")
    with database.open_snapshot() as db:
        resolve_record_id(db, ident, database.where)
    with database.open_transaction() as db:
        full_id = resolve_record_id(db, ident, database.where)
        old_reason = _find_withdrawal_reason(db, full_id)
        if old_reason is not None:
            raise RecordsError(f"{full_id}: was already withdrawn; reason: {old_reason}")
        text = clean_text(reason.strip())
        entry = {"id": full_id, "when": utc_timestamp(), "why": text, "by": user_name()}
        db.execute(WITHDRAWN.insert().values(**entry))
        children = select(DERIVED_FROM.c.child).where(DERIVED_FROM.c.parent == full_id).distinct()
        return full_id, sorted(str(row[0]) for row in db.execute(children))
