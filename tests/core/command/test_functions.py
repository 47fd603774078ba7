"""The functions behind the commands: same names, text or SI numbers, one answer."""

from __future__ import annotations

import inspect
import pydoc
from dataclasses import FrozenInstanceError, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

import layerjam
from laboratory.campaigns import bench as virtual
from layerjam.brake.commands import tensile
from layerjam.brake.commands.arguments import check_vacuum, convert_brake, slip_notices
from layerjam.brake.device.load import load
from layerjam.brake.simulate.procedure import parse_procedure, simple_pull
from layerjam.core.errors import FileError, FitError, LayerjamError, ProcedureError, QuantityError
from layerjam.laboratory.commands import calibration, friction, validation
from strategies import one, points, random_brakes, seeds

KAPTON = load("choi2018-kapton")


def test_text_and_si_numbers_and_files_say_the_same() -> None:
    text = layerjam.force("choi2018-kapton", slip="20 mm", vacuum="94.5 kPa")
    number = layerjam.force(KAPTON, slip=0.020, vacuum=94.5e3)
    assert dict(text.values) == dict(number.values)
    assert f"{text.force:.6f}" == "133.942755"
    assert text.units["force"] == "N" and text.warnings == []
    assert text.record[1:] == (94.5e3, 0.020)


def test_an_answer_knows_its_keys() -> None:
    answer = layerjam.vacuum(KAPTON, slip=0.02, force=100)
    assert answer.feasible is True and answer.reason is None and answer.vacuum > 0
    with pytest.raises(AttributeError, match="vacum"):
        _ = answer.vacum
    with pytest.raises(FrozenInstanceError):
        answer.warnings = ()


def test_cannot_is_an_answer() -> None:
    for force, words in ((0.1, "enclosure alone"), (1e6, "at most")):
        answer = layerjam.vacuum(KAPTON, slip=0.02, force=force)
        assert answer.feasible is False and answer.vacuum is None and words in answer.reason
    edge = layerjam.vacuum(KAPTON, slip=0.02, force=0.0)
    assert edge.feasible is False
    most = layerjam.vacuum(KAPTON, slip=0.02, force=edge.greatest_force)
    assert most.feasible is True and most.vacuum == pytest.approx(101325.0, rel=1e-12)
    least = layerjam.vacuum(KAPTON, slip=0.02, force=edge.least_force)
    assert least.feasible is True and least.vacuum == pytest.approx(0.0, abs=1e-9)


@given(seeds)
@settings(max_examples=30)
def test_the_inverse_inverts_on_random_brakes(seed: int) -> None:
    brakes = random_brakes(seed, 1)
    slip, vacuum = (float(v[0]) for v in points(seed, brakes))
    file = replace(KAPTON, brake=one(brakes, 0))
    force = layerjam.force(file, slip=slip, vacuum=vacuum).force
    answer = layerjam.vacuum(file, slip=slip, force=force)
    assert answer.feasible is True and answer.vacuum == pytest.approx(vacuum, rel=1e-9)


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -1.0, "nan mm", "1", "1 kPa", None])
def test_bad_numbers_are_refused_in_python_too(bad: Any) -> None:
    with pytest.raises((QuantityError, TypeError)) as raised:
        layerjam.force(KAPTON, slip=bad, vacuum=94.5e3)
    assert "\n" not in str(raised.value)


def test_bounds() -> None:
    with pytest.raises(QuantityError, match="beyond the overlap of 68 mm"):
        slip_notices(0.0681, KAPTON.brake)
    assert slip_notices(0.068, KAPTON.brake) and not slip_notices(0.06, KAPTON.brake)
    assert check_vacuum(101325, KAPTON.brake) == 101325.0
    with pytest.raises(QuantityError, match=r"101\.326 kPa exceeds atmospheric pressure, 101\.325"):
        check_vacuum(101326.0, KAPTON.brake)
    from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED as SPEED

    assert SPEED.si("13 mm/s", "speed") == 0.013 == SPEED.si(0.013, "speed")
    with pytest.raises(QuantityError, match="speed"):
        SPEED.si(0.0, "speed")


