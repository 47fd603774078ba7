"""The stack in the test machine: procedures, the record, the Monte Carlo, the command."""

from __future__ import annotations

import contextlib
import io
import json
from functools import partial

import numpy as np
import pytest

from layerjam.brake.commands import tensile
from layerjam.brake.device.load import load
from layerjam.brake.mechanics.pull import force_at_elongation, peak
from layerjam.brake.simulate.procedure import parse_procedure, simple_pull
from layerjam.brake.simulate.stack import tensile_stack
from layerjam.brake.simulate.stack_layout import Housing, Interfaces
from layerjam.brake.simulate.stack_spread import draw_normal, peak_spread
from layerjam.brake.simulate.tensile import tensile as lumped
from layerjam.cli.generate import Ticker
from layerjam.cli.main import main
from layerjam.core.errors import ProcedureError, QuantityError
from strategies import KAPTON, area, change

FULL = 94.5e3
FILE = load("choi2018-kapton")


def test_a_whole_pull_meets_the_lumped_brake_after_onset_and_its_energy_closes():
    record, result = tensile_stack(FILE, simple_pull(FULL, 0.013, 0.040))
    late = record.elongation > 5e-3
    law = np.asarray(force_at_elongation(record.elongation, FULL, KAPTON))
    assert record.force[late] == pytest.approx(law[late], rel=1e-3)
    assert record.force.max() == pytest.approx(float(peak(FULL, 0.06, KAPTON).force), rel=2e-3)
    # the sleeve's root adds to the very first micrometres; past them the slope is the measured one
    rise = (record.force > 30) & (record.force < 70) & (record.elongation < 1e-3)
    slope = np.polyfit(record.elongation[rise], record.force[rise], 1)[0]
    assert slope == pytest.approx(KAPTON.stiffness_measured, rel=2e-3)
    assert record.work == pytest.approx(area(record.force, record.elongation), abs=3e-6)
    left = record.work - record.dissipated_energy - record.stored_energy
    assert np.abs(left).max() < 1e-12 * record.work[-1]
    assert (np.diff(record.dissipated_energy) >= 0).all()
    onset = result.sliding.argmax(axis=0)
    assert len(set(onset.tolist())) > 1, "all interfaces let go at once"
    assert record.time[-1] == pytest.approx(0.040 / 0.013)


def test_a_procedure_with_returns_holds_and_cycles_follows_the_lumped_brake():
    steps = parse_procedure(
        "evacuate to 94.5 kPa and hold 2 s; pull at 13 mm/s until 30 mm; hold 5 s; return at "
        "13 mm/s to 27 mm; cycle 2 times between 29 mm and 35 mm at 10 mm/s; return at 5 mm/s to "
        "0 mm"
    )
    record, result = tensile_stack(FILE, steps)
    other = lumped(FILE, steps)
    assert str(record.outcome) == "FINISHED"
    assert record.time[0] == 2.0
    assert record.time[-1] == pytest.approx(other.time[-1])
    assert record.elongation[-1] == 0
    assert record.force[-1] == 0
    assert record.work[-1] == pytest.approx(other.work[-1], rel=2e-3)
    assert record.dissipated_energy[-1] == pytest.approx(other.dissipated_energy[-1], rel=2e-3)
    assert record.slip[-1] == pytest.approx(other.slip[-1], rel=2e-3)
    assert result.slack[-1]
    outside = area(record.force, record.elongation)
    assert record.work == pytest.approx(outside, abs=1e-4 * outside.max())


def test_outcomes():
    record, _ = tensile_stack(FILE, simple_pull(FULL, 0.013, 0.090))
    assert str(record.outcome) == "SEPARATED"
    assert "the sheets separated" in record.warnings[-1]
    low = parse_procedure("evacuate to 2 kPa; pull at 9 mm/s until 40 mm; return at 9 mm/s to 0 mm")
    record, _ = tensile_stack(FILE, low)
    assert str(record.outcome) == "CLOSED_BY_SLEEVE"
    record, _ = tensile_stack(FILE, simple_pull(FULL, 0.013, 0.064))
    assert any("usable travel" in w for w in record.warnings)
    soft = change(KAPTON, stiffness_measured=2000.0)
    file = FILE.__class__(name="soft", brake=soft, sources={}, text="")
    record, _ = tensile_stack(file, simple_pull(FULL, 0.013, 0.15))
    assert str(record.outcome) == "SNAPS"
    assert record.force[-1] == pytest.approx(176, abs=2)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("pull at 1 mm/s until 2 mm", "starts with an evacuation"),
        ("evacuate to 9 kPa; hold 2 s", "pulls at least once"),
        ("evacuate to 9 kPa; pull at 1 mm/s until 2 mm; vent", "'vent' needs the lumped model"),
        (
            "evacuate to 9 kPa; pull at 1 mm/s until 2 mm; evacuate to 5 kPa",
            "'evacuate to 5 kPa' needs the lumped model",
        ),
    ],
)
def test_what_the_stack_cannot_follow_is_refused_with_a_reason(text, why):
    with pytest.raises(ProcedureError, match=why):
        tensile_stack(FILE, parse_procedure(text))


