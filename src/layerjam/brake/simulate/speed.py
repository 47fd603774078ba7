"""Notices about friction that depends on the sliding speed, or whose dependence is unknown."""

from collections.abc import Sequence

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.mechanics.speed_effects import (
    depends_on_speed,
    fastest_speed,
    name_speed_effects,
    test_speed,
)
from layerjam.core.errors import Notice
from layerjam.core.units import show

SLOW = 25e-3
"""Speed of the paper's fastest pull [m/s]; the paper reports no effect of speed on dry sheets."""
UNMEASURED = Notice(
    "no speed law was measured for this brake: friction is assumed to be the same at every "
    "sliding speed, although that of PTFE rises severalfold between 10 and 500 mm/s "
    "(manufacturers' curves)",
    "speed-law-unmeasured",
)


def list_stop_notices(
    file: BrakeFile, fastest: float | None = None, error: float | None = None
) -> list[Notice]:
    """Return notices about a stop with a slip speed `fastest` [m/s] and an integration `error`."""
    if not name_speed_effects(file.brake):
        return [UNMEASURED]
    notices = []
    if error is not None:
        notices.append(
            Notice(
                f"friction follows the brake's {name_speed_effects(file.brake)}; the stop is "
                f"integrated, with a relative error of about {max(error, 1e-12):.0e} in slip, time "
                "and force",
                "speed-law",
            )
        )
    if fastest is not None:
        notices += speed_notices(file, fastest)
    return notices


def speed_notices(file: BrakeFile, fastest: float) -> list[Notice]:
    """Return a notice if sheets slide faster [m/s] than the range of the speed law."""
    limit = fastest_speed(file.brake)
    if fastest <= limit:
        return []
    return [
        Notice(
            f"the sheets slide at up to {show(fastest, 'm/s')}; their friction was measured up to "
            f"{show(limit, 'm/s')} and is extrapolated beyond",
            "speed-law-beyond",
        )
    ]


def list_force_notices(file: BrakeFile, speed: float | None) -> list[Notice]:
    """Return notices about a force at a requested sliding speed [m/s], if any."""
    if not name_speed_effects(file.brake):
        return [] if speed is None else [UNMEASURED]
    if speed is not None:
        return speed_notices(file, speed)
    speed_text = show(test_speed(file.brake), "m/s")
    return [Notice(f"the force is that of sheets sliding at {speed_text}", "at-test-speed")]


def list_pull_notices(file: BrakeFile, speed: float) -> list[Notice]:
    """Return notices about a pull whose crosshead moves at up to a `speed` [m/s]."""
    words = (
        "friction follows the brake's {} at the speed of the crosshead or cord; "
        "while it rests, the last speed is used"
    )
    return _law_notice(file, words, speed, unmeasured=speed > SLOW)


def list_stack_notices(file: BrakeFile, speeds: Sequence[float]) -> list[Notice]:
    """Return notices about a sheet-by-sheet pull; the first of `speeds` [m/s] sets its friction."""
    first = speeds[0]
    words = (
        "every interface has the friction that the brake's {} gives at "
        f"{show(first, 'm/s')}, the speed of the crosshead"
    )
    if any(speed != first for speed in speeds):
        words += (
            " in the first move, and keeps it in later moves (the lumped model follows each speed)"
        )
    return _law_notice(file, words, first, unmeasured=max(speeds) > SLOW)


def list_slide_notices(file: BrakeFile, speed: float, fastest: float) -> list[Notice]:
    """Return notices about stick–slip at a crosshead speed and a highest sliding speed [m/s]."""
    words = (
        "kinetic friction follows the brake's {} at the speed of the sliding sheets; "
        "stable_speed and stiffness_needed, closed forms without that law, are omitted"
    )
    return _law_notice(file, words, fastest, unmeasured=speed > SLOW)


def machine_notices(file: BrakeFile) -> list[Notice]:
    """Return notices about the friction of brakes in a machine."""
    words = (
        "friction follows the brake's {} at the speed of the sheets; holding "
        "forces are those of very slow sliding, or of static friction"
    )
    return _law_notice(file, words, 0.0)


def _law_notice(
    file: BrakeFile, words: str, fastest: float, unmeasured: bool = True
) -> list[Notice]:
    """Return a notice that friction follows the speed law, or that no such law was measured.

    `words` has {} for the tables of the effects.
    """
    tables = name_speed_effects(file.brake)
    if not tables:
        return [UNMEASURED] if unmeasured else []
    if not depends_on_speed(file.brake):
        return []
    return [Notice(words.format(tables), "speed-law"), *speed_notices(file, fastest)]