def test_another_site() -> None:
    assert convert_brake(KAPTON, None) is KAPTON
    high = convert_brake("choi2018-kapton", "80 kPa")
    assert high.brake.site.atmosphere == 80e3 and high.brake.sheets == KAPTON.brake.sheets
    with pytest.raises(QuantityError, match="exceeds atmospheric pressure, 80 kPa"):
        layerjam.force(KAPTON, slip=0.02, vacuum=94.5e3, atmosphere=80e3)
    assert layerjam.show(KAPTON, atmosphere=50e3).max_force < layerjam.show(KAPTON).max_force / 1.9


def test_tensile_takes_steps_text_or_three_numbers() -> None:
    steps = simple_pull(94.5e3, 0.013, 0.04)
    answers = [
        layerjam.tensile(KAPTON, procedure=steps),
        layerjam.tensile(KAPTON, procedure=steps.text()),
        layerjam.tensile(KAPTON, vacuum="94.5 kPa", speed=0.013, travel="4 cm"),
    ]
    assert answers[0] == answers[1] == answers[2]
    assert answers[0].record.procedure == steps.text()
    assert answers[0].peak_force == answers[0].record.force.max()
    for bad in ({}, {"vacuum": 1e4}, {"vacuum": 1e4, "speed": 1e-3}):
        with pytest.raises(ProcedureError, match="missing"):
            layerjam.tensile(KAPTON, **bad)
    with pytest.raises(ProcedureError, match="not both"):
        layerjam.tensile(KAPTON, vacuum=1e4, procedure=steps)
    with pytest.raises(LayerjamError, match="unknown model 'magic'"):
        layerjam.tensile(KAPTON, procedure=steps, model="magic")


def test_show_warns_of_what_the_numbers_show(tmp_path: Path) -> None:
    weak = replace(
        KAPTON, brake=replace(KAPTON.brake, film=replace(KAPTON.brake.film, strength=1e6))
    )
    assert any("exceeds the film's strength" in w for w in layerjam.show(weak).warnings)
    # nobody sells Kapton HN as thick as the paper's
    assert [w.key for w in layerjam.show(KAPTON).warnings] == ["film-gauge"]
    slippery = replace(KAPTON, brake=replace(KAPTON.brake, scale_factor=0.005))
    assert any("has no peak" in w for w in layerjam.show(slippery).warnings)
    unmeasured = replace(KAPTON, brake=replace(KAPTON.brake, stiffness_measured=None))
    shown = layerjam.show(unmeasured)
    assert shown.stiffness_measured is None and shown.stiffness_mount is None
    assert any("no stiffness was measured" in w for w in shown.warnings)


def measured(folder: Path, name: str = "pull.csv", **more: Any) -> Path:
    machine = virtual.Machine(sampling_rate=500.0, load_cell_noise=0.1, seed=9)
    trace = virtual.pull(KAPTON.brake, 94.5e3, 0.013, 0.04, machine, **more)
    return virtual.write_own(trace, folder / name)


def test_the_lab_in_python(tmp_path: Path) -> None:
    path = measured(tmp_path)
    answer = layerjam.calibrate("choi2018-kapton", [path], out=tmp_path / "mine.toml")
    assert answer.file == str(tmp_path / "mine.toml")
    assert layerjam.load(tmp_path / "mine.toml").brake.scale_factor == answer.scale_factor
    assert answer.record[1].scale_factor == answer.scale_factor
    with pytest.raises(FileError, match="already exists"):
        layerjam.calibrate("choi2018-kapton", [path], out=tmp_path / "mine.toml")
    checked = layerjam.validate(tmp_path / "mine.toml", [str(path)])
    assert any("also used to calibrate this brake" in w for w in checked.warnings)
    other = measured(tmp_path, "other.csv", repeat=2)
    assert not any(
        "for calibration" in w for w in layerjam.validate(tmp_path / "mine.toml", [other]).warnings
    )


