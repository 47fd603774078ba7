"""Flows through valve, tube and leak against printed numbers and limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.brake.fluid.flow import (
    LAMINAR,
    NORMAL,
    flow_ratio,
    leak_throughput,
    tube_throughput,
    valve_throughput,
)
from layerjam.laboratory.identify.logs import leak

PRESSURES = st.floats(1.0, 2e5)


def test_the_ellipse_of_iso_6358():
    """Share of the choked flow at b = 0.3 as CKD prints it: 96, 82, 62 and 37 %."""
    shares = [round(flow_ratio(r, 0.3) * 100) for r in (0.5, 0.7, 0.85, 0.95)]
    assert shares == [96, 82, 62, 37]
    assert flow_ratio(0.1) == flow_ratio(0.528) == 1.0
    assert flow_ratio(1.0) == 0.0


def test_mass_flow_of_a_worked_valve():
    """C = 8.5e-9 m^3/(s Pa), b = 0.35, 700 to 500 kPa, 293.15 K: 0.0058394 kg/s (1.185 kg/m^3)."""
    flow = valve_throughput(700e3, 500e3, 8.5e-9, 0.35) / NORMAL * 1.185
    assert flow == pytest.approx(0.005839398199417552, rel=1e-9)


@given(PRESSURES, PRESSURES)
def test_flows_turn_round_with_the_pressures(a, b):
    assert valve_throughput(a, b, 1e-9) == -valve_throughput(b, a, 1e-9)
    assert tube_throughput(a, b, 1.0, 2e-3) == -tube_throughput(b, a, 1.0, 2e-3)
    assert (valve_throughput(a, b, 1e-9) > 0) == (a > b)


def test_no_jump_where_the_straight_part_begins():
    below, above = (flow_ratio(LAMINAR * (1 - 1e-12)), flow_ratio(LAMINAR * (1 + 1e-12)))
    assert below == pytest.approx(above, rel=1e-8)


def test_poiseuille_per_volume_at_the_mean_pressure():
    """Small differences: q/p is the liquid's flow, pi r^4 dp / (8 mu L)."""
    length, bore, p, dp = 1.5, 2e-3, 5e4, 1e-3
    flow = tube_throughput(p + dp / 2, p - dp / 2, length, bore) / p
    assert flow == pytest.approx(np.pi * (bore / 2) ** 4 * dp / (8 * 1.81e-5 * length), rel=1e-6)


@pytest.mark.parametrize("p", [1e3, 4e4, 9e4])
@pytest.mark.parametrize("model", ["laminar", "orifice"])
def test_leaks_are_those_the_pressure_log_fits(p, model):
    sizes = {"laminar": (1e-8, 0.0), "orifice": (0.0, 1e-8)}[model]
    assert leak_throughput(p, 101325.0, *sizes) == pytest.approx(
        -leak.flow(model, p, 1e-8, 101325.0), rel=1e-12
    )
