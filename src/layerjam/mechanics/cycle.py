"""Response of a brake to an elongation history, for any law of its enclosure."""

from typing import Any, NamedTuple


class Cycle(NamedTuple):
    """Response to an elongation history; every field has the history's shape (N,)."""

    force: Any
    """[N], never negative."""
    slip: Any
    """[m]"""
    sleeve_force: Any
    """[N]"""
    work: Any
    """External work done on the brake so far [J]."""
    heat: Any
    """Energy dissipated so far [J], summed on its own."""
    stored: Any
    """Elastic energy held now in enclosure, sheets and mount [J]."""
    slack: Any
    """True where the crosshead has come closer than the brake is long."""
    closed: Any
    """True once the enclosure has pulled the brake back by itself."""
    separated: Any
    """True once the overlap is used up; nothing after that point counts."""
    overflow: Any
    """True once the enclosure's memory of turning points was exceeded."""
    snapped: Any
    """True once the brake began to slide on a spring softer than `least_stiffness`."""
