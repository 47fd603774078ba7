"""Checks of the options of `drop` that exclude or need each other."""

from typing import Any

from layerjam.core.command.log_options import LogOptions
from layerjam.core.errors import QuantityError


def check_options(
    vacuum: Any,
    travel: Any,
    history: Any,
    log: LogOptions,
    no_brake: bool,
    duration: float | None,
) -> None:
    """Check that exactly one vacuum, history or travel is given; none without a brake."""
    if no_brake:
        if history is not None or duration is not None:
            raise QuantityError("vacuum and duration: not valid without a brake")
        if vacuum is not None or travel is not None:
            raise QuantityError("vacuum and travel: not valid without a brake")
        return
    if history is None and log != LogOptions():
        raise QuantityError(
            "reading, columns and decimal: only valid with a file of a vacuum history"
        )
    if history is not None:
        if vacuum is not None or travel is not None:
            raise QuantityError.of("vacuum", "a history is given; omit vacuum and travel")
    elif vacuum is None:
        raise QuantityError.of("vacuum", "missing; give one, or 'tuned' together with travel")
    elif vacuum == "tuned" and travel is None:
        raise QuantityError.of("travel", "missing; a tuned vacuum requires the slip of the stop")
    elif vacuum != "tuned" and travel is not None:
        raise QuantityError.of("travel", "only valid with a tuned vacuum")


def check_leak(values: tuple[Any, Any, Any], history: Any, no_brake: bool) -> None:
    """Check that vacuum share, leak time and `held` are given only with a brake and one vacuum."""
    values_by_name = dict(zip(("vacuum share", "leak time", "held"), values, strict=True))
    for name, value in values_by_name.items():
        if value is not None and no_brake:
            raise QuantityError(f"{name}: only valid with a brake")
    if values_by_name["leak time"] is None:
        if values_by_name["held"] is not None:
            raise QuantityError("held: only valid with a leak; give its leak time too")
    elif history is not None:
        raise QuantityError("leak time: not valid with a history, which already includes the leak")


def check_damping(damping: float | None, rope_stiffness: float | None) -> float:
    """Return the damping of the rope, or 0; raises QuantityError if there is no rope."""
    if damping is not None and rope_stiffness is None:
        raise QuantityError("rope damping: there is no rope; give its stiffness too")
    return damping or 0.0
