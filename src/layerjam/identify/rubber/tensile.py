"""The enclosure's silicone from a tensile test after ASTM D412: moduli of the first loading.

The "100 % modulus" of D412 and of data sheets is the engineering stress at 100 % elongation. It is
what `enclosure.modulus` holds: stress over strain there, and the strain is 1.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from layerjam.errors import FileError, FitError
from layerjam.measure.log import TIME, Log, read_log
from layerjam.measure.options import SKIP, ReadingOptions
from layerjam.measure.readers.columns import Want
from layerjam.measure.readers.unit_words import convert
from layerjam.measure.readers.words import plain
from layerjam.measure.trace import Array
from layerjam.units import show

WINDOW = (0.05, 0.20)
"""Strain over which the initial modulus is the slope of a straight line."""
_TRUE = r"\btrue\b|wahre|\bvraie?\b"
_STRAIN, _STRESS = r"\bstrain\b|dehnung\b|\bdeformation\b", r"\bstress\b|spannung\b|\bcontrainte\b"
_NOT_TRUE = r"^(?!.*true)"
_WANTED = (
    Want("strain", "1", _STRAIN, ("%", "1"), avoid=_TRUE),
    Want("stress", "Pa", _STRESS, ("MPa", "psi"), avoid=_TRUE),
    Want("true_strain", "1", rf"({_TRUE}).*({_STRAIN})", ("%", "1"), avoid=_NOT_TRUE),
    Want("true_stress", "Pa", rf"({_TRUE}).*({_STRESS})", ("MPa",), avoid=_NOT_TRUE),
    Want("force", "N", r"\b(force|load)\b|kraft\b", ("N",)),
    Want("elongation", "m", r"\b(extension|displacement|crosshead)\b|weg\b", ("mm",)),
    TIME,
)
WANTS = tuple(replace(want, optional=True) for want in _WANTED)


@dataclass(frozen=True, kw_only=True)
class Specimen:
    """The first loading of one specimen: engineering strain [-], rising, and stress [Pa], (N,).

    `head` holds what the file says above its table, `understood` how its columns were taken.
    """

    path: str
    strain: Array
    stress: Array
    head: Mapping[str, tuple[str, ...]]
    understood: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    """Whether a program wrote the file."""

    @property
    def name(self) -> str:
        """The file's name without its folder."""
        return Path(self.path).name


@dataclass(frozen=True, kw_only=True)
class Moduli:
    """Of one specimen; stresses in Pa. None: the record does not reach it.

    `initial` is the slope over `window`, `initial_se` its standard error from the residuals;
    `modulus_100`, `modulus_300` the engineering stress at that strain in percent.
    """

    initial: float | None
    initial_se: float | None
    window: tuple[float, float]
    modulus_100: float | None
    modulus_100_se: float | None
    modulus_300: float | None
    strength: float
    strain_at_end: float
    warnings: tuple[str, ...] = ()


def read_rubber(
    path: str | Path,
    *,
    area: float | None = None,
    gauge_length: float | None = None,
    options: ReadingOptions | None = None,
) -> Specimen:
    """The first loading in a file of stress and strain, or of force and elongation.

    `area` [m^2] and `gauge_length` [m] make stress and strain of force and elongation; where they
    are not given the file's head may say them. Raises FileError where neither pair of columns is
    there, or where a strain without unit could be percent.
    """
    named = options.entries({w.role: w.si for w in WANTS}) if options else {}
    log = read_log(path, [w for w in WANTS if not named or w.role in named], options)
    notes: list[str] = []
    if "strain" in log and "stress" in log:
        strain, stress = log["strain"], log["stress"]
        _know_strain(log)
        if area is not None:
            notes.append(f"{log.name}: it holds stress, so the area given is not used")
    elif "true_strain" in log and "true_stress" in log:
        strain = np.expm1(log["true_strain"])
        stress = log["true_stress"] / (1 + strain)
        _know_strain(log)
        notes.append(f"{log.name}: engineering values from true ones, volume taken as constant")
    elif "force" in log and ("elongation" in log or "strain" in log):
        stress = log["force"] / _stated(log, "m^2", area)
        if "strain" in log:
            strain = log["strain"]
            _know_strain(log)
        else:
            strain = log["elongation"] / _stated(log, "m", gauge_length)
    else:
        raise FileError(
            log.path,
            "holds neither stress and strain nor force and elongation in units that are known; "
            f"say what its columns are, as in --columns strain:%,stress:MPa ({SKIP}: not used)",
        )
    if "time" in log and (np.diff(log["time"]) <= 0).any():
        notes.append(f"{log.name}: its time does not rise throughout; it is not used")
    start, end, said = first_loading(strain, stress)
    rising = np.concatenate(
        [[True], strain[start + 1 : end] > np.maximum.accumulate(strain[start:end])[:-1]]
    )
    kept = np.flatnonzero(rising) + start
    if len(kept) < 20 or stress[kept].max() <= 0:
        why = f"its first loading has {len(kept)} samples, 20 are needed"
        if len(kept) >= 20:
            why = "its stress is nowhere above zero: is tension counted negative?"
        raise FileError(log.path, why)
    return Specimen(
        path=log.path,
        strain=strain[kept],
        stress=stress[kept],
        head=log.head,
        understood=(*log.understood, *said),
        warnings=(*log.said, *notes),
        synthetic=log.synthetic,
    )


