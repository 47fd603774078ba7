"""Moduli of the enclosure's silicone from the first loading of a tensile test (ASTM D412).

The "100 % modulus" of D412 and of data sheets is the engineering stress at 100 % elongation. It
equals `enclosure.modulus`, stress divided by strain, because the strain is 1.
"""

import contextlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from layerjam.core.brief import brief
from layerjam.core.errors import FileError, FitError
from layerjam.core.evolve import evolve
from layerjam.core.system import quote_word
from layerjam.core.units import show
from layerjam.laboratory.identify.load_cell import Zero, find_released_force, find_zero
from layerjam.laboratory.measure.log import TIME, Log, read_log
from layerjam.laboratory.measure.noise import find_quantum, rounding_limit
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.readers.header import Want
from layerjam.laboratory.measure.readers.hints import format_entry, guess_column
from layerjam.laboratory.measure.readers.unit_words import convert_unit
from layerjam.laboratory.measure.readers.words import normalise_name
from layerjam.laboratory.measure.saturation import find_plateau
from layerjam.laboratory.measure.trace import Array

AT_ZERO = 0.01
"""Largest first strain of a record that begins without strain."""
TOE, LONGEST_TOE, FEWEST_TOE = 0.05, 0.20, 8
"""Range of strain that shows the stress without strain; if it has fewer samples than that minimum,
it is extended, but not beyond the second value."""
WINDOW = (0.05, 0.20)
"""Range of strain in which a straight line is fitted; its slope is the initial modulus."""
_TRUE = r"\btrue\b|wahre|\bvraie?\b"
_STRAIN, _STRESS = r"\bstrain\b|dehnung\b|\bdeformation\b", r"\bstress\b|spannung\b|\bcontrainte\b"
_NOT_TRUE = r"^(?!.*true)"
_STRETCH = r"\bstretch\b|\blambda\b|\bλ\b|streckung|\b(extension|elongation) ratio\b"
_WANTED = (
    Want("strain", "1", rf"{_STRAIN}|^ε$|^epsilon$", ("%", "1"), avoid=f"{_TRUE}|{_STRETCH}"),
    Want("stress", "Pa", _STRESS, ("MPa", "psi"), avoid=_TRUE),
    Want("stretch", "1", _STRETCH, ("1", "%"), avoid=_TRUE),
    Want("true_strain", "1", rf"({_TRUE}).*({_STRAIN})", ("%", "1"), avoid=_NOT_TRUE),
    Want("true_stress", "Pa", rf"({_TRUE}).*({_STRESS})", ("MPa",), avoid=_NOT_TRUE),
    Want("force", "N", r"\b(force|load)\b|kraft\b", ("N",)),
    Want("elongation", "m", r"\b(extension|displacement|crosshead)\b|weg\b", ("mm",)),
    TIME,
)
WANTS = tuple(evolve(want, optional=True) for want in _WANTED)
_PAIRS = (
    ("strain", "stress"),
    ("stretch", "stress"),
    ("true_strain", "true_stress"),
    ("strain", "force"),
    ("stretch", "force"),
    ("elongation", "force"),
)
"""Pairs of columns that give strain and stress, best first."""
_AT_ONE = (0.8, 1.3)
"""Range of the first value of a stretch ratio, which a preload may change."""


@brief
@dataclass(frozen=True, kw_only=True)
class Specimen:
    """First loading of one specimen: ascending engineering strain [-] and stress [Pa], (N,).

    `head` is the text above the file's table, `understood` the interpretation of the columns.
    `zero` is the stress without strain [Pa], None if unknown, `end_stress` that after the break,
    and `quantum` the resolution of the stress.
    """

    path: str
    strain: Array
    stress: Array
    head: Mapping[str, tuple[str, ...]]
    understood: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    synthetic: bool = False
    """Whether a program generated the file."""
    zero: Zero | None = None
    end_stress: float | None = None
    quantum: float = 0.0

    @property
    def name(self) -> str:
        """File name without its folder."""
        return Path(self.path).name


