"""Force–elongation path of a chain of brakes, where one stage slips while the others relax.

The pull law yields a polyline of force versus elongation for every brake; all later steps are exact
for polylines. A brake's force rises to a peak and then falls, so only one stage at a time, the
weakest of the series, can slip while the force falls. The path alternates between rising to the
lowest next peak and falling to the valley after it, until every stage has reached its end.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from layerjam.brake.device.brake import Brake
from layerjam.brake.mechanics.pull import brake_force, least_stiffness, peak
from layerjam.brake.mechanics.stiffness import working_stiffness
from layerjam.brake.simulate.record import Outcome
from layerjam.core.errors import QuantityError
from layerjam.core.evolve import evolve
from layerjam.core.units import show

KNOTS = 400
_SAME = 1e-12
_STOP = 1e7
"""Rise [N] of the force on a stop, greater than the force of any chain of brakes."""


@dataclass(frozen=True)
class Backbone:
    """First loading of a brake: knots of elongation, force and slip, and whether it has a stop."""

    elongation: np.ndarray
    force: np.ndarray
    slip: np.ndarray
    stiffness: float
    peak_slip: float
    end: float
    """Elongation at which the travel is used up."""
    stop: bool
    slack: float = 0.0

    def add_slack(self, slack: float) -> "Backbone":
        """Return this backbone shifted by a slack [m], within which the force is zero."""
        if not slack:
            return self
        rows = (self.elongation + slack, self.force, self.slip)
        u, force, slip = (np.concatenate([[0.0], row]) for row in rows)
        end = self.end + slack
        return evolve(self, elongation=u, force=force, slip=slip, end=end, slack=slack)


def make_backbone(brake: Brake, vacuum: float, travel: float, stop: bool, name: str) -> Backbone:
    """Return a brake's backbone at a vacuum [Pa] over a travel [m]; QuantityError if it snaps."""
    k = float(working_stiffness(brake))
    min_stiffness = float(least_stiffness(vacuum, brake))
    if k <= min_stiffness:
        raise QuantityError(
            f"{name}: stiffness {show(k, 'N/m')} does not exceed {show(min_stiffness, 'N/m')}, "
            "the rate at which the brake's force falls as it slides; the brake would snap by itself"
        )
    top = peak(vacuum, travel, brake)
    # the enclosure's square-root law is steep at first, so knots are dense at zero slip. The knot
    # nearest to the peak is moved to it, so that only one array shape is compiled
    slip = travel * np.linspace(0.0, 1.0, KNOTS) ** 3
    peak_slip = float(top.slip)
    slip[np.argmin(np.abs(slip[1:-1] - peak_slip)) + 1] = min(peak_slip, travel * (1 - 1e-9))
    force = np.asarray(brake_force(slip, vacuum, brake))
    u = slip + force / k
    end = float(u[-1])
    if stop:
        stop_force = float(force.max()) + _STOP
        u = np.append(u, u[-1] + (stop_force - force[-1]) / k)
        force, slip = np.append(force, stop_force), np.append(slip, slip[-1])
    if force[0] > 0:
        u, force, slip = (np.concatenate([[0.0], a]) for a in (u, force, slip))
    return Backbone(u, force, slip, k, peak_slip, end, stop)


@dataclass(frozen=True)
class Path:
    """Force path of a chain: N samples, and M members in the order of the stages."""

    elongation: np.ndarray
    force: np.ndarray
    slips: np.ndarray
    forces: np.ndarray
    outcome: Outcome


class _Stage:
    """Parallel members: their common backbone, and how far the path has followed it."""

    def __init__(self, members: Sequence[Backbone]) -> None:
        self.members = members
        knots = np.unique(np.concatenate([m.elongation for m in members]))
        # the stage ends when the first member separates or reaches the end of its stop line
        self.u = knots[knots <= min(m.elongation[-1] for m in members)]
        self.separates = not all(m.stop for m in members)
        self.f = np.sum([np.interp(self.u, m.elongation, m.force) for m in members], axis=0)
        self.end = min(m.end for m in members)
        self.front = 0.0

    @property
    def front_force(self) -> float:
        """Force at the farthest point reached so far."""
        return float(np.interp(self.front, self.u, self.f))

    def find_next_peak(self) -> tuple[float, float, float]:
        """Return the next peak: (force, elongation, elongation of the valley after it).

        A final rise onto a stop has an infinite peak. Without a stop, the end itself is the peak.
        """
        u = np.concatenate([[self.front], self.u[self.u > self.front]])
        f = np.interp(u, self.u, self.f)
        falling_steps = np.flatnonzero(np.diff(f) < 0)
        if not len(falling_steps):
            end = float(u[-1])
            return (float(f[-1]), end, end) if self.separates else (np.inf, end, np.inf)
        top = int(falling_steps[0])
        rising_steps = np.flatnonzero(np.diff(f[top:]) > 0)
        valley = top + int(rising_steps[0]) if len(rising_steps) else len(u) - 1
        return float(f[top]), float(u[top]), float(u[valley])

    def member_slips(self, front: np.ndarray) -> np.ndarray:
        """Return the slip of each member, shape (N, M), once the path has reached `front` (N,)."""
        return np.column_stack([np.interp(front, m.elongation, m.slip) for m in self.members])

    def relax_members(self, force: np.ndarray) -> np.ndarray:
        """Return the elongation after taut members relax to a force below `front_force`."""
        slack, k = np.array([(m.slack, m.stiffness) for m in self.members]).T
        start = self.member_slips(np.array([self.front]))[0] + slack
        order = np.argsort(start, kind="stable")
        start, k = start[order], k[order]
        knot_forces = np.concatenate([[0.0], np.cumsum(np.diff(start) * np.cumsum(k)[:-1])])
        last = start[-1] + (np.maximum(force, knot_forces[-1]) - knot_forces[-1]) / k.sum()
        return np.where(force >= knot_forces[-1], last, np.interp(force, knot_forces, start))

    def follow_rise(self, force: np.ndarray, top: float) -> tuple[np.ndarray, np.ndarray]:
        """Return (elongation, front) at rising forces (N,); the rise ends at elongation `top`."""
        u = np.concatenate([[self.front], self.u[(self.u > self.front) & (self.u < top)], [top]])
        f = np.maximum.accumulate(np.interp(u, self.u, self.f))
        new_front = np.maximum(np.interp(force, f, u), self.front)
        is_new = force > self.front_force
        front = np.where(is_new, new_front, self.front)
        return np.where(is_new, front, self.relax_members(force)), front


