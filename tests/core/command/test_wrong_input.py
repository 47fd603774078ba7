"""Wrong input of somebody who has only the README: one plain sentence about the argument."""

from __future__ import annotations

import dataclasses
import datetime
import inspect
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas
import pint
import pytest
import xarray

import layerjam as lj
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.errors import ArgumentError, LayerjamError, QuantityError

KAPTON = "choi2018-kapton"
ureg = pint.UnitRegistry()
FRAME = pandas.DataFrame({"a": [1.0, 2.0, 3.0], "b": [3.0, 4.0, 5.0]})
DATES = np.array(["2020-01-01"], dtype="datetime64[D]")
SHEETS = {
    "count": 11, "width": "13 mm", "thickness": "0.25 mm", "length": "120 mm", "overlap": "68 mm",
    "free_left": "10 mm", "free_right": "10 mm", "usable_travel": "60 mm",
}  # fmt: skip


def labelled(values: Any, *dims: str, **attrs: str) -> xarray.DataArray:
    return xarray.DataArray(values, dims=dims or ("x",), attrs=attrs)


def force(**changed: Any) -> Any:
    return lj.force(KAPTON, **{"slip": "20 mm", "vacuum": "50 kPa", **changed})


def drop(**changed: Any) -> Any:
    return lj.drop(KAPTON, **{"mass": "1 kg", "speed": 2.5, "vacuum": "90 kPa", **changed})


def sheets(**changed: Any) -> Any:
    return lj.Sheets(**{**SHEETS, **changed})


def refused(call: Callable[[], object]) -> str:
    """The sentence of the error; none of the words of the packages below may be in it."""
    with pytest.raises(LayerjamError) as caught:
        call()
    sentence = str(caught.value)
    assert "\n" not in sentence and len(sentence) < 400, sentence
    assert not re.search(r"Tracer|dtype|NoneType|os\.PathLike|positional arg|__init__", sentence)
    return sentence


NUMBER = "is not a number or a text with a unit, such as '1 mm'"
SLIPS: list[tuple[Any, str]] = [
    (True, f"slip: True {NUMBER}"),
    (1j, f"slip: 1j {NUMBER}"),
    (None, "slip: missing; Slip of the sheets, e.g. 20mm"),
    (b"20 mm", f"slip: b'20 mm' {NUMBER}"),
    ({"a": 1}, f"slip: {{'a': 1}} {NUMBER}"),
    (abs, f"slip: <built-in function abs> {NUMBER}"),
    (datetime.timedelta(seconds=1), f"seconds=1) {NUMBER}"),
    ("", "slip: '' is not a number with a unit such as 'mm'"),
    ("20", "slip: '20' has no unit; write '20 mm'"),
    ("20 furlongx", "slip: '20 furlongx' is not in units of length"),
    ("1,5 mm", "slip: '1,5 mm' has a decimal comma"),
    (float("nan"), "slip: nan is not allowed; slip of the sheets must be zero or more"),
    (-0.01, "slip: -10 mm is not allowed"),
    (10**400, "slip: inf is not allowed"),
    (20 * ureg.kPa, "slip: 20 kilopascal cannot be converted to m"),
    (float("nan") * ureg.mm, "slip: nan is not allowed"),
    ([], "slip: the array is empty"),
    ([[0.01], [0.01, 0.02]], f"slip: [0.01] {NUMBER}"),
    ([0.01, None], f"slip: None {NUMBER}"),
    ([0.01, 10**400], "slip: inf is not allowed"),
    ([20 * ureg.mm, 3 * ureg.kg], "slip: 3 kilogram cannot be converted to m"),
    (np.array([]), "slip: the array is empty"),
    (np.array([1j, 2]), "slip: elements of type complex128 are not real numbers"),
    (np.array([True]), "slip: elements of type bool are not real numbers"),
    (np.bool_(True), "slip: elements of type bool are not real numbers"),
    (DATES, r"slip: elements of type datetime64[D] are not real numbers"),
    (np.zeros(1, dtype="V3"), "slip: elements of type |V3 are not real numbers"),
    (np.ma.masked_array([0.01, 0.02], [False, True]), "slip: some elements are masked"),
    (FRAME, "slip: a DataFrame contains several quantities; give one column"),
    (pandas.Series(["10 mm", "x"]), "slip: 'x' is not a number with a unit"),
    (xarray.Dataset({"slip": ("x", [0.01])}), "slip: a Dataset contains several quantities"),
    (labelled(["a"]), "slip: 'a' is not a number with a unit"),
    (labelled([True]), "slip: elements of type bool"),
    (labelled([1j]), "slip: elements of type complex128"),
    (labelled([0.01, np.nan]), "slip: nan is not allowed"),
    (labelled([1.0], units="kPa"), "slip: its attribute units, 'kPa', cannot be converted to m"),
    (np.zeros((4000, 1)), "slip and vacuum span 16,000,000 combinations; at most 10,000,000"),
]


