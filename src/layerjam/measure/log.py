"""A time log of any logger or test machine: named columns, units, and nothing guessed.

A command says which quantities it wants (`Want`). A column is taken by its unit first, then by its
name. Where a file has no names, or does not say enough, the user says what its columns are:
``time:ms,skip,pressure:bar`` (by place, one entry a column) or ``pressure:bar=Chamber 2``.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from layerjam.errors import FileError, QuantityError
from layerjam.measure.readers.columns import listed, plain, unit_role
from layerjam.measure.readers.content import Source
from layerjam.measure.readers.numbers import read_columns
from layerjam.measure.readers.source import load_source
from layerjam.measure.readers.table import (
    Table,
    find_table,
    looks_numeric,
    read_grid,
    separator_of,
    split,
)
from layerjam.units import show, unit_factor

Array = npt.NDArray[np.float64]
SKIP = "skip"
STANDARD_GRAVITY = 9.80665
_HEAD_LINES = 200
_G = {"g", "gn", "g_n", "g0", "gs", "gee", "g's"}
_TEMPERATURES = {
    "k": (1.0, 0.0), "kelvin": (1.0, 0.0), "°c": (1.0, 273.15), "c": (1.0, 273.15),
    "degc": (1.0, 273.15), "deg c": (1.0, 273.15), "celsius": (1.0, 273.15),
    "°f": (5 / 9, 459.67 * 5 / 9), "degf": (5 / 9, 459.67 * 5 / 9), "f": (5 / 9, 459.67 * 5 / 9),
}  # fmt: skip
_PRESSURE = re.compile(
    r"(?P<unit>[a-z0-9]+?)(?: ?[(_.]?(?P<how>abs|absolute|gauge|gage|rel|a|g|ü)\)?)?", re.IGNORECASE
)
_TWO_POINTS = re.compile(rb"(?<![\w.,])[+-]?\d{1,3}(?:\.\d{3}){1,4}\.\d{1,9}(?![\d.,])")


@dataclass(frozen=True)
class Want:
    """A quantity a command needs: its name, SI unit, how its column may be called, what is due.

    `words` is a pattern for names in lower case without accents. `optional`: the command can do
    without. `bare`: a column without any unit will do (a pure number).
    """

    role: str
    si: str
    words: str
    due: str
    optional: bool = False
    bare: bool = False
    avoid: str = ""


TIME = Want("time", "s", r"\b(time|zeit|temps|tiempo|tempo|t|elapsed)\b|zeit\b", "'s' or 'ms'")
PRESSURE = Want(
    "pressure", "Pa", r"\b(pressure|vacuum|pression|presion|pressione|p|vide)\b|druck\b|vakuum",
    "'kPa' or 'bar'",
)  # fmt: skip
TEMPERATURE = Want("temperature", "K", r"\btemp\b|temperature?", "'K' or '°C'", True)
ACCELERATION = Want(
    "acceleration", "m/s^2", r"\b(acc|acceleration|accel|beschleunigung|a)\b", "'g' or 'm/s^2'"
)


@dataclass(frozen=True)
class Said:
    """A column as it was taken: name and unit as written or given."""

    index: int
    name: str
    unit: str
    by_user: bool


@dataclass(frozen=True)
class Log:
    """Columns in SI units by role, shape (N,) each, and what was understood of the file.

    `head` holds the lines above the table, lower-case key to the rest of the line; `said` each
    column's name and unit as written, for what a unit alone does not say (bar absolute or gauge).
    """

    path: str
    columns: Mapping[str, Array]
    said: Mapping[str, Said]
    head: Mapping[str, tuple[str, ...]]
    understood: tuple[str, ...]

    def __getitem__(self, role: str) -> Array:
        return self.columns[role]

    def __contains__(self, role: object) -> bool:
        return role in self.columns

    @property
    def name(self) -> str:
        """The file's name without its folder."""
        return Path(self.path).name


