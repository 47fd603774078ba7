"""Where a number comes from."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = {
    "paper": "printed in the paper",
    "inferred": "not printed, follows from what is",
    "measured": "measured on this brake or this pair of surfaces",
    "calibrated": "fitted to pulls of this brake",
    "data sheet": "from the maker's data sheet of the material",
    "handbook": "published for such a material, not measured on these surfaces",
    "assumed": "assumed, no source",
    "unstated": "the file does not say",
}


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
