"""Assembly instructions, step by step, with the numbers of one build."""

from collections.abc import Collection
from dataclasses import dataclass

from layerjam.brake.device.load import catalogue
from layerjam.brake.device.workshop import M5
from layerjam.core.units import show
from layerjam.workshop.fabricate.bom import mould_bolt, mould_thread
from layerjam.workshop.fabricate.cutting import PUNCHED_BELOW
from layerjam.workshop.fabricate.drawing import Drawing
from layerjam.workshop.fabricate.lengths import M5_LEAST, M5_PITCH, mm, nut_overhang
from layerjam.workshop.fabricate.masses import screw_name
from layerjam.workshop.fabricate.silicone import cavity_volume


@dataclass(frozen=True)
class Step:
    """One step: an instruction, and commands to type."""

    text: str
    commands: tuple[str, ...] = ()


def _m(millimetres: float) -> str:
    return show(millimetres * 1e-3, "m")


def _check_ids(drawing: Drawing, *codes: str) -> str:
    return " ".join(
        f"{check.code}: {check.text}." for check in drawing.checks if check.code in codes
    )


PATTERN = "cut/pattern.pdf"


def film_steps(drawing: Drawing, coupons: bool, files: Collection[str] | None = None) -> list[str]:
    """Return the steps from film to a stack of sheets, given the written `files` (None: all)."""
    lengths, build = drawing.lengths, drawing.build
    made_of = ", ".join(f"{part.count} × cut/{part.name}.dxf" for part in drawing.film.parts)
    cutter = {
        "service": "Send the single-part files to the service. Their outlines are nominal: ask it "
        "to compensate its kerf, and to align the film's direction with each part.",
        "laser": "Cut whole pieces with cut/film-*.dxf: blue lines first, then red lines; omit the "
        f"INFO layer. The outlines include half the kerf of {_m(mm(build.kerf))}: "
        "switch off the laser's own compensation.",
        "knife": "Cut whole pieces with cut/film-*.dxf: blue lines first, then red lines; omit the "
        "INFO layer. The plotter adds its own offset and overcut.",
    }[build.cutter]
    out = [
        f"Measure the film's thickness in five places: it should be {_m(lengths.thickness)}. A "
        f"stack more than 7 % off {_m(lengths.stack)} changes the clamping and the force.",
        _check_ids(drawing, "C15"),
    ]
    if coupons:
        kerf_hint = {
            "service": "ask the service to compensate it.",
            "laser": "specify it with --kerf and build again.",
            "knife": "a knife leaves almost none.",
        }[build.cutter]
        out.append(
            "Cut cut/coupon.dxf first, from the same film. Push the ten slats of the comb "
            "together in their frame: the remaining gap, divided by 11, is the kerf; "
            f"{kerf_hint}"
        )
    by_hand = f" By hand, cut through {PATTERN} printed at 100 %; its ruler must measure 100 mm."
    if files is not None and PATTERN not in files:
        by_hand = " One piece exceeds every paper size, so there is no pattern to cut by hand."
    out += [
        f"Cut {made_of}. {cutter}",
        "Align every part with the film's direction, as drawn: the film "
        f"has different properties along and across it.{by_hand}",
    ]
    if lengths.hole < PUNCHED_BELOW and build.cutter == "knife":
        out.append(f"Punch the {_m(lengths.hole)} holes: a knife cannot cut round holes.")
    out.append(
        "Remove beads and char from the edges, wipe every part, and wear clean gloves. "
        f"Press all {lengths.count} sheets of one brake flat: the stack must measure "
        f"{_m(lengths.stack)}. If it measures more, beads remain."
    )
    return out


