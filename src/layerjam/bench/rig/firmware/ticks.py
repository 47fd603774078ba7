"""Time on the board: microseconds in 30 bits, which wrap every 17.9 minutes."""

WRAP = 1 << 30
PERIOD = 10000
"""Time between two samples [us]."""


def diff(later: int, earlier: int) -> int:
    """Return the microseconds between two counts, also across a wrap, for up to 8.9 minutes."""
    return ((later - earlier + (WRAP >> 1)) & (WRAP - 1)) - (WRAP >> 1)


def add(count: int, us: int) -> int:
    """Return the clock count `us` microseconds later."""
    return (count + us) & (WRAP - 1)