@pytest.mark.parametrize(("slip", "words"), SLIPS, ids=range(len(SLIPS)))
def test_an_array_argument(slip: Any, words: str) -> None:
    many = getattr(slip, "shape", None) == (4000, 1)
    vacuum = np.full(4000, 5e4) if many else "50 kPa"
    assert words in refused(lambda: force(slip=slip, vacuum=vacuum))


WRONG: dict[str, tuple[Callable[[], object], str]] = {
    "shapes": (
        lambda: force(slip=labelled([0.01]), vacuum=labelled([1e4, 2e4])),
        "coordinates of the arrays differ: slip {'x': 1} and vacuum {'x': 2}",
    ),
    "brake as dict": (
        lambda: lj.force({"a": 1}, slip=0.02, vacuum=1e4),
        "brake: {'a': 1} is not text, a path, a BrakeFile or a Brake",
    ),
    "no brake": (lambda: lj.show(None), "brake: missing; Catalogue name or path"),
    "brake as table": (lambda: lj.show(FRAME), "brake: DataFrame of shape (3, 2) is not text"),
    "by place": (
        lambda: lj.force(KAPTON, 0.02, 1e4),
        "force() accepts brake by position, not 3 values; pass the others by name, such as slip",
    ),
    "twice": (lambda: lj.force(KAPTON, brake=KAPTON, slip=0.0, vacuum=0.0), "got brake twice"),
    "array for one": (lambda: drop(mass=np.ones(2)), "mass: ndarray of shape (2,) is not a si"),
    "typo of a word": (
        lambda: drop(vacuum="tunned", travel=0.04),
        "unknown vacuum 'tunned'; did you mean tuned?",
    ),
    "flag": (lambda: drop(horizontal="yes"), "horizontal: 'yes' is not True or False"),
    "flag of Python": (
        lambda: drop(has_intervals="yes"),
        "has intervals: 'yes' is not True or False",
    ),
    "history": (
        lambda: drop(vacuum_history=FRAME),
        "vacuum history: DataFrame of shape (3, 2)",
    ),
    "unknown setting": (
        lambda: drop(sensing={"accelerometre": "ideal"}),
        "unknown option of sensing 'accelerometre'; did you mean accelerometer?",
    ),
    "settings": (lambda: drop(sensing=5), "sensing: 5 is not a Sensing or a mapping"),
    "acceptance": (lambda: drop(accept=5), "accept: 5 is not a mapping or a list of text"),
    "check": (lambda: drop(accept={"foo": "bar"}), "unknown check 'foo'; none exists"),
    "progress": (lambda: drop(progress=5), "progress: 5 is not a function"),
    "atmosphere": (lambda: drop(atmosphere=[1e5]), "atmosphere: [100000.0] is not a number or"),
    "its unit": (lambda: drop(atmosphere=1 * ureg.kg), "atmosphere: 1 kilogram cannot be convert"),
    "procedure": (lambda: lj.tensile(KAPTON, procedure=5), "procedure: 5 is not text or a Proced"),
    "step": (lambda: lj.parse_procedure(None), "procedure: None is not a string such as 'vent'"),
    "files": (
        lambda: lj.calibrate(KAPTON, 5),
        "files: 5 is not text, a path, a Trace, a DataFrame or a list of them",
    ),
    "no file": (lambda: lj.calibrate(KAPTON, None), "files: missing; Files from a test machine"),
    "a file": (lambda: lj.friction("nofile.csv"), "nofile.csv: does not exist"),
    "file as dict": (lambda: lj.calibrate(KAPTON, {"Load": [1, 2]}), "files: {'Load': [1, 2]} is"),
    "columns": (
        lambda: lj.calibrate(KAPTON, FRAME, vacuum="50 kPa"),
        "has the columns a, b; name force and elongation with their units, such as 'Force [N]'",
    ),
    "column": (lambda: lj.calibrate(KAPTON, FRAME, column=5), "column: 5 is not a mapping or a l"),
    "specification": (lambda: lj.design(5), "unknown specification '5'; did you mean stop"),
    "log": (lambda: lj.leak(FRAME), "file: DataFrame of shape (3, 2) is not text or a path"),
    "out": (lambda: lj.build(KAPTON, out=5), "out: 5 is not text or a path"),
    "part": (lambda: lj.parts(5), "name: 5 is not text"),
    "sheets": (lambda: sheets(width="20 kPa"), "width: '20 kPa' is not in units of length"),
    "field": (lambda: sheets(widht="13 mm"), "Sheets() has no field 'widht'; did you mean width?"),
    "no fields": (lambda: lj.Sheets(count=3), "Sheets() needs width, thickness, length"),
    "one by place": (lambda: lj.Sheets(11), "Sheets() takes count, width, thickness"),
    "many dates": (lambda: sheets(width=DATES), "width: elements of type datetime64[D]"),
    "too narrow": (lambda: sheets(width=-1.0), "width: -1 m is not allowed"),
    "options": (lambda: lj.Sensing(foo=1), "Sensing() has no field 'foo'; did you mean"),
    "trace": (lj.Trace, "Trace() needs force, elongation, time"),
    "law, text": (
        lambda: lj.brake_force("20 mm", 1e4, lj.load(KAPTON)),
        "brake_force, slip: '20 mm' is not a number or an array of numbers in SI units",
    ),
    "law, name": (
        lambda: lj.brake_force(0.02, 1e4, KAPTON),
        "brake_force, brake: 'choi2018-kapton' is not a Brake, such as layerjam.load(NAME).brake",
    ),
    "law, swapped": (
        lambda: lj.brake_force(lj.load(KAPTON).brake, 1, 1),
        "brake_force, slip: Brak",
    ),
    "law, shapes": (
        lambda: lj.brake_force(np.ones(2), np.ones(3), lj.load(KAPTON)),
        "brake_force: shapes do not broadcast: slip (2,) and vacuum (3,)",
    ),
    "law, dates": (lambda: lj.brake_force(DATES, 1e4, lj.load(KAPTON)), "brake_force, slip: ndarr"),
    "law, optional": (
        lambda: lj.brake_cycle([0.01], 1e4, lj.load(KAPTON), np.array([1j])),
        "brake_cycle, speed: ndarray of shape (1,) is not a number or",
    ),
    "law, few": (lambda: lj.brake_force(0.02), "brake_force() takes slip, vacuum, brake"),
    "plot": (
        lambda: force().plot("a.xyz"),
        "a.xyz: extension '.xyz' is unknown; use .svg",
    ),
    "axes": (lambda: force().plot(ax=5), "ax: int is not a Matplotlib Axes object"),
    "path": (lambda: force().save(5), "path: 5 is not text or a path"),
    "interval": (lambda: force().interval("mass"), "unknown number with an interval 'mass'"),
}


