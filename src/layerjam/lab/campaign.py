"""A whole campaign of the virtual laboratory: friction tests and pulls from a stated truth.

Nothing is written here (`campaign_files` does): `Campaign.traces` gives the records as a perfect
reader would, so that a study over thousands of campaigns needs no files.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from layerjam.lab.plan import Subject, Trial, duration, planned, samples
from layerjam.lab.records import friction_trace, pull_traces, pulls_at_once
from layerjam.lab.spec import Spec, checked
from layerjam.lab.text import read_spec
from layerjam.measure.trace import Trace

_CHUNK = 2_000_000
"""Samples simulated at once."""


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """The tests of a campaign; `traces` simulates them."""

    spec: Spec
    subjects: tuple[Subject, ...]
    tests: tuple[Trial, ...]

    def traces(self, kind: str = "") -> list[Trace]:
        """The records in order, of one kind ("pull", "friction") if it is given.

        As a perfect reader would give them: faults of the machine are in, the practice faults of
        files are not. Needs JAX in double precision (PrecisionError).
        """
        made = {test.number: trace for test, trace in self.each(kind)}
        return [made[number] for number in sorted(made)]

    def each(self, kind: str = "") -> Iterator[tuple[Trial, Trace]]:
        """Tests with their records, some at a time, so that memory holds them; order as it comes.

        Raises QuantityError for a pull that cannot be.
        """
        sleds = [t for t in self.tests if t.kind == "friction" and kind in ("", "friction")]
        for test in sleds:
            yield test, friction_trace(self.spec, test)
        for speed, tests in pulls_at_once(self.tests if kind in ("", "pull") else ()):
            count = samples(duration(self.spec, speed), self.spec.machine)
            size = max(1, _CHUNK // count)
            for start in range(0, len(tests), size):
                some = tests[start : start + size]
                yield from zip(some, pull_traces(self.spec, some, count), strict=True)


def campaign(spec: Spec | str | Path, seed: int | None = None) -> Campaign:
    """The campaign of a spec, or of the path of its TOML file; `seed` instead of the spec's.

    Raises QuantityError or FileError for a spec that cannot be; nothing is simulated yet.
    """
    spec = spec if isinstance(spec, Spec) else read_spec(spec)
    spec = checked(spec if seed is None else replace(spec, seed=seed))
    subjects, tests = planned(spec)
    return Campaign(spec=spec, subjects=subjects, tests=tests)
