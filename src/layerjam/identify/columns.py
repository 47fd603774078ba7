"""Which column is what: units first, then names in several languages.

A unit outranks a name: a column in s is the time whatever it is called. Among several columns of
one dimension the name decides (standard travel before the absolute crosshead), and the trace says
which was taken; where nothing decides, the user is asked, never guessed for.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from layerjam.errors import FileError, QuantityError, UnknownNameError
from layerjam.units import unit_factor

ROLES = {"time": "s", "elongation": "m", "force": "N"}
_DUE = {"time": "'s' or 'ms'", "elongation": "'mm' or 'in'", "force": "'N', 'kN' or 'lbf'"}

# How machines write units that no unit table knows, in lower case: MM, KN, Sek.
_KILOGRAM = Fraction(980665, 100000)
_ALIASES: dict[str, tuple[str, Fraction]] = {
    "gf": ("force", _KILOGRAM / 1000),
    "kgf": ("force", _KILOGRAM),
    "kp": ("force", _KILOGRAM),
    "kn": ("force", Fraction(1000)),
    "newton": ("force", Fraction(1)),
    "newtons": ("force", Fraction(1)),
    "sek": ("time", Fraction(1)),
    "sek.": ("time", Fraction(1)),
    "sec": ("time", Fraction(1)),
    "sec.": ("time", Fraction(1)),
    "mm": ("elongation", Fraction(1, 1000)),
    "in": ("elongation", Fraction(254, 10000)),
    "lbf": ("force", Fraction(44482216152605, 10**13)),
    "mm.": ("elongation", Fraction(1, 1000)),
    "pouce": ("elongation", Fraction(254, 10000)),
    "zoll": ("elongation", Fraction(254, 10000)),
}

# Names after lower-casing and without accents. German joins words (Standardkraft, Traversenweg),
# so its words may stand at the end of another; the others begin one.
_TRAVEL = r"\b(standard|extension|displacement|elongation|travel|stroke|position|slip|course"
_TRAVEL += "|deplacement|allongement|desplazamiento|alargamiento|carrera|spostamento|corsa"
_TRAVEL += r"|allungamento|deslocamento|kolben)|weg\b|verschiebung|verlangerung"
_CROSSHEAD = r"\b(crosshead|travers)"
_SENSOR = r"\b(extensomet|capteur|strain|deformation|laser|video|local|ave\d*\b|lvdt|tool|true"
_SENSOR += r"|correct|korrig|corrig|nominal)|aufnehmer|dehnung|feindehn"
_NOT_TRAVEL = r"\b(width|thickness|diameter|gau?ge length|breite|dicke|largeur|epaisseur|anchura"
_NOT_TRAVEL += r"|espesor|initial|rms|amplitude|error|fehler|command|demand|soll)"
_FORCE = r"\b(force|load|last\b|charge|effort|fuerza|carga|forza|carico|forca)|kraft\b|kracht\b"
_OTHER_FORCE = r"\d|\b(peak|max|min|mean|filter|raw|true|error|command|demand|soll|aux|normal)"
_TIME = r"\b(time|temps|tiempo|tempo|duree|elapsed)\b|zeit\b|tijd\b"
_ELSE = r"\b(torque|moment|rotation|angle|winkel|couple|stress|contrainte)|spannung"


@dataclass(frozen=True)
class Choices:
    """What the user says where a file cannot: answers to the questions in the error messages.

    `negative`: of "force" and "elongation", those the machine counts the other way round;
    `columns`: {"force" | "elongation" | "time": column name}; `decimal`: "." or ",".
    """

    negative: Sequence[str] = ()
    columns: Mapping[str, str] | None = None
    decimal: str | None = None

    def __post_init__(self) -> None:
        for name in (*self.negative, *(self.columns or {})):
            if name not in ROLES:
                raise UnknownNameError("column's role", str(name), ROLES)
        if self.decimal not in (None, ".", ","):
            raise QuantityError(f"decimal: '{self.decimal}' is not allowed; it is '.' or ','")


@dataclass(frozen=True)
class Column:
    """One column taken: its place, its name and unit as written, and the factor to SI."""

    role: str
    index: int
    name: str
    unit: str
    factor: Fraction


@lru_cache(maxsize=4096)
def unit_role(unit: str) -> tuple[str, Fraction] | None:
    """("time" | "elongation" | "force", factor to SI) of a unit's text; None for all others."""
    text = unit.strip()
    if not 0 < len(text) <= 20 or "/" in text or any(c.isdigit() for c in text):
        return None  # mm/min, mm2: no unit of ours, and not worth asking for
    for role, si in ROLES.items():
        factor = unit_factor(text, si)
        if factor is not None:
            return role, factor
    return _ALIASES.get(text.lower())


def take(role: str, index: int, name: str, unit: str | None, path: str, line: int) -> Column:
    """The column for a role, where its place is known; FileError where its unit is not one."""
    known = unit_role(unit) if unit else None
    if known is None or known[0] != role:
        raise FileError(path, _wrong_unit(role, name, unit), line)
    return Column(role, index, name, unit or "", known[1])


def _wrong_unit(role: str, name: str, unit: str | None) -> str:
    if not unit:
        return f"column '{_cut(name)}' has no unit; {role} needs one such as {_DUE[role]}"
    return (
        f"column '{_cut(name)}' is in '{_cut(unit)}', which is no unit of {role}; "
        f"it needs one such as {_DUE[role]}"
    )


