"""What the facts beside a pull say against the brake that it is taken for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from laboratory.campaigns import bench as virtual
from layerjam.brake.commands.edit import edit
from layerjam.brake.device.load import load
from layerjam.laboratory.commands.calibration import calibrate

STATED = "choi2018-kapton"


@pytest.fixture
def pull(tmp_path: Path) -> Path:
    machine = virtual.Machine(sampling_rate=500.0, load_cell_noise=0.1, seed=3)
    trace = virtual.pull(load(STATED).brake, 94.5e3, 0.013, 0.04, machine, name=STATED)
    return virtual.write_bluehill(trace, tmp_path / "pull.csv")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"width": "25 mm"}, "whose sheet width is 25 mm, not 13 mm"),
        ({"count": 21}, "whose .* is 21, not 11"),
        ({"width": "13.05 mm"}, None),
    ],
)
def test_pulls_of_a_brake_with_other_sheets_are_not_taken_in_silence(change, words, pull) -> None:
    changes = {f"sheets.{name}": value for name, value in change.items()}
    mine = edit(STATED, changes, name="mine").record
    said = [str(w) for w in calibrate(mine, pull).warnings if w.key == "other-brake"]
    assert len(said) == (words is not None)
    assert all(STATED in one and re.search(words, one) for one in said)
