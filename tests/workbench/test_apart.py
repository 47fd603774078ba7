"""What is copied and taken away beside pulls and drops: files of one name, a record, the bench."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.workbench.answer import Answer, file_bytes
from layerjam.workbench.bench_session import BenchRecord, BenchState
from layerjam.workbench.call import Call, DataFile, Subject, disambiguate, python_code

KAPTON = "choi2018-kapton"
SAID = {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "20 mm"}


def two_of_one_name():
    texts = [load(name).text + "\n" for name in (KAPTON, "choi2018-ptfe")]
    files = [BrakeFile.read(text, "a brake") for text in texts]
    return [Call("tensile", (Subject("mine.toml", file),), SAID) for file in files]


def test_the_copied_python_of_two_brakes_of_one_name_computes_both(tmp_path, monkeypatch):
    shown, pinned = two_of_one_name()
    own = disambiguate([shown], {"before": pinned})
    assert list(own.texts) == ["mine.toml", "mine-2.toml"]
    for name, text in own.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    space = {}
    exec(python_code(own.calls, own.pinned_calls), space)
    assert space["result"].values == shown.run().values
    assert space["pinned"]["before"].values == pinned.run().values
    assert space["result"].peak_force != pytest.approx(space["pinned"]["before"].peak_force)


def test_equal_files_stay_one_and_what_a_call_writes_keeps_its_name():
    one, other = two_of_one_name()
    assert list(disambiguate([one, one]).texts) == ["mine.toml"]
    own = disambiguate([one, Call("validate", other.subjects, made=True)])
    assert list(own.texts) == ["mine.toml"]
    assert own.calls[1].subjects[0].name == "mine.toml"
    assert disambiguate([Call("show", (Subject(KAPTON),))]).texts == {}


@pytest.mark.slow
def test_a_record_of_the_laboratory_is_drawn_as_the_command_draws_it(tmp_path):
    path = tmp_path / "layerjam-file-0001.csv"
    path.write_bytes(file_bytes(Call("tensile", (Subject(KAPTON),), SAID).run(), "csv"))
    taken = Answer(Call("pull", files=(DataFile("pull.csv", path),)), title="pull")
    assert taken.figure("svg").startswith(b"<?xml")
    assert "pull.csv" in taken.python_code() and "layerjam-file" not in taken.python_code()


def looks():
    for k in range(50):
        vacuum = None if k == 7 else 40e3 * (1 - np.exp(-k / 10))
        yield BenchState(3.0 + k / 10, vacuum, 40e3, 0.5, False, "RUN", None)


def test_what_was_seen_of_a_bench_is_drawn_by_the_lines_that_are_copied(tmp_path, monkeypatch):
    shown = BenchRecord(tuple(looks()), simulated=True)
    assert shown.columns["time"][-1] == pytest.approx(4.9)
    assert np.isnan(shown.columns["vacuum"][7])
    monkeypatch.chdir(tmp_path)
    exec(shown.python_code(), {})
    assert Path("bench.svg").read_bytes() == shown.figure("svg")
    assert b"computed, not measured" in shown.figure("svg")
    space = {}
    exec("".join(json.loads(shown.notebook())["cells"][1]["source"]), space)
    assert space["figure"].axes
