"""What clutch and belt break away at once their sheets have rested; nothing changes for others."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from layerjam.brake.mechanics.friction import holding_force
from layerjam.studies.machines.registry import load_scenario


@pytest.mark.parametrize(
    ("name", "time"),
    [
        ("ankle-clutch", "loading_time"),
        pytest.param("seat-belt", "vacuum_time", marks=pytest.mark.slow),
    ],
)
def test_a_rested_machine_breaks_away_at_its_aged_force(name: str, time: str) -> None:
    plain = load_scenario(name)
    aged = replace(plain, brake=plain.brake.with_(ageing=0.03, static_hold="10 s"))
    before, after = plain.analyse(), aged.analyse()
    assert "aged_holding_force" not in before.own
    # by hand: 0.03 for ten times the hold, at the vacuum in use, on every chain
    own, brake = after.own, aged.brake.brake
    vacuum = own.get("vacuum", aged.brakes.vacuum)
    hold = own[time]
    static = max(brake.film.static + 0.03 * math.log10(hold / 10), brake.film.kinetic)
    flat = float(holding_force(vacuum, brake)) * aged.brakes.parallel
    assert own["aged_holding_force"] == pytest.approx(flat * static / brake.film.static)
    # all else is as it was
    assert {k: v for k, v in own.items() if k != "aged_holding_force"} == before.own
