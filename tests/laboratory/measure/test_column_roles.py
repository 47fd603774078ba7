"""A column has one role: a name that implies one is not ranked for a different one."""

from __future__ import annotations

import pytest

from layerjam.laboratory.measure.readers.column_names import find_role, rank_name

NAMES = {
    "time": ("Time", "Elapsed time", "Zeit", "Temps", "Test time"),
    "force": ("Force", "Load", "Kraft", "Axial force", "Standard force"),
    "elongation": ("Extension", "Displacement", "Crosshead displacement", "Weg", "Position"),
}
CASES = [(role, name) for role, names in NAMES.items() for name in names]


@pytest.mark.parametrize(("role", "name"), CASES)
def test_a_name_implies_its_role_and_excludes_the_others(role: str, name: str) -> None:
    for text in (name, name.upper(), f" {name.lower()}"):
        assert find_role(text) in (role, None)
        assert rank_name(role, text) is not None and rank_name(role, text) <= 2
        for other in {"force", "elongation"} - {role}:
            if find_role(text) is not None:
                assert rank_name(other, text) is None
    assert any(find_role(one) == role for one in NAMES[role])


def test_the_best_name_of_a_role_is_the_plain_one() -> None:
    for role, names in NAMES.items():
        ranks = [rank_name(role, name) for name in names]
        assert ranks[0] == 0 == min(rank for rank in ranks if rank is not None)


@pytest.mark.parametrize("role", NAMES)
def test_a_reference_does_not_change_the_role(role: str) -> None:
    """Extension from preload is not a load, and time after preload is not one either."""
    name = NAMES[role][0]
    assert find_role(f"{name} from preload") == find_role(f"{name} after preload") == role
