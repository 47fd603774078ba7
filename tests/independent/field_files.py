"""Files in layouts from the field, generated with numpy alone; each has one right answer.

The laws are written here again: a linear leak, a Mooney-Rivlin specimen, a half-sine impact, and a
pull with a straight rise. Nothing here imports the product.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

ATMOSPHERE = 101.325
"""Atmospheric pressure [kPa]."""
C1, C2 = 20.0, 10.0
"""Mooney-Rivlin parameters [kPa]."""
G = 9.80665


def stress(stretch):
    """Engineering stress [kPa] of a Mooney-Rivlin solid in tension at a stretch ratio."""
    return 2 * (stretch - stretch**-2) * (C1 + C2 / stretch)


def write(path: Path, lines, end: str = "\n") -> Path:
    """Write lines of text."""
    path.write_bytes((end.join([*lines, ""])).encode())
    return path


def hold(constant: float, start: float, rows: int = 120, step: float = 0.5, noise: float = 0.02):
    """Times [s] and absolute pressures [kPa] of a chamber that leaks, with a time constant [s]."""
    time = np.arange(rows) * step
    rng = np.random.default_rng(round(constant))
    pressure = ATMOSPHERE + (start - ATMOSPHERE) * np.exp(-time / constant)
    return time, pressure + noise * rng.standard_normal(rows)


def pump_down(constant: float = 12.0, rows: int = 120, ultimate: float = 5.0):
    """Times [s] and absolute pressures [kPa] of a chamber that a pump evacuates."""
    time = np.arange(rows) * 0.5
    rng = np.random.default_rng(2)
    pressure = ultimate + (ATMOSPHERE - ultimate) * np.exp(-time / constant)
    return time, pressure + 0.02 * rng.standard_normal(rows)


def csv(path: Path, head: str, *columns, form: str = "%.6g", mark: str = ",") -> Path:
    """Write columns of numbers below a header."""
    rows = zip(*columns, strict=True)
    return write(path, [head, *(mark.join(form % v for v in row) for row in rows)])


def specimen(rows: int = 150, to: float = 3.0):
    """Strain [-] and engineering stress [kPa] of a specimen of silicone."""
    strain = np.linspace(0, to, rows)
    return strain, stress(1 + strain)


def impact(rows: int = 600, step: float = 1e-4, height: float = 20.0, seed: int = 4):
    """Times [s] and accelerations [g] of a half sine of 20 ms from 20 ms on."""
    time = np.arange(rows) * step
    inside = (time >= 0.02) & (time <= 0.04)
    pulse = np.where(inside, height * np.sin(np.pi * (time - 0.02) / 0.02), 0.0)
    return time, pulse + 0.01 * np.random.default_rng(seed).standard_normal(rows)


def pull(stiffness: float = 50.0, rows: int = 120, noise: float = 0.05):
    """Times [s], elongations [mm] and forces [N] of a straight rise; `stiffness` in N/mm."""
    time = np.arange(rows) * 0.1
    elongation = 0.42 * time
    return (
        time,
        elongation,
        stiffness * elongation + noise * np.random.default_rng(5).standard_normal(rows),
    )


def load_cycles(count: int = 10, back: float = 0.35):
    """A pull to 2 mm, then load cycles that fall back by `back` [mm]."""
    first = np.linspace(0, 2, 200)
    cycle = np.r_[np.linspace(0, -back, 40)[1:], np.linspace(-back, 0.005, 41)[1:]]
    parts, top = [first], 2.0
    for _ in range(count):
        parts.append(top + cycle)
        top = parts[-1][-1]
    elongation = np.concatenate(parts)
    noise = 0.03 * np.random.default_rng(7).standard_normal(len(elongation))
    return np.arange(len(elongation)) * 0.2, elongation, 50 * elongation + noise


def labview(decimal: str, x_columns: str) -> list[str]:
    """Lines of a LabVIEW measurement: "No" X column, or "Multi", one for each of two channels."""
    time, value = impact()
    many = x_columns == "Multi"
    head = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
        f"Decimal_Separator\t{decimal}", "Multi_Headings\tYes", f"X_Columns\t{x_columns}",
        "Time_Pref\tRelative", "***End_of_Header***\t", "",
    ]  # fmt: skip
    zero, step = "0.0000000000000000E+0", "1.000000E-4"
    keys = {
        "Channels": ("2",) if many else ("1",),
        "Samples": ("600", "", "600") if many else ("600",),
        "Y_Unit_Label": ("Volts", "", "g") if many else ("g",),
        "X_Dimension": ("Time", "", "Time") if many else ("Time",),
        "X0": (zero, "", zero) if many else (zero,),
        "Delta_X": (step, "", step) if many else (step,),
    }
    head += ["\t".join((key, *values)) for key, values in keys.items()]
    names = "X_Value\tHammer\t" * many + "X_Value\tAccel\tComment"
    head += ["***End_of_Header***\t", names]
    rows = []
    for t, a in zip(time, value, strict=True):
        rows.append(f"{t:.6f}\t{a / 10:.6f}\t{t:.6f}\t{a:.6f}" if many else f"\t{a:.6f}")
    body = [line.replace(".", decimal) if decimal != "." else line for line in rows]
    return head[:15] + [line.replace(".", decimal) for line in head[15:]] + body


def phone(path: Path) -> Path:
    """Steps of 10 ms, and of 10.04 ms from 6 s on."""
    time = np.cumsum(np.r_[np.full(600, 0.01), np.full(450, 0.01004)])
    inside = (time >= 6.0) & (time <= 6.1)
    pulse = np.where(inside, 30 * np.sin(np.pi * (time - 6.0) / 0.1), 0.0)
    pulse += 0.02 * np.random.default_rng(6).standard_normal(len(time))
    head = '"Time (s)"\t"Linear Acceleration z (m/s^2)"'
    return csv(path, head, time, pulse, form="%.9E", mark="\t")
