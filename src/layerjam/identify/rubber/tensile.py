"""Moduli of the enclosure's silicone from the first loading of a tensile test (ASTM D412).

The "100 % modulus" of D412 and of data sheets is the engineering stress at 100 % elongation. It
equals `enclosure.modulus`, stress divided by strain, because the strain is 1.
"""

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
from layerjam.measure.readers.unit_words import convert_unit
from layerjam.measure.readers.words import normalise_name
from layerjam.measure.trace import Array
from layerjam.units import show

WINDOW = (0.05, 0.20)
"""Range of strain in which a straight line is fitted; its slope is the initial modulus."""
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
    """First loading of one specimen: ascending engineering strain [-] and stress [Pa], (N,).

    `head` is the text above the file's table, `understood` the interpretation of the columns.
    """

    path: str
    strain: Array
    stress: Array
    head: Mapping[str, tuple[str, ...]]
    understood: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    """Whether a program generated the file."""

    @property
    def name(self) -> str:
        """File name without its folder."""
        return Path(self.path).name


@dataclass(frozen=True, kw_only=True)
class Moduli:
    """Moduli of one specimen [Pa], None if the record ends earlier.

    `initial` is the slope over `window`, `initial_se` its standard error from the residuals;
    `modulus_100` and `modulus_300` are the engineering stresses at those strains in percent.
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
    """Read the first loading from a file of stress and strain, or of force and elongation.

    `area` [m^2] and `gauge_length` [m] convert force and elongation; the file's header may also
    state them. Raises FitError or FileError if neither pair of columns exists, or if a strain
    without a unit could be in percent.
    """
    entries = options.entries({w.role: w.si for w in WANTS}) if options else {}
    log = read_log(path, [w for w in WANTS if not entries or w.role in entries], options)
    notes: list[str] = []
    if "strain" in log and "stress" in log:
        strain, stress = log["strain"], log["stress"]
        _require_strain_unit(log)
        if area is not None:
            notes.append(f"{log.name}: it contains stress, so the given area is not used")
    elif "true_strain" in log and "true_stress" in log:
        strain = np.expm1(log["true_strain"])
        stress = log["true_stress"] / (1 + strain)
        _require_strain_unit(log)
        notes.append(
            f"{log.name}: engineering values computed from true ones, assuming constant volume"
        )
    elif "force" in log and ("elongation" in log or "strain" in log):
        stress = log["force"] / _find_dimension(log, "m^2", area)
        if "strain" in log:
            strain = log["strain"]
            _require_strain_unit(log)
        else:
            strain = log["elongation"] / _find_dimension(log, "m", gauge_length)
    else:
        raise FileError(
            log.path,
            "contains neither stress and strain nor force and elongation in known units; "
            f"state its columns, as in --columns strain:%,stress:MPa ({SKIP}: not used)",
        )
    if "time" in log and (np.diff(log["time"]) <= 0).any():
        notes.append(f"{log.name}: its time does not always increase; it is not used")
    start, end, notes_of_loading = first_loading(strain, stress)
    rising = np.concatenate(
        [[True], strain[start + 1 : end] > np.maximum.accumulate(strain[start:end])[:-1]]
    )
    rows = np.flatnonzero(rising) + start
    if len(rows) < 20 or stress[rows].max() <= 0:
        reason = f"its first loading has {len(rows)} samples; 20 are needed"
        if len(rows) >= 20:
            reason = "its stress is never above zero: check whether tension is counted as negative"
        raise FileError(log.path, reason)
    return Specimen(
        path=log.path,
        strain=strain[rows],
        stress=stress[rows],
        head=log.head,
        understood=(*log.understood, *notes_of_loading),
        warnings=(*log.notices, *notes),
        synthetic=log.synthetic,
    )


def _require_strain_unit(log: Log) -> None:
    """Raise FileError unless the file or the user states the unit of strain.

    A column of true strain identifies the unit, if that column equals ln(1 + strain).
    """
    role = "strain" if "strain" in log else "true_strain"
    column = log.taken[role]
    if column.unit:
        return
    if "strain" in log and "true_strain" in log:
        gaps = np.abs(np.log1p(np.maximum(log["strain"], -0.99)) - log["true_strain"])
        if float(gaps.max()) <= 1e-3 * max(float(log["true_strain"].max()), 1e-3):
            return
    raise FileError(
        log.path,
        f"column '{column.name[:40]}' does not show whether it is a ratio or in percent; write "
        f"--columns '{role}:1={column.name[:40]},...' or {role}:%, and the stress likewise",
    )


_SIZES = {
    "m^2": (r"cross.?section|\barea\b|querschnitt", "forces", "cross-section (--area)"),
    "m": (r"gau?ge length|specimen length|\blength\b", "elongations", "length (--gauge-length)"),
}
"""Dimensions of a specimen: pattern in a file's header, quantity to convert, option."""


