"""Checks of silicone specimens: against each other, the data sheet and plausible moduli."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from layerjam.core.units import show
from layerjam.core.verdict import Check, Level, check, interval_check
from layerjam.laboratory.identify.fit_checks import check_span
from layerjam.laboratory.identify.friction.agreement import check_repeats
from layerjam.laboratory.identify.load_cell import check_drift, check_resolution, check_zero
from layerjam.laboratory.identify.statistics import summarise_repeats

SILICONES = (5e3, 2e7)
"""Range of the 100 % modulus [Pa] of silicones of Shore 000 to Shore A 80, widened twofold."""
LIKELY, POSSIBLE = 1.5, 3.0
"""Ratios to the maker's data sheet above which the check warns and fails, respectively."""
MEETS = 0.15
"""Largest error of the fitted model at 100 % strain that passes."""


def check_specimens(
    rows: Mapping[str, Mapping[str, Any]], totals: Mapping[str, Any], writes_model: bool
) -> Iterator[Check]:
    """Yield the checks of specimens, {path: row}, and of the values `pooled` over them, SI.

    `pooled` is empty if there are several materials. `writes_model` states whether the fitted model
    is written to a brake file.
    """
    for path, row in rows.items():
        if (modulus := row["modulus_100"]) is not None:
            name = Path(path).name
            if not SILICONES[0] <= modulus <= SILICONES[1]:
                start = f"the 100 % modulus of {name}, {show(modulus, 'Pa')}, is not typical of a"
                low, high = (show(edge, "Pa") for edge in SILICONES)
                advice = f" silicone, {low} to {high}: check its unit, area and gauge length"
                yield Check(name="silicone", level="failed", sentence=start + advice)
            if row["difference"] is not None:
                yield _check_data_sheet(name, 1 + row["difference"], row["material"])
    yield from _check_load_cell(rows)
    if not totals:
        return
    names = [Path(path).name for path in rows]
    moduli = {
        words: [row[key] for row in rows.values()]
        for words, key in {
            "100 % modulus": "modulus_100",
            "initial modulus": "initial_modulus",
        }.items()
    }
    yield check_repeats(
        names, moduli, "rubber specimens normally vary", "check unit, area and gauge length"
    )
    values = moduli["100 % modulus"]
    if len(values) > 1 and None not in values:
        mean = summarise_repeats(values)
        if mean.low is not None and mean.high is not None:
            yield interval_check("100 % modulus", mean.mean, mean.low, mean.high)
    if (error := totals.get("error_at_100")) is not None:
        level: Level = "failed" if writes_model else "warning"
        label = "model error at 100 % strain"
        yield check_span(
            "model", error, (-MEETS, MEETS), label, ("fit a smaller range (--fit-to)"), level
        )


def _check_load_cell(rows: Mapping[str, Mapping[str, Any]]) -> Iterator[Check]:
    """Yield the checks of zero, drift and resolution on all 100 % moduli above zero."""
    rows_to_100 = {
        Path(p).name: row for p, row in rows.items() if row["resolution_effect"] is not None
    }
    zeros = {
        name: (show(row["zero"], "Pa"), row["zero_effect"])
        for name, row in rows_to_100.items()
        if row["zero_effect"] is not None
    }
    result = "the 100 % modulus"
    if rows_to_100:
        yield check_zero(zeros, result, quantity="stress")
        steps = max(row["resolution"] for row in rows_to_100.values())
        effects = {result: max(row["resolution_effect"] for row in rows_to_100.values())}
        yield check_resolution(effects, show(steps, "Pa", 3))
    drifts = {n: d for n, row in rows_to_100.items() if (d := row["drift_effect"]) is not None}
    if drifts:
        worst = max(drifts, key=lambda name: abs(drifts[name]))
        yield check_drift(worst, drifts[worst], result, "a zero that drifts")


def _check_data_sheet(name: str, ratio: float, material: str) -> Check:
    """Return the check of the ratio of a specimen's modulus to that in the maker's data sheet."""
    sentence = (
        f"the 100 % modulus of {name} is {ratio:.3g} times that of the data sheet of {material}"
    )
    level: Level = "warning" if 1 / POSSIBLE <= ratio <= POSSIBLE else "failed"
    advice = ": check its unit, area, gauge length and material"
    return check("data sheet", 1 / LIKELY <= ratio <= LIKELY, sentence, advice, level)