def test_what_made_the_brake_stands_in_its_file(tmp_path: Path) -> None:
    path = measured(tmp_path)
    own = tmp_path / "own.toml"
    own.write_bytes(f"# my own words\n{KAPTON.text}".encode())
    layerjam.calibrate(own, [path], out=tmp_path / "mine.toml")
    file = layerjam.load(tmp_path / "mine.toml")
    assert file.notes["files"][0]["name"] == "pull.csv"
    assert len(file.notes["files"][0]["sha256"]) == 64
    assert (
        file.notes["program"].startswith("layerjam ") and "one pull only" in file.notes["verdict"]
    )
    assert file.sources["scale_factor"].kind == "synthetic"
    assert "pull.csv" in file.sources["stiffness_measured"].text
    assert file.sources["scale_factor"].spread.startswith("standard error ")
    # its comments and all other numbers are the old ones
    assert file.text.startswith("# my own words\n")
    assert file.brake.sheets == KAPTON.brake.sheets and file.brake.film == KAPTON.brake.film


def test_refused_files_are_told_apart_from_used_ones(tmp_path: Path) -> None:
    good, bad = measured(tmp_path), tmp_path / "bad.csv"
    bad.write_text("nothing")
    answer = layerjam.calibrate("choi2018-kapton", [bad, good], out=tmp_path / "x.toml")
    assert list(answer.refused) == [str(bad)] and answer.file is None
    assert not (tmp_path / "x.toml").exists()
    assert layerjam.calibrate(
        "choi2018-kapton", [bad, good], out=tmp_path / "x.toml", partial=True
    ).file
    for nothing in ([], ()):
        with pytest.raises(FitError, match="no file was given"):
            layerjam.validate("choi2018-kapton", nothing)
    with pytest.raises(FileError, match=r"bad\.csv"):
        layerjam.validate("choi2018-kapton", [bad])


def test_friction_in_python(tmp_path: Path) -> None:
    machine = virtual.Machine(sampling_rate=25.0, load_cell_noise=0.002, seed=3)
    trace = virtual.friction(0.32, 0.24, 2.45, machine=machine, string_stiffness=30.0)
    path = virtual.write_bluehill(trace, tmp_path / "sled.csv")
    answer = layerjam.friction([path])
    assert answer.kinetic == pytest.approx(0.24, rel=0.01) and answer.static_sd is None
    same = layerjam.friction([path], normal_force="2.45 N", start="40 mm", end=0.1)
    assert same.kinetic == answer.kinetic
    with pytest.raises(QuantityError, match="both"):
        layerjam.friction([path], brake="choi2018-kapton")
    with pytest.raises(LayerjamError, match="from"):
        layerjam.friction([path], start=0.1, end=0.04)


def test_new_in_python(tmp_path: Path) -> None:
    answer = layerjam.new("mine", "choi2018-ptfe", tmp_path / "mine.toml")
    assert answer.file == str(tmp_path / "mine.toml")
    with pytest.raises(FileError, match="already exists"):
        layerjam.new("mine", "choi2018-ptfe", tmp_path / "mine.toml")
    layerjam.new("other", "choi2018-kapton", tmp_path / "mine.toml", overwrite=True)
    assert layerjam.load(tmp_path / "mine.toml").name == "other"


def test_arrays_broadcast() -> None:
    slip, vacuum = np.array([0.01, 0.02]), np.array([[50e3], [94.5e3]])
    found = layerjam.force(KAPTON, slip=slip, vacuum=vacuum)
    assert found.force.shape == (2, 2)
    for i, j in np.ndindex(2, 2):
        alone = layerjam.force(KAPTON, slip=slip[j], vacuum=vacuum[i, 0])
        assert found.force[i, j] == pytest.approx(alone.force, rel=1e-14)
    back = layerjam.vacuum(KAPTON, slip=slip, force=found.force)
    assert back.vacuum == pytest.approx(np.broadcast_to(vacuum, (2, 2)), rel=1e-12)
    with pytest.raises(QuantityError, match="beyond the overlap"):
        layerjam.force(KAPTON, slip=[0.01, 0.07], vacuum=94.5e3)
    assert parse_procedure("vent").text() == "vent"


