"""One definition per quantity; where two of one name and unit differ, the reason stands here."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import math
import pkgutil
import sys
from collections import defaultdict

import pytest

import layerjam
from layerjam.core.command.declare import load_command
from layerjam.core.command.index import commands
from layerjam.core.errors import QuantityError
from layerjam.core.record_classes import RECORDS
from layerjam.core.units import QuantitySpec

APART = {
    # parts of a device that have the same word for different things
    "bench serve.port": "0 takes a free one",
    "bench log.duration": "recorded for days, not simulated",
    "Sheets.count": "sheets of one brake, pumps of one line",
    "Sheets.length": "a sheet, not a tube",
    "Enclosure.density": "rubber, not film, which may hold glass",
    "Enclosure.modulus": "rubber, not film",
    "Chamber.volume": "what the pump empties, not a tank",
    "Build.wall": "of what is printed, not of the enclosure",
    "Sensor.lag": "a pressure sensor, not the lag of a load cell's fault",
    "Rope.stiffness": "a rope, not the brake in a rig",
    # friction coefficients: of a film, of a fitted curve that may reach zero, or their scatter
    "Stribeck.static": "a curve may be frictionless",
    "Stribeck.kinetic": "a curve may be frictionless",
    "WetFilm.static": "a curve may be frictionless",
    "WetFilm.kinetic": "a curve may be frictionless",
    "Scatter.static": "a standard deviation divided by the mean",
    "Scatter.kinetic": "a standard deviation divided by the mean",
    # speeds of different things
    "tensile.speed": "of a crosshead, which is slower than what arrives",
    "stick-slip.speed": "of a crosshead, which is slower than what arrives",
    "StickSlipPull.speed": "of a crosshead, which is slower than what arrives",
    "Facts.speed": "of a crosshead, which is slower than what arrives",
    "Pull.speed": "of a crosshead, which is slower than what arrives",
    "Return.speed": "of a crosshead, which is slower than what arrives",
    "FrictionTests.speed": "of a crosshead, which is slower than what arrives",
    "ReadingOptions.speed": "of a crosshead, which is slower than what arrives",
    "pull.speed": "of a crosshead, which is slower than what arrives",
    "ageing.speed": "of a crosshead, which is slower than what arrives",
    "friction.speed": "of a crosshead, which is slower than what arrives",
    "calibrate.speed": "of a crosshead, which is slower than what arrives",
    "validate.speed": "of a crosshead, which is slower than what arrives",
    "report.speed": "of a crosshead, which is slower than what arrives",
    "publish.speed": "of a crosshead, which is slower than what arrives",
    "follow.speed": "of a slip, which may be held",
    "Stribeck.speed": "zero: static friction decays at once",
    "WetFilm.speed": "zero: the water carries at once",
    # masses, forces and lengths of people and machines
    "NeckGuardHead.mass": "a head, not what a brake may stop in general",
    "SeatBeltOccupant.mass": "a person, not what a brake may stop in general",
    "AnkleClutchLimits.mass": "a limit on what is worn",
    "RehabilitationLimits.mass": "a limit on what is worn",
    "SeatBeltLimits.mass": "a limit on what a car carries",
    "NeckGuardHead.height": "within a body, not of a fall",
    "Hold.duration": "a wait, which may be none, or take weeks",
    "Pull.until": "a position, which may be that of the start",
    "Facts.hold": "films at rest, of which a logarithm is taken",
    "ageing.hold": "films at rest, of which a logarithm is taken",
    "RehabilitationExercise.hold": "by a person, not by a machine",
    "NeckGuardBlow.duration": "of a blow to the head",
    "SeatBeltCrash.duration": "of a crash pulse",
    "AnkleClutchLimits.slip": "a limit, above zero",
    "StopRequirement.force": "a limit, above zero",
    "AnkleClutchSpring.lever": "about an ankle, not about the neck",
    "AnkleClutchSpring.stiffness": "a spring beside the ankle",
    "NeckGuardGuard.stiffness": "helmet, straps and vest",
    "SeatBeltBelt.stiffness": "webbing",
    "Truth.stiffness": "the brake in its rig, not a rope",
    "NeckGuardGuard.slack": "of straps, not of a rig",
    "SeatBeltBelt.slack": "of a belt, not of a rig",
    # what a log tells of a line that need not be one of ours
    "leak.volume": "of any closed chamber",
    "pump-down.volume": "of any chamber",
    "pump-down.compliance": "fitted: below zero where the log shows it",
    # what is asked of the virtual laboratory and of designs
    "Pulls.travel": "elongation, at least one sample and at most a machine's stroke",
    "FrictionTests.travel": "a sled's path, at least one sample and at most a machine's stroke",
    "Pulls.repeats": "a campaign without pulls is none",
    "FrictionTests.stick_slip": "a sled's force is smaller than a brake's",
    "tensile.samples": "two stacks have a scatter; chances need a hundred samples",
    "Brakes.vacuum": "brakes without vacuum do not resist",
    "array.parallel": "each member is computed; a scenario counts equal ones once",
    "array.series": "each member is computed; a scenario counts equal ones once",
    "build.parallel": "as in array",
    "build.series": "as in array",
}
"""{owner.name: why it differs from the others of its name and unit}."""


UNITS = {
    "window": "of time, path or strain, as the command evaluates",
    "rmse": "of force or of pressure, as the command fits",
}
"""{key of results: why it has more than one unit}."""


def _modules() -> None:
    for found in pkgutil.walk_packages(layerjam.__path__, "layerjam."):
        if not found.name.startswith(("layerjam.workbench", "layerjam.cli")):
            importlib.import_module(found.name)


def _declared() -> dict[str, QuantitySpec]:
    """{owner.name: specification} of all parameters of commands and fields of records.

    A field without bounds is an output.
    """
    _modules()
    found = {}
    for name in commands():
        made = load_command(name)
        found |= {f"{made.name}.{p.name}": p.spec for p in made.parameters if p.spec}
    modules = [m for n, m in sys.modules.items() if n.startswith("layerjam.")]
    # a kind of machine has records that no module names; other tests declare records of their own
    own = [record for record in RECORDS if record.__module__.startswith("layerjam.")]
    for cls in [*(one for module in modules for one in vars(module).values()), *own]:
        if not (isinstance(cls, type) and dataclasses.is_dataclass(cls)):
            continue
        for f in dataclasses.fields(cls):
            spec = f.metadata.get("quantity")
            if spec is not None and "result" not in f.metadata and _bounded(spec):
                said = (c for c in cls.__mro__ if f.name in inspect.get_annotations(c))
                found[f"{next(said).__name__}.{f.name}"] = spec
    return found


def _bounded(spec: QuantitySpec) -> bool:
    return spec.open_lo or spec.lo not in (0, -math.inf) or spec.hi != math.inf


def _bounds(spec: QuantitySpec) -> tuple[float | bool, ...]:
    return spec.lo, spec.hi, spec.open_lo, spec.whole


@pytest.fixture(scope="module")
def declared() -> dict[str, QuantitySpec]:
    return _declared()


def test_equal_quantities_have_equal_bounds(declared: dict[str, QuantitySpec]) -> None:
    groups: dict[tuple[str, str], dict[str, QuantitySpec]] = defaultdict(dict)
    for where, spec in declared.items():
        if where not in APART:
            groups[where.rpartition(".")[2], spec.unit][where] = spec
    differ = {
        name: {where: _bounds(spec) for where, spec in group.items()}
        for (name, _), group in groups.items()
        if len({_bounds(spec) for spec in group.values()}) > 1
    }
    assert not differ


def test_every_reason_is_needed(declared: dict[str, QuantitySpec]) -> None:
    for where in APART:
        assert where in declared, f"{where} is not declared"
        spec, name = declared[where], where.rpartition(".")[2]
        same = [
            other
            for at, other in declared.items()
            if at != where and at.endswith(f".{name}") and other.unit == spec.unit
        ]
        assert any(_bounds(other) != _bounds(spec) for other in same), where


def test_a_quantity_takes_its_own_bounds(declared: dict[str, QuantitySpec]) -> None:
    for where, spec in declared.items():
        for edge in (spec.lo, spec.hi):
            if math.isinf(edge) or (edge == spec.lo and spec.open_lo):
                continue
            assert spec.check(edge, where) == edge
            if spec.whole:
                assert spec.read(str(edge), where) == edge
        if not math.isinf(spec.hi):
            with pytest.raises(QuantityError):
                spec.check(spec.hi * 1.001 + (spec.hi == 0), where)


def test_examples_are_allowed(declared: dict[str, QuantitySpec]) -> None:
    for where, spec in declared.items():
        if spec.example:
            spec.read(spec.example.strip("'"), where)


def test_a_result_counts_a_name_in_one_unit() -> None:
    units = defaultdict(set)
    for name in commands():
        made = load_command(name)
        for f in [*made.result.keys()]:
            if f.metadata["quantity"]:
                units[f.name].add(f.metadata["quantity"].unit)
    assert {name for name, found in units.items() if len(found) > 1} == set(UNITS)
