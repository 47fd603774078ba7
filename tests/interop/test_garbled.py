"""Damaged states: refused, or stepped without undefined behaviour, by the kernel and both FMUs."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from brake.kernel.histories import history
from interop.importer import Refused, Unit
from layerjam.brake.kernel import kernel as kernels
from layerjam.brake.kernel.compiler import FLAGS, SOURCES, run_compiler
from layerjam.brake.kernel.kernel import Kernel
from layerjam.core.errors import QuantityError
from layerjam.interop import fmi
from strategies import KAPTON

pytestmark = pytest.mark.skipif(
    shutil.which("gcc") is None or fmi.find_platform() != "linux",
    reason="gcc's sanitizer is not installed, or another platform than the importer's",
)
SANITIZED = ("gcc", *FLAGS, "-O0", "-g", "-fsanitize=undefined", "-shared", "-fPIC", f"-I{SOURCES}")
STATES = 1000


def garbled(whole: bytes, rng: np.random.Generator, fixed: int = 0) -> bytes:
    """A copy with one to eight bytes changed, or a number made NaN, infinite or huge."""
    bytes_ = np.frombuffer(whole, np.uint8).copy()
    if rng.random() < 0.5:
        places = rng.integers(fixed, len(bytes_), rng.integers(1, 9))
        bytes_[places] = rng.integers(0, 256, len(places))
    else:
        place = fixed + 8 * rng.integers(0, (len(bytes_) - fixed) // 8)
        number = rng.choice([np.nan, np.inf, -np.inf, 1e300, -1e300])
        bytes_[place : place + 8] = np.frombuffer(number.tobytes(), np.uint8)
    return bytes_.tobytes()


@pytest.fixture
def sanitized_kernel(tmp_path, monkeypatch):
    target = tmp_path / "kernel.so"
    run_compiler([*SANITIZED, *map(str, kernels.CODE)], target)
    loaded = kernels.bind_library(target, "double")
    monkeypatch.setattr(kernels, "load_library", lambda precision: loaded)
    return Kernel(KAPTON)


def wandered(kernel):
    """The kernel after a random history, with turning points inside one another."""
    for point in zip(*history(KAPTON, 14, 200), strict=True):
        kernel.move(*point)
    return kernel


def test_a_garbled_state_of_the_kernel(sanitized_kernel, capfd):
    kernel, rng, refused = wandered(sanitized_kernel), np.random.default_rng(1), 0
    whole = kernel.state
    path, vacuum = history(KAPTON, 6, STATES)
    for i in range(STATES):
        damaged = garbled(whole, rng)
        try:
            kernel.state = damaged
        except QuantityError as error:
            assert error.quantity == "state" and kernel.state == whole
            refused += 1
            continue
        for point in ((path[i], vacuum[i]), (0.0, vacuum[i]), (0.06, 9e4)):
            assert np.isfinite(
                [kernel.move(*point), kernel.tangent(), kernel.vacuum_tangent()]
            ).all()
        kernel.state = whole
    assert STATES / 2 < refused < STATES
    assert "runtime error" not in capfd.readouterr().err


@pytest.mark.parametrize("count", [0, 1, 37, 255])
def test_more_turning_points_than_there_is_room_for(count):
    kernel = wandered(Kernel(KAPTON))
    damaged = kernel._made.state.from_buffer_copy(kernel.state)
    damaged.count = count
    with pytest.raises(QuantityError, match="more turning points than are remembered"):
        kernel.state = bytes(damaged)


def test_a_state_of_another_version_and_pieces_in_disorder():
    kernel = wandered(Kernel(KAPTON))
    damaged = kernel._made.state.from_buffer_copy(kernel.state)
    damaged.layout = 1
    with pytest.raises(QuantityError, match="a state of another version"):
        kernel.state = bytes(damaged)
    damaged = kernel._made.state.from_buffer_copy(kernel.state)
    damaged.ends[damaged.count - 1] = 1.5
    with pytest.raises(QuantityError, match="pieces of tension in disorder"):
        kernel.state = bytes(damaged)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_every_number_of_a_state_must_be_finite(bad):
    kernel = wandered(Kernel(KAPTON))
    whole = np.frombuffer(kernel.state, np.float64)
    for place in range(kernel._made.state.flags.offset // 8):
        damaged = whole.copy()
        damaged[place] = bad
        with pytest.raises(QuantityError, match="not finite"):
            kernel.state = damaged.tobytes()
    kernel.state = whole.tobytes()


@pytest.mark.parametrize("version", ["3", "2"])
def test_a_garbled_state_of_a_mock_up_unit(version, tmp_path, capfd):
    target, headers = tmp_path / "unit.so", f"-I{fmi.UNIT / 'headers'}"
    code = (fmi.UNIT / f"fmi{version}.c", fmi.UNIT / "model.c", SOURCES / "layerjam.c")
    run_compiler([*SANITIZED, headers, f"-I{fmi.UNIT}", *map(str, code)], target, libraries=["-lm"])
    made = fmi.build_fmu(version, "one", fmi.brake_values(KAPTON), {"linux": target.read_bytes()})
    (tmp_path / "one.fmu").write_bytes(made)
    unit = Unit(tmp_path / "one.fmu", tmp_path / "unit", version)
    path, vacuum = history(KAPTON, 14, 200)
    unit.start(vacuum=vacuum[0])
    unit.pull(path, vacuum)
    whole, rng, refused = unit.saved(), np.random.default_rng(2), 0
    for i in range(STATES):
        try:
            unit.restore(garbled(whole, rng, fixed=16))
        except Refused as error:
            assert "damaged" in str(error) or "is not allowed" in str(error), error
            refused += 1
            continue
        try:
            assert np.isfinite(unit.pull(path[i % 100 :][:3], vacuum[i % 100 :][:3])).all()
        except Refused as error:
            assert "not running" in str(error), error
        unit.restore(whole)
    assert STATES / 2 < refused < STATES
    assert "runtime error" not in capfd.readouterr().err
