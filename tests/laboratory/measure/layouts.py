"""Files in the machines' layouts, written by the tests themselves."""

from __future__ import annotations

from pathlib import Path

import numpy as np

REAL = Path(__file__).resolve().parents[4] / "shared" / "data"


def curve(rows: int = 60) -> tuple[list[float], list[float], list[float]]:
    """(time [s], travel [mm], force [N]) of something pulled that rises, peaks and falls."""
    time = np.arange(rows) * 0.01
    travel = 13.0 * time
    noise = np.random.default_rng(5).normal(0.0, 0.05, rows)
    force = 100.0 * np.minimum(travel / 1.3, 1.0) - 2.0 * np.maximum(travel - 1.3, 0.0) + noise
    return time.tolist(), travel.tolist(), force.tolist()


def rows(rows: int = 60, form: str = "{:.4f},{:.5f},{:.4f}") -> list[str]:
    return [form.format(*row) for row in zip(*curve(rows), strict=True)]


def bluehill(count: int = 60) -> str:
    head = ['"Results Table 1"', '"","Maximum Load"', '"","(N)"', '"1","99.8"', '"Mean","99.8"', ""]
    head += ['"Time","Extension","Load"', '"(s)","(mm)","(N)"', ""]
    return "\n".join([*head, *rows(count, '"{:.4f}","{:.5f}","{:.4f}"'), ""])


def named(count: int = 60) -> str:
    return "\n".join(["Time (s),Displacement (mm),Force (N)", *rows(count), ""])


def german(count: int = 60) -> str:
    body = "\n".join(rows(count, "{:.4f};{:.5f};{:.4f}")).replace(".", ",")
    return f"Prüfzeit [s];Standardweg [mm];Standardkraft [N]\n{body}\n"


def testxpert(count: int = 60) -> str:
    head = ['"Épaisseur éprouvette",1.06,"mm"', '"Section",6.38,"mm²"', '"Capteur de force",""']
    head += ['"v1",1,"mm/min"', '"Temps","Traverse absolue","Force standard","Course standard"']
    head += ['"s","mm","N","mm"']
    body = [f"{t:.6g},{x - 755:.6g},{f:.6g},{x:.6g}" for t, x, f in zip(*curve(count), strict=True)]
    return "\n".join([*head, *body, ""])


def own(count: int = 60) -> str:
    head = ["# layerjam 0.1.0 tensile", "# procedure: pull", "# brake:", '#   name = "x"']
    head.append("time [s],elongation [m],force [N],slip [m],sleeve_force [N],vacuum [Pa]")
    body = [
        f"{t!r},{x / 1000!r},{f!r},0.0,1.5,94500.0" for t, x, f in zip(*curve(count), strict=True)
    ]
    return "\n".join([*head, *body, ""])


LAYOUTS = {
    "bluehill": (bluehill, "utf-8-sig"),
    "named": (named, "utf-8"),
    "german": (german, "cp1252"),
    "german_utf16": (german, "utf-16"),
    "testxpert": (testxpert, "latin-1"),
    "own": (own, "utf-8"),
}


def encoded(layout: str, count: int = 60) -> bytes:
    write, encoding = LAYOUTS[layout]
    return write(count).encode(encoding)
