"""Content of a file, and the files that it cites, identified by digests, never by similarity.

A run is read from its own tables. Only the bytes of a test machine's file are used here.
"""

import json
import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.errors import FileError, LayerjamError
from layerjam.core.system import format_command_line, report_failure
from layerjam.core.toml_files.table_text import restore_comment
from layerjam.core.toml_files.toml import parse_toml, read_text
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.measure.runs import ENDING, open_run
from layerjam.laboratory.measure.sidecar import FOLDER, SIDECAR_ENDING, list_fact_files, read_facts
from layerjam.laboratory.measure.synthetic import is_marked_synthetic
from layerjam.laboratory.records.pieces import (
    Cited,
    Content,
    Piece,
    clean_text,
    make_piece,
    parse_digest,
    text_digest,
)

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
"""Calibration text of a board whose sensor was never calibrated."""
BOARD = {"serial": "board", "model": "model", "firmware": "firmware"}
"""{column of a board record: key of `meta`}."""


def require_closed_run(path: str) -> None:
    """Raise FileError if part of a run's data is still in a separate file."""
    log = Path(f"{path}-wal")
    if log.exists() and log.stat().st_size:
        command = ("sqlite3", Path(path).name, "PRAGMA journal_mode = DELETE")
        raise FileError(
            path,
            f"is not closed: {log.name} next to it contains part of the run. If the recording "
            f"has ended, close it with: {format_command_line(command)}",
        )


def read_run_content(path: str, file: Mapping[str, Any]) -> Content:
    """Return a run, with the brake, line, board and sensor calibration that it contains.

    Raises FileError for a file that is not a run or is incomplete.
    """
    base = open_run(path, is_complete=True)
    try:
        rows = base.execute("SELECT key, value FROM meta").fetchall()
        counts = base.execute(
            "SELECT count(*), max(seq) - min(seq) + 1 FROM samples GROUP BY boot"
        ).fetchall()
    except sqlite3.Error as error:
        raise FileError(path, f"is damaged: {error}") from None
    finally:
        base.close()
    meta = {str(key): clean_text(str(value)) for key, value in rows if value not in (None, "")}
    samples = sum(count for count, _ in counts)
    simulated = meta.get("simulated") != "0"
    columns = {
        **{key: meta.get(key) for key in STATED},
        "started": meta.get("started_utc"),
        "ended": meta.get("ended_utc"),
        "simulated": simulated,
        "samples": samples,
        "gaps": sum(span for _, span in counts) - samples,
        "file_sha256": file["sha256"],
        "file": file["name"],
    }
    others, notes = _read_pieces(path, meta)
    texts = [(kind, meta[f"{kind}_toml"]) for kind in ("brake", "line") if kind in others]
    if not meta.get("outcome"):
        notes.append("the run was not closed: it is stored as interrupted")
    return Content(
        path=path,
        file={**file, "kind": "run", "simulated": simulated},
        piece=Piece(kind="run", columns=columns),
        # also link a file of the same brake that may be added later
        cited=tuple(Cited(text_digest(text), kind, f"its {kind}") for kind, text in texts),
        others=others,
        notes=tuple(notes),
    )


def _read_pieces(path: str, meta: Mapping[str, str]) -> tuple[dict[str, Piece], list[str]]:
    """Return {role: record} of the records in a run, and notes on unreadable records."""
    records: dict[str, Piece] = {}
    notes = []
    for kind in ("brake", "line"):
        text = meta.get(f"{kind}_toml")
        if text is None:
            continue
        try:
            records[kind] = make_piece(kind, text, f"{path}, its {kind}")
        except LayerjamError as error:
            notes.append(f"its {kind} cannot be read and is not linked: {error}")
    if "board" in meta:
        columns = {name: meta.get(key) for name, key in BOARD.items()}
        records["board"] = Piece(kind="board", columns=columns)
        text = meta.get("sensor_calibration")
        if text is not None and _parse_calibration(text) != NONE:
            records["sensor calibration"] = Piece(
                kind="sensor calibration", columns={"said": text, **_parse_calibration(text)}
            )
    return records, notes


def _parse_calibration(text: str) -> dict[str, Any]:
    """Return the zero [Pa], gain and name of a sensor calibration from the board's report."""
    zero, gain, name = ([*text.split(",", 2), "", "", ""])[:3]
    try:
        return {"zero": float(zero), "gain": float(gain), "name": name.strip(' "')}
    except ValueError:
        return {"zero": None, "gain": None, "name": None}


