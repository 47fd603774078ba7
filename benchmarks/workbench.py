"""The workbench in Debian's Chromium: from a slider's key to the redrawn curve, start, memory.

Run alone: `python -m benchmarks.workbench`. `--moves 3 --scene regulated` tries it quickly, and
`--page docs/contribute.md` replaces the table there.
"""

from __future__ import annotations

import argparse
import datetime
import itertools
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.first_page import LONG, at, first_numbers, started
from benchmarks.timing import Row, number_text
from layerjam.workbench.state import State, format_link

MOVES = 200
PAUSE = 0.2
"""Seconds between two moves: no move waits for the one before it."""
GONE = 14.0
"""Seconds after which the server has let go of a tab: it waits ten for it to come back."""
MEDIAN, WORST = 0.05, 0.15
HEAD = "<!-- workbench -->\n"
SESSIONS = 10


@dataclass(frozen=True)
class Scene:
    """A slider and the chart that it redraws, or the words that follow it where there is no chart.

    `setting` is what is set on the tab; `ready` brings the page there. With `along` the slider goes
    from one end to the other, else it goes to and fro.
    """

    name: str
    tab: str
    slider: str
    ready: Callable[[Any], None]
    chart: str = ""
    words: str = ""
    setting: Mapping[str, Any] = field(default_factory=dict)
    along: bool = False

    @property
    def watched(self) -> str:
        """What is looked at."""
        return self.chart or self.words


def pull_ready(page: Any) -> None:
    """The first curve stands."""
    page.wait_for_function(
        "document.querySelector('[data-testid=pull-peak_force]')?.innerText.length > 2",
        timeout=LONG,
    )


def files_ready(page: Any) -> None:
    """Two measured pulls lie over it."""
    from layerjam.brake.commands.tensile import tensile
    from layerjam.workbench.answer import file_bytes

    pull_ready(page)
    with tempfile.TemporaryDirectory() as folder:
        places = []
        for vacuum in ("60 kPa", "94 kPa"):
            made = tensile("choi2018-kapton", vacuum=vacuum, speed="1 mm/s", travel="30 mm")
            place = Path(folder) / f"pull-{vacuum[:2]}.csv"
            place.write_bytes(file_bytes(made, "csv"))
            places.append(str(place))
        page.locator(".files-dropped input[type=file]").first.set_input_files(places)
        page.click(at("dropped-use"), timeout=LONG)
        page.click(at("tab-pull"))
        page.wait_for_selector(at("pull-errors"), timeout=LONG)


def drop_ready(page: Any) -> None:
    """The drop is judged."""
    page.wait_for_function(
        "document.querySelector('[data-testid=drop-verdict]')?.innerText.length > 2",
        timeout=LONG,
    )


def drop_scene(name: str, **setting: Any) -> Scene:
    """Drops of 0.1 to 10 kg."""
    setting = {"mass": 0.1, "speed": 1.5, **setting}
    return Scene(f"Drop, mass, {name}", "drop", "drop-mass", drop_ready, "drop-chart",
                 setting=setting, along=True)  # fmt: skip


def drawn_first(ident: str) -> Callable[[Any], None]:
    """The chart of that name stands."""

    def ready(page: Any) -> None:
        page.wait_for_selector(f"{at(ident)} canvas", timeout=LONG)

    return ready


def told_first(ident: str) -> Callable[[Any], None]:
    """There is a number."""

    def ready(page: Any) -> None:
        page.wait_for_function(
            "place => document.querySelector(place)?.innerText.length > 2",
            arg=at(ident), timeout=LONG,
        )  # fmt: skip

    return ready


def regulated(page: Any) -> None:
    """A safe state is chosen, the regulator has answered."""
    page.locator(at("vacuum-safe_state")).get_by_text("hold", exact=True).click()
    drawn_first("vacuum-loop")(page)


SCENES = (
    Scene("Start, vacuum", "start", "start-vacuum", drawn_first("start-chart"), "start-chart"),
    # of the numbers, only this one differs after each step
    Scene("Brake, slip", "brake", "brake-slip", told_first("brake-force"),
          words="brake-enclosure_force", along=True),
    Scene("Pull, vacuum", "pull", "pull-vacuum", pull_ready, "pull-chart"),
    Scene("Pull, elongation", "pull", "pull-travel", pull_ready, "pull-chart"),
    Scene("Pull, sheet by sheet", "pull", "pull-vacuum", pull_ready, "pull-chart",
          setting={"model": "stack"}),
    Scene("Pull, stick–slip, speed", "pull", "pull-speed", drawn_first("pull-chart"), "pull-chart",
          setting={"model": "judder"}, along=True),
    Scene("Pull, vacuum, two files over it", "pull", "pull-vacuum", files_ready, "pull-chart"),
    Scene("Drop, speed", "drop", "drop-speed", drop_ready, "drop-chart"),
    drop_scene("no brake", shown="none"),
    drop_scene("full vacuum", shown="full"),
    drop_scene("tuned", shown="tuned"),
    drop_scene("30 kPa", shown="value", vacuum=30e3),
    drop_scene("no rope", shown="full", on_rope="none"),
    Scene("Vacuum, target", "vacuum", "vacuum-target", drawn_first("vacuum-chart"), "vacuum-chart"),
    Scene("Vacuum, target, regulated", "vacuum", "vacuum-target", regulated, "vacuum-loop"),
    Scene("Arrays, vacuum", "design", "design-vacuum", drawn_first("design-array-chart"),
          "design-array-chart", setting={"part": "arrays"}),
    Scene("Force over mass, vacuum", "design", "design-ours", drawn_first("design-density-chart"),
          "design-density-chart", setting={"part": "density"}),
)  # fmt: skip
MODELS = ("sheet by sheet", "stick–slip", "lumped")

