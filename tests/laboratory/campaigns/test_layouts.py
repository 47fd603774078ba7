"""Files in the machines' layouts give the record back, and replace nothing unasked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from layerjam.core.errors import FileError
from layerjam.laboratory.measure.readers.read import read_trace
from layerjam.laboratory.measure.sidecar import read_facts
from strategies import KAPTON


@pytest.mark.parametrize("form", virtual.WRITERS)
@pytest.mark.parametrize("kind", ["pull", "friction"])
def test_files_give_the_record_back(form: str, kind: str, tmp_path: Path) -> None:
    machine = virtual.Machine(seed=11, jitter=2e-5)
    if kind == "pull":
        trace = virtual.pull(KAPTON, 94.5e3, 0.013, 0.04, machine, 2, "choi2018-kapton")
    else:
        trace = virtual.friction(0.32, 0.24, 2.45, repeat=2)
    path = virtual.WRITERS[form](trace, tmp_path / "x.dat")
    back = read_trace(path)
    digits = {"own": 0.0, "bluehill": 5.1e-7, "testxpert": 5.1e-5}[form]
    np.testing.assert_allclose(back.force, trace.force, rtol=0, atol=max(digits * 10, 1e-12))
    np.testing.assert_allclose(
        back.elongation, trace.elongation, rtol=0, atol=max(digits, 1e-15) / 100
    )
    np.testing.assert_allclose(back.time, trace.time, rtol=0, atol=digits)
    assert back.facts == trace.facts == read_facts(path) and back.facts.synthetic
    assert b"SYNTHETIC" in path.read_bytes()[:400]
    assert back.synthetic
    with pytest.raises(FileError, match="already exists"):
        virtual.WRITERS[form](trace, path)
    virtual.WRITERS[form](trace, path, overwrite=True)
    (tmp_path / "x.dat.toml").unlink()
    assert read_trace(path).synthetic


def test_nothing_is_written_beside_a_sidecar_of_another(tmp_path: Path) -> None:
    (tmp_path / "x.csv.toml").write_text('note = "mine"')
    with pytest.raises(FileError, match="x.csv.toml: already exists"):
        virtual.write_own(virtual.pull(KAPTON, 5e4, 0.013, 0.04), tmp_path / "x.csv")
    assert not (tmp_path / "x.csv").exists()