SQLITE = b"SQLite format 3\0"
HEAD = 100_000
"""Number of bytes at the start of a file that are searched for comment lines."""
CALIBRATED = {"scale_factor", "stiffness", "scale_factor_eq8", "standard_errors", "checks"}
"""Keys that identify the JSON of `calibrate`."""
LOGARITHMS = ("scale_factor", "stiffness_measured")
CALIBRATION_NAMES = {"stiffness_measured": "stiffness"}
"""{name in the evidence: key of `calibrate`}."""
LARGEST_JSON = 50_000_000


def read_content(path: str | Path) -> Content:
    """Return the content of a file; raises FileError if it is unreadable or of unknown kind."""
    place, name = Path(path), str(path)
    with report_failure(name, "cannot be read"):
        if place.is_dir():
            raise FileError(name, "is a folder, not a file")
        if not place.is_file():
            raise FileError(name, "does not exist")
        size = place.stat().st_size
        if not size:
            raise FileError(name, "is empty")
        if place.suffix == ENDING:
            require_closed_run(name)  # do not open it: closing would release a recorder's locks
        with place.open("rb") as handle:
            head = handle.read(HEAD)
        digest = sha256(name)
    full_path = place.absolute()
    if clean_text(str(full_path)) != str(full_path):
        raise FileError(name, "has a name that is not UTF-8 text; rename it")
    file = {
        "sha256": digest,
        "bytes": size,
        "name": full_path.name,
        "folder": str(full_path.parent),
    }
    if head.startswith(SQLITE) or place.suffix == ENDING:
        return read_run_content(name, file)
    if place.suffix == ".toml":
        return _read_toml(name, file)
    if place.suffix == ".json":
        return _read_json(name, file)
    return _read_data(name, file, head)


def _read_toml(path: str, file: Mapping[str, Any]) -> Content:
    text = read_text(Path(path))
    tables = parse_toml(text, path)
    if "sheets" in tables:
        return _read_brake(path, file, text)
    heads = {key.partition(".")[0] for key in LineFile.fields if "." in key}
    if heads & tables.keys():
        return Content(
            path=path, file={**file, "kind": "line"}, piece=make_piece("line", text, path)
        )
    name = Path(path).name
    if name != FOLDER and not Path(name).stem.count("."):
        raise FileError(
            path,
            "is not a brake ([sheets]), a line, or the metadata of a measurement (NAME.csv.toml)",
        )
    measurement = Path(path).with_name("x") if name == FOLDER else Path(path).with_suffix("")
    facts = read_facts(measurement)
    return Content(path=path, file={**file, "kind": "facts", "simulated": facts.synthetic or None})


def _read_brake(path: str, entry: Mapping[str, Any], text: str) -> Content:
    """Return a brake, with its calibration if a layerjam command wrote one into it."""
    piece = make_piece("brake", text, path)
    file = {**entry, "kind": "brake"}
    brake = BrakeFile.read(text, path)
    notes = brake.notes
    files, program = notes.get("files"), str(notes.get("program", ""))
    if not program.startswith("layerjam ") or not isinstance(files, list):
        return Content(path=path, file=file, piece=piece)
    cited = [*_cite_files(files, "measured"), *_cite_files(notes.get("excluded"), "left out")]
    if piece.columns["parent"]:
        cited.append(Cited(piece.columns["parent"], "start", "the brake before the change"))
    result = tomlkit.dumps({"made_by": notes})
    calibration = Piece(
        kind="calibration",
        columns={
            "kind": " ".join([program.rsplit(maxsplit=1)[-1], str(notes.get("depth", ""))]).strip(),
            "result": json.dumps(notes, default=str),
            "covariance": _format_covariance(brake),
            "checks": notes.get("verdict"),
            "result_toml": result,
            # the same text in two brakes with different numbers means two calibrations
            "sha256": text_digest(f"{piece.columns['sha256']}\n{result}"),
            "simulated": _has_synthetic_file(files),
        },
        cited=tuple(cited),
    )
    origins = {"calibration": calibration}
    return Content(path=path, file=file, piece=piece, others=origins)


def _cite_files(entries: Any, role: str) -> list[Cited]:
    """Return the files in a list of names and digests, without entries that lack a digest."""
    citations = []
    for entry in entries if isinstance(entries, list) else ():
        if not isinstance(entry, dict):
            continue
        name = clean_text(str(entry.get("name") or entry.get("file") or ""))
        if digest := parse_digest(entry.get("sha256")):
            citations.append(Cited(digest, role, name))
        if digest := parse_digest(entry.get("facts_sha256")):
            citations.append(Cited(digest, "conditions", name + SIDECAR_ENDING))
    return citations


