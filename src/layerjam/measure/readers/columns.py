"""Which column is what: units first, then names in several languages.

A unit outranks a name: a column in s is the time whatever it is called. Among several columns of
one dimension the name decides (standard travel before the absolute crosshead), and the trace says
which was taken; where nothing decides, the user is asked, never guessed for.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from layerjam.errors import FileError
from layerjam.measure.options import SKIP, ColumnEntry
from layerjam.measure.readers import words
from layerjam.measure.readers.unit_words import (
    common_unit,
    convert,
    gainsays,
    unit_role,
    weight_unit,
)
from layerjam.measure.readers.words import plain
from layerjam.measure.trace import Array


@dataclass(frozen=True)
class Want:
    """A quantity that is looked for: its SI unit, units it may come in, names of its column.

    `words` is a pattern for names in lower case without accents, `avoid` one for names that mean
    something else. `optional`: it may be missing. A pure number (SI unit "1") needs no unit.
    """

    role: str
    si: str
    words: str
    units: tuple[str, ...]
    optional: bool = False
    avoid: str = ""

    @property
    def due(self) -> str:
        """Units that would do, in words."""
        quoted = [f"'{unit}'" for unit in self.units]
        return " or ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)

    def named(self, name: str) -> bool:
        """Whether a name says that its column is this one."""
        return re.search(self.words, spoken(name)) is not None

    def rank(self, name: str) -> int | None:
        """How well a name suits, 0 best; None if it says that its column is something else."""
        if self.avoid and re.search(self.avoid, spoken(name)):
            return None
        return int(not self.named(name))


def spoken(name: str) -> str:
    """A name in lower case, its words apart: p_abs."""
    return plain(name).replace("_", " ")


@dataclass(frozen=True)
class MachineWant(Want):
    """A column of a test machine, whose names are known in many languages."""

    def named(self, name: str) -> bool:
        """Whether the name alone says so."""
        return named_role(name) == self.role

    def rank(self, name: str) -> int | None:
        """How well the name suits, 0 best; None if it says that it is something else."""
        return _rank(self.role, name)


PULL = (
    MachineWant("time", "s", words.TIME, ("s", "ms"), optional=True),
    MachineWant("elongation", "m", words.ROLE["elongation"], ("mm", "in")),
    MachineWant("force", "N", words.FORCE, ("N", "kN", "lbf")),
)
"""What is wanted of a pull or friction test."""
TIMED = tuple(replace(w, optional=w.role == "elongation") for w in PULL)
"""The same of a test whose elongation is its speed times its time."""


@dataclass(frozen=True)
class Column:
    """One column taken: where it stands, its name and unit as written or given, how it gets SI."""

    role: str
    index: int
    name: str
    unit: str
    factor: Fraction
    offset: float = 0.0
    given: bool = False
    """Whether the user said which column it is."""

    def si(self, values: Array) -> Array:
        """Values in SI units; a factor such as 1/1000 divides, which rounds once."""
        factor = self.factor
        if factor.numerator == 1:
            values = values / factor.denominator if factor.denominator != 1 else values
        else:
            values = values * float(factor)
        return values + self.offset if self.offset else values

    def sentence(self, others: Sequence[Column] = (), by_unit: bool = False) -> str:
        """What was understood of the column, and which others it was preferred to."""
        text = f"{self.role} is the column '{cut(self.name)}'"
        text += f" in {self.unit}" if self.unit else ", a pure number"
        text += ", as given" if self.given else " (by its unit)" if by_unit else ""
        if others:
            text += ", not " + " or ".join(
                f"'{cut(c.name)}'" + (f" in {c.unit}" if c.name == self.name else "")
                for c in others[:4]
            )
        return text


@dataclass(frozen=True)
class Header:
    """The columns of a file's table: names and units as written, and the line of the names.

    `style` says where the units stand: "bracket row", "plain row", "names", "units", "units above",
    "stated" or "" (nowhere). `label` holds the fields of the line above the names, which may number
    specimens.
    """

    names: tuple[str, ...]
    units: tuple[str | None, ...]
    style: str
    line: int
    label: tuple[str, ...] = ()
    path: str = ""

    @property
    def columns(self) -> list[tuple[str, str | None]]:
        """(name, unit) of each."""
        return list(zip(self.names, self.units, strict=True))

    def only(self, kept: Collection[int]) -> Header:
        """The same with some columns; the others' names and units are empty."""
        names = tuple(n if i in kept else "" for i, n in enumerate(self.names))
        units = tuple(u if i in kept else None for i, u in enumerate(self.units))
        return replace(self, names=names, units=units)

    def fail(self, reason: str, how: str = "", asks: str = "columns") -> FileError:
        """An error about these columns; with `how`, the option that answers it, it `asks`."""
        return FileError(self.path, reason, self.line, how=how, asks=asks if how else "")

    def listed(self) -> str:
        """The columns there are, as the end of an error's sentence."""
        there = [f"'{cut(n)}' [{cut(u)}]" if u else f"'{cut(n)}'" for n, u in self.columns[:8]]
        return f"its columns are {', '.join(there)}" + (" and more" if self.names[8:] else "")

    def candidates(self, want: Want, said: ColumnEntry | None = None) -> list[tuple[int, Column]]:
        """Columns in a unit of what is wanted, those the user names, with the rank of each name."""
        found = []
        for index, (name, written) in enumerate(self.columns):
            if said is not None and plain(name) != plain(said.name or ""):
                continue
            unit = (said.unit if said else "") or written or ""
            known, rank = convert(unit, want.si) if unit else None, want.rank(name)
            if not unit and want.si == "1" and (said is not None or want.named(name)):
                known = Fraction(1), 0.0
            if known and (rank is not None or said is not None):
                column = Column(want.role, index, name, unit, *known, said is not None)
                found.append((rank or 0, column))
        return found


