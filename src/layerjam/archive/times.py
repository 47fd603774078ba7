"""Times as the records hold them."""

from __future__ import annotations

from datetime import UTC, datetime


def now() -> str:
    """The moment, UTC in RFC 3339 to the millisecond: 2026-11-23T03:27:39.123Z."""
    return datetime.now(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")
