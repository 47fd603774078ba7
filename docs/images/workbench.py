"""Photograph the workbench's first page: python docs/images/workbench.py FILE.

Needs Chromium and playwright. Next to the picture, a JSON file lists its words and their places.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SIZE = {"width": 1280, "height": 800}
COLORS = 128
"""Enough for flat areas and thin lines, and a fifth of the bytes."""
TURN = 15_000
"""Time until the brake has turned into its place [ms]."""
WORDS = """() => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = []
  while (walker.nextNode()) {
    const node = walker.currentNode, range = document.createRange()
    range.selectNode(node)
    const box = range.getBoundingClientRect(), text = node.textContent.trim().replace(/\\s+/g, ' ')
    const shown = {opacityProperty: true, visibilityProperty: true}
    if (text && node.parentElement.checkVisibility(shown) && box.width && box.top < innerHeight)
      found.push([text, Math.round(box.left), Math.round(box.top)])
  }
  return found
}"""


@contextlib.contextmanager
def serve() -> Iterator[str]:
    """Start a workbench and yield its address."""
    program = Path(sys.executable).with_name("layerjam")
    words = [str(program), "workbench", "--no-show", "--port", "8099"]
    server = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    try:
        first = server.stdout.readline() if server.stdout is not None else ""
        yield first.split()[1]  # its first line ends with it
    finally:
        server.terminate()
        server.wait(30)


def photograph(browser: Any, address: str) -> tuple[bytes, list[Any]]:
    """Return the first page as PNG, and its words as (text, left, top) in pixels."""
    from PIL import Image

    page = browser.new_page(viewport=SIZE, color_scheme="light")
    page.goto(address, timeout=120_000)
    page.locator("canvas").first.wait_for(timeout=120_000)
    page.wait_for_timeout(TURN)
    picture, stored = Image.open(io.BytesIO(page.screenshot())).convert("RGB"), io.BytesIO()
    picture.quantize(COLORS).save(stored, "png", optimize=True)
    words = page.evaluate(WORDS)
    page.close()
    return stored.getvalue(), words


def main(path: Path) -> None:
    """Write the picture and its words, or a sentence if Chromium is not installed."""
    chromium = shutil.which("chromium")
    if chromium is None:
        print(f"{path.name} is not drawn: Chromium is not installed")
        return
    from playwright.sync_api import sync_playwright

    with serve() as address, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        picture, words = photograph(browser, address)
        browser.close()
    path.write_bytes(picture)
    rows = ",\n".join(f" {json.dumps(word, ensure_ascii=False)}" for word in words)
    path.with_suffix(".json").write_text(f"[\n{rows}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
