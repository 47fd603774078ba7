"""Array arguments of a command: broadcasting, and the labels of its result."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from layerjam.core.conversion import unit_factor
from layerjam.core.errors import MissingExtraError, QuantityError
from layerjam.core.units import show, usual_unit

if TYPE_CHECKING:
    import pandas
    import xarray

    from layerjam.core.drawing.chart import Pane

ROWS = 12
"""Largest number of rows printed of an array result."""
MOST_CURVES = 24
"""Largest number of curves in one figure of an array result."""
MOST_ELEMENTS = 10_000_000
"""Largest number of combinations of array arguments in one call, limited by memory."""


Coordinate = tuple[tuple[str, ...], Any, Mapping[str, Any]]


@dataclass(frozen=True)
class Grid:
    """The array arguments of one call, and the dimensions of the results.

    `inputs` are SI arrays that broadcast to `shape`, `units` their SI units. `coordinates` maps a
    name to the dimensions, values and attributes of a coordinate; one named like an input contains
    its SI values. If the arguments were `labelled`, so are the arrays in the result.
    """

    inputs: Mapping[str, np.ndarray]
    units: Mapping[str, str]
    dimensions: tuple[str, ...]
    shape: tuple[int, ...]
    coordinates: Mapping[str, Coordinate]
    labelled: bool = False

    def label_values(self, values: Mapping[str, Any], units: Mapping[str, str]) -> dict[str, Any]:
        """Return the values that have the shape of the grid, as labelled arrays."""
        import xarray

        return {
            name: xarray.DataArray(
                value,
                dims=self.dimensions,
                coords=dict(self.coordinates),
                name=name,
                attrs={"units": units[name]} if name in units else {},
            )
            for name, value in values.items()
            if np.ndim(value) and np.shape(value) == self.shape
        }

    def to_frame(self, values: Mapping[str, Any]) -> "pandas.DataFrame":
        """Return one row per element: first the inputs, then the computed numbers."""
        import pandas

        columns = {
            name: np.broadcast_to(
                np.asarray(np.nan if value is None else value), self.shape
            ).ravel()
            for name, value in {**self.inputs, **values}.items()
        }
        return pandas.DataFrame(columns)

    def to_xarray(self, values: Mapping[str, Any], units: Mapping[str, str]) -> "xarray.Dataset":
        """Return the numbers along the dimensions of the inputs; single numbers remain single."""
        with MissingExtraError.raise_if_missing("a labelled result (xarray)", "labelled"):
            import xarray
        scalars = {name: value for name, value in values.items() if np.ndim(value) == 0}
        arrays = scalars | self.label_values(values, units)
        data = xarray.Dataset(arrays, coords=self.coordinates)
        for name in scalars:
            data[name].attrs["units"] = units[name]
        return data

    def lines(self, values: Mapping[str, Any], units: Mapping[str, str]) -> Iterator[str]:
        """Yield a table of inputs and numbers in usual units, with rows omitted in the middle."""
        units = {**self.units, **units}
        frame = self.to_frame({name: v for name, v in values.items() if np.ndim(v)})
        columns: list[list[str]] = []
        for name in frame:
            unit = usual_unit(units.get(str(name), "1"))
            factor = usual_unit_factor(units.get(str(name), "1"))
            cells = [
                str(v) if isinstance(v, bool | np.bool_) else "–" if v != v else f"{v / factor:.4g}"
                for v in frame[name].tolist()
            ]
            columns.append(
                [f"{str(name).replace('_', ' ')} [{unit}]" if unit else str(name), *cells]
            )
        rows = list(zip(*columns, strict=True))
        if len(rows) > ROWS + 1:
            rows = [*rows[: ROWS - 1], ("…",) * len(columns), *rows[-2:]]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        for row in rows:
            yield "  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True))

    def panes(self, name: str, value: Any, unit: str) -> "list[Pane]":
        """Return panes of a number versus the first dimension, with one curve per case."""
        from layerjam.core.drawing.chart import Curve, Pane
        from layerjam.core.drawing.style import CYCLE

        cases = np.reshape(np.asarray(value, float), (self.shape[0], -1))
        if cases.shape[1] > MOST_CURVES:
            raise QuantityError.of(
                name,
                f"{cases.shape[1]} curves are too many for one figure; choose at most "
                f"{MOST_CURVES} of them",
            )
        inputs = {
            n: np.reshape(np.broadcast_to(array, self.shape), cases.shape)
            / usual_unit_factor(self.units[n])
            for n, array in self.inputs.items()
        }
        varying_inputs = [n for n, array in self.inputs.items() if sizes(array, self.shape)[0] > 1]
        abscissa = (varying_inputs or [n for n, array in self.inputs.items() if array.ndim])[0]
        curves = []
        for place in range(cases.shape[1]):
            fixed_inputs = [n for n in inputs if n not in (abscissa, *varying_inputs)]
            label = ", ".join(show(self.input_at(n, place), self.units[n]) for n in fixed_inputs)
            y = cases[:, place] / usual_unit_factor(unit)
            curves.append(Curve(inputs[abscissa][:, place], y, CYCLE[place % len(CYCLE)], label))
        x = f"{abscissa.replace('_', ' ')} [{usual_unit(self.units[abscissa])}]"
        height = f"{name.replace('_', ' ')} [{usual_unit(unit)}]"
        low, high = float(np.min(inputs[abscissa])), float(np.max(inputs[abscissa]))
        ends = (low, high) if low < high else (None, None)
        return [Pane(curves, x, height, ends, (None, None))]

    def input_at(self, name: str, place: int) -> float:
        """Return the value of an input in the first row of a case, in SI units."""
        values = np.broadcast_to(self.inputs[name], self.shape)
        return float(np.reshape(values, (self.shape[0], -1))[0, place])


def sizes(value: np.ndarray, shape: tuple[int, ...]) -> tuple[int, ...]:
    """Return the sizes of an array along the axes of the shape to which it broadcasts."""
    return (1,) * (len(shape) - value.ndim) + value.shape


def usual_unit_factor(si: str) -> float:
    """Return the factor from the usual unit of a quantity to SI; 1 for a pure number."""
    unit = usual_unit(si)
    return float(unit_factor(unit, si) or 1) if unit else 1.0


def align_grid(arguments: dict[str, Any], units: Mapping[str, str]) -> Grid | None:
    """Return the grid of the arguments with units; None if all are single numbers.

    Labelled arrays among the arguments are replaced by plain arrays in the shape of the grid. They
    broadcast by the names of their dimensions, others by NumPy's rules. Raises QuantityError if
    arrays cannot be broadcast together or if only some of them are labelled.
    """
    values = {n: arguments[n] for n in units if arguments.get(n) is not None}
    arrays = {name: value for name, value in values.items() if np.ndim(value)}
    labelled_arrays = {name: value for name, value in arrays.items() if hasattr(value, "dims")}
    if not arrays:
        return None
    if labelled_arrays:
        array_names = [name for name in arrays if name not in labelled_arrays]
        if array_names:
            raise QuantityError.of(
                array_names[0],
                f"has no named dimensions, but {next(iter(labelled_arrays))} has; label both, such "
                f"as xarray.DataArray({array_names[0]}, dims='{array_names[0]}')",
            )
        grid = _label_axes(labelled_arrays, values, units)
        _check_size(grid.shape, arrays)
        arguments |= grid.inputs
        return grid
    try:
        shape = np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    except ValueError:
        shapes = " and ".join(f"{n} {np.shape(v)}" for n, v in arrays.items())
        raise QuantityError.of(
            next(iter(arrays)),
            f"shapes do not broadcast: {shapes}; use equal lengths, or name the dimensions with "
            "xarray.DataArray(..., dims=...) for every combination",
        ) from None
    _check_size(shape, arrays)
    inputs = {name: np.asarray(value, float) for name, value in values.items()}
    dimensions: list[str] = []
    coordinates: dict[str, Coordinate] = {}
    for axis, size in enumerate(shape):
        varying = []
        for name, value in inputs.items():
            own_sizes = sizes(value, shape)
            if own_sizes[axis] > 1 or (size == 1 and value.ndim):
                varying.append((name, sum(length > 1 for length in own_sizes)))
        is_single = len(varying) == 1 and varying[0][1] <= 1
        name = varying[0][0] if is_single and varying[0][0] not in dimensions else f"case_{axis}"
        dimensions.append(name)
        if name in inputs:
            coordinates[name] = ((name,), inputs[name].ravel(), {"units": units[name]})
    for name, value in inputs.items():
        if name not in coordinates:
            array = np.broadcast_to(value, shape) if value.ndim else value
            own_dimensions = tuple(dimensions) if value.ndim else ()
            coordinates[name] = (own_dimensions, array, {"units": units[name]})
    return Grid(inputs, dict(units), tuple(dimensions), shape, coordinates)


def _check_size(shape: tuple[int, ...], arrays: Mapping[str, Any]) -> None:
    """Raise QuantityError if there are more combinations than fit into memory."""
    if (size := math.prod(shape)) > MOST_ELEMENTS:
        raise QuantityError.of(
            next(iter(arrays)),
            f"{' and '.join(arrays)} span {size:,} combinations; at most {MOST_ELEMENTS:,} can be "
            "computed in one call, so split them into several calls",
        )


def _label_axes(
    arrays_by_name: Mapping[str, Any], values: Mapping[str, Any], units: Mapping[str, str]
) -> Grid:
    import xarray

    for name, array in arrays_by_name.items():
        if len(set(array.dims)) < array.ndim:
            raise QuantityError.of(name, f"two of its dimensions have the same name: {array.dims}")
    try:
        arrays = xarray.align(*arrays_by_name.values(), join="exact", copy=False)
    except ValueError:
        sizes_of = " and ".join(f"{name} {dict(a.sizes)}" for name, a in arrays_by_name.items())
        raise QuantityError.of(
            next(iter(arrays_by_name)),
            f"coordinates of the arrays differ: {sizes_of}; arrays that share a dimension need "
            "the same coordinates along it",
        ) from None
    by_name = dict(zip(arrays_by_name, xarray.broadcast(*arrays), strict=True))
    first = next(iter(by_name.values()))
    coordinates: dict[str, Coordinate] = {
        str(name): (tuple(map(str, coordinate.dims)), coordinate.values, coordinate.attrs)
        for name, coordinate in first.coords.items()
        if name not in arrays_by_name
    }
    for name, value in values.items():
        if name not in arrays_by_name:
            coordinates[name] = ((), float(value), {"units": units[name]})
    for name, array in arrays_by_name.items():
        if name not in first.dims or array.dims == (name,):
            attributes = {"units": units[name]}
            coordinates[name] = (tuple(map(str, array.dims)), array.values, attributes)
    inputs = {
        name: np.asarray(by_name[name].values if name in by_name else value, float)
        for name, value in values.items()
    }
    return Grid(inputs, dict(units), tuple(map(str, first.dims)), first.shape, coordinates, True)
