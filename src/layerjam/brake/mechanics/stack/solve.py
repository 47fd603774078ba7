"""One increment of the stack: sliding interfaces, and final positions of sheets and mount.

Sheet i has displacement w_i and an anchor spring d_i to its cap (left ones to ground, right ones to
the cap at U). Interface i carries f_i, |f_i| <= c_i, and has slipped by s_i. One increment is

min over w of 1/2 sum d_i (w_i - y_i)^2 + sum c_i |w_{i+1} - w_i - s_i|, y_i = 0 or U,

strictly convex, so the solution is unique; no time step, no contact stiffness, no chatter. Which
interfaces slide is found exactly in time linear in the sheets (`fused_lasso`). Then sheets, mount
and slip-dependent bounds form one tridiagonal system, and the enclosure's faces add two unknowns
(`compute_response`, `place_sheets`). The two steps alternate until the pattern does not change. The
first attempt usually suffices, because the pattern is that of the last increment.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.stack.enclosure import DONE, SNAPPED, STALLED, Faces, Signs, face_gap
from layerjam.brake.mechanics.stack.lasso import Array, Knots, fused_lasso

Terms = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]

CAP, FORCE, ELONGATION, WORK, HEAT, STORED, SLACK, TOP, TOP_ELONGATION, TOP_SLIP = range(10)
"""Places in `State.values`; the first two also in `Trial.values`."""
VALUES = 10
_ROUNDS = 150
_SNAPS = 40
"""Number of attempts to find a different pattern before the mount counts as too soft."""
# tolerances against rounding, relative to the friction and to spring times cap
_TIGHT, _ROUNDED = 1e-11, 4e-16


class Stack(NamedTuple):
    """Stack at a vacuum; n sheets, n - 1 interfaces. Walls of a housing count as sheets.

    An interface holds `friction` (1 - slip/length), which may differ between interfaces (scatter,
    pressure missing in the middle, misaligned sheets).
    """

    springs: Array
    """(n,) anchor springs [N/m]."""
    right: Flags
    """(n,) True for sheets held by the moving cap."""
    friction: Array
    """(n - 1,) kinetic friction at rest [N]."""
    ratio: Array
    """(n - 1,) ratio of static to kinetic friction, at least 1."""
    length: Array
    """(n - 1,) slip at which the friction ends [m]; infinite if it is constant."""
    mount: float
    """Stiffness between crosshead and moving cap [N/m]; infinite if rigid."""
    ends: Signs
    """(2,) sheets whose outer side the enclosure's faces touch."""
    face: Array
    """(3,) one face of the enclosure: EA [N], friction q [N/m], reach l [m]; EA = 0 for none."""
    one_by_one: bool = False
    """Whether only the most overloaded interface breaks next if a break overloads several."""

    @property
    def sheet_count(self) -> int:
        """Number of sheets n."""
        return len(self.springs)


class State(NamedTuple):
    """State of a stack between two increments."""

    past: Array
    """(n - 1,) w_{i+1} - w_i at the end of the last slide of each interface [m]."""
    slides: Signs
    """(n - 1,) sign of the last sliding, 0 at rest."""
    moving: Flags
    """(n - 1,) True if kinetic friction applies."""
    sheets: Array
    """(n,) displacements [m]."""
    interface: Array
    """(n - 1,) forces [N]."""
    values: Array
    """(VALUES,) cap, force, elongation, work, heat, stored energy, slack of the crosshead, and the
    largest force so far with its elongation and mean slip.
    """
    faces: Faces


class Trial(NamedTuple):
    """The increment being solved, with its work arrays."""

    slides: Signs
    z: Array
    sheets: Array
    force: Array
    slip: Array
    push: Array
    pull: Array
    """(2,) forces of the faces for which the pattern was determined [N]."""
    values: Array
    """Cap and force."""
    offset: Array
    bound: Array
    centre: Array
    group: Signs
    diagonal: Array
    couple: Array
    terms: Terms
    """(n, 4) displacement of a group = terms . (1, U, p0, p1)."""
    knots: Knots
    marks: Flags
    """(n - 1,) interfaces that break next."""


def bound(i: int, slip: float, stack: Stack) -> float:
    """Return the kinetic friction of interface i at w_{i+1} - w_i = slip [N]."""
    forward = -slip if stack.right[i] else slip
    return max(stack.friction[i] * (1.0 - forward / stack.length[i]), 0.0)


def stiffness_sum(stack: Stack) -> float:
    """Return the sum of all anchor springs [N/m]."""
    stiff = 0.0
    for i in range(stack.sheet_count):
        stiff += stack.springs[i]
    return stiff


def margin(i: int, reach: float, stiff: float, stack: Stack) -> float:
    """Return the tolerance [N] within which the force of interface i counts as its bound."""
    return _TIGHT * stack.friction[i] + _ROUNDED * stiff * reach


def is_held(i: int, stack: Stack, state: State) -> bool:
    """Return whether interface i rests on static friction that exceeds kinetic friction."""
    return stack.ratio[i] > 1.0 and not state.moving[i] and bound(i, state.past[i], stack) > 0.0


