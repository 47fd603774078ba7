"""Records the answers of all commands: `python -m recorded.record` in the folder `tests`."""

from __future__ import annotations

import contextlib
import json
import tempfile
from pathlib import Path

RECORD = Path(__file__).with_name("numbers.json")


def read_recorded() -> dict[str, dict[str, float | str]]:
    """Return {question: {key: recorded number or word}}."""
    known: dict[str, dict[str, float | str]] = json.loads(RECORD.read_text("utf-8"))
    return known


def record() -> None:
    """Answer every question and replace the record."""
    from recorded.cases import QUESTIONS, answer
    from recorded.files import write_files

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "files"
        write_files(folder)
        with contextlib.chdir(folder):
            made = {name: answer(question) for name, question in QUESTIONS.items()}
    for answers in made.values():
        for key, value in answers.items():
            answers[key] = float(f"{value:.10g}") if isinstance(value, float) else value
    text = json.dumps(made, indent=0, sort_keys=True, allow_nan=True)
    RECORD.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    record()
