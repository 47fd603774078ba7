"""Claims of the paper, our results, and the verdicts that follow from both."""

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any


class Verdict(StrEnum):
    """Verdict on a claim."""

    REPRODUCED = "reproduced"
    CONSISTENT = "consistent"
    BY_CONSTRUCTION = "by construction"
    DIFFERS = "differs"
    NOT_REPRODUCIBLE = "not reproducible"
    OURS = "ours to explain"


class Basis(StrEnum):
    """Basis of our result, which limits the meaning of an agreement; see paper.toml."""

    OTHER_NUMBERS = "other numbers"
    OWN_WORDS = "own words"
    ITSELF = "itself"
    OUR_ASSUMPTIONS = "our assumptions"
    NOTHING = "nothing"


VERDICTS: Mapping[Basis, tuple[Verdict, Verdict]] = MappingProxyType(
    {
        Basis.OTHER_NUMBERS: (Verdict.REPRODUCED, Verdict.DIFFERS),
        Basis.OWN_WORDS: (Verdict.CONSISTENT, Verdict.DIFFERS),
        Basis.ITSELF: (Verdict.BY_CONSTRUCTION, Verdict.OURS),
        Basis.OUR_ASSUMPTIONS: (Verdict.CONSISTENT, Verdict.OURS),
        Basis.NOTHING: (Verdict.NOT_REPRODUCIBLE, Verdict.NOT_REPRODUCIBLE),
    }
)
"""{basis: (verdict if a claim agrees, verdict if it does not)}."""


@dataclass(frozen=True, kw_only=True)
class PrintedClaim:
    """A claim as in paper.toml, with the value that the paper prints, in `unit`."""

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
    """One row of the report: printed value `paper` and computed value `ours`, both in `unit`."""

    claim: str
    section: str
    paper: float | str | None
    ours: float | str | None
    unit: str
    verdict: Verdict
    because: str
    why: str
    again: str
    """Key of the claim that this one repeats; empty if this claim is counted."""

    def row(self) -> dict[str, float | str | None]:
        """Return the row for results.json."""
        return asdict(self) | {"verdict": str(self.verdict)}


@cache
def load_paper() -> Mapping[str, Any]:
    """Return the tables of paper.toml: `part` is a list, and `claim` is keyed by claim."""
    text = (files("layerjam.studies.choi2018") / "paper.toml").read_text(encoding="utf-8")
    return MappingProxyType(tomllib.loads(text))


def claim(
    key: str,
    our_value: float | str | None = None,
    *,
    holds: bool | None = None,
    instead: Mapping[str, Any] | None = None,
    **words: Any,
) -> Claim:
    """Return a judged claim of paper.toml, given its key and our value, or whether it `holds`.

    `words` fill the placeholders in the claim's sentences; `instead` replaces entries of the file.
    """
    return judge_claim(
        PrintedClaim(**(load_paper()["claim"][key] | (instead or {}))), our_value, holds, **words
    )


def judge_claim(
    row: PrintedClaim, our_value: float | str | None = None, holds: bool | None = None, **words: Any
) -> Claim:
    """Return a claim with its verdict, based on a number, on a statement, or on neither.

    A number agrees if it is within the tolerance, by default half a unit of the last digit. The
    basis of our result limits the meaning of an agreement. Raises ValueError if the claim requires
    a comparison but there is nothing to compare, or vice versa.
    """
    paper_value = row.paper
    reason = row.why.format(**words)
    otherwise = row.otherwise.format(**words)
    basis, agrees = Basis(row.against), holds
    if holds is not None:
        paper_value, our_value = "as stated", row.ours.format(**words)
    elif (
        row.tolerance is not None
        and isinstance(our_value, float)
        and isinstance(paper_value, float)
    ):
        agrees = abs(our_value - paper_value) <= row.tolerance
        if not agrees:
            difference = (
                f"{(our_value - paper_value) / paper_value:+.1%} relative to the paper"
                if paper_value
                else ""
            )
            reason = "; ".join(word for word in (difference, reason, otherwise) if word)
    if (agrees is None) is not (basis is Basis.NOTHING):
        raise ValueError(f"{row.claim}: cannot be judged against {basis}")
    return Claim(
        claim=row.claim.format(**words),
        section=row.section,
        paper=paper_value,
        ours=our_value,
        unit=row.unit,
        verdict=VERDICTS[basis][0 if agrees else 1],
        because=row.because,
        why=reason,
        again=load_paper()["claim"][row.again]["claim"] if row.again else "",
    )


def count_verdicts(claims: Iterable[Claim]) -> dict[Verdict, int]:
    """Return the number of claims with each verdict, except claims that repeat others."""
    verdicts = [claim.verdict for claim in claims if not claim.again]
    return {verdict: verdicts.count(verdict) for verdict in Verdict}