def compute_response(stack: Stack, state: State, t: Trial) -> None:
    """Compute how groups of stuck sheets follow cap and faces, for the pattern of `t`.

    A sliding interface carries f = s c (1 - slip/length), s its sign, which couples its groups.
    """
    n = stack.sheet_count
    t.offset[0] = 0.0
    for i in range(n - 1):
        t.offset[i + 1] = t.offset[i] + state.past[i]
    j, total = 0, 0.0
    for m in range(4):
        t.terms[0, m] = 0.0
    for i in range(n):
        d = stack.springs[i]
        total += d
        t.group[i] = j
        t.terms[j, 0] -= d * t.offset[i]
        if stack.right[i]:
            t.terms[j, 1] += d
        last = i == n - 1
        if last or t.slides[i] != 0:
            t.diagonal[j] = total + (t.diagonal[j] if j > 0 else 0.0)
            if not last:
                sign = -1.0 if stack.right[i] else 1.0
                hold, soft = 0.0, 0.0
                if sign * t.slip[i] < stack.length[i]:
                    soft = t.slides[i] * sign * stack.friction[i] / stack.length[i]
                    hold = t.slides[i] * stack.friction[i] - soft * state.past[i]
                t.couple[j] = soft
                t.diagonal[j] -= soft
                t.diagonal[j + 1] = -soft
                t.terms[j, 0] += hold
                t.terms[j + 1, 0] = -hold
                for m in range(1, 4):
                    t.terms[j + 1, m] = 0.0
                j, total = j + 1, 0.0
    for e in range(2):
        end = stack.ends[e]
        t.terms[t.group[end], 2 + e] = -1.0 if stack.right[end] else 1.0
    diagonal = t.diagonal[0]
    for k in range(1, j + 1):
        factor = t.couple[k - 1] / diagonal
        diagonal = t.diagonal[k] - factor * t.couple[k - 1]
        t.diagonal[k] = diagonal
        for m in range(4):
            t.terms[k, m] -= factor * t.terms[k - 1, m]
    for m in range(4):
        t.terms[j, m] /= diagonal
    for k in range(j - 1, -1, -1):
        couple, diagonal = t.couple[k], t.diagonal[k]
        for m in range(4):
            t.terms[k, m] = (t.terms[k, m] - couple * t.terms[k + 1, m]) / diagonal


def _lay_out_sheets(stack: Stack, state: State, t: Trial) -> None:
    """Compute sheets, forces and slips of the pattern of `t` from its cap and faces."""
    n, cap = stack.sheet_count, t.values[CAP]
    p0, p1 = t.push
    total, force = 0.0, 0.0
    for i in range(n):
        j = t.group[i]
        t.z[i] = t.terms[j, 0] + t.terms[j, 1] * cap + t.terms[j, 2] * p0 + t.terms[j, 3] * p1
        t.sheets[i] = t.z[i] + t.offset[i]
        stretch = t.sheets[i] - (cap if stack.right[i] else 0.0)
        force += stack.springs[i] * stretch
        for e in range(2):
            if i == stack.ends[e]:
                force += t.push[e] if stack.right[i] else -t.push[e]
                total += 0.0 if stack.right[i] else t.push[e]
        if stack.right[i]:
            total -= stack.springs[i] * stretch
        if i < n - 1:
            t.force[i] = force
    t.values[FORCE] = total
    for i in range(n - 1):
        t.slip[i] = state.past[i] + (t.z[i + 1] - t.z[i] if t.slides[i] != 0 else 0.0)


