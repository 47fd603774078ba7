"""The path of a chain of brakes: which stage slips when, while the others relax.

Every brake is a polyline of force over elongation from the pull law; on polylines the rest is
exact. A brake rises to a peak and falls after it, so in series only one stage can slide downhill
at a time: the weakest. The path alternates between rising to the lowest next peak and falling
behind it to the next valley, until every stage is at its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from layerjam.device.brake import Brake
from layerjam.errors import QuantityError
from layerjam.mechanics.pull import brake_force, least_stiffness, peak
from layerjam.mechanics.stiffness import working_stiffness
from layerjam.simulate.record import Outcome
from layerjam.units import show

KNOTS = 400
_SAME = 1e-12
_STOP = 1e7
"""A stop's line is drawn to this force [N], more than any chain of brakes pulls with."""


@dataclass(frozen=True)
class Backbone:
    """A brake's first loading: knots of elongation, force and slip, and what it does at its end."""

    elongation: np.ndarray
    force: np.ndarray
    slip: np.ndarray
    stiffness: float
    peak_slip: float
    end: float
    """Elongation at which the travel is used up."""
    stop: bool
    slack: float = 0.0

    def after(self, slack: float) -> Backbone:
        """The same, carrying only after a slack [m]."""
        if not slack:
            return self
        rows = (self.elongation + slack, self.force, self.slip)
        u, force, slip = (np.concatenate([[0.0], row]) for row in rows)
        end = self.end + slack
        return replace(self, elongation=u, force=force, slip=slip, end=end, slack=slack)


def backbone(brake: Brake, vacuum: float, travel: float, stop: bool, name: str) -> Backbone:
    """A brake's backbone at a vacuum [Pa] over a travel [m]; QuantityError where it snaps."""
    k = float(working_stiffness(brake))
    soft = float(least_stiffness(vacuum, brake))
    if k <= soft:
        raise QuantityError(
            f"{name}: stiffness {show(k, 'N/m')} is not above {show(soft, 'N/m')}, by which the "
            "brake softens as it slides; it would snap on its own"
        )
    top = peak(vacuum, travel, brake)
    # the enclosure's root rises steeply at first: knots crowd at zero slip, and the peak is one of
    # them (moved there, so that one shape is compiled)
    slip = travel * np.linspace(0.0, 1.0, KNOTS) ** 3
    at = float(top.slip)
    slip[np.argmin(np.abs(slip[1:-1] - at)) + 1] = min(at, travel * (1 - 1e-9))
    force = np.asarray(brake_force(slip, vacuum, brake))
    u = slip + force / k
    end = float(u[-1])
    if stop:
        far = float(force.max()) + _STOP
        u = np.append(u, u[-1] + (far - force[-1]) / k)
        force, slip = np.append(force, far), np.append(slip, slip[-1])
    if force[0] > 0:
        u, force, slip = (np.concatenate([[0.0], a]) for a in (u, force, slip))
    return Backbone(u, force, slip, k, at, end, stop)


@dataclass(frozen=True)
class Path:
    """A chain's path: N samples, M members stage by stage."""

    elongation: np.ndarray
    force: np.ndarray
    slips: np.ndarray
    forces: np.ndarray
    outcome: Outcome


class _Stage:
    """Members side by side: their common backbone, and how far it has been followed."""

    def __init__(self, members: Sequence[Backbone]) -> None:
        self.members = members
        knots = np.unique(np.concatenate([m.elongation for m in members]))
        # where the first member comes apart, or its stop's line ends, the stage is at its end
        self.u = knots[knots <= min(m.elongation[-1] for m in members)]
        self.apart = not all(m.stop for m in members)
        self.f = np.sum([np.interp(self.u, m.elongation, m.force) for m in members], axis=0)
        self.end = min(m.end for m in members)
        self.front = 0.0

    @property
    def frontier(self) -> float:
        """Force at the farthest point reached."""
        return float(np.interp(self.front, self.u, self.f))

    def turns(self) -> tuple[float, float, float]:
        """(peak force, its elongation, elongation of the valley behind it) from here on.

        A last rise onto a stop has no peak: infinite. Without a stop the end itself is the peak.
        """
        u = np.concatenate([[self.front], self.u[self.u > self.front]])
        f = np.interp(u, self.u, self.f)
        falls = np.flatnonzero(np.diff(f) < 0)
        if not len(falls):
            end = float(u[-1])
            return (float(f[-1]), end, end) if self.apart else (np.inf, end, np.inf)
        top = int(falls[0])
        rises = np.flatnonzero(np.diff(f[top:]) > 0)
        valley = top + int(rises[0]) if len(rises) else len(u) - 1
        return float(f[top]), float(u[top]), float(u[valley])

    def slips(self, front: np.ndarray) -> np.ndarray:
        """Slip kept by each member, shape (N, M), after the stage was at `front` (N,)."""
        return np.column_stack([np.interp(front, m.elongation, m.slip) for m in self.members])

    def relaxed(self, force: np.ndarray) -> np.ndarray:
        """Elongation at a force not above the frontier's: slips kept, taut members elastic."""
        slack, k = np.array([(m.slack, m.stiffness) for m in self.members]).T
        start = self.slips(np.array([self.front]))[0] + slack
        order = np.argsort(start, kind="stable")
        start, k = start[order], k[order]
        carried = np.concatenate([[0.0], np.cumsum(np.diff(start) * np.cumsum(k)[:-1])])
        last = start[-1] + (np.maximum(force, carried[-1]) - carried[-1]) / k.sum()
        return np.where(force >= carried[-1], last, np.interp(force, carried, start))

    def at(self, force: np.ndarray, top: float) -> tuple[np.ndarray, np.ndarray]:
        """(elongation, front) where a rising force (N,) has come; `top` ends the rise."""
        u = np.concatenate([[self.front], self.u[(self.u > self.front) & (self.u < top)], [top]])
        f = np.maximum.accumulate(np.interp(u, self.u, self.f))
        fresh = np.maximum(np.interp(force, f, u), self.front)
        beyond = force > self.frontier
        front = np.where(beyond, fresh, self.front)
        return np.where(beyond, front, self.relaxed(force)), front


