"""The frame around the pages: tabs, brake and line, undo, link, copying, light and dark."""

import html
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace

from nicegui import run, ui

from layerjam.brake.figures import device_drawing
from layerjam.core.errors import LayerjamError
from layerjam.laboratory.identify.origin import describe_origin
from layerjam.workbench.call import disambiguate, python_code
from layerjam.workbench.copying import copy_text, show_copy
from layerjam.workbench.desk import Desk, forget_desk, move_files
from layerjam.workbench.dropping import Dropping
from layerjam.workbench.memory import forget_tab
from layerjam.workbench.page import Page
from layerjam.workbench.pages.all import Tab
from layerjam.workbench.session import ENDING, format_session, read_kept_files
from layerjam.workbench.state import LONGEST_LINK, format_link, parse_link
from layerjam.workbench.widgets import button, dress, read_asset, status

# animated panels move away while the user clicks them
ui.expansion.default_props("duration=0")

SCRIPTS = (
    "workbench.js",
    "controls.js",
    "view.js",
    "chart.js",
    "zoom.js",
    "narrow.js",
    "peak.js",
    "files.js",
    "sheets.js",
)
"""Scripts loaded once, at the end of the page's body."""
LONG_LINK = 2000
"""Number of characters above which mail programs may truncate a link."""
ICON = "flat round dense size=13px color=none"
DARK = "matchMedia('(prefers-color-scheme: dark)').matches"


def make_desk(link: str) -> tuple[Desk, str]:
    """Return the desk for a link, or a new desk and the reason why the link was rejected."""
    if not link:
        return Desk(), ""
    try:
        return Desk(parse_link(link)), ""
    except LayerjamError as err:
        return Desk(), str(err)


def build_frame(link: str, tabs: Sequence[Tab], prepare: Callable[[], None]) -> None:
    """Build the pages of a browser tab; a thread calls `prepare` before any computation.

    Pages are loaded and built when they are first opened.
    """
    desk, trouble = make_desk(link)
    kinds = {tab.name: tab for tab in tabs}
    if desk.state.page not in kinds:
        desk.state = replace(desk.state, page=tabs[0].name)
    pages: dict[str, Page] = {}
    _add_assets()
    dark = ui.dark_mode(None)
    heads = _build_header(desk, tabs, pages, dark)
    _show_preparation(desk, prepare)
    with (
        ui.tab_panels(heads, value=desk.state.page, animated=False)
        .classes("w-full")
        .props("keep-alive") as panels
    ):
        slots = {name: ui.tab_panel(name).classes("p-0") for name in kinds}
    client = ui.context.client
    client.on_delete(forget_tab)
    client.on_delete(lambda: forget_desk(desk))

    def show_page(name: str) -> None:
        if name in kinds:  # a session may name a page of a different version
            panels.set_value(name)

    desk.show_tab = show_page

    def load_page(tab: Tab) -> type[Page]:
        if not tab.light:
            prepare()
        return tab.load()

    async def open_tab(name: str) -> None:
        ui.run_javascript(f"layerjamPage({name!r})")
        desk.open(name)
        if name not in pages:
            kind = await run.io_bound(load_page, kinds[name])
            if kind is None or client.is_deleted:  # the program or the tab is closed
                return
            if name not in pages:
                pages[name] = kind(desk)
                pages[name].prepare = prepare
        pages[name].dark = bool(dark.value)
        with slots[name]:
            pages[name].open()
        ui.run_javascript("document.getElementById('first-look')?.remove()")

    panels.on_value_change(lambda e: open_tab(str(e.value)))
    Dropping(desk, show_page)
    _follow_address(desk)
    ui.on("layerjam_undo", desk.undo)
    ui.on("layerjam_redo", desk.redo)
    if trouble:
        ui.notify(trouble, type="warning", timeout=8000, close_button=True)

    async def start_tab() -> None:
        try:
            system = bool(await ui.run_javascript(DARK, timeout=2.0))
        except TimeoutError:
            system = False
        dark.set_value(system)
        move_files(client, desk)
        await open_tab(desk.state.page)

    ui.timer(0.01, start_tab, once=True)


