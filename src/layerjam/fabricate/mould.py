"""The enclosure, its mould and the mould's core (section 2.4) [mm]; x = 0 in the middle.

The mould parts at z = 0. Bolts stand in both flanges; keys take the place of the middle pair. The
sprue is at one end and two vents are at the other, in what is cut off; it is filled on end.
"""

from __future__ import annotations

from collections.abc import Iterator

from layerjam.device.workshop import Build
from layerjam.fabricate.lengths import KEY_DEPTH, KEY_HEIGHT, Lengths, mm
from layerjam.fabricate.solid import Box, Ellipse, Prism, Solid, add, cut, solid


def sleeve(lengths: Lengths) -> Solid:
    """The enclosure as trimmed, a straight tube."""
    return _tube("sleeve", lengths.inner_width, lengths.inner_height, lengths.wall, lengths.sleeve)


def casting(lengths: Lengths) -> Solid:
    """What the mould holds: the enclosure and what is cut off from it."""
    found, grown = lengths.mould, lengths.mould.outer_width - lengths.mould.inner_width
    return _tube("casting", found.inner_width, found.inner_height, grown / 2, found.casting)


def _tube(name: str, width: float, height: float, wall: float, length: float) -> Solid:
    outer = Box.about((0, 0), width + 2 * wall, height + 2 * wall)
    inner = Box.about((0, 0), width, height)
    ends = -length / 2, length / 2
    return solid(name, [add("x", *ends, outer), cut("x", *ends, inner)])


def core(lengths: Lengths) -> Solid:
    """The core, which the mould holds at both ends."""
    found = lengths.mould
    section = Box.about((0, 0), found.inner_width, found.inner_height)
    return solid("core", [add("x", -found.core / 2, found.core / 2, section)])


def bottom(lengths: Lengths, build: Build) -> Solid:
    """The lower half, with the keys' pins."""
    pins = [
        add("z", 0, KEY_HEIGHT, Ellipse.circle(place, mm(build.key)))
        for place in places(lengths)[1]
    ]
    body = list(_half(lengths, build, below=True))
    return solid("mould-bottom", [*body, *pins])


def top(lengths: Lengths, build: Build) -> Solid:
    """The upper half, with the keys' holes, the sprue and the vents."""
    found = lengths.mould
    prisms = list(_half(lengths, build, below=False))
    wide = mm(build.key) + mm(build.key_clearance)
    prisms += [cut("z", 0, KEY_DEPTH, Ellipse.circle(place, wide)) for place in places(lengths)[1]]
    roof = found.outer_height / 2
    for place, diameter in openings(lengths, build):
        prisms.append(cut("z", roof, found.half, Ellipse.circle(place, diameter)))
    return solid("mould-top", prisms)


def openings(lengths: Lengths, build: Build) -> list[tuple[tuple[float, float], float]]:
    """(place, diameter) of sprue and vents, in the middle of the length that is cut off."""
    found, trim = lengths.mould, mm(build.trim)
    sprue, vent = mm(build.sprue), mm(build.vent)
    low, high = (trim - found.casting) / 2, (found.casting - trim) / 2
    aside = found.outer_width / 4
    return [((low, 0.0), sprue), ((high, -aside), vent), ((high, aside), vent)]


def _half(lengths: Lengths, build: Build, below: bool) -> Iterator[Prism]:
    """One half without keys and openings: block, cavity, seats of the core, bolts."""
    found, gap = lengths.mould, mm(build.core_clearance)
    length, width = found.length / 2, found.width / 2
    low, high = (-found.half, 0.0) if below else (0.0, found.half)
    yield add("z", low, high, Box((-length, -width), (length, width)))

    def hollow(depth: float, ends: tuple[float, float], half: float) -> Prism:
        level = (-depth, 0.0) if below else (0.0, depth)
        return cut("z", *level, Box((ends[0], -half), (ends[1], half)))

    end, far = found.casting / 2, found.core / 2 + gap
    yield hollow(found.outer_height / 2, (-end, end), found.outer_width / 2)
    seat, deep = found.inner_width / 2 + gap, found.inner_height / 2 + gap
    yield hollow(deep, (-far, -end), seat)
    yield hollow(deep, (end, far), seat)
    for place in places(lengths)[0]:
        yield cut("z", low, high, Ellipse.circle(place, mm(build.mould_bolt)))


def places(lengths: Lengths) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Places of the bolts, and of the keys instead of the middle pair."""
    found = lengths.mould
    aside = (found.outer_width + found.flange) / 2
    first = -(found.length - found.flange) / 2
    step = -2 * first / (found.bolts - 1)
    bolts: list[tuple[float, float]] = []
    keys: list[tuple[float, float]] = []
    for index in range(found.bolts):
        pair = [(first + index * step, y) for y in (-aside, aside)]
        (keys if index == found.bolts // 2 else bolts).extend(pair)
    return bolts, keys
