"""What an attacker found once stays mended."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from layerjam.brake.commands import drop as drop_command
from layerjam.brake.commands import force as force_command
from layerjam.brake.commands import tensile, tuning
from layerjam.brake.device.load import load
from layerjam.cli.main import main
from links import link


@pytest.mark.parametrize("travel", ["80 mm", "200 mm", "10 m"])
@pytest.mark.parametrize("vacuum", [500.0, 3335.0, 50e3, 94.5e3])
def test_separation_does_not_depend_on_the_travel_asked_for(vacuum: float, travel: str) -> None:
    for name in ("choi2018-kapton", "choi2018-ptfe"):
        pulled = tensile.tensile(name, vacuum=vacuum, speed="13 mm/s", travel=travel)
        alone = force_command.force(name, slip="68 mm", vacuum=vacuum).force
        assert pulled.outcome == "SEPARATED"
        assert pulled.force_at_end == pytest.approx(alone, rel=1e-9)
        assert any("the sheets separated" in w for w in pulled.warnings)


def test_a_tuned_vacuum_stops_where_it_says_or_is_refused() -> None:
    case: dict[str, Any] = {"mass": "2.26 kg", "speed": "0.3118 m/s", "travel": "3.84 mm"}
    soft = tuning.tune("choi2018-kapton", **case, rope_stiffness="10 N/m")
    assert soft.feasible is False and "soft" in soft.reason
    firm = drop_command.drop("choi2018-kapton", **case, vacuum="tuned", rope_stiffness="200 kN/m")
    assert firm.outcome == "STOPPED" and firm.slip == pytest.approx(3.84e-3, rel=1e-6)


def test_without_gravity_there_is_no_multiple_of_it(tmp_path: Path) -> None:
    path = tmp_path / "space.toml"
    path.write_text(load("choi2018-kapton").text + '\n[site]\ngravity = "0 m/s^2"\n')
    answer = drop_command.drop(str(path), mass="1 kg", speed="1 m/s", vacuum="50 kPa")
    assert answer.peak_g is None and answer.peak_force > 0
    assert tuning.tune(str(path), mass="1 kg", speed="2 m/s", travel="40 mm").floor_g is None


def test_pipes_and_folders_do_not_hang_or_lose_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.toml")
    assert main(["show", str(tmp_path / "pipe.toml")]) == 2
    (tmp_path / "taken.svg").mkdir()
    words = ["tensile", "choi2018-kapton", "--vacuum", "9kPa", "--speed", "1mm/s", "--elongation"]
    words += ["20mm", "--out", str(tmp_path / "z.csv"), "--figure", str(tmp_path / "taken.svg")]
    assert main([*words, "--overwrite"]) == 2
    assert not (tmp_path / "z.csv").exists()
    assert main(["new", "x", "--from", "choi2018-ptfe", "--out", str(tmp_path / "y") * 99]) == 2
    gone = tmp_path / "gone.toml"
    if not link(gone, tmp_path / "nowhere.toml"):
        gone.touch()
    assert main(["new", "x", "--from", "choi2018-ptfe", "--out", str(gone)]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and len(shown.err.strip().splitlines()) == 4


def test_a_key_of_thousands_of_parts_is_refused_at_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bomb.toml"
    path.write_text(".".join(["a"] * 100_000) + " = 1\n")
    assert main(["show", str(path)]) == 2
    assert "line 1: has a line with more than 300 dots" in capsys.readouterr().err
    path.write_text('name = "x"\nnote = "\\u001b[31mred"\nwidth = 0.254 mm\n')
    assert main(["show", str(path)]) == 2
    assert "put a quantity in quotes" in capsys.readouterr().err


@pytest.mark.slow
def test_a_stack_on_a_soft_rig_snaps_as_the_lumped_brake_does(tmp_path: Path) -> None:
    path = tmp_path / "soft.toml"
    path.write_text(load("choi2018-kapton").text.replace("131 kN/m", "1 kN/m"))
    for model in ("lumped", "stack"):
        answer = tensile.tensile(
            str(path), vacuum="94.5 kPa", speed="13 mm/s", travel="300 mm", model=model
        )
        assert answer.outcome == "SNAPS" and any("snaps" in w for w in answer.warnings)
