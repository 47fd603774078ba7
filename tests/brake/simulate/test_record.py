"""Records become frames, datasets and files; a file rebuilds its run and is whole or absent."""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path

import numpy as np
import pandas
import pytest
import xarray

from layerjam.brake.device.load import load
from layerjam.brake.simulate.procedure import parse_procedure
from layerjam.brake.simulate.record import Outcome, TensileRecord, read_header
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import FileError
from strategies import change

TEXT = (
    "evacuate to 94.5 kPa and hold 0.3 s; pull at 13 mm/s until 30 mm; return at 7 mm/s to 11 mm; "
    "evacuate to 33.3 kPa; pull at 1 mm/s until 20 mm"
)
UNITS = {
    "time": "s", "elongation": "m", "force": "N", "slip": "m", "sleeve_force": "N",
    "vacuum": "Pa", "work": "J", "dissipated_energy": "J", "stored_energy": "J",
}  # fmt: skip


@pytest.fixture(scope="module")
def record() -> TensileRecord:
    file = load("choi2018-kapton")
    # numbers no short decimal stands for
    brake = change(file.brake, scale_factor=0.1 + 0.2 * 3.1, film__kinetic=1 / 4.1,
                   site__atmosphere=100_000 / 1.01)  # fmt: skip
    return tensile(dataclasses.replace(file, brake=brake), parse_procedure(TEXT))


def same(one: TensileRecord, other: TensileRecord) -> None:
    for (name, a, _), (_, b, _) in zip(one.columns(), other.columns(), strict=True):
        np.testing.assert_array_equal(a, b, err_msg=name)
    assert (one.outcome, one.procedure, one.model) == (other.outcome, other.procedure, other.model)


def test_frame(record: TensileRecord) -> None:
    frame = record.to_frame()
    assert list(frame.columns) == list(UNITS) and frame.attrs["units"] == UNITS
    assert frame.attrs["outcome"] == "FINISHED"
    np.testing.assert_array_equal(frame["force"].to_numpy(), record.force)


def test_xarray(record: TensileRecord) -> None:
    data = record.to_xarray()
    assert set(data.data_vars) == set(UNITS) - {"time"} and "time" in data.coords
    assert {name: data[name].attrs["units"] for name in UNITS} == UNITS
    np.testing.assert_array_equal(data["work"].to_numpy(), record.work)
    assert data.attrs["procedure"] == record.procedure
    assert "synthetic" in data.attrs["data"]


def test_csv_rebuilds_the_run_bit_for_bit(record: TensileRecord, tmp_path: Path) -> None:
    path = record.to_csv(tmp_path / "run.csv")
    file, text = read_header(path)
    assert file.brake == record.brake.brake
    again = tensile(file, parse_procedure(text))
    same(record, again)
    table = pandas.read_csv(path, comment="#")
    assert list(table.columns) == [f"{name} [{unit}]" for name, unit in UNITS.items()]
    for name, unit in UNITS.items():
        np.testing.assert_array_equal(table[f"{name} [{unit}]"], getattr(record, name))
    head = path.read_text(encoding="utf-8").split("\n")[:6]
    assert head[0].startswith("# layerjam ") and "synthetic" in head[1]
    # and the file the second run writes is the first one
    assert again.to_csv(tmp_path / "again.csv").read_bytes() == path.read_bytes()


def test_csv_is_read_back_as_a_pull(record: TensileRecord, tmp_path: Path) -> None:
    from layerjam.laboratory.measure.readers.read import read_trace

    trace = read_trace(record.to_csv(tmp_path / "run.csv"))
    np.testing.assert_array_equal(trace.force, record.force)
    np.testing.assert_array_equal(trace.elongation, record.elongation)


def test_netcdf(record: TensileRecord, tmp_path: Path) -> None:
    path = record.save(tmp_path / "run.nc")
    with xarray.open_dataset(path, engine="scipy") as data:
        for name, unit in UNITS.items():
            np.testing.assert_array_equal(data[name].to_numpy(), getattr(record, name))
            if name != "time":
                assert data[name].attrs["units"] == unit
        from layerjam.brake.device.brake_file import BrakeFile

        file = BrakeFile.read(data.attrs["brake"], "header")
        same(record, tensile(file, parse_procedure(data.attrs["procedure"])))


def test_endings(record: TensileRecord, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"'\.txt' is unknown; use \.csv or \.nc"):
        record.save(tmp_path / "run.txt")
    assert record.save(tmp_path / "RUN.CSV").stat().st_size > 1000
    assert list(tmp_path.iterdir()) == [tmp_path / "RUN.CSV"]


@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_an_existing_file_stays_unless_forced(
    record: TensileRecord, tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"run.{ending}"
    path.write_text("mine")
    with pytest.raises(FileError, match="already exists"):
        record.save(path)
    assert path.read_text() == "mine"
    record.save(path, overwrite=True)
    assert path.stat().st_size > 1000 and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("when", ["write", "replace"])
@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_files_appear_whole_or_not_at_all(
    record: TensileRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str, when: str
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    path = tmp_path / f"run.{ending}"
    path.write_text("mine")
    if when == "write":
        monkeypatch.setattr(Path, "write_bytes", full)
        monkeypatch.setattr(xarray.Dataset, "to_netcdf", full)
    else:
        monkeypatch.setattr(os, when, full)
    with pytest.raises(FileError, match="cannot be written: No space left on device"):
        record.save(path, overwrite=True)
    monkeypatch.undo()
    assert path.read_text() == "mine" and list(tmp_path.iterdir()) == [path]


def test_the_folder_must_exist(record: TensileRecord, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be written"):
        record.save(tmp_path / "nowhere" / "run.csv")
    (tmp_path / "run.csv").mkdir()
    with pytest.raises(FileError, match="folder"):
        record.save(tmp_path / "run.csv", overwrite=True)
    assert [p.name for p in tmp_path.iterdir()] == ["run.csv"]


@pytest.mark.parametrize(
    "text", ["", "time [s],force [N]\n0,1\n", "# procedure: vent\n1,2\n", "\xff\xfe"]
)
def test_a_header_that_rebuilds_nothing_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "other.csv"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(FileError):
        read_header(path)
    with pytest.raises(FileError):
        read_header(tmp_path / "absent.csv")


def test_a_header_cut_inside_the_brake_is_refused(record: TensileRecord, tmp_path: Path) -> None:
    lines = record.to_csv(tmp_path / "run.csv").read_text(encoding="utf-8").splitlines()
    start = lines.index("# brake:")
    (tmp_path / "cut.csv").write_text("\n".join(lines[: start + 12]) + "\n")
    with pytest.raises(FileError):
        read_header(tmp_path / "cut.csv")


def test_a_record_is_frozen_and_outcomes_are_words(record: TensileRecord) -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        record.outcome = Outcome.SNAPS  # type: ignore[misc]
    assert {"FINISHED", "SEPARATED", "CLOSED_BY_SLEEVE", "SNAPS"} <= {str(o) for o in Outcome}
