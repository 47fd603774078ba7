"""The uncertainty budget of the scale factor: the repeats, and what all pulls share."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import NamedTuple

from layerjam.device.brake import Brake
from layerjam.mechanics.pull import scale_factor_of_peak
from layerjam.records.source import Source
from layerjam.units import get, show

STEP = 1e-4
COVERAGE = 2.0
"""Expanded over standard uncertainty (GUM, 6.3.3: about 95 %)."""
GEOMETRY = {"sheets.width": "width of the sheets", "sheets.overlap": "overlap at rest"}


class Peak(NamedTuple):
    """One pull's peak force [N] and vacuum [Pa]."""

    force: float
    vacuum: float


@dataclass(frozen=True, kw_only=True)
class Contribution:
    """One line of a budget.

    `standard` is the standard uncertainty of the input, over its value; `sensitivity` by how many
    times as much the scale factor changes; None where nobody stated it. `basis` says what was
    stated.
    """

    what: str
    basis: str
    standard: float | None
    sensitivity: float

    @property
    def relative(self) -> float | None:
        """What it adds to the standard uncertainty of the scale factor, over its value."""
        return None if self.standard is None else abs(self.sensitivity) * self.standard


@dataclass(frozen=True, kw_only=True)
class Budget:
    """The contributions, and what those that were stated make together, over the scale factor."""

    contributions: tuple[Contribution, ...]

    @property
    def combined(self) -> float:
        """Standard uncertainty: the root of the sum of squares (GUM, 5.1.2)."""
        return sqrt(sum((c.relative or 0.0) ** 2 for c in self.contributions))

    @property
    def expanded(self) -> float:
        """Twice the standard uncertainty."""
        return COVERAGE * self.combined

    @property
    def whole(self) -> bool:
        """Whether every contribution was stated."""
        return all(c.standard is not None for c in self.contributions)


def budget(
    peaks: Sequence[Peak],
    brake: Brake,
    repeats: float | None,
    limits: Mapping[str, float | None],
    sources: Mapping[str, Source],
) -> Budget:
    """The budget of the scale factor that `peaks` of `brake` gave.

    `repeats` is its standard error over the pulls, over its value; None for one pull. `limits`
    holds the limits of error of "load_cell" (over the reading) and "gauge" [Pa], taken as
    rectangular (GUM, 4.3.7); both act on all pulls alike. `sources` are those of the brake's
    geometry, whose `sd` counts. The friction that the brake states has no line: only its product
    with the factor is measured, and it stands in every force as that product.
    """
    of_force = _mean(_change(p, brake, Peak(p.force * (1 + STEP), p.vacuum)) for p in peaks)
    of_vacuum = _mean(_change(p, brake, Peak(p.force, p.vacuum * (1 + STEP))) for p in peaks)
    cell, gauge = limits.get("load_cell"), limits.get("gauge")
    over = _mean(1 / p.vacuum for p in peaks)
    lines = [
        Contribution(
            what="repeats",
            basis="standard error over the pulls" if repeats is not None else "one pull",
            standard=repeats,
            sensitivity=1.0,
        ),
        Contribution(
            what="load cell",
            basis="not stated" if cell is None else f"limit of error {cell:.2g} of the reading",
            standard=None if cell is None else cell / sqrt(3),
            sensitivity=of_force,
        ),
        Contribution(
            what="vacuum gauge",
            basis="not stated" if gauge is None else f"limit of error {show(gauge, 'Pa')}",
            standard=None if gauge is None else gauge * over / sqrt(3),
            sensitivity=of_vacuum,
        ),
        *_geometry(peaks, brake, sources),
    ]
    return Budget(contributions=tuple(lines))


def _geometry(
    peaks: Sequence[Peak], brake: Brake, sources: Mapping[str, Source]
) -> Iterator[Contribution]:
    """What the brake's lengths add, as its file states how well they are known."""
    for path, words in GEOMETRY.items():
        name = path.partition(".")[2]
        longer = replace(
            brake, sheets=replace(brake.sheets, **{name: get(brake, path) * (1 + STEP)})
        )
        sd = sources[path].sd if path in sources else None
        yield Contribution(
            what=words,
            basis="not stated" if sd is None else f"SD {sd:.2g} of it, from the brake's file",
            standard=sd,
            sensitivity=_mean(_change(p, longer, p, brake) for p in peaks),
        )


def _change(at: Peak, brake: Brake, other: Peak, before: Brake | None = None) -> float:
    """Relative change of the factor, per relative change of an input."""
    factor = float(scale_factor_of_peak(at.force, at.vacuum, before or brake))
    return (float(scale_factor_of_peak(other.force, other.vacuum, brake)) / factor - 1) / STEP


def _mean(values: Iterable[float]) -> float:
    every = list(values)
    return sum(every) / len(every)
