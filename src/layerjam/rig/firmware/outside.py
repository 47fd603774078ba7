"""Memory that our image keeps out of the heap: the collector need not look through it."""


def place(name: str) -> int:
    """Where the piece of that name begins; 0 under an image that reserves none."""
    try:
        import reserved
    except ImportError:
        return 0
    return getattr(reserved, name)


def piece(begin: int, size: int):
    """So many bytes of the memory from there on."""
    import uctypes

    return uctypes.bytearray_at(begin, size)