def split_unit(text: str) -> tuple[str, str | None]:
    """("Force", "kN") from "Force (kN)", "Force [kN]" or "Kraft / kN"; the unit None if unsaid."""
    text = text.strip()
    match = re.fullmatch(r"(.*?)\s*[(\[]([^()\[\]]*)[)\]]", text, re.DOTALL)
    if match:
        return match.group(1).strip(), match.group(2).strip()
    name, slash, unit = text.rpartition("/")
    if not slash:
        name, slash, unit = text.rpartition(" in ")
    if slash and unit_role(unit):
        return name.strip(), unit.strip()
    return text, None


def plain(name: str) -> str:
    """A name in lower case, without accents and doubled blanks."""
    letters = unicodedata.normalize("NFKD", name.lower().replace("ß", "ss"))
    return " ".join("".join(c for c in letters if not unicodedata.combining(c)).split())


def named_role(name: str) -> str | None:
    """What a column's name alone says it is."""
    text = plain(name)
    if re.search(_ELSE, text):
        return None
    if re.search(_TIME, text):
        return "time"
    if re.search(_FORCE, text):
        return "force"
    if re.search(f"{_TRAVEL}|{_CROSSHEAD}", text) and not re.search(_SENSOR, text):
        return "elongation"
    return None


def _rank(role: str, name: str) -> int | None:
    """How well a name suits a role, 0 best; None if it says that it is something else."""
    text = plain(name)
    if role == "time":
        if re.fullmatch(r"(time|zeit|temps|tiempo|tempo|prufzeit|testzeit|temps d'essai)", text):
            return 0
        return 1 if re.search(_TIME, text) else 2
    if role == "force":
        if re.search(_TIME, text) or named_role(name) == "elongation":
            return None
        if not re.search(_FORCE, text):
            return 3
        return 1 if re.search(_OTHER_FORCE, text) else 0
    if re.search(_NOT_TRAVEL, text) or named_role(name) in ("force", "time"):
        return None
    if re.search("absol", text):
        return 3
    if re.search(_SENSOR, text):
        return 4
    if re.search(_CROSSHEAD, text):
        return 1 if re.search(_TRAVEL, text) else 2
    return 0 if re.search(_TRAVEL, text) else 5


def assign(
    names: Sequence[str], units: Sequence[str | None], path: str, line: int, choices: Choices
) -> tuple[dict[str, Column], list[str]]:
    """The columns for force, elongation and (if there) time, and sentences saying so.

    Raises FileError where force or elongation is missing, has no unit or one of another
    dimension, or where several columns could be meant.
    """
    found: dict[str, list[tuple[int, Column]]] = {role: [] for role in ROLES}
    for index, (name, unit) in enumerate(zip(names, units, strict=True)):
        known = unit_role(unit) if unit else None
        if known:
            role, factor = known
            rank = _rank(role, name)
            if rank is not None:
                found[role].append((rank, Column(role, index, name, unit or "", factor)))
    taken: dict[str, Column] = {}
    sentences = []
    for role in ROLES:
        wanted = (choices.columns or {}).get(role)
        candidates = found[role]
        if wanted is not None:
            candidates = [(0, c) for _, c in candidates if plain(c.name) == plain(wanted)]
            if not candidates:
                raise FileError(path, f"has no column '{_cut(wanted)}' with a unit of {role}", line)
        if not candidates:
            if role != "time":
                raise FileError(path, _missing(role, names, units), line)
            continue
        best = min(rank for rank, _ in candidates)
        first = [c for rank, c in candidates if rank == best]
        if len(first) > 1 and role != "time":
            which = " or ".join(f"'{_cut(c.name)}'" for c in first[:4])
            if len({plain(c.name) for c in first}) == 1:
                raise FileError(
                    path,
                    f"has {len(first)} columns {which.split(' or ')[0]}: it seems to hold several "
                    "specimens; export them one by one",
                    line,
                )
            raise FileError(
                path,
                f"does not say which column is the {role}: {which}; name one "
                f"(--column {role}=NAME)",
                line,
            )
        taken[role] = first[0]
        others = [c for _, c in candidates if c is not first[0]]
        sentences.append(sentence(first[0], others))
    return taken, sentences


def sentence(column: Column, others: list[Column]) -> str:
    """What was understood of a column, and which others it was preferred to."""
    text = f"{column.role} is the column '{_cut(column.name)}' in {column.unit}"
    if named_role(column.name) != column.role:
        text += " (by its unit)"
    if others:
        text += ", not " + " or ".join(f"'{_cut(c.name)}'" for c in others[:4])
    return text


def _missing(role: str, names: Sequence[str], units: Sequence[str | None]) -> str:
    for name, unit in zip(names, units, strict=True):
        if named_role(name) == role:
            return _wrong_unit(role, name, unit)
    return f"has no column with a unit of {role} ({_DUE[role]}); {listed(names, units)}"


def listed(names: Sequence[str], units: Sequence[str | None]) -> str:
    """The columns there are, as the end of an error's sentence."""
    pairs = list(zip(names, units, strict=True))
    there = [f"'{_cut(n)}' [{_cut(u)}]" if u else f"'{_cut(n)}'" for n, u in pairs[:8]]
    return f"its columns are {', '.join(there)}" + (" and more" if len(pairs) > 8 else "")


def _cut(text: str) -> str:
    text = " ".join(text.split())
    return text if len(text) <= 40 else text[:37] + "..."
