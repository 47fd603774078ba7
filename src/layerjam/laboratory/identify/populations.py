"""Pulls that no plausible scatter explains, and pulls that form two groups.

One deviating pull may have a wrong unit, or be one of another brake. If many deviate, the pulls do
not show which of them are right, and the majority need not be.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from layerjam.core.errors import count_text
from layerjam.core.units import show
from layerjam.laboratory.identify.curves import number_levels
from layerjam.laboratory.identify.fit_checks import Check, check
from layerjam.laboratory.identify.odd import find_gross_outliers, find_two_groups, outlier_limit
from layerjam.laboratory.identify.single_pulls import SinglePull

FACTOR, STIFFNESS = "scale factor", "stiffness"
CONVERSIONS: Mapping[str, Mapping[str, float]] = {
    FACTOR: {
        "its force were in kN but read as N": 1e-3,
        "its force were in N but read as kN": 1e3,
        "its force were in lbf but read as N": 1 / 4.4482216,
        "its force were in N but read as lbf": 4.4482216,
        "its force were in gram-force but read as N": 1000 / 9.80665,
        "its force were in kgf but read as N": 1 / 9.80665,
        "its force were in N but read as kgf": 9.80665,
    },
    STIFFNESS: {
        "its elongation were in inches but read as mm": 25.4,
        "its elongation were in mm but read as inches": 1 / 25.4,
        "its elongation were in mm but read as cm": 0.1,
        "its elongation were in cm but read as mm": 10.0,
        "its elongation were in mm but read as m": 1e-3,
    },
}
"""{quantity: {likely cause: factor by which it changes the quantity}}."""
CLOSE_RATIO = 1.25
"""Largest ratio to a conversion factor at which that conversion counts as the likely cause."""
ALARMS = 0.005
"""Fraction of faultless campaigns whose scale factors (or stiffnesses) may divide into groups."""
LEAST, LEAST_MOUNTED = 0.1, 0.15
"""Relative difference of two groups' means up to which they count as one population.

