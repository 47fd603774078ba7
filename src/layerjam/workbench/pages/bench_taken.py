"""What the chart of the bench gives away: what was seen of it in the last minute."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from layerjam.workbench.bench_session import Look
from layerjam.workbench.notebook import notebook_of


@dataclass(frozen=True)
class Watched:
    """Looks at a bench, and whether its board is a virtual one."""

    looks: Sequence[Look]
    simulated: bool
    name: str = "bench"
    files: Mapping[str, str] = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, list[float]]:
        """{time [s] from the first look, vacuum [Pa], NaN where none was shown, target [Pa]}."""
        start = self.looks[0].time
        return {
            "time": [round(look.time - start, 6) for look in self.looks],
            "vacuum": [math.nan if k.vacuum is None else float(k.vacuum) for k in self.looks],
            "target": [float(look.target) for look in self.looks],
        }

    def figure(self, ending: str) -> bytes:
        """The bytes of the figure."""
        from layerjam.report import control_figures, style

        made = control_figures.watched(**self.columns, simulated=self.simulated)
        with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
            return style.save(made, Path(folder) / f"figure.{ending}").read_bytes()

    def python(self) -> str:
        """Lines that hold what was seen and draw it."""
        saving = f'style.save(figure, Path("{self.name}.svg"), force=True)'
        return f"from pathlib import Path\n{self._lines()}{saving}\n"

    def notebook(self) -> str:
        """A Jupyter notebook that holds what was seen and draws it."""
        return notebook_of("What was seen of the bench", self._lines())

    def _lines(self) -> str:
        held = (f"{k} = [{', '.join(map(repr, v))}]\n" for k, v in self.columns.items())
        return (
            "from math import nan\n\nfrom layerjam.report import style\n"
            "from layerjam.report.control_figures import watched\n\n"
            f"{''.join(held)}figure = watched(time, vacuum, target, simulated={self.simulated})\n"
        )
