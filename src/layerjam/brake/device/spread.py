"""Uncertainty of the numbers of a brake: from its tests, its sources, or its handbook values.

Each `Unknown` is a set of independent deviations of some numbers, as logarithms. Numbers that the
tests in the file do not show have a stated spread, listed in docs/verdicts.md.
"""

import functools
import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile, materials
from layerjam.brake.device.evidence import Evidence, state_fitted
from layerjam.brake.device.load import catalogue, devices, load
from layerjam.core.evolve import evolve
from layerjam.core.toml_files.source import Source
from layerjam.core.toml_files.toml import parse_toml

Array = npt.NDArray[np.float64]
MARGIN = 2.0
"""Factor by which the catalogue's range of a film's friction is widened at both ends."""
REPEAT_SD: Mapping[str, float] = MappingProxyType({"static": 0.08, "kinetic": 0.03})
"""Relative SD of friction between repeats (Choi 2018, table I), if a source states none."""
MOUNTING_SD = 0.05
"""Relative SD of friction and stiffness between mountings, if no tests show it.

The friction of a film scatters by 3 to 8 % between tests (Choi 2018, table I).
"""
UNFITTED_SD = math.log(2) / 1.96
"""SD of ln(scale factor) if nobody fitted it: 95 % lie within the plausible 0.5 to 2.

Choi 2018 fitted 0.875 for Kapton and 1.24 for PTFE.
"""
COMPUTED_STIFFNESS = (0.1, 1.0)
"""Ratio of the stiffness of brake and rig to that of the sheets alone, for 95 % of brakes.

Choi 2018 measured 131 instead of 808 kN/m (0.16) for Kapton: clamps and rig dominate.
"""
EXPONENT_SD = 0.06
"""SD of the exponent of friction versus contact pressure, if no tests at several vacuums show it.

For 95 % of brakes friction then changes by up to 31 % a decade of pressure.
"""
PRIOR_DEGREES = 4.0
"""Degrees of freedom of an assumed SD, with which the scatter of tests is pooled.

An SD between 3 and 8 %, as in the paper, is known within a factor of 1.6.
"""
TEST_VACUUM, TEST_SPEED = 101325.0, 0.01
"""Full vacuum at sea level [Pa] and speed of usual pulls [m/s], for a brake without tests."""
SPEED_SD = 0.03
"""SD of the change of ln(friction) per decade of speed, if the brake has no speed law."""
UPPER = 0.975
"""Level of the upper end of a 95 % interval."""
OF_SHEETS = ("sheets.", "film.product")
"""Values with which a scale factor may change; friction and stiffness may be measured anew."""
FITTED = ("paper", "inferred", "calibrated", "measured", "synthetic")
"""Kinds of sources of a number that somebody determined on this kind of brake."""


class Unknown(NamedTuple):
    """Independent deviations of some numbers of a brake.

    `root` (q, q) is a root of the covariance of the logarithms of the `names`; each of its columns
    multiplies an independent Student's t with `degrees` (q,) of freedom. `shift` (q,) is the
    logarithm of the ratio of the median to the value in the file. `further` marks a scatter of a
    further test, which the mean of many tests does not have.
    """

    names: tuple[str, ...]
    root: Array
    degrees: tuple[float, ...]
    shift: tuple[float, ...] = ()
    further: bool = False


def list_unknowns(file: BrakeFile) -> Iterator[Unknown]:
    """Yield the deviations of friction, stiffness and enclosure of a brake.

    Film friction and scale factor are one number if pulls determined their product.
    """
    fit = file.valid_evidence("calibrate")
    film = file.valid_evidence("friction")
    if fit is not None:
        yield from _from_evidence(fit)
        yield from _static_over_kinetic(file, film)
        return
    if film is not None:
        yield from _from_evidence(film)
    else:
        yield from _film_friction(file)
    factor = file.sources.get("scale_factor")
    fitted = factor is not None and factor.kind in FITTED and not file.outdated_evidence
    fitted = fitted and find_borrowed_fit(file) is None
    yield _single("scale_factor", MOUNTING_SD if fitted else UNFITTED_SD)
    yield _single("scale_factor", REPEAT_SD["kinetic"], further=True)
    if file.brake.stiffness_measured is not None:
        yield _single("stiffness_measured", MOUNTING_SD)
        yield _single("stiffness_measured", REPEAT_SD["kinetic"], further=True)
    else:
        low, high = (math.log(end) for end in COMPUTED_STIFFNESS)
        yield _single("stiffness_measured", (high - low) / 2 / 1.96, shift=(low + high) / 2)
    entry = _enclosure_evidence(file)
    if entry is None:
        yield _single("enclosure_force", file.brake.enclosure.force_sd)
    else:
        yield from _from_evidence(entry)


