"""What `make bench` compares with solves the same drops: each neighbour against the exact law."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:  # where pytest was not started as `python -m pytest` in the root
    sys.path.append(str(ROOT))

from benchmarks.comparators import compiled, reference, scipy_drop, tuned_scipy  # noqa: E402
from benchmarks.comparators.drops import Answer, Drops, given, population  # noqa: E402

from benchmarks import gpu, impact, timing  # noqa: E402
from layerjam.brake.mechanics.pull import brake_force  # noqa: E402
from layerjam.brake.mechanics.stop.exact import BOTTOMED_OUT, NEVER_SLID, SNAPS, STOPPED, Stop, stop  # noqa: E402

needs_cc = pytest.mark.skipif(not compiled.compiler(), reason="there is no C compiler (cc) here")


def ours(drops: Drops) -> Stop:
    fixed = drops.spring, drops.gravity, drops.brake
    return Stop(*map(np.asarray, stop(drops.mass, drops.speed, drops.vacuum, *fixed)))


def wide(n: int, seed: int, spring: float | None = None) -> Drops:
    """Drops of every outcome, down to vacuums at which the sleeve saturates and to none at all."""
    random = np.random.default_rng(seed)
    vacuum = 101e3 * 10 ** random.uniform(-4, 0, n) * random.integers(0, 10, n).clip(0, 1)
    drops = given(10 ** random.uniform(-2, 1.1, n), random.uniform(0, 4, n), vacuum)
    return drops if spring is None else replace(drops, spring=spring)


def test_the_drops_slide_and_fewer_are_the_first_of_more():
    many = population(3000)
    outcome = ours(many).outcome
    assert set(outcome.tolist()) == {STOPPED, BOTTOMED_OUT}
    assert np.mean(outcome == STOPPED) > 0.3
    few = population(7)
    for name in ("mass", "speed", "vacuum"):
        assert getattr(few, name).tolist() == getattr(many, name)[:7].tolist()
    again = many.first(7)
    assert again.force.c.tolist() == few.force.c.tolist()


def test_the_force_is_the_law_s():
    drops = wide(500, 1)
    slip = np.random.default_rng(2).uniform(0, drops.travel, len(drops))
    right = np.asarray(brake_force(slip, drops.vacuum, drops.brake))
    assert drops.force.at(slip) == pytest.approx(right, rel=1e-13, abs=1e-13)


def test_the_reference_has_the_check_values_and_more_digits_than_the_law():
    checks = given([1.0, 1.0], [2.5, 3.0], [94.5e3, 80e3])
    found = reference.solve(checks)
    assert found.travel.astype(float) == pytest.approx([17.0251044e-3, 44.0565365e-3], abs=5e-11)
    assert found.peak.astype(float) == pytest.approx([175.925038, 149.007238], abs=5e-7)
    drops = population(2000)
    right, law = reference.solve(drops), ours(drops)
    assert np.abs(law.slip - right.travel).max() < 1e-14
    assert np.abs(law.peak_force - right.peak).max() < 1e-12


def test_the_reference_holds_where_the_sleeve_saturates():
    random = np.random.default_rng(3)
    drops = given(random.uniform(0.05, 0.3, 500), random.uniform(0.5, 2.5, 500),
                  random.uniform(1.2e3, 6e3, 500))  # fmt: skip
    law, right = ours(drops), reference.solve(drops)
    slid = law.outcome != NEVER_SLID
    past = (law.slip > drops.force.saturation) & (law.outcome == STOPPED)
    assert past.sum() > 20
    assert np.abs(law.slip - right.travel)[slid].max() < 1e-13
    with pytest.raises(ValueError, match="falls at the end"):
        reference.solve(given([0.1], [1.0], [500.0]))


@pytest.mark.parametrize("method", ["LSODA", "DOP853"])
def test_scipy_is_as_exact_as_stated(method):
    drops = population(30)
    right = reference.solve(drops).travel
    for accuracy, rtol in scipy_drop.TOLERANCE[method].items():
        assert np.abs(scipy_drop.prepare(drops, method, rtol)() - right).max() < accuracy


@pytest.mark.parametrize("method", ["LSODA", "DOP853"])
def test_scipy_where_the_sleeve_saturates_and_where_nothing_slides(method):
    drops = given([0.05, 0.1, 0.1], [2.0, 1.0, 0.1], [1.3e3, 5e3, 60e3])
    law = ours(drops)
    assert law.slip[0] > drops.force.saturation[0] and law.outcome[2] == NEVER_SLID
    travel = scipy_drop.prepare(drops, method, 1e-9)()
    assert travel == pytest.approx(law.slip, abs=1e-8)


@needs_cc
@pytest.mark.parametrize("spring", [None, 1500.0], ids=["rope", "soft"])
def test_c_gives_all_six_answers_of_the_law(spring):
    drops = wide(20_000, 4, spring)
    law, kernel = ours(drops), Stop(*compiled.prepare(drops)())
    wanted = {STOPPED, NEVER_SLID, BOTTOMED_OUT} | ({SNAPS} if spring else set())
    assert set(law.outcome.tolist()) == wanted
    differ = law.outcome != kernel.outcome
    assert differ.sum() <= 1
    for name in ("slip", "peak_force", "heat", "stored"):
        right = getattr(law, name)
        near = np.abs(getattr(kernel, name) - right) <= 1e-12 + 1e-11 * np.abs(right)
        assert (near | differ).all(), name
    # the speed is a root: near the end of a stop it keeps half of the digits
    assert np.abs(kernel.end_speed**2 - law.end_speed**2)[~differ].max() < 1e-11


@needs_cc
def test_c_answers_nan_where_the_law_does():
    drops = given([1.0, -1.0, 1.0, 1.0], [2.5, 2.5, -1.0, 2.5], [94.5e3, 94.5e3, 94.5e3, np.nan])
    kernel, law = Stop(*compiled.prepare(drops)()), ours(drops)
    for name in ("slip", "peak_force", "end_speed", "heat", "stored"):
        assert np.isnan(getattr(kernel, name)).tolist() == [False, True, True, True]
        assert np.isnan(getattr(law, name)).tolist() == [False, True, True, True]


@needs_cc
def test_a_kernel_that_does_not_compile_says_why(tmp_path, monkeypatch):
    (tmp_path / "broken.c").write_text("int broken(void) { return nothing; }\n")
    monkeypatch.setattr(compiled, "HERE", tmp_path)
    with pytest.raises(RuntimeError, match="nothing"):
        compiled.library("broken")


def test_without_a_compiler_the_c_rows_are_left_out_in_plain_words(monkeypatch):
    monkeypatch.setattr(compiled, "compiler", lambda: None)
    assert impact.compiled_c() == []
    assert "no C compiler" in impact.compiler_missing()
    with pytest.raises(RuntimeError, match="no C compiler"):
        compiled.library("absent")


@pytest.mark.slow
def test_diffrax_is_as_exact_as_stated():
    pytest.importorskip("diffrax", reason="diffrax is not installed: `make bench` brings it")
    from benchmarks.comparators import diffrax_drop

    drops = population(200)
    right = reference.solve(drops).travel
    for accuracy, rtol in diffrax_drop.TOLERANCE.items():
        found = np.asarray(diffrax_drop.prepare(drops, rtol)())
        assert np.abs(found - right).max() < accuracy
    low = given([0.05], [2.0], [1.3e3])
    assert ours(low).slip > low.force.saturation
    found = np.asarray(diffrax_drop.prepare(low, 1e-9)())
    assert found == pytest.approx(ours(low).slip, abs=1e-8)


def test_mujoco_comes_near_and_nearer_with_a_finer_step():
    pytest.importorskip("mujoco", reason="mujoco is not installed: `make bench` brings it")
    from benchmarks.comparators import mujoco_drop

    drops = population(10)
    right = reference.solve(drops)
    stops = right.travel < drops.travel
    worst = {}
    for step in (1e-4, mujoco_drop.STEP):
        found = mujoco_drop.prepare(drops, step)()
        off = np.abs(found.travel - right.travel)
        assert off[~stops].max() == 0
        worst[step] = off.max()
        # the slider of mass m rings on the spring k: up to v sqrt(k m) on top of the force
        ring = drops.speed * np.sqrt(drops.spring * mujoco_drop.SLIDER)
        assert ((found.peak - right.peak) < 1.1 * ring + 0.5).all()
        assert (found.peak > right.peak - 0.5).all()
    assert worst[mujoco_drop.STEP] < min(1e-4, worst[1e-4])


def test_errors_are_measured_not_stated():
    """A method that is 1 um and 2 N off is shown so; the exact one is not."""

    def off(drops: Drops):
        right = reference.solve(drops)
        return lambda: Answer(right.travel + 1e-6, right.peak - 2.0)

    exact = impact.Method(
        "exact", 40, lambda drops: lambda: reference.solve(drops).travel, kind="ours"
    )
    rows = impact.measure([exact, impact.Method("off", 20, off, wanted=1e9)], rounds=1)
    assert (rows[0].median_error, rows[0].worst_error, rows[0].peak_error) == (0, 0, None)
    assert rows[1].median_error == pytest.approx(1e-6)
    assert rows[1].worst_error == pytest.approx(1e-6)
    assert rows[1].peak_error == pytest.approx(2.0)
    table = impact.markdown(rows)
    assert "| exact | 40 | 0e+00 / 0e+00 |  |" in table
    assert "| off | 20 | 1e-06 / 1e-06 | 2e+00 |" in table and "MISSED" in table


def test_the_neighbours_lock_agrees_with_the_main_one():
    pins = {}
    for path in (ROOT / "requirements.lock", ROOT / "benchmarks" / "requirements.lock"):
        text = path.read_text(encoding="utf-8")
        assert "://" not in text and "file:" not in text
        blocks = re.split(r"^(?=[a-z])", text, flags=re.MULTILINE)[1:]
        assert all(re.search(r"--hash=sha256:[0-9a-f]{64}", block) for block in blocks)
        heads = [block.split("\\")[0].strip() for block in blocks]
        pins[path.parent.name] = {head.split("==")[0]: set() for head in heads}
        for head in heads:
            pins[path.parent.name][head.split("==")[0]].add(head)
    neighbours, main = pins["benchmarks"], pins[ROOT.name]
    assert {"diffrax", "mujoco", "jax"} <= set(neighbours)
    for name in set(neighbours) & set(main):
        assert neighbours[name] == main[name], "run `make lock`"


def test_the_picture_names_every_method():
    rows = [
        impact.Measured(impact.Method("ours", 1, lambda d: d, kind="ours"), 2e-8, 0, 1e-16, None),
        impact.Measured(impact.Method("other", 1, lambda d: d), 3e-3, 0, 4e-7, None),
    ]
    (axes,) = impact.draw(rows, "somewhere").axes
    shown = [text.get_text() for text in (*axes.get_yticklabels(), *axes.texts)]
    for words in ("ours", "other", "20 ns, exact to rounding", "3 ms, 400 nm off", "somewhere"):
        assert words in shown


def test_what_a_law_moves_is_its_arrays(monkeypatch):
    monkeypatch.setattr(gpu, "_seconds", lambda law, arrays, blocks: 2.0 * blocks)
    rows = {(row.name, row.blocks): row for row in gpu.moved(40)}
    assert set(rows) == {(n, b) for n in ("drops", "force law", "designs") for b in (1, gpu.BLOCKS)}
    law = rows["force law", 1]
    assert law.bytes == 3 * 8 * 40 and law.copied == 16 * 40 / 2
    assert law.share == pytest.approx(1.5) and rows["force law", 10].share == pytest.approx(0.15)


def test_the_gpu_script_says_where_nothing_was_measured(capsys, monkeypatch):
    monkeypatch.setattr(gpu, "gpus", lambda: [])
    assert gpu.main() == 0
    assert "no GPU here: nothing was measured" in capsys.readouterr().out


@pytest.mark.slow
def test_the_gpu_script_runs_on_what_is_there(capsys, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gpu, "gpus", lambda: jax.devices("cpu"))
    monkeypatch.setattr(gpu, "COUNTS", (1000,))
    assert gpu.main() == 0
    out = capsys.readouterr().out
    assert "layerjam stop, jit, 1,000" in out and "double precision" in out
    assert out.count("| designs | 1,000 |") == 2 and (tmp_path / "out/bench/gpu.svg").is_file()


def test_the_lines_of_the_readme_are_timed_beside_a_script_with_the_same_result(
    capsys: pytest.CaptureFixture[str],
) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = dict(re.findall(r"```python\n(.*?)```\s+```text\n(.*?)```", readme, re.S))
    printed = blocks[timing.README.removeprefix("\n")]
    tuned_scipy.main()
    assert capsys.readouterr().out == printed


def test_a_missed_aim_is_printed_beside_the_ratio() -> None:
    def row(value: float) -> timing.Row:
        return timing.Row("tune", value, other=1.0, other_name="SciPy script", target_ratio=1.5)

    met, missed = timing.table([row(1.4), row(1.6)]).splitlines()
    assert "within 1.5x" in met and "1.40x SciPy script (1 s)" in met
    assert "missed 1.5x" in missed and "1.60x SciPy script (1 s)" in missed


def test_a_timed_process_has_its_caches_in_a_folder_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", "elsewhere")
    code = "import os, pathlib; pathlib.Path('seen').write_text(repr(dict(os.environ)))"
    assert timing.cpu([sys.executable, "-c", code], tmp_path) > 0
    seen = (tmp_path / "seen").read_text()
    assert "elsewhere" not in seen and repr(str(tmp_path / "cache")) in seen
