"""assembly.pdf: how to build a brake, with its pictures, parts list, checks and assumptions."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from layerjam._version import __version__
from layerjam.fabricate.bom import items
from layerjam.fabricate.drawing import Drawing
from layerjam.report import assembly_steps as steps
from layerjam.report.typeset import typeset
from layerjam.units import show

Block = dict[str, Any]
MARKS = {"passed": "ok", "note": "-", "warning": "LOOK", "failed": "FAIL"}


def assembly(
    made: Drawing,
    named: Mapping[str, str],
    coupons: bool = False,
    there: Collection[str] | None = None,
) -> bytes:
    """The PDF's bytes; `named` holds the pictures as SVG by name.

    `there` are the files beside it, all that there can be without it. Raises MissingExtraError
    without typst.
    """
    data = {
        "title": f"How to build {made.file.name}",
        "lead": made.file.title or "A layer-jamming brake",
        "footer": f"layerjam {__version__}",
        "banner": [
            "This design was never cut, printed or cast by us. Build one, do the checks on the "
            "last pages, and only then build more.",
            *made.film.notes,
        ],
        "numbers": _numbers(made),
        "parts": _parts(made, coupons, there),
    }
    return typeset("assembly", data, {f"{name}.svg": svg for name, svg in named.items()})


def _numbers(made: Drawing) -> list[tuple[str, str]]:
    found = made.lengths
    mass = sum(row.mass for row in made.masses)
    return [
        (str(made.brakes), "brake" if made.brakes == 1 else "brakes"),
        (show(mass, "kg", 3), "each as drawn, without fittings"),
        (show(found.pin_to_pin * 1e-3, "m"), "pin to pin at rest"),
        (show(found.strap * 1e-3, "m"), "pin to pin, pulled out"),
        (show(made.torque, "N m", 2), "on each clamp screw"),
    ]


def _parts(made: Drawing, coupons: bool, there: Collection[str] | None) -> list[dict[str, Any]]:
    chapters: list[tuple[str, bool, list[Block]]] = [
        (
            "1  Parts",
            False,
            [picture("exploded"), _list(made, there), {"kind": "text", "text": steps.tools(made)}],
        ),
        (
            "2  Cut the film",
            True,
            [numbered(steps.film(made, coupons, there)), picture("film", _share(made))],
        ),
        ("3  Print caps and plates", True, [numbered(steps.caps(made)), picture("section")]),
        ("4  Cast the enclosure", True, [picture("mould", 0.8), numbered(steps.sleeve(made))]),
        (
            "5  Stack and clamp",
            True,
            [picture("layers", 0.86), numbered(steps.stack(made)), picture("stacking", 0.62)],
        ),
        ("6  Close it", True, [picture("assembled", 0.86), numbered(steps.close(made))]),
    ]
    if made.brakes > 1:
        chapters.append(
            ("7  Join the brakes", False, [picture("boards", 0.7), numbered(steps.array(made))])
        )
    number = len(chapters) + 1
    chapters += [
        (f"{number}  Check the first one", True, [numbered(steps.first(made, coupons))]),
        (f"{number + 1}  What the drawing was checked for", False, [_checks(made)]),
        (f"{number + 2}  What is assumed", False, [{"kind": "list", "items": made.assumptions()}]),
    ]
    return [{"title": t, "page": page, "blocks": blocks} for t, page, blocks in chapters]


def picture(name: str, share: float = 1.0) -> Block:
    """A picture at a share of the page's width."""
    return {"kind": "picture", "name": name, "share": share}


def numbered(found: Sequence[steps.Step]) -> Block:
    """Numbered steps with the commands that belong to them."""
    rows = [{"text": step.text, "commands": list(step.commands)} for step in found]
    return {"kind": "steps", "steps": rows}


def _share(made: Drawing) -> float:
    """Share of the width at which the film's picture leaves room for the steps."""
    if not made.film.pieces:
        return 0.5
    piece = made.film.pieces[0]
    return min(0.8, 0.8 * piece.length / piece.width)


def _list(made: Drawing, there: Collection[str] | None) -> Block:
    rows = [
        [
            row.item,
            row.what,
            f"{row.quantity} {row.unit}" if row.unit == "g" else row.quantity,
            row.file,
            row.basis,
        ]
        for row in items(made, there)
    ]
    return {
        "kind": "table",
        "head": ["part", "what", "how many", "file", ""],
        "columns": ["auto", "1fr", "auto", "auto", "auto"],
        "right": [2],
        "rows": rows,
    }


def _checks(made: Drawing) -> Block:
    rows = [[MARKS[check.level], check.code, check.text] for check in made.checks]
    return {"kind": "checks", "rows": rows}
