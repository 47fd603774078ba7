"""Words that machines use for time, travel and force in many languages, from vocabulary.toml.

Words are compared in lower case, without accents, and with full-width letters converted to half
width. Latin and Cyrillic entries match the start of a word (`displacement`). German has compound
words, so its entries may match the end (`Standardkraft`). Chinese, Japanese and Korean are written
without spaces, so their entries may match anywhere.
"""

import re
import tomllib
import unicodedata
from collections.abc import Mapping
from functools import lru_cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

_LETTERS = str.maketrans({"ß": "ss", "ł": "l", "ø": "o", "đ": "d", "ı": "i", "æ": "ae", "œ": "oe"})
_TEXT = (files("layerjam.laboratory.measure.readers") / "vocabulary.toml").read_text(
    encoding="utf-8"
)
VOCABULARY: Mapping[str, Any] = MappingProxyType(tomllib.loads(_TEXT))
"""The tables "names" and "units" of the file."""


@lru_cache(maxsize=8192)
def normalise_name(name: str) -> str:
    """Return a name in lower case, without accents and with single blanks."""
    lower = unicodedata.normalize("NFKC", name).lower().translate(_LETTERS)
    letters = unicodedata.normalize("NFKD", lower)
    return " ".join("".join(c for c in letters if not unicodedata.combining(c)).split())


def _make_pattern(name: str) -> str:
    """Return one regular expression for entries that match the start, end or any part of a word."""
    entry = VOCABULARY["names"][name]
    begin, end, anywhere = (
        normalise_name(entry.get(k, "")).split() for k in ("begin", "end", "anywhere")
    )
    parts = [rf"(?<![^\W_])(?:{'|'.join(map(re.escape, begin))})"] if begin else []
    parts += [rf"{re.escape(word)}(?![^\W_])" for word in end]
    parts += [re.escape(word) for word in anywhere]
    return "|".join([*parts, *([entry["pattern"]] if "pattern" in entry else [])])


TIME = _make_pattern("time")
TRAVEL = _make_pattern("travel")
CROSSHEAD = _make_pattern("crosshead")
SENSOR = _make_pattern("sensor")
NOT_TRAVEL = _make_pattern("not_travel")
FORCE = _make_pattern("force")
OTHER_FORCE = r"\d|\b(peak|max|min|mean|filter|raw|true|error|command|demand|soll|aux|normal)"
OTHER_QUANTITY = _make_pattern("else")
SPECIMEN = _make_pattern("specimen")
STATISTIC = _make_pattern("statistic")
RESULTS = _make_pattern("results")
UNIT = _make_pattern("unit")
ROLE = {"time": TIME, "elongation": f"{TRAVEL}|{CROSSHEAD}", "force": FORCE}
_ANY = re.compile("|".join([*ROLE.values(), SENSOR, SPECIMEN, UNIT, OTHER_QUANTITY]))


def count_known_letters(text: str) -> int:
    """Return the number of characters in known words, which identifies the code page."""
    matches = [m[0] for m in _ANY.finditer(normalise_name(text))]
    return sum(len(word) * (1 if word.isascii() else 4) for word in matches)
