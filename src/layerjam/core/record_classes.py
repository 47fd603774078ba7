"""Classes decorated with `record`."""

from collections.abc import Callable

__all__ = ["RECORDS", "add_record", "follow_records"]
RECORDS: list[type] = []
"""Every class decorated with `record`."""
_followers: list[Callable[[type], None]] = []


def follow_records(function: Callable[[type], None]) -> None:
    """Call a function with each record class, now and whenever a further one is defined."""
    _followers.append(function)
    for cls in RECORDS:
        function(cls)


def add_record(cls: type) -> None:
    """Add a record class and tell the followers."""
    RECORDS.append(cls)
    for function in _followers:
        function(cls)