def _pull_csv(path: Path, scale: float = 1.0) -> Path:
    trace = virtual.pull(KAPTON.brake, 94.5e3, 13e-3, 40e-3, virtual.Machine(sampling_rate=500.0))
    rows = zip(trace.elongation * 1e3 * scale, trace.force, strict=True)
    lines = ["Extension (mm),Load (N)", *(f"{u!r},{f!r}" for u, f in np.array(list(rows)).tolist())]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_the_same_measurement_counts_once(tmp_path: Path) -> None:
    """A copy is no repeat: its scatter would be a false zero."""
    first = _pull_csv(tmp_path / "one.csv")
    copy = tmp_path / "two.csv"
    copy.write_bytes(first.read_bytes())
    answer = calibration.calibrate(KAPTON, [first, copy], vacuum=94.5e3)
    assert "same measurement" in answer.refused[str(copy)]
    assert "one pull" in answer.standard_errors["rests_on"]


def test_a_pull_far_beyond_the_overlap_has_the_wrong_unit(tmp_path: Path) -> None:
    path = _pull_csv(tmp_path / "metres.csv", scale=1000.0)
    for use in (calibration.calibrate, validation.validate):
        with pytest.raises(
            FileError, match=r"pulls to \d+\.?\d* m, but the sheets overlap by only 68 mm"
        ):
            use(KAPTON, [path], vacuum=94.5e3)


def test_our_own_simulated_pull_brings_its_vacuum(tmp_path: Path) -> None:
    out = tmp_path / "pull.csv"
    answer = tensile.tensile(KAPTON, vacuum="40 kPa", speed="13 mm/s", travel="40 mm")
    answer.record.save(out)
    fitted = calibration.calibrate(KAPTON, [out])
    assert fitted.scale_factor == pytest.approx(0.875, rel=1e-6)
    clash = calibration.calibrate(KAPTON, [out], vacuum="94.5 kPa")
    assert any("overrides --vacuum" in w for w in clash.warnings)


def test_an_unlikely_friction_is_said(tmp_path: Path) -> None:
    machine = virtual.Machine(sampling_rate=25.0, load_cell_noise=0.002, load_cell_range=10.0)
    trace = virtual.friction(0.32, 0.24, 2.45, machine=machine, string_stiffness=30.0)
    path = virtual.write_bluehill(trace, tmp_path / "sled.csv")
    answer = friction.friction([path], normal_force="245 N")
    assert "usual range for films" in {r["name"]: r["reason"] for r in answer.failed_checks}["film"]


def public_commands() -> list[str]:
    return [name for name in dir(layerjam) if hasattr(getattr(layerjam, name), "declaration")]


def test_help_begins_with_a_short_signature_and_lists_parameters() -> None:
    for name in public_commands():
        function = getattr(layerjam, name)
        head = str(inspect.signature(function))
        assert len(head) <= 500 and "Annotated" not in head, name
        text = pydoc.plain(pydoc.render_doc(function))
        for p in function.declaration.parameters:
            if p.name != "progress":
                unit = f" [{p.spec.unit}]" if p.spec and p.spec.unit != "1" else ""
                assert f"\n        {p.name}{unit}: " in text, (name, p.name)
    drop = pydoc.plain(pydoc.render_doc(layerjam.drop))
    assert "mass [kg]: Moving mass, e.g. 1kg." in drop
    assert "horizontal: Ignore gravity along the pull. Default False." in drop


def test_laws_and_internal_members_are_hidden_but_work() -> None:
    laws = {n for n in dir(layerjam.laws) if not n.startswith("_")}
    assert not (laws - {"layerjam", "Stribeck"}) & {*dir(layerjam)}
    assert layerjam.stop is layerjam.laws.stop and layerjam.peak is layerjam.laws.peak
    result = layerjam.force(KAPTON, slip=0.02, vacuum=5e4)
    listed = {n for n in dir(result) if not n.startswith("_")}
    assert listed == {
        *result.values, "record", "warnings", "verdict", "failed_checks", "accepted", "exit_code",
        "values", "units", "require", "interval", "table", "json", "save", "plot", "to_frame",
        "to_xarray",
    }  # fmt: skip
    assert result.with_notices() is result
