"""The pictures of a build as files: shaded ones as PNG, all of them with their words as SVG."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import NamedTuple

from layerjam.device.workshop import Build
from layerjam.fabricate.drawing import Drawing
from layerjam.fabricate.film import plates
from layerjam.fabricate.lengths import Lengths
from layerjam.fabricate.nest import Piece
from layerjam.report import build_drawings as drawings
from layerjam.report.assembly import assembly
from layerjam.report.assembly_steps import PATTERN
from layerjam.report.build_pictures import labelled, shots
from layerjam.report.build_scene import scene
from layerjam.report.pattern import pattern
from layerjam.report.svg import drawn


class Pictures(NamedTuple):
    """Pictures by name."""

    plain: dict[str, bytes]
    """PNG of what is shaded, without words."""
    named: dict[str, str]
    """SVG of every picture, with names or dimensions."""

    def files(self) -> dict[str, bytes]:
        """{path: bytes}."""
        made = {f"pictures/{name}.png": png for name, png in self.plain.items()}
        return made | {f"pictures/{name}.svg": svg.encode() for name, svg in self.named.items()}


def pictures(build: Build, lengths: Lengths, pieces: Sequence[Piece]) -> Pictures:
    """Exploded, stacking, mould, assembled; layers, film, and the section with dimensions.

    Raises MissingExtraError without matplotlib or manifold3d.
    """
    world = scene(build, lengths)
    seen = shots(world)
    figures = {name: labelled(shot, labels) for name, (shot, labels) in seen.items()}
    figures |= {"section": drawings.section(world), "layers": drawings.order(world)}
    if pieces:
        figures["film"] = drawings.film(pieces[0])
    return Pictures(
        {name: shot.png() for name, (shot, _) in seen.items()},
        {name: drawn(figure) for name, figure in figures.items()},
    )


def papers(
    made: Drawing, coupons: bool = False, others: Collection[str] | None = None
) -> dict[str, bytes]:
    """{path: bytes} of the pictures, assembly.pdf and cut/pattern.pdf of a build.

    `others` are its other files, all that there can be without it. No pattern where a piece of film
    is larger than any paper. Raises MissingExtraError without matplotlib, manifold3d or typst.
    """
    drawn_ones = pictures(made.build, made.lengths, made.film.pieces)
    if made.brakes > 1:
        flat_parts = plates(made.build, made.lengths, made.parallel, made.series)
        drawn_ones.named["boards"] = drawn(drawings.plates(list(flat_parts.items())))
    content = drawn_ones.files()
    flat = pattern(made.film.pieces, made.film.notes)
    if flat is not None:
        content[PATTERN] = flat
    there = None if others is None else {*others, *content}
    content["assembly.pdf"] = assembly(made, drawn_ones.named, coupons, there)
    return content
