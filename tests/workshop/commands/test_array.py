"""`array`: totals and the pull of equal brakes, as verb and as command."""

from __future__ import annotations

import json

import numpy as np
import pytest

from brake.commands.test_predicted import proven
from layerjam.brake.commands.tensile import tensile
from layerjam.brake.device.brake import mass
from layerjam.brake.device.load import load
from layerjam.cli.main import main
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.workshop.commands.array import array

NAME = "choi2018-kapton"


def test_one_brake_is_the_brake():
    one = array(NAME, vacuum="94.5 kPa")
    pulled = tensile(NAME, vacuum="94.5 kPa", speed="1 mm/s", travel="40 mm")
    assert one.peak_force == pytest.approx(pulled.peak_force, rel=1e-6)
    assert one.mass == pytest.approx(mass(load(NAME).brake))
    assert (one.outcome, one.brakes) == ("BOTTOMED_OUT", 1)


@pytest.mark.parametrize(("parallel", "series"), [(3, 1), (1, 3), (2, 2)])
def test_side_by_side_adds_force_and_in_series_travel(parallel, series):
    one, many = array(NAME, vacuum=80e3), array(NAME, parallel=parallel, series=series, vacuum=80e3)
    assert many.peak_force == pytest.approx(parallel * one.peak_force, rel=1e-9)
    assert many.travel == pytest.approx(series * one.travel)
    assert many.stiffness == pytest.approx(one.stiffness * parallel / series)
    assert many.mass == pytest.approx(parallel * series * one.mass)
    assert many.energy == pytest.approx(parallel * series * one.energy)
    # the record's force over elongation holds the work but for what each drop gives back
    assert many.work >= float(np.trapezoid(many.record.force, many.record.elongation)) * 0.99
    # every chain's brakes slide one after the other: as many peaks as brakes in series
    runs = [i for _, i, what in many.record.order if what == "runs"]
    assert len(set(runs)) == parallel * series


def test_the_peak_elongation_ranges_over_that_of_weaker_and_stronger_brakes():
    sd, file = 0.1, proven(0.1)
    many = array(file, series=3, vacuum=80e3)
    for sign, end in zip((-1, 1), many.interval("peak_elongation"), strict=True):
        factor = file.brake.scale_factor * np.exp(sign * 1.96 * sd)
        brake = evolve(file.brake, scale_factor=float(factor))
        other = array(evolve(file, brake=brake), series=3, vacuum=80e3)
        assert end == pytest.approx(other.peak_elongation, rel=5e-3)


def test_a_pull_that_ends_before_the_travel():
    made = array(NAME, parallel=2, until="5 mm")
    assert (made.outcome, made.end) == ("FINISHED", 5e-3)
    assert made.vacuum == load(NAME).brake.site.atmosphere


@pytest.mark.parametrize(
    ("how", "words"),
    [({"parallel": 0}, "at least 1"), ({"series": 1.5}, "an integer"),
     ({"parallel": 100, "series": 100}, "at most 1000"), ({"vacuum": "200 kPa"}, "atmospheric"),
     ({"parallel": "two"}, "parallel"), ({"until": "0 mm"}, "until")],
)  # fmt: skip
def test_refusals(how, words):
    with pytest.raises(QuantityError, match=words):
        array(NAME, **how)


def test_the_command_says_the_same(capsys):
    words = ["array", NAME, "--parallel", "2", "--series", "2", "--vacuum", "60kPa", "--json"]
    assert main(words) == 0
    said = json.loads(capsys.readouterr().out)
    answer = array(NAME, parallel=2, series=2, vacuum="60 kPa")
    numbers = {k: v for k, v in answer.values.items() if k not in ("intervals", "extrapolated")}
    assert {k: said[k] for k in numbers} == pytest.approx(numbers)
    assert said["intervals"]["energy"] == pytest.approx(dict(answer.intervals["energy"]))
    assert main(["array", NAME, "--parallel", "0"]) == 2
    assert "parallel" in capsys.readouterr().err
