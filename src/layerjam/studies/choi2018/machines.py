"""Fig. 13 of the paper: four machines that it proposes, each computed from a scenario of ours."""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING

from layerjam.report.page import Picture
from layerjam.studies.choi2018.claims import Claim, beyond
from layerjam.studies.choi2018.page import Part
from layerjam.studies.machines import figures as draw
from layerjam.studies.machines.registry import analyse, load_scenario
from layerjam.studies.machines.verdict import Result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MACHINES = {
    "seat-belt": ("a seat belt that takes up a crash", draw.belt_over_way),
    "neck-guard": ("a neck guard against head rotation", draw.neck_in_time),
    "ankle-clutch": ("a clutch of an ankle exoskeleton", draw.ankle_stride),
    "rehabilitation": ("resistance for rehabilitation", draw.exercise_in_time),
}
CAPTIONS = {
    "seat-belt": "Seat belt: force over the way of the chest, with eight brakes, with webbing "
    "alone, and with the least load limiter of constant force that stops in the space.",
    "neck-guard": "Neck guard: the blow with and without two brakes.",
    "ankle-clutch": "Ankle clutch: one stride, what the clutch must hold and when it must let go.",
    "rehabilitation": "Finger or elbow: the resistance wanted and given over one exercise.",
}


@cache
def _result(name: str) -> Result:
    return analyse(load_scenario(name))


def claims() -> list[Claim]:
    """What the paper proposes, and our verdict on it."""
    return [
        beyond(f"Fig. 13: {what}", "III-F", "proposed", "", _result(name).reason,
               ours="feasible" if _result(name).feasible else "not as built")
        for name, (what, _) in MACHINES.items()
    ]  # fmt: skip


def _figure(name: str) -> Figure:
    return MACHINES[name][1](_result(name).record)  # type: ignore[operator, no-any-return]


def part() -> Part:
    """The part of the page; its claims come from `claims`."""
    return Part(
        id="machines",
        title="Four machines (Fig. 13)",
        text=["The paper draws four uses and computes none. Here each is a scenario with the "
              "paper's brake and line, human data from named sources and what had to be assumed "
              "marked so; 'layerjam apply' writes a page on each, with what it would take."],
        pictures=[
            Picture(name=f"machine-{name}", figure=partial(_figure, name),
                    caption=CAPTIONS[name])
            for name in MACHINES
        ],
    )  # fmt: skip
