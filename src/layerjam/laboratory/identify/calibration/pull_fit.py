"""Result of a calibration on one pull."""

from dataclasses import dataclass

from layerjam.laboratory.identify.pull.features import PullFeatures


@dataclass(frozen=True, kw_only=True)
class PullFit:
    """Result of one pull, without a stiffness if its rise has too few samples."""

    scale_factor: float
    scale_factor_se: float
    stiffness: float | None
    scale_factor_eq8: float
    stiffness_eq9: float | None
    vacuum: float
    pull: PullFeatures
    growth: float = 1.0
    """Ratio of friction at the pull's speed to friction at the scale factor's, by the speed law."""
