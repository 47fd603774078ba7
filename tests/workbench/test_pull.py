"""The page of pulls without a browser: its questions, overlaid files, what it gives away."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from layerjam.brake.commands.stick_slip import stick_slip
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.load import load
from layerjam.brake.simulate.record import Outcome
from layerjam.cli.main import main
from layerjam.workbench.answer import file_bytes
from layerjam.workbench.charts import round_up
from layerjam.workbench.desk import Desk
from layerjam.workbench.outcomes import PULLS, describe_pull, describe_stick_slip
from layerjam.workbench.pages.pull import Pull
from layerjam.workbench.pages.pull_chart import pull_chart
from layerjam.workbench.pages.pull_files import Reading, find_pulls, read_pulls
from layerjam.workbench.state import State
from layerjam.workshop.commands.show import show
from printed import split_command

KAPTON = "choi2018-kapton"
PULL = {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "30 mm"}


@pytest.fixture
def page_of():
    made: list[Pull] = []

    def make(**settings) -> Pull:
        page = Pull(Desk(State(page="pull", settings={"pull": settings})))
        made.append(page)
        return page

    yield make
    for page in made:
        page.uploads.close()


def measured(scale: float = 1.0) -> bytes:
    """A pull as a machine would write it: the model's curve with a known error."""
    record = tensile(KAPTON, **PULL).record
    rows = zip(record.time, record.elongation * 1e3, record.force * scale, strict=True)
    lines = ["Time (s),Extension (mm),Load (N)"]
    lines += [f"{t:.6f},{x:.6f},{f:.6f}" for t, x, f in rows]
    return "\n".join(lines).encode()


def test_each_model_asks_its_verb(page_of):
    page = page_of(vacuum=60e3, travel=0.03)
    assert page.compute()[0].result.values == tensile(KAPTON, **PULL).values
    stack = page_of(vacuum=60e3, travel=0.03, model="stack").compute()[0].result
    assert stack.values == tensile(KAPTON, **PULL, model="stack").values
    call = page_of(vacuum=60e3, model="judder", damping=5.0).calls()[0]
    options = ("--vacuum", "60 kPa", "--speed", "1 mm/s", "--damping", "5 N s/m")
    words = ["layerjam", "stick-slip", "choi2018-kapton", *options]
    assert split_command(call.command_line()) == words


@pytest.mark.slow
def test_the_saw_is_that_of_stick_slip_and_its_copy(page_of):
    page = page_of(vacuum=60e3, model="judder", damping=5.0)
    answer = page.compute()[0].result
    own = stick_slip(KAPTON, vacuum="60 kPa", speed="1 mm/s", damping="5 N s/m")
    assert answer.values == own.values


def test_files_are_held_against_the_model_and_what_is_left_over_is_drawn(page_of):
    page = page_of(vacuum=20e3)
    page.uploads.store_file("../../a pull.csv.toml", b'vacuum = "60 kPa"\n')
    page.uploads.store_file("../../a pull.csv", measured(1.1))
    page.result = answer, whole, reading, _ = page.compute()
    assert [c.call.name for c in page.answers()] == ["tensile", "pull", "validate"]
    assert not reading.lacks_vacuum
    (curve,) = reading.curves
    assert curve.vacuum == 60e3
    # ten percent more than the model leaves a tenth of it over
    np.testing.assert_allclose(curve.residual, 0.1 * curve.model, rtol=0.02)
    np.testing.assert_array_equal(curve.residual, curve.measured - curve.model)
    assert list(reading.shown_name(p) for p in reading.pull_result.understood) == ["a pull.csv"]
    words = ["layerjam", "validate", "choi2018-kapton", "a pull.csv"]
    assert split_command(page.answers()[2].call.command_line()) == words
    chart = pull_chart(answer.result, whole, reading, False)
    below = [s for s in chart["series"] if s["yAxisIndex"] == 1]
    assert [s["name"] for s in below] == ["60 kPa, a pull.csv, residual"]
    drawn = [y for _, y in below[0]["data"] if y is not None]
    assert min(drawn) > 0
    # cursor: every curve has its points at the same places
    assert len({tuple(x for x, _ in s["data"]) for s in chart["series"]}) == 1
    # read once: dragging the vacuum leaves the files alone
    assert page.compute()[2] is reading