def _enclosure_evidence(file: BrakeFile) -> Evidence | None:
    """Return what tensile tests of the enclosure showed, unless the file states its uncertainty."""
    if file.brake.enclosure.force_uncertainty is not None:
        return None
    return file.valid_evidence("enclosure")


def rate_enclosure(file: BrakeFile) -> Brake:
    """Return the brake of a file, with the uncertainty of its enclosure that tests showed."""
    entry, brake = _enclosure_evidence(file), file.brake
    if entry is None:
        return brake
    place = entry.names.index("enclosure_force")
    sd = math.sqrt(entry.find_covariance()[place, place])
    return evolve(brake, enclosure=evolve(brake.enclosure, force_uncertainty=sd))


def find_borrowed_fit(file: BrakeFile) -> tuple[str, dict[str, tuple[Any, Any]]] | None:
    """Return the brake of the catalogue whose fitted scale factor a different brake still has.

    The second value {path: (value of that brake, value now)} contains what differs. Such a file
    began as a copy of that brake and was edited.
    """
    source = file.sources.get("scale_factor")
    if source is None or any(entry.command == "calibrate" for entry in file.evidence):
        return None
    values, changes = file.known_values, []
    for name, own_source, old_values in _list_fitted_brakes():
        if source == own_source:
            ends = {place: (old, values.get(place)) for place, old in old_values.items()}
            changes.append((name, {p: pair for p, pair in ends.items() if _differ(*pair)}))
    nearest = min(changes, key=lambda change: len(change[1]), default=None)
    return nearest if nearest is not None and nearest[1] else None


@functools.cache
def _list_fitted_brakes() -> tuple[tuple[str, Source, Mapping[str, Any]], ...]:
    """Return name, source of the scale factor, and values for which it holds, of the catalogue."""

    def describe(file: BrakeFile) -> dict[str, Any]:
        values = state_fitted("calibrate", file.known_values)
        return {place: value for place, value in values.items() if place.startswith(OF_SHEETS)}

    rows = ((f, f.sources.get("scale_factor")) for f in map(load, catalogue()))
    return tuple(
        (file.name, source, describe(file))
        for file, source in rows
        if source is not None and source.kind in FITTED
    )


def _differ(old: Any, new: Any) -> bool:
    if isinstance(old, str | bool) or new is None:
        return bool(old != new)
    return not math.isclose(old, new, rel_tol=1e-9)


def join_alike(unknowns: Iterable[Unknown]) -> tuple[Unknown, ...]:
    """Return deviations with those of the same numbers joined into one.

    The mean of some tests and the scatter of the next one rest on the same scatter, with the same
    degrees of freedom. It is too large or too small for both, so their variances add, as in
    Student's prediction interval. Variances of different degrees of freedom are independent. Their
    sum has the degrees of freedom of Welch and Satterthwaite (GUM, annex G.4.1). Its interval is
    never narrower than that of one part.
    """
    groups: dict[tuple[str, ...], list[Unknown]] = {}
    units: list[Unknown] = []
    for unknown in unknowns:
        if any(unknown.shift):
            units.append(unknown)
        else:
            groups.setdefault(unknown.names, []).append(unknown)
    return (*units, *(_join(group) if len(group) > 1 else group[0] for group in groups.values()))


def _join(group: list[Unknown]) -> Unknown:
    covariances: dict[tuple[float, ...], Array] = {}
    for unknown in group:
        square = unknown.root @ unknown.root.T
        covariances[unknown.degrees] = covariances.get(unknown.degrees, 0.0) + square
    total = sum(covariances.values(), np.zeros(()))
    degrees, scales = [], []
    for place in range(len(total)):
        parts = [(float(c[place, place]), nu[place]) for nu, c in covariances.items()]
        freedom, scale = _combine_variances(parts)
        degrees.append(freedom)
        scales.append(scale)
    root = _find_root(total * np.outer(scales, scales))
    return Unknown(group[0].names, root, tuple(degrees))


