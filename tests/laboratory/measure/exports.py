"""Exports of machines and locales, written from a truth by a small writer of the tests' own.

Each case says how a machine writes: names, units and where they stand, order, separator, decimal
and thousands signs, quotes, encoding, line ends, lines above and below. None is a copy of a real
file; the layouts follow what such programs are known to write.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SI = {
    "s": 1.0, "sec": 1.0, "sec.": 1.0, "Sek.": 1.0, "с": 1.0, "秒": 1.0, "seg": 1.0, "S": 1.0,
    "ms": 1e-3, "msec": 1e-3, "min": 60.0, "Min": 60.0, "h": 3600.0,
    "mm": 1e-3, "MM": 1e-3, "мм": 1e-3, "毫米": 1e-3, "㎜": 1e-3, "cm": 1e-2, "m": 1.0,
    "um": 1e-6, "µm": 1e-6, "in": 0.0254, "inch": 0.0254, "in.": 0.0254, "pulg": 0.0254,
    "N": 1.0, "Н": 1.0, "牛": 1.0, "kN": 1e3, "KN": 1e3, "кН": 1e3, "mN": 1e-3, "cN": 1e-2,
    "daN": 10.0, "gf": 9.80665e-3, "gF": 9.80665e-3, "kgf": 9.80665, "кгс": 9.80665,
    "lbf": 4.4482216152605, "lbF": 4.4482216152605, "ozf": 0.27801385095378,
    "ozF": 0.27801385095378,
}  # fmt: skip


@dataclass(frozen=True)
class Export:
    """How one machine writes. `columns` are (what, name, unit), what is t, x, f or a constant."""

    columns: Sequence[tuple[str, str, str]]
    style: str = "{name} ({unit})"
    """How name and unit stand in one cell; "rows" for a row each, "rows[]" with brackets."""
    sep: str = ","
    decimal: str = "."
    thousands: str = ""
    quote: str = ""
    """Signs around each cell: "" none, "all" everything, "names" the head only."""
    encoding: str = "utf-8"
    newline: str = "\n"
    above: Sequence[str] = ()
    below: Sequence[str] = ()
    origin: float = 0.0
    """Where the crosshead starts [m]."""
    digits: int = 7
    pad: int = 0
    between: Sequence[str] = ()
    """Lines between head and numbers."""

    def write(self, time: np.ndarray, travel: np.ndarray, force: np.ndarray) -> bytes:
        values = {"t": time, "x": travel + self.origin, "f": force}
        columns = [
            values[what] / SI[unit] if what in values else np.full(len(time), float(what))
            for what, _, unit in self.columns
        ]
        lines = [*self.above, *self._head(), *self.between]
        for row in zip(*(c.tolist() for c in columns), strict=True):
            lines.append(self._row([self._number(v) for v in row], self.quote == "all"))
        lines += self.below
        return (self.newline.join(lines) + self.newline).encode(self.encoding)

    def _number(self, value: float) -> str:
        digits = max(0, self.digits - max(0, int(np.floor(np.log10(abs(value) + 1e-30)))))
        text = f"{value:,.{min(digits, 12)}f}"
        text = text.replace(",", "\0").replace(".", self.decimal)
        return text.replace("\0", self.thousands)

    def _row(self, cells: Sequence[str], quoted: bool) -> str:
        if quoted:
            cells = [f'"{c}"' for c in cells]
        return self.sep.join(c.rjust(self.pad) for c in cells)

    def _head(self) -> list[str]:
        quoted = self.quote in ("all", "names")
        names = [n for _, n, _ in self.columns]
        units = [u for _, _, u in self.columns]
        if self.style == "none":
            return []
        if self.style == "rows":
            return [self._row(names, quoted), self._row(units, quoted)]
        if self.style == "rows()":
            return [self._row(names, quoted), self._row([f"({u})" for u in units], quoted)]
        if self.style == "rows[]":
            return [self._row(names, quoted), self._row([f"[{u}]" for u in units], quoted)]
        if self.style == "units above":
            return [self._row(units, quoted), self._row(names, quoted)]
        if self.style == "names alone":
            return [self._row(names, quoted)]
        cells = [self.style.format(name=n, unit=u) for n, u in zip(names, units, strict=True)]
        return [self._row(cells, quoted)]


def tfx(time: str, travel: str, force: str, *units: str) -> list[tuple[str, str, str]]:
    t, x, f = units or ("s", "mm", "N")
    return [("t", time, t), ("x", travel, x), ("f", force, f)]


ENGLISH = tfx("Time", "Extension", "Load")
EXPORTS: dict[str, Export] = {
    "Bluehill 3, quoted, kN": Export(
        tfx("Time", "Extension", "Load", "s", "mm", "kN"), "rows()", quote="all", digits=9
    ),
    "Bluehill Universal, results above": Export(
        ENGLISH, quote="all", encoding="utf-8-sig", newline="\r\n",
        above=['"Results Table 1"', '"","Maximum Load (N)","Extension at Maximum Load (mm)"',
               '"1","176.9","1.3"', '"Mean","176.9","1.3"', '""', '"Raw Data"'],
    ),
    "Bluehill, German, semicolons": Export(
        tfx("Zeit", "Verlängerung", "Last"), sep=";", decimal=",", encoding="cp1252",
        above=["Probenbezeichnung;A 12", "Prüfer;M. Müller"], newline="\r\n",
    ),
    "Bluehill, French": Export(
        tfx("Temps", "Extension", "Charge"), "rows()", sep=";", decimal=",", encoding="cp1252",
    ),
    "testXpert TRA, German": Export(
        [("t", "Prüfzeit", "s"), ("250", "Traverse absolut", "mm"), ("f", "Standardkraft", "N"),
         ("x", "Standardweg", "mm")], "rows", quote="names", encoding="latin-1",
        above=['"Probendicke",1.06,"mm"', '"Kraftaufnehmer",""', '"v1",780,"mm/min"'],
    ),
    "testXpert III, tabs": Export(
        tfx("Prüfzeit", "Standardweg", "Standardkraft"), "rows", sep="\t", decimal=",",
        encoding="utf-16", above=["Probe 1"], newline="\r\n",
    ),
    "MTS TestSuite, blank after names": Export(
        [("x", "Crosshead ", "mm"), ("f", "Load ", "N"), ("t", "Time ", "sec")], "rows",
        quote="names", above=['"Test Run Name","pull 3"', '"Date","11/20/2026 10:12:01 AM"',
                              '"Width","38","mm"', ""],
    ),
    "MTS TestSuite, tabs": Export(
        [("x", "Crosshead", "mm"), ("f", "Load", "N"), ("t", "Time", "sec")], "rows", sep="\t",
        above=["Test Name:\tPull", "Specimen Area:\t38.1\tmm^2", "", "Data Acquisition 1"],
    ),
    "MTS TestSuite, inches and lbf": Export(
        [("x", "Axial Displacement", "in"), ("f", "Axial Force", "lbf"),
         ("t", "Running Time", "sec")],
        "rows()", above=["MTS793|BTW|ENU|1|0|.|/|:|1|0|0|A", "Station Name: A.cfg", ""], digits=9,
    ),
    "MTS 793, columns of blanks": Export(
        [("t", "Time", "s"), ("f", "Axial Force", "N"), ("x", "Axial Displacement", "mm")],
        "rows", sep="   ", pad=12, above=["Data Header:", "Data Acquisition: Timed", ""],
    ),
    "Trapezium, one specimen": Export(
        [("t", "Time", "sec"), ("f", "Force", "N"), ("x", "Stroke", "mm")], "rows", quote="all",
        above=['"1 _ 1","",""'],
    ),
    "Trapezium, Japanese": Export(
        [("t", "時間", "秒"), ("f", "試験力", "N"), ("x", "ストローク", "mm")], "rows", quote="all",
        encoding="cp932", newline="\r\n", above=['"試験名","引張"', "", '"1 _ 1"'],
    ),
    "Japanese, full width brackets": Export(
        tfx("時間", "変位", "荷重"), "{name}（{unit}）", encoding="utf-8-sig"
    ),
    "Japanese, square millimetre sign": Export(
        tfx("時間", "クロスヘッド変位", "荷重", "s", "㎜", "N"), "{name}[{unit}]", encoding="cp932"
    ),
    "Chinese, GB 18030": Export(
        tfx("时间", "位移", "力值", "s", "mm", "kN"), "{name}({unit})", encoding="gb18030", digits=9
    ),
    "Chinese words for units": Export(
        tfx("时间", "位移", "负荷", "秒", "毫米", "牛"), "rows", sep="\t", encoding="utf-16-le"
    ),
    "Russian, cp1251": Export(
        tfx("Время", "Перемещение", "Нагрузка", "с", "мм", "Н"), "{name}, {unit}", sep=";",
        decimal=",", encoding="cp1251", newline="\r\n", above=["Испытание;Растяжение"],
    ),
    "Russian, kgf": Export(
        tfx("Время", "Перемещение", "Усилие", "с", "мм", "кгс"), "rows", sep="\t", encoding="cp1251"
    ),
    "Polish, cp1250": Export(
        tfx("Czas", "Wydłużenie", "Siła"), "{name} [{unit}]", sep=";", decimal=",",
        encoding="cp1250",
    ),
    "Spanish": Export(
        tfx("Tiempo", "Desplazamiento", "Fuerza", "seg", "mm", "N"), sep=";", decimal=",",
        thousands=".", encoding="latin-1",
    ),
    "Italian (Galdabini)": Export(
        tfx("Tempo", "Spostamento", "Carico"), "{name} {unit}", sep="\t", decimal=","
    ),
    "Portuguese": Export(
        tfx("Tempo", "Deslocamento", "Força", "s", "mm", "kgf"), sep=";", decimal=",",
        encoding="cp1252",
    ),
    "Dutch": Export(
        tfx("Tijd", "Verplaatsing", "Kracht"), "{name} in {unit}", sep=";", decimal=","
    ),
    "Czech": Export(
        tfx("Čas", "Prodloužení", "Síla"), "{name} [{unit}]", sep=";", decimal=",",
        encoding="cp1250",
    ),
    "Swedish": Export(tfx("Tid", "Förlängning", "Kraft"), sep=";", decimal=",", encoding="cp1252"),
    "Mark-10 (MESUR)": Export(
        [("f", "Load", "lbF"), ("x", "Travel", "in"), ("t", "Time", "sec.")], "{name} [{unit}]",
        above=["Test: pull", "Date,11/20/2026"], digits=9,
    ),
    "Mecmesin (Emperor), ozf": Export(
        tfx("Time", "Displacement", "Load", "s", "mm", "ozf"), sep="\t", above=["Sample:\t3"]
    ),
    "Lloyd (Nexygen), slashes": Export(
        [("f", "Load", "N"), ("x", "Machine Extension", "mm"), ("t", "Time", "s")],
        "{name} / {unit}",
        sep=";",
    ),
    "Tinius Olsen (Horizon)": Export(
        [("t", "Time", "sec"), ("x", "Position", "mm"), ("f", "Force", "N")], "{name}({unit})",
        quote="names", above=['"Test Name:","Pull"', '"Specimen:","1"'],
    ),
    "ADMET": Export(
        [("f", "Load", "lbf"), ("x", "Position", "in"), ("t", "Time", "sec")], "{name} ({unit})",
        sep="\t", above=["Sample Information", "Name\tpull"], digits=9,
    ),
    "Hounsfield, underscores": Export(tfx("time", "extension", "force"), "{name}_{unit}", sep="\t"),
    "Imada, gf and ms": Export(
        tfx("Elapsed Time", "Displacement", "Force", "msec", "mm", "gf"), "{name}[{unit}]"
    ),
    "an English locale with thousands": Export(
        tfx("Time", "Position", "Load", "ms", "um", "mN"), "rows[]", quote="all", thousands=",",
        digits=5,
    ),
    "a Swiss locale": Export(
        tfx("Zeit", "Weg", "Kraft", "ms", "µm", "mN"), sep=";", thousands="'", encoding="cp1252",
        digits=5,
    ),
    "a French locale, narrow blanks": Export(
        tfx("Temps", "Déplacement", "Force", "ms", "µm", "mN"), sep=";", decimal=",",
        thousands="\u202f", digits=5,
    ),
    "a French locale, hard blanks, cp1252": Export(
        tfx("Temps", "Déplacement", "Force", "ms", "µm", "mN"), sep=";", decimal=",",
        thousands="\u00a0", digits=5, encoding="cp1252",
    ),
    "a German locale with thousands": Export(
        tfx("Zeit", "Weg", "Kraft", "ms", "µm", "mN"), "rows[]", sep="\t", decimal=",",
        thousands=".", digits=5, encoding="cp1252",
    ),
    "bars": Export(ENGLISH, "{name} [{unit}]", sep="|"),
    "bars with blanks": Export(ENGLISH, "{name} [{unit}]", sep=" | "),
    "blanks and decimal commas": Export(ENGLISH, "{name}({unit})", sep="   ", decimal=","),
    "a comment sign before the names": Export(ENGLISH, sep=" ", above=["# made by a script"]),
    "a comment with units": Export(
        [("t", "# time", "s"), ("x", "pos", "m"), ("f", "force", "N")], "{name}[{unit}]", sep="\t",
        digits=9,
    ),
    "commas with blanks": Export(ENGLISH, sep=", "),
    "old Macintosh line ends": Export(ENGLISH, newline="\r"),
    "minutes": Export(tfx("Time", "Extension", "Load", "Min", "MM", "KN"), "rows", digits=9),
    "hours and metres": Export(tfx("Time", "Extension", "Load", "h", "m", "daN"), digits=10),
    "an absolute crosshead at -2.5 mm": Export(ENGLISH, origin=-2.5e-3),
    "a crosshead far from zero": Export(ENGLISH, origin=0.7948, sep=";", decimal=","),
    "columns nobody needs": Export(
        [("1", "Zyklus", "1"), ("f", "Kraft", "N"), ("5", "Dehnung", "%"), ("2", "Spannung", "MPa"),
         ("t", "Zeit", "s"), ("13", "Geschwindigkeit", "mm/s"), ("x", "Traversenweg", "mm"),
         ("38", "Probenbreite", "mm"), ("0.5", "Feindehnung", "mm")],
        "{name} [{unit}]", sep="\t",
    ),
    "names in one row, units above": Export(ENGLISH, "units above", sep="\t"),
    "units by themselves": Export(
        ENGLISH, "names alone", sep=";",
        above=["Time unit;s", "Extension unit;mm", "Load unit;N"],
    ),
    "a line between head and numbers": Export(
        ENGLISH, "rows", sep="\t", between=["-----\t---\t---"]
    ),
    "words below": Export(ENGLISH, sep=";", below=["", "End of test"]),
    "UTF-16 big end, no mark": Export(ENGLISH, sep="\t", encoding="utf-16-be"),
    "UTF-16 with mark": Export(ENGLISH, sep=";", decimal=",", encoding="utf-16"),
    "inch sign": Export(tfx("Time", "Stroke", "Load", "s", "in.", "lbf"), digits=9),
    "centimetres, centinewtons": Export(
        tfx("Time", "Hub", "Kraft", "s", "cm", "cN"), "{name}:{unit}"
    ),
    "a time called otherwise": Export(tfx("Messwert", "Kanal 1", "Kanal 2")),
    "camel case": Export(tfx("time", "displacement", "force", "ms", "mm", "N"), "{name}_{unit}"),
}  # fmt: skip
SUFFIX = {"\t": "txt", "|": "txt"}