def test_housing_and_static_friction_reach_the_record():
    steps = simple_pull(FULL, 0.013, 0.01)
    plain, _ = tensile_stack(FILE, steps)
    housed, run = tensile_stack(FILE, steps, housing=Housing(friction=5.0))
    assert run.slip.shape[1] == 12
    assert housed.force.max() == pytest.approx(plain.force.max() + 10, rel=2e-3)
    assert housed.slip.max() == pytest.approx(plain.slip.max(), rel=2e-2)
    assert housed.sleeve_force == pytest.approx(run.faces.sum(axis=1))
    stiff, _ = tensile_stack(FILE, steps, static=True)
    assert stiff.force.max() > plain.force.max() + 10
    assert stiff.force[-1] == pytest.approx(plain.force[-1], rel=1e-6)


# --- Monte Carlo


def test_scatter_spreads_the_peak_as_the_sum_of_ten_frictions():
    spread = peak_spread(FILE, FULL, 0.10, samples=4000)
    assert spread.count == 4000
    assert spread.peak.mean() == pytest.approx(176.1, rel=2e-3)
    assert spread.peak.std(ddof=1) == pytest.approx(175.43 * 0.10 / 10**0.5, rel=0.03)
    assert spread.stiffness.mean() == pytest.approx(131e3, rel=6e-3)
    assert spread.stiffness.std() > 0
    assert (spread.onset < spread.peak).all()
    none = peak_spread(FILE, FULL, 0.0, samples=3)
    assert np.ptp(none.peak) == 0


def test_chunks_seeds_and_threads(monkeypatch):
    whole = peak_spread(FILE, FULL, 0.2, samples=300, seed=7)
    parts = peak_spread(FILE, FULL, 0.2, samples=300, seed=7, chunk=37)
    assert (whole.peak == parts.peak).all()
    assert (whole.stiffness == parts.stiffness).all()
    for threads in (1, 3):
        monkeypatch.setattr("layerjam.core.threads.core_count", lambda n=threads: n)
        some = peak_spread(FILE, FULL, 0.2, samples=300, seed=7)
        assert (whole.peak == some.peak).all()
        assert (whole.stiffness == some.stiffness).all()
    assert (peak_spread(FILE, FULL, 0.2, samples=300, seed=8).peak != whole.peak).all()
    assert (draw_normal(5, 9, 10, 3) == draw_normal(0, 9, 10, 3)[5:]).all()
    many = draw_normal(0, 20000, 10, 3)
    assert many.mean() == pytest.approx(0, abs=0.01)
    assert many.std() == pytest.approx(1, abs=0.01)
    assert np.abs(np.corrcoef(many.T) - np.eye(10)).max() < 0.03


def test_an_interrupt_ends_it_without_a_result():
    told = []

    def stop(done, asked):
        told.append((done, asked))
        if done >= 200:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        peak_spread(FILE, FULL, 0.1, samples=1000, chunk=100, progress=stop)
    assert told == [(100, 1000), (200, 1000)]


def test_layouts_hold_for_all_stacks_of_a_batch():
    weak = peak_spread(
        FILE, FULL, 0.05, samples=50, interfaces=Interfaces.missing_vacuum(11, 0.5),
        housing=Housing(friction=3.0), static=False,
    )  # fmt: skip
    share = np.asarray(Interfaces.missing_vacuum(11, 0.5).vacuum).mean()
    assert weak.peak.mean() == pytest.approx(175.43 * share + 6.6, rel=0.02)
    for wrong in ({"scatter": -1.0}, {"scatter": 3.0}, {"samples": 0}, {"seed": -1}):
        with pytest.raises(QuantityError):
            peak_spread(FILE, FULL, **{"scatter": 0.1, **wrong})  # type: ignore[arg-type]
    with pytest.raises(QuantityError, match="there is no friction to vary"):
        peak_spread(FILE, 0.0, 0.1)


