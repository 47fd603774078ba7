"""Several brakes in parallel, in series or both: mass, force and travel of the whole array.

An array has chains in parallel. A chain has stages in series. A stage has members in parallel. A
single brake is a chain of one stage with one member.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from layerjam.brake.device.brake import Brake, mass, validate
from layerjam.brake.mechanics.energy import slip_work
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.record import Outcome
from layerjam.core.brief import brief
from layerjam.core.errors import Notice, QuantityError, make_notices
from layerjam.core.evolve import evolve
from layerjam.core.units import QuantitySpec, show
from layerjam.workshop.design.array_path import Backbone, Path, follow_chain, make_backbone

SLACK = QuantitySpec("m", "slack taken up before a member carries load", hi=10)
LEVER = QuantitySpec("m", "lever arm or pulley radius", open_lo=True, hi=10)
VOLUME = QuantitySpec("m^3", "gas volume of one brake and its fittings", lo=1e-9, hi=1)
MAX_MEMBERS = 10_000
_BLOCK = 4096


@dataclass(frozen=True, kw_only=True)
class Member:
    """One brake of an array, at a constant vacuum.

    The stage lengthens by `slack` [m] before this brake carries force. With `stop`, a strap carries
    the load once the usable travel is used up; otherwise the sheets separate after the overlap.
    """

    brake: Brake
    vacuum: float
    slack: float = 0.0
    stop: bool = True
    name: str = ""

    @property
    def travel(self) -> float:
        """Return the available slip [m]: the usable travel if there is a stop, else the overlap."""
        sheets = self.brake.sheets
        return sheets.usable_travel if self.stop else sheets.overlap


Stage = tuple[Member, ...]
Chain = tuple[Stage, ...]


@dataclass(frozen=True, kw_only=True)
class Array:
    """Chains in parallel, each made of stages in series, each made of members in parallel.

    Raises QuantityError for an empty chain or stage, more than 10,000 members, a vacuum above the
    site's atmosphere, a slack out of bounds or a brake with contradictory values.
    """

    chains: tuple[Chain, ...]

    def __post_init__(self) -> None:
        if not self.chains or not all(c and all(c) for c in self.chains):
            raise QuantityError("array: a chain or stage is empty; each needs at least one member")
        members = self.members
        if len(members) > MAX_MEMBERS:
            raise QuantityError(f"array: {len(members)} members; at most {MAX_MEMBERS} are allowed")
        for index, member in enumerate(members, 1):
            validate(member.brake)
            SLACK.check(member.slack, f"member {index}.slack")
            atmosphere = member.brake.site.atmosphere
            QuantitySpec("Pa", "vacuum up to atmospheric pressure", hi=atmosphere).check(
                member.vacuum, f"member {index}.vacuum"
            )

    @property
    def members(self) -> tuple[Member, ...]:
        """Return every member: chain by chain and stage by stage, in the order given."""
        return tuple(m for chain in self.chains for stage in chain for m in stage)


def single(brake: Brake, vacuum: float, **how: float | bool) -> Array:
    """Return an array of one brake at a vacuum [Pa]; `how` is passed on to Member."""
    return Array(chains=(((Member(brake=brake, vacuum=vacuum, **how),),),))  # type: ignore[arg-type]


def grid(member: Member, *, series: int, parallel: int) -> Array:
    """Return `parallel` identical chains in parallel, each of `series` identical brakes."""
    for count, name in ((series, "series"), (parallel, "parallel")):
        QuantitySpec("1", "brakes", lo=1, hi=MAX_MEMBERS, whole=True).check(count, name)
    return Array(chains=(((member,),) * series,) * parallel)


def in_series(*parts: Array) -> Array:
    """Return arrays of one chain each, connected in series in the order given."""
    if any(len(part.chains) != 1 for part in parts):
        raise QuantityError(
            "array: several parallel chains cannot be in series with others; a stage of parallel "
            "members can"
        )
    return Array(chains=(tuple(stage for part in parts for stage in part.chains[0]),))


def in_parallel(*parts: Array) -> Array:
    """Return arrays connected in parallel, which share one elongation and whose forces add up.

    Single-stage chains remain separate chains. To put parallel brakes into one stage of a longer
    chain, use Array.
    """
    return Array(chains=tuple(chain for part in parts for chain in part.chains))


class Totals(NamedTuple):
    """Mass, travel, energy and stiffness of a whole array."""

    mass: float
    """Mass [kg]."""
    travel: float
    """Elongation due to slip alone until the first chain reaches its end [m]."""
    energy: float
    """Work required to slip every brake over its own travel at its vacuum [J]."""
    stiffness: float
    """Stiffness before any slip, with all slack taken up [N/m]."""
    volume: float | None
    """Gas volume that the line must evacuate [m^3], or None if no chamber was given."""
    brakes: int


def totals(array: Array, chamber: float | None = None) -> Totals:
    """Return mass, travel, energy, stiffness and line volume of an array.

    `chamber` is the gas volume [m^3] of one brake with its fittings (`chamber.volume` of its line);
    every brake has this volume. A stage ends when any of its members does: its travel is the
    smallest sum of slack and travel among them.
    """
    if chamber is not None:
        VOLUME.check(chamber, "chamber")
    members = array.members
    travels, stiffness = [], 0.0
    for chain in array.chains:
        travels.append(sum(min(m.slack + m.travel for m in stage) for stage in chain))
        per_stage = [sum(float(working_stiffness(m.brake)) for m in stage) for stage in chain]
        stiffness += 1 / sum(1 / k for k in per_stage)
    work = {m: float(slip_work(m.travel, m.vacuum, m.brake)) for m in dict.fromkeys(members)}
    return Totals(
        mass=float(sum(mass(m.brake) for m in members)),
        travel=float(min(travels)),
        energy=float(sum(work[m] for m in members)),
        stiffness=stiffness,
        volume=None if chamber is None else chamber * len(members),
        brakes=len(members),
    )


@brief
@dataclass(frozen=True, kw_only=True)
class ArrayLoading:
    """One slow pull of an array from rest; N samples, M members in the order of `members`.

    `outcome` is BOTTOMED_OUT (all stages of a chain are at their stops), SEPARATED (a brake without
    a stop has separated), FINISHED (the requested elongation was reached) or SNAPS (the force of a
    slipping brake falls faster than the others relax; the record ends there). `order` lists the
    events in sequence: (elongation [m], index among `members`, "runs" at a peak or "ends").
    """

    elongation: np.ndarray = field(repr=False)
    """Elongation [m], shape (N,)."""
    force: np.ndarray = field(repr=False)
    """Force [N], shape (N,)."""
    work: np.ndarray = field(repr=False)
    """External work so far [J], shape (N,): slip work and F^2/2k, summed over the members."""
    slips: np.ndarray = field(repr=False)
    """Slips [m], shape (N, M)."""
    forces: np.ndarray = field(repr=False)
    """Forces [N], shape (N, M)."""
    order: tuple[tuple[float, int, str], ...]
    outcome: Outcome
    warnings: tuple[Notice, ...] = ()

    def torque(self, lever: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (angle [rad], torque [N m]) for a tangential pull at a lever arm [m]."""
        LEVER.check(lever, "lever")
        return self.elongation / lever, self.force * lever