@lru_cache(maxsize=1024)
def scale(unit: str, si: str) -> tuple[float, float] | None:
    """(factor, offset) with SI value = factor * value + offset; None for another dimension.

    Beyond `units.unit_factor`: °C and °F, g as an acceleration, bara and barg, Sek.
    """
    text = re.sub(r"(?<=m)([23])$", r"^\1", unit.strip())  # N/mm2
    if si == "K":
        return _TEMPERATURES.get(text.lower())
    if si == "m/s^2" and text.lower() in _G:
        return STANDARD_GRAVITY, 0.0
    if si == "s" and (known := unit_role(text)) and known[0] == "time":
        return float(known[1]), 0.0
    factor = unit_factor(text, si) if text else None
    if factor is None and si == "1" and text.lower() in ("mm/mm", "m/m", "in/in", "-", "1"):
        return 1.0, 0.0
    if factor is None and si == "Pa" and (match := _PRESSURE.fullmatch(text)):
        factor = unit_factor(match["unit"], si)
        small = match["unit"].lower()
        if factor is None and small in ("kpa", "mpa", "hpa", "mbar", "bar", "psi", "torr"):
            factor = unit_factor({"kpa": "kPa", "mpa": "MPa", "hpa": "hPa"}.get(small, small), si)
    return None if factor is None else (float(factor), 0.0)


def _words(name: str) -> str:
    """A name in lower case, its words apart: p_abs."""
    return plain(name).replace("_", " ")


def pressure_says(said: Said) -> str | None:
    """What a column's unit or name says of it: "absolute", "gauge", "vacuum" or None."""
    match = _PRESSURE.fullmatch(said.unit.strip())
    how = (match["how"] or "").lower() if match and unit_factor(said.unit, "Pa") is None else ""
    name = "" if said.by_user else _words(said.name)
    if how in ("a", "abs", "absolute") or re.search(r"\babs\b|absolute?", name):
        return "absolute"
    if how in ("g", "gauge", "gage", "rel", "ü") or re.search(
        r"\b(gauge|gage)\b|uberdruck|relative?", name
    ):
        return "gauge"
    return "vacuum" if re.search(r"\b(vacuum|vide)\b|vakuum|unterdruck", name) else None


def read_log(
    path: str | Path,
    wants: Sequence[Want],
    columns: str | None = None,
    decimal: str | None = None,
) -> Log:
    """The wanted columns of a file in SI units.

    `columns` is the user's mapping, `decimal` "." or "," where the file leaves it open. Raises
    FileError (no such column, several, no unit, no number) and QuantityError for a mapping that is
    none. Time, where it is wanted and not optional, may not run backwards.
    """
    if decimal not in (None, ".", ","):
        raise QuantityError(f"decimal: '{decimal}' is not allowed; it is '.' or ','")
    given = _mapping(columns, wants) if columns is not None else {}
    source = load_source(path)
    if given and all(isinstance(place, int) for place in given):
        table = _by_place(source, str(columns).count(",") + 1)
        taken = {r: Said(int(p), f"column {int(p) + 1}", u, True) for p, (r, u) in given.items()}
    else:
        found = find_table(source)
        if found is None:
            raise FileError(source.path, _say_columns(source, wants))
        table = found
        taken = _taken(source, table, wants, given)
    for want in wants:
        if want.role not in taken and not want.optional:
            raise FileError(source.path, f"the columns given hold no {want.role}: {_how(wants)}")
    decimal = decimal or source.decimal
    source, table, notes = _last_point(source, table, list(taken.values()), decimal)
    grid = read_grid(source, table)
    places = list(taken)
    raw = read_columns(
        grid, [taken[r].index for r in places], [taken[r].name for r in places], decimal,
        table.separator == ",",
    )  # fmt: skip
    units = {w.role: w.si for w in wants}
    made = {}
    for role, values in zip(places, raw, strict=True):
        factor, offset = scale(taken[role].unit, units[role]) or (1.0, 0.0)
        made[role] = values * factor + offset
    _check_time(source.path, made, wants)
    said = [_sentence(role, what) for role, what in taken.items()] + notes
    return Log(source.path, made, taken, _head(source, table), tuple(said))


