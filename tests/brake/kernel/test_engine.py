"""What the product steps with: the kernel or the law, the same answer, and never an accident."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings

import layerjam as lj
from counts import cases
from layerjam.bench.rig.stepped_brake import SteppedBrake
from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.device.load import load
from layerjam.brake.device.speed_law import SpeedLaw
from layerjam.brake.kernel import engine
from layerjam.brake.kernel.compiler import build_library, cached_library, find_on_path
from layerjam.brake.kernel.kernel import CODE, DEPTH, Kernel
from layerjam.brake.mechanics.pull import least_stiffness
from layerjam.brake.simulate.procedure import Procedure, Pull, Return, parse_procedure, simple_pull
from layerjam.brake.simulate.record import Outcome, TensileRecord
from layerjam.brake.simulate.tensile import tensile
from layerjam.core.errors import CompilerError, ProcedureError, QuantityError
from layerjam.workshop.design.antagonist import pair
from strategies import KAPTON, change, one, random_brakes, seeds

pytestmark = pytest.mark.skipif(find_on_path() is None, reason="no C compiler here")
FILE = load("choi2018-kapton")
NAMES = ("choi2018-kapton", "choi2018-ptfe", "choi2018-polyester", "choi2018-ptfe-fiberglass")
FULL = 94.5e3


@pytest.fixture(autouse=True)
def one_length(monkeypatch: pytest.MonkeyPatch) -> None:
    """All pulls here fit into one block, so that the law is compiled once."""
    monkeypatch.setattr(engine, "BLOCK", 3 * 512)


@contextmanager
def switched(said: str) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(engine.SWITCH, said)
        yield


def both(file: BrakeFile, steps: Procedure, **more: float) -> tuple[TensileRecord, TensileRecord]:
    """The same pull as the product would do it, and by the law."""
    quick = tensile(file, steps, **more)
    with switched("off"):
        slow = tensile(file, steps, **more)
    assert slow.engine == "law"
    return quick, slow


def same(quick: TensileRecord, slow: TensileRecord) -> None:
    """Outcome, length and words are equal; forces within 1e-9 N or 1e-12 of the peak."""
    assert quick.outcome is slow.outcome and quick.warnings == slow.warnings
    assert len(quick.time) == len(slow.time)
    peak = slow.force.max()
    joules = 1e-11 * max(1.0, peak / 200)
    for name, values, spec in quick.columns():
        bound = {"N": max(1e-9, 1e-12 * peak), "J": joules, "m": 1e-14}.get(spec.unit, 0.0)
        assert np.abs(values - getattr(slow, name)).max() <= bound, name


def with_brake(brake: object) -> BrakeFile:
    return dataclasses.replace(FILE, brake=brake)  # type: ignore[arg-type]


def out_back_and_out(seed: int, exponent: bool) -> None:
    """A random brake, the vacuum changed at rest, past the overlap too."""
    rng = np.random.default_rng(seed)
    brake = one(random_brakes(seed, 1, exponent=exponent), 0)
    full, far = brake.site.atmosphere, brake.sheets.overlap
    # so little that the enclosure closes the brake, and as much as there is
    first, second = full * np.exp(rng.uniform(np.log(1e-4), 0, 2))
    near = far * rng.uniform(0.05, 0.5)
    back = far * rng.uniform(0, 0.05)
    steps = [*simple_pull(first, 1e-2, near).steps, Return(speed=1e-2, to=back)]
    steps += simple_pull(second, 1e-2, far * rng.uniform(0.6, 1.2)).steps
    quick, slow = both(with_brake(brake), Procedure(tuple(steps)))
    same(quick, slow)
    if quick.outcome is not Outcome.SEPARATED:
        assert quick.engine == "kernel"


@settings(max_examples=6)
@given(seeds)
def test_a_pull_is_the_same_by_kernel_and_law(seed: int) -> None:
    out_back_and_out(seed, exponent=False)


@pytest.mark.slow
@settings(max_examples=cases(150, 20))
@given(seeds)
def test_many_pulls_are_the_same_by_kernel_and_law(seed: int) -> None:
    out_back_and_out(seed, exponent=bool(seed % 2))


@pytest.mark.parametrize(
    "name",
    [NAMES[0], *(pytest.param(n, marks=pytest.mark.slow) for n in NAMES[1 : cases(4, 2)])],
)
def test_what_is_printed_is_the_same(name: str) -> None:
    """Every digit of the catalogue's results that is shown."""
    words = "evacuate to {}; pull at 13 mm/s until 40 mm; return at 13 mm/s to 5 mm"
    for vacuum in ("94.5 kPa", "0.4 kPa"):
        quick = lj.tensile(name, procedure=words.format(vacuum))
        with switched("off"):
            slow = lj.tensile(name, procedure=words.format(vacuum))
        assert (quick.record.engine, slow.record.engine) == ("kernel", "law")
        assert str(quick) == str(slow)


