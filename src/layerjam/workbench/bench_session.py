"""A page's bench: a thread communicates with the board as long as the page is open.

A board keeps its outputs on while a client communicates with it. The browser reports several times
a second that its page is open. If the reports stop, the thread stops communicating, and the board's
lease expires.
"""

import math
import queue
import tempfile
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from layerjam.bench.commands.regulator import RegulatorSettings, make_regulator
from layerjam.bench.control.faults import make_injection
from layerjam.bench.control.settings import Regulator, validate
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.execute import ProcedureBench, RunResult, open_procedure_bench
from layerjam.bench.rig.recorder import Block
from layerjam.bench.rig.stop import Stop
from layerjam.bench.rig.telemetry import PERIOD
from layerjam.bench.rig.virtual_plant import HEALTHY, read_hardware
from layerjam.brake.fluid.line_file import LineFile
from layerjam.core.errors import LayerjamError, QuantityError
from layerjam.core.units import exact_text
from layerjam.workbench.answer import build_figure_notebook

LEASE = 3.0
"""Seconds after which a closed page no longer keeps a brake jammed."""
PRESENT = 1.0
"""Part of LEASE [s] in which a page need not report; the board's own lease is the remainder."""
PACE, SEEN = 0.1, 600
"""Interval between readings of the bench [s], and number of readings that are stored."""
RECORDED_EVERY = 10
"""Number of recorded samples per displayed sample."""
T = TypeVar("T")


@dataclass(frozen=True)
class BenchState:
    """State of the bench at one moment; `vacuum` is None if the sensor provides no reading."""

    time: float
    """Time on the board's clock [s]."""
    vacuum: float | None
    target: float
    pump: float
    vent: bool
    state: str
    fault: str | None


@dataclass
class Session:
    """One bench, used by one page; `alive` returns whether the page is open."""

    bench: ProcedureBench
    alive: Callable[[], bool]
    looks: deque[BenchState] = field(default_factory=lambda: deque(maxlen=SEEN))
    lost: str = ""
    """Reason for the loss of the connection; "" while connected."""
    running: Stop | None = None
    """Stop request for the running procedure."""

    def __post_init__(self) -> None:
        self._asked: queue.SimpleQueue[tuple[Callable[[ProcedureBench], Any], Future[Any]]]
        self._asked = queue.SimpleQueue()
        self._over = threading.Event()
        self._faults: dict[int, str] = {}
        # only the holder of the lock renews the lease: another client must not keep a brake jammed
        # after the page is closed
        if not self.bench.lock():
            raise QuantityError.of("bench", "is locked by another client")
        self.bench.lease = LEASE - PRESENT
        self._thread = threading.Thread(
            target=self._run_requests, name="layerjam bench", daemon=True
        )
        self._thread.start()

    @classmethod
    def connect(cls, address: str, alive: Callable[[], bool], target: float) -> "Session":
        """Open the session at an address; a virtual line is linearised at the target [Pa]."""
        place = address_of(address)
        if place.simulated and "at" not in place.options:
            place = replace(place, options={**place.options, "at": exact_text(target, "Pa")})
        bench = open_procedure_bench(place)
        try:
            return cls(bench, alive)
        except BaseException:
            bench.close()
            raise

    def request_action(self, act: Callable[[ProcedureBench], T]) -> Future[T]:
        """Queue `act` for the thread, after all earlier requests; return a future of its result."""
        answer: Future[T] = Future()
        if self._over.is_set() or self.lost:
            answer.set_exception(LayerjamError(self.lost or "the bench is disconnected"))
        else:
            self._asked.put((act, answer))
        return answer

    def close(self) -> None:
        """End any running procedure, switch the outputs off and close the connection."""
        if self.running is not None:
            self.running.request_stop()
        self._over.set()

    def wait_until_ended(self, seconds: float) -> bool:
        """Return whether the thread ends within the given number of seconds."""
        self._thread.join(seconds)
        return not self._thread.is_alive()

    def _run_requests(self) -> None:
        try:
            while not self._over.is_set():
                try:
                    act, answer = self._asked.get(timeout=PACE)
                except queue.Empty:
                    if self.alive():
                        self._read_state()
                    continue
                try:
                    answer.set_result(act(self.bench))
                except Exception as error:
                    # the caller gets the error, and the bench remains supervised
                    answer.set_exception(error)
        except LayerjamError as error:
            self.lost = str(error)
        finally:
            self._over.set()
            self.bench.close()
            while not self._asked.empty():
                self._asked.get()[1].set_exception(LayerjamError("the bench is disconnected"))

    def _read_state(self) -> None:
        parts = self.bench.ask("FETC:ALL?").split(",")
        vacuum, fault = float(parts[1]), int(parts[6])
        if fault and fault not in self._faults:
            self._faults[fault] = self.bench.fault or str(fault)
        self.looks.append(
            BenchState(
                time=int(parts[0]) * PERIOD * 1e-6,
                vacuum=None if abs(vacuum) > 1e37 else vacuum,
                target=float(parts[2]),
                pump=float(parts[3]),
                vent=parts[4] == "1",
                state=parts[5],
                fault=self._faults.get(fault),
            )
        )

    def record_run(self, procedure: str, out: Path, meta: dict[str, object]) -> Future[RunResult]:
        """Run and record a procedure; it ends if the page is closed."""

        def run_procedure(bench: ProcedureBench) -> RunResult:
            stop = self.running = Stop()
            try:
                return bench.run(
                    procedure, out=out, meta=meta, overwrite=True, stop=stop, watch=self._on_block
                )
            finally:
                self.running = None
                bench.lock()

        return self.request_action(run_procedure)

    def _on_block(self, block: Block) -> None:
        if not self.alive() and self.running is not None:
            self.running.request_stop()
        states = {0: "SAFE", 1: "RUN", 2: "FAULT"}
        for row in block.rows[::RECORDED_EVERY]:
            vacuum = float(row["vacuum"])
            self.looks.append(
                BenchState(
                    time=int(row["seq"]) * PERIOD * 1e-6,
                    vacuum=None if vacuum != vacuum else vacuum,
                    target=float(row["target"]),
                    pump=int(row["pump"]) / 255,
                    vent=bool(row["flags"] & 1),
                    state=states.get(int(row["state"]), "DRIVE"),
                    fault=None,
                )
            )


