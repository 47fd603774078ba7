"""When Ctrl-C stops a command, and when its whole result is already appearing."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from layerjam.cli.interrupts import _raise_interrupt
from layerjam.core.drawing.folder import write_folder
from layerjam.core.store import Appearing


def test_an_interrupt_is_ignored_while_a_whole_folder_appears(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Appearing, "begun", False)
    with pytest.raises(KeyboardInterrupt):
        _raise_interrupt(signal.SIGINT, None)
    write_folder(tmp_path / "report", {"report.html": "<p>", "figures/one.svg": b"<svg/>"})
    _raise_interrupt(signal.SIGINT, None)
    assert len(list((tmp_path / "report").rglob("*.*"))) == 2
