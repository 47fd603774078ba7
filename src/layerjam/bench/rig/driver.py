"""A bench in Python: properties in SI units. Each write checks the instrument's error queue."""

import math
import struct
import time
import zlib
from typing import Any, Self, TypeVar

import numpy as np

from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.board import law_hash
from layerjam.bench.rig.line import LineError
from layerjam.bench.rig.link import BoardLink, Link, open_link
from layerjam.bench.rig.outcomes import BenchStatus
from layerjam.bench.rig.telemetry import parse_records, read_payload
from layerjam.bench.rig.virtual_plant import VirtualPlant
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.units import QuantitySpec, check, parse

SAFE_STATES = {"release": "REL", "hold": "HOLD"}
VENT_RESTS = {"open": "OPEN", "closed": "CLOS"}
NO_NUMBER = 9.9e37
"""Number that represents NaN in SCPI."""
LEASE = QuantitySpec("s", "time that outputs stay on after the host goes silent", lo=0.2, hi=600)
TARGET = QuantitySpec("Pa", "vacuum to hold", lo=0.0, hi=1.2e5)


class InstrumentError(LayerjamError):
    """Raised if the instrument rejects a command; `code` is the SCPI number, which is negative."""

    key = "instrument"
    code: int

    def __init__(self, code: int, text: str, line: str) -> None:
        super().__init__(f"the instrument rejected '{line[:60]}': {text} ({code})")
        self.code = code


class TrippedError(LayerjamError):
    """Raised if the device reports a fault during a wait; `fault` is its name."""

    key = "tripped"
    fault: str

    def __init__(self, fault: str) -> None:
        super().__init__(
            f"the bench went to its safe state: {fault}; to clear it, run 'layerjam bench clear'"
        )
        self.fault = fault