def by_order(
    header: Header, wants: Sequence[Want], said: Mapping[str, ColumnEntry], count: int
) -> Taken:
    """The columns as the user lists them; FileError where the file has not `count` of them."""
    if count != len(header.names):
        raise header.fail(
            f"has {len(header.names)} columns",
            f", --columns lists {count}; write one entry for each, '{SKIP}' for those not used",
        )
    taken = {}
    for want in wants:
        if (entry := said.get(want.role)) is not None and entry.index is not None:
            known = convert(entry.unit, want.si) or (Fraction(1), 0.0)
            name = header.names[entry.index]
            taken[want.role] = Column(want.role, entry.index, name, entry.unit, *known, True)
        elif not want.optional:
            raise header.fail(f"the columns given hold no {want.role}", f": {how(wants)}")
    return taken, [column.sentence() for column in taken.values()]


Taken = tuple[dict[str, Column], list[str]]
"""{role: column}, and sentences that say what was understood."""


def assign(
    header: Header,
    wants: Sequence[Want],
    said: Mapping[str, ColumnEntry],
    same: Callable[[Sequence[Column]], bool] | None = None,
) -> Taken:
    """The column of each quantity that is wanted, and sentences saying so.

    `same` tells whether several columns hold the same measurement; then the first is taken. Raises
    FileError where a column is missing, has no unit or one of another dimension, or where several
    could be meant.
    """
    taken: dict[str, Column] = {}
    sentences = []
    for want in wants:
        candidates = header.candidates(want, said.get(want.role))
        if not candidates:
            if want.role in said or not want.optional:
                raise header.fail(*_missing(header, want, said.get(want.role)))
            sentences += _not_read(header, want)
            continue
        best = min(rank for rank, _ in candidates)
        first = [c for rank, c in candidates if rank == best]
        spare = want.optional and want.role == "time"
        if len(first) > 1 and not spare and not (same and same(first)):
            which = " or ".join(f"'{cut(c.name)}'" for c in first[:4])
            raise header.fail(
                f"does not say which column is the {want.role}: {which}; name one",
                f" (--columns {want.role}=NAME)",
            )
        taken[want.role] = column = first[0]
        if column.given and (why := _gainsaid(header, column, want.si)):
            raise header.fail(
                f"{why}; give the unit that the file states",
                ", or, if the file is wrong, list its columns in order "
                f"(--columns {want.role}:{column.unit},{SKIP},...)",
            )
        others = [c for _, c in candidates if c is not column]
        by_unit = isinstance(want, MachineWant) and not want.named(column.name)
        sentences.append(column.sentence(others, by_unit))
    return taken, sentences


def complete(header: Header, said: Mapping[str, ColumnEntry], wants: Sequence[Want] = PULL) -> bool:
    """Whether there is a column for all that is due."""
    return all(header.candidates(w, said.get(w.role)) for w in wants if not w.optional)