def place_sheets(target: float, slack: float, stack: Stack, state: State, t: Trial) -> int:
    """Compute cap, faces, sheets and forces of the pattern; SNAPPED if the mount is too soft."""
    n = stack.sheet_count
    compute_response(stack, state, t)
    # coefficients of the force on the cap, and of the gaps, for (1, U, p0, p1)
    f0, fu, fa, fb = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        if stack.right[i]:
            d, j = stack.springs[i], t.group[i]
            f0 -= d * (t.offset[i] + t.terms[j, 0])
            fu += d * (1.0 - t.terms[j, 1])
            fa -= d * t.terms[j, 2]
            fb -= d * t.terms[j, 3]
    first, last = stack.ends
    fa += 0.0 if stack.right[first] else 1.0
    fb += 0.0 if stack.right[last] else 1.0
    # equation of the cap: U = u, or mount (u - U) = F, or F = 0
    u0, ua, ub = target, 0.0, 0.0
    if slack > 0.0 or not np.isinf(stack.mount):
        spring = fu + (0.0 if slack > 0.0 else stack.mount)
        if spring <= 0.0:
            return SNAPPED
        u0 = ((0.0 if slack > 0.0 else stack.mount * target) - f0) / spring
        ua, ub = -fa / spring, -fb / spring
    p0, p1 = 0.0, 0.0
    if stack.face[0] > 0.0:
        s0, s1 = (-1.0 if stack.right[first] else 1.0), (-1.0 if stack.right[last] else 1.0)
        a, b = t.terms[t.group[first]], t.terms[t.group[last]]
        h0 = (0.0 if stack.right[first] else 1.0) - s0 * a[1]
        h1 = (0.0 if stack.right[last] else 1.0) - s1 * b[1]
        g0 = h0 * u0 - s0 * (a[0] + t.offset[first])
        g1 = h1 * u0 - s1 * (b[0] + t.offset[last])
        b00, b01 = h0 * ua - s0 * a[2], h0 * ub - s0 * a[3]
        b10, b11 = h1 * ua - s1 * b[2], h1 * ub - s1 * b[3]
        p0, p1 = state.faces.push
        for _ in range(_ROUNDS):
            at0, slope0 = face_gap(p0, 0, state.faces, stack.face)
            at1, slope1 = face_gap(p1, 1, state.faces, stack.face)
            # at the start of first loading, two faces on one group of sheets have a single unknown
            slope0, slope1 = max(slope0, -1e-6 * b00), max(slope1, -1e-6 * b11)
            r0 = g0 + b00 * p0 + b01 * p1 - at0
            r1 = g1 + b10 * p0 + b11 * p1 - at1
            m00, m11 = slope0 - b00, slope1 - b11
            determinant = m00 * m11 - b01 * b10
            d0, d1 = (m11 * r0 + b01 * r1) / determinant, (m00 * r1 + b10 * r0) / determinant
            p0, p1 = p0 + d0, p1 + d1
            if abs(d0) <= 1e-14 * abs(p0) + 1e-15 and abs(d1) <= 1e-14 * abs(p1) + 1e-15:
                break
    cap = u0 + ua * p0 + ub * p1
    t.push[0], t.push[1] = p0, p1
    t.values[CAP] = cap
    _lay_out_sheets(stack, state, t)
    return DONE


def solve_increment(target: float, slack: float, stack: Stack, state: State, t: Trial) -> int:
    """Solve the increment to `target`, or to zero force; static interfaces stay at rest."""
    n = stack.sheet_count
    for i in range(n - 1):
        t.slides[i], t.slip[i] = state.slides[i], state.past[i]
        if is_held(i, stack, state):
            t.slides[i] = 0
    cap, stiff = state.values[CAP], stiffness_sum(stack)
    before, snaps = cap, 0
    t.pull[0], t.pull[1] = state.faces.push
    for turn in range(_ROUNDS):
        code = place_sheets(target, slack, stack, state, t)
        fine, reach = code == DONE, abs(t.values[CAP]) + abs(target)
        for i in range(n - 1):
            tight = margin(i, reach, stiff, stack)
            if t.slides[i] != 0:
                progress = t.slides[i] * (t.slip[i] - state.past[i])
                fine &= progress >= -tight / stack.springs[i]
                # bounds depend on the overlap, which is that of the previous round
                hold = t.slides[i] * bound(i, t.slip[i], stack)
                fine &= abs(t.force[i] - hold) <= 1e3 * tight
            elif not is_held(i, stack, state):
                fine &= abs(t.force[i]) <= bound(i, t.slip[i], stack) + tight
        if fine:
            return DONE
        if code != DONE:
            snaps += 1
            if snaps > _SNAPS:
                return code
            # if all slid one way before and slide the other way now, the solution is in between
            cap = (cap + before) / 2
            # a sliding pattern is a poor initial guess for a reversal
            for i in range(n - 1):
                t.slides[i], t.slip[i] = 0, state.past[i]
            if turn == 0:
                continue
        # cap and faces for the next pattern; if two patterns lead to each other, the solution is in
        # between, and decreasing steps find it
        part = 1.0 if turn < 5 else 0.5 if turn < 25 else 12.0 / turn
        if code == DONE:
            before = cap
            cap += part * (t.values[CAP] - cap)
            for e in range(2):
                t.pull[e] += part * (t.push[e] - t.pull[e])
        lowest, highest = np.inf, -np.inf
        for i in range(n):
            t.centre[i] = (cap if stack.right[i] else 0.0) - t.offset[i]
            for e in range(2):
                if i == stack.ends[e]:
                    pull = -t.pull[e] if stack.right[i] else t.pull[e]
                    t.centre[i] += pull / stack.springs[i]
            lowest, highest = min(lowest, t.centre[i]), max(highest, t.centre[i])
        for i in range(n - 1):
            t.bound[i] = bound(i, t.slip[i], stack)
            if is_held(i, stack, state):
                t.bound[i] = stiff * (highest - lowest)  # more than any interface can carry
        fused_lasso(n, stack.springs, t.centre, t.bound, t.z, t.knots)
        for i in range(n - 1):
            jump = t.z[i + 1] - t.z[i]
            t.slides[i] = 1 if jump > 0.0 else -1 if jump < 0.0 else 0
            if t.slides[i] != 0:
                t.slip[i] = state.past[i] + jump
    return STALLED
