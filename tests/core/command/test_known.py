"""`require`: a result for numbers that can be relied on."""

from __future__ import annotations

import pickle

import pytest

import layerjam as lj
from layerjam.brake.commands.drop import Stop
from layerjam.core.errors import LayerjamError, NotKnownError

KAPTON = "choi2018-kapton"
DROP = {"mass": "1 kg", "speed": 2.5, "vacuum": "tuned"}


def test_a_feasible_result_has_its_numbers() -> None:
    stop = lj.drop(KAPTON, **DROP, travel=0.04)
    sure = stop.require()
    assert sure.slip == stop.slip and sure.vacuum == stop.vacuum and sure.json() == stop.json()
    assert isinstance(sure, Stop) and repr(sure) == repr(stop)
    assert pickle.loads(pickle.dumps(sure)).slip == stop.slip
    with pytest.raises(AttributeError, match="slipp"):
        _ = sure.slipp


def test_an_infeasible_result_says_why() -> None:
    stop = lj.drop(KAPTON, mass="40 kg", speed=9.0, vacuum="tuned", travel=0.04)
    assert stop.slip is None and stop.reason
    with pytest.raises(NotKnownError) as caught:
        stop.require()
    assert str(caught.value) == stop.reason and caught.value.key == "not-known"
    assert isinstance(caught.value, LayerjamError) and isinstance(caught.value, ValueError)


def test_one_infeasible_element_counts() -> None:
    assert lj.vacuum(KAPTON, slip=0.02, force=[50, 100]).require().vacuum.shape == (2,)
    with pytest.raises(NotKnownError, match="143"):
        lj.vacuum(KAPTON, slip=0.02, force=[50, 300]).require()


def test_a_number_that_is_not_known_raises_where_it_is_read() -> None:
    shown = lj.show(lj.load(KAPTON).with_(stiffness_measured=None)).require()
    assert shown.mass == pytest.approx(0.02, rel=1e-4)
    with pytest.raises(NotKnownError, match="stiffness measured: unknown for this case"):
        _ = shown.stiffness_measured
    assert lj.force(KAPTON, slip=0.02, vacuum=5e4).require().force > 0
