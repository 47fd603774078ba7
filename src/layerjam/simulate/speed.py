"""What to say of friction that depends on the sliding speed, or that nobody has measured so."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import Notice
from layerjam.units import show

SLOW = 25e-3
"""Fastest pull of the paper [m/s], which saw no effect of speed on dry sheets."""
UNMEASURED = Notice(
    "no speed law was measured for this brake: friction counts as the same at every sliding speed, "
    "while that of PTFE rises several times from 10 to 500 mm/s (makers' curves)",
    "speed-law-unmeasured",
)


def follows_speed(brake: Brake) -> bool:
    """Whether the friction of a brake (plain numbers) depends on the sliding speed."""
    return brake.speed_law is not None and brake.speed_law.power > 0


def counted(brake: Brake) -> Brake:
    """The brake without a speed law that changes nothing, which would be followed for nothing."""
    return brake if follows_speed(brake) else replace(brake, speed_law=None)


def in_a_stop(
    file: BrakeFile, fastest: float | None = None, error: float | None = None
) -> list[Notice]:
    """What a stop has to say; `fastest` is its sliding speed [m/s], `error` that of integration."""
    law = file.brake.speed_law
    if law is None:
        return [UNMEASURED]
    said = []
    if error is not None:
        said.append(
            Notice(
                "friction follows the brake's [speed_law]; the stop is integrated, slip, time and "
                f"force to about {max(error, 1e-12):.0e} of their value",
                "speed-law",
            )
        )
    if fastest is not None:
        said += beyond(file, fastest)
    return said


def beyond(file: BrakeFile, fastest: float) -> list[Notice]:
    """That the sheets slide faster [m/s] than the speed law was measured."""
    law = file.brake.speed_law
    known = None if law is None else law.fastest
    if known is None or fastest <= known:
        return []
    return [
        Notice(
            f"the sheets slide at up to {show(fastest, 'm/s')}; their friction was measured up to "
            f"{show(known, 'm/s')} and is extrapolated",
            "speed-law-beyond",
        )
    ]


def of_force(file: BrakeFile, speed: float | None) -> list[Notice]:
    """What a force at a sliding speed [m/s] has to say; None where no speed was asked for."""
    law = file.brake.speed_law
    if law is None:
        return [] if speed is None else [UNMEASURED]
    if speed is not None:
        return beyond(file, speed)
    at = show(law.test_speed, "m/s")
    return [Notice(f"the force is that of sheets sliding at {at}", "at-test-speed")]


def in_a_pull(file: BrakeFile, speed: float) -> list[Notice]:
    """What a pull has to say whose crosshead moves at up to a `speed` [m/s]."""
    words = (
        "friction follows the brake's [speed_law] at the speed of the crosshead or cord; while "
        "that stands, the last one counts"
    )
    return _followed(file, words, speed, unmeasured=speed > SLOW)


def in_a_stack(file: BrakeFile, speeds: Sequence[float]) -> list[Notice]:
    """What a pull sheet by sheet has to say whose moves go at speeds [m/s]; the first counts."""
    first = speeds[0]
    words = (
        f"every interface has the friction of the brake's [speed_law] at {show(first, 'm/s')}, the "
        "speed of the crosshead"
    )
    if any(speed != first for speed in speeds):
        words += " in the first move; the others count with it too (the lumped model follows them)"
    return _followed(file, words, first, unmeasured=max(speeds) > SLOW)


def in_a_slide(file: BrakeFile, speed: float, fastest: float) -> list[Notice]:
    """What stick–slip at a speed of the crosshead, and a fastest slip [m/s], has to say."""
    words = (
        "kinetic friction follows the brake's [speed_law] at the speed of the sliding sheets; "
        "stable_speed and stiffness_needed are closed forms without it and are left out"
    )
    return _followed(file, words, fastest, unmeasured=speed > SLOW)


def in_a_machine(file: BrakeFile) -> list[Notice]:
    """What every machine has to say of the brakes' friction."""
    words = (
        "friction follows the brake's [speed_law] at the speed of the sheets; a force that holds "
        "is that of sheets which slide ever so slowly, or the static one"
    )
    return _followed(file, words, 0.0)


def _followed(file: BrakeFile, words: str, fastest: float, unmeasured: bool = True) -> list[Notice]:
    """How friction follows the speed law, or that there is none if speed counts (`unmeasured`)."""
    if file.brake.speed_law is None:
        return [UNMEASURED] if unmeasured else []
    if not follows_speed(file.brake):
        return []
    return [Notice(words, "speed-law"), *beyond(file, fastest)]
