"""Names of columns: the unit in a name, and the quantity that a name implies."""

import re
import unicodedata

from layerjam.laboratory.measure.readers import words
from layerjam.laboratory.measure.readers.unit_words import (
    common_unit,
    force_unit_for,
    unit_role,
)
from layerjam.laboratory.measure.readers.words import normalise_name


def separate_words(name: str) -> str:
    """Return a name in lower case with its words separated by blanks, such as "p abs"."""
    return normalise_name(name).replace("_", " ")


def shorten(text: str) -> str:
    """Return a text for a message: printable, on one line, at most forty characters."""
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= 40 else text[:37] + "..."


_BRACKETS = re.compile(r"[(\[<{【]\s*([^()\[\]<>{}【】]*?)\s*[)\]>}】]")
_LAST_WORD = re.compile(r"(.*?)(?:\s*[,:;_|\-]\s*|\s+)([^\s,:;_|\-]{1,12})", re.DOTALL)
_CAMEL = re.compile(r"(.*[a-z])(kN|mN|N|MM|mm|MS|ms|Mm|Ms)")


def split_unit(text: str) -> tuple[str, str | None]:
    """Split names such as "Force (kN)", "Kraft / kN" or "Load, N" into (name, unit or None)."""
    text = unicodedata.normalize("NFKC", text).strip()
    match = re.fullmatch(rf"(.*?)\s*{_BRACKETS.pattern}", text, re.DOTALL)
    if match and unit_role(match[2]):
        return match[1].strip(), match[2]
    for inner in _BRACKETS.finditer(text):  # for example: Load (N) Specimen 2, Time (s).1
        if unit_role(inner[1]):
            name_left = f"{text[: inner.start()].strip()} {text[inner.end() :].strip()}"
            return name_left.strip(), inner[1]
    if match:
        return match[1].strip(), match[2]
    for mark in ("/", " in "):
        name, slash, unit = text.rpartition(mark)
        if slash and (unit_role(unit) or (force_unit_for(unit) and find_role(name) == "force")):
            return name.strip(), unit.strip()
    return _split_bare_unit(text)


def _split_bare_unit(text: str) -> tuple[str, str | None]:
    """Split off a unit without a bracket or slash if it suits the name."""
    if len(text) > 80:
        return text, None
    match = _LAST_WORD.fullmatch(text)
    if match and (found_role := common_unit(match[2])):
        name_role = find_role(match[1])
        strong = re.search(r"[,:;_|]\s*$", text[: match.start(2)]) is not None
        if name_role == found_role[0] or (name_role is None and strong and match[1].strip()):
            return match[1].strip(), match[2]
    if match and force_unit_for(match[2]) and find_role(match[1]) == "force":
        return match[1].strip(), match[2]  # Load, g: the unit is reported as a mass
    match = _CAMEL.fullmatch(text)
    if match and (found_role := common_unit(match[2])) and find_role(match[1]) == found_role[0]:
        return match[1].strip(), match[2]
    return text, None


def _strip_origin(text: str) -> str:
    """Return a name without its reference: "extension from preload" is not a load."""
    return re.sub(r"\b(from|after|since|at|ab|bei) (pre-?load|vorkraft)\b", "", text)


def find_role(name: str) -> str | None:
    """Return the role that a column's name alone implies."""
    text = _strip_origin(normalise_name(name))
    if re.search(words.OTHER_QUANTITY, text):
        return None
    if re.search(words.TIME, text):
        return "time"
    if re.search(words.FORCE, text):
        return "force"
    if re.search(words.ROLE["elongation"], text) and not re.search(words.SENSOR, text):
        return "elongation"
    return None


def rank_name(role: str, name: str) -> int | None:
    """Return the rank of a name for a role, 0 for the best; None if it has a different meaning."""
    text = _strip_origin(normalise_name(name))
    if role == "time":
        if re.fullmatch(r"(time|zeit|temps|tiempo|tempo|prufzeit|testzeit|temps d'essai)", text):
            return 0
        return 1 if re.search(words.TIME, text) else 2
    if role == "force":
        if re.search(words.TIME, text) or find_role(name) == "elongation":
            return None
        if not re.search(words.FORCE, text):
            return 3
        return 1 if re.search(words.OTHER_FORCE, text) else 0
    if re.search(words.NOT_TRAVEL, text) or find_role(name) in ("force", "time"):
        return None
    if re.search("absol", text):
        return 3
    if re.search(words.SENSOR, text):
        return 4
    if re.search(words.CROSSHEAD, text):
        return 1 if re.search(words.TRAVEL, text) else 2
    return 0 if re.search(words.TRAVEL, text) else 5
