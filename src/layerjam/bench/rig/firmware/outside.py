"""Memory that our image keeps outside the heap, so that the collector does not search it."""


def reserved_address(name: str) -> int:
    """Return the address of a reserved memory area; 0 if the image reserves none."""
    try:
        import reserved
    except ImportError:
        return 0
    return getattr(reserved, name)


def map_memory(begin: int, size: int):
    """Return `size` bytes of memory starting at an address."""
    import uctypes

    return uctypes.bytearray_at(begin, size)
