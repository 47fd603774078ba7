"""`layerjam bench status`, `serve`, `clear` and `zero`, as they are typed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import pytest

from bench.rig.boards import law_words, regulator
from bench.rig.gateways import Client, gateway
from layerjam.cli.main import main

KEYS = {
    "identity", "simulated", "state", "fault", "vacuum", "target", "pump", "vent", "safe_state",
    "vent_rest", "lease", "boot", "reset_cause", "uptime", "late_ticks", "worst_lateness",
    "samples_lost", "law_matches", "double", "zero_age", "errors",
}  # fmt: skip


def test_status(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "status", "sim:choi2018", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert set(said) >= KEYS
    assert said["simulated"] and said["law_matches"] and said["state"] == "SAFE"
    assert (said["safe_state"], said["fault"], said["lease"], said["errors"]) == (None, None, 2, [])
    assert said["units"]["vacuum"] == "Pa"


@pytest.mark.parametrize("address", ["choi2018", "sim:nobody", "tcp:127.0.0.1:1", "usb:1"])
def test_no_such_bench(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "status", address]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("layerjam: ") and err.count("\n") == 1


def test_serve_says_where_and_ends_with_zero(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = "import sys; from layerjam.cli.main import main; sys.exit(main(sys.argv[1:]))"
    has_terminals = sys.platform != "win32"
    words = ["bench", "serve", "sim:choi2018", "--port", "0"]
    words += ["--pty", str(tmp_path / "bench")] if has_terminals else []
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ},
    )  # fmt: skip
    try:
        assert process.stdout is not None
        first = json.loads(process.stdout.readline())
        assert first["pid"] == process.pid and first["address"] == "sim:choi2018"
        host, _, port = first["listening"].rpartition(":")
        client = Client(int(port))
        assert host == "127.0.0.1" and client.ask("*IDN?").count(",") == 3
        assert (tmp_path / "bench").is_symlink() is has_terminals
        client.close()
        assert main(["bench", "status", f"tcp:{first['listening']}", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["state"] == "SAFE"
    finally:
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
    assert "read_termination" in err
    if has_terminals:  # SIGTERM ends a process on Windows before it can react
        assert process.returncode == 0


def test_clear_leaves_a_fault(capsys: pytest.CaptureFixture[str]) -> None:
    """A silent client trips the board; `bench clear` names the fault and leads to SAFE."""
    with gateway("sim:choi2018") as (number, _):
        client = Client(number)
        client.send("OUTP:SAFE REL;VENT:REST OPEN")
        client.send("CONT:LAW " + law_words(regulator()))
        client.send("SYST:LEAS 0.2;:VAC 20 kPa;:OUTP ON")
        assert client.error() == 0
        time.sleep(0.5)
        assert client.ask("FETC:ALL?").split(",")[5] == "FAULT"
        for fault in ("LEASE_EXPIRED", None):
            assert main(["bench", "clear", f"tcp:127.0.0.1:{number}", "--json"]) == 0
            answer = json.loads(capsys.readouterr().out)
            assert (answer["fault"], answer["state"], answer["simulated"]) == (fault, "SAFE", True)
        client.close()


def test_zero_is_measured_shown_and_stored(capsys: pytest.CaptureFixture[str]) -> None:
    """An offset of 700 Pa of the sensor, which the test sets, is measured, taken away and dated."""
    with gateway("sim:choi2018?noise=50Pa&speed=5") as (number, _):
        client = Client(number)
        client.send("OUTP:SAFE REL;VENT:REST OPEN")
        client.send("CONT:LAW " + law_words(regulator()))
        client.send("SENS:VAC:CAL -700,1,'bench 7 \"left\"'")
        assert client.error() == 0
        assert main(["bench", "zero", f"tcp:127.0.0.1:{number}", "--json"]) == 0
        answer = json.loads(capsys.readouterr().out)
        assert answer["zero"] == pytest.approx(700, abs=20) and 0 <= answer["zero_scatter"] < 80
        assert answer["sensor_offset"] == pytest.approx(0, abs=20)
        today = datetime.now(UTC).date().isoformat()
        assert answer["date"] == today and answer["units"]["zero"] == "Pa"
        offset, gain, name = client.ask("SENS:VAC:CAL?").split(",", 2)
        assert float(offset) == pytest.approx(answer["sensor_offset"], abs=1e-3) and gain == "1"
        assert name == f'"bench 7 ""left""; zero {today}"'
        assert client.ask("SYST:SETT:COUN?") == "1"
        client.send("SENS:VAC:CAL -9000,1,'x'")
        assert main(["bench", "zero", f"tcp:127.0.0.1:{number}"]) == 2
        assert "5 % of the sensor's range" in capsys.readouterr().err
        client.close()
