"""A test as typed steps and as text; the simulator, the bench and a data file's sidecar read one.

``"evacuate to 94.5 kPa; pull at 13 mm/s until 40 mm; return at 13 mm/s to 0 mm"``
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from layerjam.errors import LayerjamError, ProcedureError
from layerjam.units import QuantitySpec, exact_text

_VACUUM = QuantitySpec("Pa", "vacuum")
_SPEED = QuantitySpec("m/s", "crosshead speed", lo=1e-6, hi=100)
_PLACE = QuantitySpec("m", "elongation", hi=10)
_TIME = QuantitySpec("s", "duration", hi=1e7)
MAX_STEPS = 200


@dataclass(frozen=True, kw_only=True)
class Evacuate:
    """Bring the vacuum to `to` [Pa] with the crosshead at rest, then wait `hold` [s]."""

    to: float
    hold: float = 0.0

    def text(self) -> str:
        """Its sentence."""
        wait = f" and hold {exact_text(self.hold, 's')}" if self.hold else ""
        return f"evacuate to {exact_text(self.to, 'Pa')}{wait}"


@dataclass(frozen=True, kw_only=True)
class Vent:
    """Let the vacuum go."""

    def text(self) -> str:
        """Its sentence."""
        return "vent"


@dataclass(frozen=True, kw_only=True)
class Hold:
    """Wait `duration` [s]."""

    duration: float

    def text(self) -> str:
        """Its sentence."""
        return f"hold {exact_text(self.duration, 's')}"


@dataclass(frozen=True, kw_only=True)
class Pull:
    """Move the crosshead out at `speed` [m/s] until elongation `until` [m]."""

    speed: float
    until: float

    def text(self) -> str:
        """Its sentence."""
        return f"pull at {exact_text(self.speed, 'm/s')} until {exact_text(self.until, 'm')}"


@dataclass(frozen=True, kw_only=True)
class Return:
    """Move the crosshead back at `speed` [m/s] to elongation `to` [m]."""

    speed: float
    to: float

    def text(self) -> str:
        """Its sentence."""
        return f"return at {exact_text(self.speed, 'm/s')} to {exact_text(self.to, 'm')}"


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
        place = 0.0
        for step in self.steps:
            _check(step)
            if isinstance(step, Pull):
                if step.until <= place:
                    raise ProcedureError(
                        f"procedure: '{step.text()}' does not pull: the crosshead is at "
                        f"{exact_text(place, 'm')} already"
                    )
                place = step.until
            elif isinstance(step, Return):
                if step.to >= place:
                    raise ProcedureError(
                        f"procedure: '{step.text()}' does not go back: the crosshead is at "
                        f"{exact_text(place, 'm')}"
                    )
                place = step.to

    def text(self) -> str:
        """The procedure as a sentence; `parse_procedure` reads it back exactly."""
        return "; ".join(step.text() for step in self.steps)

    def highest_vacuum(self) -> float:
        """Greatest vacuum of all steps [Pa]."""
        return max((s.to for s in self.steps if isinstance(s, Evacuate)), default=0.0)


def simple_pull(vacuum: float, speed: float, travel: float) -> Procedure:
    """Evacuate, then one pull: vacuum [Pa], speed [m/s], travel [m] of elongation."""
    return Procedure((Evacuate(to=vacuum), Pull(speed=speed, until=travel)))


def _check(step: Step) -> None:
    rules = {"speed": _SPEED, "until": _PLACE, "hold": _TIME, "duration": _TIME}
    for name, value in vars(step).items():
        rule = rules.get(name) or (_VACUUM if isinstance(step, Evacuate) else _PLACE)
        rule.check(value, f"procedure, {type(step).__name__.lower()}, {name}")


_Maker = Callable[[Sequence[str]], list[Step]]


def _q(spec: QuantitySpec, text: str) -> float:
    return spec.read(text, f"procedure, {spec.text}")


def _cycle(found: Sequence[str]) -> list[Step]:
    times = int(found[0])
    if times * 2 > MAX_STEPS:
        raise ProcedureError(f"procedure: {times} cycles; at most {MAX_STEPS // 2}")
    low, high, speed = _q(_PLACE, found[1]), _q(_PLACE, found[2]), _q(_SPEED, found[3])
    return [Pull(speed=speed, until=high), Return(speed=speed, to=low)] * times


_SENTENCES: dict[str, tuple[str, _Maker]] = {
    "evacuate to 94.5 kPa [and hold 5 s]": (
        r"evacuate to (.+?)(?: and hold (?:for )?(.+))?",
        lambda f: [Evacuate(to=_q(_VACUUM, f[0]), hold=_q(_TIME, f[1]) if f[1] else 0.0)],
    ),
    "vent": (r"vent", lambda f: [Vent()]),
    "hold 5 s": (r"hold (?:for )?(.+)", lambda f: [Hold(duration=_q(_TIME, f[0]))]),
    "pull at 13 mm/s until 40 mm": (
        r"pull at (.+?) (?:until|to) (.+)",
        lambda f: [Pull(speed=_q(_SPEED, f[0]), until=_q(_PLACE, f[1]))],
    ),
    "return at 13 mm/s to 0 mm": (
        r"return at (.+?) (?:until|to) (.+)",
        lambda f: [Return(speed=_q(_SPEED, f[0]), to=_q(_PLACE, f[1]))],
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
