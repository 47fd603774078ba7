"""Response of a brake to an elongation history, for any law of its enclosure."""

from typing import Any, NamedTuple

from layerjam.brake.device.brake import Brake


class Cycle(NamedTuple):
    """Response to an elongation history; every field has the history's shape (N,)."""

    force: Any
    """Force [N], never negative."""
    slip: Any
    """Slip [m]."""
    sleeve_force: Any
    """Force of the enclosure [N]."""
    work: Any
    """External work done on the brake so far [J]."""
    heat: Any
    """Energy dissipated so far [J], integrated separately."""
    stored: Any
    """Elastic energy in enclosure, sheets and mount [J]."""
    slack: Any
    """True if the brake is slack: longer than the distance to the crosshead."""
    closed: Any
    """True once the enclosure has pulled the brake back."""
    separated: Any
    """True once the overlap is used up; later values are not valid."""
    overflow: Any
    """True once the turning points exceed the enclosure's memory."""
    snapped: Any
    """True once the brake has begun to slide on a spring softer than `least_stiffness`."""


class Setting(NamedTuple):
    """Constants of a move at one vacuum."""

    c: Any
    k: Any
    overlap: Any
    enclosure: Any
    """Law of the enclosure at that vacuum."""
    shapes: tuple[Any, ...] = ()
    """Effects of the slip on the friction, as in `Sheets`."""
    paced_brake: Brake | None = None
    """The brake if its friction depends on the sliding speed; `c` is that at the test speed."""
