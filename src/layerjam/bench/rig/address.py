"""Addresses of benches: `serial:PORT`, `tcp:host:5025`, `visa:RESOURCE`, `sim:choi2018?speed=10`.

In `tcp:host:5025?token=FILE`, FILE contains the gateway's token.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from layerjam.core.errors import QuantityError, UnknownNameError

KINDS = {
    "serial": "serial:/dev/ttyACM0",
    "tcp": "tcp:127.0.0.1:5025",
    "visa": "visa:TCPIP::127.0.0.1::5025::SOCKET",
    "sim": "sim:choi2018",
}
"""{kind of address: example}."""
VIRTUAL = "sim:choi2018?noise=50Pa&leak=500s&vent=0.2s"
"""The paper's vacuum line with an assumed leak, vent valve and sensor noise, used in campaigns."""
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
"""{kind of address: options that may follow the question mark}."""


@dataclass(frozen=True)
class Address:
    """Parsed address of a bench; `where` is a port, `host:port` or a vacuum line."""

    kind: str
    where: str
    options: Mapping[str, str] = field(default_factory=dict)

    @property
    def simulated(self) -> bool:
        """Whether the bench is simulated."""
        return self.kind == "sim"

    @property
    def host_port(self) -> tuple[str, int]:
        """Host and port of a `tcp:` address."""
        host, _, port = self.where.rpartition(":")
        return host.strip("[]"), int(port)

    def __str__(self) -> str:
        options = "&".join(f"{name}={value}" for name, value in self.options.items())
        return f"{self.kind}:{self.where}" + (f"?{options}" if options else "")


def address_of(text: str | Address) -> Address:
    """Return the parsed address; raises QuantityError or UnknownNameError if it is invalid."""
    if isinstance(text, Address):
        return text
    kind, colon, remainder = text.partition(":")
    if not colon or not remainder:
        examples = " or ".join(f"'{example}'" for example in KINDS.values())
        raise QuantityError.of("address", f"'{text[:80]}' is not an address; write {examples}")
    if kind not in KINDS:
        raise UnknownNameError("kind of address", kind, KINDS, quantity="address")
    target, options = remainder, {}
    if kind in OPTIONS:
        target, _, pairs = remainder.partition("?")
        for pair in pairs.split("&") if pairs else []:
            name, equals, value = pair.partition("=")
            if name not in OPTIONS[kind]:
                raise UnknownNameError(
                    f"option of a '{kind}:' address", name, OPTIONS[kind], quantity="address"
                )
            if not equals or not value or name in options:
                raise QuantityError.of("address", f"'{pair[:80]}' must be one '{name}=value'")
            options[name] = value
    if kind == "tcp":
        port = target.rpartition(":")[2]
        if ":" not in target or not port.isdecimal() or not 1 <= int(port) <= 65535:
            raise QuantityError.of(
                "address", f"'{text[:80]}' has no port from 1 to 65535; write '{KINDS['tcp']}'"
            )
    return Address(kind, target, options)
