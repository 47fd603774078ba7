"""The gateway as strangers use it: sockets, a serial port, many at once, and bad manners."""

from __future__ import annotations

import contextlib
import os
import random
import select
import socket
import stat
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.rig.bad_lines import BAD
from bench.rig.boards import law_words, regulator
from bench.rig.gateways import Client, gateway
from layerjam.bench.rig import link
from layerjam.bench.rig.driver import InstrumentError, open_bench
from layerjam.bench.rig.serve import Listening, Splitter, serve
from layerjam.bench.rig.token import Door, make_token
from layerjam.core.errors import LayerjamError

termios = pytest.importorskip("termios", reason="this system has no pseudo-terminals")


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with gateway("sim:choi2018") as (number, _):
        yield number


@pytest.fixture
def client(port: int) -> Iterator[Client]:
    made = Client(port)
    yield made
    made.close()


@pytest.fixture(scope="module")
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[int, Path]]:
    """Port of a gateway with a token, and the file of the token."""
    file = tmp_path_factory.mktemp("guarded") / "token"
    with gateway("sim:choi2018", token_file=str(file)) as (number, _):
        yield number, file


def test_it_says_who_it_is(client: Client) -> None:
    maker, model, serial, version = client.ask("*IDN?").split(",")
    assert (maker, model, serial) == ("layerjam", "virtual bench", "SIM-choi2018")
    assert version.startswith("0.1/law-") and version.endswith("/double")
    assert client.ask(b"*OPC?\r") == "1"
    client.send("")
    client.send("\r")
    assert client.error() == 0


def test_bad_lines_have_their_numbers_through_the_gateway() -> None:
    """On a board of its own: what others have declared changes the reasons."""
    with gateway("sim:choi2018") as (number, _):
        client = Client(number)
        for line, code in BAD:
            client.send(line.encode("latin-1") if isinstance(line, str) else line)
            assert client.error() == code, line
        assert client.error() == 0
        client.close()


def test_commands_in_one_packet_and_one_command_in_many(client: Client) -> None:
    client.send("*ESE 5\n*ESE?\n*ESE 6;*ESE?")
    assert [client.file.readline() for _ in range(2)] == [b"5\n", b"6\n"]
    for letter in "*OPC?\n":
        client.socket.sendall(letter.encode())
        time.sleep(0.002)
    assert client.file.readline() == b"1\n"


