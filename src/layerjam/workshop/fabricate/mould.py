"""The enclosure, its mould and the mould's core (section 2.4) [mm]; x = 0 is in the middle.

The halves meet at z = 0. Both flanges have bolts; keys replace the middle pair. The sprue is at one
end and two vents are at the other, in the length that is cut off. The mould is filled upright.
"""

from collections.abc import Iterator

from layerjam.brake.device.workshop import Build
from layerjam.workshop.fabricate.lengths import KEY_DEPTH, KEY_HEIGHT, Lengths, mm
from layerjam.workshop.fabricate.solid import Box, Ellipse, Prism, Solid, add, cut, make_solid


def make_sleeve(lengths: Lengths) -> Solid:
    """Return the trimmed enclosure, a straight tube."""
    return _make_tube(
        "sleeve", lengths.inner_width, lengths.inner_height, lengths.wall, lengths.sleeve
    )


def make_casting(lengths: Lengths) -> Solid:
    """Return the casting in the mould: the enclosure with the ends that are cut off."""
    mould, walls = lengths.mould, lengths.mould.outer_width - lengths.mould.inner_width
    return _make_tube("casting", mould.inner_width, mould.inner_height, walls / 2, mould.casting)


def _make_tube(name: str, width: float, height: float, wall: float, length: float) -> Solid:
    outer = Box.from_centre((0, 0), width + 2 * wall, height + 2 * wall)
    inner = Box.from_centre((0, 0), width, height)
    ends = -length / 2, length / 2
    return make_solid(name, [add("x", *ends, outer), cut("x", *ends, inner)])


def make_core(lengths: Lengths) -> Solid:
    """Return the core, which the mould holds at both ends."""
    mould = lengths.mould
    section = Box.from_centre((0, 0), mould.inner_width, mould.inner_height)
    return make_solid("core", [add("x", -mould.core / 2, mould.core / 2, section)])


def make_bottom(lengths: Lengths, build: Build) -> Solid:
    """Return the lower half of the mould, with the pins of the keys."""
    pins = [
        add("z", 0, KEY_HEIGHT, Ellipse.circle(place, mm(build.key)))
        for place in bolt_positions(lengths)[1]
    ]
    body = list(_mould_half(lengths, build, is_lower=True))
    return make_solid("mould-bottom", [*body, *pins])


def make_top(lengths: Lengths, build: Build) -> Solid:
    """Return the upper half of the mould, with the holes for the keys, the sprue and the vents."""
    mould = lengths.mould
    prisms = list(_mould_half(lengths, build, is_lower=False))
    key_width = mm(build.key) + mm(build.key_clearance)
    prisms += [
        cut("z", 0, KEY_DEPTH, Ellipse.circle(place, key_width))
        for place in bolt_positions(lengths)[1]
    ]
    roof = mould.outer_height / 2
    for place, diameter in vent_positions(lengths, build):
        prisms.append(cut("z", roof, mould.half, Ellipse.circle(place, diameter)))
    return make_solid("mould-top", prisms)


def vent_positions(lengths: Lengths, build: Build) -> list[tuple[tuple[float, float], float]]:
    """Return (position, diameter) of sprue and vents, in the middle of the cut-off ends."""
    mould, trim = lengths.mould, mm(build.trim)
    sprue, vent = mm(build.sprue), mm(build.vent)
    low, high = (trim - mould.casting) / 2, (mould.casting - trim) / 2
    y = mould.outer_width / 4
    return [((low, 0.0), sprue), ((high, -y), vent), ((high, y), vent)]


def _mould_half(lengths: Lengths, build: Build, is_lower: bool) -> Iterator[Prism]:
    """Yield one mould half without keys and openings: block, cavity, core seats and bolt holes."""
    mould, gap = lengths.mould, mm(build.core_clearance)
    length, width = mould.length / 2, mould.width / 2
    low, high = (-mould.half, 0.0) if is_lower else (0.0, mould.half)
    yield add("z", low, high, Box((-length, -width), (length, width)))

    def cut_cavity(depth: float, ends: tuple[float, float], half: float) -> Prism:
        level = (-depth, 0.0) if is_lower else (0.0, depth)
        return cut("z", *level, Box((ends[0], -half), (ends[1], half)))

    end, reach = mould.casting / 2, mould.core / 2 + gap
    yield cut_cavity(mould.outer_height / 2, (-end, end), mould.outer_width / 2)
    seat, lower = mould.inner_width / 2 + gap, mould.inner_height / 2 + gap
    yield cut_cavity(lower, (-reach, -end), seat)
    yield cut_cavity(lower, (end, reach), seat)
    for place in bolt_positions(lengths)[0]:
        yield cut("z", low, high, Ellipse.circle(place, mm(build.mould_bolt)))


def bolt_positions(lengths: Lengths) -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Return the positions of the bolts, and those of the keys that replace the middle pair."""
    mould = lengths.mould
    y_row = (mould.outer_width + mould.flange) / 2
    first = -(mould.length - mould.flange) / 2
    step = -2 * first / (mould.bolts - 1)
    bolts: list[tuple[float, float]] = []
    keys: list[tuple[float, float]] = []
    for index in range(mould.bolts):
        pair = [(first + index * step, y) for y in (-y_row, y_row)]
        (keys if index == mould.bolts // 2 else bolts).extend(pair)
    return bolts, keys
