"""What a drop says beside its numbers."""

from __future__ import annotations

from layerjam.verbs.impact import drop

CASE = {"mass": "1 kg", "speed": "2.5 m/s", "vacuum": "tuned", "travel": "40 mm",
        "rope_stiffness": "20 kN/m"}  # fmt: skip


def test_a_damped_rope_takes_energy_that_the_tuned_vacuum_counted_on():
    plain = drop("choi2018-kapton", **CASE)
    damped = drop("choi2018-kapton", **CASE, rope_damping="50 N*s/m")
    assert abs(plain.slip - 0.040) < 1e-9
    assert damped.slip < plain.slip
    said = [w for w in damped.warnings if "tuned for a rope without damping" in w]
    assert len(said) == 1 and "not 40 mm" in said[0]
    assert not any("tuned for" in w for w in plain.warnings)
