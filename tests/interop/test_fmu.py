"""`export fmu`: the law inside, what it refuses, that instances and snapshots are their own."""

from __future__ import annotations

import ctypes
import json
import re
import shutil
import subprocess
import sys
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

from brake.kernel.histories import history
from interop.importer import SIZE, Refused, U, Unit
from layerjam.brake.device.brake import Brake
from layerjam.brake.kernel.kernel import Kernel
from layerjam.cli.main import main
from layerjam.core.errors import FileError, QuantityError
from layerjam.core.units import quantities
from layerjam.interop import fmi
from layerjam.interop.commands.export import export_fmu
from layerjam.interop.fmi_variables import FILE, format_header, list_variables, make_token
from strategies import KAPTON, PTFE, one, random_brakes

CC = pytest.mark.skipif(
    (shutil.which("cc") is None and shutil.which("gcc") is None) or fmi.find_platform() != "linux",
    reason="no C compiler here, or another platform than the importer's",
)
BOTH = pytest.mark.parametrize("version", ["3", "2"])


@pytest.fixture
def made(tmp_path):
    """An instance of a brake, of Kapton by default."""

    def make(version, brake=KAPTON, rope=None, **options):
        values = fmi.brake_values(brake, rope)
        own = {"linux": fmi.build_binary(version, "linux")}
        path = tmp_path / f"{version}.fmu"
        path.write_bytes(fmi.build_fmu(version, "one", values, own))
        folder = tmp_path / f"unit-{len(list(tmp_path.iterdir()))}"
        return Unit(path, folder, version, **options)

    return make


def test_the_list_of_variables_is_that_of_the_c_code():
    """python -m layerjam.interop.fmi_variables writes it anew."""
    assert FILE.read_text("utf-8") == format_header()


@BOTH
def test_parameters_carry_names_units_and_bounds_of_a_brake_file(version):
    text = fmi.model_description(version, 'a "brake" & <more>', fmi.brake_values(KAPTON), ())
    root = ElementTree.fromstring(text)
    assert root.attrib["modelName"] == 'a "brake" & <more>'
    known = {path: spec for path, spec, _ in quantities(Brake)}
    listed = root.findall("ModelVariables/*")
    assert len({one.attrib["valueReference"] for one in listed}) == len(listed)
    parameters = [one for one in listed if one.attrib["causality"] == "parameter"]
    assert len(parameters) == 17
    for row in parameters:
        spec, typed = known[row.attrib["name"]], row if version == "3" else row[0]
        assert typed.attrib.get("unit", "1") == spec.unit
        assert float(typed.attrib["max"]) == spec.hi
        assert float(typed.attrib["min"]) in (spec.lo, 0)
        assert float(typed.attrib["start"]) == fmi.brake_values(KAPTON)[row.attrib["name"]]


@CC
@BOTH
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (2, 5, 11))]
)
def test_forces_are_the_kernels(made, version, seed):
    bent = replace(one(random_brakes(seed, 2, exponent=True), 0), vacuum_share=0.8)
    for brake, rope in ((KAPTON, 16.8e3), (PTFE, None), (bent, None)):
        path, vacuum = history(brake, seed, 256)
        unit, law = made(version, brake, rope), Kernel(brake, rope_stiffness=rope)
        unit.start(elongation=0, vacuum=vacuum[0])
        wanted = [law.move(*point) for point in zip(path, vacuum, strict=True)]
        np.testing.assert_allclose(unit.pull(path, vacuum), wanted, rtol=1e-12, atol=1e-10)
        assert unit.get("heat") == pytest.approx(law.heat, rel=1e-12)
        assert unit.get("work") - unit.get("heat") - unit.get("stored") == pytest.approx(
            0, abs=1e-12 * max(law.work, 1)
        )


@CC
@BOTH
def test_velocity_leads_through_a_step_and_asking_changes_nothing(made, version):
    unit = made(version)
    unit.start(elongation=0, velocity=0.01, vacuum=94.5e3)
    for i in range(400):
        unit.set(elongation=i * 1e-4, velocity=0.01)
        unit.step(i * 0.01, 0.01)
    # shared/design/interop.md, section 4, check 7
    assert unit.get("force") == pytest.approx(88.14862277, abs=1e-8)
    assert unit.get("slip") == pytest.approx(39.32710975e-3, abs=1e-11)
    assert unit.get("work") == pytest.approx(5.305468488, abs=1e-8)
    assert unit.get("heat") == pytest.approx(5.089966247, abs=1e-8)
    before = unit.saved()
    unit.set(elongation=0.02)
    assert unit.get("force") < 20
    unit.set(elongation=0.04)
    assert unit.get("force") == pytest.approx(88.14862277, abs=1e-8)
    unit.restore(before)
    assert unit.saved() == before