def _format_covariance(brake: BrakeFile) -> str | None:
    """Return {value: {value: covariance}} in SI as JSON, from the evidence of a calibration.

    Files of earlier versions have it as rows in [made_by].
    """
    matrix: dict[str, dict[str, float]] = {}
    for entry in brake.evidence:
        if entry.command == "calibrate":
            names = [CALIBRATION_NAMES.get(name, name) for name in entry.names]
            # logarithms, except the exponent's: a relative covariance times both values
            sizes = [
                brake.known_values.get(n, 1.0) if n in LOGARITHMS else 1.0 for n in entry.names
            ]
            square = entry.find_covariance() * np.outer(sizes, sizes)
            matrix = {
                name: dict(zip(names, row, strict=True))
                for name, row in zip(names, square.tolist(), strict=True)
            }
    rows = brake.notes.get("covariance")
    for row in rows if isinstance(rows, list) else ():
        if isinstance(row, dict) and row.keys() >= {"of", "and", "value"}:
            for row_name, column_name in ((row["of"], row["and"]), (row["and"], row["of"])):
                matrix.setdefault(str(row_name), {})[str(column_name)] = row["value"]
    return json.dumps(matrix, default=str) if matrix else None


def _has_synthetic_file(files: Any) -> bool | None:
    """Return True if any file in a list is marked as synthetic, otherwise None (unknown)."""
    marks = any(isinstance(row, dict) and row.get("synthetic") is True for row in files or ())
    return True if marks else None


def _read_json(path: str, file: Mapping[str, Any]) -> Content:
    """Return a calibration from the JSON that `calibrate --json` prints."""
    if file["bytes"] > LARGEST_JSON:
        raise FileError(path, "is too large for a result (more than 50 MB)")
    try:
        result = json.loads(Path(path).read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"is not JSON: {str(error)[:80]}") from None
    if not isinstance(result, dict) or not result.keys() >= CALIBRATED:
        raise FileError(path, "is JSON, but not the output of 'layerjam calibrate --json'")
    origin: Any = result.get("made_from")
    origin = origin if isinstance(origin, dict) else {}
    brake: Any = origin.get("brake")
    brake = brake if isinstance(brake, dict) else {}
    cited = [
        *_cite_files(origin.get("files"), "measured"),
        *_cite_files(result.get("excluded"), "left out"),
    ]
    if digest := parse_digest(brake.get("sha256")):
        cited.append(Cited(digest, "start", clean_text(str(brake.get("name", "")))))
    piece = Piece(
        kind="calibration",
        columns={
            "kind": clean_text(f"calibrate {result.get('depth', '')}".strip()),
            "result": json.dumps(result),
            "covariance": json.dumps(result["covariance"]) if result.get("covariance") else None,
            "checks": json.dumps(result["checks"]),
            "sha256": file["sha256"],
            "simulated": _has_synthetic_file(origin.get("files")),
        },
        cited=tuple(cited),
    )
    notes = () if cited else ("it lists its sources without digests, so it cannot be linked",)
    return Content(path=path, file={**file, "kind": "calibration"}, piece=piece, notes=notes)


def _read_data(path: str, entry: Mapping[str, Any], head: bytes) -> Content:
    """Return a measurement or an exported run; the comment lines distinguish them."""
    comments = _read_head_comments(head)
    synthetic = is_marked_synthetic("\n".join(comments).encode())
    with_facts = False
    try:
        with_facts = read_facts(path).synthetic
    except LayerjamError as error:
        raise FileError(path, f"its metadata cannot be read: {error}") from None
    file = {**entry, "kind": "data", "simulated": True if synthetic or with_facts else None}
    fields = dict(line.split(": ", 1) for line in comments if ": " in line)
    cited = [
        Cited(sha256(str(place)), "conditions", place.name)
        for place in list_fact_files(path)
        if place.is_file()
    ]
    if comments and comments[0].endswith(" bench export") and fields.get("run_id"):
        file["kind"] = "export"
        run_id = clean_text(fields["run_id"].strip())
        cited.append(Cited(run_id, "run", "the run that was exported"))
    if (brake := _find_header_brake(comments)) is not None:
        cited.append(Cited(text_digest(brake), "brake", "the brake in its header"))
    return Content(path=path, file=file, cited=tuple(cited))


def _read_head_comments(head: bytes) -> list[str]:
    comments = []
    for line in head.decode("utf-8-sig", "replace").splitlines():
        if not line.startswith("#"):
            break
        text = restore_comment(line)
        comments.append(text[2:] if text.startswith("# ") else text[1:])
    return comments


def _find_header_brake(comments: list[str]) -> str | None:
    """Return the text of the brake in the header of a simulated record, or None."""
    if "brake:" not in comments:
        return None
    lines = comments[comments.index("brake:") + 1 :]
    header_lines = [line.removeprefix("  ") for line in lines if not line or line.startswith("  ")]
    return "\n".join(header_lines) + "\n"
