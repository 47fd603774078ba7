"""Pulls that a calibration leaves out, because no plausible scatter explains them."""

from collections.abc import Sequence

from layerjam.brake.device.brake import Brake
from layerjam.core.errors import FitError
from layerjam.laboratory.identify.calibration.peaks import fit_pull
from layerjam.laboratory.identify.populations import find_exclusions
from layerjam.laboratory.identify.pull.features import PullFeatures


def find_gross_pulls(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> dict[int, str]:
    """Return {index: reason} of pulls to leave out, each pull given with its vacuum [Pa].

    The scale factor of the peak and the stiffness of the rise are compared with the median over the
    pulls; see `find_exclusions`.
    """
    factors: list[float | None] = []
    for pull, vacuum in pulls:
        try:
            factors.append(fit_pull(pull, vacuum, brake).scale_factor)
        except FitError:
            factors.append(None)
    springs = [pull.stiffness if pull.straight else None for pull, _ in pulls]
    return find_exclusions(factors, springs)
