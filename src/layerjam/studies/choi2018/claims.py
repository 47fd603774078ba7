"""A claim of the paper, what we find, and the verdict, which is computed and never typed in."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any


class Verdict(StrEnum):
    """What became of a claim."""

    REPRODUCED = "reproduced"
    DIFFERS = "differs"
    NOT_REPRODUCIBLE = "not reproducible"
    NOT_YET = "not yet"


@dataclass(frozen=True, kw_only=True)
class Printed:
    """A claim as paper.toml has it, with what the paper prints in `unit`; see there."""

    claim: str
    section: str
    paper: float | str | None = None
    unit: str = ""
    tolerance: float | None = None
    ours: str = ""
    why: str = ""
    otherwise: str = ""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One row of the report: `paper` is what is printed, `ours` what was computed, in `unit`."""

    claim: str
    section: str
    paper: float | str | None
    ours: float | str | None
    unit: str
    verdict: Verdict
    why: str

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

    A number is reproduced within its tolerance, half of the last digit printed unless said
    otherwise.
    """
    printed, why, otherwise = row.paper, row.why.format(**words), row.otherwise.format(**words)
    verdict = Verdict.NOT_REPRODUCIBLE
    if holds is not None:
        verdict = Verdict.REPRODUCED if holds else Verdict.DIFFERS
        printed, ours = "as stated", row.ours.format(**words)
    elif row.tolerance is not None and isinstance(ours, float) and isinstance(printed, float):
        verdict = Verdict.REPRODUCED
        if abs(ours - printed) > row.tolerance:
            verdict = Verdict.DIFFERS
            off = f"{(ours - printed) / printed:+.1%} against the paper" if printed else ""
            why = "; ".join(word for word in (off, why, otherwise) if word)
    return Claim(
        claim=row.claim.format(**words),
        section=row.section,
        paper=printed,
        ours=ours,
        unit=row.unit,
        verdict=verdict,
        why=why,
    )