def cap_steps(drawing: Drawing) -> list[str]:
    """Return the steps for the printed parts, which are fitted before anything is stacked."""
    lengths, build = drawing.lengths, drawing.build
    thread = lengths.thread
    port = (
        f"Tap M5 threads in the ports ({_m(lengths.port)}) of both caps."
        if build.port == M5
        else f"The {_m(mm(float(build.port)))} tubes are glued into the ports later."
    )
    printed_parts = ", ".join(
        f"{part.count * drawing.brakes} × {part.name}"
        for part in drawing.parts
        if part.printed and part.stays
    )
    sides = "" if lengths.has_same_caps else " Mark left and right: the caps differ."
    return [
        f"Print {printed_parts} (print/print.3mf and print/*.stl contain one of each), solid, "
        "by SLA as in the paper. A cap printed from filament leaks between its layers unless "
        f"it is sealed.{sides}",
        "Uncured resin and solvent harm skin, eyes and lungs: work in a well-"
        "ventilated area, preferably under extraction, away from flames, with safety "
        "glasses and nitrile gloves. Wash and cure the parts, then clear the bores: blow "
        "through each cap from the port to the tray.",
        f"{port} Do it now: later, chips would fall into the stack.",
        f"Do a dry fit. {screw_name(lengths)} passes through plate and shelf. The "
        f"{thread.name} nut slides into its pocket from the front and does not turn. "
        f"The plate drops into the tray. The {_m(mm(build.pin))} dowel slides through "
        f"the head.{_describe_nut_corners(drawing)}",
        "Break every edge that the enclosure will touch, neck and tray first, and feel for "
        "burrs: a nick there causes a leak.",
    ]


def _describe_nut_corners(drawing: Drawing) -> str:
    lengths = drawing.lengths
    proud = nut_overhang(lengths)
    if proud <= 0:
        return " No nut projects from the tray."
    return (
        f" The front corner of each {lengths.thread.name} nut reaches up to {_m(round(proud, 2))} "
        "beyond the tray's face, where it would cut the enclosure: file that corner off, until no "
        "nut projects from the tray."
    )


def sleeve_steps(drawing: Drawing) -> list[str]:
    """Return the steps for the enclosure: mould, silicone, cutting to length."""
    lengths, build, silicone = drawing.lengths, drawing.build, drawing.file.making.enclosure
    halves = drawing.silicone_parts
    if halves is None:
        mass = show(drawing.silicone_mass / drawing.brakes, "kg", 3)
        amount = f"Mix {mass} of silicone as its manufacturer specifies"
    else:
        a, b = (show(half / drawing.brakes, "kg", 3) for half in halves)
        amount = f"Mix {a} of A with {b} of B ({silicone.mix})"
    life = (
        f"Its pot life is {show(silicone.pot_life, 's')}."
        if silicone.pot_life
        else "Its pot life is not in the brake file: read it off the can."
    )
    cure = (
        f"Let it cure for {show(silicone.cure_time, 's')}"
        if silicone.cure_time
        else "Let it cure as its manufacturer specifies"
    )
    count = 2 * (lengths.mould.bolts - 1)
    amount += " for each casting" if drawing.brakes > 1 else ""
    castings = "" if drawing.brakes == 1 else f" {drawing.brakes} castings are needed."
    return [
        "Print both halves and the core. Uncured resin, sulphur, latex and tin-cured silicone "
        "keep platinum silicone from curing. Seal a printed mould and wear vinyl gloves. "
        "Let a dab cure on a corner of the mould before you fill it.",
        f"{_check_ids(drawing, 'C13')} Place the core in its seats, set the upper half on the "
        f"two keys and close the mould with {count} bolts ({mould_bolt(drawing)}).",
        f"{amount} and degas it. {life} {_check_ids(drawing, 'C12')}",
        "Stand the mould on end, sprue at the bottom. Inject slowly at the sprue until "
        "silicone runs from both vents, then plug the sprue.",
        f"{cure}, open the mould, and work the core out with soapy water. Trim "
        f"{_m(mm(build.trim))} off each end, including sprue and vents: {_m(lengths.sleeve)} "
        f"remain. Rinse it and let it dry.{castings}",
        f"Measure the wall in eight places: it should be {_m(lengths.wall)}. Hold the "
        "enclosure up to the light: a bubble is a leak.",
    ]