def pull(array: Array, until: float | None = None) -> ArrayLoading:
    """Pull an array slowly from rest, to an elongation [m] or to its end.

    Members of a stage share one elongation, and each force follows the member's own law. Stages of
    a chain share one force. The stage with the lowest next peak slips; if peaks are equal, the one
    listed first. Once a brake slides, its force falls: the others relax without further slip, and
    the next one slips only when the first has reached its stop. Only first loading is covered:
    members relax elastically and carry no compression.

    Raises QuantityError for a brake that would snap even on its own.
    """
    backbones = _make_backbones(array.members)
    paths, first = [], 0
    for chain in array.chains:
        numbers = []
        for stage in chain:
            numbers.append(tuple(range(first, first + len(stage))))
            first += len(stage)
        paths.append(follow_chain([[backbones[i] for i in n] for n in numbers]))
    ends = [float(p.elongation[-1]) for p in paths]
    end = min(ends) if until is None else min(*ends, until)
    grid = np.unique(np.concatenate([p.elongation for p in paths]))
    grid = np.append(grid[grid < end], end)
    parts = [_interpolate_path(path, grid) for path in paths]
    slips, forces = (np.hstack([p[i] for p in parts]) for i in (1, 2))
    force = np.sum([p[0] for p in parts], axis=0)
    if until is not None and end >= until:
        outcome = Outcome.FINISHED
    else:
        outcome = paths[int(np.argmin(ends))].outcome
    return ArrayLoading(
        elongation=grid,
        force=force,
        work=_member_work(array.members, slips, forces),
        slips=slips,
        forces=forces,
        order=_event_order(array.members, grid, slips, backbones),
        outcome=outcome,
        warnings=tuple(make_notices(_array_notices(array.members, outcome, end))),
    )


