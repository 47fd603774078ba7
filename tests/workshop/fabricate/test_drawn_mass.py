"""The mass as drawn, without any file of a build."""

from __future__ import annotations

import math

import pytest

import layerjam as lj
from built_parts import KAPTON
from layerjam.workshop.fabricate.drawn_mass import drawn_mass

# section 2.5 of the specification [mm³, mm²]
CAP, PLATE, SHEET = 3613.35961, 276.39516, 1097.39491


def test_the_sum_by_hand() -> None:
    """Film, silicone, plastic and steel of the specification's printed numbers."""
    spacer = 6 * 13 - math.pi / 4 * 3**2 - (4 - math.pi) * 0.5**2
    film = 11 * (SHEET + spacer) * 0.254 * 1420e-9
    tube = ((13 + 2) * (2.794 + 2) - 13 * 2.794) * 126 * KAPTON.brake.enclosure.density * 1e-9
    printed = 2 * (CAP + PLATE) * 1150e-9
    screw = 0.9 * math.pi / 4 * (5.5**2 * 3 + 3**2 * 8)
    nut = (math.sqrt(3) / 2 * 5.5**2 - math.pi / 4 * 3**2) * 2.4
    steel = 2 * (screw + nut) * 7850e-9
    assert drawn_mass(KAPTON) == pytest.approx(film + tube + printed + steel, rel=1e-7)
    assert lj.show(KAPTON).drawn_mass == drawn_mass(KAPTON)


def test_it_is_the_mass_of_the_build_and_not_the_papers() -> None:
    heavier = KAPTON.with_(fittings_mass="30 g")
    assert lj.show(heavier).mass > lj.show(KAPTON).mass
    assert lj.show(heavier).drawn_mass == lj.show(KAPTON).drawn_mass
    wider = KAPTON.with_(width="14 mm")
    assert lj.show(wider).drawn_mass > lj.show(KAPTON).drawn_mass


@pytest.mark.parametrize(
    "changes",
    [{"width": "7 mm"}, {"count": 400}, {"screw_hole": "1.5 mm"}],
    ids=["too narrow for its nut", "no screw long enough", "no screw thin enough"],
)
def test_what_cannot_be_drawn_has_no_mass(changes: dict[str, object]) -> None:
    found = lj.show(KAPTON.with_(**changes))
    assert found.drawn_mass is None and "drawn mass" not in str(found)
    assert found.mass > 0
