"""A vented chamber that a pump evacuates, and that may then leak: NumPy only, no part of layerjam.

The logger starts while the chamber is vented. The pump lowers the pressure exponentially to its
ultimate pressure. A valve then may close, and the pressure returns exponentially to that of the
atmosphere. The gauge has noise and a zero error.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ATMOSPHERE = 101.325


@dataclass(frozen=True, kw_only=True)
class Chamber:
    """One log; pressures in kPa, times in s."""

    vented: float = 5.0
    pump: float = 0.5
    """Time constant of the evacuation."""
    pumped: float = 5.0
    """Duration of the evacuation."""
    ultimate: float = 15.0
    leak: float = 400.0
    """Time constant of the leak."""
    held: float = 100.0
    """Duration of the hold; 0 if the log ends while the pump runs."""
    rate: float = 10.0
    noise: float = 0.05
    zero: float = 0.0
    atmosphere: float = ATMOSPHERE
    kind: str = "gauge"

    def record(self, seed: int) -> tuple[Array, Array]:
        """Return times [s] and readings [kPa], shape (N,), in the reference `kind`."""
        time = np.arange(0.0, self.vented + self.pumped + self.held, 1 / self.rate)
        running = np.clip(time - self.vented, 0.0, self.pumped)
        excess = (self.atmosphere - self.ultimate) * np.exp(-running / self.pump)
        pressure = self.ultimate + excess
        closed = np.maximum(time - self.vented - self.pumped, 0.0)
        gap = (pressure - self.atmosphere) * np.exp(-closed / self.leak)
        noise = self.noise * np.random.default_rng(seed).standard_normal(len(time))
        reading = {"gauge": gap, "vacuum": -gap, "absolute": gap + self.atmosphere}[self.kind]
        return time, reading + self.zero + noise

    def write(self, path: Path, seed: int, keep: Any = slice(None)) -> Path:
        """Write the samples `keep` of the log as a CSV file."""
        name = {"gauge": "Gauge pressure", "vacuum": "Vacuum", "absolute": "Absolute pressure"}
        time, reading = (values[keep] for values in self.record(seed))
        rows = [f"{t:.4f},{p:.4f}" for t, p in zip(time, reading, strict=True)]
        path.write_text("\n".join([f"Time (s),{name[self.kind]} (kPa)", *rows, ""]), "utf-8")
        return path


def draw(random: np.random.Generator, **numbers: Any) -> Chamber:
    """Return a healthy chamber with random numbers; `numbers` are given."""
    drawn = {
        "vented": random.uniform(1, 10),
        "pump": random.uniform(0.2, 3),
        "ultimate": random.uniform(3, 40),
        "rate": float(random.choice([5, 10, 20, 50])),
        "noise": random.uniform(0.01, 0.15),
        "kind": str(random.choice(["gauge", "vacuum", "absolute"])),
    }
    drawn["pumped"] = 6 * drawn["pump"]
    return Chamber(**{**drawn, **numbers})
