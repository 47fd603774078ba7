"""Source of a number."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

from layerjam.core.errors import QuantityError, UnknownNameError
from layerjam.core.units import QuantitySpec

KINDS: Mapping[str, str] = {
    "paper": "printed in the paper",
    "inferred": "not printed, but derived from printed values",
    "measured": "measured on this brake or this pair of surfaces",
    "calibrated": "fitted to pulls of this brake",
    "data sheet": "from the manufacturer's data sheet for the material",
    "handbook": "published for this material, not measured on these surfaces",
    "synthetic": "from files written by a program, not measured",
    "assumed": "assumed, without a source",
    "unstated": "not stated in the file",
}
_SD = QuantitySpec("1", "standard deviation divided by the mean")
_KEYS = {
    "kind": "kind",
    "source": "text",
    "was": "was",
    "spread": "spread",
    "conflict": "conflict",
}
"""{key of a file: field of Source}."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """Source of one number.

    `kind` is one of KINDS and `text` names the source. `was` is the earlier value with its source,
    if the number was set by hand. `spread` is the scatter as printed in the source, and `sd` the
    relative standard deviation. `conflict` describes a source with a different value.
    """

    kind: str = "unstated"
    text: str = ""
    was: str = ""
    spread: str = ""
    conflict: str = ""
    sd: float | None = None

    def __post_init__(self) -> None:
        if self.sd is None:
            object.__setattr__(self, "sd", _relative_sd(self.spread))

    def sentence(self) -> str:
        """Return the source as one line of text."""
        parts = [f"{self.kind}: {self.text}" if self.text else self.kind]
        if self.was:
            parts.append(f"was {self.was}")
        if self.spread:
            parts.append(f"spread {self.spread}")
        if self.conflict:
            parts.append(f"conflict: {self.conflict}")
        return "; ".join(parts)

    def to_synthetic(self) -> Self:
        """Return the source for a number that was computed from files that a program generated."""
        measured_here = self.kind in ("measured", "calibrated")
        return replace(self, kind="synthetic") if measured_here else self

    @classmethod
    def read(cls, table: Mapping[str, Any], name: str) -> tuple[Any, Self]:
        """Return a value and its source from { value = "13 mm", source = "caliper" }."""
        keys = {"value", "sd", *_KEYS}
        unknown_keys = ", ".join(sorted(set(table) - keys))[:60]
        if unknown_keys or "value" not in table:
            problem = f"has the unknown key {unknown_keys}" if unknown_keys else "has no value"
            keys_text = ", ".join(sorted(keys))
            raise QuantityError(f"{name} {problem}; allowed keys: {keys_text}", quantity=name)
        words = {field: table[key] for key, field in _KEYS.items() if key in table}
        for field, word in words.items():
            if not isinstance(word, str):
                raise QuantityError(f"{name}.{field} must be text in quotes", quantity=name)
        if words.get("kind", "unstated") not in KINDS:
            raise UnknownNameError("kind", words["kind"], KINDS, quantity=name)
        sd = _SD.read(table["sd"], f"{name}.sd") if "sd" in table else None
        return table["value"], cls(**words, sd=sd)

    def to_toml(self) -> dict[str, str]:
        """Return the source's entries for a file; empty ones are omitted."""
        words = {key: getattr(self, field) for key, field in _KEYS.items()}
        if self.sd != _relative_sd(self.spread):
            words["sd"] = repr(self.sd)
        return {key: word for key, word in words.items() if word}


def _relative_sd(spread: str) -> float | None:
    """Return the relative standard deviation in a spread such as "SD 8.18 %", or None."""
    match = re.match(r"SD\s+([\d.]+\s*%)", spread)
    return float(_SD.read(match.group(1), "spread")) if match else None
