"""A result takes the fields of the same name from the records behind it."""

import dataclasses
import json
import math
from types import SimpleNamespace

import pytest

import layerjam as lj
from layerjam.core.command.results import Judged, Result, add_prefix, fact, number, result
from layerjam.core.errors import Notice
from layerjam.core.outputs import outputs


@result
class Held(Result):
    """A vacuum that is held."""

    vacuum: float = number("Pa", "the vacuum")
    rise_time: float | None = number("s", "how fast")
    outcome: str = fact("how it ends")
    tuned_vacuum: float | None = number("Pa", "the tuned vacuum", default=None)
    certain: bool = False


LOOP = SimpleNamespace(vacuum=6e4, rise_time=math.nan, outcome="HEALTHY", certain=True)


def test_the_first_record_with_a_name_counts_and_what_is_given_comes_before():
    made = Held.create({"vacuum": 5e4}, LOOP, None, outcome="LEAK")
    assert made.values == {
        "vacuum": 5e4, "rise_time": None, "outcome": "LEAK", "tuned_vacuum": None
    }  # fmt: skip


def test_only_keys_are_taken():
    assert Held.create(LOOP).certain is False


def test_a_prefix_keeps_records_of_one_kind_apart():
    made = Held.create(add_prefix("tuned_", SimpleNamespace(vacuum=1e4, outcome="STOPPED")), LOOP)
    assert (made.vacuum, made.tuned_vacuum, made.outcome) == (6e4, 1e4, "HEALTHY")


def test_a_key_that_nobody_has_raises():
    with pytest.raises(TypeError, match="outcome"):
        Held.create({"vacuum": 5e4, "rise_time": 1.0})


@outputs
class Pump:
    """What a lower folder computes."""

    flow: float = number("m^3/s", "flow", interval=True)
    kind: str = fact("kind")
    holds: float = number("Pa", "vacuum")


@result
class PumpAnswer(Judged, Pump):
    """A result that inherits its keys, one of them further down."""

    file: str | None = fact("file")
    holds: float


PUMPS = PumpAnswer.create(Pump(flow=2e-6, flow_low=1e-6, kind="piston", holds=4e4))


def test_a_result_has_the_keys_of_the_record_it_inherits():
    keys = ["flow", "flow_low", "flow_high", "kind", "file", "holds", "checks"]
    assert list(PUMPS.values) == keys
    shown = json.loads(PUMPS.json())
    assert list(shown)[: len(keys)] == keys and shown["flow_low"] == 1e-6
    unit = "m^3/s"
    assert shown["units"] == {"flow": unit, "flow_low": unit, "flow_high": unit, "holds": "Pa"}


def test_a_number_stands_in_the_table_with_its_interval():
    assert PUMPS.rows() == [
        ("flow", "2 mL/s (95 %: above 1 mL/s)"), ("kind", "piston"), ("holds", "40 kPa")
    ]  # fmt: skip
    assert PUMPS.interval("flow") == (1e-6, None)


def test_a_result_compares_and_prints_as_a_result():
    again = PumpAnswer.create(Pump(flow=2e-6, flow_low=1e-6, kind="piston", holds=4e4))
    assert again == PUMPS and len({PUMPS, again}) == 1
    other = PumpAnswer.create(Pump(flow=2e-6, flow_low=1e-6, kind="piston", holds=4.1e4))
    assert other != PUMPS and PUMPS != 1
    assert repr(PUMPS) == PUMPS.table(100)


def test_every_warning_has_a_key():
    made = Held.create(LOOP, vacuum=5e4, warnings=["plain", Notice("keyed", "own")])
    assert [(w, w.key) for w in made.warnings] == [("plain", "note"), ("keyed", "own")]
    more = made.with_notices(Notice("third", "more"))
    assert [w.key for w in more.warnings] == ["note", "own", "more"]


@pytest.mark.parametrize("call", ["show", "force", "tensile", "drop", "rise"])
def test_the_warnings_of_unmeasured_brakes_and_lines_have_keys(call):
    brake = lj.load("choi2018-polyester")
    assert any("handbook" in w or "assumed" in w for w in brake.warnings())
    pull = {"vacuum": "60 kPa", "speed": "10 mm/s", "travel": "5 mm"}
    calls = {
        "show": lambda: lj.show(brake),
        "force": lambda: lj.force(brake, slip=0.02, vacuum=6e4),
        "tensile": lambda: lj.tensile(brake, **pull),
        "drop": lambda: lj.drop(brake, mass=1, speed=1, vacuum=6e4),
        "rise": lambda: lj.rise("choi2018", target=6e4),
    }
    made = calls[call]()
    assert made.warnings and all(w.key for w in made.warnings)
    record = made.record
    if dataclasses.is_dataclass(record) and not callable(getattr(record, "warnings", None)):
        assert all(w.key for w in getattr(record, "warnings", ()))
