"""Authors of a dataset, and the licence under which others may use it."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from typing import Any, Self

from layerjam.core.errors import Notice, QuantityError

USUAL = (
    "CC-BY-4.0",
    "CC0-1.0",
    "CC-BY-SA-4.0",
    "CC-BY-NC-4.0",
    "ODbL-1.0",
    "ODC-By-1.0",
    "PDDL-1.0",
    "Apache-2.0",
    "BSD-3-Clause",
    "MIT",
)
"""SPDX identifiers of common licences for data."""
SPDX = "https://spdx.org/licenses/"
ORCID = "https://orcid.org/"
LONGEST = 200


@dataclass(frozen=True)
class Author:
    """A person's name and, if known, ORCID iD (16 digits in groups of four)."""

    name: str
    orcid: str = ""

    @property
    def id(self) -> str:
        """Address of the ORCID iD or, if there is none, an identifier within the dataset."""
        if self.orcid:
            return ORCID + self.orcid
        return "#" + (re.sub(r"[^\w-]+", "-", self.name).strip("-") or "author")


@dataclass(frozen=True, kw_only=True)
class Details:
    """Details of a dataset stated by the user: name, SPDX licence, authors and date (ISO 8601)."""

    name: str
    licence: str | None
    authors: Sequence[Author]
    date: str

    @classmethod
    def read(cls, row: Mapping[str, Any]) -> Self:
        """Return the details from a table; raises KeyError, TypeError or ValueError if invalid."""
        authors = [Author(**a) for a in row["authors"]]
        texts = [row["name"], row["date"], *(t for a in authors for t in vars(a).values())]
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("expected text")
        date.fromisoformat(row["date"])
        licence_notices(row["licence"], authors)
        return cls(name=row["name"], licence=row["licence"], authors=authors, date=row["date"])

    def notices(self) -> list[Notice]:
        """Return notices of a missing licence or authors; QuantityError for an invalid licence."""
        return licence_notices(self.licence, self.authors)


def parse_author(text: str) -> Author:
    """Return the author from "NAME" or "NAME,ORCID".

    Raises QuantityError for an empty name or an ORCID iD with a wrong check digit.
    """
    name, comma, orcid = (part.strip() for part in text.rpartition(","))
    if not comma or not re.search(r"\d", orcid):
        name, orcid = text.strip(), ""
    if not name or len(name) > LONGEST or not name.isprintable():
        raise QuantityError.of("author", f"'{text[:60]}' has no name; write NAME or NAME,ORCID")
    number = orcid.upper().removeprefix(ORCID.upper())
    if number and not _is_orcid(number):
        raise QuantityError.of(
            "author",
            f"'{orcid[:60]}' is not an ORCID iD (16 characters, the last a check digit); "
            "write it as in 0000-0002-1825-0097",
        )
    return Author(name, number)


def _is_orcid(number: str) -> bool:
    """Return whether the last of the 16 digits is the check digit (ISO/IEC 7064, MOD 11-2)."""
    if not re.fullmatch(r"\d{4}-\d{4}-\d{4}-\d{3}[\dX]", number):
        return False
    total, digits = 0, number.replace("-", "")
    for digit in digits[:-1]:
        total = (total + int(digit)) * 2
    check = (12 - total % 11) % 11
    return digits[-1] == ("X" if check == 10 else str(check))


def licence_notices(licence: str | None, authors: Sequence[Author]) -> list[Notice]:
    """Return notices of a missing licence or missing authors.

    Raises QuantityError for a licence that is not an SPDX identifier.
    """
    notices = []
    if licence is None:
        text = "no licence is stated: others have no right to use the data; add --licence CC-BY-4.0"
        notices.append(Notice(text, "no-licence"))
    elif not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]{1,60}", licence):
        examples = ", ".join(USUAL[:4])
        raise QuantityError.of(
            "licence", f"'{licence[:60]}' is not an SPDX identifier; write one such as {examples}"
        )
    elif licence not in USUAL:
        text = (
            f"the licence {licence} is unknown to layerjam; check that {SPDX}{licence}.html exists"
        )
        notices.append(Notice(text, "unknown-licence"))
    if not authors:
        text = "no author is stated; name each: --author 'NAME,ORCID'"
        notices.append(Notice(text, "no-author"))
    return notices
