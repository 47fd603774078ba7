"""Evidence of tensile tests of an enclosure's silicone, for the file of a brake."""

import math
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.enclosure import SILICONE_FRICTION
from layerjam.brake.device.evidence import Evidence, Part, state_fitted


def make_enclosure_evidence(
    file: BrakeFile,
    values: Mapping[str, Any],
    strain: float,
    changes: Mapping[str, tuple[Any, object] | None],
    date: str | None = None,
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
        date=date or datetime.now(UTC).date().isoformat(),
        tests=count,
        names=("enclosure_force",),
        parts=(
            Part("mean", ((modulus / 4,),), float(count - 1)),
            Part("mean", ((friction / 4,),)),
        ),
        ranges={"strain": (0.0, strain)},
        fitted=state_fitted("enclosure", file.known_values, changes),
    )
