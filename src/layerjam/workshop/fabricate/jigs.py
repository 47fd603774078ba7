"""Flat parts other than sheets [mm]: the jig, an array's yokes and links, and the coupons."""

from layerjam.workshop.fabricate.outline import Circle, Cut, Outline

CORNER = 3.0
"""Radius of the corners of a board [mm]."""
RIM = 10.0
"""Smallest distance from a hole's centre to the board's edge [mm]."""
EYE = 15.0
"""Distance of a yoke's eye from the row of pins [mm]."""
SLATS, SLAT = 10, 10.0
"""Number of slats in the comb, and width of each [mm]."""
_SLED = 25.0
"""Side length of the sled's face in the paper's friction test [mm]."""


def edge_distance(bore: float) -> float:
    """Return the distance from a hole's centre to the board's edge [mm]."""
    return max(RIM, bore / 2 + 5)


def make_jig(pin_to_pin: float, bore: float) -> Outline:
    """Return a board with a hole for each pin, at the distance between the pins at rest."""
    edge = edge_distance(bore) + 5
    return Outline(
        length=pin_to_pin + 2 * edge,
        width=2 * edge,
        start=CORNER,
        end=CORNER,
        holes=[Circle(edge + x, 0.0, bore) for x in (0.0, pin_to_pin)],
    )


def make_yoke(brakes: int, pitch: float, bore: float) -> Outline:
    """Return a plate that joins parallel brakes; the load hangs from the eye in its middle.

    The eye is not in the row of the pins, because an odd number of brakes has a pin in the middle.
    """
    edge = edge_distance(bore)
    row = [Circle(edge + i * pitch, -EYE / 2, bore) for i in range(brakes)]
    middle = edge + (brakes - 1) * pitch / 2
    return Outline(
        length=(brakes - 1) * pitch + 2 * edge,
        width=EYE + 2 * edge,
        start=CORNER,
        end=CORNER,
        holes=[*row, Circle(middle, EYE / 2, bore)],
    )


def make_link(head: float, gap: float, bore: float) -> Outline:
    """Return a plate that joins two brakes in series; `head` is the length of a cap's head."""
    edge = edge_distance(bore)
    return Outline(
        length=head + gap + 2 * edge,
        width=2 * edge,
        start=edge,
        end=edge,
        holes=[Circle(edge + x, 0.0, bore) for x in (0.0, head + gap)],
    )


def make_coupon(hole: float, gap: float) -> list[Outline]:
    """Return test pieces at nominal size, to cut first, from the same film in the same direction.

    A comb of ten slats in a frame measures the kerf: pushed together, the slats leave a gap of
    eleven kerfs. The square with a hole measures the kerf again. A strip and three patches are
    specimens for `layerjam friction`.
    """
    comb = Outline(
        length=SLATS * SLAT,
        width=25.0,
        cuts=[Cut((i * SLAT, -12.5), (i * SLAT, 12.5)) for i in range(1, SLATS)],
    )
    square = Outline(length=20.0, width=20.0, holes=[Circle(10.0, 0.0, hole)])
    strip = Outline(length=170.0, width=40.0, start=2.0, end=2.0)
    patch = Outline(length=_SLED + 20, width=_SLED, start=1.0, end=1.0)
    upper_length = 20.0 + gap + 12.5
    top = upper_length + 12.5 + gap + patch.width / 2
    row = [patch.translate(i * (patch.length + gap), top) for i in range(3)]
    comb = comb.translate(0.0, upper_length)
    square = square.translate(SLATS * SLAT + gap + 1, upper_length)
    return [strip, comb, square, *row]
