"""Pinned curves, stored as calls that are run again."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from layerjam.core.errors import QuantityError
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.desk import SHELVES, Desk, read_device
from layerjam.workbench.more import find_other_inputs, is_file
from layerjam.workbench.state import MEASURED, Pin

MAX_PINS = 8
"""Largest number of curves pinned to one page."""
COMMANDS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"pull": ("tensile", "judder"), "drop": ("drop",), "vacuum": ("rise", "regulate")}
)
"""{page: commands whose curves can be pinned there}; links with other commands are rejected."""
BAND = "band"
"""Option of a pinned pull that is shown with its band; its text has no meaning."""
LINES = ("rise", "regulate")
"""Commands that act on a vacuum line; all others act on a brake."""


def make_pin(page: str, call: Call) -> Pin:
    """Return the pin for a call on a brake or line.

    Raises QuantityError for a call with a dropped file, because that file stays on this machine.
    """
    simple_options = {
        k: v for k, v in call.options.items() if isinstance(v, str | bool | int | float)
    }
    files = call.options.keys() - simple_options.keys()
    if files or call.files:
        names = ", ".join(sorted(files)) or "a file"
        raise QuantityError(
            f"pin: {names} comes from a file you dropped, which a link cannot contain"
        )
    return Pin(page, call.name, call.subjects[0].text, simple_options)


def make_call(pin: Pin) -> Call:
    """Return the call of a pin.

    Raises QuantityError for a pin that no page can create, such as a path in a link.
    """
    if pin.command not in COMMANDS.get(pin.page, ()):
        raise QuantityError(f"pin: curves of '{pin.command[:40]}' cannot be pinned on this page")
    inputs = {p.name for p in find_other_inputs(pin.command, ()) if not is_file(p)}
    options = {key: v for key, v in pin.options.items() if (pin.command, key) != ("tensile", BAND)}
    strange = sorted(options.keys() - inputs)
    if strange:
        raise QuantityError(f"pin: '{strange[0][:40]}' is not an option of a pinned curve")
    shelf = "line" if pin.command in LINES else "brake"
    file = read_device(shelf, pin.subject)
    in_catalogue = pin.subject in SHELVES[shelf].names()
    subject = Subject(pin.subject) if in_catalogue else Subject(f"{file.name}.toml", file)
    return Call(pin.command, (subject,), options)


def make_pin_labels(calls: Sequence[Call], current: Call) -> list[str]:
    """Return labels that distinguish calls from the current one and, if necessary, each other."""
    names = [
        _describe_difference(call, [current]) or _describe_difference(call, calls) or "as shown"
        for call in calls
    ]
    for place, label in enumerate(names):
        if names.count(label) > 1:
            names[place] = _describe_difference(calls[place], [current, *calls]) or label
    return [
        label if names.count(label) == 1 else f"{label} ({names[: place + 1].count(label)})"
        for place, label in enumerate(names)
    ]


def _describe_difference(call: Call, from_these: Sequence[Call]) -> str:
    """Return, as text, the brake or line and the options in which a call differs from others."""
    name, words = call.subjects[0].name.removesuffix(".toml"), []
    if any(peer.subjects != call.subjects for peer in from_these):
        words.append(name)
    for key in dict.fromkeys(k for c in (call, *from_these) for k in c.options):
        value = call.options.get(key)
        if any(peer.options.get(key) != value for peer in from_these):
            text = key.replace("_", " ")
            words.append(text if value is True else f"no {text}" if value is None else str(value))
    return ", ".join(words)


def add_pin(desk: Desk, pin: Pin) -> None:
    """Add a pin unless it exists; raises QuantityError if the page has the maximum number."""
    pins = desk.state.pins
    if pin in pins:
        return
    if sum(p.page == pin.page for p in pins) >= MAX_PINS:
        raise QuantityError(f"pin: {MAX_PINS} curves are pinned; unpin one first")
    desk.put_pins((*pins, pin))


def toggle_file_pin(desk: Desk, key: str) -> None:
    """Pin a dropped file to the Pull page, or unpin it; raises QuantityError for too many pins."""
    file_pin = Pin("pull", MEASURED, key)
    if file_pin in desk.state.pins:
        desk.put_pins(tuple(pin for pin in desk.state.pins if pin != file_pin))
    else:
        add_pin(desk, file_pin)
