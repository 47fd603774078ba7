"""What a file is, and which others it names: by digests that it holds, never by likeness.

A run is read from its own tables; of a file of a test machine only its bytes count here.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import tomlkit

from layerjam.archive.pieces import (
    Cited,
    Content,
    Piece,
    hex_of,
    made_of_text,
    storable,
    text_digest,
)
from layerjam.device.file import BrakeFile
from layerjam.errors import FileError, LayerjamError
from layerjam.fluid.file import LineFile
from layerjam.identify.provenance import sha256
from layerjam.measure.runs import ENDING, opened
from layerjam.measure.sidecar import FOLDER, SIDECAR_ENDING, places, read_facts
from layerjam.measure.synthetic import says_synthetic
from layerjam.records.table_text import plain_comment
from layerjam.records.toml import parse_toml, read_text

STATED = (
    "run_id",
    "procedure",
    "outcome",
    "firmware",
    "law_sha256",
    "settings_hex",
    "safe_state",
)
"""Key of `meta` for each column of the table of runs."""
NONE = {"zero": 0.0, "gain": 1.0, "name": ""}
"""Answer of a board whose sensor was never calibrated."""
BOARD = {"serial": "board", "model": "model", "firmware": "firmware"}
"""{column of a board: key of `meta`}."""


def check_whole(path: str) -> None:
    """Raise FileError for a run whose bytes alone are not the run."""
    beside = Path(f"{path}-wal")
    if beside.exists() and beside.stat().st_size:
        raise FileError(
            path,
            f"is not closed: {beside.name} beside it holds a part of the run, so its bytes alone "
            "are not the run. If it is recorded no more, close it with: sqlite3 "
            f"{Path(path).name} 'PRAGMA journal_mode = DELETE'",
        )


def run(path: str, own: Mapping[str, Any]) -> Content:
    """A run, with the brake, the line, the board and the calibration of its sensor inside it.

    Raises FileError for a file that is not a run, or not a whole one.
    """
    base = opened(path, whole=True)
    try:
        rows = base.execute("SELECT key, value FROM meta").fetchall()
        counts = base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1 FROM samples GROUP BY boot"
        ).fetchall()
    except sqlite3.Error as error:
        raise FileError(path, f"is damaged: {error}") from None
    finally:
        base.close()
    said = {str(key): storable(str(value)) for key, value in rows if value not in (None, "")}
    samples = sum(count for count, _ in counts)
    simulated = said.get("simulated") != "0"
    columns = {
        **{key: said.get(key) for key in STATED},
        "started": said.get("started_utc"),
        "ended": said.get("ended_utc"),
        "simulated": simulated,
        "samples": samples,
        "gaps": sum(spanned for _, spanned in counts) - samples,
        "file_sha256": own["sha256"],
        "file": own["name"],
    }
    others, notes = _inside(path, said)
    texts = [(kind, said[f"{kind}_toml"]) for kind in ("brake", "line") if kind in others]
    if not said.get("outcome"):
        notes.append("nobody closed the run: it is kept as interrupted")
    return Content(
        path=path,
        file={**own, "kind": "run", "simulated": simulated},
        what=Piece(kind="run", columns=columns),
        # a file of the same brake that comes later is linked too
        cited=tuple(Cited(text_digest(text), kind, f"its {kind}") for kind, text in texts),
        others=others,
        notes=tuple(notes),
    )


def _inside(path: str, said: Mapping[str, str]) -> tuple[dict[str, Piece], list[str]]:
    """{role: record} of what a run holds that stands for itself, and what could not be read."""
    found: dict[str, Piece] = {}
    notes = []
    for kind in ("brake", "line"):
        text = said.get(f"{kind}_toml")
        if text is None:
            continue
        try:
            found[kind] = made_of_text(kind, text, f"{path}, its {kind}")
        except LayerjamError as error:
            notes.append(f"its {kind} cannot be read and is not linked: {error}")
    if "board" in said:
        columns = {name: said.get(key) for name, key in BOARD.items()}
        found["board"] = Piece(kind="board", columns=columns)
        text = said.get("sensor_calibration")
        if text is not None and _calibration(text) != NONE:
            found["sensor calibration"] = Piece(
                kind="sensor calibration", columns={"said": text, **_calibration(text)}
            )
    return found, notes


def _calibration(text: str) -> dict[str, Any]:
    """Zero [Pa], gain and name of a sensor's calibration as the board says them."""
    zero, gain, name = ([*text.split(",", 2), "", "", ""])[:3]
    try:
        return {"zero": float(zero), "gain": float(gain), "name": name.strip(' "')}
    except ValueError:
        return {"zero": None, "gain": None, "name": None}


