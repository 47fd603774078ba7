"""Parts list: everything needed for a build, without prices or suppliers."""

from collections.abc import Collection
from dataclasses import astuple, dataclass, fields

import numpy as np

from layerjam.brake.device.workshop import M5
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.table_text import format_rows
from layerjam.core.units import show
from layerjam.workshop.fabricate.drawing import Drawing
from layerjam.workshop.fabricate.lengths import ellipse_girth, mm
from layerjam.workshop.fabricate.masses import screw_name
from layerjam.workshop.fabricate.screws import THREADS, Thread, find_screw_length


@dataclass(frozen=True)
class Item:
    """One row of the parts list: part, description, quantity, file and basis."""

    item: str
    what: str
    quantity: str
    unit: str
    file: str
    basis: str
    """Basis of the row: "drawn", "standard" or "choose" (left to the builder)."""


def list_items(plan: Drawing, files: Collection[str] | None = None) -> list[Item]:
    """Return the rows for all brakes of a build; `files` lists the files written (default: all)."""
    rows = [
        *_film_items(plan),
        *_printed_items(plan),
        *_casting_items(plan),
        *_bought_items(plan),
        *_board_items(plan),
    ]
    return [row if files is None or row.file in files else evolve(row, file="") for row in rows]


def bom_csv(plan: Drawing, files: Collection[str] | None = None) -> str:
    """Return the parts list as CSV, with a header row."""
    rows = (astuple(row) for row in list_items(plan, files))
    return format_rows([[f.name for f in fields(Item)], *rows])


def _film_items(plan: Drawing) -> list[Item]:
    thickness = show(plan.file.brake.sheets.thickness, "m")
    product = plan.file.making.film.product
    material = f"film {thickness} thick" + (f", {product}" if product else "")
    rows = [(part.name, material, part.count) for part in plan.film.parts]
    for piece in plan.film.pieces:
        size = f"{piece.length:.4g} mm × {piece.width:.4g} mm; the film runs along the first side"
        rows.append((piece.name, size, 1))
    return [_cut_item(*row) for row in rows]


def _cut_item(name: str, text: str, count: int) -> Item:
    return Item(name, text, str(count), "pieces", f"cut/{name}.dxf", "drawn")


def _printed_items(plan: Drawing) -> list[Item]:
    rows = []
    for part in plan.parts:
        if not part.printed:
            continue
        count = part.count * (plan.brakes if part.stays else 1)
        kind = "printed airtight (SLA, or sealed)" if part.stays else "printed tool"
        rows.append(Item(part.name, kind, str(count), "pieces", f"print/{part.name}.stl", "drawn"))
    return rows


def _casting_items(plan: Drawing) -> list[Item]:
    wall = show(plan.file.brake.enclosure.wall, "m")
    size = f"cast, {plan.lengths.sleeve:.4g} mm long after trimming, wall {wall}"
    rows = [Item("enclosure", size, str(plan.brakes), "pieces", "cad/sleeve.step", "drawn")]
    halves = plan.silicone_parts
    words = ("A", "B") if halves else ("",)
    product = plan.file.making.enclosure.product
    for word, mass in zip(words, halves or [plan.silicone_mass], strict=True):
        name = f"silicone {word}".strip()
        text = f"{product}, " if product else ""
        text += "to mix, including waste"
        rows.append(Item(name, text, f"{mass * 1e3:.1f}", "g", "", "drawn"))
    return rows


def _bought_items(plan: Drawing) -> list[Item]:
    lengths, build = plan.lengths, plan.build
    number = plan.brakes
    head = show(lengths.head_height * 1e-3, "m")
    size = f"dowel {mm(build.pin):g} mm, longer than the head ({head}) by its fastener's height"
    tie = show(groove_girth(plan) * 1e-3, "m", 2)
    port = "thread M5" if build.port == M5 else f"tube {mm(float(build.port)):g} mm, glued in"
    rows = [
        ("screw", f"{screw_name(lengths)}, ISO 4762", 2 * lengths.screws * number, "standard"),
        ("nut", f"{lengths.thread.name}, ISO 4032", 2 * lengths.screws * number, "standard"),
        ("dowel pin", size, 2 * number, "standard"),
        (
            "cable tie",
            f"{mm(build.tie_width):g} mm wide, for a circumference of {tie}",
            2 * number,
            "choose",
        ),
        ("tube fitting", f"{port}; one end may have a sensor or a plug", 2 * number, "choose"),
        ("tube", "to the pump or valve, to suit the fitting", number, "choose"),
        ("mould bolt", mould_bolt(plan), 2 * (lengths.mould.bolts - 1), "standard"),
        ("mould nut", mould_nut(plan), 2 * (lengths.mould.bolts - 1), "standard"),
    ]
    return [Item(item, text, str(n), "pieces", "", basis) for item, text, n, basis in rows]


def groove_girth(plan: Drawing) -> float:
    """Return the girth of the enclosure in the groove for the cable tie [mm]."""
    lengths, out = plan.lengths, plan.lengths.wall - mm(plan.build.tie_depth)
    return ellipse_girth(lengths.neck_a + out, lengths.neck_b + out)


def mould_thread(plan: Drawing) -> Thread | None:
    """Return the largest thread that fits the mould's bolt holes; None if not even M2 fits."""
    hole = mm(plan.build.mould_bolt)
    return max(
        (t for t in THREADS if t.clearance <= hole + 1e-9), key=lambda t: t.size, default=None
    )


def mould_nut(plan: Drawing) -> str:
    """Return the designation of the nuts for the mould's bolts."""
    thread = mould_thread(plan)
    return "for the mould's bolts" if thread is None else f"{thread.name}, ISO 4032"


def mould_bolt(plan: Drawing) -> str:
    """Return the designation of a bolt that is long enough for both mould halves and its nut."""
    thread = mould_thread(plan)
    if thread is None:
        return f"for a hole of {mm(plan.build.mould_bolt):g} mm"
    min_length = 2 * plan.lengths.mould.half + thread.nut_height
    length = find_screw_length(min_length, thread)
    size = f"{thread.name} × {length:g}"
    if np.isnan(length):
        size = f"{thread.name}, at least {min_length:.0f} mm long"
    return f"{size}, ISO 4762"


def _board_items(plan: Drawing) -> list[Item]:
    rows = [("jig", "board that holds the pins at their rest distance", 1)]
    if plan.parallel > 1:
        rows.append(("yoke", "plate of any material, above and below the heads", 4))
    if plan.series > 1:
        rows.append(("link", "plate of any material", 2 * (plan.series - 1) * plan.parallel))
    return [_cut_item(*row) for row in rows]
