"""A file that a program wrote stays known as one in everything that is made from it."""

from __future__ import annotations

import dataclasses
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.commands.force import force
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import force_at_elongation
from layerjam.core.command.results import Result
from layerjam.core.errors import QuantityError
from layerjam.interop.commands.export import export_c, export_fmu, export_mujoco
from layerjam.laboratory.campaigns.exports import ENCODINGS, LANGUAGES, LAYOUTS, Form, encode_file
from layerjam.laboratory.commands.calibration import calibrate
from layerjam.laboratory.commands.crash import crash
from layerjam.laboratory.commands.enclosure import enclosure
from layerjam.laboratory.commands.friction import FrictionTest, friction
from layerjam.laboratory.commands.leak import leak
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import Facts
from layerjam.laboratory.measure.trace import Trace
from layerjam.workshop.commands.show import show

WORD = b"SYNTHETIC"
FRICTION = FrictionTest(normal_force="2.45 N")
KAPTON = load("choi2018-kapton")


def pull(brake: Brake = KAPTON.brake) -> Trace:
    """A pull to 20 mm at 94.5 kPa by the law itself, with a little noise."""
    u = np.linspace(0, 0.02, 1500)
    noise = np.random.default_rng(7).normal(0, 0.05, u.size)
    f = np.asarray(force_at_elongation(u, 94.5e3, brake)) + noise
    facts = Facts(seed=7, repeat=1, speed=0.001)
    return Trace(f, u, u / 0.001, "pull", "made here", facts=facts)


def pulled(brake: BrakeFile) -> Result:
    """The same as `tensile` computes it."""
    return tensile(brake, vacuum="94.5 kPa", speed="1 mm/s", travel="20 mm")


def sled() -> Trace:
    """A friction test: 0.32 to break away, then 0.24, under 2.45 N."""
    u = np.linspace(0, 0.11, 1200)
    f = 2.45 * np.where(u < 0.002, 0.32 * u / 0.002, 0.24)
    f = f + np.random.default_rng(3).normal(0, 1e-3, u.size)
    return Trace(f, u, u / 0.0025, "sled", "made here", facts=Facts(seed=3, repeat=1))


def alone(folder: Path, trace: Trace, synthetic: bool = True) -> Path:
    """Its file without a sidecar; as if measured, without the word."""
    data = encode_file(trace, Form(layout="bluehill"))
    assert WORD in data
    path = folder / f"{trace.path}-{'made' if synthetic else 'measured'}.csv"
    path.write_bytes(data if synthetic else data.replace(WORD, b"operator A,"))
    return path


def keys(found: Result) -> set[str]:
    """What a result says, by key."""
    return {getattr(w, "key", "") for w in found.warnings}


def forms() -> Iterator[Form]:
    """Every form in which the virtual laboratory writes a file."""
    for layout, made in LAYOUTS.items():
        if made.fixed:
            yield Form(layout=layout)
            continue
        of = [(language, "usual") for language in LANGUAGES] + [("en", e) for e in ENCODINGS]
        for language, encoding in of:
            form = Form(layout=layout, language=language, encoding=encoding)
            try:
                form.check_encoding()
            except QuantityError:
                continue
            yield form


def test_every_layout_says_so_in_its_own_words(tmp_path: Path) -> None:
    u = np.linspace(0, 0.02, 60)
    short = Trace(9e3 * u * (1 - 20 * u), u, u / 0.001, "short", "", facts=Facts(seed=1, repeat=1))
    made = list(forms())
    assert len(made) > 40
    for number, form in enumerate(made):
        path = tmp_path / f"{number}{form.details.ending}"
        path.write_bytes(encode_file(short, form))
        assert read_trace(path).synthetic, form


@pytest.mark.slow
def test_what_a_simulation_wrote_is_no_measurement(tmp_path: Path) -> None:
    path = pulled(KAPTON).save(tmp_path / "pull.csv")
    assert read_trace(path).synthetic
    found = calibrate(KAPTON, path, out=tmp_path / "again.toml")
    assert "synthetic" in keys(found)
    assert load(tmp_path / "again.toml").synthetic


@pytest.fixture
def chain(tmp_path: Path) -> tuple[BrakeFile, BrakeFile]:
    """A brake with synthetic friction, and the same calibrated on a pull that counts as measured.

    The second command writes another [made_by] than the first.
    """
    tested, fitted = tmp_path / "tested.toml", tmp_path / "fitted.toml"
    friction(alone(tmp_path, sled()), test=FRICTION, brake="choi2018-kapton", out=tested)
    calibrate(tested, alone(tmp_path, pull(), False), vacuum="94.5 kPa", out=fitted)
    return load(tested), load(fitted)


