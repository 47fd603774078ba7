"""Faces of the enclosure in the stack: Masing's rule at constant vacuum.

A face is an elastic strip between the sheet it touches and the opposite cap. Over its gap x it
carries f(x) in first loading (half of `EnclosureLaw.force`). After a turn at (x_r, F_r) it carries
F_r -/+ 2 f(|x - x_r|/2), until it meets an older loop, which then continues. The loops use the
inverse, gap versus force, which is smooth where the square root is not.
"""

from typing import Any, NamedTuple

import numpy as np

from layerjam.brake.mechanics.stack.lasso import Array

Turns = np.ndarray[Any, np.dtype[np.float64]]
Signs = np.ndarray[Any, np.dtype[np.int64]]

DONE, SNAPPED, OVERFLOW, CHATTER, STALLED = range(5)
"""Result of an increment: success, a mount that is too soft, full memory, endless breaks of static
friction, no solution."""
DEPTH = 64
"""Number of turning points remembered for nested loops."""


class Faces(NamedTuple):
    """Both faces of the enclosure between two increments."""

    gaps: Turns
    """(2, DEPTH) gaps of the turning points, outermost first [m]."""
    pushes: Turns
    """(2, DEPTH) forces of the turning points [N]."""
    counts: Signs
    """(2,) number of valid turning points."""
    heading: Signs
    """(2,) 1 while a face is being loaded, -1 while unloaded."""
    gap: Array
    """(2,) gaps [m]."""
    push: Array
    """(2,) forces [N]."""
    energy: Array
    """(2,) elastic energies [J]."""


def first_gap(force: float, face: Array) -> tuple[float, float]:
    """Return the gap at which first loading carries `force`, and its slope."""
    stiff, q, reach = face[0], face[1], face[2]
    if force < q * reach:
        return force * force / (stiff * q), 2 * force / (stiff * q)
    return (force - q * reach / 2) * 2 * reach / stiff, 2 * reach / stiff


def first_work(gap: float, face: Array) -> tuple[float, float]:
    """Return work and heat of first loading to `gap` [J], one face."""
    stiff, q, reach = face[0], face[1], face[2]
    start = min(gap, q * reach * reach / stiff)
    root = float(np.sqrt(stiff * q * start)) * start / 3
    linear_gap = gap - start
    linear_work = (stiff * (gap + start) / (4 * reach) + q * reach / 2) * linear_gap
    return 2 * root + linear_work, root + q * reach * linear_gap / 2


def face_gap(push: float, e: int, faces: Faces, face: Array) -> tuple[float, float]:
    """Return the gap at which face `e` carries `push`, and its slope, by Masing's rule."""
    direction = 1 if push >= faces.push[e] else -1
    gaps, pushes = faces.gaps[e], faces.pushes[e]
    origin, close = faces.counts[e] - 1, faces.counts[e] - 2
    gap, force, first = 0.0, 0.0, origin < 0
    if direction == faces.heading[e]:
        if not first:
            gap, force = gaps[origin], pushes[origin]
    else:
        gap, force, first, close = faces.gap[e], faces.push[e], False, close + 1
    while close >= 0 and direction * (push - pushes[close]) >= 0:
        first = close == 0
        if not first:
            gap, force = gaps[close - 1], pushes[close - 1]
        close -= 2
    if first:
        return first_gap(push, face)
    half, slope = first_gap(direction * (push - force) / 2, face)
    return gap + direction * 2 * half, slope


def move_face(push: float, e: int, faces: Faces, face: Array) -> tuple[float, float, int]:
    """Move face `e` to `push` and return work and heat [J]."""
    work, heat = 0.0, 0.0
    if push == faces.push[e]:
        return work, heat, DONE
    direction = 1 if push > faces.push[e] else -1
    gaps, pushes = faces.gaps[e], faces.pushes[e]
    if direction != faces.heading[e]:
        if faces.counts[e] == DEPTH:
            return work, heat, OVERFLOW
        gaps[faces.counts[e]], pushes[faces.counts[e]] = faces.gap[e], faces.push[e]
        faces.counts[e] += 1
        faces.heading[e] = direction
    while faces.push[e] != push:
        count = faces.counts[e]
        closes = count >= 2 and direction * (push - pushes[count - 2]) >= 0
        end, goal = gaps[count - 2] if closes else 0.0, pushes[count - 2] if closes else push
        if count == 0:
            end, _ = first_gap(push, face)
            after, before = first_work(end, face), first_work(faces.gap[e], face)
            work += after[0] - before[0]
            heat += after[1] - before[1]
        else:
            gap, force = gaps[count - 1], pushes[count - 1]
            if not closes:
                half, _ = first_gap(direction * (push - force) / 2, face)
                end = gap + direction * 2 * half
            after = first_work(direction * (end - gap) / 2, face)
            before = first_work(direction * (faces.gap[e] - gap) / 2, face)
            work += force * (end - faces.gap[e]) + 4 * (after[0] - before[0])
            heat += 2 * (after[1] - before[1])
        faces.gap[e], faces.push[e] = end, goal
        if closes:
            faces.counts[e] -= 2
    return work, heat, DONE
