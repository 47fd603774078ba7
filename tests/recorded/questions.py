"""Brakes, files and inputs that several recorded questions share."""

from __future__ import annotations

from typing import Any

K, P, F, Y = (
    "choi2018-kapton",
    "choi2018-ptfe",
    "choi2018-ptfe-fiberglass",
    "choi2018-polyester",
)
OWN = ("aged.toml", "exponent.toml", "fan.toml", "speed-law.toml")
WINDOW = {"start": "15 mm", "end": "45 mm"}
PULL = {"vacuum": "52 kPa", "speed": "7 mm/s"}
STOP = {"mass": "1.3 kg", "travel": "35 mm"}
SAFE = {"safe_state": "release", "sensor_range": "103 kPa"}
PULLS = tuple(f"lab/pull_k_{v}kPa_7mms_{n}.{e}" for v in (40, 80) for n, e in
              ((1, "csv"), (2, "TRA"), (3, "txt")))  # fmt: skip
HELD = tuple(f"lab/friction_k_hold{h}s_{n}.{e}" for h, n, e in
             ((10, 1, "csv"), (10, 2, "TRA"), (100, 1, "txt"), (100, 2, "csv"),
              (1000, 1, "TRA"), (1000, 2, "txt")))  # fmt: skip
Question = tuple[str, tuple[Any, ...], dict[str, Any]]


def ask(command: str, *subjects: Any, **options: Any) -> Question:
    return command, subjects, options