@pytest.mark.parametrize("name", WRONG)
def test_other_arguments(name: str) -> None:
    call, words = WRONG[name]
    assert words in refused(call)


def test_dimensions_of_one_name() -> None:
    with pytest.warns(UserWarning, match="Duplicate dimension"):
        square = labelled([[0.01]], "x", "x")
        assert "two of its dimensions have the same name" in refused(lambda: force(slip=square))


@pytest.mark.parametrize("name", commands())
def test_every_parameter_of_every_command(name: str) -> None:
    """Neither an object nor a number with a foreign unit gets as far as a computation."""
    command = load_command(name)
    for parameter in command.parameters:
        if type(parameter.type) is object and parameter.spec is None and not parameter.words:
            continue  # its type is known to type checkers alone
        for wrong in (object(), SimpleNamespace(unit="furlong", value=3.0)):
            with pytest.raises(LayerjamError) as caught:
                parameter.read(wrong, {}, [])
            assert parameter.label in str(caught.value) or parameter.name == "spec"


def test_what_is_right_stays_right(tmp_path: Path) -> None:
    """One name for a list of them, a generator of files, text in arrays, units of a site."""
    frame = lj.tensile(KAPTON, travel="20 mm", speed="5 mm/s", vacuum="67 kPa").to_frame()
    table = frame[["elongation", "force"]].set_axis(["Extension [m]", "Load [N]"], axis=1)
    table.to_csv(tmp_path / "one.csv", index=False)
    found = lj.calibrate(KAPTON, tmp_path.glob("*.csv"), vacuum="67 kPa")
    assert found.scale_factor == pytest.approx(0.875, rel=1e-3)
    high = force(atmosphere=0.9 * ureg.bar, vacuum=8e4)
    assert high.force == force(atmosphere=9e4, vacuum=8e4).force
    widths = sheets(width=np.array(["13 mm", "2 cm"])).width
    assert widths.tolist() == [0.013, 0.02]
    assert issubclass(ArgumentError, TypeError) and issubclass(QuantityError, ValueError)


