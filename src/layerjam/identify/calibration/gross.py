"""Pulls that no plausible scatter explains: a wrong unit, a different brake, a wrong vacuum."""

from collections.abc import Mapping, Sequence

from layerjam.device.brake import Brake
from layerjam.errors import FitError
from layerjam.identify.calibration.peaks import fit_pull
from layerjam.identify.odd import find_gross_outliers
from layerjam.identify.pull.features import PullFeatures

CONVERSIONS: Mapping[str, Mapping[str, float]] = {
    "scale factor": {
        "its force were in kN but read as N": 1e-3,
        "its force were in N but read as kN": 1e3,
        "its force were in lbf but read as N": 1 / 4.4482216,
        "its force were in N but read as lbf": 4.4482216,
        "its force were in gram-force but read as N": 1000 / 9.80665,
        "its force were in kgf but read as N": 1 / 9.80665,
        "its force were in N but read as kgf": 9.80665,
    },
    "stiffness": {
        "its elongation were in inches but read as mm": 25.4,
        "its elongation were in mm but read as inches": 1 / 25.4,
        "its elongation were in mm but read as cm": 0.1,
        "its elongation were in cm but read as mm": 10.0,
        "its elongation were in mm but read as m": 1e-3,
    },
}
"""{likely cause: factor by which it changes the quantity}."""
CLOSE_RATIO = 1.25
"""Largest ratio to a conversion factor at which that conversion counts as the likely cause."""


def find_gross_pulls(pulls: Sequence[tuple[PullFeatures, float]], brake: Brake) -> dict[int, str]:
    """Return {index: reason} of pulls to leave out, each pull given with its vacuum [Pa].

    The scale factor of the peak and the stiffness of the rise are compared with the median over the
    pulls (`find_gross_outliers`).
    """
    factors: list[float | None] = []
    for pull, vacuum in pulls:
        try:
            factors.append(fit_pull(pull, vacuum, brake).scale_factor)
        except FitError:
            factors.append(None)
    springs = [pull.stiffness if pull.straight else None for pull, _ in pulls]
    reasons: dict[int, list[str]] = {}
    for quantity, values in {"scale factor": factors, "stiffness": springs}.items():
        for index, ratio in find_gross_outliers(values).items():
            reasons.setdefault(index, []).append(
                f"its {quantity} is {ratio:.3g} times the median of the pulls"
                + _describe_likely_cause(quantity, ratio)
            )
    return {index: "; ".join(sentences) for index, sentences in sorted(reasons.items())}


def _describe_likely_cause(quantity: str, ratio: float) -> str:
    for cause, factor in CONVERSIONS[quantity].items():
        if 1 / CLOSE_RATIO < ratio / factor < CLOSE_RATIO:
            return f", as if {cause}"
    return ""
