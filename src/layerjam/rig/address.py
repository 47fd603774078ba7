"""Addresses of benches: `serial:PORT`, `tcp:host:5025`, `visa:RESOURCE`, `sim:choi2018?speed=10`.

`tcp:host:5025?token=FILE` names the file of the gateway's token.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from layerjam.errors import QuantityError, UnknownNameError

KINDS = {
    "serial": "serial:/dev/ttyACM0",
    "tcp": "tcp:127.0.0.1:5025",
    "visa": "visa:TCPIP::127.0.0.1::5025::SOCKET",
    "sim": "sim:choi2018",
}
"""Kind: an example."""
VIRTUAL = "sim:choi2018?noise=50Pa&leak=500s&vent=0.2s"
"""The paper's line with a leak, a vent valve and a noisy sensor of ours: for campaigns."""
SIMULATED = (
    "speed",
    "rest",
    "range",
    "noise",
    "at",
    "leak",
    "vent",
    "second",
    "seed",
    "python",
    "store",
)
OPTIONS = {"sim": SIMULATED, "tcp": ("token",)}
"""Kind of address: options that may follow its question mark."""


@dataclass(frozen=True)
class Address:
    """A bench's address, read; `where` is a port, `host:port` or a vacuum line."""

    kind: str
    where: str
    options: Mapping[str, str] = field(default_factory=dict)

    @property
    def simulated(self) -> bool:
        """Whether no hardware is behind it."""
        return self.kind == "sim"

    @property
    def host_port(self) -> tuple[str, int]:
        """Of a `tcp:` address."""
        host, _, port = self.where.rpartition(":")
        return host.strip("[]"), int(port)

    def __str__(self) -> str:
        more = "&".join(f"{name}={value}" for name, value in self.options.items())
        return f"{self.kind}:{self.where}" + (f"?{more}" if more else "")


def address_of(text: str | Address) -> Address:
    """The address that a text states; QuantityError or UnknownNameError where it states none."""
    if isinstance(text, Address):
        return text
    kind, colon, rest = text.partition(":")
    if not colon or not rest:
        shown = " or ".join(f"'{example}'" for example in KINDS.values())
        raise QuantityError.of("address", f"'{text[:80]}' is none; write {shown}")
    if kind not in KINDS:
        raise UnknownNameError("kind of address", kind, KINDS, quantity="address")
    where, options = rest, {}
    if kind in OPTIONS:
        where, _, more = rest.partition("?")
        for pair in more.split("&") if more else []:
            name, equals, value = pair.partition("=")
            if name not in OPTIONS[kind]:
                raise UnknownNameError(
                    f"option of a '{kind}:' address", name, OPTIONS[kind], quantity="address"
                )
            if not equals or not value or name in options:
                raise QuantityError.of("address", f"'{pair[:80]}' is not one '{name}=value'")
            options[name] = value
    if kind == "tcp":
        port = where.rpartition(":")[2]
        if ":" not in where or not port.isdecimal() or not 1 <= int(port) <= 65535:
            raise QuantityError.of(
                "address", f"'{text[:80]}' has no port of 1 to 65535; write '{KINDS['tcp']}'"
            )
    return Address(kind, where, options)