# from the key to the frame after the chart has rendered what it was given since; of moves that
# overtake each other, the first counts
WATCH = """(place) => {
  const chart = getElement(+document.querySelector(place).id.slice(1)).chart;
  window.took = []; window.drawn = new Set();
  let began = null, given = false;
  const set = chart.setOption.bind(chart);
  chart.setOption = (...all) => { given = true; return set(...all); };
  addEventListener('keydown', e => {
    if (began === null) { began = e.timeStamp; given = false; }
  }, true);
  chart.on('rendered', () => {
    if (began === null || !given) return;
    const since = began; began = null;
    requestAnimationFrame(() => {
      took.push(performance.now() - since);
      drawn.add(JSON.stringify(chart.getOption().series.map(one => one.data)));
    });
  });
}"""
# the same of words
READ = """(place) => {
  window.took = []; window.drawn = new Set();
  let began = null;
  addEventListener('keydown', e => { if (began === null) began = e.timeStamp; }, true);
  const words = document.querySelector(place);
  new MutationObserver(() => {
    if (began === null) return;
    const since = began; began = null;
    requestAnimationFrame(() => {
      took.push(performance.now() - since);
      drawn.add(words.innerText);
    });
  }).observe(words, {childList: true, characterData: true, subtree: true});
}"""


def opened(browser: Any, place: str, scene: Scene) -> Any:
    """A tab of its own session, ready and watched, its slider in focus."""
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    state = State(page=scene.tab, settings={scene.tab: dict(scene.setting)})
    page.goto(f"{place}?s={format_link(state)}")
    scene.ready(page)
    page.wait_for_timeout(1500)
    page.evaluate(WATCH if scene.chart else READ, at(scene.watched))
    page.locator(f"{at(scene.slider)} [tabindex='0']").first.focus()
    return page


