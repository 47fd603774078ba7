"""Solids of a build: printed parts with their quantities, and the cast enclosure."""

from dataclasses import dataclass

from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate import mould
from layerjam.workshop.fabricate.cap import make_cap, make_plate
from layerjam.workshop.fabricate.lengths import Lengths
from layerjam.workshop.fabricate.solid import Solid


@dataclass(frozen=True)
class Part:
    """A solid, and the number of copies for one brake."""

    solid: Solid
    count: int
    printed: bool = True
    stays: bool = True
    """Whether it becomes part of the brake, unlike the mould."""

    @property
    def name(self) -> str:
        """Name of the part and of its files."""
        return self.solid.name


def make_parts(lengths: Lengths, build: Build) -> list[Part]:
    """Return caps, plates, mould, core and enclosure, by side if the sides differ."""
    solids = []
    for shape, word in ((make_cap, "cap"), (make_plate, "plate")):
        if lengths.has_same_caps:
            solids.append(Part(shape(lengths, build, lengths.left, word), 2))
            continue
        for side in lengths.sides:
            solids.append(Part(shape(lengths, build, side, f"{word}-{side.name}"), 1))
    tools = [mould.make_bottom(lengths, build), mould.make_top(lengths, build)]
    solids += [Part(tool, 1, stays=False) for tool in (*tools, mould.make_core(lengths))]
    return [*solids, Part(mould.make_sleeve(lengths), 1, printed=False)]
