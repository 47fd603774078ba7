"""A workbench that runs, and Debian's Chromium to look at it with."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def running(*options, folder=None, home=None, tell=subprocess.DEVNULL):
    """(address, process) of a workbench of its own; its temporary files go into `folder`.

    With an empty folder as `home`, it starts as in a fresh installation, without compiled code.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    program = str(Path(sys.executable).with_name("layerjam"))
    words = [program, "workbench", "--no-show", "--port", str(port), *options]
    plain = {k: v for k, v in os.environ.items() if not k.startswith(("PYTEST", "NICEGUI"))}
    if folder is not None:
        plain["TMPDIR"] = str(folder)
    if home is not None:
        plain |= {"HOME": str(home), "XDG_CACHE_HOME": str(home / "cache")}
    process = subprocess.Popen(words, env=plain, stdout=subprocess.PIPE, stderr=tell, text=True)
    try:
        said = process.stdout.readline().split()
        assert said, "the workbench ended"
        place = said[1].replace("0.0.0.0", "127.0.0.1")
        for _ in range(300):
            assert process.poll() is None, "the workbench ended"
            try:
                with urllib.request.urlopen(place, timeout=5):
                    break
            except urllib.error.HTTPError:
                break
            except OSError:
                time.sleep(0.1)
        yield place, process
    finally:
        process.terminate()
        process.wait(30)
        process.stdout.close()


@pytest.fixture(scope="session")
def workbench():
    """The address of a workbench; ended afterwards."""
    with running() as (place, _):
        yield place


@pytest.fixture(scope="module")
def chromium():
    """Debian's Chromium, driven by playwright; skips where either is missing.

    Not for the whole session: playwright keeps a loop running in this thread, and a test of
    another module that starts one of its own would fail.
    """
    api = pytest.importorskip("playwright.sync_api", reason="no playwright here")
    place = shutil.which("chromium")
    if place is None:
        pytest.skip("no chromium here")
    with api.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=place, args=["--no-sandbox"])
        yield browser
        browser.close()


@pytest.fixture
def tab(chromium, workbench):
    """A fresh tab at 1280 by 800 on the workbench; what its console calls an error fails a test."""
    page = chromium.new_page(viewport={"width": 1280, "height": 800})
    errors: list[str] = []
    page.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda e: errors.append(str(e)))
    page.goto(workbench)
    page.errors = errors
    yield page
    page.close()
