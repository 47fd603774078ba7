"""The FMUs in tools that nobody here wrote: FMPy, its build of the sources, fmutool's checks."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.device.load import catalogue
from layerjam.interop.commands.export import export_fmu

fmpy = pytest.importorskip("fmpy", reason="fmpy is not installed: `make interop` has it")
validation = pytest.importorskip("fmpy.validation")
description = fmpy.read_model_description
BOTH = pytest.mark.parametrize("version", ["3", "2"])
OUTPUTS = ("force", "slip", "work", "heat")
LAST = (88.14862277, 39.32710975e-3, 5.305468488, 5.089966247)
"""After 40 mm at 94.5 kPa: shared/design/interop.md, section 4, check 7."""


def made(folder: Path, version: str, brake: str = "choi2018-kapton", **options: object) -> Path:
    path = folder / f"{brake}-{version}.fmu"
    export_fmu(brake, out=path, fmi=version, **options)  # type: ignore[arg-type]
    return path


@BOTH
@pytest.mark.parametrize("brake", sorted(catalogue()))
def test_fmpy_and_fmutool_find_no_problem(tmp_path, version, brake):
    path = made(tmp_path, version, brake)
    assert validation.validate_fmu(str(path)) == []
    tool = Path(sys.executable).parent / "fmutool"
    done = subprocess.run(
        [tool, "-input", path, "-check"], capture_output=True, text=True, check=True
    )
    said = done.stdout + done.stderr
    assert f"compliant with FMI-{version}.0" in said and "No semantic error" in said


@BOTH
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_a_pull_ends_where_the_law_says(tmp_path, version, kind):
    pull = np.array(
        [(0.0, 0.0, 0.01, 94.5e3), (4.0, 0.04, 0.01, 94.5e3)],
        dtype=[(name, float) for name in ("time", "elongation", "velocity", "vacuum")],
    )
    rows = fmpy.simulate_fmu(
        str(made(tmp_path, version)),
        fmi_type=kind,
        input=pull,
        stop_time=4.0,
        output_interval=0.01,
        output=OUTPUTS,
    )
    exact = kind == "CoSimulation"
    for name, wanted in zip(OUTPUTS, LAST, strict=True):
        assert rows[name][-1] == pytest.approx(wanted, abs=1e-8 if exact else 1e-6)
    if exact:
        top = int(np.argmax(rows["force"]))
        assert rows["force"][top] == pytest.approx(175.9205338, abs=1e-7)
        assert rows["time"][top] == pytest.approx(0.15)


@BOTH
def test_the_sources_build_without_a_warning(tmp_path, version):
    path = made(tmp_path, version, sources_only=True)
    command = [sys.executable, "-m", "fmpy", "compile", path]
    command += ["--all-warnings", "--warning-as-error"]
    subprocess.run(command, check=True, capture_output=True)
    rows = fmpy.simulate_fmu(
        str(path), brake_values={"elongation": 1e-3, "vacuum": 94.5e3}, stop_time=0.1
    )
    assert rows["force"][-1] == pytest.approx(131.0, abs=1e-6)


def test_the_same_pull_from_the_command_line(tmp_path):
    """Section 4, check 7, as it stands there; the velocity column lets the brake keep up."""
    made(tmp_path, "3")
    (tmp_path / "pull.csv").write_text(
        "time,elongation,velocity,vacuum\n0,0,0.01,94500\n4,0.04,0.01,94500\n"
    )
    command = [sys.executable, "-m", "fmpy", "simulate", "choi2018-kapton-3.fmu"]
    command += ["--interface-type", "CoSimulation", "--input-file", "pull.csv"]
    command += ["--stop-time", "4", "--output-interval", "0.01", "--output-variables", *OUTPUTS]
    subprocess.run([*command, "--output-file", "out.csv"], cwd=tmp_path, check=True)
    rows = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    for name, wanted in zip(OUTPUTS, LAST, strict=True):
        assert rows[name][-1] == pytest.approx(wanted, abs=1e-8)


PULL = np.arange(1, 40) * 1e-3
"""To 39 mm, a millimetre a step."""
ENDS = (90.591778031, 38.308459710e-3)


@BOTH
def test_ecos_pulls_to_the_same_force(tmp_path, version):
    try:
        ecospy = pytest.importorskip("ecospy", reason="ecospy is not installed")
    except OSError as error:
        pytest.skip(f"ecospy does not load: {error}; Debian has libtbb12")
    with ecospy.EcosSimulationStructure() as structure:
        structure.add_model("brake", str(made(tmp_path, version)))
        structure.add_parameter_set("start", {"brake::vacuum": 94.5e3})
        with ecospy.EcosSimulation(structure=structure, step_size=1e-3) as simulation:
            simulation.init(parameter_set="start")
            for elongation in PULL:
                simulation.set_real("brake::elongation", float(elongation))
                simulation.step()
            found = [simulation.get_real(f"brake::{name}") for name in ("force", "slip")]
    assert found == pytest.approx(ENDS, abs=1e-9)


def test_osp_pulls_to_the_same_force(tmp_path):
    """libcosimpy takes FMI 2.0 alone: it crashes on every FMI 3.0 unit."""
    pytest.importorskip("libcosimpy", reason="libcosimpy is not installed")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    path = made(tmp_path, "2")
    known = {one.name: one.valueReference for one in description(path).modelVariables}
    execution = CosimExecution.from_step_size(step_size=1_000_000)
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name="brake"))
    manipulator, observer = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator=manipulator)
    execution.add_observer(observer=observer)
    inputs = [known["vacuum"], known["elongation"]]
    for elongation in PULL:
        manipulator.slave_real_values(
            slave_index=slave, variable_references=inputs, values=[94.5e3, float(elongation)]
        )
        execution.step()
    found = observer.last_real_values(
        slave_index=slave, variable_references=[known["force"], known["slip"]]
    )
    assert list(found) == pytest.approx(ENDS, abs=1e-9)