def fallen(unit, step, implicit=False):
    """Slip [m] of 1 kg that falls into the unit at 2.5 m/s, the mass stepped here.

    The mass first and then the brake, or the trapezoidal rule with the unit's own slope, which asks
    without committing.
    """
    unit.start(vacuum=94.5e3)
    down, speed, force = 0.0, 2.5, 0.0
    while speed > 0:
        before, ahead = force, speed + step * (9.80665 - force)
        for _ in range(20 if implicit else 0):
            unit.set(elongation=down + step * (speed + ahead) / 2)
            gap = ahead - speed - step * (9.80665 - (before + unit.get("force")) / 2)
            ahead -= gap / (1 + step**2 * unit.slope("force", "elongation") / 4)
        down += step * ((speed + ahead) / 2 if implicit else ahead)
        speed = ahead
        unit.set(elongation=down)
        unit.step(0.0, step)
        force = unit.get("force")
    return unit.get("slip")


@CC
@BOTH
def test_a_mass_slips_as_far_as_its_coupling_lets_it(made, version):
    """shared/design/interop.md, section 4, check 11; 17.025104387 mm by the closed form."""
    rope = 16.8e3
    for step, millimetres in ((0.5e-3, 17.0911), (0.1e-3, 17.0370)):
        assert 1e3 * fallen(made(version, rope=rope), step) == pytest.approx(millimetres, abs=5e-4)
    slip = fallen(made(version, rope=rope), 1e-3, implicit=True)
    assert slip == pytest.approx(17.025104387e-3, abs=10e-6)


@CC
@BOTH
def test_snapshots_go_on_bit_for_bit_and_instances_are_apart(made, version):
    path, vacuum = history(KAPTON, 3, 120)
    unit, other = made(version), made(version, PTFE)
    for each in (unit, other):
        each.start(vacuum=vacuum[0])
    unit.pull(path[:60], vacuum[:60])
    middle = unit.saved()
    first = unit.pull(path[60:], vacuum[60:])
    other.pull(path, vacuum)
    unit.restore(middle)
    assert unit.pull(path[60:], vacuum[60:]).tobytes() == first.tobytes()
    with pytest.raises(Refused, match="not a state of this FMU"):
        unit.restore(middle[:-8])
    with pytest.raises(Refused, match="state: none is given"):
        unit.call("SetFMUState" if version == "3" else "SetFMUstate", None)


@CC
@BOTH
def test_slopes_are_those_of_differences(made, version):
    unit = made(version)
    unit.start(vacuum=60e3)
    for elongation in (2e-4, 0.01, 0.03, 0.0295):
        unit.set(elongation=elongation)
        unit.step(0, 1)
        ahead = -1e-7 if elongation == 0.0295 else 1e-7
        for output in ("force", "slip", "work", "heat", "stored"):
            unit.set(elongation=elongation)
            slope, here = unit.slope(output, "elongation"), unit.get(output)
            unit.set(elongation=elongation + ahead)
            found = (unit.get(output) - here) / ahead
            assert slope == pytest.approx(found, rel=2e-3, abs=1e-3)
        unit.set(elongation=elongation)
        fall, here = unit.slope("force", "vacuum"), unit.get("force")
        unit.set(vacuum=60e3 - 1)
        assert fall == pytest.approx(here - unit.get("force"), rel=1e-3, abs=1e-9)
        unit.set(vacuum=60e3)


@CC
@BOTH
def test_what_is_not_allowed_is_named(made, version, tmp_path):
    def unit():
        return made(version)

    with pytest.raises(Refused, match=r"sheets\.count: 1 is not allowed; a whole number, at least"):
        unit().start(sheets__count=1)
    with pytest.raises(Refused, match=r"sheets\.count: 2\.5 is not allowed"):
        unit().start(sheets__count=2.5)
    with pytest.raises(Refused, match="test_pressure: 0 is not allowed"):
        unit().start(pressure_exponent=-0.1)
    with pytest.raises(Refused, match="vacuum: a negative vacuum is not allowed"):
        unit().start(vacuum=-1)
    running = unit()
    running.start(vacuum=50e3)
    running.set(elongation=0.01)
    running.step(0, 1)
    held = running.saved()
    for values, said in (
        ({"elongation": float("nan")}, "elongation: nan is not a number"),
        ({"film.kinetic": 0.3}, "film.kinetic: a parameter cannot be set while"),
        ({"vacuum": float("inf")}, "vacuum: inf is not a number"),
        ({"velocity": -1e300}, r"velocity: -1e\+300 is not a number"),
        ({"force": 1.0}, "force: neither a parameter nor an input"),
        ({"slack": 1.0}, "slack: neither a parameter nor an input"),
        ({"nobody": 1.0}, "variable 999"),
    ):
        with pytest.raises(Refused, match=said):
            running.set_by(values)
    kind = "Int32" if version == "3" else "Integer"
    reference, whole = (U * 1)(running.references["sheets.count"]), (ctypes.c_int * 1)(3)
    sizes = (SIZE(1),) if version == "3" else ()
    for call in (f"Get{kind}", f"Set{kind}"):
        said = rf"sheets\.count: fmi{version}{call} is not for this variable"
        with pytest.raises(Refused, match=said):
            running.call(call, reference, SIZE(1), whole, *sizes)
    with pytest.raises(Refused, match="force: a function for Booleans is not for this variable"):
        running.flag("force")
    with pytest.raises(Refused, match="slack: a function for numbers is not for this variable"):
        running.get("slack")
    with pytest.raises(Refused, match="vacuum: a slope of an output is not for this variable"):
        running.slope("vacuum", "force")
    with pytest.raises(Refused, match="step: 0 s is not allowed"):
        running.step(1, 0)
    with pytest.raises(Refused, match="variable 999"):
        running.get("nobody")
    assert running.saved() == held
    with pytest.raises(Refused, match="not that of this brake"):
        made(version, token="{0}")