SQLITE = b"SQLite format 3\0"
HEAD = 100_000
"""Bytes at the start of a file in which its comment lines are looked for."""
CALIBRATED = {"scale_factor", "stiffness", "scale_factor_eq8", "standard_errors", "checks"}
"""Keys by which the JSON of `calibrate` is known."""
LARGEST_JSON = 50_000_000


def read(path: str | Path) -> Content:
    """What a file is; FileError for one that cannot be read, or is nothing the records take."""
    place, name = Path(path), str(path)
    try:
        if place.is_dir():
            raise FileError(name, "is a folder, not a file")
        if not place.is_file():
            raise FileError(name, "is no file")
        size = place.stat().st_size
        if not size:
            raise FileError(name, "is empty")
        if place.suffix == ENDING:
            check_whole(name)  # before it is opened: closing it would give up a recorder's locks
        with place.open("rb") as handle:
            head = handle.read(HEAD)
        digest = sha256(name)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(name[:200], f"cannot be read: {reason}") from None
    full = place.absolute()
    if storable(str(full)) != str(full):
        raise FileError(name, "has a name that is not UTF-8 text; rename it")
    own = {"sha256": digest, "bytes": size, "name": full.name, "folder": str(full.parent)}
    if head.startswith(SQLITE) or place.suffix == ENDING:
        return run(name, own)
    if place.suffix == ".toml":
        return _toml(name, own)
    if place.suffix == ".json":
        return _json(name, own)
    return _data(name, own, head)


def _toml(path: str, own: Mapping[str, Any]) -> Content:
    """A brake, a line, or the facts beside a measurement."""
    text = read_text(Path(path))
    tables = parse_toml(text, path)
    if "sheets" in tables:
        return _brake(path, own, text)
    heads = {key.partition(".")[0] for key in LineFile.fields if "." in key}
    if heads & tables.keys():
        return Content(
            path=path, file={**own, "kind": "line"}, what=made_of_text("line", text, path)
        )
    name = Path(path).name
    if name != FOLDER and not Path(name).stem.count("."):
        raise FileError(
            path,
            "is neither a brake ([sheets]), nor a line, nor the facts beside a measurement "
            "(NAME.csv.toml)",
        )
    beside = Path(path).with_name("x") if name == FOLDER else Path(path).with_suffix("")
    facts = read_facts(beside)
    return Content(path=path, file={**own, "kind": "facts", "simulated": facts.synthetic or None})


def _brake(path: str, own: Mapping[str, Any], text: str) -> Content:
    """A brake; one that a command of ours wrote holds a calibration too."""
    what = made_of_text("brake", text, path)
    file = {**own, "kind": "brake"}
    notes = BrakeFile.read(text, path).notes
    files, program = notes.get("files"), str(notes.get("program", ""))
    if not program.startswith("layerjam ") or not isinstance(files, list):
        return Content(path=path, file=file, what=what)
    cited = [*_named(files, "measured"), *_named(notes.get("excluded"), "left out")]
    if what.columns["parent"]:
        cited.append(Cited(what.columns["parent"], "start", "the brake that was changed"))
    held = tomlkit.dumps({"made_by": notes})
    calibration = Piece(
        kind="calibration",
        columns={
            "kind": " ".join([program.rsplit(maxsplit=1)[-1], str(notes.get("depth", ""))]).strip(),
            "result": json.dumps(notes, default=str),
            "covariance": _covariance(notes.get("covariance")),
            "checks": notes.get("verdict"),
            "result_toml": held,
            # the same words in two brakes of different numbers are two calibrations
            "sha256": text_digest(f"{what.columns['sha256']}\n{held}"),
            "simulated": _any_synthetic(files),
        },
        cited=tuple(cited),
    )
    others = {"calibration": calibration}
    return Content(path=path, file=file, what=what, others=others)