def _add_assets() -> None:
    """Add the styles, scripts and colours of all pages."""
    for style in ("utilities.css", "workbench.css"):
        ui.add_css(read_asset(style))
    ui.add_css(device_drawing.read_asset("brake_drawing.css"))
    for script in SCRIPTS:
        ui.add_body_html(f"<script>{read_asset(script)}</script>")
    ui.colors(primary="#0B5C8E", negative="#B3261E", positive="#1E7A37")


FIRST_LOOK = """<div id="first-look"><div class="frame-head"></div>
<div class="frame-preparing">{text}</div><div class="figure frame-brake">
<svg class="drawing" data-testid="frame-brake" role="img" aria-label="{label}"></svg></div></div>
<script>{script}
drawBrake(document.querySelector('#first-look svg'), {shape}, 0, 0);</script>"""
"""HTML with the brake's drawing, which the browser shows before it has loaded any code."""


def _show_preparation(desk: Desk, prepare: Callable[[], None]) -> None:
    """Show the brake, and the current step of the preparation until it is done."""
    text: str = getattr(prepare, "text", "")
    if not text:
        return
    look = FIRST_LOOK.format(
        text=text,
        label=html.escape(f"{desk.brake.name}, from the side and from above"),
        script=device_drawing.read_asset("brake_drawing.js"),
        shape=json.dumps(asdict(device_drawing.make_shape(desk.brake.brake))),
    )
    ui.add_body_html(look)
    line = status("preparing", "frame-preparing", text)

    def update() -> None:
        line.set_text(current := getattr(prepare, "text", ""))
        if not current:
            timer.cancel()
            line.set_visibility(False)

    timer = ui.timer(0.1, update)


def _build_header(
    desk: Desk, tabs: Sequence[Tab], pages: dict[str, Page], dark: ui.dark_mode
) -> ui.tabs:
    with ui.header().classes("frame-head"):
        ui.label("layerjam").classes("frame-name")
        _build_brake_choice(desk)
        with ui.tabs().classes("frame-tabs").props("dense no-caps") as heads:
            for tab in tabs:
                dress(ui.tab(tab.name, label=tab.title), f"tab-{tab.name}")
        with ui.row().classes("items-center gap-0 no-wrap frame-acts"):
            _add_button("undo", "Undo (Ctrl+Z)", desk.undo)
            _add_button("redo", "Redo (Ctrl+Shift+Z)", desk.redo)
            _add_button("link", "Copy a link to all settings", lambda: _copy_link(desk))
            _build_session_buttons(desk)
            _add_button("terminal", "Copy as command", lambda: _copy_code(desk, pages, "command"))
            _add_button("code", "Copy as Python", lambda: _copy_code(desk, pages, "python"))

            def toggle_dark() -> None:
                dark.set_value(not dark.value)
                for page in pages.values():
                    page.dark = bool(dark.value)
                    page.refresh()

            _add_button("contrast", "Light or dark", toggle_dark)
    return heads


CHECKED = {"passed": "passed", "accepted": "failed check"}
"""{verdict on a brake file's numbers: text in the header}."""


