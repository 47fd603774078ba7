"""A claim of the paper, what we find, and the verdict, which is computed and never typed in."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any


class Verdict(StrEnum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    CONSISTENT = "consistent"
    BY_CONSTRUCTION = "by construction"
    DIFFERS = "differs"
    NOT_REPRODUCIBLE = "not reproducible"
    OURS = "ours to explain"


class Against(StrEnum):
    """What ours rests on, and so what agreement with the paper can mean; see paper.toml."""

    OTHER_NUMBERS = "other numbers"
    OWN_WORDS = "own words"
    ITSELF = "itself"
    OUR_ASSUMPTIONS = "our assumptions"
    NOTHING = "nothing"


VERDICTS: Mapping[Against, tuple[Verdict, Verdict]] = MappingProxyType(
    {
        Against.OTHER_NUMBERS: (Verdict.REPRODUCED, Verdict.DIFFERS),
        Against.OWN_WORDS: (Verdict.CONSISTENT, Verdict.DIFFERS),
        Against.ITSELF: (Verdict.BY_CONSTRUCTION, Verdict.OURS),
        Against.OUR_ASSUMPTIONS: (Verdict.CONSISTENT, Verdict.OURS),
        Against.NOTHING: (Verdict.NOT_REPRODUCIBLE, Verdict.NOT_REPRODUCIBLE),
    }
)
"""The verdict on a claim that agrees, and on one that does not."""


@dataclass(frozen=True, kw_only=True)
class Printed:
    """A claim as paper.toml has it, with what the paper prints in `unit`; see there."""

    claim: str
    section: str
    against: str
    because: str
    paper: float | str | None = None
    unit: str = ""
    tolerance: float | None = None
    ours: str = ""
    why: str = ""
    otherwise: str = ""
    again: str = ""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One row of the report: `paper` is what is printed, `ours` what was computed, in `unit`."""

    claim: str
    section: str
    paper: float | str | None
    ours: float | str | None
    unit: str
    verdict: Verdict
    because: str
    why: str
    again: str
    """The claim that it looks at once more; empty for one that counts."""

    def row(self) -> dict[str, float | str | None]:
        """The row of results.json."""
        return asdict(self) | {"verdict": str(self.verdict)}


@cache
def paper() -> Mapping[str, Any]:
    """The tables of paper.toml: `part` a list, `claim` by key."""
    text = (files("layerjam.studies.choi2018") / "paper.toml").read_text(encoding="utf-8")
    return MappingProxyType(tomllib.loads(text))


def claim(
    key: str,
    ours: float | str | None = None,
    *,
    holds: bool | None = None,
    instead: Mapping[str, Any] | None = None,
    **words: Any,
) -> Claim:
    """A claim of paper.toml by its key, with our number, or whether it `holds`.

    `words` are what its sentences have in braces; `instead` replaces entries of the file.
    """
    return judged(Printed(**(paper()["claim"][key] | (instead or {}))), ours, holds, **words)


def judged(
    row: Printed, ours: float | str | None = None, holds: bool | None = None, **words: Any
) -> Claim:
    """What becomes of a claim: a number against a computed one, a statement, or neither.

    A number agrees within its tolerance, half of the last digit printed unless said otherwise. What
    agreement is worth follows from what ours rests on. Raises ValueError where there is nothing to
    compare and the claim does not say so, or the other way round.
    """
    printed, why, otherwise = row.paper, row.why.format(**words), row.otherwise.format(**words)
    against, agrees = Against(row.against), holds
    if holds is not None:
        printed, ours = "as stated", row.ours.format(**words)
    elif row.tolerance is not None and isinstance(ours, float) and isinstance(printed, float):
        agrees = abs(ours - printed) <= row.tolerance
        if not agrees:
            off = f"{(ours - printed) / printed:+.1%} against the paper" if printed else ""
            why = "; ".join(word for word in (off, why, otherwise) if word)
    if (agrees is None) is not (against is Against.NOTHING):
        raise ValueError(f"{row.claim}: cannot be judged against {against}")
    return Claim(
        claim=row.claim.format(**words),
        section=row.section,
        paper=printed,
        ours=ours,
        unit=row.unit,
        verdict=VERDICTS[against][0 if agrees else 1],
        because=row.because,
        why=why,
        again=paper()["claim"][row.again]["claim"] if row.again else "",
    )


def tally(claims: Iterable[Claim]) -> dict[Verdict, int]:
    """How many claims have each verdict; those that look at another once more are in no count."""
    counted = [claim.verdict for claim in claims if not claim.again]
    return {verdict: counted.count(verdict) for verdict in Verdict}
