"""A report as PDF, set by typst from the same text as the HTML page, on two sheets of A4."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam.errors import MissingExtraError

if TYPE_CHECKING:
    from types import ModuleType

PAGES = 2
SIZES = ((8.4, 1.0), (8.0, 0.94), (7.6, 0.88), (7.2, 0.80), (6.8, 0.72))
"""Type size [pt] and scale of the figures."""
TRIES = tuple((*size, apart) for apart in (True, False) for size in SIZES)
"""Tried in turn until the report fits, else the last: with validation on a page of its own first,
then on from where calibration ends."""
MOST_ROWS, MOST_FILES, MOST_NOTES, MOST_LETTERS = 14, 60, 6, 32
"""What is shown at most of each list; the rest is counted, and stands in results.json."""


def engine() -> ModuleType:
    """The typst module; raises MissingExtraError without it."""
    try:
        import typst
    except ImportError:
        raise MissingExtraError("the report as PDF (typst)", "pdf") from None
    return typst


def pdf(shown: Mapping[str, Any], pictures: Mapping[str, str]) -> bytes:
    """The PDF's bytes; the same content on the same date gives the same bytes.

    `shown` is what brake_report.context gives, `pictures` the figures' SVG by name. Fonts are those
    inside typst, so that no machine's fonts change a page.
    """
    typst = engine()
    when = datetime.fromisoformat(str(shown["date"])).replace(tzinfo=UTC)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, svg in pictures.items():
            (root / f"{name}.svg").write_text(svg, encoding="utf-8")
        template = (files("layerjam.report") / "brake_report.typ").read_text(encoding="utf-8")
        (root / "main.typ").write_text(template, encoding="utf-8")
        for size, scale, apart in TRIES:
            data = {**shortened(shown), "size": size, "scale": scale, "apart": apart}
            (root / "data.json").write_text(json.dumps(data), encoding="utf-8")
            place = {"input": str(root / "main.typ"), "root": folder, "ignore_system_fonts": True}
            drawn = typst.compile(**place, format="svg")
            if not isinstance(drawn, list) or len(drawn) <= PAGES:
                break
        return bytes(typst.compile(**place, format="pdf", timestamp=when))


def shortened(shown: Mapping[str, Any]) -> dict[str, Any]:
    """The content with lists cut to what two pages can hold, each saying how much it leaves out."""
    parts = []
    for part in shown["parts"]:
        tables = [_cut(t) for t in part["tables"] if t["printed"]]
        parts.append({**part, "tables": tables, "notes": _some(part["notes"], MOST_NOTES)})
    digests = shown["digests"]
    left = len(digests) - MOST_FILES
    return {
        **shown,
        "parts": parts,
        "digests": _columns([_digest(d) for d in digests[:MOST_FILES]], 3),
        "command": shown["short_command"],
        "more_files": f"and {left} more, in results.json" if left > 0 else "",
        "refused": shown["refused"][:MOST_NOTES],
        "more_refused": max(len(shown["refused"]) - MOST_NOTES, 0),
    }


def _digest(entry: Mapping[str, Any]) -> dict[str, Any]:
    """A file's line in a narrow column: a long name without its middle, 12 digits."""
    name = str(entry["name"])
    if len(name) > MOST_LETTERS:
        half = MOST_LETTERS // 2
        name = f"{name[: half - 1]}…{name[-half:]}"
    return {"name": name, "sha": str(entry["sha"])[:12]}


def _columns(items: list[Any], count: int) -> list[list[Any]]:
    """Items in columns of like height, read downwards."""
    long = -(-len(items) // count)
    return [items[i * long : (i + 1) * long] for i in range(count)]


def _cut(table: Mapping[str, Any]) -> dict[str, Any]:
    rows, total = table["rows"], table["total"]
    left = len(rows) - total - MOST_ROWS
    if left <= 0:
        return dict(table)
    kept = [*rows[:MOST_ROWS], *rows[len(rows) - total :]]
    note = f"{left} more rows in numbers.csv. {table['note']}"
    return {**table, "rows": kept, "note": note}


def _some(notes: list[str], most: int) -> list[str]:
    left = len(notes) - most
    return [*notes[:most], f"{left} more notes, in results.json"] if left > 0 else list(notes)
