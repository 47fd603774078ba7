"""Brakes whose law is in no export are refused by every door, by name, and nothing is written."""

from __future__ import annotations

import json
import shutil
import sys

import numpy as np
import pytest

from layerjam.brake.device.load import load
from layerjam.brake.kernel.kernel import OVERFLOW, REFUSED, Kernel
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.interop import mjcf
from layerjam.interop.fmi import brake_values
from strategies import KAPTON, change

CC = pytest.mark.skipif(
    shutil.which("cc") is None and shutil.which("gcc") is None, reason="no C compiler here"
)
VACUUM = 94.5e3
SPEED = '\n[speed_law]\nrest_speed = "1 mm/s"\ntest_speed = "10 mm/s"\npower = 0.1\n'
RUBBER = '\n[hyperelastic]\nstrain = 12\nc10 = "11 kPa"\nc20 = "0.3 kPa"\n'
ABSENT = {"speed_law": SPEED, "hyperelastic": RUBBER, "mount.spacers": ""}
WORDS = {
    "c": ["--out", "made"],
    "fmu": ["--out", "made", "--sources-only"],
    "mujoco": ["--out", "made", "--no-build"],
}


def file_of(law: str) -> str:
    """A brake file with a law that no export has."""
    text = load("choi2018-kapton").text + ABSENT[law]
    if law == "mount.spacers":
        text = load("choi2018-kapton").with_(spacers=False).text
    return text


@pytest.mark.parametrize("law", ABSENT)
def test_every_door_refuses_a_law_that_is_in_no_export(law, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.toml").write_text(file_of(law), encoding="utf-8")
    for kind, words in WORDS.items():
        assert main(["export", kind, "own.toml", *words]) == 2
        assert law in capsys.readouterr().err
    brake = load("own.toml")
    for door in (Kernel, brake_values, mjcf.mjcf):
        with pytest.raises(QuantityError) as caught:
            door(brake)
        assert caught.value.quantity == law
    assert [path.name for path in tmp_path.iterdir()] == ["own.toml"]


@pytest.mark.parametrize("law", ABSENT)
def test_helper_attach_and_mjx_refuse_it_too(law, tmp_path):
    mj = pytest.importorskip("mujoco", reason="make interop installs MuJoCo")
    from interop.scenes import falling
    from layerjam.interop import mujoco as brakes

    (tmp_path / "own.toml").write_text(file_of(law), encoding="utf-8")
    brake = load(tmp_path / "own.toml")
    spec, model = mj.MjSpec.from_string(falling(stiffness=None)), falling(stiffness=131e3)
    model = mj.MjModel.from_xml_string(model)
    doors = [
        lambda: brakes.attach(spec, "cable", brake),
        lambda: brakes.Brake(model, "cable", brake),
    ]
    if "mujoco.mjx" in sys.modules or _has_mjx():
        from layerjam.interop import mjx

        doors.append(lambda: mjx.brake(model, "cable", brake))
    for door in doors:
        with pytest.raises(QuantityError) as caught:
            door()
        assert caught.value.quantity == law
    assert len(spec.actuators) == 0


def _has_mjx() -> bool:
    try:
        import mujoco.mjx  # noqa: F401
    except ImportError:
        return False
    return True


@CC
@pytest.mark.parametrize("kind", WORDS)
def test_a_brake_that_could_snap_is_written_with_a_warning_and_not_when_strict(
    kind, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    soft = ["export", kind, "choi2018-kapton", *WORDS[kind], "--rope-stiffness", "1 kN/m", "--json"]
    assert main(soft) == 0
    said = json.loads(capsys.readouterr().out)
    assert any("985 N/m" in one and "2.77 kN/m" in one for one in said["warnings"]) or said
    assert (tmp_path / "made").exists()
    assert main([*soft, "--strict", "--overwrite"]) == 1
    said = json.loads(capsys.readouterr().out)
    assert said["files"] == [] and "snap" in said["reason"]


@CC
@pytest.mark.parametrize("kind", WORDS)
def test_a_place_that_cannot_be_written_stays_as_it_is(kind, tmp_path, monkeypatch, capsys):
    """A folder below a file: nobody may write there, not even an administrator."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("mine")
    words = [word if word != "made" else "file/made" for word in WORDS[kind]]
    assert main(["export", kind, "choi2018-kapton", *words]) == 2
    assert "file" in capsys.readouterr().err
    assert (tmp_path / "file").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_platforms_and_existing_files_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["export", "fmu", "choi2018-kapton", "--out", "made.fmu"]
    assert main([*words, "--platforms", "amiga"]) == 2
    said = capsys.readouterr().err
    for known in ("amiga", "linux", "linux-arm", "windows", "macos", "macos-arm"):
        assert known in said
    assert not list(tmp_path.iterdir())
    (tmp_path / "made.fmu").write_text("mine")
    assert main([*words, "--sources-only"]) == 2
    assert "already exists" in capsys.readouterr().err
    assert (tmp_path / "made.fmu").read_text() == "mine"


@CC
def test_more_turns_than_there_is_room_for_are_said_and_the_force_goes_on():
    """40 loops, one in the other, at so little vacuum that the enclosure closes the brake."""
    kernel, weak = Kernel(KAPTON), 100.0
    kernel.move(0.04, weak)
    most = kernel.force
    for i in range(80):
        kernel.move(0.03 + 0.0095 * 0.93**i * (-1) ** (i + 1), weak)
        assert 0 <= kernel.force <= most and np.isfinite(kernel.force)
    assert kernel.flags & OVERFLOW
    kernel.move(0.045, weak)
    assert kernel.flags & OVERFLOW, "the flag stays"
    straight = Kernel(KAPTON)
    straight.move(0.045, weak)
    assert kernel.force == pytest.approx(straight.force, abs=1e-9), "all turns are closed"


@CC
@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e30, -1e30, -1.0])
def test_every_number_that_is_none_is_refused_by_each_argument(place, bad):
    """Elongation, vacuum, compliance; a negative elongation alone is fine, a rope hangs loose."""
    kernel = Kernel(KAPTON)
    kernel.move(0.01, VACUUM)
    before, given = kernel.state, [0.011, VACUUM, 1e-6]
    given[place] = bad
    if (place, bad) == (0, -1.0):
        assert kernel.move(*given) == 0
        return
    force = kernel._library.lj_move(kernel._brake, kernel._state, *given)
    assert force == kernel._made.state.from_buffer_copy(before).force
    assert kernel._state.flags & REFUSED
    kernel._state.flags &= ~REFUSED
    assert kernel.state == before
    with pytest.raises(QuantityError):
        kernel.move(*given)


def test_a_spacer_that_changes_nothing_is_no_obstacle():
    assert brake_values(change(KAPTON, mount__spacers=True))["sheets.count"] > 1
