"""Sweeps on disk: stopped, killed and gone on with, here and on a cluster, to the same bytes."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from layerjam.core.errors import FileError, MissingExtraError, QuantityError
from layerjam.workshop.commands.design import design
from layerjam.workshop.commands.sweep import sweep
from layerjam.workshop.design import blocks
from layerjam.workshop.design.blocks import Store, decode_block, encode_block, fingerprint
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import read_spec

pytestmark = pytest.mark.timing

pytest.importorskip("pyarrow")

SPEC = """
name = "swept"
brake = "choi2018-kapton"
line = "choi2018"
without = ["buildable", "drawn_mass"]
constraints = ["holding_force >= 150 N", "clamped_length <= 110 mm"]
objectives = ["minimise mass", "maximise energy_capacity"]
[vary]
count = { from = 5, to = 23, step = 2 }
width = { from = "10 mm", to = "24 mm", step = "2 mm" }
overlap = { from = "40 mm", to = "80 mm", step = "4 mm" }
vacuum = ["50 kPa", "70 kPa", "90 kPa"]
"""
BLOCK = 250  # computed 256 at a time
TOTAL = 11  # of 10 * 8 * 11 * 3 designs


def read(text: str = SPEC):
    return read_spec(text, "spec.toml")


def content(folder: Path) -> dict[str, str]:
    """SHA-256 of every file of a sweep."""
    return {
        str(p.relative_to(folder)): hashlib.sha256(p.read_bytes()).hexdigest()
        for p in sorted(folder.rglob("*"))
        if p.is_file() and p.name != ".lock"
    }


@pytest.mark.parametrize("block", ["many", 0, -3, 2.5, True])
def test_a_block_of_no_whole_number_of_designs_is_refused(tmp_path, block):
    with pytest.raises(QuantityError, match=r"^block: .* (integer|at least 1|pure number)"):
        sweep(read(), out=tmp_path / "none", block=block)
    assert not (tmp_path / "none").exists()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A sweep that nothing disturbed."""
    out = tmp_path_factory.mktemp("whole") / "sweep"
    return out, sweep(read(), out=out, block=BLOCK)


def test_a_sweep_finds_what_design_finds(whole):
    out, answer = whole
    alone = design(read())
    assert answer.complete and answer.blocks == answer.blocks_done == TOTAL
    for key in ("chosen", "runner_up", "refined", "front_size", "feasible_designs", "binding"):
        np.testing.assert_equal(answer.values[key], alone.values[key])
    manifest = json.loads((out / "manifest.json").read_text())
    assert sum(b["designs"] for b in manifest["blocks"]) == read().grid.size
    assert sum(b["feasible"] for b in manifest["blocks"]) == answer.feasible_designs
    for row in manifest["blocks"]:
        assert hashlib.sha256((out / row["file"]).read_bytes()).hexdigest() == row["sha256"]


def test_the_front_can_be_read_as_a_table(whole):
    import pyarrow.parquet as pq

    out, answer = whole
    table = pq.read_table(out / "front.parquet")
    assert table.num_rows == answer.front_size
    assert table.schema.field("mass").metadata[b"unit"] == b"kg"
    mass = table["mass"].to_numpy()
    assert sorted(mass) == pytest.approx(sorted(d["mass"] for d in answer.front))


def test_a_block_is_the_same_bytes_each_time_and_read_back_whole():
    search = Search(read(), BLOCK)
    mark = fingerprint(search.spec, BLOCK)
    first, second = (encode_block(search, 3, search.run_block(3), mark) for _ in range(2))
    assert first == second
    back, found = decode_block(search, first, mark, 3), search.run_block(3)
    assert back is not None
    np.testing.assert_equal(vars(back), vars(found))
    np.testing.assert_equal(search.summary(back), search.summary(found))
    assert decode_block(search, first, mark, 4) is None
    assert decode_block(search, first, "another", 3) is None
    assert decode_block(search, first[:-10], mark, 3) is None


def test_a_block_without_a_find_is_kept_too(tmp_path):
    # in its first blocks, of few sheets, nothing holds so much
    asked = read(SPEC.replace("150 N", "600 N"))
    answer = sweep(asked, out=tmp_path / "s", block=BLOCK)
    with Store(tmp_path / "s", Search(answer.record.spec, BLOCK)) as store:
        empty = [i for i, found in enumerate(store.read_blocks(TOTAL)) if not found.feasible]
    assert answer.complete and 0 in empty and len(empty) < TOTAL
    np.testing.assert_equal(answer.chosen, design(asked).chosen)


@pytest.mark.parametrize("at", [1, pytest.param(4, marks=pytest.mark.slow), TOTAL])
def test_stopped_from_the_keyboard_it_goes_on(tmp_path, whole, at):
    seen = []

    def stop(_what: str, share: float) -> None:
        seen.append(share)
        if len(seen) == at:
            raise KeyboardInterrupt

    first = sweep(read(), out=tmp_path / "s", block=BLOCK, progress=stop)
    assert not first.complete and first.feasible is None
    assert first.blocks_done == at
    assert not (tmp_path / "s" / "manifest.json").exists()
    again = sweep(read(), out=tmp_path / "s", block=BLOCK)
    assert again.complete and again.blocks_found == at
    assert content(tmp_path / "s") == content(whole[0])


def test_what_a_killed_process_left_is_cleared_away(tmp_path, whole):
    out = tmp_path / "s"
    sweep(read(), out=out, block=BLOCK)
    (out / "manifest.json").unlink()
    folder = out / "blocks"
    (folder / "block-0000002.parquet").write_bytes(b"PAR1 half of it")
    (folder / "block-0000005.parquet").unlink()
    (folder / ".block-0000005-x1y2.parquet").write_bytes(b"half")
    again = sweep(read(), out=out, block=BLOCK)
    assert again.blocks_found == TOTAL - 2
    assert content(out) == content(whole[0])


