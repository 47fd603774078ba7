"""Which column is what: units first, then names in several languages.

A unit outranks a name: a column in s is the time whatever it is called. Among several columns of
one dimension the name decides (standard travel before the absolute crosshead), and the trace says
which was taken; where nothing decides, the user is asked, never guessed for.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from layerjam.errors import FileError, QuantityError, UnknownNameError
from layerjam.measure.readers import words
from layerjam.measure.readers.unit_words import MASS, ROLES, common_unit, unit_role
from layerjam.measure.readers.words import plain

__all__ = ["ROLES", "Choices", "Column", "assign", "listed", "plain", "split_unit", "unit_role"]

_DUE = {"time": "'s' or 'ms'", "elongation": "'mm' or 'in'", "force": "'N', 'kN' or 'lbf'"}
SKIP = "skip"


@dataclass(frozen=True)
class Choices:
    """What the user says where a file cannot: answers to the questions in the error messages.

    `negative`: of "force" and "elongation", those the machine counts the other way round;
    `columns`: {"force" | "elongation" | "time": column name}; `units`: {role: unit} where the file
    states none; `places`: for each column of the file in order "time:ms" or "skip"; `decimal`:
    "." or ","; `specimen`: which of several in a file, from 1; `sheet`: of a workbook, by name.
    """

    negative: Sequence[str] = ()
    columns: Mapping[str, str] | None = None
    decimal: str | None = None
    units: Mapping[str, str] | None = None
    places: Sequence[str] = ()
    specimen: int | None = None
    sheet: str | None = None

    def __post_init__(self) -> None:
        for name in (*self.negative, *(self.columns or {}), *(self.units or {})):
            if name not in ROLES:
                raise UnknownNameError("column's role", str(name), ROLES)
        if self.decimal not in (None, ".", ","):
            raise QuantityError(f"decimal: '{self.decimal}' is not allowed; it is '.' or ','")
        for role, unit in (self.units or {}).items():
            _check_unit(role, unit)
        if self.specimen is not None and self.specimen < 1:
            raise QuantityError(f"specimen: {self.specimen} is not allowed; the first is 1")
        if self.places:
            self._check_places()

    def _check_places(self) -> None:
        roles = []
        for entry in self.places:
            if entry == SKIP:
                continue
            role, _, unit = entry.partition(":")
            if role not in ROLES:
                raise QuantityError(
                    f"columns: '{entry[:40]}' is not of the form ROLE:UNIT or skip; roles are "
                    f"{', '.join(ROLES)}"
                )
            _check_unit(role, unit)
            roles.append(role)
        for role in ROLES:
            if roles.count(role) > 1:
                raise QuantityError(f"columns: {role} is given twice")
            if role != "time" and role not in roles:
                raise QuantityError(
                    f"columns: {role} is missing; write one entry for each column, such as "
                    "time:ms,force:N,elongation:mm,skip"
                )


def _check_unit(role: str, unit: str) -> None:
    known = unit_role(unit)
    if known is None or known[0] != role:
        what = f"'{unit[:20]}' is no unit of {role}" if unit else f"{role} has no unit"
        raise QuantityError(f"columns: {what}; give one such as {_DUE[role]}")


@dataclass(frozen=True)
class Column:
    """One column taken: its place, its name and unit as written, and the factor to SI."""

    role: str
    index: int
    name: str
    unit: str
    factor: Fraction
    given: bool = False
    """Whether the user said the unit."""


def take(role: str, index: int, name: str, unit: str | None, path: str, line: int) -> Column:
    """The column for a role, where its place is known; FileError where its unit is not one."""
    known = unit_role(unit) if unit else None
    if known is None or known[0] != role:
        raise FileError(path, _wrong_unit(role, name, unit), line)
    return Column(role, index, name, unit or "", known[1])


def _wrong_unit(role: str, name: str, unit: str | None) -> str:
    example = {"time": "s", "elongation": "mm", "force": "N"}[role]
    say = f"--column {role}:{example}='{_cut(name)}'"
    if not unit:
        return (
            f"column '{_cut(name)}' has no unit; {role} needs one such as {_DUE[role]} "
            f"(say which: {say})"
        )
    mass = unit.strip(" .").lower() in MASS and role == "force"
    kind = ", a unit of mass" if mass else ""
    if mass:
        say = say.replace(":N=", ":lbf=" if unit.lower().startswith("lb") else ":kgf=")
    return (
        f"column '{_cut(name)}' is in '{_cut(unit)}', which is no unit of {role}{kind}; "
        f"it needs one such as {_DUE[role]} (say which: {say})"
    )


_BRACKETS = re.compile(r"[(\[<{【]\s*([^()\[\]<>{}【】]*?)\s*[)\]>}】]")
_LAST_WORD = re.compile(r"(.*?)(?:\s*[,:;_|\-]\s*|\s+)([^\s,:;_|\-]{1,12})", re.DOTALL)
_CAMEL = re.compile(r"(.*[a-z])(kN|mN|N|MM|mm|MS|ms|Mm|Ms)")


def split_unit(text: str) -> tuple[str, str | None]:
    """("Force", "kN") from "Force (kN)", "Force [kN]", "Kraft / kN", "Load, N"; None if unsaid."""
    text = unicodedata.normalize("NFKC", text).strip()
    match = re.fullmatch(rf"(.*?)\s*{_BRACKETS.pattern}", text, re.DOTALL)
    if match and unit_role(match[2]):
        return match[1].strip(), match[2]
    for inner in _BRACKETS.finditer(text):  # Load (N) Specimen 2, Time (s).1
        if unit_role(inner[1]):
            rest = f"{text[: inner.start()].strip()} {text[inner.end() :].strip()}"
            return rest.strip(), inner[1]
    if match:
        return match[1].strip(), match[2]
    for mark in ("/", " in "):
        name, slash, unit = text.rpartition(mark)
        if slash and unit_role(unit):
            return name.strip(), unit.strip()
    return _weakly_split(text)


def _weakly_split(text: str) -> tuple[str, str | None]:
    """A unit at the end without a bracket or slash counts where the name does not gainsay it."""
    if len(text) > 80:
        return text, None
    match = _LAST_WORD.fullmatch(text)
    if match and (known := common_unit(match[2])):
        named = named_role(match[1])
        strong = re.search(r"[,:;_|]\s*$", text[: match.start(2)]) is not None
        if named == known[0] or (named is None and strong and match[1].strip()):
            return match[1].strip(), match[2]
    match = _CAMEL.fullmatch(text)
    if match and (known := common_unit(match[2])) and named_role(match[1]) == known[0]:
        return match[1].strip(), match[2]
    return text, None


def named_role(name: str) -> str | None:
    """What a column's name alone says it is."""
    text = plain(name)
    if re.search(words.ELSE, text):
        return None
    if re.search(words.TIME, text):
        return "time"
    if re.search(words.FORCE, text):
        return "force"
    if re.search(words.ROLE["elongation"], text) and not re.search(words.SENSOR, text):
        return "elongation"
    return None


