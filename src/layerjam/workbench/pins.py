"""Pinned curves: what a chart showed once, kept as the call it came from and computed anew."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from layerjam.errors import QuantityError
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import SHELVES, Desk, read_any
from layerjam.workbench.more import is_file, others
from layerjam.workbench.state import MEASURED, Pin

MOST = 8
"""Curves pinned to one page at most."""
COMMANDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"pull": ("tensile", "judder"), "drop": ("drop",), "vacuum": ("rise", "regulate")}
)
"""{page: commands whose curves can be pinned there}; a link may ask for no other."""
BAND = "band"
"""What a pin of a pull keeps besides options: how sure its law is, as `LawError.text` writes it."""
LINES = ("rise", "regulate")
"""Commands on a vacuum line; all others are on a brake."""


def pin_of(page: str, call: Call) -> Pin:
    """What keeps a call on a brake or line.

    Raises QuantityError for a call with a dropped file: it stays on this machine.
    """
    plain = {k: v for k, v in call.options.items() if isinstance(v, str | bool | int | float)}
    lost = call.options.keys() - plain.keys()
    if lost or call.files:
        what = ", ".join(sorted(lost)) or "a file"
        raise QuantityError(f"pin: {what} comes from a file you dropped, and no link keeps it")
    return Pin(page, call.name, call.subjects[0].text, plain)


def call_of(pin: Pin) -> Call:
    """The call that a pin keeps; QuantityError for what no page pins, such as a path in a link."""
    if pin.command not in COMMANDS.get(pin.page, ()):
        raise QuantityError(f"pin: nothing of '{pin.command[:40]}' is pinned on this page")
    known = {p.name for p in others(pin.command, ()) if not is_file(p)}
    options = {key: v for key, v in pin.options.items() if (pin.command, key) != ("tensile", BAND)}
    strange = sorted(options.keys() - known)
    if strange:
        raise QuantityError(f"pin: '{strange[0][:40]}' is no option that is kept")
    shelf = "line" if pin.command in LINES else "brake"
    file = read_any(shelf, pin.subject)
    named = pin.subject in SHELVES[shelf].names()
    subject = Subject(pin.subject) if named else Subject(f"{file.name}.toml", file)
    return Call(pin.command, (subject,), options)


def labels(calls: Sequence[Call], shown: Call) -> list[str]:
    """What tells each call from what is shown, and from each other where that is not enough."""
    made = [_apart(call, [shown]) or _apart(call, calls) or "as shown" for call in calls]
    for place, label in enumerate(made):
        if made.count(label) > 1:
            made[place] = _apart(calls[place], [shown, *calls]) or label
    return [
        label if made.count(label) == 1 else f"{label} ({made[: place + 1].count(label)})"
        for place, label in enumerate(made)
    ]


def _apart(call: Call, from_these: Sequence[Call]) -> str:
    """The brake or line and the options that differ from any of some calls, as words."""
    name, words = call.subjects[0].name.removesuffix(".toml"), []
    if any(other.subjects != call.subjects for other in from_these):
        words.append(name)
    for key in dict.fromkeys(k for one in (call, *from_these) for k in one.options):
        value = call.options.get(key)
        if any(other.options.get(key) != value for other in from_these):
            said = key.replace("_", " ")
            words.append(said if value is True else f"no {said}" if value is None else str(value))
    return ", ".join(words)


def put_pin(desk: Desk, made: Pin) -> None:
    """Add a pin, unless it is there; QuantityError where a page has as many as it may."""
    pins = desk.state.pins
    if made in pins:
        return
    if sum(one.page == made.page for one in pins) >= MOST:
        raise QuantityError(f"pin: {MOST} curves are pinned; unpin one first")
    desk.put_pins((*pins, made))


def turn_file(desk: Desk, key: str) -> None:
    """Pin a dropped file to the pull, or take that back; QuantityError where there are enough."""
    made = Pin("pull", MEASURED, key)
    if made in desk.state.pins:
        desk.put_pins(tuple(pin for pin in desk.state.pins if pin != made))
    else:
        put_pin(desk, made)