@brief
@dataclass(frozen=True, kw_only=True)
class Moduli:
    """Moduli of one specimen [Pa], None if the record ends earlier.

    `initial` is the slope over `window`, `initial_se` its standard error from the residuals;
    `modulus_100` and `modulus_300` are the engineering stresses at those strains in percent. The
    last are the relative changes of `modulus_100` due to the zero, its drift up to the break, and
    the largest due to the resolution; None if unknown.
    """

    initial: float | None
    initial_se: float | None
    window: tuple[float, float]
    modulus_100: float | None
    modulus_100_se: float | None
    modulus_300: float | None
    strength: float
    strain_at_end: float
    zero_effect: float | None
    drift_effect: float | None
    resolution_effect: float | None
    warnings: tuple[str, ...] = ()


def read_rubber(
    path: str | Path,
    *,
    area: float | None = None,
    gauge_length: float | None = None,
    options: ReadingOptions | None = None,
    tare: bool = False,
) -> Specimen:
    """Read the first loading from a file of stress and strain, or of force and elongation.

    `area` [m^2] and `gauge_length` [m] convert force and elongation; the file's header may also
    state them. With `tare`, the stress without strain is subtracted. Raises FitError or FileError
    if no pair of columns exists. It also does so if a strain without a unit could be in percent, or
    if a strain starts at 1 and could be a stretch ratio.
    """
    options = options or ReadingOptions()
    log, (strain_role, load_role) = _read_curve(path, options)
    notes: list[str] = []
    size = _find_dimension(log, "m^2", area) if load_role == "force" else 1.0
    values, load = _read_strain(log, strain_role, gauge_length), log[load_role] / size
    strain = -values if "elongation" in options.negative else values
    stress = -load if "force" in options.negative else load
    if strain_role == "true_strain":
        stress = stress / (1 + strain)
        notes.append(
            f"{log.name}: engineering values computed from true ones, assuming constant volume"
        )
    if load_role != "force" and area is not None:
        notes.append(f"{log.name}: it contains stress, so the given area is not used")
    if "time" in log and (np.diff(log["time"]) <= 0).any():
        notes.append(f"{log.name}: its time does not always increase; it is not used")
    start, end, notes_of_loading = first_loading(strain, stress)
    notes_of_loading += [f"the sign of the {role} was reversed" for role in options.negative]
    rising = np.concatenate(
        [[True], strain[start + 1 : end] > np.maximum.accumulate(strain[start:end])[:-1]]
    )
    rows = np.flatnonzero(rising) + start
    _check_signs(log, strain, stress, options)
    if len(rows) < 20:
        raise FileError(log.path, f"samples of its first loading: {len(rows)}; 20 are needed")
    if (plateau := find_plateau(stress[start:end])) is not None:
        raise FileError(
            log.path,
            f"the load cell was saturated: the stress stays at {show(plateau.level, 'Pa')} over "
            f"{plateau.count} samples while the strain increases",
        )
    quantum = find_quantum(stress)
    zero, end_stress = _find_zeros(strain, stress, rows, end)
    if tare:
        if zero is None:
            raise FileError(log.path, "does not show the stress without strain (tare)")
        notes.append(f"{log.name}: {show(zero.force, 'Pa')} was subtracted from the stress (tare)")
        stress = stress - zero.force
        end_stress = None if end_stress is None else end_stress - zero.force
        zero = evolve(zero, force=0.0)
    return Specimen(
        path=log.path,
        strain=strain[rows],
        stress=stress[rows],
        zero=zero,
        end_stress=end_stress,
        quantum=quantum,
        head=log.head,
        understood=(*log.understood, *notes_of_loading),
        warnings=(*log.notices, *notes),
        synthetic=log.synthetic,
    )


def _find_zeros(
    strain: Array, stress: Array, rows: npt.NDArray[np.intp], end: int
) -> tuple[Zero | None, float | None]:
    """Return the stress without strain, and that after the break [Pa]; None if unknown.

    Without a section before the load, it is where a parabola through the first strains begins.
    """
    level = float(np.max(stress[rows]))
    at_rest = find_zero(stress[: rows[-1] + 1], level)
    x, y = strain[rows], stress[rows]
    first = x <= max(x[0] + TOE, float(x[FEWEST_TOE - 1]))
    if at_rest is None and abs(x[0]) <= AT_ZERO and x[first][-1] <= LONGEST_TOE:
        parabola, cov = np.polyfit(x[first], y[first], 2, cov=True)
        at_rest = Zero(force=float(parabola[-1]), error=float(np.sqrt(cov[-1, -1])))
    broken = len(strain) > end and float(strain[end:].min()) >= float(strain[end - 1])
    return at_rest, find_released_force(stress[end:], level) if broken else None


