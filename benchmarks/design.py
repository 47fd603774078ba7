"""Ten million designs with all figures of merit; blocks on disk, here and on a local cluster."""

from __future__ import annotations

import resource
import tempfile
import time
from pathlib import Path

from benchmarks.timing import Row, median
from layerjam.workshop.commands.show import show
from layerjam.workshop.commands.sweep import sweep
from layerjam.workshop.design.search import Search
from layerjam.workshop.design.specification import read_spec

SPEC = """
name = "ten million"
brake = "choi2018-kapton"
line = "choi2018"
constraints = ["holding_force >= 300 N", "mass <= 30 g", "stress_margin >= 2"]
objectives = ["minimise mass", "maximise energy_capacity"]

[[film]]
use = "choi2018-kapton"
thickness = ["25.4 um", "50.8 um", "76.2 um", "127 um"]

[judder]
speed = "1 mm/s"
mass = "0.5 kg"
damping_ratio = 0.05

[vary]
count = { from = 5, to = 44, step = 1 }
width = { from = "10 mm", to = "30 mm", step = "0.4 mm" }
overlap = { from = "40 mm", to = "80 mm", step = "1 mm" }
vacuum = { from = "40 kPa", to = "100 kPa", step = "2 kPa" }
"""
WANTED = 10_000_000


def rows() -> list[Row]:
    """Seconds for 10^7 designs; seconds for a sweep to disk; what Dask adds to it."""
    spec = read_spec(SPEC, "benchmark")
    search, size = Search(spec), spec.grid.size
    begun = time.perf_counter()
    search.run_all()
    cold = time.perf_counter() - begun
    warm = median(search.run_all, 3)
    each = median(lambda: [show("choi2018-kapton") for _ in range(20)], 3) / 20
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    scale = WANTED / size
    here, there, stored = _sweeps()
    return [
        Row(f"10^7 designs, all merits, by {size / 1e6:.1f}e6", warm * scale, 10.0,
            each * WANTED, "`show` one by one, by 20"),
        Row("the same, compiling in it", cold * scale),
        Row("memory so far at the most", peak, 2.0, unit="GB"),
        Row("sweep of 10^9 to disk, by the same", here * 1e9 / size),
        Row("on disk, 10^9", stored * 1e9 / size / 1e9, 1.0, unit="GB"),
        Row("the sweep by Dask, two local workers", there, None, here, "here", target_ratio=1.1),
    ]  # fmt: skip


def _sweeps() -> tuple[float, float, float]:
    """(seconds here, seconds by two local workers, bytes), workers warm."""
    import distributed

    with tempfile.TemporaryDirectory() as folder:
        spec = Path(folder) / "spec.toml"
        spec.write_text(SPEC, encoding="utf-8")

        def timed(name: str, **how: str) -> tuple[float, float]:
            begun = time.perf_counter()
            made = sweep(spec, out=Path(folder) / name, **how)
            return time.perf_counter() - begun, float(made.values["bytes"])

        here, stored = sorted(timed(f"here{i}") for i in range(3))[1]
        with distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=None
        ) as cluster:
            timed("warm", scheduler=cluster.scheduler_address)
            runs = [timed(f"there{i}", scheduler=cluster.scheduler_address) for i in range(3)]
        return here, sorted(runs)[1][0], stored