def test_a_brake_that_snaps_is_the_laws() -> None:
    """Every bit: the kernel would jump to where it holds again, and the record ends before."""
    least = float(least_stiffness(FULL, KAPTON))
    for share in (0.5, 1.0):
        file = with_brake(change(KAPTON, stiffness_measured=share * least))
        quick, slow = both(file, simple_pull(FULL, 13e-3, 0.12))
        assert quick.engine == "law" and quick.outcome is slow.outcome
        assert all((v == getattr(slow, n)).all() for n, v, _ in quick.columns())
    file = with_brake(change(KAPTON, stiffness_measured=1.01 * least))
    quick, slow = both(file, simple_pull(FULL, 13e-3, 0.12))
    assert quick.engine == "kernel"
    same(quick, slow)


def test_a_record_ends_where_the_sheets_part() -> None:
    """At a sample of the pull the kernel knows it; between two, as here with a leak, the law."""
    steps = simple_pull(FULL, 13e-3, 0.1)
    quick, slow = both(FILE, steps)
    assert (quick.engine, quick.outcome) == ("kernel", Outcome.SEPARATED)
    same(quick, slow)
    quick, slow = both(FILE, steps, leak_time=20.0)
    assert (quick.engine, quick.outcome) == ("law", Outcome.SEPARATED)
    same(quick, slow)
    assert Kernel(KAPTON).exact_cycle([0.0, 0.08], FULL) is None
    after = Kernel(KAPTON).exact_cycle(np.append(quick.elongation[:-1], 0.05), FULL)
    assert after is not None and not after.separated.any()


def nested(turns: int) -> Procedure:
    """Loops inside each other at a vacuum at which the enclosure takes part in every turn."""
    steps = [*simple_pull(20e3, 13e-3, 0.04).steps]
    for i in range(turns):
        steps.append(Return(speed=13e-3, to=0.02 + 0.5e-3 * i))
        steps.append(Pull(speed=13e-3, until=0.04 - 0.5e-3 * (i + 1)))
    return Procedure(tuple(steps))


@pytest.mark.slow
def test_as_many_turns_are_refused_by_both() -> None:
    soft = with_brake(change(KAPTON, scale_factor=0.001))
    assert tensile(soft, nested(DEPTH - 4)).engine == "kernel"
    quick, slow = both(soft, nested(DEPTH - 1))
    assert quick.engine == "law", "so near the limit a rounding could decide"
    same(quick, slow)
    for said in ("on", "off"):
        with switched(said), pytest.raises(ProcedureError, match="nested reversals"):
            tensile(soft, nested(DEPTH + 2))


def test_turns_after_the_sheets_parted_do_not_count() -> None:
    """The record ends there; what the procedure does afterwards raises nothing."""
    soft = with_brake(change(KAPTON, scale_factor=0.001))
    steps = (*simple_pull(20e3, 13e-3, 0.1).steps, *nested(DEPTH + 2).steps[2:])
    assert tensile(soft, Procedure(steps)).outcome is Outcome.SEPARATED


