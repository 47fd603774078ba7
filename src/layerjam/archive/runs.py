"""A run of a bench as the records take it: what its own tables say, and what is inside it."""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from layerjam.archive.pieces import Cited, Content, Piece, made_of_text, storable, text_digest
from layerjam.errors import FileError, LayerjamError
from layerjam.measure.runs import opened

STATED = (
    "run_id",
    "procedure",
    "outcome",
    "firmware",
    "law_sha256",
    "settings_hex",
    "safe_state",
)
"""What `meta` says under the names that the table of runs has."""
NONE = {"zero": 0.0, "gain": 1.0, "name": ""}
"""What a board says whose sensor was never calibrated."""
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

    Raises FileError for a file that is no run, or not a whole one.
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
