"""State and links, undo, calls and what is copied, the gate, the runner."""

from __future__ import annotations

import asyncio
import base64
import json
import socket
import subprocess
import sys
import zlib
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.units import QuantitySpec
from layerjam.workbench import live
from layerjam.workbench.answer import try_call
from layerjam.workbench.call import Call, Subject
from layerjam.workbench.charts import POINTS, thin_points
from layerjam.workbench.controls import Control, read_number
from layerjam.workbench.desk import Desk
from layerjam.workbench.page import Page
from layerjam.workbench.pages.all import TABS
from layerjam.workbench.runner import ComputationStopped, Part, Runner
from layerjam.workbench.server import LOCAL, RequestGuard, check_address, is_loopback
from layerjam.workbench.state import LARGEST, State, format_link, parse_link
from printed import split_command

WORD = st.text(max_size=20)
VALUE = st.one_of(WORD, st.booleans(), st.floats(allow_nan=False, allow_infinity=False))


@given(st.dictionaries(WORD, st.dictionaries(WORD, VALUE, min_size=1, max_size=4), max_size=4))
def test_a_link_brings_everything_back(settings):
    state = State(page="pull", brake="choi2018-ptfe", beside="choi2018-kapton", settings=settings)
    assert parse_link(format_link(state)) == state


@given(st.text(max_size=300))
def test_rubbish_is_no_link(text):
    try:
        parse_link(text)
    except QuantityError as err:
        assert "link:" in str(err)


def packed(plain: bytes) -> str:
    return base64.urlsafe_b64encode(zlib.compress(plain, 9)).decode()


@pytest.mark.parametrize(
    "text",
    [
        packed(b"0" * (LARGEST + 1)),
        packed(b"[1, 2]"),
        packed(b'{"page": 3}'),
        packed(b'{"settings": {"pull": {"vacuum": NaN}}}'),
        packed(b'{"settings": {"pull": {"vacuum": [1]}}}'),
        packed(b'{"settings": [1]}'),
        packed(b"[" * 100_000),
        "A" * 40_000,
    ],
)
def test_a_link_of_the_wrong_kind_is_refused(text):
    with pytest.raises(QuantityError, match="link:"):
        parse_link(text)


def test_a_link_never_opens_a_path():
    for brake in ("/etc/passwd", "../secret.toml", "choi2018-capton"):
        with pytest.raises(LayerjamError, match="catalogue"):
            Desk(State(brake=brake))
        with pytest.raises(LayerjamError, match="catalogue"):
            Desk(State(line=brake))