def _mapping(text: str, wants: Sequence[Want]) -> dict[int | str, tuple[str, str]]:
    """{place or column name: (role, unit)} of the option; QuantityError for what it is not."""
    known = {w.role: w for w in wants}
    out: dict[int | str, tuple[str, str]] = {}
    entries = [e.strip() for e in text.split(",")]
    named = any("=" in e for e in entries)
    for place, entry in enumerate(entries):
        if entry == SKIP and not named:
            continue
        said, equals, name = entry.partition("=")
        role, _, unit = said.partition(":")
        role, unit = role.strip(), unit.strip()
        if role not in known or (named and not (equals and name.strip())):
            form = "ROLE:UNIT=NAME" if named else "ROLE:UNIT or skip"
            raise QuantityError(
                f"columns: '{entry[:40]}' is not of the form {form}; roles are {', '.join(known)}"
            )
        want = known[role]
        if scale(unit, want.si) is None and (unit or not (want.bare or named)):
            problem = f"'{unit[:20]}' is no unit of {role}" if unit else f"{role} has no unit"
            raise QuantityError(f"columns: {problem}; give {want.due}, as in {role}:{_unit(want)}")
        if role in (r for r, _ in out.values()):
            raise QuantityError(f"columns: {role} is given twice")
        out[name.strip() if named else place] = (role, unit)
    if not out:
        raise QuantityError(f"columns: '{text[:40]}' names no column; roles are {', '.join(known)}")
    return out


def _unit(want: Want) -> str:
    return want.due.split("'")[1] if "'" in want.due else want.due


def _how(wants: Sequence[Want]) -> str:
    due = [w for w in wants if not w.optional]
    return "write --columns " + ",".join(f"{w.role}:{_unit(w)}" for w in due) + " (skip: not used)"


def _say_columns(source: Source, wants: Sequence[Want]) -> str:
    return f"has no row of column names; say what its columns are: {_how(wants)}"


def _by_place(source: Source, count: int) -> Table:
    """The table of a file whose columns the user counts; it begins at the first row of numbers."""
    head = []
    for item in source.lines():
        head.append(item)
        if len(head) == 1000:
            break
    separator = separator_of(text for _, text in head[-200:])
    for number, (offset, text) in enumerate(head, 1):
        fields = split(text, separator)
        while fields and not fields[-1]:
            fields.pop()
        if fields and all(looks_numeric(f) for f in fields):
            if len(fields) != count:
                raise FileError(
                    source.path,
                    f"has {len(fields)} columns, {count} are given; write one entry for each, "
                    f"'{SKIP}' for those not used",
                    number,
                )
            names = tuple(f"column {i + 1}" for i in range(count))
            return Table(names, (None,) * count, "", separator, max(number - 1, 1), offset)
    raise FileError(source.path, "holds no row of numbers")


def _taken(
    source: Source, table: Table, wants: Sequence[Want], given: Mapping[int | str, tuple[str, str]]
) -> dict[str, Said]:
    """The column for each role: the user's, else by unit, then by name."""
    pairs = [_name_unit(n, u, wants) for n, u in zip(table.names, table.units, strict=True)]
    by_name = {role: (str(name), unit) for name, (role, unit) in given.items()}
    out: dict[str, Said] = {}
    for want in wants:
        if want.role in by_name:
            name, unit = by_name[want.role]
            out[want.role] = _named(source, table, pairs, want, name, unit)
            continue
        found = [
            (not re.search(want.words, _words(n)), Said(i, n, u or "", False))
            for i, (n, u) in enumerate(pairs)
            if (scale(u, want.si) if u else want.bare and re.search(want.words, _words(n)))
            and not (want.avoid and re.search(want.avoid, _words(n)))
        ]
        best = [s for odd, s in found if odd == min(o for o, _ in found)]
        if not best and want.optional:
            continue
        if not best:
            there = listed(table.names, [u for _, u in pairs])
            raise FileError(
                source.path,
                f"has no column of {want.role} in a unit such as {want.due}; {there}; or "
                f"{_how(wants)}",
                table.line,
            )
        if len(best) > 1:
            which = " or ".join(f"'{s.name[:30]}'" for s in best[:4])
            raise FileError(
                source.path,
                f"does not say which column is the {want.role}: {which}; "
                f"write --columns '{want.role}=NAME'",
                table.line,
            )
        out[want.role] = best[0]
    return out


def _named(
    source: Source, table: Table, pairs: Sequence[tuple[str, str | None]], want: Want, name: str,
    unit: str,
) -> Said:  # fmt: skip
    """The column the user names, in the unit given or written."""
    places = [i for i, (n, _) in enumerate(pairs) if plain(n) == plain(name)]
    if len(places) != 1:
        count = f"{len(places)} columns" if places else "no column"
        there = listed(table.names, [u for _, u in pairs])
        raise FileError(source.path, f"has {count} '{name[:40]}'; {there}", table.line)
    unit = unit or pairs[places[0]][1] or ""
    if scale(unit, want.si) is None and (unit or not want.bare):
        raise FileError(
            source.path,
            f"column '{name[:40]}' has no unit of {want.role} ({want.due}); "
            f"write --columns '{want.role}:{_unit(want)}={name[:40]}'",
            table.line,
        )
    return Said(places[0], name, unit, True)