def _named(entries: Any, role: str) -> list[Cited]:
    """The files of a list of name and digest; what has no digest names none."""
    made = []
    for one in entries if isinstance(entries, list) else ():
        if not isinstance(one, dict):
            continue
        name = storable(str(one.get("name") or one.get("file") or ""))
        if digest := hex_of(one.get("sha256")):
            made.append(Cited(digest, role, name))
        if digest := hex_of(one.get("facts_sha256")):
            made.append(Cited(digest, "conditions", name + SIDECAR_ENDING))
    return made


def _covariance(rows: Any) -> str | None:
    """{value: {value: covariance}} as JSON, of the rows in a brake's [made_by]."""
    made: dict[str, dict[str, float]] = {}
    for row in rows if isinstance(rows, list) else ():
        if isinstance(row, dict) and row.keys() >= {"of", "and", "value"}:
            for one, other in ((row["of"], row["and"]), (row["and"], row["of"])):
                made.setdefault(str(one), {})[str(other)] = row["value"]
    return json.dumps(made, default=str) if made else None


def _any_synthetic(files: Any) -> bool | None:
    """Return True if a file of a list is marked synthetic, else None: nobody says."""
    marked = any(isinstance(one, dict) and one.get("synthetic") is True for one in files or ())
    return True if marked else None


def _json(path: str, own: Mapping[str, Any]) -> Content:
    """The JSON of a calibration, as `calibrate --json` prints it."""
    if own["bytes"] > LARGEST_JSON:
        raise FileError(path, "is too large for a result (more than 50 MB)")
    try:
        said = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"is not JSON: {str(error)[:80]}") from None
    if not isinstance(said, dict) or not said.keys() >= CALIBRATED:
        raise FileError(path, "is JSON, but not what 'layerjam calibrate --json' prints")
    made: Any = said.get("made_from")
    made = made if isinstance(made, dict) else {}
    brake: Any = made.get("brake")
    brake = brake if isinstance(brake, dict) else {}
    cited = [*_named(made.get("files"), "measured"), *_named(said.get("excluded"), "left out")]
    if digest := hex_of(brake.get("sha256")):
        cited.append(Cited(digest, "start", storable(str(brake.get("name", "")))))
    piece = Piece(
        kind="calibration",
        columns={
            "kind": storable(f"calibrate {said.get('depth', '')}".strip()),
            "result": json.dumps(said),
            "covariance": json.dumps(said["covariance"]) if said.get("covariance") else None,
            "checks": json.dumps(said["checks"]),
            "sha256": own["sha256"],
            "simulated": _any_synthetic(made.get("files")),
        },
        cited=tuple(cited),
    )
    notes = () if cited else ("it names what it comes from without digests and cannot be linked",)
    return Content(path=path, file={**own, "kind": "calibration"}, what=piece, notes=notes)


def _data(path: str, own: Mapping[str, Any], head: bytes) -> Content:
    """A measurement, or what was exported of a run; comment lines tell which."""
    comments = _comments(head)
    synthetic = says_synthetic("\n".join(comments).encode())
    with_facts = False
    try:
        with_facts = read_facts(path).synthetic
    except LayerjamError as error:
        raise FileError(path, f"the facts beside it cannot be read: {error}") from None
    file = {**own, "kind": "data", "simulated": True if synthetic or with_facts else None}
    said = dict(line.split(": ", 1) for line in comments if ": " in line)
    cited = [
        Cited(sha256(str(place)), "conditions", place.name)
        for place in places(path)
        if place.is_file()
    ]
    if comments and comments[0].endswith(" bench export") and said.get("run_id"):
        file["kind"] = "export"
        run_id = storable(said["run_id"].strip())
        cited.append(Cited(run_id, "run", "the run that was exported"))
    if (brake := _brake_above(comments)) is not None:
        cited.append(Cited(text_digest(brake), "brake", "the brake in its head"))
    return Content(path=path, file=file, cited=tuple(cited))


def _comments(head: bytes) -> list[str]:
    """The lines at the start that begin with '#', without it."""
    found = []
    for line in head.decode("utf-8-sig", "replace").splitlines():
        if not line.startswith("#"):
            break
        text = plain_comment(line)
        found.append(text[2:] if text.startswith("# ") else text[1:])
    return found


def _brake_above(comments: list[str]) -> str | None:
    """Return the text of the brake in the head of a simulated record, or None."""
    if "brake:" not in comments:
        return None
    lines = comments[comments.index("brake:") + 1 :]
    inside = [line.removeprefix("  ") for line in lines if not line or line.startswith("  ")]
    return "\n".join(inside) + "\n"