def test_the_numbers_carry_the_mark_past_the_next_command(
    chain: tuple[BrakeFile, BrakeFile],
) -> None:
    tested, fitted = chain
    both = ["film.static", "film.kinetic"]
    assert tested.synthetic == both
    assert tested.notes["files"][0]["synthetic"] is True
    assert fitted.synthetic == both
    assert fitted.sources["scale_factor"].kind == "calibrated"
    assert "synthetic" not in fitted.notes["files"][0]
    for file in chain:
        said = [w for w in file.warnings() if getattr(w, "key", "") == "synthetic-brake"]
        assert len(said) == 1
        assert all(path in said[0] for path in both)
    # what is found anew is not spoken of
    assert not fitted.synthetic_mark(without=both)


def test_a_calibration_on_synthetic_pulls_marks_what_it_found(tmp_path: Path) -> None:
    out = tmp_path / "fitted.toml"
    calibrate(KAPTON, alone(tmp_path, pull()), vacuum="94.5 kPa", out=out)
    assert set(load(out).synthetic) == {"scale_factor", "stiffness_measured"}
    calibrate(out, alone(tmp_path, pull(), False), vacuum="94.5 kPa", out=out, overwrite=True)
    assert load(out).synthetic == []


def test_what_is_computed_and_exported_says_so(
    chain: tuple[BrakeFile, BrakeFile], tmp_path: Path
) -> None:
    brake = chain[1]
    for found in (show(brake), force(brake, slip="10 mm", vacuum="50 kPa")):
        assert "synthetic-brake" in keys(found)
    assert 'kind = "synthetic"' in brake.render("again")  # above the columns of every simulation
    mark = "film.kinetic of fitted: synthetic"
    export_c(brake, out=tmp_path / "c")
    export_mujoco(brake, out=tmp_path / "mujoco", no_build=True)
    for name in ("c/brake.h", "mujoco/actuator.xml"):
        assert mark in (tmp_path / name).read_text(encoding="utf-8"), name
    for version in ("2", "3"):
        out = tmp_path / f"brake{version}.fmu"
        export_fmu(brake, out=out, fmi=version, sources_only=True)
        with zipfile.ZipFile(out) as archive:
            assert mark in archive.read("modelDescription.xml").decode()
    export_c(KAPTON, out=tmp_path / "own")
    assert "synthetic" not in (tmp_path / "own/brake.h").read_text(encoding="utf-8")


def table(path: Path, head: str, *columns: np.ndarray) -> Path:
    """A log."""
    rows = (",".join(map(repr, row)) for row in np.column_stack(columns).tolist())
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return path


def logs(folder: Path, said: str) -> dict[str, Result]:
    """`leak`, `crash` and `enclosure` of logs with this above their columns."""
    t = np.arange(0, 200, 1.0)
    held = table(
        folder / "hold.csv",
        f"{said}time [s],vacuum [kPa]",
        t,
        90 * np.exp(-t / 900) + 1e-3 * (t % 7),
    )
    clock = np.arange(0, 0.2, 1e-4)
    pulse = np.where((clock > 0.1) & (clock < 0.12), 50 * np.sin(np.pi * (clock - 0.1) / 0.02), 0.0)
    hit = table(folder / "hit.csv", f"{said}time [s],acceleration [m/s^2]", clock, pulse)
    strain = np.linspace(0.01, 3, 300)
    stress = 6e4 * (strain + 1 - (strain + 1) ** -2)
    drawn = table(folder / "drawn.csv", f"{said}Strain [1],Stress [Pa]", strain, stress)
    options = {"brake": "choi2018-kapton", "out": folder / "sleeve.toml", "overwrite": True}
    return {
        "leak": leak(held, volume="100 mL"),
        "crash": crash(hit),
        "enclosure": enclosure(drawn, **options),
    }


@pytest.mark.parametrize("how", ["head", "sidecar", "measured"])
def test_logs(tmp_path: Path, how: str) -> None:
    if how == "sidecar":
        for name in ("hold", "hit", "drawn"):
            (tmp_path / f"{name}.csv.toml").write_text("synthetic = true\n", encoding="utf-8")
    found = logs(tmp_path, "# SYNTHETIC, made here\n" if how == "head" else "")
    synthetic = how != "measured"
    for name, one in found.items():
        assert ("synthetic" in keys(one)) is synthetic, name
        said = json.loads(one.json())["warnings"]
        assert any(w.startswith("synthetic") for w in said) is synthetic
        words = [text.get_text() for text in one.draw().texts]
        assert ("synthetic data" in words) is synthetic
    brake = load(tmp_path / "sleeve.toml")
    assert brake.synthetic == ["enclosure.modulus"] * synthetic
    assert brake.sources["enclosure.modulus"].kind == ("synthetic" if synthetic else "measured")


def test_only_what_was_found_changes_its_kind() -> None:
    source = KAPTON.sources["scale_factor"]
    for kind, after in (("measured", "synthetic"), ("assumed", "assumed"), ("paper", "paper")):
        assert dataclasses.replace(source, kind=kind).to_synthetic().kind == after
