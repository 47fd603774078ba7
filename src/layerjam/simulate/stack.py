"""The brake pulled sheet by sheet: staggered onset, rounded peak, the load each sheet carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from layerjam.device.brake import Brake
from layerjam.device.file import BrakeFile
from layerjam.errors import ProcedureError
from layerjam.mechanics.enclosure import backbone_dissipated, backbone_stored, sleeve_at
from layerjam.mechanics.friction import friction_per_contact
from layerjam.mechanics.pull import least_stiffness, peak
from layerjam.mechanics.stack import Stack, StackPull, pull_stack
from layerjam.mechanics.stiffness import sheet_section, stiffness_sliding, working_stiffness
from layerjam.simulate.procedure import Evacuate, Procedure, Pull
from layerjam.simulate.record import Outcome, TensileRecord
from layerjam.units import show

FINE, COARSE = 2400, 1200
Array = np.ndarray[Any, np.dtype[np.float64]]


@dataclass(frozen=True, kw_only=True)
class Interfaces:
    """How the n - 1 interfaces differ; each entry is one number or one an interface.

    `friction` multiplies the friction of each, `vacuum` the vacuum that reaches it (housing
    friction is not an interface), `extra_overlap` [m] is added to its overlap.
    """

    friction: float | Array = 1.0
    vacuum: float | Array = 1.0
    extra_overlap: float | Array = 0.0


def stack_of(
    brake: Brake,
    vacuum: float,
    *,
    interfaces: Interfaces | None = None,
    static: bool = False,
    sleeve: bool = True,
    mount: float | None = None,
) -> Stack:
    """The stack of a brake at a vacuum [Pa].

    `static` takes table I's static friction before an interface moves (the paper and the lumped
    brake use the kinetic one throughout). `mount` [N/m] is by default what makes the stack as stiff
    as measured before onset; infinite where nothing was measured.
    """
    sheets, film = brake.sheets, brake.film
    count = sheets.count
    each = interfaces or Interfaces()
    right = np.arange(count) % 2 == 1
    free = np.where(right, sheets.free_right, sheets.free_left)
    springs = film.modulus * float(sheet_section(brake)) / free
    share = np.broadcast_to(np.asarray(each.friction, float), count - 1)
    pressure = vacuum * np.broadcast_to(np.asarray(each.vacuum, float), count - 1)
    one = np.asarray(friction_per_contact(pressure, brake)) / (count - 1)
    kinetic = np.ascontiguousarray(share * one)
    face = sleeve_at(vacuum, brake)
    if mount is None:
        mount = np.inf
        if brake.stiffness_measured is not None:
            rest = 1 / brake.stiffness_measured - 1 / float(stiffness_sliding(0.0, brake))
            mount = 1 / rest if rest > 0 else np.inf
    values = [float(face.stiffness), float(face.friction), float(face.reach)]
    return Stack(
        springs=springs,
        right=right,
        static=kinetic * (film.static / film.kinetic if static else 1.0),
        kinetic=kinetic,
        overlap=sheets.overlap,
        extra=np.broadcast_to(np.asarray(each.extra_overlap, float), count - 1).copy(),
        mount=mount,
        face=np.array(values if sleeve else [0.0, 0.0, 1.0]),
    )


def _places(brake: Brake, vacuum: float, end: float) -> Array:
    """Elongations [m], dense where the sheets let go one after another."""
    top = float(peak(vacuum, brake.sheets.overlap, brake).force)
    near = min(end, 2.0 * top / float(working_stiffness(brake)))
    # a stack of thousands of sheets is smooth anyway, and its history large
    fewer = 1 + brake.sheets.count // 500
    fine, coarse = FINE // fewer + 1, COARSE // fewer + 1
    return np.union1d(np.linspace(0, near, fine), np.linspace(0, end, coarse))


def tensile_stack(
    file: BrakeFile,
    procedure: Procedure,
    *,
    interfaces: Interfaces | None = None,
    static: bool = False,
) -> tuple[TensileRecord, StackPull]:
    """Pull a brake sheet by sheet; one evacuation, then one pull.

    Gives the record (slip is the mean over the interfaces) and what every sheet and interface did.
    Raises ProcedureError for any other procedure: the stack follows no unloading yet.
    """
    steps = procedure.steps
    if len(steps) != 2 or not isinstance(steps[0], Evacuate) or not isinstance(steps[1], Pull):
        raise ProcedureError(
            "procedure: the stack model follows one evacuation and one pull, nothing else yet"
        )
    brake, vacuum, pull = file.brake, steps[0].to, steps[1]
    stack = stack_of(brake, vacuum, interfaces=interfaces, static=static)
    path = _places(brake, vacuum, pull.until)
    result = pull_stack(path, stack)
    count = len(result.force)
    least, k = float(least_stiffness(vacuum, brake)), float(working_stiffness(brake))
    snaps = k <= least and float(result.slip.max(initial=0.0)) > 0
    if snaps:
        count = int(np.argmax(result.force)) + 1
        result = StackPull(*(a[:count] for a in result))  # type: ignore[arg-type]
    path = path[:count]
    ends = [
        result.sheets[:, end] if stack.right[end] else result.cap - result.sheets[:, end]
        for end in (0, brake.sheets.count - 1)
    ]
    face = sleeve_at(vacuum, brake)
    gaps = np.maximum(np.stack(ends), 0.0)
    # the laws count both faces; each end is one
    sleeve_heat = np.asarray(backbone_dissipated(gaps, face)).sum(axis=0) / 2
    sleeve_held = np.asarray(backbone_stored(gaps, face)).sum(axis=0) / 2
    home = np.where(stack.right, result.cap[:, None], 0.0)
    sheets_held = (stack.springs * (result.sheets - home) ** 2).sum(axis=1) / 2
    mount_held = np.zeros(count) if np.isinf(stack.mount) else result.force**2 / (2 * stack.mount)
    sign = np.where(stack.right[:-1], -1.0, 1.0)
    rubbed = _summed(result.interface * sign, result.slip).sum(axis=1)
    done = count == 0 or bool((result.slip[-1] >= stack.overlap + stack.extra).all())
    warnings = list(file.warnings())
    if snaps:
        done = False
        warnings.append(
            f"the brake softens by {show(least, 'N/m')} once it slides: on a rig of "
            f"{show(k, 'N/m')} it snaps; needed is more than that"
        )
    if float(result.slip.max(initial=0.0)) > brake.sheets.usable_travel and not done:
        warnings.append(
            f"slip {show(float(result.slip.max()), 'm')} is beyond the usable travel of "
            f"{show(brake.sheets.usable_travel, 'm')}"
        )
    record = TensileRecord(
        time=path / pull.speed + steps[0].hold,
        elongation=path,
        force=result.force,
        slip=result.slip.mean(axis=1),
        sleeve_force=result.force - (result.interface * sign).sum(axis=1),
        vacuum=np.full(count, vacuum),
        work=_summed(result.force[:, None], path[:, None])[:, 0],
        dissipated_energy=rubbed + sleeve_heat,
        stored_energy=sheets_held + mount_held + sleeve_held,
        outcome=Outcome.SNAPS if snaps else Outcome.SEPARATED if done else Outcome.FINISHED,
        procedure=procedure.text(),
        brake=file,
        model="stack",
        warnings=tuple(warnings),
    )
    return record, result


def _summed(force: Array, way: Array) -> Array:
    """Running integral of force over way along the first axis, by trapezoids."""
    steps = (force[1:] + force[:-1]) / 2 * np.diff(way, axis=0)
    return np.vstack([np.zeros((1, force.shape[1])), np.cumsum(steps, axis=0)])


def peak_spread(
    file: BrakeFile, vacuum: float, scatter: float, samples: int = 200, seed: int = 1
) -> tuple[Array, Array]:
    """Peak force [N] and stiffness before onset [N/m] of pulls whose interfaces scatter.

    Each interface's friction is drawn log-normally with relative SD `scatter`; shape (samples,).
    """
    random = np.random.Generator(np.random.PCG64(seed))
    brake = file.brake
    width = float(np.sqrt(np.log1p(scatter**2)))
    path = _places(brake, vacuum, 3 * float(peak(vacuum, brake.sheets.overlap, brake).elongation))
    tops, springs = np.zeros(samples), np.zeros(samples)
    for i in range(samples):
        draw = np.exp(width * random.standard_normal(brake.sheets.count - 1) - width**2 / 2)
        force = pull_stack(
            path, stack_of(brake, vacuum, interfaces=Interfaces(friction=draw))
        ).force
        tops[i] = force.max()
        rise = (force > 0.1 * tops[i]) & (force < 0.4 * tops[i])
        rise[int(np.argmax(force)) :] = False
        springs[i] = np.polyfit(path[rise], force[rise], 1)[0]
    return tops, springs
