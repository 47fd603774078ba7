"""Questions that take a minute, for the part of `make windows` that CI runs.

`python tests/windows/questions.py FOLDER` writes the answers into FOLDER/results.json.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import layerjam as lj


def main() -> None:
    """Ask for forces, a vacuum, a pull and a stop; write every number of the answers."""
    kapton, slips = "choi2018-kapton", np.linspace(0.0, 0.04, 200)
    answers = [
        lj.force(kapton, slip=slips, vacuum="50 kPa"),
        lj.vacuum(kapton, force="100 N", slip="20 mm"),
        lj.tensile(kapton, vacuum="94.5 kPa", speed="1 mm/s", travel="40 mm"),
        lj.drop(kapton, mass="1 kg", speed="2.5 m/s", vacuum="tuned", travel="40 mm"),
    ]
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    text = ",\n".join(answer.json() for answer in answers)
    (folder / "results.json").write_text(f"[{text}]\n", encoding="utf-8")


if __name__ == "__main__":
    main()