def stack_steps(drawing: Drawing) -> list[str]:
    """Return the steps for placing the layers in both caps, and for the clamps."""
    lengths = drawing.lengths
    left, right = lengths.sides
    distance = f"{_m(lengths.pin_to_pin)} apart"
    faces = (
        "Both outer faces are left sheets."
        if lengths.count % 2
        else "The lowest layer is a left sheet, the highest a right sheet: mark the faces."
    )
    nuts = "the nut" if lengths.screws == 1 else f"the {lengths.screws} nuts"
    screw = "the screw" if lengths.screws == 1 else "the screws in turn"
    return [
        f"Slide {nuts} of each cap into the shelf from the front. Cut a board from "
        f"cut/jig.dxf, or drill two holes {distance}, and set the caps on dowels in the "
        f"board, with the trays facing each other.{_describe_levelling(drawing)}",
        f"Put a rod or a drill bit of {lengths.thread.size - lengths.thread.pitch:g} "
        "mm in the nut below each screw hole: it keeps every layer in place.",
        f"Stack from below as drawn above: a left sheet, a spacer behind it in the right cap; "
        f"then a right sheet, and a spacer in the left cap; and so on. The left cap holds "
        f"{left.sheets} sheets and {left.spacers} spacers, the right cap {right.sheets} and "
        f"{right.spacers}: {lengths.count} layers in each. {faces}",
        "Lay the plates on, replace each rod with its screw, one after the other, and "
        f"tighten {screw}. {_check_ids(drawing, 'C8')} Tighten again after an hour and after a "
        "day: plastic creeps under the screw, and only the clamping force holds.",
        f"Check that the cap faces are {_m(lengths.free)} apart. Pull by hand: all sheets must "
        "slide, none may buckle, and every hole must lie under its screw.",
    ]


def _describe_levelling(drawing: Drawing) -> str:
    lengths = drawing.lengths
    below = {
        "necks": lengths.neck_b,
        "trays": lengths.stack / 2 + lengths.shelf_height,
        "heads": lengths.head_height / 2,
    }
    lowest = max(below.values())
    gaps = {place: lowest - depth for place, depth in below.items() if lowest - depth > 0.05}
    if not gaps:
        return ""
    words = " and ".join(f"{_m(round(gap, 1))} under the {place}" for place, gap in gaps.items())
    return f" The caps differ in height: place strips of card or film, {words}."


def final_steps(drawing: Drawing) -> list[str]:
    """Return the steps for enclosure, ties and fittings."""
    lengths, build = drawing.lengths, drawing.build
    ends = f"{_m(lengths.left.reach)} behind the face of each cap"
    if not lengths.has_same_caps:
        ends = f"{_m(lengths.left.reach)} behind the left cap's face and "
        ends += f"{_m(lengths.right.reach)} behind the right cap's face"
    fitting = (
        f"Screw in the fittings, with a washer or thread tape, at least {_m(M5_LEAST)} "
        f"({M5_LEAST / M5_PITCH:.0f} turns; the thread is {_m(lengths.head / 2)} deep) and by hand "
        "only: threads in printed resin strip easily"
        if build.port == M5
        else f"Glue the {_m(mm(float(build.port)))} tubes in"
    )
    return [
        "Take the brake off the jig and pull out the dowels. In a well-ventilated area, "
        "wearing safety glasses and away from flames, wet the inside of the enclosure with "
        "isopropyl alcohol. Widen it with your fingers, and pull it over one head "
        "and cap and along the stack until it covers both necks. Use no talc or oil: "
        "the sheets work by friction. Let the alcohol dry.",
        f"The enclosure must end {ends}, at the head, "
        "and lie straight, without a fold over the groove.",
        f"Tie both necks in their grooves with ties {_m(mm(build.tie_width))} wide. Tighten by "
        f"hand, with about {show(build.tie_tension, 'N')}, turn the locks to opposite sides, "
        f"and cut the ends flush. {_check_ids(drawing, 'C11')}",
        f"{fitting}. Fit one to each port: one for the line to the pump or the valve, "
        "the other for a sensor or a plug.",
        "Put the dowels back. The brake hangs from the dowels only.",
    ]


