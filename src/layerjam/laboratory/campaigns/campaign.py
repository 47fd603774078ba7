"""A campaign of the virtual laboratory: friction tests and pulls of brakes with known true values.

This module writes nothing (`campaign_files` does). `Campaign.traces` returns the records as if read
from files, so a study of thousands of campaigns needs no files.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from layerjam.core.brief import brief
from layerjam.core.errors import explain_arguments
from layerjam.core.evolve import evolve
from layerjam.laboratory.campaigns.plan import (
    Subject,
    Trial,
    plan_tests,
    pull_duration,
    sample_count,
)
from layerjam.laboratory.campaigns.spec import Spec, check_spec
from layerjam.laboratory.campaigns.text import read_spec
from layerjam.laboratory.campaigns.virtual_records import (
    group_pulls,
    simulate_friction_test,
    simulate_pulls,
)
from layerjam.laboratory.measure.trace import Trace

_CHUNK = 2_000_000
"""Number of samples that are simulated in one batch."""


@brief
@explain_arguments
@dataclass(frozen=True, kw_only=True)
class Campaign:
    """The tests of a campaign; `traces` simulates them."""

    spec: Spec
    subjects: tuple[Subject, ...]
    tests: tuple[Trial, ...]

    def traces(self, kind: str = "") -> list[Trace]:
        """Return the records in order; only those of `kind` ("pull" or "friction") if it is given.

        They contain the faults of the machine, but not the practice faults of files. Raises
        PrecisionError unless JAX is in double precision.
        """
        traces = {test.number: trace for test, trace in self.records(kind)}
        return [traces[number] for number in sorted(traces)]

    def records(self, kind: str = "") -> Iterator[tuple[Trial, Trace]]:
        """Yield tests with their records, in any order, from chunks that fit into memory.

        Raises QuantityError for an impossible pull.
        """
        sleds = [t for t in self.tests if t.kind == "friction" and kind in ("", "friction")]
        for test in sleds:
            yield test, simulate_friction_test(self.spec, test)
        for speed, tests in group_pulls(self.tests if kind in ("", "pull") else ()):
            count = sample_count(pull_duration(self.spec, speed), self.spec.machine)
            size = max(1, _CHUNK // count)
            for start in range(0, len(tests), size):
                chunk = tests[start : start + size]
                yield from zip(chunk, simulate_pulls(self.spec, chunk, count), strict=True)


def campaign(spec: Spec | str | Path, seed: int | None = None) -> Campaign:
    """Return the campaign of a spec or of a TOML file; `seed`, if given, replaces the spec's seed.

    Raises QuantityError or FileError for an invalid spec; nothing is simulated yet.
    """
    spec = spec if isinstance(spec, Spec) else read_spec(spec)
    spec = check_spec(spec if seed is None else evolve(spec, seed=seed))
    subjects, tests = plan_tests(spec)
    return Campaign(spec=spec, subjects=subjects, tests=tests)
