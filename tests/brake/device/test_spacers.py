"""What a file says of spacers, and what it is asked for where it matters."""

from __future__ import annotations

import math

import pytest

from layerjam.brake.device.brake_file import updated_text
from layerjam.brake.device.load import catalogue, load
from layerjam.brake.mechanics import friction
from layerjam.brake.mechanics.effects import require_linear
from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.source import Source

KAPTON = load("choi2018-kapton")


def keys(file):
    return [getattr(w, "key", "") for w in file.warnings()]


def test_who_does_not_say_is_warned_where_it_matters_and_with_the_size():
    for name in catalogue():
        assert not [*load(name).spacer_notices()]
    thick = KAPTON.with_(count=41)
    (notice,) = thick.spacer_notices()
    assert notice.key == "spacers-unstated" and notice in thick.warnings()
    # 1.989 at a friction of 0.875 x 0.24/1.048, over the 1.048 that the scale factor holds
    assert "1.9 times" in notice
    for said in (True, False):
        assert not [*thick.with_(spacers=said).spacer_notices()]


def test_a_scale_factor_that_may_hold_a_fan_is_asked_about():
    """Fitted before anybody spoke of spacers, it holds more than the friction of the film."""
    fitted = KAPTON.with_(count=41, amplification_held=None)
    for said in (True, False):
        assert keys(fitted.with_(spacers=said))[-1] == "amplification-unstated"
        assert not [*fitted.with_(spacers=said, scale_factor=1.0).spacer_notices()]


def test_what_the_old_scale_factor_held_goes_with_it():
    changes = {"scale_factor": (0.9, Source(kind="calibrated", text="own pulls"))}
    made = KAPTON.read(updated_text(KAPTON, "own", changes), "own")
    assert made.brake.scale_factor == 0.9 and made.brake.amplification_held is None
    # fitted with the factor in the law, it goes on holding what it held
    spaced = KAPTON.with_(spacers=False)
    made = KAPTON.read(updated_text(spaced, "own", changes), "own")
    assert made.brake.amplification_held == KAPTON.brake.amplification_held


def test_a_model_with_a_straight_line_takes_spacers_and_refuses_a_fan():
    assert require_linear(KAPTON.brake, "x") is KAPTON.brake
    flat = require_linear(KAPTON.brake.with_(spacers=True), "x")
    assert flat.scale_factor == pytest.approx(0.875 / 1.048, rel=1e-12)
    assert flat.mount.spacers is None and flat.amplification_held is None
    with pytest.raises(QuantityError, match="x does not support the self-amplified friction"):
        require_linear(KAPTON.brake.with_(spacers=False), "x")


@pytest.mark.parametrize("name", ["choi2018-kapton", "choi2018-ptfe"])
def test_either_word_would_move_forces_that_were_checked(name: str) -> None:
    """A held factor is that of the brake at rest: while it slides the fan closes, and less is held.

    Sheet friction with `spacers = false` over that without a word, by the factor's own formula.
    """
    file = load(name)
    brake, held = file.brake, file.brake.amplification_held
    assert held is not None and brake.mount.spacers is None
    mu = brake.scale_factor / held * brake.film.kinetic
    for slip, moved in ((0.0, 1e-4), (0.04, 5e-3)):
        alpha = mu * 0.254e-3 * (11 / 4) ** 2 * 2 / (11e-3 + slip)
        factor = math.sqrt(math.pi / 4 / alpha) * math.exp(alpha) * math.erf(math.sqrt(alpha))
        silent, fans, flat = (
            float(friction.sheet_friction(slip, 94.5e3, one.brake))
            for one in (file, file.with_(spacers=False), file.with_(spacers=True))
        )
        assert fans / silent == pytest.approx(factor / held, rel=1e-12)
        assert flat / silent == pytest.approx(1 / held, rel=1e-12)
        assert (abs(fans / silent - 1) < moved) is (slip == 0)
