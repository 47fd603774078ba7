"""Time on the board: microseconds in 30 bits, which wrap every 17.9 minutes."""

WRAP = 1 << 30
PERIOD = 10000
"""Between two samples [us]."""


def diff(later: int, earlier: int) -> int:
    """Microseconds from one count to another, right across a wrap, within 8.9 minutes."""
    return ((later - earlier + (WRAP >> 1)) & (WRAP - 1)) - (WRAP >> 1)


def add(count: int, us: int) -> int:
    """The count so many microseconds later."""
    return (count + us) & (WRAP - 1)