def _find_dimension(log: Log, si: str, size: float | None) -> float:
    """Return a dimension of the specimen, given or in the header: 'Specimen Length (mm);33'."""
    words, holds, option = _SIZES[si]
    if size:
        return size
    for key, values in log.head.items():
        match = re.fullmatch(r"(.*?)\s*[(\[](.+)[)\]]", key)
        if match and re.search(words, match[1]) and (unit := convert_unit(match[2], si)):
            with contextlib.suppress(ValueError):
                return float(values[0].replace(",", ".")) * float(unit[0])
    raise FileError(log.path, f"contains {holds}; state the specimen's {option}")


def first_loading(strain: Array, stress: Array) -> tuple[int, int, list[str]]:
    """Return (first, end, notes) of the loading, up to the first strain reversal or the break.

    At a reversal, the strain drops by more than 2 % of its range below its maximum so far. At a
    break, the stress drops below half of its peak within the loading and does not recover.
    """
    reach = np.maximum.accumulate(strain)
    span = float(strain.max() - strain[0])
    turns = np.flatnonzero(reach - strain > 0.02 * span)
    end, notes = len(strain), []
    if turns.size:
        end = int(np.argmax(strain[: turns[0]])) + 1
        notes.append(
            f"only the first loading is used, up to a strain of {strain[end - 1]:.3g}; "
            f"{len(strain) - end} later samples are cycles or unloading"
        )
    top = int(np.argmax(stress[:end]))
    low = np.flatnonzero(stress[top:end] < 0.5 * stress[top])
    if low.size and stress[top] > 0 and (stress[top + low[0] : end] < 0.5 * stress[top]).all():
        end = top + 1
        notes.append(f"it breaks at a strain of {strain[top]:.3g}; later samples are not used")
    return 0, end, notes


def specimen_moduli(specimen: Specimen, window: tuple[float, float] = WINDOW) -> Moduli:
    """Return the moduli of a first loading; raises FitError for an empty window."""
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
                f"{specimen.name}: the line from {low:.0%} to {high:.0%} crosses zero stress "
                f"at a strain of {-base / slope:.1%}: slack, or a load cell that was not zeroed"
            )
    else:
        warnings.append(
            f"{specimen.name}: {int(inside.sum())} samples lie between strains of {low:.0%} and "
            f"{high:.0%}; the initial modulus needs 4"
        )
    at_100, se_100 = _estimate_stress(x, y, 1.0)
    if at_100 is None:
        warnings.append(f"{specimen.name}: ends at a strain of {x[-1]:.0%}, before 100 %")
    if y[0] < 0:
        warnings.append(
            f"{specimen.name}: its stress starts at {show(float(y[0]), 'Pa')}, below "
            "zero; no offset is subtracted"
        )
    return Moduli(
        initial=slope,
        initial_se=slope_se,
        window=window,
        modulus_100=at_100,
        modulus_100_se=se_100,
        modulus_300=_estimate_stress(x, y, 3.0)[0],
        strength=float(y.max()),
        strain_at_end=float(x[-1]),
        warnings=tuple(warnings),
    )


def _estimate_stress(x: Array, y: Array, strain: float) -> tuple[float | None, float | None]:
    """Return the stress at a strain, and its standard error, by a parabola over ±10 % of it."""
    if not x[0] <= strain <= x[-1]:
        return None, None
    inside = np.abs(x - strain) <= 0.1 * strain
    if inside.sum() < 6:
        return float(np.interp(strain, x, y)), None
    parabola, cov = np.polyfit(x[inside] - strain, y[inside], 2, cov=True)
    return float(parabola[-1]), float(np.sqrt(cov[-1, -1]))


def find_material(specimen: Specimen, names: Mapping[str, str]) -> tuple[str, str] | None:
    """Return (catalogue key, source) of the silicone that a file names; None if none is found.

    `names` maps the catalogue's keys to the makers' names. Links and words in the file's header
    have priority over the file name. The longest matching name is used.
    """
    head = [text for values in specimen.head.values() for text in values]
    places = [("the file's header", t) for t in head] + [("the file name", specimen.name)]
    for place, text in places:
        letters = re.sub(r"[^a-z0-9]+", "", normalise_name(re.sub(r"\.csv$", "", text)))
        fits = []
        for key, name in names.items():
            for form in (key, name):
                short = re.sub(r"[^a-z0-9]+", "", normalise_name(form))
                if re.search(rf"{short}(?!\d)", letters):
                    fits.append((len(short), key))
        if fits:
            return max(fits)[1], place
    return None