def _make_backbones(members: Sequence[Member]) -> list[Backbone]:
    """Return the backbone of each member; identical members are computed once."""
    backbones: dict[Member, Backbone] = {}
    for index, m in enumerate(members, 1):
        unnamed_member = evolve(m, slack=0.0, name="")
        if unnamed_member not in backbones:
            backbones[unnamed_member] = make_backbone(
                m.brake, m.vacuum, m.travel, m.stop, f"member {index}"
            )
    return [backbones[evolve(m, slack=0.0, name="")].add_slack(m.slack) for m in members]


def _interpolate_path(path: Path, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    force = np.interp(grid, path.elongation, path.force)
    columns = [
        np.column_stack([np.interp(grid, path.elongation, column) for column in table.T])
        for table in (path.slips, path.forces)
    ]
    return force, columns[0], columns[1]


def _member_work(members: Sequence[Member], slips: np.ndarray, forces: np.ndarray) -> np.ndarray:
    count = len(slips)
    total = np.zeros(count)
    # use whole blocks, so that only a few shapes are compiled
    blocks = np.pad(np.maximum(slips, 0.0), ((0, -count % _BLOCK), (0, 0)))
    for column, m in enumerate(members):
        total += np.asarray(slip_work(blocks[:, column], m.vacuum, m.brake))[:count]
        total += forces[:, column] ** 2 / (2 * float(working_stiffness(m.brake)))
    return total


def _event_order(
    members: Sequence[Member], grid: np.ndarray, slips: np.ndarray, backbones: Sequence[Backbone]
) -> tuple[tuple[float, int, str], ...]:
    """Return the events of all members: passing a peak (and slipping alone) and reaching an end."""
    events = []
    for i, m in enumerate(members):
        is_running = slips[:, i] > backbones[i].peak_slip * (1 + 1e-9) + 1e-12
        is_ended = slips[:, i] >= m.travel * (1 - 1e-9)
        for event, samples in (("runs", is_running), ("ends", is_ended)):
            if samples.any():
                events.append((float(grid[np.argmax(samples)]), i, event))
    return tuple(sorted(events, key=lambda e: e[0]))


def _array_notices(members: Sequence[Member], outcome: Outcome, end: float) -> tuple[str, ...]:
    if outcome is Outcome.SEPARATED:
        return (f"the sheets separated and the record ends at an elongation of {show(end, 'm')}",)
    if outcome is Outcome.SNAPS:
        return (
            f"at {show(end, 'm')} the slipping brake softens faster than the others relax: it "
            "snaps; fewer brakes in series, or stiffer ones, are needed",
        )
    return ()