class Bench:
    """An instrument, opened by `layerjam.bench.rig.open` and closed like a file.

    Outputs stay on only while a client communicates within the `lease`, as `wait` does. `events`
    collects the device errors from the queue.
    """

    def __init__(self, link: Link, address: Address) -> None:
        self._link = link
        self.address = address
        self.events: list[str] = []
        self._commanded = False
        answer, code, text = link.exchange("*IDN?")
        self.identity = answer.decode("ascii", "replace")
        while code:  # these errors are from the board's start, not from a command
            self.events.append(text)
            _, code, text = link.exchange("*OPT?")

    def ask(self, query: str) -> str:
        """Return the response to one SCPI query; raises InstrumentError if it is rejected."""
        return self._exchange(query).decode("ascii", "replace")

    def block(self, query: str) -> bytes:
        """Return the content of a definite-length block; raises InstrumentError."""
        return read_payload(self._exchange(query))

    def tell(self, line: str) -> None:
        """Send one command and check that it was accepted; raises InstrumentError."""
        self._commanded = True
        self._exchange(line)

    def _exchange(self, line: str) -> bytes:
        answer, code, text = self._link.exchange(line)
        rejection: InstrumentError | None = None
        while code:
            if code > 0:
                self.events.append(text)
            elif rejection is None:
                rejection = InstrumentError(code, text, line)
            _, code, text = self._link.exchange("*OPT?")
        if rejection is not None:
            raise rejection
        return answer

    def _query_number(self, query: str) -> float:
        value = float(self.ask(query))
        return math.nan if abs(value) >= NO_NUMBER else value

    @property
    def plant(self) -> VirtualPlant | None:
        """Plant of a virtual board that this program started, for fault injection, or None."""
        link = self._link
        return link.board.plant if isinstance(link, BoardLink) and link.board else None

    @property
    def simulated(self) -> bool:
        """Whether the board is a virtual one."""
        return ",virtual bench," in self.identity

    @property
    def vacuum(self) -> float:
        """Latest reading [Pa]; NaN if the sensor provides none."""
        return self._query_number("MEAS:VAC?")

    @property
    def reach(self) -> float:
        """Highest target [Pa] that the controller's plant can hold; 0 if there is no controller."""
        return self._query_number("SOUR:VAC? MAX")

    @property
    def target(self) -> float:
        """Target vacuum: a number in Pa or text with a unit; 0 releases the brake."""
        return self._query_number("SOUR:VAC?")

    @target.setter
    def target(self, value: float | str) -> None:
        self.tell(f"SOUR:VAC {_to_si(value, TARGET, 'target'):.17g}")

    @property
    def output(self) -> bool:
        """Whether the control law is running."""
        return self.ask("OUTP?") == "1"

    @output.setter
    def output(self, value: bool) -> None:
        self.tell("OUTP ON" if value else "OUTP OFF")

    @property
    def safe_state(self) -> str | None:
        """`release` or `hold`; None until it is declared."""
        return _from_scpi_word(SAFE_STATES, self.ask("OUTP:SAFE?"))

    @safe_state.setter
    def safe_state(self, value: str) -> None:
        self.tell(f"OUTP:SAFE {_to_scpi_word(SAFE_STATES, value, 'safe_state')}")

    @property
    def vent_rest(self) -> str | None:
        """Position of the unpowered vent valve, `open` or `closed`; None until declared."""
        return _from_scpi_word(VENT_RESTS, self.ask("OUTP:VENT:REST?"))

    @vent_rest.setter
    def vent_rest(self, value: str) -> None:
        self.tell(f"OUTP:VENT:REST {_to_scpi_word(VENT_RESTS, value, 'vent_rest')}")

    @property
    def lease(self) -> float:
        """Time [s] for which the outputs stay on if the host sends nothing."""
        return self._query_number("SYST:LEAS?")

    @lease.setter
    def lease(self, value: float | str) -> None:
        self.tell(f"SYST:LEAS {_to_si(value, LEASE, 'lease'):.17g}")

    @property
    def regulator(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Settings of the control law on the board; assigning a Regulator sets all of them.

        Raises InstrumentError (-221) if the board has none.
        """
        raw = bytes.fromhex(self.ask("CONT:LAW?").split('"')[1])
        numbers = struct.unpack(f"<{len(raw) // 8}d", raw)
        return numbers[:15], numbers[15:]

    @regulator.setter
    def regulator(self, value: Regulator) -> None:
        check(value)
        first, second = value.pack()
        raw = struct.pack(f"<{len(first) + len(second)}d", *first, *second)
        self.tell(f'CONT:LAW "{raw.hex().upper()}","{zlib.crc32(raw):08X}"')

    @property
    def calibration(self) -> tuple[float, float, str]:
        """Offset [Pa] and gain of the sensor, and the calibration's name; lost if the board resets.

        A reading is (raw - offset) * gain. `SYST:SETT:STOR` stores all three permanently.
        """
        offset, gain, name = self.ask("SENS:VAC:CAL?").split(",", 2)
        return float(offset), float(gain), name[1:-1].replace('""', '"')

    @calibration.setter
    def calibration(self, value: tuple[float, float, str]) -> None:
        offset, gain, name = value
        text = name.replace('"', '""')
        self.tell(f'SENS:VAC:CAL {offset:.9g},{gain:.9g},"{text}"')

    @property
    def sensor_range(self) -> float | None:
        """Highest vacuum [Pa] the controller's sensor measures; None if there is no controller."""
        return self.regulator[1][6] if self.reach else None

    @property
    def state(self) -> str:
        """SAFE, RUN, FAULT or DRIVE."""
        return self.ask("FETC:ALL?").split(",")[5]

    @property
    def fault(self) -> str | None:
        """Name of the latched fault, or None."""
        code, name = self.ask("OUTP:PROT:FAUL?").split(",")
        return name.strip('"') if int(code) else None

    def clear(self) -> None:
        """Clear a latched fault, the error queue and the registers; the outputs stay off."""
        self.tell("*CLS;:OUTP:PROT:CLE")
        self.events.clear()

    def off(self) -> None:
        """Turn the pump off and set the vent to the safe state.

        Any client may do this, even without the lock.
        """
        self.tell("OUTP OFF")

    def lock(self) -> bool:
        """Prevent other clients from sending commands; return False if one of them has the lock."""
        return self.ask("SYST:LOCK:REQ?") == "1"

    def unlock(self) -> None:
        """Release the lock."""
        self.tell("SYST:LOCK:REL")

    def wait(self, seconds: float, *, until: float | None = None) -> float:
        """Keep the lease alive for a time [s] of the host's clock; return the latest vacuum [Pa].

        The wait ends early once the vacuum rises to `until` [Pa]. Raises TrippedError if a fault
        puts the bench into its safe state.
        """
        end = time.monotonic() + seconds
        pause = min(self.lease / 4, 0.1)
        while True:
            parts = self.ask("FETC:ALL?").split(",")
            vacuum = float(parts[1])
            if parts[5] == "FAULT":
                raise TrippedError(self.fault or "unknown")
            time_left = end - time.monotonic()
            if time_left <= 0 or (until is not None and vacuum >= until):
                return math.nan if vacuum >= NO_NUMBER else vacuum
            time.sleep(min(pause, time_left))

    def samples(self, count: int = 100) -> np.ndarray[Any, Any]:
        """Return the oldest unacknowledged records, at most `count`; see `telemetry.RECORD`."""
        return parse_records(self._exchange(f"FETC:STR? {count}"))

    def stream(self, count: int = 200) -> tuple[np.ndarray[Any, Any], int]:
        """Return records as `samples` does, and the random number of the board's latest start."""
        block, mark, boot = self._exchange(f"FETC:STR? {count};:SYST:BOOT?").rpartition(b';"')
        if not mark:
            raise LineError("no block of samples was received")
        return parse_records(block), int(boot[:8], 16)

    def acknowledge(self, seq: int) -> None:
        """Acknowledge the records up to and including `seq`; this does not affect the outputs."""
        self._exchange(f"STR:ACK {seq}")

    def status(self) -> BenchStatus:
        """Return the state of the bench."""
        _, vacuum, target, pump, vent, state, _ = self.ask("FETC:ALL?").split(",")
        boot, cause, uptime, _ = self.ask("SYST:BOOT?").split(",")
        timing = self.ask("SYST:TIM?").split(",")
        age = float(self.ask("SENS:VAC:ZERO?").split(",")[1])
        last = self.identity.rpartition(",")[2].split("/")
        return BenchStatus(
            identity=self.identity,
            simulated=self.simulated,
            state=state,
            fault=self.fault,
            vacuum=None if float(vacuum) >= NO_NUMBER else float(vacuum),
            target=float(target),
            pump=float(pump),
            vent="open" if vent == "1" else "closed",
            safe_state=self.safe_state,
            vent_rest=self.vent_rest,
            lease=self.lease,
            boot=boot.strip('"'),
            reset_cause=cause.strip('"'),
            uptime=float(uptime),
            late_ticks=int(timing[1]),
            worst_lateness=float(timing[2]),
            samples_lost=int(self.ask("STR:LOST?")),
            law_matches=f"law-{law_hash()[:8]}" in last,
            double="double" in last,
            zero_age=None if age >= NO_NUMBER else age,
            errors=tuple(self.events),
        )

    def close(self) -> None:
        """Switch the outputs off if this client has sent any command, and disconnect."""
        try:
            if self._commanded:
                self.off()
        except LayerjamError:
            pass  # if the connection is lost, the outputs switch off when the lease expires
        finally:
            self._link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


B = TypeVar("B", bound=Bench)


def open_bench(address: str | Address) -> Bench:
    """Return the bench at an address: `sim:choi2018`, `serial:/dev/ttyACM0`, `tcp:host:5025`.

    Raises FileError, LineError, QuantityError, UnknownNameError or MissingExtraError.
    """
    return open_bench_as(address, Bench)


def open_bench_as(address: str | Address, kind: type[B]) -> B:
    """Return the bench at an address as an object of the given class.

    Raises FileError, LineError, QuantityError, UnknownNameError or MissingExtraError.
    """
    target = address_of(address)
    link = open_link(target)
    try:
        return kind(link, target)
    except BaseException:
        link.close()
        raise


def _to_si(value: float | str, spec: QuantitySpec, name: str) -> float:
    """Return a number, or text with a unit, in SI units; raises QuantityError for anything else."""
    number = parse(value, spec.unit, name) if isinstance(value, str) else float(value)
    if not math.isfinite(number):
        raise QuantityError.of(name, f"{number} is not a finite number")
    return number


def _to_scpi_word(words: dict[str, str], value: str, name: str) -> str:
    if value not in words:
        raise QuantityError.of(name, f"'{value}' is not allowed; write {' or '.join(words)}")
    return words[value]


def _from_scpi_word(words: dict[str, str], scpi_word: str) -> str | None:
    return next((word for word, value in words.items() if value == scpi_word), None)