class Presence:
    """Whether a page is open, according to repeated reports from its browser."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._heard = clock()

    def record_heartbeat(self) -> None:
        """Record a report from the browser."""
        self._heard = self._clock()

    def __call__(self) -> bool:
        """Return whether the browser reported recently."""
        return self._clock() - self._heard < PRESENT


def bench_regulator(
    address: str, line: LineFile, target: float, safe_state: str, kind: str, sensor_range: float
) -> Regulator:
    """Return a controller for a virtual board's line or, for a real board, the desk's line.

    Raises QuantityError if the controller cannot hold the target [Pa].
    """
    place = address_of(address)
    if place.simulated:
        options = {"at": exact_text(target, "Pa"), **place.options}
        board = read_hardware(replace(place, options=options))
        regulator = Regulator(
            plant=board.plant, sensor=board.sensor, kind=kind, safe_state=safe_state
        )
    else:
        settings: dict[str, Any] = {"safe_state": safe_state, "kind": kind}
        if line.line.sensor is None:
            settings["sensor_range"] = sensor_range
        regulator, _ = make_regulator(line, target, RegulatorSettings(**settings))
    validate(regulator, target)
    return regulator


def hold_target(bench: ProcedureBench, regulator: Regulator, rest: str, target: float) -> None:
    """Hold a target [Pa]; if one is already held, only the target changes."""
    is_on = bench.output
    if not is_on:
        bench.safe_state, bench.vent_rest = regulator.safe_state, rest
        bench.regulator = regulator
    bench.target = target
    if not is_on:
        bench.output = True


def inject_fault(bench: ProcedureBench, fault: str, regulator: Regulator, target: float) -> None:
    """Inject a fault into the plant of a virtual board; "none" repairs it."""
    if bench.plant is not None:
        injection = HEALTHY if fault == "none" else make_injection(fault, 0.0, regulator, target)[0]
        bench.plant.injected = injection


@dataclass(frozen=True)
class BenchRecord:
    """Readings of a bench, and whether its board is virtual."""

    looks: Sequence[BenchState]
    simulated: bool
    name: str = "bench"
    files: Mapping[str, str] = field(default_factory=dict)
    failures: Sequence[str] = ()

    @property
    def columns(self) -> dict[str, list[float]]:
        """Return {name: values}: time [s] since the first reading, vacuum [Pa], target [Pa]."""
        start = self.looks[0].time
        return {
            "time": [round(look.time - start, 6) for look in self.looks],
            "vacuum": [math.nan if k.vacuum is None else float(k.vacuum) for k in self.looks],
            "target": [float(look.target) for look in self.looks],
        }

    def figure(self, ending: str) -> bytes:
        """Return the figure as bytes."""
        from layerjam.bench.figures import control_figures
        from layerjam.core.drawing import style

        figure = control_figures.draw_run(**self.columns, simulated=self.simulated)
        with tempfile.TemporaryDirectory(prefix="layerjam-") as folder:
            return style.save(figure, Path(folder) / f"figure.{ending}").read_bytes()

    def python_code(self) -> str:
        """Return code that contains the readings and draws them."""
        saving = f'style.save(figure, Path("{self.name}.svg"), overwrite=True)'
        return f"from pathlib import Path\n{self._python_source()}{saving}\n"

    def notebook(self) -> str:
        """Return a Jupyter notebook that contains the readings and draws them."""
        return build_figure_notebook("Bench readings", self._python_source())

    def _python_source(self) -> str:
        lists = (f"{k} = [{', '.join(map(repr, v))}]\n" for k, v in self.columns.items())
        return (
            "from math import nan\n\nfrom layerjam.core.drawing import style\n"
            "from layerjam.bench.figures.control_figures import draw_run\n\n"
            f"{''.join(lists)}figure = draw_run(time, vacuum, target, simulated={self.simulated})\n"
        )