The second is that of groups that are, or may be, two mountings. At a scatter of 5 % (SD) between
mountings, two differ by more in one of thirty campaigns.
"""
LONE = ": correct its unit, or leave the file out (--exclude)"
GROUPS = (
    ": correct the unit, lever arm or vacuum of the wrong group, or leave it out (--exclude). "
    "The pulls do not show which group is right, so both were used"
)
Values = Sequence[float | None]


def describe_gross_outliers(factors: Values, stiffnesses: Values) -> dict[int, str]:
    """Return {index: reason} of pulls whose scale factor or stiffness no scatter explains."""
    reasons: dict[int, list[str]] = {}
    for quantity, values in {FACTOR: factors, STIFFNESS: stiffnesses}.items():
        for index, ratio in find_gross_outliers(values).items():
            reasons.setdefault(index, []).append(
                f"its {quantity} is {ratio:.3g} times the median of the pulls"
                + _describe_likely_cause(quantity, ratio)
            )
    return {index: "; ".join(sentences) for index, sentences in sorted(reasons.items())}


def find_exclusions(factors: Values, stiffnesses: Values) -> dict[int, str]:
    """Return {index: reason} of the pulls to leave out without a decision.

    None is left out if more pulls deviate than `outlier_limit` allows, or if the others form two
    groups.
    """
    reasons = describe_gross_outliers(factors, stiffnesses)
    others = ([v for i, v in enumerate(q) if i not in reasons] for q in (factors, stiffnesses))
    if len(reasons) > outlier_limit(len(factors)) or any(map(_split_values, others)):
        return {}
    return reasons


def _split_values(values: Values) -> tuple[int, ...]:
    """Return the indices of the smaller of two groups; none if there are no groups."""
    indices = [index for index, value in enumerate(values) if value is not None]
    logs = np.log([value for value in values if value is not None])
    places = find_two_groups(logs, ALARMS, float(np.log1p(LEAST)))
    return tuple(indices[place] for place in places or ())


def _describe_likely_cause(quantity: str, ratio: float) -> str:
    for cause, factor in CONVERSIONS[quantity].items():
        if 1 / CLOSE_RATIO < ratio / factor < CLOSE_RATIO:
            return f", as if {cause}"
    return ""


def check_population(rows: Sequence[SinglePull]) -> Check:
    """Check that the pulls are of one population: no outlier beyond scatter, and no two groups.

    Groups that differ in a stated vacuum, speed or mounting are not two populations, unless no
    scatter explains them.
    """
    if len(rows) < 2:
        return check("pulls", True, "one pull only: it cannot be compared with others")
    factors = [None if r.vacuum_of_peak is None else r.vacuum_of_peak / r.vacuum for r in rows]
    stiffnesses = [row.stiffness for row in rows]
    lone = find_exclusions(factors, stiffnesses)
    if lone:
        sentences = [f"{rows[index].file}: {reason}" for index, reason in lone.items()]
        return check("pulls", False, "; ".join(sentences), LONE, "failed")
    groups = {
        quantity: _find_group(rows, values)
        for quantity, values in ((FACTOR, factors), (STIFFNESS, stiffnesses))
    }
    sentences = [_describe_groups(rows, q, group) for q, group in groups.items() if group]
    ok_sentence = (
        f"none of the {len(rows)} pulls differs from the others by more than plausible scatter"
    )
    return check("pulls", not sentences, "; ".join(sentences) or ok_sentence, GROUPS, "failed")


def _find_group(rows: Sequence[SinglePull], values: Values) -> tuple[int, ...]:
    """Return the indices of the pulls that differ from the others as a group; none if none do."""
    group, gross = _split_values(values), tuple(find_gross_outliers(values))
    others = {i for i, value in enumerate(values) if value is not None} - set(group)
    if any(_separates_levels(levels, group, others) for levels in _list_conditions(rows)):
        return gross
    if group:
        means = [np.mean([np.log(values[i] or 1.0) for i in part]) for part in (group, others)]
        is_small = abs(means[0] - means[1]) <= np.log1p(LEAST_MOUNTED)
        if is_small and any(
            _separates_levels(levels, group, others) for levels in _list_pairs(rows)
        ):
            return gross
    return group or gross


def _separates_levels(levels: Sequence[int], group: Iterable[int], others: Iterable[int]) -> bool:
    """Return whether no level occurs in both groups."""
    return not {levels[i] for i in group} & {levels[i] for i in others}


def _list_pairs(rows: Sequence[SinglePull]) -> Iterator[Sequence[int]]:
    """Yield pairs of mountings: as stated, or two batches in the order given, or the repeats."""
    mountings = [row.mounting for row in rows if row.mounting is not None]
    if len(mountings) == len(rows):
        yield from [mountings] * (len(set(mountings)) == 2)
        return
    count = len(rows)
    for first in range(2, count - 1):
        yield [int(place >= first) for place in range(count)]
    counts: dict[int, int] = {}
    repeats = []
    for level in number_levels([row.vacuum for row in rows]):
        counts[level] = counts.get(level, 0) + 1
        repeats.append(counts[level])
    yield repeats


def _list_conditions(rows: Sequence[SinglePull]) -> Iterator[Sequence[int]]:
    """Yield the level of each pull in vacuum, speed and mounting, as far as all pulls state it.

    Mountings of fewer than two pulls on average explain nothing, and two mountings alone only a
    small difference; see `_list_pairs`.
    """
    for name in ("vacuum", "speed"):
        values = [v for row in rows if (v := getattr(row, name)) is not None]
        if len(values) == len(rows):
            yield number_levels(values)
    mountings = [row.mounting for row in rows if row.mounting is not None]
    if len(mountings) == len(rows) and 2 < len(set(mountings)) <= len(rows) / 2:
        yield mountings


def _describe_groups(rows: Sequence[SinglePull], quantity: str, group: Sequence[int]) -> str:
    name, unit = ("factor", "1") if quantity == FACTOR else ("stiffness", "N/m")

    def describe(indices: Sequence[int]) -> str:
        values = [v for i in indices if (v := getattr(rows[i], name)) is not None]
        span = " to ".join(show(v, unit, 3) for v in sorted({min(values), max(values)}))
        files = ", ".join(rows[i].file for i in indices)
        return f"{count_text(len(indices), 'pull')} with {span} ({files})"

    others = [i for i, r in enumerate(rows) if i not in group and getattr(r, name) is not None]
    noun = "scale factors" if quantity == FACTOR else "stiffnesses"
    return f"the {noun} form two groups: {describe(others)} and {describe(group)}"