def test_undo_takes_back_one_step_and_redo_brings_it_again(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("layerjam.workbench.desk.time.monotonic", lambda: now[0])
    desk, told = Desk(), []
    desk.add_watcher(told.append)
    for value in (1.0, 2.0, 3.0):  # one drag
        now[0] += 0.1
        desk.put_setting("pull", "vacuum", value)
    now[0] += 10
    desk.put_setting("pull", "vacuum", 9.0)
    desk.put_brake("choi2018-ptfe")
    assert (desk.brake.name, desk.get("pull", "vacuum", 0)) == ("choi2018-ptfe", 9.0)
    assert desk.undo() and desk.brake.name == "choi2018-kapton"
    assert desk.undo() and desk.get("pull", "vacuum", 0.0) == 3.0
    assert desk.undo() and desk.get("pull", "vacuum", 0.0) == 0.0
    assert not desk.undo()
    assert desk.redo() and desk.redo() and desk.redo()
    assert (desk.brake.name, desk.get("pull", "vacuum", 0)) == ("choi2018-ptfe", 9.0)
    assert not desk.redo()
    assert "undo" in told and "brake" in told
    with pytest.raises(LayerjamError):
        desk.put_brake("name = 3\n")
    assert desk.brake.name == "choi2018-ptfe"


def test_a_value_of_a_link_that_is_out_of_bounds_does_not_count():
    control = Control("vacuum", QuantitySpec("Pa", "vacuum", 0.0, 1e5), 5e4, 0.0, 1e5)
    for bad in (-1.0, 2e5, "x", True):
        desk = Desk(State(settings={"pull": {"vacuum": bad}}))
        assert read_number(desk, "pull", control) == 5e4
    assert read_number(Desk(State(settings={"pull": {"vacuum": 7e4}})), "pull", control) == 7e4


@pytest.mark.slow
def test_the_command_that_is_copied_gives_the_same_numbers(tmp_path):
    call = Call(
        "tensile", (Subject("choi2018-kapton"),),
        {"vacuum": "60 kPa", "speed": "1 mm/s", "elongation": "30 mm"},
    )  # fmt: skip
    shown = call.run()
    words = [
        sys.executable,
        "-m",
        "layerjam.cli.main",
        *split_command(call.command_line())[1:],
        "--json",
    ]
    said = subprocess.run(words, capture_output=True, text=True, check=True, cwd=tmp_path)
    assert json.loads(said.stdout)["peak_force"] == shown.peak_force


def test_flags_and_quotes_of_a_command():
    call = Call("drop", (Subject("my brake.toml"),), {"no_brake": True, "horizontal": False})
    words = ["layerjam", "drop", "my brake.toml", "--no-brake"]
    assert split_command(call.command_line()) == words


def test_thin_keeps_extremes():
    import numpy as np

    x = np.linspace(0, 1, 20_000)
    y = np.sin(40 * x)
    y[7777], y[12345] = 5.0, np.nan
    made = thin_points(x, y)
    assert len(made) <= POINTS + 2
    assert max(b for _, b in made if b is not None) == 5.0
    assert made[0][0] == 0 and made[-1][0] == 1


def test_loopback():
    assert is_loopback("127.0.0.1") and is_loopback("::1") and is_loopback("localhost")
    assert not is_loopback("0.0.0.0") and not is_loopback("192.168.1.4")
    with pytest.raises(QuantityError, match="host"):
        is_loopback("example.org")


def test_where_nothing_can_listen_is_told_before_the_server_starts():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(QuantityError, match=f"port: {port} is in use"):
            check_address("127.0.0.1", port)
    check_address("127.0.0.1", port)
    with pytest.raises(QuantityError, match="not an address of this machine"):
        check_address("192.0.2.7", port)


def test_every_tab_has_its_page():
    for tab in TABS:
        assert tab.load().name == tab.name


def test_a_chart_is_sent_only_what_changed(monkeypatch):
    class Chart:
        def __init__(self):
            self.props, self.whole = {"options": {}}, 0

        @property
        def options(self):
            return self.props["options"]

        def update(self):
            self.whole += 1

    sent, chart = [], Chart()
    monkeypatch.setattr(
        live, "_queue_change", lambda element, kind, value: sent.append((kind, value))
    )

    def made(high, tooltip="a", curves=1):
        return {"xAxis": {"max": 4}, "tooltip": tooltip, "series": [{"data": [[0, high]]}] * curves}

    live.draw_chart(chart, made(1))
    assert (sent, chart.whole) == ([], 1)
    live.draw_chart(chart, made(2))
    assert (sent, chart.whole) == ([("charts", {"series": [{"data": [[0, 2]]}]})], 1)
    assert chart.options == made(2)
    live.draw_chart(chart, made(2, curves=2))
    live.draw_chart(chart, made(2, tooltip="b", curves=2))
    assert (len(sent), chart.whole) == (1, 3)


def through(gate, headers, query=b"", kind="http", body=(b"",), path="/"):
    """(messages sent, kinds of messages that the application got)."""
    sent, seen, parts = [], [], list(body)

    async def inside(scope, receive, send):
        while True:
            message = await receive()
            seen.append(message["type"])
            if message["type"] == "http.disconnect" or not message.get("more_body"):
                break
        if kind == "http":
            await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive():
        part = parts.pop(0) if parts else b""
        return {"type": "http.request", "body": part, "more_body": bool(parts)}

    async def send(message):
        sent.append(message)

    gate.app = inside
    raw = [(k.encode(), v.encode()) for k, v in headers.items()]
    scope = {"type": kind, "method": "GET", "path": path, "headers": raw, "query_string": query}
    asyncio.run(gate(scope, receive, send))
    return sent, seen


def status(sent):
    return next((m["status"] for m in sent if m["type"] == "http.response.start"), None)


def test_the_gate_on_loopback():
    gate = RequestGuard(None, token=None, largest=100, names=(*LOCAL, "127.0.0.2"))
    assert status(through(gate, {"host": "localhost:8321"})[0]) == 200
    assert status(through(gate, {"host": "[::1]:8321"})[0]) == 200
    assert status(through(gate, {"host": "127.0.0.2:8321"})[0]) == 200
    assert status(through(gate, {"host": "evil.example:8321"})[0]) == 403
    own = {"host": "127.0.0.1:8321", "origin": "http://127.0.0.1:8321"}
    assert status(through(gate, own)[0]) == 200
    other = {"host": "127.0.0.1:8321", "origin": "http://evil.example"}
    assert status(through(gate, other)[0]) == 403
    assert through(gate, other, kind="websocket")[0][0]["type"] == "websocket.close"
    assert status(through(gate, {"host": "localhost", "content-length": "101"})[0]) == 413
    sent, seen = through(gate, {"host": "localhost"}, body=[b"x" * 60, b"y" * 60, b"z"])
    assert status(sent) == 413 and len(seen) == 1


def test_no_other_page_may_hold_ours_or_lend_it_scripts():
    gate = RequestGuard(None, token=None, largest=100, names=LOCAL)
    for host in ("localhost", "evil.example"):
        headers = dict(through(gate, {"host": host})[0][0]["headers"])
        rules = headers[b"content-security-policy"].decode()
        assert "frame-ancestors 'none'" in rules and "http" not in rules and "*" not in rules
        assert headers[b"x-frame-options"] == b"DENY"


def test_the_gate_elsewhere_wants_the_token():
    gate = RequestGuard(None, token="secret", largest=100, names=None)
    host = {"host": "192.168.1.4:8321"}
    assert status(through(gate, host)[0]) == 401
    assert status(through(gate, host, b"token=wrong")[0]) == 401
    sent, seen = through(gate, host, b"token=secret&s=a%2Bb", path="//evil.example")
    headers = dict(sent[0]["headers"])
    assert status(sent) == 303 and not seen
    assert headers[b"location"] == b"/evil.example?s=a%2Bb"
    cookie = headers[b"set-cookie"].decode().lower()
    assert "httponly" in cookie and "samesite=strict" in cookie
    assert status(through(gate, {**host, "cookie": "layerjam=secret"})[0]) == 200
    assert status(through(gate, {**host, "cookie": "layerjam=other"})[0]) == 401
    assert through(gate, host, kind="websocket")[0][0]["code"] == 1008


def test_the_latest_inputs_win():
    """Ten questions while the first is computed: two computations, the last with the last input."""
    value, computed, shown = [0], [], []

    async def elsewhere(compute):
        await asyncio.sleep(0.02)
        return compute()

    def compute():
        computed.append(value[0])
        return value[0]

    async def scene():
        runner = Runner(compute, lambda result, problem: shown.append(result), elsewhere)
        first = asyncio.create_task(runner.request_result())
        for i in range(10):
            value[0] = i
            await asyncio.sleep(0)
            await runner.request_result()
        await first

    asyncio.run(scene())
    assert shown[-1] == 9 and len(computed) <= 3


def test_a_part_is_shown_first_and_the_rest_once_nobody_asks_again(monkeypatch):
    """The second request comes while the rest of the first waits, which nobody needs then."""
    value, seen = ["old"], []

    async def elsewhere(compute):
        return compute()

    def compute():
        now = value[0]
        # the first waits for the second request, however long that takes
        monkeypatch.setattr("layerjam.workbench.runner.PAUSE", {"old": 600.0, "new": 0.0}[now])
        return Part(f"part of {now}", lambda: f"all of {now}")

    async def scene():
        runner = Runner(
            compute, lambda result, problem: seen.append(result), elsewhere, seen.append
        )
        first = asyncio.create_task(runner.request_result())
        while not seen:
            await asyncio.sleep(0)
        value[0] = "new"
        await runner.request_result()
        await first

    asyncio.run(scene())
    assert seen == ["part of old", "part of new", "all of new"]


def test_after_a_stop_the_last_result_takes_the_place_of_a_part(monkeypatch):
    drawn = []

    class Numbers(Page):
        def draw(self, result):
            drawn.append(result)

        draw_part = draw

    tasks = SimpleNamespace(create=lambda task, name: task.close())
    monkeypatch.setattr("layerjam.workbench.page.background_tasks", tasks)
    page = Numbers(Desk(State()))
    page.client = SimpleNamespace(is_deleted=False)
    page._show([1.0], "")
    page._show_part([2.0])
    page._show(None, "stopped")
    page._show(None, "a wrong input, of which no part was shown")
    page._show_part([3.0])
    page._show([3.0, 4.0], "")
    assert drawn == [[1.0], [2.0], [1.0], [3.0], [3.0, 4.0]] and page.result == [3.0, 4.0]


def test_problems_are_words_and_a_stopped_run_says_so():
    shown = []

    async def elsewhere(compute):
        return compute()

    def scene(compute):
        runner = Runner(compute, lambda result, problem: shown.append((result, problem)), elsewhere)
        asyncio.run(runner.request_result())

    def refused():
        raise QuantityError("slip: 80 mm is beyond\nthe overlap")

    def stopped():
        raise ComputationStopped

    scene(refused)
    scene(stopped)
    assert shown == [(None, "slip: 80 mm is beyond the overlap"), (None, "stopped")]
    runner = Runner(lambda: None, lambda *_: None, elsewhere)
    runner.report_progress("fit", 0.5)
    runner.stop()
    with pytest.raises(ComputationStopped):
        runner.report_progress("fit", 0.6)


def test_an_error_stands_at_the_field_of_its_quantity():
    page = next(tab for tab in TABS if tab.name == "drop").load()(Desk(State(page="drop")))
    page.fields = {key: SimpleNamespace(error=None) for key in ("speed", "rope_stiffness")}
    answer = try_call(
        Call("drop", (Subject("choi2018-kapton"),), {"mass": 1.0, "speed": -1.0, "vacuum": 9e4})
    )
    page._show_problems([(answer.quantity, answer.refusal)])
    assert "-1" in page.fields["speed"].error and page.fields["rope_stiffness"].error is None
    page._show_problems([("rope stiffness", "rope stiffness: missing"), (None, "speed: quoted")])
    assert page.fields["speed"].error is None
    assert page.fields["rope_stiffness"].error == "rope stiffness: missing"


@given(st.floats(-1e4, 1e4))
def test_the_remedy_is_the_nearest_allowed_value(value):
    spec = QuantitySpec("m", "length", 0.002, 0.05)
    control = Control("length", spec, 0.01, 0.005, 0.04, "mm")
    nearest = control.nearest_value(f"{value:.6f} mm")
    assert nearest == pytest.approx(min(max(value * 1e-3, 0.002), 0.05), abs=1e-9)
    assert control.nearest_value("rubbish") is None
