"""The bench behind a page: what it may do, and that it lets go when the page is gone."""

from __future__ import annotations

import time

import pytest

from layerjam.brake.fluid.line_file import load_line
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.workbench.bench_session import (
    LEASE,
    PRESENT,
    Presence,
    Session,
    bench_regulator,
    hold_target,
    inject_fault,
)

pytestmark = pytest.mark.timing

ADDRESS, TARGET = "sim:choi2018?speed=20", 40e3


@pytest.fixture
def there():
    """Whether the page is there, as a list of one."""
    return [True]


@pytest.fixture
def session(there):
    made = Session.connect(ADDRESS, lambda: there[0], TARGET)
    made.regulator = bench_regulator(ADDRESS, load_line("choi2018"), TARGET, "release", "pi", 103e3)
    yield made
    made.close()
    assert made.wait_until_ended(10)


def until(session, what, seconds=20.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if session.looks and what(session.looks[-1]):
            return session.looks[-1]
        time.sleep(0.02)
    raise AssertionError(f"not within {seconds} s: {list(session.looks)[-1:]}")


def on(session):
    session.request_action(lambda b: hold_target(b, session.regulator, "open", TARGET)).result(10)


def test_it_holds_names_a_fault_and_records(session, tmp_path):
    session.request_action(lambda b: setattr(b, "lease", 60.0)).result(10)
    on(session)
    held = until(session, lambda look: look.vacuum and look.vacuum > 0.98 * TARGET)
    assert (held.state, held.fault, held.target) == ("RUN", None, TARGET)
    session.request_action(
        lambda b: inject_fault(b, "sensor-nan", session.regulator, TARGET)
    ).result(10)
    broken = until(session, lambda look: look.state == "FAULT")
    assert broken.fault == "NOT_A_NUMBER"
    session.request_action(lambda b: inject_fault(b, "none", session.regulator, TARGET)).result(10)
    session.request_action(lambda b: b.clear()).result(10)
    done = session.record_run("evacuate to 30 kPa; vent", tmp_path / "run.ljrun", {}).result(60)
    assert done.outcome == "FINISHED" and done.gaps == 0 and done.simulated


def test_a_refusal_is_told_and_the_session_goes_on(session):
    refused = session.request_action(lambda b: setattr(b, "output", True))
    with pytest.raises(LayerjamError, match="OUTP:SAFE"):
        refused.result(10)
    # nor does a mistake of ours leave the bench alone, or who asked without an answer
    with pytest.raises(ZeroDivisionError):
        session.request_action(lambda b: 1 / 0).result(10)
    assert session.request_action(lambda b: b.state).result(10) == "SAFE"
    with pytest.raises(QuantityError, match="target"):
        bench_regulator(ADDRESS, load_line("choi2018"), 103e3, "release", "pi", 103e3)


def test_a_page_that_is_gone_ends_its_procedure(session, there, tmp_path):
    on(session)
    session.request_action(lambda b: b.off()).result(10)
    running = session.record_run("evacuate to 30 kPa and hold 1000 s", tmp_path / "run.ljrun", {})
    until(session, lambda look: look.vacuum and look.vacuum > 25e3)
    there[0] = False
    assert running.result(30).outcome == "OPERATOR_STOPPED"


def test_presence_ends_soon_after_the_last_sign():
    now = [0.0]
    present = Presence(lambda: now[0])
    now[0] = 0.9 * PRESENT
    assert present()
    present.record_heartbeat()
    now[0] += 0.9 * PRESENT
    assert present()
    now[0] += 0.2 * PRESENT
    assert not present() and PRESENT < LEASE


@pytest.mark.slow
def test_a_closed_page_lets_go_within_the_lease(chromium, workbench):
    """Watched by another client of the same gateway, who must not keep it closed by asking."""
    from bench.rig.gateways import Client, gateway

    def at(ident):
        return f'[data-testid="{ident}"]'

    with gateway("sim:choi2018") as (port, _):
        watcher = Client(port)
        page = chromium.new_page(viewport={"width": 1280, "height": 800})
        page.goto(workbench)
        page.click(at("tab-bench"))
        page.wait_for_selector(at("bench-connect"), timeout=60_000)
        page.fill(at("bench-address"), f"tcp:127.0.0.1:{port}")
        page.click(at("bench-connect"))
        page.locator(at("bench-state"), has_text="Safe state").wait_for(timeout=60_000)
        page.click(at("bench-on"))
        page.locator(at("bench-safe_state-problem"), has_text="Choose the safe state").wait_for(
            timeout=30_000
        )
        page.locator(at("bench-safe_state")).get_by_text("release", exact=True).click()
        page.locator(at("bench-vent_rest")).get_by_text("open", exact=True).click()
        page.wait_for_timeout(500)
        page.click(at("bench-on"))
        end = time.monotonic() + 60
        while float(watcher.ask("MEAS:VAC?")) < 0.95 * TARGET:
            assert time.monotonic() < end, watcher.ask("FETC:ALL?")
            time.sleep(0.1)
        # as long as the page is there the bench holds, also longer than the lease
        time.sleep(1.5 * LEASE)
        assert watcher.ask("FETC:ALL?").split(",")[5] == "RUN"
        page.close()
        closed = time.monotonic()
        while watcher.ask("FETC:ALL?").split(",")[5] == "RUN":
            assert time.monotonic() - closed < LEASE + 0.5
            time.sleep(0.02)
        assert "LEASE_EXPIRED" in watcher.ask("OUTP:PROT:FAUL?")
        watcher.close()
