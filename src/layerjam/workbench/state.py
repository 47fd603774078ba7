"""A desk's state as plain values, for undo and for links."""

import base64
import binascii
import json
import zlib
from collections.abc import Collection, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace

from pydantic import ConfigDict, TypeAdapter, ValidationError

from layerjam.core.errors import QuantityError

LONGEST_LINK = 30_000
LARGEST = 200_000
"""Largest number of characters of a link, and of its unpacked content."""
Value = float | str | bool
MEASURED = "measured"
"""Command of a pin for a dropped file: its subject is the file's key."""
SHARED = "desk"
"""Name under which the settings that pages share are stored."""
SAME: Mapping[str, tuple[tuple[str, str], ...]] = {
    "vacuum": (
        ("start", "vacuum"),
        ("pull", "vacuum"),
        ("drop", "vacuum"),
        ("vacuum", "target"),
        ("design", "vacuum"),
        ("design", "ours"),
        ("brake", "vacuum"),
    )
}
"""{shared setting: the controls (page, key) that show and set it}."""


def shared_setting(page: str, key: str) -> str:
    """Return the shared setting that a control shows; empty if there is none."""
    return next((name for name, places in SAME.items() if (page, key) in places), "")


def _find_places(page: str, key: str) -> Iterator[tuple[str, str]]:
    """Yield the (page, key) pairs under which a value may be stored; the first found is used.

    Older links contain a separate vacuum for each page.
    """
    name = shared_setting(page, key)
    if name:
        yield SHARED, name
    yield page, key
    if name:
        yield from SAME[name]


@dataclass(frozen=True)
class Pin:
    """A pinned curve: page, command, brake or line (catalogue name or TOML text), and options.

    For a dropped file the command is `MEASURED`, and the subject is the file's key.
    """

    __pydantic_config__ = ConfigDict(strict=True, allow_inf_nan=False)
    page: str
    command: str
    subject: str
    options: dict[str, Value] = field(default_factory=dict)


@dataclass(frozen=True)
class State:
    """The open page, the settings, and the brake and line as catalogue names or TOML texts."""

    __pydantic_config__ = ConfigDict(strict=True, allow_inf_nan=False)
    page: str = "start"
    brake: str = "choi2018-kapton"
    line: str = "choi2018"
    beside: str = ""
    """Second brake, for comparison; empty if there is none."""
    settings: dict[str, dict[str, Value]] = field(default_factory=dict)
    """{page: {control: SI value, choice or flag}}."""
    pins: tuple[Pin, ...] = ()
    """Pinned curves, stored as their calls."""

    @property
    def files(self) -> tuple[str, ...]:
        """Keys of the dropped files that are pinned."""
        return tuple(pin.subject for pin in self.pins if pin.command == MEASURED)

    def without_files(self, keys: Collection[str] = ()) -> "State":
        """Return the state without pins of dropped files, except those with these `keys`."""
        pins = (p for p in self.pins if p.command != MEASURED or p.subject in keys)
        return replace(self, pins=tuple(pins))

    def get(self, page: str, key: str, default: Value) -> Value:
        """Return a setting, or the default."""
        value = self.find_setting(page, key)
        return default if value is None else value

    def find_setting(self, page: str, key: str) -> Value | None:
        """Return a setting, or None."""
        for place, name in _find_places(page, key):
            if name in self.settings.get(place, {}):
                return self.settings[place][name]
        return None

    def put_setting(self, page: str, key: str, value: Value) -> "State":
        """Return a state with one setting changed; shared settings change for all pages."""
        place, name = next(_find_places(page, key))
        settings = dict(self.settings)
        for shared_page, control in SAME.get(name, ()) if place == SHARED else ():
            if control in settings.get(shared_page, {}):
                settings[shared_page] = {
                    k: v for k, v in settings[shared_page].items() if k != control
                }
        settings[place] = {**settings.get(place, {}), name: value}
        return replace(self, settings=settings)


READER = TypeAdapter(State)


class InvalidStateError(ValueError):
    """JSON that is not a valid state, with the location and the reason."""


def read_state(text: str | bytes) -> State:
    """Return the state that a JSON text describes; raises InvalidStateError."""
    try:
        return READER.validate_json(text)
    except ValidationError as err:
        first = err.errors()[0]
        location = ".".join(str(part)[:40] for part in first["loc"]) or "its content"
        raise InvalidStateError(f"{location}: {first['msg']}") from None


def format_link(state: State) -> str:
    """Return the state as text for an address, without pinned files."""
    text = json.dumps(asdict(state.without_files()), separators=(",", ":"), allow_nan=False)
    return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")


def parse_link(text: str) -> State:
    """Return the state that a link contains; raises QuantityError if it is invalid or too long."""
    if len(text) > LONGEST_LINK:
        raise QuantityError(f"link: {len(text)} characters; the limit is {LONGEST_LINK}")
    try:
        data = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        reader = zlib.decompressobj()
        content = reader.decompress(data, LARGEST)
        if reader.unconsumed_tail or not reader.eof:
            raise ValueError("too large")
        return read_state(content)
    except InvalidStateError as err:
        raise QuantityError(f"link: {err}; the page uses the default values") from None
    except (binascii.Error, zlib.error, ValueError):
        raise QuantityError("link: it cannot be read; the page uses the default values") from None
