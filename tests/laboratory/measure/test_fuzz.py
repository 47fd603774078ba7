"""Damaged files: an error in plain words or a finite trace, soon, whatever the damage."""

from __future__ import annotations

import os
import random
import re
import time
from pathlib import Path

import numpy as np
import pytest

from counts import cases
from laboratory.measure.exports import EXPORTS
from laboratory.measure.layouts import LAYOUTS, curve, encoded
from layerjam.core.errors import FileError, LayerjamError
from layerjam.laboratory.measure.history import read_history
from layerjam.laboratory.measure.log import ACCELERATION, PRESSURE, TEMPERATURE, TIME, Log, read_log
from layerjam.laboratory.measure.readers.read import read_traces
from layerjam.laboratory.measure.readers.unit_words import unit_role
from layerjam.laboratory.measure.trace import Trace

TOKENS = [
    b"NaN",
    b"inf",
    b"-inf",
    b"1e999",
    b"9" * 400,
    b"-1e308",
    b"1e-320",
    b"",
    b"True",
    b"0x1F",
]
TOKENS += [
    b"1.234.567",
    b"1,234,567.8",
    b"--5",
    b"5-",
    b"1e",
    b"N",
    b"(kN)",
    b'"',
    b";",
    b"\t",
    b",",
]
TOKENS += [
    "\u22123".encode(),
    b"\xff\xfe",
    b"\xef\xbb\xbf",
    b"\x00",
    b"\x1a",
    b"\r",
    b"1 000",
    b"'",
]
TOKENS += [b"Time", b"Load", b"(s)", b"[mm]", b"# layerjam", b"(", b"[" * 50, b" " * 300]


def _bytes_flipped(data: bytearray, rng: random.Random) -> bytes:
    for _ in range(rng.choice([1, 1, 3, 20])):
        data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)


def _cut(data: bytearray, rng: random.Random) -> bytes:
    return bytes(data[: rng.randrange(len(data))])


def _token_put(data: bytearray, rng: random.Random) -> bytes:
    for _ in range(rng.choice([1, 1, 2, 10])):
        at = rng.randrange(len(data) + 1)
        data[at : at + rng.choice([0, 0, 1, 5, 30])] = rng.choice(TOKENS)
    return bytes(data)


def _lines_moved(data: bytearray, rng: random.Random) -> bytes:
    lines = bytes(data).split(b"\n")
    a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
    kind = rng.randrange(6)
    if kind == 0:
        del lines[a]
    elif kind == 1:
        lines.insert(a, lines[b])
    elif kind == 2:
        rng.shuffle(lines)
    elif kind == 3:
        lines[a], lines[b] = lines[b], lines[a]
    elif kind == 4:
        del lines[min(a, b) : max(a, b)]
    else:
        lines[a:a] = lines[b:] * rng.choice([1, 3])
    return b"\n".join(lines)


def _fields_swapped(data: bytearray, rng: random.Random) -> bytes:
    lines = bytes(data).split(b"\n")
    mark = rng.choice([b",", b";", b"\t", b'","'])
    for _ in range(rng.choice([1, 5])):
        at = rng.randrange(len(lines))
        fields = lines[at].split(mark)
        kind = rng.randrange(3)
        if kind == 0:
            rng.shuffle(fields)
        elif kind == 1:
            fields[rng.randrange(len(fields))] = rng.choice(TOKENS)
        else:
            fields.pop() if rng.random() < 0.5 else fields.append(rng.choice(TOKENS))
        lines[at] = mark.join(fields)
    return b"\n".join(lines)


def _signs_changed(data: bytearray, rng: random.Random) -> bytes:
    old, new = rng.sample([b",", b".", b";", b"\t", b'"', b"\n", b"\r\n", b" ", b"-", b"e", b""], 2)
    count = rng.choice([-1, -1, 1, 20])
    return bytes(data).replace(old or b"0", new, count)


def _recoded(data: bytearray, rng: random.Random) -> bytes:
    text = bytes(data).decode("latin-1")
    coded = text.encode(rng.choice(["utf-8", "utf-16", "utf-16-le", "utf-32", "utf-8-sig"]))
    return coded[: rng.choice([None, -1, -3])]


def _whole_text(data: bytearray, rng: random.Random) -> bytes:
    piece = rng.choice([*TOKENS, b"1,2,3\n", b'"', b"a b\n", bytes(data[:40])])
    return piece * rng.choice([1, 50, 3000]) + (bytes(data) if rng.random() < 0.5 else b"")


def _separators_swapped(data: bytearray, rng: random.Random) -> bytes:
    marks = [b",", b";", b"\t", b"|", b"  "]
    text = bytes(data)
    here = next((m for m in (b"\t", b";", b"|", b",") if m in text), b",")
    lines = text.split(b"\n")
    first = rng.randrange(len(lines))
    last = rng.choice([first + 1, first + 5, len(lines)])
    new = rng.choice(marks)
    return b"\n".join(
        line.replace(here, new) if first <= k < last else line for k, line in enumerate(lines)
    )


