"""A result takes the fields of the same name from the records behind it."""

import math
from types import SimpleNamespace

import pytest

from layerjam.commands.results import Result, fact, number, prefixed, result


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
    made = Held.of({"vacuum": 5e4}, LOOP, None, outcome="LEAK")
    assert made.values == {
        "vacuum": 5e4, "rise_time": None, "outcome": "LEAK", "tuned_vacuum": None
    }  # fmt: skip


def test_only_keys_are_taken():
    assert Held.of(LOOP).certain is False


def test_a_prefix_keeps_records_of_one_kind_apart():
    made = Held.of(prefixed("tuned_", SimpleNamespace(vacuum=1e4, outcome="STOPPED")), LOOP)
    assert (made.vacuum, made.tuned_vacuum, made.outcome) == (6e4, 1e4, "HEALTHY")


def test_a_key_that_nobody_has_raises():
    with pytest.raises(TypeError, match="outcome"):
        Held.of({"vacuum": 5e4, "rise_time": 1.0})