def _rank(role: str, name: str) -> int | None:
    """How well a name suits a role, 0 best; None if it says that it is something else."""
    text = plain(name)
    if role == "time":
        if re.fullmatch(r"(time|zeit|temps|tiempo|tempo|prufzeit|testzeit|temps d'essai)", text):
            return 0
        return 1 if re.search(words.TIME, text) else 2
    if role == "force":
        if re.search(words.TIME, text) or named_role(name) == "elongation":
            return None
        if not re.search(words.FORCE, text):
            return 3
        return 1 if re.search(words.OTHER_FORCE, text) else 0
    if re.search(words.NOT_TRAVEL, text) or named_role(name) in ("force", "time"):
        return None
    if re.search("absol", text):
        return 3
    if re.search(words.SENSOR, text):
        return 4
    if re.search(words.CROSSHEAD, text):
        return 1 if re.search(words.TRAVEL, text) else 2
    return 0 if re.search(words.TRAVEL, text) else 5


def by_place(
    choices: Choices, count: int, path: str, line: int
) -> tuple[dict[str, Column], list[str]]:
    """The columns as the user lists them; FileError where the file has another number."""
    if count != len(choices.places):
        raise FileError(
            path,
            f"has {count} columns, --columns lists {len(choices.places)}; write one entry for "
            f"each, '{SKIP}' for those not used",
            line,
        )
    taken = {}
    for index, entry in enumerate(choices.places):
        role, _, unit = entry.partition(":")
        known = unit_role(unit) if role != SKIP else None
        if known:
            taken[role] = Column(role, index, f"column {index + 1}", unit, known[1], True)
    return taken, [sentence(taken[role], []) for role in ROLES if role in taken]