def follow(stages: Sequence[Sequence[Backbone]]) -> Path:
    """Pull a chain from rest to its end; first loading, monotonic in elongation."""
    chain = [_Stage(members) for members in stages]
    force = 0.0
    blocks = [_taut(chain)]
    outcome = Outcome.BOTTOMED_OUT
    while True:
        turns = [stage.turns() for stage in chain]
        peaks = np.array([t[0] for t in turns])
        least = float(peaks.min())
        # of equal peaks the first named slips
        weak = int(np.argmax(peaks <= least * (1 + _SAME))) if np.isfinite(least) else -1
        target = least if weak >= 0 else _last_force(chain)
        if target > force:
            blocks.append(_rise(chain, turns, force, target))
        if weak < 0:
            break
        force, block = _fall(chain, weak, turns[weak])
        blocks.append(block)
        if chain[weak].front >= chain[weak].u[-1]:
            outcome = Outcome.SEPARATED
            break
    return _joined(chain, blocks, outcome)


_Block = tuple[np.ndarray, np.ndarray]
"""Forces (N,), and of every stage its elongations and fronts, shape (stages, 2, N)."""


def _taut(chain: Sequence[_Stage]) -> _Block:
    """The slack of every stage taken up at no force."""
    for stage in chain:
        stage.front = float(stage.u[np.flatnonzero(stage.f > 0)[0] - 1]) if stage.f.any() else 0.0
    return np.zeros(2), np.array([[[0.0, stage.front]] * 2 for stage in chain])


def _last_force(chain: Sequence[_Stage]) -> float:
    """Force at which the last stage comes onto its stop: there the pull ends."""
    return max(float(np.interp(s.end, s.u, s.f)) for s in chain)


def _rise(
    chain: Sequence[_Stage], turns: Sequence[tuple[float, float, float]], low: float, high: float
) -> _Block:
    """Force from `low` to `high`: every stage along its own branch."""
    knots = [s.f[(s.u >= s.front) & (s.f > low) & (s.f < high)] for s in chain]
    force = np.unique(np.concatenate([np.linspace(low, high, 25), *knots, [high]]))
    force = force[force <= high]
    moved = np.array([s.at(force, top) for s, (_, top, _) in zip(chain, turns, strict=True)])
    for stage, (_, front) in zip(chain, moved, strict=True):
        stage.front = float(front[-1])
    return force, moved


def _fall(
    chain: Sequence[_Stage], weak: int, turn: tuple[float, float, float]
) -> tuple[float, _Block]:
    """The weak stage from its peak down to its valley; the others relax."""
    stage, (_, top, valley) = chain[weak], turn
    u = stage.u[(stage.u > top) & (stage.u <= valley)]
    force = np.interp(u, stage.u, stage.f)
    moved = [
        (u, u) if other is stage else (other.relaxed(force), np.full(len(u), other.front))
        for other in chain
    ]
    stage.front = valley
    return stage.frontier, (force, np.array(moved))


def _joined(chain: Sequence[_Stage], blocks: Sequence[_Block], outcome: Outcome) -> Path:
    force, moved = (np.concatenate(parts, axis=-1) for parts in zip(*blocks, strict=True))
    slips, forces = [], []
    for stage, (place, front) in zip(chain, moved, strict=True):
        kept = stage.slips(front)
        slack, k = np.array([(m.slack, m.stiffness) for m in stage.members]).T
        slips.append(kept)
        forces.append(np.maximum(k * (place[:, None] - slack - kept), 0.0))
    total = sum(place for place, _ in moved)
    back = np.flatnonzero(np.diff(total) < -1e-12 * max(1.0, float(total.max())))
    if len(back):
        outcome = Outcome.SNAPS
    keep = np.arange(len(total)) <= (back[0] if len(back) else len(total))
    keep &= np.concatenate([[True], np.diff(total) > 0])
    return Path(total[keep], force[keep], np.hstack(slips)[keep], np.hstack(forces)[keep], outcome)