def _know_strain(log: Log) -> None:
    """A strain without unit is a number, not percent, only where the file itself shows it.

    Either true strain stands beside it and is ln(1 + strain), or the user says so.
    """
    role = "strain" if "strain" in log else "true_strain"
    column = log.taken[role]
    if column.unit:
        return
    if "strain" in log and "true_strain" in log:
        off = np.abs(np.log1p(np.maximum(log["strain"], -0.99)) - log["true_strain"])
        if float(off.max()) <= 1e-3 * max(float(log["true_strain"].max()), 1e-3):
            return
    raise FileError(
        log.path,
        f"column '{column.name[:40]}' does not say whether it is a number or percent; write "
        f"--columns '{role}:1={column.name[:40]},...' or {role}:%, and the stress likewise",
    )


_SIZES = {
    "m^2": (r"cross.?section|\barea\b|querschnitt", "forces", "cross-section (--area)"),
    "m": (r"gau?ge length|specimen length|\blength\b", "elongations", "length (--gauge-length)"),
}
"""Sizes of a specimen: words for it in a file's head, what it divides, what the user calls it."""


def _stated(log: Log, si: str, given: float | None) -> float:
    """A size of the specimen, given or in a line of the head such as 'Specimen Length (mm);33'."""
    words, holds, called = _SIZES[si]
    if given:
        return given
    for key, rest in log.head.items():
        match = re.fullmatch(r"(.*?)\s*[(\[](.+)[)\]]", key)
        if match and re.search(words, match[1]) and (unit := convert(match[2], si)):
            with contextlib.suppress(ValueError):
                return float(rest[0].replace(",", ".")) * float(unit[0])
    raise FileError(log.path, f"holds {holds}; give the specimen's {called}")


def first_loading(strain: Array, stress: Array) -> tuple[int, int, list[str]]:
    """(first, end, what was left out): up to the first turn of strain, or to the break.

    A turn: strain falls by more than 2 % of the range below what it had reached. A break: stress
    falls to less than half of its peak within the loading and does not come back.
    """
    reach = np.maximum.accumulate(strain)
    span = float(strain.max() - strain[0])
    back = np.flatnonzero(reach - strain > 0.02 * span)
    end, said = len(strain), []
    if back.size:
        end = int(np.argmax(strain[: back[0]])) + 1
        said.append(
            f"only the first loading is used, to {strain[end - 1]:.3g} of strain; "
            f"{len(strain) - end} later samples are cycles or unloading"
        )
    top = int(np.argmax(stress[:end]))
    low = np.flatnonzero(stress[top:end] < 0.5 * stress[top])
    if low.size and stress[top] > 0 and (stress[top + low[0] : end] < 0.5 * stress[top]).all():
        end = top + 1
        said.append(f"it breaks at {strain[top]:.3g} of strain; later samples are not used")
    return 0, end, said


def moduli(specimen: Specimen, window: tuple[float, float] = WINDOW) -> Moduli:
    """Moduli of a first loading; raises FitError for an empty window."""
    low, high = window
    if not 0 <= low < high:
        raise FitError(f"initial modulus: the window from {low:.3g} to {high:.3g} is empty")
    x, y = specimen.strain, specimen.stress
    warnings = []
    inside = (x >= low) & (x <= high)
    slope = slope_se = None
    if inside.sum() >= 4:
        (line, base), cov = np.polyfit(x[inside], y[inside], 1, cov=True)
        slope, slope_se = float(line), float(np.sqrt(cov[0, 0]))
        if base < -0.02 * slope:
            warnings.append(
                f"{specimen.name}: the line from {low:.0%} to {high:.0%} meets zero stress "
                f"at {-base / slope:.1%} of strain: slack, or a load cell that was not zeroed"
            )
    else:
        warnings.append(
            f"{specimen.name}: {int(inside.sum())} samples lie between {low:.0%} and {high:.0%} of "
            "strain, 4 are needed for the initial modulus"
        )
    at_100, se_100 = _stress_at(x, y, 1.0)
    if at_100 is None:
        warnings.append(f"{specimen.name}: ends at {x[-1]:.0%} of strain, before 100 %")
    if y[0] < 0:
        warnings.append(
            f"{specimen.name}: its stress begins at {show(float(y[0]), 'Pa')}, below zero; no "
            "offset is taken off"
        )
    return Moduli(
        initial=slope,
        initial_se=slope_se,
        window=window,
        modulus_100=at_100,
        modulus_100_se=se_100,
        modulus_300=_stress_at(x, y, 3.0)[0],
        strength=float(y.max()),
        strain_at_end=float(x[-1]),
        warnings=tuple(warnings),
    )


def _stress_at(x: Array, y: Array, strain: float) -> tuple[float | None, float | None]:
    """Stress at a strain and its standard error: a parabola over ±10 % of that strain."""
    if not x[0] <= strain <= x[-1]:
        return None, None
    near = np.abs(x - strain) <= 0.1 * strain
    if near.sum() < 6:
        return float(np.interp(strain, x, y)), None
    fitted, cov = np.polyfit(x[near] - strain, y[near], 2, cov=True)
    return float(fitted[-1]), float(np.sqrt(cov[-1, -1]))


def material_of(specimen: Specimen, names: Mapping[str, str]) -> tuple[str, str] | None:
    """(catalogue key, by what) of the silicone a file names; None where nothing decides.

    `names` maps the catalogue's keys to the makers' names. Looked at: links and words of the
    file's head, then the file's name. The longest name that fits counts, and fits once only.
    """
    head = [text for rest in specimen.head.values() for text in rest]
    places = [("the file's head", t) for t in head] + [("the file's name", specimen.name)]
    for place, text in places:
        squeezed = re.sub(r"[^a-z0-9]+", "", plain(re.sub(r"\.csv$", "", text)))
        fits = []
        for key, name in names.items():
            for form in (key, name):
                short = re.sub(r"[^a-z0-9]+", "", plain(form))
                if re.search(rf"{short}(?!\d)", squeezed):
                    fits.append((len(short), key))
        if fits:
            return max(fits)[1], place
    return None
