"""A test as typed steps and as text; the simulator, the bench and a data file's sidecar read one.

``"evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm; return at 13 mm/s to 0 mm"``
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from layerjam.errors import LayerjamError, ProcedureError
from layerjam.simulate.quantities import CROSSHEAD_SPEED, VACUUM
from layerjam.units import QuantitySpec, check, exact_text

_POSITION = QuantitySpec("m", "elongation", hi=10)
_TIME = QuantitySpec("s", "duration", hi=1e7)
MAX_STEPS = 200


def _of(spec: QuantitySpec) -> Any:
    return field(metadata={"quantity": spec})


class _Step:
    """What every step can do; `sentence` holds its quantities in braces."""

    sentence: ClassVar[str]

    def text(self) -> str:
        """Its sentence."""
        said = {}
        for one in fields(self):  # type: ignore[arg-type]
            said[one.name] = exact_text(getattr(self, one.name), one.metadata["quantity"].unit)
        return self.sentence.format(**said)


@dataclass(frozen=True, kw_only=True)
class Evacuate(_Step):
    """Bring the vacuum to `to` [Pa] with the crosshead at rest, then wait `hold` [s]."""

    to: float = _of(VACUUM)
    hold: float = field(default=0.0, metadata={"quantity": _TIME})

    @property
    def sentence(self) -> str:  # type: ignore[override]
        """It says nothing of a hold of no time."""
        return "evacuate to {to} and hold {hold}" if self.hold else "evacuate to {to}"


@dataclass(frozen=True, kw_only=True)
class Vent(_Step):
    """Let the vacuum go."""

    sentence = "vent"


@dataclass(frozen=True, kw_only=True)
class Hold(_Step):
    """Wait `duration` [s]."""

    sentence = "hold {duration}"
    duration: float = _of(_TIME)


@dataclass(frozen=True, kw_only=True)
class Pull(_Step):
    """Move the crosshead out at `speed` [m/s] until elongation `until` [m]."""

    sentence = "pull at {speed} until {until}"
    speed: float = _of(CROSSHEAD_SPEED)
    until: float = _of(_POSITION)

    @property
    def end(self) -> float:
        """Elongation where it ends [m]."""
        return self.until


@dataclass(frozen=True, kw_only=True)
class Return(_Step):
    """Move the crosshead back at `speed` [m/s] to elongation `to` [m]."""

    sentence = "return at {speed} to {to}"
    speed: float = _of(CROSSHEAD_SPEED)
    to: float = _of(_POSITION)

    @property
    def end(self) -> float:
        """Elongation where it ends [m]."""
        return self.to


Step = Evacuate | Vent | Hold | Pull | Return


@dataclass(frozen=True)
class Procedure:
    """Steps in order, checked against each other when made.

    Raises ProcedureError for a pull that does not go out, a return that does not go back, or a
    value out of bounds.
    """

    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        if not self.steps:
            raise ProcedureError("procedure: it has no step")
        if len(self.steps) > MAX_STEPS:
            raise ProcedureError(f"procedure: {len(self.steps)} steps; at most {MAX_STEPS}")
        position = 0.0
        for step in self.steps:
            check(step, f"procedure, {type(step).__name__.lower()}, ")
            if isinstance(step, Pull | Return):
                out = isinstance(step, Pull)
                if step.end == position or (step.end > position) != out:
                    raise ProcedureError(
                        f"procedure: '{step.text()}' does not {'pull' if out else 'go back'}: the "
                        f"crosshead is at {exact_text(position, 'm')} already"
                    )
                position = step.end

    def text(self) -> str:
        """The procedure as a sentence; `parse_procedure` reads it back exactly."""
        return "; ".join(step.text() for step in self.steps)

    def highest_vacuum(self) -> float:
        """Greatest vacuum of all steps [Pa]."""
        return max((s.to for s in self.steps if isinstance(s, Evacuate)), default=0.0)


def simple_pull(vacuum: float, speed: float, travel: float) -> Procedure:
    """Evacuate, then one pull: vacuum [Pa], speed [m/s], travel [m] of elongation."""
    return Procedure((Evacuate(to=vacuum), Pull(speed=speed, until=travel)))


_Maker = Callable[[Sequence[str]], list[Step]]


def _q(spec: QuantitySpec, text: str) -> float:
    return spec.read(text, f"procedure, {spec.text}")


def _cycle(found: Sequence[str]) -> list[Step]:
    times = int(found[0])
    if times * 2 > MAX_STEPS:
        raise ProcedureError(f"procedure: {times} cycles; at most {MAX_STEPS // 2}")
    low, high, speed = (
        _q(_POSITION, found[1]),
        _q(_POSITION, found[2]),
        _q(CROSSHEAD_SPEED, found[3]),
    )
    return [Pull(speed=speed, until=high), Return(speed=speed, to=low)] * times


_SENTENCES: dict[str, tuple[str, _Maker]] = {
    "evacuate to 94.5 kPa [and hold 5 s]": (
        r"evacuate to (.+?)(?: and hold (?:for )?(.+))?",
        lambda f: [Evacuate(to=_q(VACUUM, f[0]), hold=_q(_TIME, f[1]) if f[1] else 0.0)],
    ),
    "vent": (r"vent", lambda f: [Vent()]),
    "hold 5 s": (r"hold (?:for )?(.+)", lambda f: [Hold(duration=_q(_TIME, f[0]))]),
    "pull at 13 mm/s until 40 mm": (
        r"pull at (.+?) (?:until|to) (.+)",
        lambda f: [Pull(speed=_q(CROSSHEAD_SPEED, f[0]), until=_q(_POSITION, f[1]))],
    ),
    "return at 13 mm/s to 0 mm": (
        r"return at (.+?) (?:until|to) (.+)",
        lambda f: [Return(speed=_q(CROSSHEAD_SPEED, f[0]), to=_q(_POSITION, f[1]))],
    ),
    "cycle 3 times between 10 mm and 20 mm at 13 mm/s": (
        r"cycle (\d{1,4}) times between (.+?) and (.+?) at (.+)",
        _cycle,
    ),
}


def parse_procedure(text: str) -> Procedure:
    """A Procedure from text; sentences are separated by ';'.

    Raises ProcedureError for a sentence nobody knows, for a quantity that cannot be read, and for
    steps that contradict each other.
    """
    steps: list[Step] = []
    for part in text.split(";"):
        sentence = " ".join(part.split())
        if not sentence:
            continue
        for pattern, make in _SENTENCES.values():
            match = re.fullmatch(pattern, sentence, re.IGNORECASE)
            if match:
                try:
                    steps += make(match.groups())
                except LayerjamError as err:
                    raise ProcedureError(str(err)) from None
                break
        else:
            known = "; ".join(_SENTENCES)
            raise ProcedureError(f"procedure: '{sentence[:60]}' is no step; steps are: {known}")
    return Procedure(tuple(steps))
