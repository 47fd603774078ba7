"""The parts list: what to have on the table, without prices and without suppliers."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import astuple, dataclass, fields, replace

import numpy as np

from layerjam.device.workshop import M5
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.lengths import ellipse_girth, mm
from layerjam.fabricate.masses import screw_name
from layerjam.fabricate.screws import THREADS, Thread, sold_length
from layerjam.records.table_text import rows_text
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


def items(made: Drawing, there: Collection[str] | None = None) -> list[Item]:
    """All rows, for all brakes of the build; `there` are the files that are made, else all."""
    rows = [*_film(made), *_printed(made), *_cast(made), *_bought(made), *_boards(made)]
    return [row if there is None or row.file in there else replace(row, file="") for row in rows]


def bom_csv(made: Drawing, there: Collection[str] | None = None) -> str:
    """The parts list as CSV, with a row of headings."""
    rows = (astuple(row) for row in items(made, there))
    return rows_text([[f.name for f in fields(Item)], *rows])


def _film(made: Drawing) -> list[Item]:
    thickness = show(made.file.brake.sheets.thickness, "m")
    product = made.file.making.film.product
    bought = f"film {thickness} thick" + (f", {product}" if product else "")
    rows = [
        Item(
            part.name,
            bought,
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
    product = made.file.making.enclosure.product
    for word, mass in zip(words, halves or [made.silicone_mass], strict=True):
        name = f"silicone {word}".strip()
        what = f"{product}, " if product else ""
        what += "to mix, waste included"
        rows.append(Item(name, what, f"{mass * 1e3:.1f}", "g", "", "drawn"))
    return rows


def _bought(made: Drawing) -> list[Item]:
    found, build = made.lengths, made.build
    each = made.brakes
    head = show(found.head_height * 1e-3, "m")
    size = f"dowel {mm(build.pin):g} mm, longer than the head's {head} by what holds it"
    tied = show(tied_girth(made) * 1e-3, "m", 2)
    port = "thread M5" if build.port == M5 else f"tube {mm(float(build.port)):g} mm, glued in"
    rows = [
        ("screw", f"{screw_name(found)}, ISO 4762", 2 * found.screws * each, "standard"),
        ("nut", f"{found.thread.name}, ISO 4032", 2 * found.screws * each, "standard"),
        ("dowel pin", size, 2 * each, "standard"),
        ("cable tie", f"{mm(build.tie_width):g} mm wide, to go around {tied}", 2 * each, "choose"),
        ("tube fitting", f"{port}; one end may take a sensor or a plug", 2 * each, "choose"),
        ("tube", "to pump or valve, for the fitting", each, "choose"),
        ("mould bolt", bolt(made), 2 * (found.mould.bolts - 1), "standard"),
        ("mould nut", mould_nut(made), 2 * (found.mould.bolts - 1), "standard"),
    ]
    return [Item(item, what, str(count), "pieces", "", basis) for item, what, count, basis in rows]


def tied_girth(made: Drawing) -> float:
    """Length of a cable tie around enclosure and groove [mm]."""
    found, out = made.lengths, made.lengths.wall - mm(made.build.tie_depth)
    return ellipse_girth(found.neck_a + out, found.neck_b + out)


def mould_thread(made: Drawing) -> Thread | None:
    """The largest thread that goes through the mould's holes; None below M2."""
    hole = mm(made.build.mould_bolt)
    return max(
        (t for t in THREADS if t.clearance <= hole + 1e-9), key=lambda t: t.size, default=None
    )


def mould_nut(made: Drawing) -> str:
    """The nut of the mould's bolts as a shop calls it."""
    thread = mould_thread(made)
    return "for the mould's bolts" if thread is None else f"{thread.name}, ISO 4032"


def bolt(made: Drawing) -> str:
    """The mould's bolt as a shop calls it, as long as both halves and its nut."""
    thread = mould_thread(made)
    if thread is None:
        return f"for a hole of {mm(made.build.mould_bolt):g} mm"
    least = 2 * made.lengths.mould.half + thread.nut_height
    length = sold_length(least, thread)
    size = f"{thread.name} × {length:g}"
    if np.isnan(length):
        size = f"{thread.name}, at least {least:.0f} mm long"
    return f"{size}, ISO 4762"


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