def _combine_variances(parts: list[tuple[float, float]]) -> tuple[float, float]:
    """Return the degrees of freedom of a sum of variances, and a multiplier of its root.

    The multiplier is above 1 where the sum would have a narrower interval than one part.
    """
    total = sum(variance for variance, _ in parts)
    inverse = sum((variance / total) ** 2 / nu for variance, nu in parts) if total else 0.0
    if not inverse:
        return math.inf, 1.0
    from scipy.special import stdtrit

    width = stdtrit(1 / inverse, UPPER) * math.sqrt(total)
    widths = [stdtrit(nu, UPPER) * math.sqrt(variance) for variance, nu in parts]
    return 1 / inverse, max(1.0, float(max(widths) / width))


def _from_evidence(entry: Evidence) -> Iterator[Unknown]:
    for part in entry.parts:
        root = _find_root(part.covariance)
        degrees = (part.degrees,) * len(entry.names)
        yield Unknown(entry.names, root, degrees, further=part.of != "mean")


def _film_friction(file: BrakeFile) -> Iterator[Unknown]:
    """Yield the spread of the film's friction, from its source or from the catalogue."""
    source = file.sources.get("film.kinetic")
    if source is not None and source.kind in FITTED:
        for name, usual in REPEAT_SD.items():
            friction_source = file.sources.get(f"film.{name}")
            sd = (
                usual
                if friction_source is None or friction_source.sd is None
                else friction_source.sd
            )
            yield _single(f"film.{name}", math.sqrt(math.log1p(sd**2)))
        return
    low, high = film_friction_range(file)
    middle = math.log(low * high) / 2 - math.log(file.brake.film.kinetic)
    sd = math.log(high / low) / 2 / 1.96
    # a rougher film has more of both frictions
    root = np.array([[sd, 0.0], [sd, 0.0]])
    yield Unknown(("film.kinetic", "film.static"), root, (math.inf,) * 2, (middle, middle))
    yield from _static_over_kinetic(file, None)


def _static_over_kinetic(file: BrakeFile, film: Evidence | None) -> Iterator[Unknown]:
    """Yield the spread of static friction that the kinetic friction does not have."""
    if film is not None and "film.static" in film.names:
        place = film.names.index("film.static")
        for part in film.parts:
            sd = part.covariance[place][place] ** 0.5
            yield _single("film.static", sd, part.degrees, further=part.of != "mean")
        return
    source = file.sources.get("film.static")
    sd = REPEAT_SD["static"] if source is None or source.sd is None else source.sd
    yield _single("film.static", math.sqrt(math.log1p(sd**2)))


def _single(
    name: str, sd: float, degrees: float = math.inf, shift: float = 0.0, further: bool = False
) -> Unknown:
    return Unknown((name,), np.array([[sd]]), (degrees,), (shift,), further)


def _find_root(matrix: object) -> Array:
    """Return a root of a covariance, lower triangular where the covariance is not singular."""
    square = np.array(matrix, float)
    scale = np.sqrt(np.maximum(np.diag(square), 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = np.nan_to_num(square / np.outer(scale, scale))
    # a tiny ridge lets a singular matrix have a triangular root
    safe = unit + 1e-12 * np.eye(len(unit))
    np.fill_diagonal(safe, np.where(scale > 0, 1.0 + 1e-12, 1.0))
    try:
        return np.asarray(scale[:, None] * np.linalg.cholesky(safe))
    except np.linalg.LinAlgError:
        values, axes = np.linalg.eigh(square)
        return np.asarray(axes * np.sqrt(np.maximum(values, 0.0)))


def exponent_sd(fit: Evidence | None) -> float:
    """Return the SD of the exponent of friction versus pressure that the tests leave open."""
    return EXPONENT_SD if fit is None or fit.exponent_sd is None else fit.exponent_sd


def film_friction_range(file: BrakeFile) -> tuple[float, float]:
    """Return the plausible range of kinetic friction [-] for a brake's film.

    It spans the brake's own value and all values of that film in the catalogue, widened by
    `MARGIN`.
    """
    product = file.known_values.get("film.product")
    values = [file.brake.film.kinetic, *_catalogue_friction(str(product))]
    return min(values) / MARGIN, max(values) * MARGIN


def _catalogue_friction(product: str) -> Iterator[float]:
    """Yield the kinetic friction of all entries of the catalogue with this film."""
    for name, text in materials()["films"].items():
        film = parse_toml(text, name)
        if film["name"] == product:
            yield film["kinetic"]["value"]
    for device in map(load, devices()):
        if device.known_values.get("film.product") == product:
            yield device.brake.film.kinetic
