"""Checks of a result, their levels, and the resulting verdict.

A failed check means that the numbers must not be used without a decision: the command line exits
with code 4 and writes nothing. A person may accept a failed check by name, with a reason. The
acceptance is stored in the file that is written, and every later command that reads this file
reports it.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from pathlib import PurePath
from typing import Any, Literal, Self

from layerjam.core.errors import Notice, QuantityError, UnknownNameError

Level = Literal["passed", "note", "warning", "failed"]
"""`note` needs no action, `warning` a review, `failed` a decision."""
FEWEST = 2
"""Number of files counted for an acceptance that does not state it: one file has no repeats."""
WIDEST = 0.5
"""Relative width of a 95 % interval above which the value counts as unknown."""


@dataclass(frozen=True, kw_only=True)
class Check:
    """One check: its name, its level, and the sentence that gives the reason.

    `value` and `limit` are in SI, in `unit`; None if the check has no number.
    """

    name: str
    level: Level = "passed"
    passed: bool = field(init=False)
    sentence: str
    value: float | None = None
    limit: float | None = None
    unit: str = "1"

    def __post_init__(self) -> None:
        object.__setattr__(self, "passed", self.level == "passed")


def check(
    name: str, passed: bool, sentence: str, otherwise: str = "", level: Level = "warning"
) -> Check:
    """Return a check; `level` and the additional text `otherwise` apply if it does not pass."""
    if passed:
        return Check(name=name, sentence=sentence)
    return Check(name=name, level=level, sentence=sentence + otherwise)


def interval_check(name: str, value: float, low: float, high: float) -> Check:
    """Return the check of a 95 % interval of a quantity that must be positive.

    It fails if the interval reaches zero or is wider than half of the value (`WIDEST`).
    """
    share = (high - low) / value if value > 0 else math.inf
    fails = not (low > 0 and share <= WIDEST)
    sentence = f"the width of the 95 % interval of {name} is {share:.2g} of its value"
    if not low > 0:
        sentence += "; the interval reaches zero"
    return Check(
        name=f"{name} interval",
        level="failed" if fails else "passed",
        sentence=sentence + (": the measurements do not determine it" if fails else ""),
        value=share if math.isfinite(share) else None,
        limit=WIDEST,
    )


@dataclass(frozen=True, kw_only=True)
class Acceptance:
    """A person's decision to use numbers although a check failed.

    `finding` is the sentence of the check, `date` is ISO 8601, and `file` stores the acceptance.
    `numbers` are the dotted paths of the numbers that it concerns (if empty, all in the file), and
    `files` is the number of measurements from which they follow; 0 if unknown.
    """

    check: str
    reason: str
    date: str
    finding: str = ""
    numbers: tuple[str, ...] = ()
    files: int = 0
    file: str = ""

    @classmethod
    def read(cls, row: Any) -> Self:
        """Return the acceptance in an [[accepted]] table; QuantityError for an invalid table."""
        texts = ("check", "reason", "date")
        row = row if isinstance(row, dict) else {}
        numbers, files = row.get("numbers", []), row.get("files", 0)
        if (
            set(row) - {*texts, "finding", "numbers", "files"}
            or not all(isinstance(row.get(key), str) and row[key].strip() for key in texts)
            or not isinstance(row.get("finding", ""), str)
            or not isinstance(numbers, list)
            or not all(isinstance(path, str) for path in numbers)
            or not (isinstance(files, int) and files >= 0)
        ):
            raise QuantityError.of(
                "accepted",
                "each [[accepted]] table contains the texts check, reason and date, and "
                "optionally finding, a list of numbers, and the number of files",
            )
        return cls.of_row({**row, "numbers": numbers})

    @classmethod
    def of_row(cls, row: Mapping[str, Any]) -> Self:
        """Return the acceptance in a row of a JSON result."""
        return cls(**{**row, "numbers": tuple(row["numbers"])})

    def to_toml(self) -> dict[str, Any]:
        """Return the table for a file; empty entries are left out."""
        row = {**asdict(self), "numbers": list(self.numbers)}
        del row["file"]
        return {key: entry for key, entry in row.items() if entry}

    def notice(self) -> Notice:
        """Return one line about the acceptance, for every command that reads its file."""
        place = PurePath(self.file).name if self.file else "this file"
        finding = f" ({self.finding})" if self.finding else ""
        return Notice(
            f"{place} has numbers whose check '{self.check}' failed{finding}; accepted on "
            f"{self.date}: {self.reason}",
            "accepted",
        )


def remaining(
    earlier: Iterable[Acceptance], new: "Verdict | None" = None, removals: Collection[str] = ()
) -> tuple[Acceptance, ...]:
    """Return the acceptances that still apply after a measurement with the verdict `new`.

    An acceptance of a number ends if the number is measured again from at least as many files and
    passes. It also ends if the same check is accepted again, or if the number is one of `removals`.
    """
    result = []
    for entry in earlier:
        ends = {*removals} if new is None else {*removals, *new.replaced_numbers(entry)}
        numbers = tuple(path for path in entry.numbers if path not in ends)
        if numbers or not entry.numbers:
            result.append(replace(entry, numbers=numbers))
    return tuple(result)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """Outcome of all checks of a result; `decisions` are the failed checks that were accepted.

    `numbers` are the dotted paths of the numbers that the checks concern, and `files` is the number
    of measurements from which they follow.
    """

    checks: tuple[Check, ...] = ()
    decisions: tuple[Acceptance, ...] = ()
    numbers: tuple[str, ...] = ()
    files: int = 0

    @property
    def failed(self) -> tuple[Check, ...]:
        """Failed checks that were not accepted."""
        exempt = {to_key(entry.check) for entry in self.decisions}
        return tuple(c for c in self.checks if c.level == "failed" and to_key(c.name) not in exempt)

    @property
    def verdict(self) -> str:
        """`failed`, `accepted` or `passed`."""
        return "failed" if self.failed else "accepted" if self.decisions else "passed"

    @property
    def failed_checks(self) -> list[dict[str, str]]:
        """Rows of `name` and `reason` of the failed checks, in the form of the JSON."""
        return [{"name": c.name, "reason": c.sentence} for c in self.failed]

    @property
    def accepted(self) -> list[dict[str, Any]]:
        """Rows of `check`, `reason`, `date` and `file` of the accepted checks."""
        return accepted_rows(self.decisions)

    def replaced_numbers(self, entry: Acceptance) -> tuple[str, ...]:
        """Return the numbers for which this verdict replaces an earlier acceptance."""
        if self.failed:
            return ()
        if not self.decisions:
            return self.numbers if self.files >= (entry.files or FEWEST) else ()
        name = _own_name(entry.check)
        same_name_numbers = (new.numbers for new in self.decisions if _own_name(new.check) == name)
        return tuple(path for numbers in same_name_numbers for path in numbers)

    def notices(self) -> list[Notice]:
        """Return one line for each accepted check of numbers that a file may store."""
        return [] if self.failed else [entry.notice() for entry in self.decisions]


def judge(
    checks: Iterable[Check | None],
    accept: Mapping[str, str] | None = None,
    numbers: Sequence[str] = (),
    file: object = "",
    date: str | None = None,
    files: int = 0,
) -> Verdict:
    """Return the verdict on some checks, given {name of a failed check: reason to accept it}.

    `numbers` are the dotted paths of the numbers that the checks concern, and `files` is the number
    of measurements from which they follow. `file` is the file that will store the acceptances.
    `date` (ISO) is today unless given. Raises UnknownNameError for a name that is not among the
    checks, and QuantityError for a check that has not failed.
    """
    results = tuple(c for c in checks if c is not None)
    names = {to_key(c.name): c.name for c in results}
    decisions = []
    for name, reason in (accept or {}).items():
        if to_key(name) not in names:
            raise UnknownNameError("check", name, names.values(), quantity="accept")
        failures = [c for c in results if to_key(c.name) == to_key(name) and c.level == "failed"]
        if not failures:
            failing = sorted({c.name for c in results if c.level == "failed"})
            detail = f"failed: {', '.join(failing)}" if failing else "no check failed"
            raise QuantityError.of(
                "accept", f"check '{names[to_key(name)]}' has not failed; {detail}"
            )
        decisions.append(
            Acceptance(
                check=failures[0].name,
                reason=reason,
                date=date or datetime.now(UTC).date().isoformat(),
                finding="; ".join(dict.fromkeys(c.sentence for c in failures)),
                numbers=tuple(numbers),
                files=files,
                file=str(file or ""),
            )
        )
    return Verdict(checks=results, decisions=tuple(decisions), numbers=tuple(numbers), files=files)


def read_acceptances(source: Any) -> dict[str, str]:
    """Return {check: reason} from a mapping, or from texts such as `repeats=new operator`.

    Raises QuantityError for a text without a name or a reason, and for a check named twice.
    """
    if isinstance(source, Mapping):
        rows = [(str(name), str(reason)) for name, reason in source.items()]
    else:
        texts = [source] if isinstance(source, str) else [str(text) for text in source]
        rows = [(name, reason) for name, _, reason in (text.partition("=") for text in texts)]
    reasons: dict[str, str] = {}
    for name, reason in rows:
        if not name.strip() or not reason.strip():
            raise QuantityError.of(
                "accept",
                f"'{name[:60]}' needs a check and a reason: --accept \"CHECK=REASON\"",
            )
        if to_key(name) in map(to_key, reasons):
            raise QuantityError.of("accept", f"check '{name.strip()}' is named twice")
        reasons[name.strip()] = reason.strip()
    return reasons


def accepted_rows(decisions: Iterable[Acceptance]) -> list[dict[str, Any]]:
    """Return acceptances as rows of a JSON result."""
    return [{**asdict(entry), "numbers": list(entry.numbers)} for entry in decisions]


def list_failures(*results: Any) -> list[str]:
    """Return a sentence for each failed check of some results, accepted or not, for exports."""
    texts = []
    for result in results:
        texts += [f"check '{row['name']}' failed: {row['reason']}" for row in result.failed_checks]
        texts += [str(Acceptance.of_row(row).notice()) for row in result.accepted]
    return list(dict.fromkeys(texts))


def _own_name(check: str) -> str:
    """Return a check's name without the stage that a report adds, as a key."""
    return to_key(check.rpartition(".")[2])


def to_key(name: str) -> str:
    """Return a check's name as used for comparison: without case, hyphens and underscores."""
    return " ".join(name.lower().replace("-", " ").replace("_", " ").split())
