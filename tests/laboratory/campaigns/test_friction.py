"""Friction tests: maximum and mean over the window, mean and SD over repeats."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from laboratory.campaigns import bench as virtual
from laboratory.campaigns.bench import QUIET
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError, FitError
from layerjam.laboratory.identify.friction.reduction import (
    WINDOW,
    add_friction,
    reduce_friction,
    reduce_repeat,
)
from layerjam.laboratory.measure.trace import Trace

NORMAL = 0.250 * 9.80665
SILENT = virtual.Machine(**QUIET, sampling_rate=50.0)
TABLE_1 = {"Kapton": (0.32, 0.24, 0.0818, 0.0277), "PTFE": (0.12, 0.05, 0.0871, 0.0317)}


def made(travel: np.ndarray, force: np.ndarray, path: str = "test.csv") -> Trace:
    return Trace(force=force, elongation=travel, time=None, path=path, format="made")


def by_hand(static: float = 0.8, kinetic: float = 0.5, far: float = 0.1, **more: object) -> Trace:
    """Travel in steps of 0.1 mm; static peak at 2 mm, then kinetic, times 2 N."""
    u = np.arange(0, round(far * 1e4) + 1) * 1e-4
    force = np.where(u < 0.002, 2 * static * u / 0.002, 2 * kinetic)
    force[20] = 2 * static
    return dataclasses.replace(made(u, force), **more)


def test_the_definition_by_hand() -> None:
    u = np.arange(0, 1001) * 1e-4
    force = np.full(1001, 9.0)
    force[400:1001] = np.linspace(1.0, 3.0, 601)  # 40 to 100 mm, both ends counted
    found = reduce_repeat(made(u, force), 2.0, WINDOW)
    assert WINDOW == (0.040, 0.100)
    assert found.static == 4.5 and found.kinetic == pytest.approx(1.0, rel=1e-12)
    assert found.static_at == 0.0 and found.samples == 1001


def test_the_window_is_inclusive_and_counts_from_the_first_sample() -> None:
    shifted = by_hand()
    moved = dataclasses.replace(shifted, elongation=shifted.elongation + 0.3)
    straight = reduce_repeat(shifted, 2.0, WINDOW)
    found = reduce_repeat(moved, 2.0, WINDOW)
    assert (found.static, found.kinetic) == (straight.static, straight.kinetic) == (0.8, 0.5)
    assert found.static_at == pytest.approx(0.002, rel=1e-9)
    back = dataclasses.replace(shifted, elongation=-shifted.elongation)
    assert reduce_repeat(back, 2.0, WINDOW) == reduce_repeat(shifted, 2.0, WINDOW)


def test_mean_and_absolute_sd_over_repeats() -> None:
    pairs = ((0.30, 0.23), (0.33, 0.24), (0.36, 0.28))
    traces = [by_hand(s, k, path=f"{i}.csv") for i, (s, k) in enumerate(pairs)]
    found = reduce_friction(traces, 2.0)
    static, kinetic = np.array(pairs).T
    assert found.static == pytest.approx(0.33, rel=1e-12)
    assert found.kinetic == pytest.approx(0.25, rel=1e-12)
    assert found.static_sd == pytest.approx(np.std(static, ddof=1), rel=1e-12)
    assert found.kinetic_sd == pytest.approx(np.std(kinetic, ddof=1), rel=1e-12)
    assert found.static_sd == pytest.approx(0.03, rel=1e-12)  # absolute, not a share of the mean
    assert [r.path for r in found.repeats] == ["0.csv", "1.csv", "2.csv"]
    assert found.warnings == ()


def test_one_repeat_has_no_sd() -> None:
    found = reduce_friction([by_hand()], 2.0)
    assert found.static_sd is None and found.kinetic_sd is None
    assert all("SD" not in s.spread for _, s in found.sources().values())


def test_another_window() -> None:
    u = np.arange(0, 501) * 1e-4
    force = np.where(u <= 0.020, 5.0, 1.0)
    found = reduce_friction([made(u, force)], 2.0, (0.010, 0.020))
    assert found.kinetic == 2.5
    with pytest.raises(FileError, match=r"travel ends at 50 mm; .* to 100 mm .*--from and --to"):
        reduce_friction([made(u, force)], 2.0)
    with pytest.raises(FileError, match="only 1 sample between"):
        reduce_friction([made(u, force)], 2.0, (0.01005, 0.01015))
    for bad in ((0.03, 0.03), (0.04, 0.03), (-0.01, 0.03)):
        with pytest.raises(FitError, match="window"):
            reduce_friction([made(u, force)], 2.0, bad)
    with pytest.raises(FitError, match="no repeat was given"):
        reduce_friction([], 2.0)


def test_a_maximum_inside_the_window_is_said() -> None:
    trace = by_hand(0.5, 0.5)
    force = trace.force + np.maximum(2.0 - np.abs(np.arange(len(trace)) - 700) * 0.05, 0)
    found = reduce_friction([dataclasses.replace(trace, force=force)], 2.0)
    assert found.static == 1.5
    assert len(found.warnings) == 1 and "at 70 mm of travel, inside" in found.warnings[0]


def test_a_force_that_is_not_friction_is_refused() -> None:
    trace = by_hand()
    with pytest.raises(FileError, match="mean force in the window"):
        reduce_friction([dataclasses.replace(trace, force=-trace.force)], 2.0)


@pytest.mark.parametrize("film", list(TABLE_1))
def test_table_1_comes_back(film: str) -> None:
    static, kinetic, _, _ = TABLE_1[film]
    trace = virtual.friction(static, kinetic, NORMAL, machine=SILENT, texture=0.0,
                             string_stiffness=50.0)  # fmt: skip
    found = reduce_friction([trace], NORMAL)
    step = 50.0 * 2.5e-3 / 50.0 / NORMAL  # what the string gains between two samples
    assert static - step <= found.static <= static
    assert found.kinetic == pytest.approx(kinetic, rel=1e-12)


@pytest.mark.parametrize("film", list(TABLE_1))
def test_the_scatter_of_table_1_comes_back(film: str) -> None:
    """200 repeats that scatter by the printed SD, which the table gives as a share of the mean."""
    static, kinetic, rel_static, rel_kinetic = TABLE_1[film]
    traces = [
        virtual.friction(
            static, kinetic, NORMAL, repeat=i, texture=0.01, string_stiffness=40.0,
            machine=virtual.Machine(sampling_rate=50.0, load_cell_noise=0.002, seed=11),
            static_sd=rel_static * static, kinetic_sd=rel_kinetic * kinetic,
        )
        for i in range(200)
    ]  # fmt: skip
    found = reduce_friction(traces, NORMAL)
    assert found.static_sd == pytest.approx(rel_static * static, rel=0.15)
    assert found.kinetic_sd == pytest.approx(rel_kinetic * kinetic, rel=0.15)
    assert abs(found.static - static) < 3 * found.static_sd / 200**0.5 + 0.003 * static
    assert abs(found.kinetic - kinetic) < 3 * found.kinetic_sd / 200**0.5


def test_friction_written_into_a_brake_voids_its_scale_factor() -> None:
    file = load("choi2018-kapton")
    result = reduce_friction([by_hand(0.33, 0.25), by_hand(0.35, 0.26)], 2.0)
    text, warnings = add_friction(file, result, "mine")
    made_file = BrakeFile.read(text, "mine.toml")
    assert made_file.name == "mine"
    assert made_file.brake.film.static == pytest.approx(0.34) == result.static
    assert made_file.brake.film.kinetic == result.kinetic
    assert made_file.brake.scale_factor == 1.0
    assert made_file.brake.sheets == file.brake.sheets
    source = made_file.sources["film.kinetic"]
    assert source.kind == "measured" and "test.csv" in source.text and "40 mm" in source.text
    assert source.spread == f"SD {result.kinetic_sd:.4g}"
    assert len(warnings) == 1 and "0.875" in warnings[0] and "calibrate" in warnings[0]
    _, again = add_friction(made_file, result, "again")
    assert again == []
