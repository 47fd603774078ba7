"""Which sheet slides when (ours): the stack as a weighted one-dimensional fused lasso.

Sheet i has displacement w_i and an anchor spring d_i to its cap (left ones to ground, right ones to
the cap at U). Interface i carries f_i, |f_i| <= c_i, and has slipped by s_i. One increment is

    min over w of  1/2 sum d_i (w_i - y_i)^2 + sum c_i |w_{i+1} - w_i - s_i|,  y_i = 0 or U,

strictly convex, so that the answer is unique; it is found exactly, in time linear in the sheets, by
dynamic programming over the derivative of the cost (Johnson 2013), whose clipping is the friction
bound. No time step, no contact stiffness, no chatter. The kernels are plain loops for numba: state
and branches in them are what array code is worst at.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from layerjam.errors import QuantityError

Array = np.ndarray[Any, np.dtype[np.float64]]
Flags = np.ndarray[Any, np.dtype[np.bool_]]
_ROUNDS = 200


class Stack(NamedTuple):
    """A stack at a vacuum; n sheets, n - 1 interfaces.

    Bounds are per metre of overlap: static and kinetic friction times width and pressure of each
    interface, which may differ (scatter, pressure missing in the middle). `extra` is how much more
    (or less) an interface overlaps than the nominal length (misaligned sheets).
    """

    springs: Array
    """(n,) anchor springs [N/m]."""
    right: Flags
    """(n,) True for sheets held by the moving cap."""
    static: Array
    """(n - 1,) [N/m]"""
    kinetic: Array
    """(n - 1,) [N/m]"""
    overlap: float
    """[m]"""
    extra: Array
    """(n - 1,) [m]"""
    mount: float
    """Spring between crosshead and moving cap [N/m]; infinite for a rigid one."""
    face: Array
    """(3,) one face of the sleeve: EA [N], friction q [N/m], reach l [m]; EA = 0 for none."""


class StackPull(NamedTuple):
    """What a stack did along a history of N elongations."""

    force: Array
    """(N,) at the crosshead [N]."""
    cap: Array
    """(N,) displacement of the moving cap [m]."""
    sheets: Array
    """(N, n) displacement of each sheet [m]."""
    interface: Array
    """(N, n - 1) force of each interface [N]."""
    slip: Array
    """(N, n - 1) slip of each interface, positive as the brake lengthens [m]."""
    sliding: Flags
    """(N, n - 1) True where the interface slides."""


@numba.njit(cache=True)
def fused_lasso(d: Array, b: Array, c: Array, z: Array, work: Array) -> None:  # pragma: no cover
    """z minimising 1/2 sum d (z - b)^2 + sum c |z_{i+1} - z_i|, exactly; `work` is (4, 2 n).

    The cost of z_i over all to its left has a piecewise linear derivative; an interface clips it to
    its bound, which leaves two knots. Every knot is met once on either side: linear in n.
    """
    n = len(d)
    x, slope, level, bounds = work[0], work[1], work[2], work[3]
    left, right = n - 1, n
    low, high = bounds[:n], bounds[n:]
    low[0], high[0] = b[0] - c[0] / d[0], b[0] + c[0] / d[0]
    x[left], x[right] = low[0], high[0]
    slope[left], level[left] = d[0], -d[0] * b[0] + c[0]
    slope[right], level[right] = -d[0], d[0] * b[0] + c[0]
    for k in range(1, n):
        first_slope, first_level = d[k], -d[k] * b[k] - c[k - 1]
        last_slope, last_level = -d[k], d[k] * b[k] - c[k - 1]
        bound = c[k] if k < n - 1 else 0.0
        i = left
        while i <= right and first_slope * x[i] + first_level <= -bound:
            first_slope += slope[i]
            first_level += level[i]
            i += 1
        if k == n - 1:
            z[k] = -first_level / first_slope
            break
        j = right
        while j >= i and -last_slope * x[j] - last_level >= bound:
            last_slope += slope[j]
            last_level += level[j]
            j -= 1
        low[k] = (-bound - first_level) / first_slope
        high[k] = -(bound + last_level) / last_slope
        left, right = i - 1, j + 1
        x[left], slope[left], level[left] = low[k], first_slope, first_level + bound
        x[right], slope[right], level[right] = high[k], last_slope, last_level + bound
    for k in range(n - 2, -1, -1):
        z[k] = min(max(z[k + 1], low[k]), high[k])


@numba.njit(cache=True)
def _face_force(slip: float, face: Array) -> float:  # pragma: no cover
    """One face of the sleeve in first loading [N]; it pulls only."""
    stiff, q, reach = face[0], face[1], face[2]
    if slip <= 0.0 or stiff == 0.0:
        return 0.0
    if stiff * slip < q * reach * reach:
        return float(np.sqrt(stiff * q * slip))
    return stiff * slip / (2 * reach) + q * reach / 2


@numba.njit(cache=True)
def _solve_at(
    cap: float, past: Array, bound: Array, push: Array, springs: Array, right: Flags,
    sheets: Array, force: Array, work: Array, rows: Array,
) -> float:  # pragma: no cover  # fmt: skip
    """Sheets and interface forces for the cap at `cap`; gives the force on the cap [N]."""
    n = len(springs)
    offset, centre, z = rows[0], rows[1], rows[2]
    offset[0] = 0.0
    for i in range(n - 1):
        offset[i + 1] = offset[i] + past[i]
    for i in range(n):
        home = cap if right[i] else 0.0
        centre[i] = home + push[i] / springs[i] - offset[i]
    fused_lasso(springs, centre, bound, z, work)
    total, carried = 0.0, 0.0
    for i in range(n):
        sheets[i] = z[i] + offset[i]
        home = cap if right[i] else 0.0
        held = springs[i] * (sheets[i] - home)
        if right[i]:
            total -= held
        carried += held - push[i]
        if i < n - 1:
            # a stuck interface is one whose z does not jump; rounding must not decide that
            force[i] = min(max(carried, -bound[i]), bound[i])
    return total


@numba.njit(cache=True)
def _settle(
    cap: float, past: Array, slips: Array, moving: Flags, stack: tuple[Any, ...],
    sheets: Array, force: Array, bound: Array, now: Flags, push: Array, work: Array, rows: Array,
) -> float:  # pragma: no cover  # fmt: skip
    """All interfaces at rest with the cap at `cap`: bounds follow the slip, static ones break.

    `now` marks interfaces that have broken in this increment or were sliding before it. Gives the
    force on the cap, faces of the sleeve included.
    """
    springs, right, static, kinetic, overlap, extra, face = stack
    n = len(springs)
    total = 0.0
    now[:] = moving
    slips[:] = past
    for _ in range(_ROUNDS):
        for i in range(n - 1):
            sign = -1.0 if right[i] else 1.0
            contact = max(overlap + extra[i] - sign * slips[i], 0.0)
            bound[i] = (kinetic[i] if now[i] else static[i]) * contact
        change = 0.0
        for end in (0, n - 1):
            gap = sheets[end] if right[end] else cap - sheets[end]
            pull = _face_force(gap, face) * (-1.0 if right[end] else 1.0)
            change = max(change, abs(pull - push[end]) / springs[end])
            push[end] = pull
        total = _solve_at(cap, past, bound, push, springs, right, sheets, force, work, rows)
        broke = False
        for i in range(n - 1):
            slid = rows[2][i + 1] != rows[2][i]
            new = sheets[i + 1] - sheets[i] if slid else past[i]
            change = max(change, abs(new - slips[i]))
            slips[i] = new
            if slid and not now[i] and kinetic[i] < static[i]:
                now[i] = True
                broke = True
            elif slid:
                now[i] = True
        if not broke and change < 1e-13:
            break
    for i in range(n - 1):
        now[i] = rows[2][i + 1] != rows[2][i]
    # a face anchored on a right sheet ends on the left cap: ground carries it, the sheet passes it
    held = 0.0
    for end in (0, n - 1):
        if not right[end]:
            held += push[end]
    return total + held


@numba.njit(cache=True)
def _run(
    path: Array, springs: Array, right: Flags, static: Array, kinetic: Array, overlap: float,
    extra: Array, mount: float, face: Array, force: Array, caps: Array, sheets: Array,
    interface: Array, slip: Array, sliding: Flags,
) -> int:  # pragma: no cover  # fmt: skip
    """Follow the path; gives the number of increments done before the sheets separated."""
    n = len(springs)
    stack = (springs, right, static, kinetic, overlap, extra, face)
    past, moving = np.zeros(n - 1), np.zeros(n - 1, np.bool_)
    slips, now = np.zeros(n - 1), np.zeros(n - 1, np.bool_)
    w, f, bound, push = np.zeros(n), np.zeros(n - 1), np.zeros(n - 1), np.zeros(n)
    work, rows = np.zeros((4, 2 * n)), np.zeros((3, n))
    cap, load = 0.0, 0.0
    for step in range(len(path)):
        target = path[step]
        if np.isinf(mount):
            cap = target
            load = _settle(cap, past, slips, moving, stack, w, f, bound, now, push, work, rows)
        else:
            # the cap's place, mount (u - U) = F(U): Illinois steps between the last place, where
            # both sides are known, and the crosshead's, where the mount would be slack
            near, far = cap, target
            above = mount * (target - cap) - load
            below = -_settle(far, past, slips, moving, stack, w, f, bound, now, push, work, rows)
            side = 0
            for _ in range(_ROUNDS):
                if above == below:
                    break
                cap = (near * below - far * above) / (below - above)
                load = _settle(cap, past, slips, moving, stack, w, f, bound, now, push, work, rows)
                rest = mount * (target - cap) - load
                if abs(rest) <= 1e-12 * abs(load) or abs(far - near) <= 1e-15:
                    break
                if rest * above > 0:
                    near, above = cap, rest
                    below = below / 2 if side == 1 else below
                    side = 1
                else:
                    far, below = cap, rest
                    above = above / 2 if side == -1 else above
                    side = -1
        past[:] = slips
        moving[:] = now
        force[step], caps[step] = load, cap
        sheets[step], interface[step], sliding[step] = w, f, now
        done = True
        for i in range(n - 1):
            slip[step, i] = -past[i] if right[i] else past[i]
            if slip[step, i] < overlap + extra[i]:
                done = False
        if done:
            return step + 1
    return len(path)


def pull_stack(path: Array, stack: Stack) -> StackPull:
    """Move the crosshead along `path` [m], shape (N,), from rest.

    Increments should be small against the elastic stretch (tens of micrometres near onset).
    Raises QuantityError for a stack whose arrays do not fit together. The arrays end where no
    interface overlaps any more.
    """
    n, steps = len(stack.springs), len(path)
    if n < 2 or any(len(a) != n - 1 for a in (stack.static, stack.kinetic, stack.extra)):
        raise QuantityError(f"stack: {n} sheets need {n - 1} interfaces, at least one")
    out = StackPull(
        np.zeros(steps), np.zeros(steps), np.zeros((steps, n)), np.zeros((steps, n - 1)),
        np.zeros((steps, n - 1)), np.zeros((steps, n - 1), bool),
    )  # fmt: skip
    done = _run(
        np.ascontiguousarray(path, float), stack.springs, stack.right, stack.static, stack.kinetic,
        float(stack.overlap), stack.extra, float(stack.mount), stack.face, *out,
    )  # fmt: skip
    return StackPull(
        force=out.force[:done],
        cap=out.cap[:done],
        sheets=out.sheets[:done],
        interface=out.interface[:done],
        slip=out.slip[:done],
        sliding=out.sliding[:done],
    )