def array_steps(drawing: Drawing) -> list[str]:
    """Return the steps for yokes and links."""
    out = []
    if drawing.series > 1:
        out.append(
            f"Join {drawing.series} brakes in a row with two links at each joint "
            "(cut/link.dxf), one above and one below the heads, on their dowels."
        )
    if drawing.parallel > 1 and drawing.yoke_moment is not None:
        out.append(
            f"Set {drawing.parallel} side by side between two yokes at each end "
            f"(cut/yoke.dxf). Bending moment: {show(drawing.yoke_moment, 'N m', 3)}. The "
            "section modulus of each yoke must be at least this moment divided by the "
            "allowable stress of your material. The load hangs from the eye; the brakes "
            "elongate equally only while the yoke does not tilt."
        )
    return out


def list_tools(drawing: Drawing) -> str:
    """Return the required tools as one sentence."""
    lengths, build = drawing.lengths, drawing.build
    keys = {lengths.thread.key}
    if (thread := mould_thread(drawing)) is not None:
        keys.add(thread.key)
    cutters = {"service": "", "laser": "a CO2 laser with extraction; ", "knife": "a plotter; "}
    cast = show(cavity_volume(lengths) * (1 + build.waste), "m^3", 2)
    things = [
        f"hex keys: {' and '.join(f'{key:g} mm' for key in sorted(keys))}",
        f"a torque driver for the {lengths.thread.key:g} mm key",
        "a calliper and a balance with 0.1 g resolution",
        *(["a tap M5 x 0.8"] if build.port == M5 else ["glue for the tubes"]),
        f"a syringe or mixing cartridge that holds {cast}",
        "safety glasses, nitrile gloves, ventilation or extraction for resin and solvent",
        "a cup, vinyl gloves and a sealer for printed moulds",
        "side cutters, thread tape, isopropyl alcohol, soapy water",
        "a board for the jig",
    ]
    return f"You need: {cutters[build.cutter]}{'; '.join(things)}."


def list_first_checks(drawing: Drawing, coupons: bool) -> list[Step]:
    """Return the checks to make on the first finished brake, each with its command."""
    lengths = drawing.lengths
    new_file = (
        (f"layerjam new my-brake --from {drawing.file.name} --out my-brake.toml",)
        if drawing.file.name in catalogue() and not drawing.file.path.endswith(".toml")
        else ()
    )
    mass = sum(row.mass for row in drawing.masses)
    strips = (
        "Drag a sled with a patch of the film over the strip of cut/coupon.dxf, along the film"
        if coupons
        else "Drag a sled with a patch of the film over a strip of it (--coupons draws both), "
        "along the film"
    )
    return [
        Step(
            f"Weigh it. As drawn, it weighs {show(mass, 'kg', 3)} without ties, fittings, tubes "
            "and dowels. Enter the mass in the brake file as weighed_mass.",
            (*new_file, "layerjam show my-brake.toml"),
        ),
        Step(
            "Check for leaks: pump to full vacuum, close the valve, and log the pressure "
            "for ten minutes. If the pressure rises, hold ties and ports under soapy water.",
            ("layerjam leak hold.csv --reading vacuum",),
        ),
        Step(
            f"{strips}.",
            (
                "layerjam friction friction-*.csv --normal-force 2.45N "
                "--brake my-brake.toml --out my-brake-friction.toml",
            ),
        ),
        Step(
            "Pull it slowly under vacuum in a test machine, no further than "
            f"{show(drawing.file.brake.sheets.usable_travel, 'm')} and behind a shield. "
            f"The maximum computed force is {show(drawing.force, 'N', 3)}.",
            (
                "layerjam calibrate my-brake-friction.toml pull-*.csv "
                "--out my-brake-calibrated.toml",
            ),
        ),
        Step(
            "Open the clamps again and check: no hole is elongated, no sheet has crept, and "
            f"the pins are still {_m(lengths.pin_to_pin)} apart. Then build the next one."
        ),
    ]