@pytest.mark.parametrize("queries", [50, pytest.param(400, marks=pytest.mark.slow)])
def test_eight_clients_are_never_mixed_up(port: int, queries: int) -> None:
    """Mixed queries, with a mask of one's own that every answer carries."""
    wrong: list[str] = []

    def use(number: int) -> None:
        draw, client = random.Random(number), Client(port)
        client.send(f"*ESE {number}")
        for n in range(queries):
            kind = draw.randrange(4)
            if kind == 0:
                if client.ask("*ESE?") != str(number):
                    wrong.append(f"{number}: mask")
            elif kind == 1:
                if not client.ask("MEAS:VAC?").lstrip("-").replace(".", "").isdigit():
                    wrong.append(f"{number}: vacuum")
            elif kind == 2:
                client.send(f"FOO{number}")
                if not client.ask("SYST:ERR?").endswith(f'header;FOO{number}"'):
                    wrong.append(f"{number}: error")
            elif client.ask(f"*ESE?;*OPC?;*ESE {number};*ESE?") != f"{number};1;{number}":
                wrong.append(f"{number}: line {n}")
        client.close()

    threads = [threading.Thread(target=use, args=(n + 1,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_a_lock_ends_with_its_client(port: int) -> None:
    first, second = Client(port), Client(port)
    assert first.ask("SYST:LOCK:REQ?") == "1" and second.ask("SYST:LOCK:REQ?") == "0"
    second.send("SOUR:VAC 1")
    assert second.error() == -203
    second.send("OUTP OFF")
    assert second.error() == 0
    first.close()
    end = time.monotonic() + 5
    while second.ask("SYST:LOCK:REQ?") != "1" and time.monotonic() < end:
        time.sleep(0.01)
    assert second.ask("SYST:LOCK:OWN?") == '"SELF"'
    second.close()


def test_sessions_begin_afresh_and_are_fourteen(port: int) -> None:
    time.sleep(0.1)
    clients = [Client(port) for _ in range(14)]
    for number, made in enumerate(clients):
        assert made.ask("*ESE?") == "0", "what an earlier client left"
        made.send(f"*ESE {number};FOO")
    more = [Client(port) for _ in range(5)]
    for made in more:
        assert made.ask("*IDN?").startswith("layerjam")
        made.send("*ESE 1")
        assert "sessions are in use" in made.ask("SYST:ERR?")
        made.send("OUTP OFF")
        assert made.error() == 0
    assert [made.ask("*ESE?") for made in clients] == [str(n) for n in range(14)]
    clients.pop().close()
    time.sleep(0.1)
    assert more[0].ask("*ESE?") == "0", "a session that is free is given to who waits"
    for made in clients + more:
        made.close()
    time.sleep(0.1)
    again = Client(port)
    assert again.ask("*ESE?;:SYST:ERR?") == '0;0,"No error"'
    again.close()


def test_two_megabytes_without_an_end(port: int, client: Client) -> None:
    rude = Client(port)
    with contextlib.suppress(ConnectionError):
        rude.socket.sendall(b"A" * 2_000_000)
    assert rude.closed()
    rude.close()
    assert client.ask("*OPC?") == "1"


def test_a_client_that_never_reads_holds_nobody_up(port: int, client: Client) -> None:
    deaf = Client(port)
    deaf.socket.settimeout(0.2)
    with contextlib.suppress(OSError):
        for _ in range(3000):
            deaf.send("SYST:HELP:HEAD?;HEAD?;HEAD?")
    begun = time.monotonic()
    assert client.ask("*OPC?") == "1" and time.monotonic() - begun < 5
    deaf.close()


def test_blocks_are_whole(client: Client) -> None:
    time.sleep(0.3)
    for _ in range(50):
        client.send("FETC:STR? 20")
        assert client.file.read(2) == b"#3"
        size = int(client.file.read(3))
        assert size % 24 == 0 and len(client.file.read(size)) == size
        assert client.file.read(1) == b"\n"


def test_a_serial_port_and_an_end(tmp_path: Path) -> None:
    """Raw as a real one; SIGTERM switches off, ends with zero, and the link goes."""
    link = tmp_path / "bench"
    with gateway("sim:choi2018", pty=str(link)) as (number, process):
        port = os.open(link, os.O_RDWR | os.O_NOCTTY)
        assert not termios.tcgetattr(port)[3] & termios.ECHO

        def ask(text: bytes) -> bytes:
            os.write(port, text)
            said = b""
            while not said.endswith(b"\n"):
                assert select.select([port], [], [], 10)[0]
                said += os.read(port, 4096)
            return said

        assert ask(b"*IDN?\r\n").startswith(b"layerjam,virtual bench,")
        os.write(port, b"AT+GCAP\r\nATE0\r\n")  # a modem manager looks for a modem
        assert ask(b"SYST:ERR:COUN?\n") == b"2\n"
        client = Client(number)
        assert client.error() == 0
        client.send("OUTP:SAFE REL;VENT:REST OPEN")
        client.send("CONT:LAW " + law_words(regulator()))
        client.send("VAC 40 kPa;:OUTP ON;:SYST:LEAS 60")
        assert client.ask("OUTP?;:SYST:ERR?") == '1;0,"No error"'
        os.close(port)
        process.terminate()
        assert process.wait(20) == 0
        assert client.closed()
        client.close()
    assert not link.exists()


def test_one_port_is_served_once(port: int) -> None:
    with pytest.raises(LayerjamError, match=f"127.0.0.1:{port}"):
        serve("sim:choi2018", lambda at: None, port=port)


def test_others_only_with_a_token() -> None:
    with pytest.raises(LayerjamError, match="token"):
        serve("sim:choi2018", lambda at: None, port=0, host="0.0.0.0")


def test_a_token(tmp_path: Path) -> None:
    file = tmp_path / "token"
    with gateway("sim:choi2018", token_file=str(file)) as (number, _):
        token = file.read_text().strip()
        assert len(token) == 32 and stat.S_IMODE(file.stat().st_mode) == 0o600
        client = Client(number)
        assert (
            client.ask("*IDN?").startswith("layerjam") and client.ask("SYST:PASS:CEN:STAT?") == "0"
        )
        for line in ("MEAS:VAC?", "OUTP ON", "*IDN?;OUTP ON", "SYST:PASS:CEN 'wrong'"):
            client.send(line)
            assert client.error() == -203, line
        client.send("OUTP OFF")
        assert client.error() == 0
        client.send(f'SYST:PASS:CEN "{token}"')
        assert client.ask("SYST:PASS:CEN:STAT?") == "1" and client.error() == 0
        assert client.ask("MEAS:VAC?") != ""
        guesser, begun = Client(number), time.monotonic()
        for _ in range(5):
            guesser.send("SYST:PASS:CEN 'guess'")
        other = Client(number)
        assert other.ask("*IDN?").startswith("layerjam") and client.ask("*OPC?") == "1"
        assert time.monotonic() - begun < 1, "wrong tokens delay only their sender"
        assert guesser.closed() and time.monotonic() - begun > 0.2 + 0.4 + 0.8 + 1.6
        for made in (client, guesser, other):
            made.close()


def test_guests_take_no_session_and_off_is_always_heard(guarded: tuple[int, Path]) -> None:
    """Clients without the token neither fill the sessions nor keep outputs on."""
    number, file = guarded
    guests = [Client(number) for _ in range(40)]
    assert all(guest.ask("*IDN?") for guest in guests)
    with open_bench(f"tcp:127.0.0.1:{number}?token={file}") as bench:
        bench.safe_state, bench.vent_rest = "release", "open"
        bench.regulator = regulator()
        bench.target = 40e3
        for guest in guests[:2]:
            bench.output = True
            assert bench.output
            guest.send("OUTP OFF")
            assert guest.error() == 0 and not bench.output
    for guest in guests:
        guest.close()


def test_who_may_start_nothing_has_nothing_pending(guarded: tuple[int, Path]) -> None:
    """`*OPC?` without the token: 1 at once, though a capture waits, and for our driver a reason."""
    number, file = guarded
    address = f"tcp:127.0.0.1:{number}"
    with open_bench(f"{address}?token={file}") as bench:
        bench.tell("TRIG:SOUR BUS;:INIT")
        guest, begun = Client(number), time.monotonic()
        assert guest.ask("*OPC?") == "1" and time.monotonic() - begun < 3
        guest.send("*OPC?;:OUTP ON")
        assert guest.error() == -203
        assert bench.ask("FETC:ACC:STAT?").startswith("WAITING")
        with open_bench(address) as other, pytest.raises(InstrumentError) as refused:
            other.status()
        assert refused.value.code == -203 and 'CEN "token" first' in str(refused.value)
        assert "?token=FILE" in str(refused.value)
        guest.close()
        bench.tell("ABOR")


def test_a_token_file_of_another_gateway(guarded: tuple[int, Path], tmp_path: Path) -> None:
    other = tmp_path / "other"
    make_token(other)
    with pytest.raises(LayerjamError, match="a different token"):
        open_bench(f"tcp:127.0.0.1:{guarded[0]}?token={other}")


def test_a_guest_does_not_keep_a_silent_client_running(tmp_path: Path) -> None:
    """`*IDN?` without the token does not renew the lease of who fell silent."""
    file = tmp_path / "token"
    with gateway("sim:choi2018", token_file=str(file)) as (number, _):
        client, guest = Client(number), Client(number)
        client.send(f'SYST:PASS:CEN "{file.read_text().strip()}"')
        client.send("OUTP:SAFE REL;VENT:REST OPEN")
        client.send("CONT:LAW " + law_words(regulator()))
        client.send("VAC 40 kPa;:OUTP ON;:SYST:LEAS 1")
        assert client.ask("OUTP?;:SYST:ERR?") == '1;0,"No error"'
        end = time.monotonic() + 1.5
        while time.monotonic() < end:
            assert guest.ask("*IDN?")
            time.sleep(0.1)
        assert client.ask("OUTP:PROT:FAUL?") == '120,"LEASE_EXPIRED"'
        client.close()
        guest.close()


REQUESTS = (
    "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/plain\r\n\r\n",
    "GET /;:OUTP ON HTTP/1.1\r\n\r\n",
    "OUTP /ON HTTP/1.1\r\n\r\n",
    "\r\nPUT / HTTP/1.0\r\n\r\n",
    "POST /\r\n",
    "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    "\x00\x01\x00\x00!\x12\xa4B",
    '{"jsonrpc": "2.0"}\n',
)


@pytest.mark.parametrize("request_", REQUESTS)
def test_a_page_in_a_browser_cannot_command(port: int, client: Client, request_: str) -> None:
    """The body holds commands that are in order; nothing of it is executed."""
    client.send("SOUR:VAC 0;:OUTP:SAFE REL;VENT:REST OPEN")
    client.send("CONT:LAW " + law_words(regulator()))
    page = Client(port)
    with contextlib.suppress(ConnectionError):
        page.socket.sendall(request_.encode("latin-1") + b"\nSOUR:VAC 40 kPa;:OUTP ON\n*IDN?\n")
    assert page.closed()
    page.close()
    assert client.ask("SOUR:VAC?;:OUTP?") == "0;0"


def test_a_token_that_others_may_read_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "token"
    file.write_text("0" * 32)
    file.chmod(0o644)
    with pytest.raises(LayerjamError, match="chmod 600"):
        make_token(file)
    file.chmod(0o600)
    assert make_token(file) == "0" * 32
    file.write_text("short")
    with pytest.raises(LayerjamError, match="16 to 128"):
        make_token(file)


def test_the_door_counts_what_it_denied() -> None:
    door = Door("a" * 32)
    assert door.filter_line(b"syst:err?") == (True, b"")
    for _ in range(40):
        assert door.filter_line(b"OUTP ON") == (False, b"")
    said = [door.filter_line(b"SYST:ERR?") for _ in range(17)]
    assert [passes for passes, _ in said] == [False] * 16 + [True]
    assert door.filter_line(b"ABORt ;OUTP ON")[0] is False


def test_lines_are_cut_out_of_any_pieces() -> None:
    draw = random.Random(1)
    text = b"".join(b"x" * draw.choice([0, 1, 5, 1024, 1025, 3000]) + draw.choice([b"\n", b"\r\n"])
                    for _ in range(300))  # fmt: skip
    wanted = [line.rstrip(b"\r")[:1025] for line in text.split(b"\n")]
    wanted = [line for line in wanted if line]
    splitter, got, rest = Splitter(), [], text
    while rest:
        size = draw.randrange(1, 700)
        got += splitter.split_lines(rest[:size])
        rest = rest[size:]
    assert got == wanted


def test_the_line_to_paste_names_a_machine() -> None:
    at = Listening("0.0.0.0", 5025, "sim:x", "", 1, None)
    assert f"TCPIP::{socket.gethostname()}::5025::SOCKET" in at.visa_resource


def test_the_line_to_paste() -> None:
    at = Listening("127.0.0.1", 5025, "sim:x", "", 1, None)
    assert at.visa_resource == (
        'rm.open_resource("TCPIP::127.0.0.1::5025::SOCKET", '
        'read_termination="\\n", write_termination="\\n")'
    )


def test_a_client_that_waits_for_a_capture_holds_up_no_other(port: int) -> None:
    """*OPC? of one client: others are served, its own OFF is heard, and leaving ends the wait."""
    waiting, other = Client(port), Client(port)
    waiting.send("*CLS;TRIG:SOUR BUS;:INIT;*OPC?")
    waiting.send("*IDN?")
    assert other.ask("*IDN?").startswith("layerjam")
    assert other.ask("FETC:ACC:STAT?").startswith("WAITING")
    waiting.socket.settimeout(0.3)
    with pytest.raises(TimeoutError):
        waiting.socket.recv(1)
    waiting.socket.settimeout(10)
    waiting.send("ABOR")
    assert waiting.socket.makefile("rb").readline() == b"1\n"
    waiting.close()
    gone = Client(port)
    gone.send("INIT;*OPC?")
    while other.ask("FETC:ACC:STAT?").startswith("IDLE"):
        time.sleep(0.01)
    gone.close()
    other.send("*TRG")
    begun = time.monotonic()
    assert other.ask("*OPC?") == "1" and time.monotonic() - begun < 5
    assert other.ask("FETC:ACC:STAT?").startswith("DONE")
    other.close()


def test_lines_that_wait_are_limited(port: int) -> None:
    """A client that sends on while its line waits is disconnected before it fills the memory."""
    client = Client(port)
    client.send("*CLS;TRIG:SOUR BUS;:INIT;*OPC?")
    with pytest.raises(OSError, match=r"reset|[Bb]roken|closed|abort"):
        for _ in range(10_000):
            client.send("*IDN?")
            time.sleep(1e-4)
    client.close()
    other = Client(port)
    assert other.ask("*IDN?").startswith("layerjam")
    other.send("ABOR")
    other.close()


def test_our_driver_waits_too(port: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """On the board's own line and as a client, longer than for any other response."""
    with open_bench("sim:choi2018?speed=20") as bench:
        bench.tell("TRIG:SOUR IMM;:INIT")
        assert bench.ask("*OPC?;:FETC:ACC:STAT?").startswith("1;DONE")
    monkeypatch.setattr(link, "PATIENCE", 0.3)
    with open_bench(f"tcp:127.0.0.1:{port}") as bench:
        bench.tell("SENS:ACC:POST 1;:TRIG:SOUR IMM;:INIT")
        begun = time.monotonic()
        assert bench.ask("*OPC?;:FETC:ACC:STAT?").startswith("1;DONE")
        assert time.monotonic() - begun > 0.6