SPEEDS = SpeedLaw(power=0.1, test_speed=1e-3, rest_speed=1e-4)
OTHERS = {
    "fan": change(KAPTON, mount__spacers=False),
    "speed": change(KAPTON, speed_law=SPEEDS),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_a_law_that_is_not_in_the_kernel_is_followed_by_the_law(name: str) -> None:
    record = tensile(with_brake(OTHERS[name]), simple_pull(FULL, 13e-3, 5e-3))
    assert record.engine == "law" and record.force.max() > 100


def test_the_kernel_is_for_brakes_that_it_knows() -> None:
    for brake in OTHERS.values():
        assert engine.make_quick_kernel(brake, FULL) is None
    assert engine.make_quick_kernel(change(KAPTON, film__kinetic=0.0), FULL) is None
    assert engine.make_quick_kernel(KAPTON, FULL) is not None


def test_a_speed_law_that_changes_nothing_is_no_hindrance() -> None:
    still = with_brake(change(KAPTON, speed_law=dataclasses.replace(SPEEDS, power=0.0)))
    assert tensile(still, simple_pull(FULL, 13e-3, 5e-3)).engine == "kernel"


@pytest.mark.slow
def test_a_pair_and_a_machine_are_the_same_by_kernel_and_law() -> None:
    angle = np.concatenate([np.linspace(0, 1.5, 60), np.linspace(1.5, -1.5, 120)])
    made, steps = [], []
    path = np.abs(0.03 * np.sin(np.linspace(0, 12, 60)))
    for said in ("on", "off"):
        with switched(said):
            made.append(pair((KAPTON, KAPTON), (50e3, 20e3), angle, 0.02, 1e-3))
            pulled = SteppedBrake(KAPTON)
            assert (pulled._kernel is None) is (said == "off")
            steps.append([pulled.step_to(u, 5e4 + 1e6 * u) for u in path])
    for quick, slow in zip(*made, strict=True):
        assert quick == pytest.approx(slow, rel=1e-12, abs=1e-9)
    assert np.array(steps[0]) == pytest.approx(np.array(steps[1]), rel=1e-12, abs=1e-9)


def test_the_switch_takes_two_words() -> None:
    with switched("no"), pytest.raises(QuantityError, match="'no' is not allowed; set it to off"):
        tensile(FILE, simple_pull(FULL, 13e-3, 1e-3))


@pytest.fixture
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder for compiled libraries."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path


def is_there() -> bool:
    return engine._is_available.__wrapped__()


def test_without_a_compiler_a_library_that_was_built_serves(
    elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = build_library(CODE)
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(elsewhere))
    assert cached_library(CODE) == path and is_there()
    path.write_bytes(b"damaged")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine, "load_library", engine.load_library.__wrapped__)
        assert not is_there()
    path.unlink()
    assert cached_library(CODE) is None and not is_there()


@pytest.mark.parametrize("compiler", ["exit 1", "exec sleep 30", None], ids=str)
def test_a_compiler_that_fails_hangs_or_is_lost_leaves_the_law(
    elsewhere: Path, monkeypatch: pytest.MonkeyPatch, compiler: str | None
) -> None:
    script = elsewhere / "compiler"
    if compiler is not None:
        said = f"#!/bin/sh\ncase $1 in --version) echo {compiler};; *) {compiler};; esac\n"
        script.write_text(said)
        script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    monkeypatch.setattr(engine, "LONGEST", 0.2)
    assert not is_there()
    assert not list(elsewhere.glob("layerjam/*/*.so")), "nothing half built stays"


def test_nowhere_to_keep_a_library_leaves_the_law(
    elsewhere: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (elsewhere / "layerjam").write_text("a file where the folder would be")
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(elsewhere / "layerjam"))
    with pytest.raises(CompilerError, match="no folder for compiled"):
        build_library(CODE)
    assert not is_there()


@pytest.mark.slow
def test_two_processes_build_at_once(elsewhere: Path) -> None:
    """Both get a whole library, and one of them stays."""
    code = "from layerjam.brake.kernel.compiler import *; import ctypes; S = SOURCES\n"
    code += "at = build_library([S / 'layerjam.c', S / 'history.c'])\n"
    code += "print(ctypes.CDLL(str(at)).lj_state_size(), at)"
    run = [subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) for _ in "12"]
    said = [process.communicate(timeout=120)[0] for process in run]
    assert said[0] == said[1] and said[0].split()[0] == b"664"
    assert len(list((elsewhere / "layerjam").rglob("*"))) == 2, "the folder and one library"


def test_threads_that_pull_at_once_get_the_same() -> None:
    steps, found = parse_procedure("evacuate to 60 kPa; pull at 1 mm/s until 20 mm"), []
    pulls = [threading.Thread(target=lambda: found.append(tensile(FILE, steps))) for _ in range(6)]
    for pull in pulls:
        pull.start()
    for pull in pulls:
        pull.join()
    assert len(found) == 6 and all((f.force == found[0].force).all() for f in found)
    assert os.environ.get(engine.SWITCH) is None