def latencies(
    page: Any, moves: int = MOVES, pause: float = PAUSE, along: bool = False
) -> list[float]:
    """Sorted seconds of single key presses on the slider, each drawn before the next."""
    page.evaluate("took.length = 0; drawn.clear()")
    for move in range(moves):
        left = not along and move % 40 < 20
        page.keyboard.press("ArrowLeft" if left else "ArrowRight")
        page.wait_for_function(f"took.length > {move}", timeout=LONG)
        page.wait_for_timeout(1e3 * pause)
    if page.evaluate("drawn.size") < min(moves // 2, 15):
        raise RuntimeError("the curve stands still while the slider moves")
    return sorted(t / 1e3 for t in page.evaluate("took"))


def after_models(browser: Any, place: str) -> dict[str, float]:
    """{model: seconds of the first move of the vacuum after the pull was given that model}."""
    page = opened(browser, place, next(s for s in SCENES if s.slider == "pull-vacuum"))
    slider = page.locator(f"{at('pull-vacuum')} [tabindex='0']").first
    took = {}
    for model in MODELS:
        page.locator(at("pull-model")).get_by_text(model, exact=True).click()
        page.wait_for_timeout(5000)
        slider.focus()
        took[model] = latencies(page, 1, 0.0)[0]
    page.context.close()
    return took


def middle(times: list[float]) -> float:
    """The median."""
    return times[len(times) // 2]


@contextmanager
def others(place: str, count: int) -> Iterator[None]:
    """So many more sessions that move their slider all the time, on other people's machines."""
    program = [sys.executable, "-m", "benchmarks.sessions", place, str(count), str(PAUSE)]
    with subprocess.Popen(
        program, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        if process.stdout.readline().strip() != "ready":
            raise RuntimeError("the other sessions could not begin")
        yield
        process.stdin.close()
        moved, answered = (int(word) for word in process.stdout.read().split())
        if answered < 0.5 * moved:
            raise RuntimeError(f"the others moved {moved} times and were answered {answered} times")


def alone_and_among(browser: Any, place: str, scene: Scene) -> tuple[float, float]:
    """Median seconds of a move in the only session, and in one of several that all move."""
    page = opened(browser, place, scene)
    one = middle(latencies(page, 60))
    with others(place, SESSIONS - 1):
        many = middle(latencies(page, 60))
    page.context.close()
    return one, many


def memory(process: int) -> float:
    """GB of main memory a process holds."""
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return float(line.split()[1]) * 1024 / 1e9
    return float("nan")


def all_pages(page: Any, place: str) -> None:
    """Open every tab once."""
    page.goto(place)
    page.wait_for_selector(at("start-chart"), timeout=LONG)
    for tab in page.locator("[data-testid^=tab-]").all():
        tab.click()
        page.wait_for_timeout(4000)


def rows(moves: int = MOVES, only: str = "") -> list[Row]:
    """Everything, or the scenes whose names match `only`; no rows where there is no browser."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        print("skipped: no playwright here", file=sys.stderr)
        return []
    chromium = shutil.which("chromium")
    if chromium is None:
        print("skipped: no chromium here", file=sys.stderr)
        return []
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        out = [] if only else first_numbers(browser)
        with started() as (place, *_):
            for scene in SCENES:
                if re.search(only, scene.name):
                    out += scene_rows(browser, place, scene, moves)
            if not only:
                out += session_rows(browser, place)
        if not only:
            out += memory_rows(browser)
        browser.close()
    return out


def scene_rows(browser: Any, place: str, scene: Scene, moves: int) -> list[Row]:
    """Median and slowest of a scene's moves; a scene that fails has no rows."""
    try:
        page = opened(browser, place, scene)
        took = latencies(page, moves, along=scene.along)
        page.context.close()
    except Exception as error:  # the other scenes are still measured
        print(f"{scene.name}: failed: {error}", file=sys.stderr, flush=True)
        return []
    rows = [
        Row(f"{scene.name}: median of {moves}", middle(took), MEDIAN),
        Row(f"{scene.name}: slowest", took[-1], WORST),
    ]
    print(*(f"{row.name} {1e3 * row.value:.0f} ms" for row in rows), sep="; ", file=sys.stderr)
    return rows


def session_rows(browser: Any, place: str) -> list[Row]:
    """First moves after a change of the model, and a move among several sessions."""
    firsts = after_models(browser, place).items()
    out = [Row(f"first move after the model {model}", first, 0.5) for model, first in firsts]
    scene = next(s for s in SCENES if s.slider == "pull-vacuum")
    one, ten = alone_and_among(browser, place, scene)
    name = f"a move, {SESSIONS} sessions moving at once"
    return [*out, Row(name, ten, None, one, "one alone", target_ratio=2.0)]


def memory_rows(browser: Any) -> list[Row]:
    """Main memory of the server at its start, in use and afterwards."""
    with started() as (place, process, _):
        out = [Row("memory at the start", memory(process), 0.5, unit="GB")]
        page = browser.new_context().new_page()
        all_pages(page, place)
        out.append(Row("memory, every page opened once", memory(process), None, unit="GB"))
        page.context.close()
        time.sleep(GONE)
        out.append(Row("memory once the tab is closed", memory(process), 0.5, unit="GB"))
    return out


def measured_text(row: Row) -> str:
    """A value, and whether it misses its aim."""
    over = "" if row.target is None or row.value <= row.target else ", missed"
    return f"{number_text(row.value, row.unit)}{over}"


def scene_table(measured: list[Row]) -> str:
    """A line for each scene: its median and its slowest move."""
    pairs = [two for two in itertools.pairwise(measured) if two[1].name.endswith(": slowest")]
    head = pairs[0][0].name.partition(": ")[2] if pairs else "median"
    aims = f"≤ {number_text(MEDIAN, 's')} | ≤ {number_text(WORST, 's')}"
    text = f"| scene | {head} | slowest |\n|---|---|---|\n| aim | {aims} |\n"
    for middle_row, last in pairs:
        name = last.name.removesuffix(": slowest")
        text += f"| {name} | {measured_text(middle_row)} | {measured_text(last)} |\n"
    return text


def markdown(measured: list[Row], load: float) -> str:
    """The rows as tables for a page, with date and load of the machine."""
    day = datetime.date.today().isoformat()
    text = f"{day}, load {load:.1f} on {os.cpu_count()} cores before the first scene.\n\n"
    text += scene_table(measured) + "\n| what | measured | aim |\n|---|---|---|\n"
    for row in measured:
        if ": " in row.name:
            continue
        aim = "" if row.target is None else f"≤ {number_text(row.target, row.unit)}"
        ratio = "" if row.other is None else f", {row.value / row.other:.2f} times {row.other_name}"
        text += f"| {row.name} | {measured_text(row)}{ratio} | {aim} |\n"
    return text


def main() -> None:
    """Measure, print the table, and write it into a page if asked to."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--moves", type=int, default=MOVES, help="moves a scene")
    parser.add_argument("--scene", default="", help="only the scenes that match this expression")
    parser.add_argument("--page", type=Path, help="page whose table is replaced")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    text = markdown(rows(options.moves, options.scene), load)
    print(text)
    if options.page is not None:
        before, _, rest = options.page.read_text("utf-8").partition(HEAD)
        after = rest.partition(HEAD)[2]
        options.page.write_text(f"{before}{HEAD}\n{text}\n{HEAD}{after}", "utf-8")


if __name__ == "__main__":
    os.environ["JAX_ENABLE_X64"] = "1"
    main()
