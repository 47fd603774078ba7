"""Checks of all pulls of a campaign, from the rows of its single pulls."""

from collections.abc import Sequence

import numpy as np

from layerjam.laboratory.identify.fit_checks import (
    Check,
    check,
    check_no_trend,
    check_scatter,
    check_shape,
    format_percent,
)
from layerjam.laboratory.identify.odd import FEWEST
from layerjam.laboratory.identify.order import check_order
from layerjam.laboratory.identify.populations import check_population
from layerjam.laboratory.identify.single_pulls import ALARMS, LEAST, SinglePull, is_seat_soft

SOFT = 0.08
"""Largest scatter of stiffnesses (SD, relative) that counts as agreement."""


def check_single_pulls(
    rows: Sequence[SinglePull], half_width: float | None = None, end: Check | None = None
) -> tuple[Check, ...]:
    """Return the checks of outliers, and of the shapes, rises and slopes of all pulls.

    `half_width` is the relative half-width of the scale factor's 95 % interval, and `end` the check
    at the end of the curves, as in `checks.check_shape`.
    """
    outliers = [f"{row.file}: {row.sentence}" for row in rows if row.is_outlier]
    ok_sentence = f"none of the {len(rows)} pulls differs from the others"
    if len(rows) < 3:
        ok_sentence = "too few pulls to identify one that differs: three are needed"
    shapes = [row.shape for row in rows if row.shape is not None]
    alarms, least_effect = ALARMS["shape of all"], LEAST["shape"]
    checks: list[Check | None] = [
        check_shape(shapes, half_width, alarms=alarms, least=least_effect, end=end),
        check("pull by pull", not outliers, "; ".join(outliers) if outliers else ok_sentence),
        check_population(rows),
        *check_order(rows),
        _check_rises(rows),
    ]
    springs = [(r.stiffness, r.vacuum) for r in rows if r.stiffness is not None]
    if len(springs) > 1:
        values = np.array([k for k, _ in springs])
        spread = float(values.std(ddof=1) / values.mean())
        used = f"{len(values)} pulls"
        checks.append(check_scatter(spread, 0.0, used, "stiffness repeats", "stiffnesses", SOFT))
        vacuums = [vacuum for _, vacuum in springs]
        checks.append(check_no_trend(values.tolist(), vacuums, "vacuum", "Pa", "stiffness"))
    return tuple(c for c in checks if c is not None)


def _check_rises(rows: Sequence[SinglePull]) -> Check | None:
    """Check that the rises of all pulls are straight; a seat that yields would bend them."""
    bends = [float(np.log1p(row.seating)) for row in rows if row.seating is not None]
    if not bends:
        return None
    has_soft_seat = is_seat_soft(bends) or (
        len(rows) < FEWEST and any(r.verdicts["seating"] == "odd" for r in rows)
    )
    change = format_percent(float(np.mean(bends)))
    sentence = f"the upper half of the rises is {change} steeper than the lower"
    cause = ": something yields as the load rises, such as a grip or a cap in its seat"
    return check(
        "seating",
        not has_soft_seat,
        sentence,
        f"{cause}; the stiffness is not that of the brake alone",
    )
