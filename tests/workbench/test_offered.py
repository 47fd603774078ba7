"""Every input of the commands behind the pages is offered on one, or named here with a reason."""

from __future__ import annotations

import asyncio
import re

import pytest

from layerjam.core.command.declare import OutFile
from layerjam.workbench.call import parameters
from layerjam.workbench.desk import Desk
from layerjam.workbench.pages.all import TABS
from layerjam.workbench.pages.laboratory import BY_FILE
from layerjam.workbench.state import State
from workbench.standing import simulate_user

BEHIND = (
    ("brake", {"part": "brake"}, ("show", "force")),
    ("brake", {"part": "build"}, ("build",)),
    ("pull", {}, ("tensile", "pull", "validate")),
    ("pull", {"model": "judder"}, ("judder",)),
    ("drop", {}, ("drop", "tune")),
    ("vacuum", {}, ("rise", "regulate")),
    ("laboratory", {}, ("friction", "calibrate", "report", "lab")),
    ("design", {"part": "need"}, ("design",)),
    ("design", {"part": "arrays"}, ("array",)),
    ("design", {"part": "density"}, ("compare",)),
    ("design", {"part": "machines"}, ("scenario",)),
)
"""(page, what is set there, commands of which it then offers every input); other pages may use
them as well."""
FILES = "files are chosen, divided and corrected one by one on the page"
NAMED = {
    ("*", "out"): "the page downloads what the command writes",
    ("*", "overwrite"): "nothing of the user's is overwritten by a download",
    ("drop", "no_brake"): "the table's first column is it",
    ("drop", "vacuum"): "the choice of what is shown, and its slider",
    ("drop", "horizontal"): "the choice of the direction",
    ("tune", "horizontal"): "the choice of the direction",
    ("compare", "vacuum"): "the slider of the vacuum of ours",
    ("scenario", "names"): "the menu of the scenarios is it",
    ("friction", "brake"): "the brake on the desk",
    ("friction", "partial"): "always: what is refused is said beside its file",
    ("calibrate", "partial"): "always: what is refused is said beside its file",
    ("friction", "accept_stick_slip"): "the choice Stick–slip",
    ("report", "accept_stick_slip"): "the choice Stick–slip",
    ("validate", "accept"): "a validation on the page writes no file",
    ("design", "accept"): "a design whose check failed is not put on the desk",
    ("design", "number"): "a click on the front selects the design that is put on the desk",
    ("design", "interval"): "the page chooses the next brake to build, and shows its interval",
    ("report", "live"): "the page Brake saves a page that computes the brake",
    ("lab", "example"): "the practice files are the built-in campaign",
    ("lab", "seed"): "the practice files are the built-in campaign",
    ("pull", "start"): "one span does not fit all files of the page; the command line cuts them",
    ("pull", "end"): "one span does not fit all files of the page; the command line cuts them",
    ("pull", "accept"): "a pull on the page writes no file",
    **{
        (command, "tare"): "a page corrects no force by itself: the calibration fits its zero"
        for command in ("pull", "validate")
    },
    **{
        ("report", key): FILES
        for key in ("friction", "pulls", "validate", "calibrate_on", "holdout")
    },
    **{
        (command, key): FILES
        for command in ("pull", "validate", "friction", "calibrate", "report")
        for key in BY_FILE
        if key in parameters(command)
    },
}
"""{(command, or * for all; input): why it has no control of that name}."""


SAYING = ("label", "aria-label", "placeholder", "innerHTML")


async def controls_of(name, settings):
    """Names of every control of a page, and every text of it, tips included."""
    kind = next(tab for tab in TABS if tab.name == name).load()
    desk = Desk(State(page=name, settings={name: settings}))

    def built():
        page = kind(desk)
        page.refresh = lambda: None
        page.open()

    async with simulate_user(built) as user:
        await user.open("/")
        elements = user.client.elements.values()
        idents = [str(e.props.get("data-testid", "")) for e in elements]
        texts = [str(getattr(e, "text", "")) for e in elements]
        texts += [str(e.props.get(key, "")) for e in elements for key in SAYING]
    return {i.removeprefix(f"{name}-") for i in idents if i.startswith(f"{name}-")}, texts


def inputs(command):
    return [
        p.name
        for p in parameters(command).values()
        if not p.positional and p.is_offered and type(p.help) is not OutFile
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("page", "settings", "commands"), BEHIND)
def test_every_input_is_offered_or_named(page, settings, commands):
    shown, texts = asyncio.run(controls_of(page, settings))
    # a drawing names the page's colours, var(--grey)
    words = [re.sub(r"var\(--[\w-]+\)", "", text) for text in texts]
    flags = [text for text in words if re.search(r"(?<![\w-])--[a-z]", text)]
    assert flags == [], "a page names controls, not flags of the command line"
    lacking = [
        (command, key)
        for command in commands
        for key in inputs(command)
        if not {key, f"{key}-number", f"{key}-file"} & shown
        and not {(command, key), ("*", key)} & NAMED.keys()
    ]
    assert lacking == []


def test_what_is_named_exists():
    for command, key in NAMED:
        if command != "*":
            assert key in parameters(command), (command, key)


def test_every_page_computes_with_commands_that_a_page_offers_whole():
    known = {command for *_, commands in BEHIND for command in commands}
    for tab in TABS:
        page = tab.load()(Desk(State(page=tab.name)))
        assert {call.name for call in page.calls()} <= known, tab.name