def _read_curve(path: str | Path, options: ReadingOptions) -> tuple[Log, tuple[str, str]]:
    """Return the columns of a file, and the roles of those that give strain and stress.

    Columns that the user names come first, then stress and strain before force and elongation.
    Raises FileError if no pair of columns is complete.
    """
    given_roles = {
        w.role for w in WANTS if w.role in options.entries({w.role: w.si for w in WANTS})
    }
    in_order = options.by_order is not None
    log = read_log(path, WANTS, options)
    given_roles.discard("time")
    pairs = sorted(_PAIRS, key=lambda pair: len(given_roles - set(pair)))
    complete = next((pair for pair in pairs if all(role in log for role in pair)), None)
    if complete is None or not (given_roles <= set(complete) or in_order):
        nearest = max(pairs, key=lambda pair: _count_columns(log, pair))
        required_columns = [evolve(w, optional=False) for w in _WANTED if w.role in nearest]
        read_log(path, required_columns, options)
        raise FileError(
            log.path,
            f"contains no pair of {' and '.join(sorted(given_roles)) or 'strain and stress'}",
        )
    return log, complete


def _count_columns(log: Log, roles: Sequence[str]) -> int:
    """Return for how many roles a file has a column, or one whose name or symbol suits it."""
    wants = [want for want in _WANTED if want.role in roles]
    roles_read = [want.role for want in wants if want.role in log]
    guesses = [log.header and guess_column(log.header, want, (), False) for want in wants]
    return max(len(roles_read), sum(index is not None for index in guesses))


def _read_strain(log: Log, role: str, gauge_length: float | None) -> Array:
    """Return the engineering strain in the column of a role; raises FileError if it is unclear.

    A strain that starts at 1 may be a stretch ratio, which is 1 + strain.
    """
    values = log[role]
    if role == "elongation":
        return values / _find_dimension(log, "m", gauge_length)
    if role == "true_strain":
        _require_strain_unit(log, role)
        return np.expm1(values)
    column, first = log.taken[role], float(values[0])
    at_one = _AT_ONE[0] <= first <= _AT_ONE[1] and first <= float(values.min()) + 0.1
    if role == "stretch":
        hundreds = 0.01 if not column.unit and not at_one else 1.0
        if at_one or _AT_ONE[0] <= first * hundreds <= _AT_ONE[1]:
            return values * hundreds - 1
    elif column.given or not at_one:
        _require_strain_unit(log, role)
        return values
    unit = column.unit or "1"
    meanings = ("strain",) if role == "stretch" else ("stretch", "strain")
    hints = " or ".join(_name_entry(log, role, meaning, unit) for meaning in meanings)
    raise FileError(
        log.path,
        f"column '{column.name[:40]}' starts at {first:.4g}: state whether it is a stretch ratio, "
        "which starts at 1, or a strain",
        how=f" ({hints})",
        asks="columns",
    )


def _check_signs(log: Log, strain: Array, stress: Array, options: ReadingOptions) -> None:
    """Raise FileError if the curve is one of compression."""
    curves = (("force", "stress", stress), ("elongation", "strain", strain - strain[0]))
    for role, name, values in curves:
        if values.max() > 0.1 * -float(values.min()) and values.max() > 0:
            continue
        if role in options.negative:
            reason, hint = f"with its sign changed, its {name} is never positive", ""
        else:
            reason = f"its {name} is never positive; if it counts tension as negative, state this"
            hint = f" (--negative {role})"
        raise FileError(log.path, reason, how=hint, asks=f"{role}-sign" if hint else "")


def _name_entry(log: Log, role: str, new: str, unit: str) -> str:
    """Return an option that gives the column of a role a new role and unit."""
    return f"--columns {quote_word(format_entry(new, unit, log.name_column(role)))}"


def _require_strain_unit(log: Log, role: str) -> None:
    """Raise FileError unless the file or the user states the unit of strain.

    A column of true strain identifies the unit, if that column equals ln(1 + strain).
    """
    column = log.taken[role]
    if column.unit:
        return
    if "strain" in log and "true_strain" in log:
        gaps = np.abs(np.log1p(np.maximum(log["strain"], -0.99)) - log["true_strain"])
        if float(gaps.max()) <= 1e-3 * max(float(log["true_strain"].max()), 1e-3):
            return
    hints = " or ".join(_name_entry(log, role, role, unit) for unit in ("1", "%"))
    raise FileError(
        log.path,
        f"column '{column.name[:40]}' does not show whether it is a ratio or in percent; state it",
        how=f" ({hints})",
        asks="columns",
    )