def follow_chain(stages: Sequence[Sequence[Backbone]]) -> Path:
    """Return the path of a chain that is pulled once from rest to its end."""
    chain = [_Stage(members) for members in stages]
    force = 0.0
    blocks = [_take_up_slack(chain)]
    outcome = Outcome.BOTTOMED_OUT
    while True:
        turns = [stage.find_next_peak() for stage in chain]
        peaks = np.array([t[0] for t in turns])
        lowest_peak = float(peaks.min())
        # if peaks are equal, the first brake listed slips
        weak = (
            int(np.argmax(peaks <= lowest_peak * (1 + _SAME))) if np.isfinite(lowest_peak) else -1
        )
        target = lowest_peak if weak >= 0 else _last_force(chain)
        if target > force:
            blocks.append(_follow_rise(chain, turns, force, target))
        if weak < 0:
            break
        force, block = _follow_fall(chain, weak, turns[weak])
        blocks.append(block)
        if chain[weak].front >= chain[weak].u[-1]:
            outcome = Outcome.SEPARATED
            break
    return _join_blocks(chain, blocks, outcome)


_Block = tuple[np.ndarray, np.ndarray]
"""Forces, shape (N,), and elongations and fronts of every stage, shape (stages, 2, N)."""


def _take_up_slack(chain: Sequence[_Stage]) -> _Block:
    """Return the block in which the slack of every stage is taken up at zero force."""
    for stage in chain:
        stage.front = float(stage.u[np.flatnonzero(stage.f > 0)[0] - 1]) if stage.f.any() else 0.0
    return np.zeros(2), np.array([[[0.0, stage.front]] * 2 for stage in chain])


def _last_force(chain: Sequence[_Stage]) -> float:
    return max(float(np.interp(s.end, s.u, s.f)) for s in chain)


def _follow_rise(
    chain: Sequence[_Stage], turns: Sequence[tuple[float, float, float]], low: float, high: float
) -> _Block:
    knots = [s.f[(s.u >= s.front) & (s.f > low) & (s.f < high)] for s in chain]
    force = np.unique(np.concatenate([np.linspace(low, high, 25), *knots, [high]]))
    force = force[force <= high]
    motion = np.array(
        [s.follow_rise(force, top) for s, (_, top, _) in zip(chain, turns, strict=True)]
    )
    for stage, (_, front) in zip(chain, motion, strict=True):
        stage.front = float(front[-1])
    return force, motion


def _follow_fall(
    chain: Sequence[_Stage], weak: int, turn: tuple[float, float, float]
) -> tuple[float, _Block]:
    """Return (valley force, block) of the weakest stage past its peak; the others relax."""
    stage, (_, top, valley) = chain[weak], turn
    u = stage.u[(stage.u > top) & (stage.u <= valley)]
    force = np.interp(u, stage.u, stage.f)
    motion = [
        (u, u) if other is stage else (other.relax_members(force), np.full(len(u), other.front))
        for other in chain
    ]
    stage.front = valley
    return stage.front_force, (force, np.array(motion))


def _join_blocks(chain: Sequence[_Stage], blocks: Sequence[_Block], outcome: Outcome) -> Path:
    force, motion = (np.concatenate(parts, axis=-1) for parts in zip(*blocks, strict=True))
    slips, forces = [], []
    for stage, (place, front) in zip(chain, motion, strict=True):
        slip = stage.member_slips(front)
        slack, k = np.array([(m.slack, m.stiffness) for m in stage.members]).T
        slips.append(slip)
        forces.append(np.maximum(k * (place[:, None] - slack - slip), 0.0))
    total = sum(place for place, _ in motion)
    reversals = np.flatnonzero(np.diff(total) < -1e-12 * max(1.0, float(total.max())))
    if len(reversals):
        outcome = Outcome.SNAPS
    keep = np.arange(len(total)) <= (reversals[0] if len(reversals) else len(total))
    keep &= np.concatenate([[True], np.diff(total) > 0])
    return Path(total[keep], force[keep], np.hstack(slips)[keep], np.hstack(forces)[keep], outcome)
