"""A test as typed steps and as text; the simulator, the bench and a data file's sidecar read one.

``"evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm; return at 13 mm/s to 0 mm"``
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
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


_SENTENCES: dict[str, tuple[str, Sequence[type[Step]]]] = {
    "evacuate to 94.5 kPa [and hold 5 s]": (
        r"evacuate to (?P<to>.+?)(?: and hold (?:for )?(?P<hold>.+))?",
        (Evacuate,),
    ),
    "vent": (r"vent", (Vent,)),
    "hold 5 s": (r"hold (?:for )?(?P<duration>.+)", (Hold,)),
    "pull at 13 mm/s until 40 mm": (
        r"pull at (?P<speed>.+?) (?:until|to) (?P<until>.+)",
        (Pull,),
    ),
    "return at 13 mm/s to 0 mm": (r"return at (?P<speed>.+?) (?:until|to) (?P<to>.+)", (Return,)),
    "cycle 3 times between 10 mm and 20 mm at 13 mm/s": (
        r"cycle (?P<times>\d{1,4}) times between (?P<to>.+?) and (?P<until>.+?) at (?P<speed>.+)",
        (Pull, Return),
    ),
}
"""{a sentence of each kind: (its pattern, with the fields of its steps by name; its steps)}."""


def _read(kind: type[Step], said: Mapping[str, str | None]) -> Step:
    """A step from the texts of its quantities; what is not said is its default."""
    known = ((f.name, f.metadata["quantity"], said.get(f.name)) for f in fields(kind))
    return kind(
        **{
            name: spec.read(text, f"procedure, {spec.text.partition(',')[0]}")
            for name, spec, text in known
            if text
        }
    )


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
        for pattern, kinds in _SENTENCES.values():
            match = re.fullmatch(pattern, sentence, re.IGNORECASE)
            if match:
                said = match.groupdict()
                times = int(said.get("times", 1))
                if times * len(kinds) > MAX_STEPS:
                    raise ProcedureError(
                        f"procedure: {times} cycles; at most {MAX_STEPS // len(kinds)}"
                    )
                try:
                    steps += [_read(kind, said) for kind in kinds] * times
                except LayerjamError as err:
                    raise ProcedureError(str(err)) from None
                break
        else:
            known = "; ".join(_SENTENCES)
            raise ProcedureError(f"procedure: '{sentence[:60]}' is no step; steps are: {known}")
    return Procedure(tuple(steps))