@CC
@BOTH
@pytest.mark.parametrize("harm", ["cut", "longer", "lost", "other"])
def test_damaged_start_values_make_no_instance(tmp_path, version, harm):
    values = fmi.brake_values(KAPTON)
    whole = fmi.build_fmu(version, "one", values, {"linux": fmi.build_binary(version, "linux")})
    (tmp_path / "whole").write_bytes(whole)
    with (
        zipfile.ZipFile(tmp_path / "whole") as old,
        zipfile.ZipFile(tmp_path / "harmed", "w") as new,
    ):
        for name in old.namelist():
            data = old.read(name)
            if name == "resources/brake.bin":
                if harm == "lost":
                    continue
                changes = {"cut": data[:-3], "longer": data + b"1", "other": b"X" + data[1:]}
                data = changes[harm]
            new.writestr(name, data)
    with pytest.raises(Refused, match=r"resources/brake\.bin"):
        Unit(tmp_path / "harmed", tmp_path / "out", version)


@CC
@BOTH
def test_a_binary_shows_the_standards_functions_only(version, tmp_path):
    path = tmp_path / "one.so"
    path.write_bytes(fmi.build_binary(version, "linux"))
    shown = subprocess.run(["nm", "-D", path], capture_output=True, text=True, check=True).stdout
    ours = {line.split()[-1] for line in shown.splitlines() if " T " in line}
    header = fmi.UNIT / "headers" / f"fmi{version}Functions.h"
    wanted = set(re.findall(rf"Export fmi{version}\w+TYPE +(\w+);", header.read_text()))
    assert ours == wanted and len(wanted) > 40


@CC
@BOTH
def test_a_binary_needs_the_c_library_only(version, tmp_path):
    path = tmp_path / "one.so"
    path.write_bytes(fmi.build_binary(version, "linux"))
    shown = subprocess.run(["ldd", path], capture_output=True, text=True, check=True).stdout
    needed = {line.split()[0].rsplit("/")[-1] for line in shown.splitlines()}
    allowed = {"linux-vdso.so.1", "ld-linux-x86-64.so.2", "libc.so.6", "libm.so.6"}
    assert needed <= allowed and "libc.so.6" in needed


@CC
def test_export_writes_once_the_same_and_says_what(tmp_path):
    first, again = tmp_path / "a.fmu", tmp_path / "b.fmu"
    said = export_fmu("choi2018-kapton", out=first, rope_stiffness="16.8 kN/m")
    export_fmu("choi2018-kapton", out=again, rope_stiffness="16.8 kN/m")
    assert first.read_bytes() == again.read_bytes() and len(first.read_bytes()) == said.bytes
    assert said.token == make_token() and said.platforms == ("linux",) and said.fmi_version == "3.0"
    assert list(said.variables) == [one.name for one in list_variables()]
    with pytest.raises(FileError, match="already exists"):
        export_fmu("choi2018-kapton", out=first)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.fmu", "b.fmu"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"platforms": "amiga"}, "choose from linux, linux-arm, windows"),
        ({"platforms": "linux", "sources_only": True}, "are not built for a platform"),
        ({"platforms": "linux-arm", "fmi": "2"}, "FMI 2.0 has no name"),
        ({"platforms": ""}, "is unknown"),
    ],
)
def test_platforms_that_cannot_be_are_refused(tmp_path, options, said):
    with pytest.raises(QuantityError, match=said):
        export_fmu("choi2018-kapton", out=tmp_path / "a.fmu", **options)
    assert not list(tmp_path.iterdir())


def test_without_a_compiler_sources_can_still_be_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setitem(sys.modules, "ziglang", None)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    command = ["export", "fmu", "choi2018-kapton", "--out", str(tmp_path / "a.fmu")]
    assert main(command) == 2
    assert "no C compiler found: install gcc or clang" in capsys.readouterr().err
    assert not (tmp_path / "a.fmu").exists()
    assert main([*command, "--sources-only", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["platforms"] == [] and said["compiler"] is None
    with zipfile.ZipFile(tmp_path / "a.fmu") as packed:
        assert not any(name.startswith("binaries/") for name in packed.namelist())
        assert "sources/buildDescription.xml" in packed.namelist()
