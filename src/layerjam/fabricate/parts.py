"""All solids of a build: what is printed, how often, and the enclosure that is cast."""

from __future__ import annotations

from dataclasses import dataclass

from layerjam.device.workshop import Build
from layerjam.fabricate import mould
from layerjam.fabricate.cap import cap, plate
from layerjam.fabricate.lengths import Lengths
from layerjam.fabricate.solid import Solid


@dataclass(frozen=True)
class Part:
    """A solid and how many of it one brake needs."""

    solid: Solid
    count: int
    printed: bool = True
    stays: bool = True
    """Whether it becomes part of the brake; the mould does not."""

    @property
    def name(self) -> str:
        """Its name, also that of its files."""
        return self.solid.name


def parts(lengths: Lengths, build: Build) -> list[Part]:
    """Caps, plates, mould, core and enclosure; left and right apart where they differ."""
    made = []
    for shape, word in ((cap, "cap"), (plate, "plate")):
        if lengths.same_caps:
            made.append(Part(shape(lengths, build, lengths.left, word), 2))
            continue
        for side in lengths.sides:
            made.append(Part(shape(lengths, build, side, f"{word}-{side.name}"), 1))
    tools = (mould.bottom(lengths, build), mould.top(lengths, build), mould.core(lengths))
    made += [Part(tool, 1, stays=False) for tool in tools]
    return [*made, Part(mould.sleeve(lengths), 1, printed=False)]
