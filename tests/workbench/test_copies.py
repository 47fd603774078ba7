"""What is copied as Python from every page gives the page's numbers in a fresh process."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import jax
import numpy as np
import pytest

from layerjam.cli.main import main
from layerjam.core.command.results import Result
from layerjam.workbench.call import Call, DataFile, Subject, python_code
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.brake import Brake
from layerjam.workbench.pages.design import Design
from layerjam.workbench.pages.drop import Drop
from layerjam.workbench.pages.laboratory import Laboratory
from layerjam.workbench.pages.laboratory_files import make_practice_files
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.pages.vacuum import Vacuum
from layerjam.workbench.said import put_edits
from layerjam.workbench.state import State
from printed import split_command

SPEC = """name = "small"
brake = "choi2018-kapton"
constraints = ["holding_force >= 300 N", "mass <= 60 g", "width <= 20 mm"]
objectives = ["minimise mass", "maximise energy_capacity"]
[vary]
count = [11, 21, 31]
width = { from = "10 mm", to = "30 mm", step = "5 mm" }
"""
PAGES = [
    (Brake, {"slip": 0.01}),
    (Pull, {"vacuum": 60e3, "travel": 0.03}),
    (
        Drop,
        {
            "shown": "value",
            "vacuum": 30e3,
            "accelerometer": "adxl193",
            "allowed_rise": "30 K",
            "atmosphere": "95 kPa",
        },
    ),
    (Vacuum, {"safe_state": "hold", "fluid": "water", "kind": "bang-bang"}),
    (Design, {"spec": SPEC}),
    (Design, {"part": "arrays", "series": 3.0}),
    (Design, {"part": "density"}),
    (Design, {"part": "machines", "scenario": "slow-stop"}),
]
RUN = """
import json, sys
for code in json.load(sys.stdin):
    space = {}
    exec(code, space)
    print("\\n@@" + space["result"].json())
"""


def results_in(found) -> list[Result]:
    """The results among what a page has computed, in the order of its calls."""
    if isinstance(found, Result):
        return [found]
    if hasattr(found, "result"):
        return results_in(found.result)
    if isinstance(found, dict):
        found = found.values()
    if isinstance(found, list | tuple) or (
        hasattr(found, "__iter__") and not isinstance(found, str)
    ):
        return [r for one in found for r in results_in(one)]
    return []


def asked(kind, settings) -> list[tuple[str, Result]]:
    """(Python, result) of every call of a page."""
    page = kind(Desk(State(settings={kind.name: settings})))
    found = page.compute()
    calls = page.calls()
    results = results_in(found)[: len(calls)]
    assert len(results) == len(calls), kind.name
    assert python_code(calls).count("import") == 1
    return [(call.python_code(), r) for call, r in zip(calls, results, strict=True)]


@pytest.fixture(scope="module")
def practice(tmp_path_factory):
    return make_practice_files(tmp_path_factory.mktemp("practice"), lambda *_: None)


def of_the_laboratory(practice, folder) -> list[tuple[str, Result]]:
    """The same of the laboratory, whose files lie in `folder` as the user's do."""
    page = Laboratory(Desk(State(settings={"laboratory": {"judder": "yes"}})))
    wanted = ("friction_choi2018-kapton_1", "94.5kPa_7mms_1", "40kPa_7mms_1")
    for name, data in practice.items():
        if any(w in name for w in wanted):
            page.uploads.store_file(name, data)
            (folder / name).write_bytes(data)
    rows = page.compute()
    put_edits(page.desk, {r.upload.key: {"role": "validate"} for r in rows if r.vacuum == 40e3})
    page.compute()
    made = [(done.call.python_code(), done.result) for done in page.chain.done.values()]
    page.close()
    assert len(made) == 3
    return made


def test_a_copy_that_writes_a_brake_runs_as_often_as_one_likes(tmp_path, monkeypatch):
    u = np.linspace(0, 0.11, 1200)
    force = 2.45 * np.where(u < 0.002, 0.32 * u / 0.002, 0.24)
    rows = "".join(f"{1e3 * x:.5f},{f:.6f}\n" for x, f in zip(u, force, strict=True))
    (tmp_path / "sled.csv").write_text("Extension [mm],Load [N]\n" + rows)
    options = {"normal_force": "2.45 N", "brake": Subject("choi2018-kapton")}
    file = DataFile("sled.csv", tmp_path / "layerjam-file-0001.csv")
    call = Call("friction", options=options, files=(file,), out="tested.toml")
    monkeypatch.chdir(tmp_path)
    found = []
    for _ in range(3):
        space: dict[str, object] = {}
        exec(call.python_code(), space)
        found.append((space["result"].json(), (tmp_path / "tested.toml").read_text()))
    assert found[0] == found[1] == found[2]
    assert main([*split_command(call.command_line())[1:], "--json"]) == 0
    assert (tmp_path / "tested.toml").read_text() == found[0][1]


@pytest.mark.slow
def test_every_copy_runs_in_a_fresh_process(practice, tmp_path):
    (tmp_path / "small.toml").write_text(SPEC)
    made = [one for kind, settings in PAGES for one in asked(kind, settings)]
    laboratory = of_the_laboratory(practice, tmp_path)
    made += [*laboratory, *laboratory]  # once more, now that the files it writes are there
    plain = {k: v for k, v in os.environ.items() if k != "JAX_ENABLE_X64"}
    # what the pages have compiled is not compiled again
    plain["JAX_COMPILATION_CACHE_DIR"] = str(jax.config.jax_compilation_cache_dir)
    plain["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0.05"
    plain["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "-1"
    said = subprocess.run(
        [sys.executable, "-c", RUN],
        input=json.dumps([code for code, _ in made]),
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=plain,
    )
    assert said.returncode == 0, said.stderr[-2000:]
    found = [json.loads(part.split("\n}\n")[0] + "\n}") for part in said.stdout.split("\n@@")[1:]]
    assert len(found) == len(made)
    for (code, result), copied in zip(made, found, strict=True):
        own = json.loads(result.json())
        for key in own.keys() - {"file", "warnings"}:
            assert copied[key] == own[key], (code, key)
