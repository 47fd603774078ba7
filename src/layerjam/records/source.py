"""Where a number comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Self

from layerjam.errors import QuantityError, UnknownNameError

KINDS: Mapping[str, str] = MappingProxyType(
    {
        "paper": "printed in the paper",
        "inferred": "not printed, follows from what is",
        "measured": "measured on this brake or this pair of surfaces",
        "calibrated": "fitted to pulls of this brake",
        "data sheet": "from the maker's data sheet of the material",
        "handbook": "published for such a material, not measured on these surfaces",
        "assumed": "assumed, no source",
        "unstated": "the file does not say",
    }
)
_KEYS = {"kind": "kind", "source": "text", "spread": "spread", "conflict": "conflict"}
"""Key of a file: field of Source."""


@dataclass(frozen=True, kw_only=True)
class Source:
    """Provenance of one number.

    `kind` is one of KINDS; `text` names the source; `spread` says what scatter is known (as the
    source prints it); `conflict` records a source that disagrees.
    """

    kind: str = "unstated"
    text: str = ""
    spread: str = ""
    conflict: str = ""

    def sentence(self) -> str:
        """All of it on one line."""
        parts = [f"{self.kind}: {self.text}" if self.text else self.kind]
        if self.spread:
            parts.append(f"spread {self.spread}")
        if self.conflict:
            parts.append(f"conflict: {self.conflict}")
        return "; ".join(parts)

    @classmethod
    def read(cls, table: Mapping[str, Any], name: str) -> tuple[Any, Self]:
        """(value, its source) from a table such as { value = "13 mm", source = "caliper" }."""
        odd = ", ".join(sorted(set(table) - {"value", *_KEYS}))[:60]
        if odd or "value" not in table:
            what = f"does not know {odd}" if odd else "has no value"
            known = ", ".join(sorted({"value", *_KEYS}))
            raise QuantityError(f"{name} {what}; a table holds {known}", quantity=name)
        words = {field: table[key] for key, field in _KEYS.items() if key in table}
        for field, word in words.items():
            if not isinstance(word, str):
                raise QuantityError(f"{name}.{field} must be a text in quotes", quantity=name)
        if words.get("kind", "unstated") not in KINDS:
            raise UnknownNameError("kind", words["kind"], KINDS, quantity=name)
        return table["value"], cls(**words)

    def written(self) -> dict[str, str]:
        """What a file holds of it beside the value; what is empty is left out."""
        words = {key: getattr(self, field) for key, field in _KEYS.items()}
        return {key: word for key, word in words.items() if word}
