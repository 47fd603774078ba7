"""Photograph the workbench's first page for docs/workbench.md: python docs/images/workbench.py.

Needs Chromium, playwright and Pillow; writes workbench-light.png and workbench-dark.png beside this
file.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
SIZE = {"width": 1280, "height": 800}
COLORS = 128
"""Enough for flat areas and thin lines, and a fifth of the bytes."""


def main() -> None:
    """Both pictures."""
    program = Path(sys.executable).with_name("layerjam")
    words = [str(program), "workbench", "--no-show", "--port", "8099"]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        first = server.stdout.readline() if server.stdout is not None else ""
        address = first.split()[1]  # its first line ends with it
        with sync_playwright() as play:
            chromium = shutil.which("chromium")
            browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
            for theme in ("light", "dark"):
                page = browser.new_page(viewport=SIZE, color_scheme=theme)
                page.goto(address, timeout=120_000)
                page.locator("canvas").first.wait_for(timeout=120_000)
                page.wait_for_timeout(15_000)  # the brake turns into its place
                picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
                picture.quantize(COLORS).save(HERE / f"workbench-{theme}.png", optimize=True)
                page.close()
            browser.close()
    finally:
        server.terminate()
        server.wait(30)


if __name__ == "__main__":
    main()