def _rows_doubled(data: bytearray, rng: random.Random) -> bytes:
    lines = bytes(data).split(b"\n")
    at = rng.randrange(len(lines))
    count = rng.choice([1, 1, 5, len(lines)])
    return b"\n".join([*lines[: at + count], *lines[at : at + count], *lines[at + count :]])


UNITS = [b"mm", b"N", b"kN", b"s", b"in", b"lbf", b"MPa", b"%", b"", b"kg", b"mm/min", b"ms"]


def _units_swapped(data: bytearray, rng: random.Random) -> bytes:
    """One unit of the head by another; what is read then must be in the unit that stands there."""
    for _ in range(20):
        old = rng.choice(UNITS[:6])
        signs = (b"(%s)", b"[%s]", b'"%s"', b"\t%s")
        form = rng.choice(signs)
        if form % old in data:
            return bytes(data).replace(form % old, form % rng.choice(UNITS), rng.choice([1, -1]))
    return bytes(data)


DAMAGE = [_bytes_flipped, _cut, _token_put, _lines_moved, _fields_swapped, _signs_changed]
DAMAGE += [_recoded, _whole_text, _separators_swapped, _rows_doubled, _units_swapped]


def _good() -> dict[str, bytes]:
    """Undamaged files: the known layouts, and every export of the varied ones, short."""
    time, travel, force = (np.array(c) for c in curve(40))
    files = {layout: encoded(layout, 40) for layout in LAYOUTS}
    files |= {n: e.write(time, travel / 1e3, force) for n, e in EXPORTS.items()}
    rows = [",".join([r] * 2) for r in encoded("named", 40).decode().split("\n")[:-1]]
    files["side by side"] = "\n".join([*rows, ""]).encode()
    files["stacked"] = encoded("bluehill", 40) + b"\n" + encoded("bluehill", 30)
    return files


def _units_as_said(trace: Trace) -> None:
    """Each sentence on a column names a unit of its own role: no force from millimetres."""
    for said in trace.understood:
        role, _, rest = said.partition(" is the column ")
        if rest and trace.format != "layerjam CSV":
            unit = re.split(r"' in ", rest)[-1].split(",")[0].split(" (by")[0]
            known = unit_role(unit)
            assert known is not None and known[0] == role, said


def _fuzz(folder: Path, count: int, seed: int) -> None:
    rng = random.Random(seed)
    good = _good()
    names_of_good = list(good)
    read = 0
    path = folder / "mutant.csv"
    path.write_bytes(encoded("german", 40))
    read_traces(path)  # what is imported at the first use counts for no file
    for number in range(count):
        data = good[rng.choice(names_of_good)]
        names = []
        for damage in rng.choices(DAMAGE, k=rng.choice([1, 1, 2, 3])):
            names.append(damage.__name__)
            data = damage(bytearray(data or b" "), rng)
        path.write_bytes(data)
        started = time.process_time()
        try:
            traces = read_traces(path)
        except LayerjamError as err:
            text = str(err)
            assert "mutant.csv" in text and "\n" not in text and len(text) < 700, (number, text)
            assert isinstance(err, FileError), (number, text)
        except Exception as err:
            raise AssertionError(f"mutant {number} of seed {seed} ({names}): {err!r}") from err
        else:
            read += 1
            for trace in traces:
                _checks(trace)
        assert time.process_time() - started < 2.0, f"mutant {number} of seed {seed} ({names})"
    assert 0.01 * count < read < 0.7 * count  # the damage is neither always fatal nor always mild


def _checks(trace: Trace) -> None:
    assert len(trace.force) == len(trace.elongation) >= 10
    assert np.isfinite(trace.force).all() and np.isfinite(trace.elongation).all()
    if trace.time is not None:
        assert len(trace.time) == len(trace.force)
        assert np.isfinite(trace.time).all() and (np.diff(trace.time) >= 0).all()
    _units_as_said(trace)


def test_damaged_files(tmp_path: Path) -> None:
    _fuzz(tmp_path, int(os.environ.get("LAYERJAM_FUZZ", "200")), seed=1)


@pytest.mark.slow
def test_many_damaged_files(tmp_path: Path) -> None:
    _fuzz(tmp_path, int(os.environ.get("LAYERJAM_FUZZ", cases(20000, 2000))), seed=2)


