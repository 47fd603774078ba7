"""Ctrl-C: always a word and 130, also while compiled modules are being loaded."""

from __future__ import annotations

import signal
import time

import pytest

from layerjam.brake.mechanics import tracing
from layerjam.cli import generate, interrupts

from .conftest import Run

pytestmark = pytest.mark.timing


def test_a_stop_is_said(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(generate, "handle_interrupts", stopped)
    for words in (("show", "choi2018-kapton"), ("show", "choi2018-ptfe", "--json")):
        ran = run(*words)
        assert (ran.code, ran.out, ran.err) == (130, "", "layerjam: stopped\n")


def test_an_interrupt_in_jaxs_garbage_callback_is_not_lost() -> None:
    """Python drops what is raised in a callback of the collector; the command would go on."""
    passed = []

    def _xla_gc_callback() -> None:
        signal.raise_signal(signal.SIGINT)
        passed.append("callback")

    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, interrupts._raise_interrupt)
    try:
        with pytest.raises(KeyboardInterrupt):
            _xla_gc_callback()
            for _ in range(500):
                time.sleep(0.01)
        assert passed == ["callback"]
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupt_amid_loading_waits_for_its_end() -> None:
    done = []
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # other tests may have left theirs
    try:
        with pytest.raises(KeyboardInterrupt), tracing._delay_interrupts():
            signal.raise_signal(signal.SIGINT)
            done.append("loaded")
        assert done == ["loaded"]
        assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_command_that_computes_listens_so() -> None:
    before = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        interrupts.handle_interrupts()
        assert signal.getsignal(signal.SIGINT) is interrupts._raise_interrupt
    finally:
        signal.signal(signal.SIGINT, before)
