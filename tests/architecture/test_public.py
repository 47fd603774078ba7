"""What `import layerjam as lj` offers: names that resolve, hide no folder, and have types."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import layerjam
from layerjam.commands.index import commands

HOME = Path(layerjam.__file__).parent
SCRIPT = """
import layerjam as lj

stop = lj.drop("choi2018-kapton", mass="1 kg", speed=2.5, vacuum="tuned", travel="40 mm")
reveal_type(stop)
reveal_type(stop.peak_force)
reveal_type(lj.force("choi2018-kapton", slip=[0.0, 0.02], vacuum="90 kPa").force)
reveal_type(lj.load("choi2018-kapton").brake.sheets.width)
reveal_type(lj.load("choi2018-kapton").with_(width="14 mm"))
reveal_type(stop.warnings)
reveal_type(stop.plot())
lj.drop("choi2018-kapton", mass=[1.0], speed=2.5)
lj.drop("choi2018-kapton", weight="1 kg")
stop.peak_farce
"""
REVEALED = (
    "layerjam.commands.impact.Stop",
    "float | None",
    "float",
    "float",
    "layerjam.device.file.BrakeFile",
    "Sequence[str]",
    "matplotlib.figure.Figure",
)
WRONG = ("[arg-type]", "[call-arg]", "[attr-defined]")


def test_every_public_name_can_be_had() -> None:
    assert len(layerjam.__all__) == len(set(layerjam.__all__)) > 40
    for name in layerjam.__all__:
        assert getattr(layerjam, name) is not None
    assert dir(layerjam) == sorted(layerjam.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = layerjam.nonsense


def test_no_name_hides_a_folder() -> None:
    import layerjam.report.style as style

    folders = {path.name for path in HOME.iterdir() if path.is_dir()}
    assert not folders & set(layerjam.__all__)
    assert style.__name__ == "layerjam.report.style"
    # what was typed before goes on working
    for name in ("design", "lab", "report"):
        assert callable(getattr(layerjam, name))


def test_every_command_is_a_public_function() -> None:
    functions = {entry.python_name for entry in commands().values()}
    known = {layerjam._WHERE[name][1] for name in layerjam.__all__}
    assert functions - known <= {"workbench", "schema"}
    for name in ("brake_force", "peak", "energy_capacity", "sleeve_mass", "parse_procedure"):
        assert callable(getattr(layerjam, name)), name


def test_a_users_script_is_typed(tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--cache-dir", str(tmp_path / "cache"), "script.py"],
        cwd=tmp_path, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    notes = [line for line in done.stdout.splitlines() if "Revealed type" in line]
    assert len(notes) == len(REVEALED), done.stdout
    for note, expected in zip(notes, REVEALED, strict=True):
        assert expected in note, note
    errors = [line for line in done.stdout.splitlines() if "error:" in line]
    assert len(errors) == len(WRONG), done.stdout
    for line, expected in zip(errors, WRONG, strict=True):
        assert expected in line, line
