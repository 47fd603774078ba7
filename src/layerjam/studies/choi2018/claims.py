"""A claim of the paper, what we find, and the verdict, which is computed and never typed in."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Verdict(StrEnum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    DIFFERS = "differs"
    NOT_REPRODUCIBLE = "not reproducible"
    NOT_YET = "not yet"


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One row of the report.

    `paper` is what the paper prints and `ours` what was computed in this run, both in `unit`
    (numbers, or words where the claim has none); `tolerance` is half of the last digit printed,
    unless said otherwise.
    """

    claim: str
    section: str
    paper: float | str | None
    ours: float | str | None
    unit: str
    verdict: Verdict
    why: str

    def row(self) -> dict[str, float | str | None]:
        """The row of results.json."""
        return {
            "claim": self.claim,
            "section": self.section,
            "paper": self.paper,
            "ours": self.ours,
            "unit": self.unit,
            "verdict": str(self.verdict),
            "why": self.why,
        }


def number(
    claim: str,
    section: str,
    paper: float,
    ours: float,
    unit: str,
    tolerance: float,
    why: str = "",
    otherwise: str = "",
) -> Claim:
    """A printed number against a computed one: reproduced within `tolerance`, else differs.

    `why` goes with either verdict, `otherwise` only with "differs".
    """
    same = abs(ours - paper) <= tolerance
    off = f"{(ours - paper) / paper:+.1%} against the paper" if paper else ""
    words = [why] if same else [off, why, otherwise]
    return Claim(
        claim=claim,
        section=section,
        paper=paper,
        ours=ours,
        unit=unit,
        verdict=Verdict.REPRODUCED if same else Verdict.DIFFERS,
        why="; ".join(w for w in words if w),
    )


def statement(claim: str, section: str, holds: bool, ours: str, why: str) -> Claim:
    """A claim in words that a computation confirms or not."""
    return Claim(
        claim=claim,
        section=section,
        paper="as stated",
        ours=ours,
        unit="",
        verdict=Verdict.REPRODUCED if holds else Verdict.DIFFERS,
        why=why,
    )


def beyond(
    claim: str, section: str, paper: float | str | None, unit: str, why: str, *,
    ours: float | str | None = None,
) -> Claim:  # fmt: skip
    """A claim that nobody can recompute from what the paper gives."""
    return Claim(
        claim=claim, section=section, paper=paper, ours=ours, unit=unit,
        verdict=Verdict.NOT_REPRODUCIBLE, why=why,
    )  # fmt: skip
