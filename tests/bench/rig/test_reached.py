"""A healthy bench reaches its target: law, procedure and check agree where that is."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

import layerjam.bench.rig
from counts import cases
from layerjam.bench.control import law
from layerjam.bench.control.settings import KINDS, Regulator
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.virtual_plant import read_hardware

LEAKY, TIGHT = (
    "sim:choi2018?speed=0&noise=50Pa&leak=500s&vent=0.2s",
    "sim:choi2018?speed=0&vent=0.2s",
)
TARGETS = (5, 8, 10, 20, 60)
FEW = [(LEAKY, "bang-bang", 5), (TIGHT, "pi", 8)]


def outcome(address: str, kind: str, target: int, out: Path) -> tuple[str, str | None]:
    made = read_hardware(address_of(address))
    with layerjam.bench.rig.open(address) as bench:
        bench.safe_state, bench.vent_rest = "release", "open"
        bench.regulator = Regulator(
            plant=made.plant, sensor=made.sensor, kind=kind, safe_state="release"
        )
        result = bench.run(f"evacuate to {target} kPa and hold 1 s; vent", out=out)
    return result.outcome, result.reason


@pytest.mark.parametrize(("address", "kind", "target"), FEW)
def test_a_healthy_run_reaches_its_target(
    address: str, kind: str, target: int, tmp_path: Path
) -> None:
    assert outcome(address, kind, target, tmp_path / "run.ljrun") == ("FINISHED", None)


@pytest.mark.slow
@pytest.mark.parametrize("address", [LEAKY, TIGHT], ids=["leaky", "tight"])
@pytest.mark.parametrize("kind", list(KINDS))
def test_every_healthy_run_reaches_its_target(address: str, kind: str, tmp_path: Path) -> None:
    for target, repeat in itertools.product(TARGETS, range(cases(3, 1))):
        told = outcome(
            f"{address}&seed={repeat}", kind, target, tmp_path / f"{target}-{repeat}.ljrun"
        )
        assert told == ("FINISHED", None), (target, repeat)


def test_reached_is_where_the_law_lets_pump_and_vent_rest() -> None:
    """Within 1 % of the target, or between band and vent band; noise widens both."""
    settings = (0.0, 0.0, 0.0, 500.0, 1200.0)
    for target, below, above in ((8e3, 500.0, 1200.0), (90e3, 900.0, 1200.0), (150e3, 1500, 1500)):
        for noise in (0.0, 150.0):
            assert law.is_reached(settings, target - below - noise, target, noise)
            assert law.is_reached(settings, target + above + noise, target, noise)
            assert not law.is_reached(settings, target - below - noise - 1.0, target, noise)
            assert not law.is_reached(settings, target + above + noise + 1.0, target, noise)
            assert not law.is_reached(settings, float("nan"), target, noise)
