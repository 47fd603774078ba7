"""Measured pulls as a fit over many of them sees them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from layerjam.identify.pull import PullFeatures


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """The loading branch of one pull, SI units; its crosshead's zero is where the rise begins.

    `speed` is None where neither the file nor its sidecar tells it. `repeat` numbers the pull among
    those at the same vacuum and speed; `pull` holds the features it was reduced to.
    """

    elongation: np.ndarray
    force: np.ndarray
    vacuum: float
    speed: float | None
    repeat: int | None
    path: str
    pull: PullFeatures