BRAKE = lj.load(KAPTON).brake
NAMES: list[tuple[Callable[[], object], str]] = [
    (lambda: lj.edit(KAPTON, width="14 mm"), "edit() has no parameter 'width'"),
    (lambda: lj.batch(5), "batch() takes law, sweep, brake"),
    (lj.batch, "batch() needs law, sweep, brake"),
    (lj.Campaign, "Campaign() needs spec, subjects, tests"),
    (lambda: lj.Procedure(5), "procedure: 5 is not a tuple of steps"),
    (lj.Procedure, "Procedure() needs steps"),
    (lambda: lj.read_trace(5), "path: 5 is not text or a path"),
    (lambda: BRAKE.with_("13 mm"), "with_() accepts only named values"),
    (lambda: lj.load(KAPTON).with_("13 mm"), "with_() accepts only named values"),
]


@pytest.mark.parametrize(("call", "words"), NAMES)
def test_functions_and_classes_explain_arguments_that_do_not_fit(
    call: Callable[[], object], words: str
) -> None:
    assert words in refused(call)


CONTRADICTIONS: list[tuple[dict[str, Any], str]] = [
    (
        {"sheets": {"usable_travel": "70 mm"}},
        "sheets.usable_travel: 70 mm exceeds",
    ),
    ({"sheets": {"length": "80 mm"}}, "sheets.length: 80 mm is shorter than"),
    ({"film": {"kinetic": 0.9}}, "film.kinetic: 0.9 exceeds film.static"),
    ({"test_pressure": "50 kPa"}, "pressure_exponent: give it together with test_pressure"),
]


@pytest.mark.parametrize(("changes", "words"), CONTRADICTIONS)
def test_a_constructed_brake_does_not_contradict_itself(
    changes: dict[str, Any], words: str
) -> None:
    def construct() -> object:
        nested = {
            name: dataclasses.replace(getattr(BRAKE, name), **value)
            for name, value in changes.items()
            if isinstance(value, dict)
        }
        return dataclasses.replace(BRAKE, **{**changes, **nested})

    assert words in refused(construct)


def test_a_constructed_line_does_not_contradict_itself() -> None:
    line = lj.load_line("choi2018").record
    both = dataclasses.replace(line.pump, ultimate="101.4 kPa")
    assert "pump.ultimate: 101.4 kPa is not below" in refused(
        lambda: dataclasses.replace(line, pump=both)
    )


def test_a_brake_of_arrays_is_not_compared() -> None:
    """Numbers for a batch may contradict each other in some cases; the laws answer NaN there."""
    many = dataclasses.replace(BRAKE.sheets, usable_travel=np.array([0.05, 0.07]))
    assert dataclasses.replace(BRAKE, sheets=many).sheets is many


@pytest.mark.parametrize(
    "wrong",
    [None, 5, "nonsense", [1, "a"], {"a": 1}, object()],
    ids=["nothing", "number", "text", "list", "mapping", "object"],
)
def test_functions_that_are_no_commands_refuse_any_other_kind(wrong: Any) -> None:
    """Each argument that must be given, of a kind that it is not."""
    functions = [
        one
        for one in (getattr(lj, name) for name in dir(lj))
        if inspect.isfunction(one) and not hasattr(one, "declaration")
    ]
    tried = 0
    for function in functions:
        places = inspect.signature(function).parameters.values()
        count = sum(p.default is p.empty and p.kind is p.POSITIONAL_OR_KEYWORD for p in places)
        if count:
            tried += 1
            with pytest.raises(LayerjamError):
                function(*[wrong] * count)
    assert tried >= 10