def _logs() -> dict[str, bytes]:
    """Undamaged logs: pressure, acceleration, a rubber's curve and a vacuum history."""
    time = np.linspace(0, 10, 40)
    value = 50 + np.sin(time)

    def table(head: str, mark: str = ",", point: str = ".") -> bytes:
        rows = (
            f"{a:.4f}{mark}{b:.4f}".replace(".", point) for a, b in zip(time, value, strict=True)
        )
        return "\n".join([head, *rows, ""]).encode("latin-1")

    return {
        "pressure": table("time [s],p [kPa abs]"),
        "german": table("Zeit [s];Druck [kPa(g)]", ";", ","),
        "crash": table("t [ms],a [g]"),
        "sleeve": table("strain [%],stress [kPa]"),
        "history": table("time [s],vacuum [kPa]"),
        "kelvin": table("time [s]\tpressure [mbar]\tT [K]", "\t"),
    }


def _in_time_order(log: Log) -> list[np.ndarray]:
    return [log["time"], *(log[role] for role in log.columns if role != "time")]


def _fuzz_logs(folder: Path, count: int, seed: int) -> None:
    rng = random.Random(seed)
    good, read = _logs(), 0
    path = folder / "mutant.csv"
    for number in range(count):
        data = good[rng.choice(list(good))]
        for damage in rng.choices(DAMAGE, k=rng.choice([1, 1, 2])):
            data = damage(bytearray(data or b" "), rng)
        path.write_bytes(data)
        started = time.process_time()
        kind = rng.randrange(3)
        try:
            if kind == 0:
                history = read_history(path, 101325.0)
                made = [history.time, history.vacuum]
            else:
                wants = (TIME, PRESSURE, TEMPERATURE) if kind == 1 else (TIME, ACCELERATION)
                made = _in_time_order(read_log(path, wants))
        except LayerjamError as err:
            text = str(err)
            assert "\n" not in text and len(text) < 900, (number, text)
        except Exception as err:
            raise AssertionError(f"log {number} of seed {seed}: {err!r}") from err
        else:
            read += 1
            for column in made:
                assert len(column) > 1 and np.isfinite(column).all(), (number, seed)
            assert (np.diff(made[0]) >= 0).all(), (number, seed)
        assert time.process_time() - started < 2.0, f"log {number} of seed {seed}"
    assert 0.005 * count < read < 0.7 * count


def test_damaged_logs(tmp_path: Path) -> None:
    _fuzz_logs(tmp_path, int(os.environ.get("LAYERJAM_FUZZ", "200")), seed=3)


HOSTILE = {
    "one line of digits": b"1" * 1_000_000,
    "only newlines": b"\n" * 1_000_000,
    "only commas": b"," * 1_000_000,
    "only quotes": b'"' * 1_000_000,
    "only blanks and a letter": b" " * 999_999 + b"x",
    "one field a line": b"1\n" * 500_000,
    "short rows": b"Time (s),Extension (mm),Load (N)\n" + b"1\n" * 490_000,
    "rows of separators": b"Time (s),Extension (mm),Load (N)\n" + b",,\n" * 330_000,
    "rows of spaces": b"Time (s),Extension (mm),Load (N)\n" + b" \n" * 490_000,
    "too many fields": b"Time (s),Extension (mm),Load (N)\n" + b"1,2,3,,,,,\n" * 90_000,
    "a word at the end": b"Time (s),Extension (mm),Load (N)\n" + b"1,2,3\n" * 160_000 + b"1,2,x\n",
    "headers over headers": b"a (s),b (mm),c (N)\n1,2,3\n" * 40_000,
    "strange units": b"".join(
        b",".join(b"n (u%c%c%d)" % (97 + i % 26, 97 + j % 26, i) for j in range(99)) + b"\n1,2\n"
        for i in range(600)
    ),
    "ambiguous signs": b"Time (s);Extension (mm);Load (N)\n" + b"1.234;1.234;1.234\n" * 55_000,
    "a quote that never closes": b"Time (s),Extension (mm),Load (N)\n" + b'1,2,"3\n' * 100_000,
    "long numbers": b"Time (s),Extension (mm),Load (N)\n" + b"1,2," + b"3" * 990_000 + b"\n",
    "spaces in a number": b"Time (s);Extension (mm);Load (N)\n" + b"1;2;" + b"3 " * 9_000 + b"\n",
    "comments only": b"# layerjam\n" * 90_000,
    "a long comment": b"# layerjam " + b"x" * 990_000,
    "words": b"True,False,True\n" * 60_000,
    "true numbers": b"Time (s),Extension (mm),Load (N)\n" + b"1,2,True\n" * 100_000,
}


@pytest.mark.parametrize("name", HOSTILE)
def test_no_input_takes_long(name: str, tmp_path: Path) -> None:
    path = tmp_path / "hostile.csv"
    path.write_bytes(HOSTILE[name])
    started = time.process_time()
    with pytest.raises(LayerjamError):
        read_traces(path)
    # seconds on a slow machine; steps that grow with the square of the size take hours
    assert time.process_time() - started < 60