def _name_unit(name: str, unit: str | None, wants: Sequence[Want]) -> tuple[str, str | None]:
    """A column's name and unit, where the unit may end the name: 'Druck / kPa', 'p_bar'."""
    if unit:
        return name, unit
    match = re.fullmatch(r"(.+?)\s*\[([^\[\]]{1,20})\]", name.strip())  # p [kPa(g)]
    if match and any(scale(match[2], w.si) for w in wants):
        return match[1], match[2]
    match = re.fullmatch(r"(.+?)(?:\s*/\s*|\s+in\s+|_|\s*[,:]\s*)([^/_,:\s]{1,12})", name.strip())
    if match and any(scale(match[2], w.si) for w in wants if w.si != "1"):
        return match[1].strip(), match[2]
    return name, None


def _last_point(
    source: Source, table: Table, taken: Sequence[Said], decimal: str | None
) -> tuple[Source, Table, list[str]]:
    """Numbers such as 1.002.000 for 1002.000, where the point groups and is the decimal sign too.

    Only where the user says that the point is the decimal sign, or the column itself does: a group
    of thousands cannot follow a lone zero, so 0.000 shows it.
    """
    body, rest = source.data[table.first : table.last], b""
    if table.last is not None:
        rest = source.data[table.last :]
    if decimal == "," or not _TWO_POINTS.search(body):
        return source, table, []
    rows = [
        split(t, table.separator)
        for o, t in source.lines(table.first)
        if not rest or o < (table.last or 0)
    ]
    notes = []
    for said in taken:
        cells = [r[said.index] for r in rows if len(r) > said.index]
        twice = next((c for c in cells if _TWO_POINTS.fullmatch(c.encode())), None)
        if twice is None:
            continue
        if decimal is None and not any(re.fullmatch(r"[+-]?0\.\d+", c) for c in cells):
            raise FileError(
                source.path,
                f"'{twice[:20]}' in {said.name} does not show whether its last point is the "
                "decimal sign; say which sign is (--decimal)",
            )
        whole = twice.replace(".", "", twice.count(".") - 1)
        notes.append(
            f"in {said.name} {twice} is read as {whole}: the last point is the decimal one"
        )
    if not notes:
        return source, table, []
    fixed = _TWO_POINTS.sub(lambda m: m[0].replace(b".", b"", m[0].count(b".") - 1), body)
    last = None if table.last is None else table.first + len(fixed)
    data = source.data[: table.first] + fixed + rest
    return replace(source, data=data), replace(table, last=last), notes


def _check_time(path: str, made: Mapping[str, Array], wants: Sequence[Want]) -> None:
    due = any(w.role == "time" and not w.optional for w in wants)
    if not due or "time" not in made:
        return
    back = np.flatnonzero(np.diff(made["time"]) < 0)
    if back.size:
        at = float(made["time"][back[0]])
        raise FileError(path, f"time runs backwards after {show(at, 's', 6)}")
    if len(made["time"]) < 2 or made["time"][-1] <= made["time"][0]:
        raise FileError(path, "its time does not advance")


def _sentence(role: str, said: Said) -> str:
    unit = f" in {said.unit}" if said.unit else ", a pure number"
    return f"{role} is '{said.name[:40]}'{unit}" + (" (as given)" if said.by_user else "")


def _head(source: Source, table: Table) -> dict[str, tuple[str, ...]]:
    """Lines above the table as key and values: 'Material;EcoFlex30;', '# volume: 120 mL'."""
    out: dict[str, tuple[str, ...]] = {}
    for number, (offset, text) in enumerate(source.lines()):
        if offset >= table.first or number + 1 == table.line or number == _HEAD_LINES:
            break
        fields = [f for f in split(text.lstrip("# "), table.separator) if f]
        if len(fields) == 1 and (match := re.match(r"([^:=]{1,60})[:=]\s*(.+)", fields[0])):
            fields = [match[1].strip(), match[2].strip()]
        if len(fields) >= 2:
            out.setdefault(plain(fields[0]), tuple(fields[1:]))
    return out
