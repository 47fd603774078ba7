"""The parts list: what to have on the table, without prices and without suppliers."""

from __future__ import annotations

import csv
import io
from dataclasses import astuple, dataclass, fields

from layerjam.device.workshop import M5
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.lengths import mm
from layerjam.fabricate.masses import screw_name
from layerjam.fabricate.screws import THREADS, length_for
from layerjam.units import show


@dataclass(frozen=True)
class Item:
    """One row: what it is, how many or how much, its file, and what it rests on."""

    item: str
    what: str
    quantity: str
    unit: str
    file: str
    basis: str
    """drawn, standard or choose."""


def items(made: Drawing) -> list[Item]:
    """All rows, for all brakes of the build."""
    return [*_film(made), *_printed(made), *_cast(made), *_bought(made), *_boards(made)]


def bom_csv(made: Drawing) -> str:
    """The parts list as CSV, with a row of headings."""
    out = io.StringIO(newline="")
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([f.name for f in fields(Item)])
    writer.writerows(astuple(row) for row in items(made))
    return out.getvalue()


def _film(made: Drawing) -> list[Item]:
    thickness = show(made.file.brake.sheets.thickness, "m")
    rows = [
        Item(
            part.name,
            f"film {thickness} thick",
            str(part.count),
            "pieces",
            f"cut/{part.name}.dxf",
            "drawn",
        )
        for part in made.film.parts
    ]
    for piece in made.film.pieces:
        size = f"{piece.length:.4g} mm × {piece.width:.4g} mm, the film runs along the first"
        rows.append(Item(piece.name, size, "1", "pieces", f"cut/{piece.name}.dxf", "drawn"))
    return rows


def _printed(made: Drawing) -> list[Item]:
    rows = []
    for part in made.parts:
        if not part.printed:
            continue
        count = part.count * (made.brakes if part.stays else 1)
        what = "printed, without leaks (SLA, or sealed)" if part.stays else "printed, a tool"
        rows.append(Item(part.name, what, str(count), "pieces", f"print/{part.name}.stl", "drawn"))
    return rows


def _cast(made: Drawing) -> list[Item]:
    wall = show(made.file.brake.enclosure.wall, "m")
    size = f"cast, {made.lengths.sleeve:.4g} mm long after trimming, wall {wall}"
    rows = [Item("enclosure", size, str(made.brakes), "pieces", "cad/sleeve.step", "drawn")]
    halves = made.silicone_parts
    words = ("A", "B") if halves else ("",)
    for word, mass in zip(words, halves or [made.silicone_mass], strict=True):
        name = f"silicone {word}".strip()
        what = "to mix, waste included"
        rows.append(Item(name, what, f"{mass * 1e3:.1f}", "g", "", "drawn"))
    return rows


def _bought(made: Drawing) -> list[Item]:
    found, build = made.lengths, made.build
    each = made.brakes
    size = f"dowel {mm(build.pin):g} mm"
    port = "thread M5" if build.port == M5 else f"tube {mm(float(build.port)):g} mm, glued in"
    rows = [
        ("screw", f"{screw_name(found)}, ISO 4762", 2 * found.screws * each, "standard"),
        ("nut", f"{found.thread.name}, ISO 4032", 2 * found.screws * each, "standard"),
        ("dowel pin", size, 2 * each, "standard"),
        ("cable tie", f"{mm(build.tie_width):g} mm wide", 2 * each, "choose"),
        ("tube fitting", f"{port}; one end may take a sensor or a plug", 2 * each, "choose"),
        ("tube", "to pump or valve, for the fitting", each, "choose"),
        ("mould bolt", bolt(made), 2 * (found.mould.bolts - 1), "standard"),
        ("mould nut", "for the mould's bolts", 2 * (found.mould.bolts - 1), "standard"),
    ]
    return [Item(item, what, str(count), "pieces", "", basis) for item, what, count, basis in rows]


def bolt(made: Drawing) -> str:
    """The mould's bolt as a shop calls it, as long as both halves and its nut."""
    hole = mm(made.build.mould_bolt)
    thread = max(
        (t for t in THREADS if t.clearance <= hole + 1e-9), key=lambda t: t.size, default=None
    )
    if thread is None:
        return f"for a hole of {hole:g} mm"
    least = 2 * made.lengths.mould.half + thread.nut_height
    length = length_for(least, thread)
    return f"{thread.name} × {length}" if length else f"{thread.name}, at least {least:.0f} mm long"


def _boards(made: Drawing) -> list[Item]:
    rows = [("jig", "board that holds the pins at rest distance", 1)]
    if made.parallel > 1:
        rows.append(("yoke", "plate of your material, above and below the heads", 4))
    if made.series > 1:
        rows.append(("link", "plate of your material", 2 * (made.series - 1) * made.parallel))
    return [
        Item(item, what, str(count), "pieces", f"cut/{item}.dxf", "drawn")
        for item, what, count in rows
    ]
