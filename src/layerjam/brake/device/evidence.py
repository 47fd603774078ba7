"""Results of tests of a brake: uncertainty, scatter and tested range, [[tested]] in its file."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from layerjam.core.errors import QuantityError
from layerjam.core.units import QuantitySpec, exact_text

Matrix = tuple[tuple[float, ...], ...]
NUMBERS = (
    "scale_factor",
    "stiffness_measured",
    "enclosure_force",
    "pressure_exponent",
    "film.static",
    "film.kinetic",
)
"""Numbers that tests determine; all but the exponent as logarithms.

`enclosure_force` multiplies the modulus of the enclosure and its friction alike.
"""
RANGES: Mapping[str, QuantitySpec] = MappingProxyType(
    {
        "vacuum": QuantitySpec("Pa", "vacuum of the tests", lo=0),
        "slip": QuantitySpec("m", "slip of the tests", lo=0),
        "speed": QuantitySpec("m/s", "speed of the tests", lo=0),
        "force": QuantitySpec("N", "force of the tests", lo=0),
        "strain": QuantitySpec("1", "strain of the enclosure in the tests", lo=0),
    }
)
LAWS = (
    *("mount.spacers", "pressure_exponent", "test_pressure", "lowest_pressure"),
    *("speed_law.", "hyperelastic."),
)
"""Values that a file need not state; a name with "." at its end is a table."""
FITTED_TO: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "friction": ("film.product", "film.static", "film.kinetic"),
        "enclosure": ("enclosure.product", "enclosure.modulus", "hyperelastic."),
        "calibrate": (
            *("sheets.count", "sheets.width", "sheets.thickness", "sheets.overlap"),
            *("sheets.free_left", "sheets.free_right"),
            *("film.product", "film.kinetic", "film.friction_on_silicone"),
            *("enclosure.wall", "enclosure.modulus", "scale_factor", "stiffness_measured"),
            *LAWS,
        ),
    }
)
"""{command: values of a brake for which its tests hold}, with names as in `LAWS`."""
REQUIRED_RANGES: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"friction": (), "calibrate": ("vacuum", "slip"), "enclosure": ("strain",)}
)
"""{command: ranges without which nothing would be outside the tests}."""
PARTS = ("mean", "test", "mounting")
LARGEST, LARGEST_EXPONENT, FEWEST_DEGREES = 4.0, 1.0, 1.0
"""Bounds of covariances of logarithms, of the SD of an exponent, and of degrees of freedom."""


class Part(NamedTuple):
    """An independent part of the uncertainty of fitted numbers, as a covariance (q, q).

    `of` is "mean" for the error of the fitted numbers, "test" for the scatter of a further test
    about them, "mounting" for that of a further mounting. `degrees` of freedom are infinite for a
    value that is assumed or stated.
    """

    of: str
    covariance: Matrix
    degrees: float = math.inf


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """Numbers that one command fitted to tests of a brake, and where these tests were made.

    `parts` are those of the uncertainty of the fitted `names`. `exponent_sd` is the SD about zero
    of an exponent of friction versus pressure that was not fitted, after tests at several vacuums.
    At `reference_pressure` [Pa] a fitted exponent does not change the friction. `ranges` {quantity:
    (lowest, highest)} are in SI, `fitted` {path: value} are the values of the brake for which the
    tests hold.
    """

    command: str
    date: str
    tests: int
    mountings: int | None = None
    names: tuple[str, ...]
    exponent_sd: float | None = None
    reference_pressure: float | None = None
    ranges: Mapping[str, tuple[float, float]]
    fitted: Mapping[str, Any]
    parts: tuple[Part, ...]

    def find_covariance(self) -> npt.NDArray[np.float64]:
        """Return the covariance (q, q) of the fitted numbers."""
        return np.sum([part.covariance for part in self.parts if part.of == "mean"], axis=0)

    def find_changes(self, values: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
        """Return {path: (value during the tests, value now)} of the values that have changed."""
        changes = {}
        # a law that the file did not state during the tests is new
        laws = (path for path in values if path not in self.fitted and _is_law(path))
        for path in (path for path in (*self.fitted, *laws) if _holds_for_path(path, self.command)):
            test_value: Any = self.fitted.get(path)
            value: Any = values.get(path)
            if value is None and isinstance(test_value, str):
                continue  # a Brake without its file has numbers only
            is_unchanged = (
                abs(value - test_value) <= 1e-9 * abs(test_value)
                if _is_number(value) and _is_number(test_value)
                else value == test_value
            )
            if not is_unchanged:
                changes[path] = (test_value, value)
        return changes

    def to_toml(self) -> dict[str, Any]:
        """Return the entries of the table; text for quantities with a unit."""
        row: dict[str, Any] = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if value is None:
                continue
            if f.name == "ranges":
                value = {
                    name: [exact_text(float(f"{end:.6g}"), RANGES[name].unit) for end in ends]
                    for name, ends in value.items()
                }
            elif f.name == "parts":
                value = [_part_to_toml(part) for part in value]
            elif isinstance(value, tuple):
                value = list(value)
            row[f.name] = dict(value) if isinstance(value, Mapping) else value
        return row

    @classmethod
    def read(cls, row: object) -> Self:
        """Return the evidence in a table of a file; raises QuantityError for any other table."""
        if not isinstance(row, dict):
            raise QuantityError("tested must be tables, each after a line [[tested]]")
        keys = {f.name for f in fields(cls)}
        unknown_keys = ", ".join(sorted(set(row) - keys))[:60]
        if unknown_keys:
            raise QuantityError(f"tested has the unknown key {unknown_keys}")
        values: dict[str, Any] = {}
        for key, read in _READERS.items():
            try:
                values[key] = read(row)
            except QuantityError:
                raise
            except (KeyError, TypeError, ValueError, AttributeError, np.linalg.LinAlgError):
                raise QuantityError(
                    f"tested: {key} is missing or not as `calibrate` writes it; calibrate again, "
                    "or remove the table"
                ) from None
        missing = set(REQUIRED_RANGES[values["command"]]) - set(values["ranges"])
        if missing:
            keys_text = ", ".join(f"ranges.{name}" for name in sorted(missing))
            raise QuantityError(
                f"tested: {keys_text} is missing; state the range of the tests, or remove the table"
            )
        size = len(values["names"])
        if any(len(part.covariance) != size for part in values["parts"]):
            raise QuantityError(f"tested: the covariance in parts is not that of {size} names")
        entry = cls(**values)
        entry._check_variances()
        return entry

    def _check_variances(self) -> None:
        """Raise an error if all parts state that a fitted number has no uncertainty.

        Pulls do not scatter the force of the enclosure, and a file may state that it is exact.
        """
        for place, name in enumerate(self.names):
            is_exact = not sum(part.covariance[place][place] for part in self.parts)
            if is_exact and (self.command, name) != ("calibrate", "enclosure_force"):
                raise QuantityError(
                    f"tested, {self.command}: the covariance of {name} is 0 in all parts; a fitted "
                    "number needs a variance above 0 in at least one; calibrate again, or remove "
                    "the table"
                )


def read_evidence(rows: object) -> tuple[Evidence, ...]:
    """Return the evidence in [[tested]] of a file; raises QuantityError if it is not valid."""
    if not isinstance(rows, list | tuple):
        raise QuantityError("tested must be tables, each after a line [[tested]]")
    entries = tuple(map(Evidence.read, rows))
    commands = [entry.command for entry in entries]
    twice = next((command for command in commands if commands.count(command) > 1), None)
    if twice is not None:
        raise QuantityError(f"tested: two tables are of {twice}; remove one of them")
    return entries


def state_fitted(
    command: str,
    values: Mapping[str, Any],
    changes: Mapping[str, tuple[Any, object] | None] = MappingProxyType({}),
) -> dict[str, Any]:
    """Return the values of a brake {path: value} for which the tests of a command hold.

    `values` are those of its file, `changes` {path: (value, source)} those that the command writes.
    """
    new_values = dict(values) | {path: change and change[0] for path, change in changes.items()}
    return {
        path: value
        for path, value in new_values.items()
        if value is not None and _holds_for_path(path, command)
    }


def _is_law(path: str) -> bool:
    return path in LAWS or f"{path.partition('.')[0]}." in LAWS


def _holds_for_path(path: str, command: str) -> bool:
    """Return whether the tests of a command hold for one value of a path only."""
    return path in FITTED_TO[command] or f"{path.partition('.')[0]}." in FITTED_TO[command]


def as_tuples(matrix: npt.ArrayLike) -> Matrix:
    """Return a matrix as tuples of numbers, which can be compared and written."""
    return tuple(tuple(float(x) for x in row) for row in np.asarray(matrix))


def replace_evidence(earlier: Sequence[Evidence], new: Evidence) -> Iterator[Evidence]:
    """Yield the evidence of a file after a command: one entry for each command."""
    yield from (entry for entry in earlier if entry.command != new.command)
    yield new


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _part_to_toml(part: Part) -> dict[str, Any]:
    degrees = {"degrees": part.degrees} if math.isfinite(part.degrees) else {}
    return {"of": part.of, **degrees, "covariance": [list(row) for row in part.covariance]}


def _read_part(row: Mapping[str, Any]) -> Part:
    matrix = np.array(row["covariance"], float)
    if row["of"] not in PARTS or set(row) - {"of", "covariance", "degrees"}:
        raise ValueError("of")
    if matrix.shape != (len(matrix), len(matrix)) or not np.isfinite(matrix).all():
        raise ValueError("covariance")
    low, high = np.linalg.eigvalsh(matrix)[[0, -1]]
    if not (np.allclose(matrix, matrix.T) and low >= -1e-9 * abs(high) and high < LARGEST):
        raise ValueError("covariance")
    degrees = _read_positive("degrees", row)
    if degrees is not None and degrees < FEWEST_DEGREES:
        raise QuantityError(
            f"tested: degrees in parts is {degrees:g}; expected at least {FEWEST_DEGREES:g}, as n "
            "tests with one fitted number have n - 1; calibrate again, or remove the table"
        )
    return Part(row["of"], as_tuples(matrix), math.inf if degrees is None else degrees)


def _read_names(row: Mapping[str, Any]) -> tuple[str, ...]:
    names = tuple(row["names"])
    if not names or len(set(names)) < len(names) or not set(names) <= set(NUMBERS):
        raise ValueError("names")
    return names


def _read_command(row: Mapping[str, Any]) -> str:
    if row["command"] not in FITTED_TO:
        raise ValueError("command")
    return str(row["command"])


def _read_fitted(row: Mapping[str, Any]) -> dict[str, Any]:
    fitted = dict(row["fitted"])
    for path, value in fitted.items():
        is_known = isinstance(value, str | bool) or (_is_number(value) and math.isfinite(value))
        if not (is_known and _holds_for_path(path, row["command"])):
            raise ValueError(path)
    # a change of a value that is not stated would go unnoticed
    every_file_has = (
        path
        for path in FITTED_TO[row["command"]]
        if not (_is_law(path) or path.endswith(".product"))
    )
    if not all(path in fitted for path in every_file_has):
        raise ValueError("fitted")
    return fitted


def _read_exponent(row: Mapping[str, Any]) -> float | None:
    sd = _read_positive("exponent_sd", row)
    if sd is not None and sd > LARGEST_EXPONENT:
        raise ValueError("exponent_sd")
    return sd


def _read_parts(row: Mapping[str, Any]) -> tuple[Part, ...]:
    parts = tuple(map(_read_part, row["parts"]))
    if not any(part.of == "mean" for part in parts):
        raise ValueError("parts")
    return parts


def _read_ranges(row: Mapping[str, Any]) -> dict[str, tuple[float, float]]:
    ranges = {}
    for name, ends in row["ranges"].items():
        low, high = (RANGES[name].read(end, f"tested.ranges.{name}") for end in ends)
        if low > high:
            raise ValueError("ranges")
        ranges[name] = (low, high)
    return ranges


def _read_positive(key: str, row: Mapping[str, Any]) -> float | None:
    if key not in row:
        return None
    if not _is_number(row[key]) or not 0 < row[key] < math.inf:
        raise ValueError(key)
    return float(row[key])


def _read_count(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise ValueError("count")
    return value


_READERS: Mapping[str, Callable[[Mapping[str, Any]], Any]] = MappingProxyType(
    {
        "command": _read_command,
        "date": lambda row: str(row["date"]),
        "tests": lambda row: _read_count(row["tests"]),
        "mountings": lambda row: _read_count(row["mountings"]) if "mountings" in row else None,
        "names": _read_names,
        "exponent_sd": _read_exponent,
        "reference_pressure": lambda row: _read_positive("reference_pressure", row),
        "ranges": _read_ranges,
        "fitted": _read_fitted,
        "parts": _read_parts,
    }
)
"""{key: its value in a table}, for every field of `Evidence`."""
