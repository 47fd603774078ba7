"""What one pull alone says of the brake."""

from __future__ import annotations

from dataclasses import dataclass

from layerjam.identify.pull.features import PullFeatures


@dataclass(frozen=True, kw_only=True)
class PullFit:
    """What one pull says; no stiffness where its rise has too few samples to tell it."""

    scale_factor: float
    scale_factor_se: float
    stiffness: float | None
    scale_factor_eq8: float
    stiffness_eq9: float | None
    vacuum: float
    pull: PullFeatures
    growth: float = 1.0
    """Friction at the pull's speed over that of the scale factor, where a speed law tells it."""
