"""Evidence of tests of film and silicone for a brake's file: uncertainty, scatter, tested range."""

import math
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

import numpy as np

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.enclosure import SILICONE_FRICTION
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
        date=datetime.now(UTC).date().isoformat(),
        tests=repeats,
        names=tuple(f"film.{name}" for name in names),
        parts=(
            Part("mean", as_tuples(covariance), degrees),
            Part("test", as_tuples(scatter), degrees),
        ),
        ranges={"speed": (min(speeds), max(speeds))} if speeds else {},
        fitted=state_fitted("friction", file.known_values, changes),
    )


def make_enclosure_evidence(
    file: BrakeFile,
    values: Mapping[str, Any],
    strain: float,
    changes: Changes,
) -> Evidence | None:
    """Return the evidence of specimens, None for one specimen, which shows no scatter.

    `values` are those of `pool`, `strain` is the largest one of all specimens, `changes` are the
    values written into the file. The enclosure's force is proportional to the square root of
    modulus times friction; its friction was not tested.
    """
    sd, count = values.get("modulus_100_sd"), values["specimens"]
    if not sd:
        return None
    modulus = math.log1p((sd / values["modulus_100"]) ** 2) / count
    friction = math.log(SILICONE_FRICTION) ** 2
    return Evidence(
        command="enclosure",
        date=datetime.now(UTC).date().isoformat(),
        tests=count,
        names=("enclosure_force",),
        parts=(
            Part("mean", ((modulus / 4,),), float(count - 1)),
            Part("mean", ((friction / 4,),)),
        ),
        ranges={"strain": (0.0, strain)},
        fitted=state_fitted("enclosure", file.known_values, changes),
    )