# --- the verb and the command


def test_the_verb_tells_the_spread_unless_it_is_stopped():
    def stop(what, share):
        if what == "scatter" and share >= 0.5:
            raise KeyboardInterrupt

    pull = partial(
        tensile.tensile, "choi2018-kapton", vacuum="94.5kPa", speed="13mm/s", travel="3mm",
        model="stack", scatter="10%",
    )  # fmt: skip
    with pytest.raises(KeyboardInterrupt):
        pull(samples=4000, progress=stop)
    answer = pull(samples=2000)
    assert answer.samples == 2000
    assert answer.peak_sd == pytest.approx(5.5, rel=0.1)
    assert answer.units["stiffness_sd"] == "N/m"


def test_options_of_the_stack_are_refused_for_the_lumped_brake():
    more = {"vacuum": "9kPa", "speed": "1mm/s", "travel": "3mm"}
    rubs = {"housing": Housing(friction=1.0)}
    for wrong in ({"static": True}, {"one_by_one": True}, {"scatter": 0.1}, rubs):
        with pytest.raises(QuantityError, match="model 'stack'"):
            tensile.tensile("choi2018-kapton", **more, **wrong)
    for wrong in ({"scatter": "-1%"}, {"scatter": "0.1", "samples": 1}, {"one_by_one": True}):
        with pytest.raises(QuantityError):
            tensile.tensile("choi2018-kapton", model="stack", **more, **wrong)


def test_the_command():
    said = io.StringIO()
    words = "tensile choi2018-kapton --vacuum 94.5kPa --speed 13mm/s --travel 3mm --model stack"
    with contextlib.redirect_stdout(said):
        code = main([*words.split(), "--static", "--scatter", "10%", "--samples", "40", "--json"])
    assert code == 0
    answer = json.loads(said.getvalue())
    assert answer["samples"] == 40
    assert answer["peak_mean"] > 190
    assert set(answer["units"]) >= {"peak_sd", "onset_mean"}


def test_the_command_takes_the_order_of_breaks():
    pulled = {"vacuum": "94.5kPa", "speed": "13mm/s", "travel": "3mm", "model": "stack"}
    uneven = {"interfaces": Interfaces(friction=np.exp(0.4 * np.sin(np.arange(10) ** 2)))}
    more = {"static": True, "scatter": "30%", "samples": 200, **pulled, **uneven}
    peaks = [tensile.tensile("choi2018-kapton", one_by_one=o, **more) for o in (False, True)]
    assert len({p.peak_force for p in peaks}) == len({p.peak_mean for p in peaks}) == 2


def test_progress_is_said_after_two_seconds_only(capsys, monkeypatch):
    clock = [0.0]
    monkeypatch.setattr("layerjam.cli.generate.time.monotonic", lambda: clock[0])
    ticker = Ticker()
    for at, share in ((1.0, 0.1), (3.1, 0.3), (3.6, 0.4), (4.2, 0.5)):
        clock[0] = at
        ticker("pull", share)
    assert capsys.readouterr().err == "layerjam: pull 30%\nlayerjam: pull 50%\n"


@pytest.mark.parametrize("count", [11, 24])
def test_sheets_that_fan_out_slide_as_the_lumped_law_says(count):
    """Off the staggered peak the stack has the force of the lumped law, and keeps its energy."""
    file = FILE.with_(spacers=False, count=count, stiffness_measured="400 kN/m")
    record, pull = tensile_stack(file, simple_pull(FULL, 0.013, 0.040))
    late = record.elongation > 0.015
    due = np.asarray(force_at_elongation(record.elongation, FULL, file.brake))
    np.testing.assert_allclose(record.force[late], due[late], rtol=1e-3)
    balance = record.work - record.dissipated_energy - record.stored_energy
    assert np.abs(balance).max() < 1e-12
    summed = np.trapezoid(record.force, record.elongation)
    assert record.work[-1] == pytest.approx(summed, rel=1e-4)
    # the middle interfaces are pressed most, by exp(alpha (1 - s^2)) with s from the middle out
    held = np.abs(pull.interface[np.argmax(record.force)])
    free = 0.011 + float(record.slip[np.argmax(record.force)])
    alpha = 2 * 0.875 / 1.048 * 0.24 * 0.254e-3 * (count / 4) ** 2 / free
    s = 1 - 1 / (count - 1)
    middle = np.sort(held)[-1]
    assert middle / held[0] == pytest.approx(np.exp(alpha * s**2), rel=0.02)
