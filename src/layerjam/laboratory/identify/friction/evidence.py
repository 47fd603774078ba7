"""Evidence of friction tests for a brake's file: uncertainty, scatter and tested range."""

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.evidence import Evidence, Part, as_tuples, state_fitted
from layerjam.brake.device.spread import REPEAT_SD
from layerjam.core.toml_files.source import Source
from layerjam.laboratory.identify.statistics import OverRepeats

Changes = Mapping[str, tuple[Any, Source] | None]


def make_friction_evidence(
    file: BrakeFile,
    means: Mapping[str, OverRepeats],
    speeds: Sequence[float],
    changes: Changes,
    date: str | None = None,
) -> Evidence:
    """Return the evidence of friction tests of a film, whose repeats scatter independently.

    `means` are those of static and kinetic friction over the repeats, `speeds` [m/s] the known
    speeds, `changes` the values written into the file. Repeats with the same reading show no
    scatter; theirs is assumed, like that of one repeat.
    """
    names = tuple(name for name in ("static", "kinetic") if name in means)
    repeats = min(means[name].repeats for name in names)
    has_sds = all(means[name].sd is not None for name in names)
    sds = np.array([(means[n].sd or 0.0) / means[n].mean or REPEAT_SD[n] for n in names])
    scatter = np.diag(np.log1p(sds**2))
    errors = [
        (means[n].standard_error or 0.0) / means[n].mean or REPEAT_SD[n] / math.sqrt(repeats)
        for n in names
    ]
    covariance = np.diag(np.square(errors)) if has_sds else scatter
    degrees = float(repeats - 1) if has_sds else math.inf
    return Evidence(
        command="friction",
        date=date or datetime.now(UTC).date().isoformat(),
        tests=repeats,
        names=tuple(f"film.{name}" for name in names),
        parts=(
            Part("mean", as_tuples(covariance), degrees),
            Part("test", as_tuples(scatter), degrees),
        ),
        ranges={"speed": (min(speeds), max(speeds))} if speeds else {},
        fitted=state_fitted("friction", file.known_values, changes),
    )