def test_a_folder_of_something_else_is_left_alone(tmp_path, whole):
    other = read(SPEC.replace("150 N", "160 N"))
    before = content(whole[0])
    with pytest.raises(FileError, match="a different specification"):
        sweep(other, out=whole[0], block=BLOCK)
    with pytest.raises(FileError, match="a different specification"):
        sweep(read(), out=whole[0], block=BLOCK // 2)
    assert content(whole[0]) == before
    (tmp_path / "blocks").mkdir()
    (tmp_path / "blocks" / "thesis.txt").write_text("mine")
    with pytest.raises(FileError, match="other files"):
        sweep(read(), out=tmp_path, block=BLOCK)
    assert (tmp_path / "blocks" / "thesis.txt").read_text() == "mine"


@pytest.mark.parametrize("theirs", ["front.parquet", "manifest.json"])
def test_nothing_is_replaced_or_made_beside_what_others_wrote(tmp_path, theirs):
    (tmp_path / theirs).write_text("mine")
    with pytest.raises(FileError, match="other files"):
        sweep(read(), out=tmp_path, block=BLOCK)
    assert [p.name for p in tmp_path.iterdir()] == [theirs]
    assert (tmp_path / theirs).read_text() == "mine"


def test_two_at_once_are_kept_apart(tmp_path):
    search = Search(read(), BLOCK)
    with Store(tmp_path / "s", search), pytest.raises(FileError, match="is running"):
        sweep(read(), out=tmp_path / "s", block=BLOCK)


def test_without_pyarrow_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match=r"\[sweep\]"):
        sweep(read(), out=tmp_path / "s", block=BLOCK)


def test_what_cannot_be_is_said_without_a_folder(tmp_path):
    answer = sweep(read(SPEC.replace("150 N", "50 kN")), out=tmp_path / "s", block=BLOCK)
    assert answer.feasible is False and not (tmp_path / "s").exists()


SCRIPT = """
import jax, sys
jax.config.update("jax_enable_x64", True)
from pathlib import Path
from layerjam.workshop.design.specification import load_spec
from layerjam.workshop.commands.sweep import sweep
answer = sweep(load_spec(sys.argv[1]), out=sys.argv[2], block=int(sys.argv[3]),
               scheduler=sys.argv[4] if len(sys.argv) > 4 else None)
print(answer.blocks_found, answer.complete)
"""


@pytest.mark.slow
def test_killed_hard_at_any_point_nothing_is_lost_or_doubled(tmp_path, whole):
    (tmp_path / "spec.toml").write_text(SPEC)
    out = tmp_path / "s"
    command = [sys.executable, "-c", SCRIPT, str(tmp_path / "spec.toml"), str(out), str(BLOCK)]
    for wanted in (1, 4, 7):
        made = subprocess.Popen(command, stdout=subprocess.PIPE)
        while made.poll() is None:
            if len(list((out / "blocks").glob("block-*"))) >= wanted:
                made.kill()
                break
            time.sleep(0.002)
        made.wait()
        assert made.stdout is not None
        made.stdout.close()
    said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True).stdout.split()
    assert int(said[0]) >= 1 and said[1] == "True"
    assert content(out) == content(whole[0])


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_cluster_that_loses_a_worker_gives_the_same_bytes(tmp_path):
    """Three local workers, one killed in mid-sweep, against one machine."""
    distributed = pytest.importorskip("distributed")
    text = SPEC.replace("step = 2 }", 'step = 2 }\nwall = ["0.5 mm", "1 mm", "2 mm"]')
    alone = tmp_path / "alone"
    sweep(read(text), out=alone, block=BLOCK)
    with (
        distributed.LocalCluster(
            n_workers=3, threads_per_worker=1, processes=True, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        pids = sorted(client.run(os.getpid).values())
        killed = []

        def progress(_what: str, share: float) -> None:
            if share > 0.2 and not killed:
                killed.append(pids[0])
                os.kill(pids[0], getattr(signal, "SIGKILL", signal.SIGTERM))

        answer = sweep(
            read(text), out=tmp_path / "s", block=BLOCK, scheduler=cluster.scheduler_address,
            progress=progress,
        )  # fmt: skip
        assert killed and answer.complete
    assert content(tmp_path / "s") == content(alone)


def test_a_scheduler_out_of_reach_is_said(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    from layerjam.workshop.design import cluster

    monkeypatch.setattr(cluster, "PATIENCE", 0.3)
    with pytest.raises(cluster.ClusterError, match="cannot be reached"):
        sweep(read(), out=tmp_path / "s", block=BLOCK, scheduler="tcp://127.0.0.1:1")
    assert not (tmp_path / "s").exists()


def test_the_mark_changes_with_what_is_asked():
    marks = {
        fingerprint(read(SPEC), BLOCK),
        fingerprint(read(SPEC), BLOCK + 1),
        fingerprint(read(SPEC.replace("150 N", "151 N")), BLOCK),
        fingerprint(read(SPEC.replace("90 kPa", "91 kPa")), BLOCK),
        fingerprint(read(SPEC.replace("choi2018-kapton", "choi2018-ptfe")), BLOCK),
    }
    assert len(marks) == 5
    # comments and what is only reported change nothing
    assert fingerprint(read(SPEC + "# well\n"), BLOCK) in marks
    assert blocks.MANIFEST == "manifest.json"
