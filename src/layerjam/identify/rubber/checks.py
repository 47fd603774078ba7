"""Checks of silicone specimens: against each other, the data sheet, and what rubber can be."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from layerjam.identify.checks import within
from layerjam.identify.friction.agreement import agreement
from layerjam.identify.repeats import over_repeats
from layerjam.units import show
from layerjam.verdict import Check, Level, check, interval_check

SILICONES = (5e3, 2e7)
"""100 % modulus [Pa] of silicone rubbers, from a gel of Shore 000 to Shore A 80, widened by two."""
LIKELY, POSSIBLE = 1.5, 3.0
"""Ratio to the maker's data sheet that deserves a look, and that no rubber of that name has."""
MEETS = 0.15
"""Error of the fitted model at 100 % strain that is let pass."""


def specimen_checks(
    rows: Mapping[str, Mapping[str, Any]], pooled: Mapping[str, Any], writes_model: bool
) -> Iterator[Check]:
    """Return the checks of specimens, {path: row}, and of the values `pooled` over them, SI.

    `pooled` is empty if the files are of several materials. `writes_model` says whether the fitted
    model goes into a brake's file.
    """
    for path, row in rows.items():
        if (modulus := row["modulus_100"]) is not None:
            name = Path(path).name
            if not SILICONES[0] <= modulus <= SILICONES[1]:
                what = f"the 100 % modulus of {name}, {show(modulus, 'Pa')}, is not that of a"
                low, high = (show(edge, "Pa") for edge in SILICONES)
                advice = f" silicone, {low} to {high}: check its unit, area and gauge length"
                yield Check(name="silicone", level="failed", sentence=what + advice)
            if row["difference"] is not None:
                yield _data_sheet(name, 1 + row["difference"], row["material"])
    if not pooled:
        return
    names = [Path(path).name for path in rows]
    moduli = {
        words: [row[key] for row in rows.values()]
        for words, key in {
            "100 % modulus": "modulus_100",
            "initial modulus": "initial_modulus",
        }.items()
    }
    yield agreement(names, moduli, "rubber scatters", "check its unit, area and gauge length")
    known = moduli["100 % modulus"]
    if len(known) > 1 and None not in known:
        over = over_repeats(known)
        if over.low is not None and over.high is not None:
            yield interval_check("100 % modulus", over.mean, over.low, over.high)
    if (error := pooled.get("error_at_100")) is not None:
        level: Level = "failed" if writes_model else "warning"
        what = "error of the model at 100 % strain"
        yield within("model", error, (-MEETS, MEETS), what, "fit less of it (--fit-to)", level)


def _data_sheet(name: str, ratio: float, material: str) -> Check:
    """Return the check of one specimen's modulus over that of the maker's data sheet."""
    sentence = f"the 100 % modulus of {name} is {ratio:.3g} times the data sheet's of {material}"
    level: Level = "warning" if 1 / POSSIBLE <= ratio <= POSSIBLE else "failed"
    advice = ": check its unit, area, gauge length and material"
    return check("data sheet", 1 / LIKELY <= ratio <= LIKELY, sentence, advice, level)
