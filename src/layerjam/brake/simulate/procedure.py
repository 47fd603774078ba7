"""Test procedure as a list of steps and as text, for the simulator, the bench and sidecars.

``"evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm; return at 13 mm/s to 0 mm"``
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from layerjam.brake.simulate.quantities import CROSSHEAD_SPEED, VACUUM
from layerjam.core.errors import LayerjamError, ProcedureError, explain_arguments, short_text
from layerjam.core.units import QuantitySpec, check, exact_text

_POSITION = QuantitySpec("m", "elongation", hi=10)
_TIME = QuantitySpec("s", "duration", hi=1e7)
MAX_STEPS = 200


def _quantity_pattern(spec: QuantitySpec) -> Any:
    return field(metadata={"quantity": spec})


class _Step:
    """Base of every step; `sentence` contains its quantities in braces."""

    sentence: ClassVar[str]

    def text(self) -> str:
        """Return the step as a sentence."""
        texts = {}
        for f in fields(self):  # type: ignore[arg-type]
            texts[f.name] = exact_text(getattr(self, f.name), f.metadata["quantity"].unit)
        return self.sentence.format(**texts)


@dataclass(frozen=True, kw_only=True)
class Evacuate(_Step):
    """Bring the vacuum to `to` [Pa] with the crosshead at rest, then wait for `hold` [s]."""

    to: float = _quantity_pattern(VACUUM)
    hold: float = field(default=0.0, metadata={"quantity": _TIME})

    @property
    def sentence(self) -> str:  # type: ignore[override]
        """Return the sentence, without the hold if it has no duration."""
        return "evacuate to {to} and hold {hold}" if self.hold else "evacuate to {to}"


@dataclass(frozen=True, kw_only=True)
class Vent(_Step):
    """Release the vacuum."""

    sentence = "vent"


@dataclass(frozen=True, kw_only=True)
class Hold(_Step):
    """Wait for `duration` [s]."""

    sentence = "hold {duration}"
    duration: float = _quantity_pattern(_TIME)


@dataclass(frozen=True, kw_only=True)
class Pull(_Step):
    """Move the crosshead out at `speed` [m/s] to the elongation `until` [m]."""

    sentence = "pull at {speed} until {until}"
    speed: float = _quantity_pattern(CROSSHEAD_SPEED)
    until: float = _quantity_pattern(_POSITION)

    @property
    def end(self) -> float:
        """Elongation at the end of the step [m]."""
        return self.until


@dataclass(frozen=True, kw_only=True)
class Return(_Step):
    """Move the crosshead back at `speed` [m/s] to elongation `to` [m]."""

    sentence = "return at {speed} to {to}"
    speed: float = _quantity_pattern(CROSSHEAD_SPEED)
    to: float = _quantity_pattern(_POSITION)

    @property
    def end(self) -> float:
        """Elongation at the end of the step [m]."""
        return self.to


Step = Evacuate | Vent | Hold | Pull | Return


@explain_arguments
@dataclass(frozen=True)
class Procedure:
    """Steps in order, checked against each other on creation.

    Raises ProcedureError for a pull that does not increase the elongation, a return that does not
    decrease it, or a value out of bounds.
    """

    steps: tuple[Step, ...]

    def __post_init__(self) -> None:
        is_sequence = isinstance(self.steps, tuple | list)
        if not is_sequence or any(not isinstance(step, Step) for step in self.steps):
            raise ProcedureError(f"procedure: {short_text(self.steps)} is not a tuple of steps")
        if not self.steps:
            raise ProcedureError("procedure: it contains no steps")
        if len(self.steps) > MAX_STEPS:
            raise ProcedureError(f"procedure: {len(self.steps)} steps; the limit is {MAX_STEPS}")
        position = 0.0
        for step in self.steps:
            check(step, f"procedure, {type(step).__name__.lower()}, ")
            if isinstance(step, Pull | Return):
                out = isinstance(step, Pull)
                if step.end == position or (step.end > position) != out:
                    raise ProcedureError(
                        f"procedure: '{step.text()}' does not {'pull' if out else 'go back'}: the "
                        f"crosshead is already at {exact_text(position, 'm')}"
                    )
                position = step.end

    def text(self) -> str:
        """Return the procedure as a sentence; `parse_procedure` reads it back exactly."""
        return "; ".join(step.text() for step in self.steps)

    def highest_vacuum(self) -> float:
        """Return the highest vacuum of all steps [Pa]."""
        return max((s.to for s in self.steps if isinstance(s, Evacuate)), default=0.0)


def simple_pull(vacuum: float, speed: float, travel: float) -> Procedure:
    """Return an evacuation and one pull: vacuum [Pa], speed [m/s], travel [m] of elongation."""
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
"""{sentence of each kind: (pattern with named fields, its steps)}."""


def _read_step(kind: type[Step], texts: Mapping[str, str | None]) -> Step:
    entries = ((f.name, f.metadata["quantity"], texts.get(f.name)) for f in fields(kind))
    return kind(
        **{
            name: spec.read(text, f"procedure, {spec.text.partition(',')[0]}")
            for name, spec, text in entries
            if text
        }
    )


def parse_procedure(text: str) -> Procedure:
    """Return a Procedure from text, whose sentences are separated by ';'.

    Raises ProcedureError for an unknown sentence, for a quantity that cannot be read, and for steps
    that contradict each other.
    """
    steps: list[Step] = []
    if not isinstance(text, str):
        raise ProcedureError(f"procedure: {short_text(text)} is not a string such as 'vent'")
    for part in text.split(";"):
        sentence = " ".join(part.split())
        if not sentence:
            continue
        for pattern, kinds in _SENTENCES.values():
            match = re.fullmatch(pattern, sentence, re.IGNORECASE)
            if match:
                groups = match.groupdict()
                times = int(groups.get("times", 1))
                if times * len(kinds) > MAX_STEPS:
                    raise ProcedureError(
                        f"procedure: {times} cycles; the limit is {MAX_STEPS // len(kinds)}"
                    )
                try:
                    steps += [_read_step(kind, groups) for kind in kinds] * times
                except LayerjamError as err:
                    raise ProcedureError(str(err)) from None
                break
        else:
            names = "; ".join(_SENTENCES)
            raise ProcedureError(f"procedure: '{sentence[:60]}' is not a step; use one of: {names}")
    return Procedure(tuple(steps))
