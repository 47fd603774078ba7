"""`layerjam bench status` and `bench serve`, as they are typed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from layerjam.cli.main import main
from rig.gateways import Client

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
    words = ["bench", "serve", "sim:choi2018", "--port", "0", "--pty", str(tmp_path / "bench")]
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
        assert (tmp_path / "bench").is_symlink()
        client.close()
        assert main(["bench", "status", f"tcp:{first['listening']}", "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["state"] == "SAFE"
    finally:
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 0 and "read_termination" in err