def test_a_file_without_a_vacuum_takes_the_one_given_for_it(page_of):
    page = page_of(vacuum=20e3, files_vacuum=60e3)
    page.uploads.store_file("pull.csv", measured())
    reading = page.compute()[2]
    assert reading.lacks_vacuum
    assert reading.curves[0].vacuum == 60e3
    assert reading.curves[0].mape < 0.01
    page.desk.put_setting("pull", "files_vacuum", 30e3)
    assert page.compute()[2].curves[0].vacuum == 30e3


@pytest.mark.parametrize("rubbish", [b"", b"\x00\xff" * 500, b"no numbers here\n", b"a,b\n1,2\n"])
def test_rubbish_is_refused_in_words_and_the_pull_stays(page_of, rubbish):
    page = page_of()
    page.uploads.store_file("rubbish.csv", rubbish)
    answer, _, reading, _ = page.compute()
    assert answer.result.peak_force > 0
    (problem,) = (one.refusal for one in reading.answers)
    assert "rubbish.csv" in problem
    assert "layerjam-" not in problem
    assert "/" not in problem.replace("and/or", "")


def test_no_file_no_question(page_of):
    page = page_of()
    assert find_pulls(page.desk) == ()
    assert read_pulls((), page.desk.brake_subject(), "1 kPa", print) == Reading()


def test_the_force_axis_stands_still_while_vacuum_is_dragged():
    whole = show(KAPTON)
    tops = set()
    for vacuum in ("5 kPa", "50 kPa", "101 kPa"):
        chart = pull_chart(tensile(KAPTON, **PULL | {"vacuum": vacuum}), whole, Reading(), False)
        tops.add(chart["yAxis"][0]["max"])
    assert tops == {200.0}
    for force in (0.3, 7.0, 188.6, 1900.0):
        assert force < round_up(force) < 2 * force


@pytest.mark.parametrize("ending", ["svg", "png"])
def test_the_figure_taken_away_is_that_of_the_command(page_of, tmp_path, capsys, ending):
    page = page_of(vacuum=60e3, travel=0.03)
    answer = page.compute()[0].result
    out = tmp_path / f"figure.{ending}"
    command = split_command(page.calls()[0].command_line())[1:]
    assert main([*command, "--figure", str(out), "--json"]) == 0
    capsys.readouterr()
    assert file_bytes(answer, ending) == out.read_bytes()


def test_the_record_taken_away_reads_back(tmp_path):
    answer = tensile(KAPTON, **PULL)
    text = file_bytes(answer, "csv").decode()
    assert text.startswith("# layerjam")
    assert load(KAPTON).name in text


@pytest.mark.parametrize(
    ("procedure", "words"),
    [
        ("evacuate to 60 kPa; pull at 1 mm/s until 20 mm", "Pulled to 20 mm"),
        ("evacuate to 60 kPa; pull at 1 mm/s until 90 mm", "came apart at 68"),
        (
            "evacuate to 60 kPa; pull at 1 mm/s until 20 mm; return at 1 mm/s to 18 mm; vent; "
            "hold 1 s; return at 1 mm/s to 0 mm",
            "pulled the brake back",
        ),
    ],
)
def test_every_pull_ends_in_a_sentence(procedure, words):
    assert words in describe_pull(tensile(KAPTON, procedure=procedure))


def test_a_sentence_for_every_outcome_that_a_pull_can_have():
    for outcome in Outcome:
        record = SimpleNamespace(elongation=np.array([0.0, 0.01]), speed=0.001)
        found = SimpleNamespace(outcome=str(outcome), record=record, events=3)
        for said in (describe_pull(found), describe_stick_slip(found)):
            assert said.endswith(".") and said[0].isupper()
        assert (outcome in describe_pull(found)) == (outcome not in PULLS)
