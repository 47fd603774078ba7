"""`export mujoco`: what it writes, and that MuJoCo opens it."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from importlib.metadata import entry_points

import pytest

from layerjam.brake.kernel import compiler
from layerjam.cli.main import main
from layerjam.core.errors import CompilerError, FileError, MissingExtraError, UnknownNameError
from layerjam.interop.commands.export import export_mujoco

THERE = importlib.util.find_spec("mujoco") is not None
MUJOCO = pytest.mark.skipif(not THERE, reason="make interop installs MuJoCo")
SOURCES = ["actuator.xml", "brake.xml", "formulas.h", "joint.h", "layerjam.c", "layerjam.h"]
SOURCES.append("layerjam_mujoco.c")


def test_sources_need_neither_mujoco_nor_a_compiler(tmp_path):
    made = export_mujoco(
        "choi2018-kapton", out=tmp_path / "made", tendon="rope", vacuum_lag="2.2533s",
        rope_stiffness="16.8kN/m", no_build=True,
    )  # fmt: skip
    assert sorted(made.files) == SOURCES == sorted(p.name for p in (tmp_path / "made").iterdir())
    assert made.library is None and made.mujoco_version is None
    tree = ET.parse(tmp_path / "made" / "actuator.xml").getroot()
    keys = {one.get("key"): one.get("value") for one in tree.iter("config")}
    assert {k: float(keys[k]) for k in made.parameters} == dict(made.parameters)
    assert made.parameters["stiffness"] == pytest.approx(1 / (1 / 131e3 + 1 / 16.8e3))
    (actuator,) = tree.find("actuator")
    assert actuator.get("tendon") == "rope" and actuator.get("dyntype") == "filterexact"
    assert float(actuator.get("dynprm")) == 2.2533
    assert [float(x) for x in actuator.get("ctrlrange").split()] == [0, 101325]
    scene = ET.parse(tmp_path / "made" / "brake.xml").getroot()
    assert scene.find("tendon/spatial").get("name") == "rope"


def test_the_keys_on_the_command_line(tmp_path, capsys):
    out = str(tmp_path / "made")
    given = ["export", "mujoco", "choi2018-kapton", "--out", out, "--no-build", "--json"]
    assert main(given) == 0
    said = json.loads(capsys.readouterr().out)
    for key in ("kind", "files", "plugin", "mujoco_version", "parameters", "warnings"):
        assert key in said
    assert said["kind"] == "mujoco" and said["plugin"] == "layerjam.brake"
    assert main(given) == 2
    assert "already exists" in capsys.readouterr().err
    assert main([*given, "--overwrite"]) == 0


def test_bad_inputs_leave_nothing(tmp_path, monkeypatch):
    out = tmp_path / "made"
    with pytest.raises(UnknownNameError, match="coupling"):
        export_mujoco("choi2018-kapton", out=out, coupling="loose", no_build=True)
    if not THERE:
        with pytest.raises(MissingExtraError, match=r"\[mujoco\]"):
            export_mujoco("choi2018-kapton", out=out)
    else:
        monkeypatch.setattr(compiler, "KNOWN", ())
        monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: None)
        monkeypatch.delenv("CC", raising=False)
        with pytest.raises(CompilerError, match=r"no C compiler found.*or use --no-build"):
            export_mujoco("choi2018-kapton", out=out)
    assert not out.exists()
    out.write_text("mine")
    with pytest.raises(FileError):
        export_mujoco("choi2018-kapton", out=out, no_build=True)
    assert out.read_text() == "mine"


def test_a_brake_that_would_snap_is_said_and_strict_stops(tmp_path):
    soft = {"rope_stiffness": "1kN/m", "no_build": True}
    made = export_mujoco("choi2018-kapton", out=tmp_path / "made", **soft)
    assert [n.key for n in made.warnings if n.key == "snaps"] and made.feasible
    stopped = export_mujoco("choi2018-kapton", out=tmp_path / "strict", strict=True, **soft)
    assert not stopped.feasible and stopped.files == [] and not (tmp_path / "strict").exists()


@MUJOCO
def test_the_model_opens_and_its_library_is_the_plugin(tmp_path):
    """Also a second time: `import mujoco` loads one where layerjam is installed."""
    made = export_mujoco("choi2018-kapton", out=tmp_path / "made")
    assert made.library in made.files and made.mujoco_version
    (tmp_path / "made" / "again.so").write_bytes((tmp_path / "made" / made.library).read_bytes())
    code = (
        "import ctypes, mujoco as m\n"
        f"ctypes.CDLL('./{made.library}'), ctypes.CDLL('./again.so')\n"
        "model = m.MjModel.from_xml_path('brake.xml'); d = m.MjData(model)\n"
        "m.mj_resetDataKeyframe(model, d, 0); m.mj_step(model, d, nstep=4000)\n"
        "print(d.plugin_state[3] == 0, -d.actuator_force[0])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path / "made", capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    still, force = done.stdout.split()
    assert still == "True" and 0 <= float(force) < 30


@MUJOCO
@pytest.mark.slow
@pytest.mark.skipif(
    shutil.which("xvfb-run") is None or shutil.which("xwininfo") is None,
    reason="Debian's xvfb and x11-utils are not installed",
)
def test_the_viewer_opens_a_window_with_the_model(tmp_path):
    """The plugin comes through the entry point of the installed package; no line of code."""
    if not any(one.name == "layerjam" for one in entry_points(group="mujoco.plugins")):
        pytest.skip("layerjam is not installed: its entry point is not found")
    export_mujoco("choi2018-kapton", out=tmp_path / "made")
    script = f"""
    "{sys.executable}" -m mujoco.viewer --mjcf=brake.xml & viewer=$!
    for i in $(seq 60); do
      xwininfo -root -tree | grep -q "a layer-jamming brake" && {{ kill $viewer; exit 0; }}
      sleep 1
    done
    kill $viewer; exit 1"""
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1024x768x24", "sh", "-c", script]
    done = subprocess.run(
        screen, cwd=tmp_path / "made", capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