def how(wants: Sequence[Want]) -> str:
    """How to say what the columns are."""
    due = ",".join(f"{w.role}:{w.units[0]}" for w in wants if not w.optional)
    return f"write --columns {due} ({SKIP}: not used)"


def _missing(header: Header, want: Want, said: ColumnEntry | None) -> tuple[str, str]:
    """Why there is no such column, and the option that would say which one it is."""
    for name, unit in header.columns:
        if said is not None and plain(name) == plain(said.name or "") and not unit:
            return _wrong_unit(want, name, unit)
        if said is None and want.named(name):
            return _wrong_unit(want, name, unit)
    weighed = [(n, u) for n, u in header.columns if u and weight_unit(u)]
    if said is None and want.si == "N" and len(weighed) == 1:
        return _wrong_unit(want, *weighed[0])
    if said is not None:
        name = cut(said.name or "")
        return f"has no column '{name}' with a unit of {want.role}; {header.listed()}", ""
    return (
        f"has no column with a unit of {want.role} ({want.due}); {header.listed()}",
        f" (say which: --columns {want.role}:{want.units[0]}=NAME)",
    )


def _not_read(header: Header, want: Want) -> list[str]:
    """That a column is called as one that may be missing, but is not read: its unit is unknown."""
    for name, unit in header.columns:
        if want.named(name):
            why = f"is in '{cut(unit)}', which is no unit of {want.role}" if unit else "has no unit"
            return [f"the {want.role} is not read: column '{cut(name)}' {why}"]
    return []


def _gainsaid(header: Header, column: Column, si: str) -> str | None:
    """That the file states another unit for a column than the user does, in words."""
    written = header.units[column.index]
    if not written or not column.unit or not gainsays(written, column.unit, si):
        return None
    name = cut(header.names[column.index])
    weight = weight_unit(written) if si == "N" else None
    means = f", which as a force is {weight}" if weight else ""
    return f"column '{name}' is in '{cut(written)}'{means}, not in '{column.unit}' as given"


def gainsaid(header: Header, taken: Mapping[str, Column], wants: Sequence[Want]) -> list[str]:
    """That the file states other units than the user, who lists its columns in order and counts."""
    found = [_gainsaid(header, taken[w.role], w.si) for w in wants if w.role in taken]
    return [f"{why}; what is given counts" for why in found if why]


def _wrong_unit(want: Want, name: str, unit: str | None) -> tuple[str, str]:
    role, called = want.role, cut(name)
    if not unit:
        say = f" (say which: --columns {role}:{want.units[0]}='{called}')"
        return f"column '{called}' has no unit; {role} needs one such as {want.due}", say
    text = f"column '{called}' is in '{cut(unit)}', which is no unit of {role}"
    weight = weight_unit(unit) if want.si == "N" else None
    if weight:
        return (
            f"{text}, a unit of mass; if its weight is meant, that is {weight}",
            f" (say so: --columns {role}:{weight}='{called}')",
        )
    if gainsays(unit, want.units[0], want.si):
        return f"{text}; name another column", f" (--columns {role}:{want.units[0]}=NAME)"
    return (
        f"{text}; it needs one such as {want.due}",
        f" (say which it is: --columns {role}:UNIT='{called}')",
    )


def cut(text: str) -> str:
    """A text for a message: printable, in one line, of at most forty letters."""
    text = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return text if len(text) <= 40 else text[:37] + "..."


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
        if slash and (unit_role(unit) or (weight_unit(unit) and named_role(name) == "force")):
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
    if match and weight_unit(match[2]) and named_role(match[1]) == "force":
        return match[1].strip(), match[2]  # Load, g: a unit that is asked for, not none
    match = _CAMEL.fullmatch(text)
    if match and (known := common_unit(match[2])) and named_role(match[1]) == known[0]:
        return match[1].strip(), match[2]
    return text, None


def _without_origin(text: str) -> str:
    """A name without the point it counts from: "extension from preload" is no load."""
    return re.sub(r"\b(from|after|since|at|ab|bei) (pre-?load|vorkraft)\b", "", text)


def named_role(name: str) -> str | None:
    """What a column's name alone says it is."""
    text = _without_origin(plain(name))
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
    text = _without_origin(plain(name))
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