_SIZES = {
    "m^2": (
        r"cross.?section|\barea\b|querschnitt",
        "forces",
        "cross-section (--area 18mm^2)",
    ),
    "m": (
        r"gau?ge length|specimen length|\blength\b",
        "elongations",
        "length (--gauge-length 33mm)",
    ),
}
"""Dimensions of a specimen: pattern in a file's header, quantity to convert, option."""


def _find_dimension(log: Log, si: str, size: float | None) -> float:
    """Return a dimension of the specimen, given or in the header: 'Specimen Length (mm);33'."""
    words, quantity, option = _SIZES[si]
    if size:
        return size
    for key, values in log.head.items():
        match = re.fullmatch(r"(.*?)\s*[(\[](.+)[)\]]", key)
        if match and re.search(words, match[1]) and (unit := convert_unit(match[2], si)):
            with contextlib.suppress(ValueError):
                return float(values[0].replace(",", ".")) * float(unit[0])
    raise FileError(log.path, f"contains {quantity}; state the specimen's {option}")


def first_loading(strain: Array, stress: Array) -> tuple[int, int, list[str]]:
    """Return (first, end, notes) of the loading, up to the first strain reversal or the break.

    At a reversal, the strain drops by more than 2 % of its range below its maximum so far. At a
    break, the stress drops below half of its peak within the loading and does not recover.
    """
    max_strain = np.maximum.accumulate(strain)
    span = float(strain.max() - strain[0])
    turns = np.flatnonzero(max_strain - strain > 0.02 * span)
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
    is_inside = (x >= low) & (x <= high)
    slope = slope_se = None
    if is_inside.sum() >= 4:
        (line, base), cov = np.polyfit(x[is_inside], y[is_inside], 1, cov=True)
        slope, slope_se = float(line), float(np.sqrt(cov[0, 0]))
        if base < -0.02 * slope:
            warnings.append(
                f"{specimen.name}: the line from {low:.0%} to {high:.0%} crosses zero stress "
                f"at a strain of {-base / slope:.1%}: slack, or a load cell that was not zeroed"
            )
    else:
        warnings.append(
            f"{specimen.name}: {int(is_inside.sum())} samples lie between strains of {low:.0%} and "
            f"{high:.0%}; the initial modulus needs 4"
        )
    at_100, se_100 = _estimate_stress(x, y, 1.0)
    if at_100 is None:
        warnings.append(f"{specimen.name}: ends at a strain of {x[-1]:.0%}, before 100 %")
    zero, drift, resolution = _load_cell_effects(specimen, at_100)
    return Moduli(
        zero_effect=zero,
        drift_effect=drift,
        resolution_effect=resolution,
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


def _load_cell_effects(
    specimen: Specimen, at_100: float | None
) -> tuple[float | None, float | None, float | None]:
    """Return the relative effects of zero, drift and resolution on a 100 % modulus above zero."""
    zero, end_stress, x = specimen.zero, specimen.end_stress, specimen.strain
    if at_100 is None or at_100 <= 0:
        return None, None, None
    drift = None
    if zero is not None and end_stress is not None:
        drift = (end_stress - zero.force) * float(np.mean(x <= 1.0)) / at_100
    samples = specimen.stress[np.abs(x - 1.0) <= 0.1]
    resolution = rounding_limit(samples, specimen.quantum) / at_100
    return None if zero is None else zero.effect(at_100), drift, resolution


def _estimate_stress(x: Array, y: Array, strain: float) -> tuple[float | None, float | None]:
    """Return the stress at a strain, and its standard error, by a parabola over ±10 % of it."""
    if not x[0] <= strain <= x[-1]:
        return None, None
    is_inside = np.abs(x - strain) <= 0.1 * strain
    if is_inside.sum() < 6:
        return float(np.interp(strain, x, y)), None
    parabola, cov = np.polyfit(x[is_inside] - strain, y[is_inside], 2, cov=True)
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
                compact_name = re.sub(r"[^a-z0-9]+", "", normalise_name(form))
                if re.search(rf"{compact_name}(?!\d)", letters):
                    fits.append((len(compact_name), key))
        if fits:
            return max(fits)[1], place
    return None
