"""Procedures: typed steps and their text say the same, and contradictions are refused."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.simulate.procedure import (
    MAX_STEPS,
    Evacuate,
    Hold,
    Procedure,
    Pull,
    Return,
    Step,
    Vent,
    parse_procedure,
    simple_pull,
)
from layerjam.core.errors import LayerjamError, ProcedureError

positive = st.floats(1e-6, 100, allow_nan=False)
places = st.floats(0, 10, allow_nan=False)


@st.composite
def procedures(draw: st.DrawFn) -> Procedure:
    steps: list[Step] = []
    place = 0.0
    for _ in range(draw(st.integers(1, 12))):
        kind = draw(st.sampled_from(["evacuate", "vent", "hold", "move"]))
        if kind == "evacuate":
            hold = draw(st.one_of(st.just(0.0), st.floats(0, 1e7)))
            steps.append(Evacuate(to=draw(st.floats(0, 110e3)), hold=hold))
        elif kind == "vent":
            steps.append(Vent())
        elif kind == "hold":
            steps.append(Hold(duration=draw(st.floats(0, 1e7))))
        else:
            new = draw(places)
            if new > place:
                steps.append(Pull(speed=draw(positive), until=new))
            elif new < place:
                steps.append(Return(speed=draw(positive), to=new))
            else:
                steps.append(Vent())
            place = new
    return Procedure(tuple(steps))


@given(procedures())
def test_text_round_trip_to_the_last_bit(procedure: Procedure) -> None:
    text = procedure.text()
    assert parse_procedure(text) == procedure
    assert parse_procedure(text).text() == text


@given(st.text(max_size=80))
def test_any_text_is_a_procedure_or_an_error(text: str) -> None:
    try:
        made = parse_procedure(text)
    except LayerjamError as error:
        assert "\n" not in str(error)
    else:
        assert made.steps


def test_the_house_sentence() -> None:
    made = parse_procedure("evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm")
    assert made == simple_pull(94.5e3, 13e-3, 40e-3)
    assert made.text() == "evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm"
    assert made.highest_vacuum() == 94.5e3


def test_every_sentence() -> None:
    made = parse_procedure(
        " Evacuate  to 50kPa and hold for 5 s;vent; hold 2 min ;\n pull at 1 mm/s to 3 cm; "
        "return at 0.1 in/s until 1 cm; cycle 2 times between 5 mm and 20 mm at 13 mm/s; "
    )
    up, down = Pull(speed=13e-3, until=20e-3), Return(speed=13e-3, to=5e-3)
    assert made.steps == (
        Evacuate(to=50e3, hold=5.0),
        Vent(),
        Hold(duration=120.0),
        Pull(speed=1e-3, until=30e-3),
        Return(speed=2.54e-3, to=10e-3),
        up, down, up, down,
    )  # fmt: skip
    assert Procedure((Vent(),)).highest_vacuum() == 0.0


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "it contains no steps"),
        (" ; ;", "it contains no steps"),
        ("pull at 1 mm/s until 20 mm; pull at 1 mm/s until 10 mm", "does not pull: the crosshead"),
        ("pull at 1 mm/s until 20 mm; pull at 1 mm/s until 20 mm", "already at 20 mm"),
        ("pull at 1 mm/s until 20 mm; return at 1 mm/s to 30 mm", "does not go back"),
        ("return at 1 mm/s to 0 mm", "does not go back"),
        ("cycle 2 times between 20 mm and 5 mm at 1 mm/s", "does not"),
        ("push at 1 mm/s until 20 mm", "is not a step; use one of: evacuate to"),
        ("pull at 1 until 20 mm", "'1' has no unit"),
        ("pull at 1 mm until 20 mm", "not in units of m/s"),
        ("pull at 0 mm/s until 20 mm", "at least 0.0001 mm/s"),
        ("pull at -1 mm/s until 20 mm", "not allowed"),
        ("pull at 1 mm/s until nan mm", "not a number"),
        ("evacuate to -5 kPa", "zero or more"),
        ("evacuate to 50 mm", "units of pressure"),
        ("hold 5 kPa", "units of time"),
        ("hold 1e9 s", "at most"),
        ("pull at 1 mm/s until 1 km", "at most"),
        ("cycle 999 times between 0 mm and 5 mm at 1 mm/s", "999 cycles; the limit is"),
        ("; ".join(["vent"] * (MAX_STEPS + 1)), f"{MAX_STEPS + 1} steps; the limit is {MAX_STEPS}"),
    ],
)
def test_contradictions_are_refused(text: str, why: str) -> None:
    with pytest.raises(ProcedureError) as raised:
        parse_procedure(text)
    assert why in str(raised.value) and "\n" not in str(raised.value)


def test_typed_steps_are_checked_too() -> None:
    with pytest.raises(LayerjamError, match="procedure, pull, speed"):
        Procedure((Pull(speed=0.0, until=0.01),))
    with pytest.raises(LayerjamError, match="procedure, evacuate, to"):
        Procedure((Evacuate(to=float("nan")),))
    with pytest.raises(LayerjamError, match="procedure, hold, duration"):
        Procedure((Hold(duration=-1.0),))


def test_steps_are_frozen() -> None:
    step = Pull(speed=1e-3, until=0.01)
    with pytest.raises(dataclasses.FrozenInstanceError):
        step.until = 0.02  # type: ignore[misc]