def _build_brake_choice(desk: Desk) -> None:
    """Show the brake that all pages use, with the origin of its numbers and the verdict on them."""
    look = "flat no-caps dense color=none"
    with dress(
        ui.button(on_click=lambda: desk.show_tab("brake")), "brake-here", "brake-here", look
    ):
        source = dress(ui.label(), "", "brake-here-source")
        name = dress(ui.label(), "brake-here-name", "brake-here-name")
        word = dress(ui.label(), "brake-here-origin", "brake-here-origin")
        verdict = dress(ui.label(), "brake-here-verdict", "brake-here-origin")
        tip = ui.tooltip("")

    def show_brake(change: str) -> None:
        if change in ("brake", "undo"):
            file, is_listed = desk.brake, desk.brake_subject().file is None
            came = describe_origin(file)
            title = file.title if is_listed and file.title else file.name
            source.set_text(title.rpartition(", ")[0])
            name.set_text(title.rpartition(", ")[2])
            word.set_text(came.word)
            decisions = [str(decision.notice()) for decision in file.accepted]
            tip.set_text(". ".join([f"{file.name}: {came.sentence}", *decisions]))
            verdict.set_text(CHECKED.get(file.verdict or "", ""))
            verdict.set_visibility(file.verdict is not None)
            if decisions:
                verdict.classes("brake-here-failed")
            else:
                verdict.classes(remove="brake-here-failed")

    desk.add_watcher(show_brake)
    show_brake("brake")


def _add_button(icon: str, label: str, act: Callable[[], object]) -> None:
    name = re.split(r" \(|:", label, maxsplit=1)[0].lower().replace(" ", "-")
    dress(button("", act, name, icon, look=ICON, tip=label), aria_label=label)


def _build_session_buttons(desk: Desk) -> None:
    async def save_session() -> None:
        try:
            text = await run.io_bound(session_text, desk)
        except LayerjamError as err:
            ui.notify(str(err), type="warning")
            return
        if text is not None:  # None means that the program is stopping
            name = f"{desk.brake.name}-session{ENDING}"
            ui.download.content(text.encode(), name, "application/json")

    _add_button("save", "Save the session: all settings in one file", save_session)
    choose = button("", None, "open-a-session", "folder_open", look=ICON, tip="Open a session")
    dress(choose, aria_label="Open a session").on("click", js_handler="() => layerjamPick()")


async def _copy_code(desk: Desk, pages: dict[str, Page], language: str) -> None:
    page = pages.get(desk.state.page)
    try:
        calls, pinned_calls = ([], {}) if page is None else page.calls_to_copy()
        export = disambiguate(calls, pinned_calls if language == "python" else {})
        text = "\n".join(c.command_line() for c in export.calls)
        if language == "python":
            text = python_code(export.calls, export.pinned_calls)
    except LayerjamError as err:
        ui.notify(str(err), type="warning")
        return
    await show_copy(text, "python" if language == "python" else "bash", export.texts)


def session_text(desk: Desk) -> str:
    """Return the text of a session file, with all settings and the files in use."""
    state = desk.state.without_files({file.key for file in desk.files.files_in_use})
    return format_session(state, read_kept_files(desk.files))


async def _copy_link(desk: Desk) -> None:
    count = len(desk.files.files_in_use)
    lacks = ""
    if count:
        files = "your file is" if count == 1 else f"your {count} files are"
        lacks = f". A link cannot contain files, so {files} not included: save a session instead"
    length = len(format_link(desk.state))
    if length > LONG_LINK:
        lacks += f". Mail programs may truncate its {length} characters: save the session instead"
    if await copy_text("window.location.href"):
        ui.notify(f"Link copied; it contains all settings{lacks}")
    else:
        advice = (
            "Your browser does not allow this page to copy text. The address bar shows the link"
        )
        ui.notify(advice + lacks, type="warning")


def _follow_address(desk: Desk) -> None:
    """Update the address bar once the state stops changing; Back opens the previous page."""
    ui.on("layerjam_page", lambda e: desk.show_tab(str(e.args)))
    last_link = last = desk.state

    def follow_state() -> None:
        nonlocal last_link, last
        rests, last = desk.state is last, desk.state
        if not rests or last is last_link:
            return
        last_link, link = last, format_link(last)
        if len(link) <= LONGEST_LINK:
            ui.run_javascript(
                "const u = new URL(window.location); u.searchParams.set('s', "
                f"'{link}'); history.replaceState(history.state, '', u)"
            )

    ui.timer(0.5, follow_state)
