"""Random brakes are built right or refused in words; never a broken mesh."""

from __future__ import annotations

import pytest

from built_parts import read_step, some_brakes
from counts import cases
from layerjam.brake.device.brake import Brake
from layerjam.brake.device.workshop import Build
from layerjam.core.errors import LayerjamError
from layerjam.workshop.fabricate import checks
from layerjam.workshop.fabricate.lengths import Lengths, compute_lengths
from layerjam.workshop.fabricate.mesh import make_mesh
from layerjam.workshop.fabricate.parts import Part, make_parts
from layerjam.workshop.fabricate.step import write_step

BUILD = Build()


def drawn(brake: Brake) -> tuple[Lengths, list[Part]] | None:
    """Lengths and parts; None where it is refused, with a sentence."""
    try:
        found = compute_lengths(brake, BUILD)
        checks.check_drawability(brake, BUILD, found)
    except LayerjamError as error:
        assert len(str(error)) > 20
        return None
    refused = [c for c in checks.clamping_checks(BUILD, found) if not c.ok]
    refused += [c for c in [checks.wall_check(BUILD, found)] if not c.ok]
    if refused:
        assert all(len(c.text) > 20 for c in refused)
        return None
    return found, make_parts(found, BUILD)


def through(name: str, found: Lengths) -> int:
    """Holes that go through a part."""
    bolts = 2 * (found.mould.bolts - 1)
    return {
        "cap": found.screws + 2,
        "plate": found.screws,
        "mould-bottom": bolts,
        "mould-top": bolts + 3,
        "core": 0,
        "sleeve": 1,
    }[name.removesuffix("-left").removesuffix("-right")]


def check(brake: Brake) -> bool:
    made = drawn(brake)
    if made is None:
        return False
    found, all_parts = made
    for part in all_parts:
        surface = make_mesh(part.solid)
        assert surface.hole_count == through(part.name, found), part.name
        assert surface.volume == pytest.approx(part.solid.volume, rel=1e-3), part.name
    return True


def test_eight_random_brakes() -> None:
    assert sum(check(brake) for brake in some_brakes(11, 8)) > 3


@pytest.mark.slow
def test_many_random_brakes() -> None:
    count = cases(500, 40)
    assert sum(check(brake) for brake in some_brakes(12, count)) > 0.6 * count


@pytest.mark.slow
def test_step_of_random_brakes(tmp_path) -> None:
    for brake in some_brakes(13, cases(30, 6)):
        made = drawn(brake)
        for part in made[1] if made else ():
            path = tmp_path / f"{part.name}.step"
            path.write_bytes(write_step(part.solid))
            found = read_step(path)
            assert found.valid and found.solids == 1
            assert found.volume == pytest.approx(part.solid.volume, rel=1e-6)
