"""Envelope of friction repeats with stick–slip."""

from collections.abc import Sequence
from dataclasses import dataclass

from layerjam.laboratory.identify.stick_slip import SawTeeth


@dataclass(frozen=True, kw_only=True)
class StickSlip:
    """Envelope of the repeats with stick–slip, as friction coefficients [-].

    `period` [s] is None if a record has no time; `spacing` [m] is in terms of travel.
    """

    upper: float
    lower: float
    amplitude: float
    middle: float
    relative_amplitude: float
    period: float | None
    spacing: float
    files: tuple[str, ...]
    accepted: bool
    reason: str


def find_envelope(
    records: Sequence[tuple[str, SawTeeth]], normal_force: float, accepted: bool
) -> StickSlip | None:
    """Return the envelope of (file, teeth) pairs, if any; `normal_force` is in N."""
    if not records:
        return None
    files, teeth = zip(*records, strict=True)

    def mean(name: str) -> float:
        return sum(getattr(t, name) for t in teeth) / len(teeth)

    upper, lower = (mean(name) / normal_force for name in ("upper", "lower"))
    kinetic = ": kinetic friction is the middle of its envelope"
    if not accepted:
        kinetic = ", so kinetic friction is not reported"
    return StickSlip(
        upper=upper,
        lower=lower,
        amplitude=(upper - lower) / 2,
        middle=(upper + lower) / 2,
        relative_amplitude=(upper - lower) / (upper + lower),
        period=None if None in (t.period for t in teeth) else mean("period"),
        spacing=mean("spacing"),
        files=files,
        accepted=accepted,
        reason=f"stick–slip has no plain mean{kinetic}",
    )