def assign(
    names: Sequence[str],
    units: Sequence[str | None],
    path: str,
    line: int,
    choices: Choices,
    same: Callable[[Sequence[Column]], bool] | None = None,
) -> tuple[dict[str, Column], list[str]]:
    """The columns for force, elongation and (if there) time, and sentences saying so.

    `same` tells whether several columns hold the same measurement; then the first is taken.
    Raises FileError where force or elongation is missing, has no unit or one of another dimension,
    or where several columns could be meant.
    """
    taken: dict[str, Column] = {}
    sentences = []
    for role in ROLES:
        candidates = _candidates(role, names, units, choices)
        wanted = (choices.columns or {}).get(role)
        if wanted is not None:
            candidates = [(0, c) for _, c in candidates if plain(c.name) == plain(wanted)]
            if not candidates:
                raise FileError(path, _not_there(role, wanted, names, units), line)
        if not candidates:
            if role != "time" or role in (choices.units or {}):
                raise FileError(path, _missing(role, names, units), line)
            sentences += _no_time(names, units)
            continue
        best = min(rank for rank, _ in candidates)
        first = [c for rank, c in candidates if rank == best]
        if len(first) > 1 and role != "time" and not (same and same(first)):
            which = " or ".join(f"'{_cut(c.name)}'" for c in first[:4])
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


def _candidates(
    role: str, names: Sequence[str], units: Sequence[str | None], choices: Choices
) -> list[tuple[int, Column]]:
    """Columns of a role's dimension with the rank of their names; the user's unit if none is."""
    found = []
    wanted = (choices.columns or {}).get(role)
    given = (choices.units or {}).get(role)
    for index, (name, written) in enumerate(zip(names, units, strict=True)):
        unit, known, said = written, unit_role(written) if written else None, False
        meant = plain(name) == plain(wanted) if wanted else named_role(name) == role
        if given and meant and (known is None or wanted):
            known, unit, said = unit_role(given), given, True
        if known and known[0] == role:
            rank = _rank(role, name)
            if rank is not None or (wanted and meant):
                found.append((rank or 0, Column(role, index, name, unit or "", known[1], said)))
    return found


def complete(names: Sequence[str], units: Sequence[str | None], choices: Choices) -> bool:
    """Whether there are columns for both force and elongation."""
    return all(_candidates(r, names, units, choices) for r in ("force", "elongation"))


def _not_there(role: str, wanted: str, names: Sequence[str], units: Sequence[str | None]) -> str:
    for name, unit in zip(names, units, strict=True):
        if plain(name) == plain(wanted) and not unit:
            return _wrong_unit(role, name, unit)
    return f"has no column '{_cut(wanted)}' with a unit of {role}"


def _no_time(names: Sequence[str], units: Sequence[str | None]) -> list[str]:
    """That a column is called time but not read, for it has no unit of time."""
    for name, unit in zip(names, units, strict=True):
        if named_role(name) == "time":
            say = f"has no unit (--column time:s='{_cut(name)}')"
            why = f"is in '{_cut(unit)}', which is no unit of time" if unit else say
            return [f"the time is not read: column '{_cut(name)}' {why}"]
    return []


def sentence(column: Column, others: list[Column]) -> str:
    """What was understood of a column, and which others it was preferred to."""
    text = f"{column.role} is the column '{_cut(column.name)}' in {column.unit}"
    if column.given:
        text += ", as given"
    elif named_role(column.name) != column.role:
        text += " (by its unit)"
    if others:
        named = [
            f"'{_cut(c.name)}'" + (f" in {c.unit}" if c.name == column.name else "")
            for c in others[:4]
        ]
        text += ", not " + " or ".join(named)
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
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= 40 else text[:37] + "..."
