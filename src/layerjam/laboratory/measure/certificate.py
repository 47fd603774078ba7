"""Calibration certificates of the instruments of a test (ISO/IEC 17025, section 7.8.4)."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from datetime import date as day
from typing import Any

from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.values import AsItIs


@dataclass(frozen=True, kw_only=True)
class Certificate:
    """One certificate: number, calibration date, laboratory and date of the next calibration.

    Dates are in ISO 8601 format; `due` is empty if it is not stated.
    """

    number: str
    date: str
    laboratory: str
    due: str = ""


KEYS = tuple(f.name for f in fields(Certificate))


@dataclass(frozen=True, kw_only=True)
class CertificateSpec(AsItIs):
    """The table of one certificate in a sidecar."""

    text: str = ""

    def limits(self) -> str:
        """Return the keys of the table."""
        return (
            'a table with number, date, laboratory and, if known, due, such as { number = "K-17", '
            'date = "2026-03-01", due = "2027-03-01", laboratory = "DKD 123" }'
        )

    def read(self, text: object, name: str) -> Certificate:
        """Return the certificate; raises QuantityError if a key or a date is invalid."""
        if not isinstance(text, Mapping):
            raise QuantityError.of(name, f"must be {self.limits()}")
        unknown = ", ".join(sorted(set(text) - set(KEYS)))[:60]
        if unknown:
            raise QuantityError.of(name, f"has unknown keys: {unknown}; it must be {self.limits()}")
        texts = {key: _require_text(text.get(key, ""), f"{name}.{key}", key) for key in KEYS}
        empty = [key for key in KEYS if key != "due" and not texts[key]]
        if empty:
            raise QuantityError.of(name, f"lacks {', '.join(empty)}; it must be {self.limits()}")
        if texts["due"] and texts["due"] < texts["date"]:
            raise QuantityError.of(
                f"{name}.due", f"{texts['due']} is before the calibration date, {texts['date']}"
            )
        return Certificate(**texts)

    def to_toml(self, value: Any) -> dict[str, str]:
        """Return the table of a certificate, without empty entries."""
        return {key: text for key, text in asdict(value).items() if text}


def _require_text(value: object, name: str, key: str) -> str:
    """Return the text of one entry; a date is in ISO 8601 format."""
    if key in ("date", "due") and value != "":
        try:
            return day.fromisoformat(str(value)).isoformat()
        except ValueError:
            raise QuantityError.of(
                name, f"'{str(value)[:40]}' is not a date such as 2026-03-01"
            ) from None
    if not isinstance(value, str):
        raise QuantityError.of(name, "must be text in quotes")
    return value.strip()
