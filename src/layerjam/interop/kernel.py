"""The C kernel, under the name by which other programs import it."""

from layerjam.brake.kernel.kernel import (
    CLOSED,
    OVERFLOW,
    REFUSED,
    SEPARATED,
    SLACK,
    SNAPPED,
    Kernel,
)

__all__ = ["CLOSED", "OVERFLOW", "REFUSED", "SEPARATED", "SLACK", "SNAPPED", "Kernel"]
