"""Result of one friction test."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from layerjam.laboratory.identify.friction.breakaway import Inertia
from layerjam.laboratory.identify.friction.outward import SledRecord
from layerjam.laboratory.identify.stick_slip import SawTeeth


@dataclass(frozen=True, kw_only=True)
class FrictionRepeat:
    """One repeat: coefficients [-], travel at the maximum force [m], and source.

    `kinetic` is None if the record shows stick–slip, unless the middle of the envelope was
    accepted. `mean` is the ratio of mean force to normal force over the travel `window` [m].
    `teeth` is the stick–slip there (forces in N), `ripple` that of the machine. `distinct` means
    that a standard's first maximum is clear, `synthetic` that a program generated the file.
    `record` is the test without its curve (see `SledRecord`). `limits` are the largest errors that
    the resolution causes in `static` and `kinetic`. `drift` is that of the force up to the window
    [N]: from the slope there, and from the levels before and after the test if they are known.
    """

    static: float
    kinetic: float | None
    mean: float
    static_at: float
    samples: int
    path: str
    window: tuple[float, float]
    speed: float | None = None
    distinct: bool = True
    teeth: SawTeeth | None = None
    ripple: SawTeeth | None = None
    inertia: Inertia | None = None
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    record: SledRecord = field(repr=False, compare=False)
    sliding_from: float
    limits: Mapping[str, float]
    drift: tuple[float, float | None]
