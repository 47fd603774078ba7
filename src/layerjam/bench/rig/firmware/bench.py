"""The instrument: its states, its safe state, and the work of each 10 ms sample.

The host is never trusted: if it is silent for longer than the lease, the outputs become safe.
"""

import math
import os
import struct

import capture
import law
import status
import store
import ticks
from built import FAULTS
from ring import Ring
from scpi import ScpiError

SAFE, RUN, FAULT, DRIVE = 0, 1, 2, 3
STATES = ("SAFE", "RUN", "FAULT", "DRIVE")
CLEAR = "; OUTP:PROT:CLE or 'layerjam bench clear' leaves FAULT"
RELEASE, HOLD = 1, 2
OPEN, CLOSED = 1, 2
SESSIONS = 16
LEASE = 2.0
"""Default time [s] for which the outputs stay on while the host is silent."""
OVERRUN = 100000
"""Delay of a sample [us] that counts as a fault."""
SUPPLY_SAMPLES = 3
SENSOR_TOLERANCE = 0.05
"""Maximum difference between two sensors, as a fraction of the range."""
DRIVEN = 5000000
"""Total time [us] for which outputs may be driven by hand before a return to SAFE."""
DAY = 8640000
"""Number of samples after which a zero measurement is out of date."""
NEVER = 1 << 40
VENTS, VENT_WINDOW = 3, 6000
"""Number of vent openings, within a window of samples, that makes the sensor suspect."""
HALVINGS = 36
"""Number of bisections in the search for the highest vacuum; few, because samples wait."""
STEPS = 100
"""Samples per second."""
SELF_TEST = (
    (1.0, 1e-4, 1e-6, 0.0, 950.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.1, 10.0, 95000.0, 1.0, 1.0),
    (
        0.1, 95000.0, 1.0, 0.01, 1.0, -5000.0, 103000.0, 3.0, 1900.0, 0.2, 0.5, 4.0, 4750.0,
        100.0, 1e15, 30.0, 950.0, 0.0, 1e13, 0.0, 0.0, 1.3, 950.0, 0.0,
    ),
)  # fmt: skip
"""Settings of the law's self-test."""
TESTED, DIES = 45, 30
"""Steps of the law's self-test, few because samples wait, and the step at which the pump fails."""


class Bench:
    """State of one board: its HAL, the law's memory, settings, sessions and a ring of samples."""

    def __init__(self, hal) -> None:
        self.hal = hal
        # memory that the garbage collector does not scan, if the board has any
        self.ring = Ring(getattr(hal, "ring_store", None), SESSIONS)
        hal.ring = self.ring
        self.capture = capture.Capture(hal)
        # input for a machine's contact, if the board has one
        self.contact = getattr(hal, "is_contact_closed", None)
        # whether an *OPC waits for the end of a capture
        self.completing = False
        self.headers: list[str] = []
        self.sessions = [status.Session(number) for number in range(SESSIONS)]
        self.boot = struct.unpack("<I", os.urandom(4))[0]
        self.cause = hal.reset_cause()
        self.settings, trouble = store.load(hal)
        self.trouble = trouble
        self.operation = self.questionable = 0
        self.owner = -1
        # session that sent the last command: its lines renew the lease, those of others do not
        self.keeper = -1
        self.lease, self.left = LEASE, 0
        # session that requested a lease different from the default
        self.lessee = -1
        self.state, self.fault = SAFE, 0
        self.target, self.state_of_law = 0.0, law.fresh()
        self.pump, self.vent, self.sync = 0.0, 0, 0
        # outputs of DIAG:DRIV; they start at the next sample, so that its record has the right time
        self.driven = (0.0, 0)
        self.reading, self.raw, self.warmth = math.nan, 0, 0
        self.count = self.micros = 0
        # sample at which a reset was requested
        self.leaving = -1
        self.last = hal.ticks_us()
        self.late = self.worst = self.slowest = 0
        self.lateness = [0, 0, 0, 0, 0]
        self.low_supply = 0
        self.zero, self.zeroed = 0.0, NEVER
        self.vented = 0
        self.openings: list[int] = []
        self.second = getattr(hal, "read_second_sensor", None)
        self.apart = 0
        self.until = self.allowed = 0
        self.ran = False
        self.reach = 0.0
        self.update_limits()
        self.rest_outputs()
        for code in (trouble, 124 if self.cause == "WATCHDOG" else 0):
            if code:
                self.report_event(code)

    def report_event(self, code: int, detail: str = "") -> None:
        """Add a device error to every queue."""
        for session in self.sessions:
            session.push(code, detail)

    def update_limits(self) -> None:
        """Calculate the highest vacuum [Pa] of the law's own plant: full pump against the leak."""
        self.reach = 0.0
        if self.settings.law is None:
            return
        watch = self.settings.law[1]
        rise, top, fall, leak = watch[:4]
        lo, hi = 0.0, top
        for _ in range(HALVINGS):
            half = 0.5 * (lo + hi)
            gives = law.healthy_rise(1.0, half, rise, top, fall, watch[18], watch[19], watch[20])
            if gives > leak * half:
                lo = half
            else:
                hi = half
        self.reach = lo

    def check_allowed(self, session, flags: str) -> None:
        """Raise an error if another session has the lock, or if the state forbids the command."""
        if "L" in flags and self.owner >= 0 and self.owner != session.number:
            raise ScpiError(-203, "locked by session %d" % self.owner)
        if "S" in flags:
            self.require_safe()

    def require_safe(self) -> None:
        """Raise -221 in any state other than SAFE."""
        if self.state != SAFE:
            hint = CLEAR if self.state == FAULT else ""
            raise ScpiError(-221, "only in SAFE, but the state is " + STATES[self.state] + hint)

    def renew_lease(self, session, commands: bool) -> None:
        """Restart the lease after a line from the commanding client.

        That client is the owner of the lock, otherwise the sender of the last command (`commands`).
        Queries from other clients do not renew the lease.
        """
        if self.owner >= 0 and self.owner != session.number:
            return
        if commands or self.owner >= 0:
            self.keeper = session.number
        if self.keeper == session.number:
            self.left = int(self.lease * 1e6)

    def set_lease(self, time: float, number: int = -1) -> None:
        """Set the lease [s] until session `number` ends; -1 sets it without a session."""
        self.lease, self.lessee = time, number
        self.left = min(self.left, int(time * 1e6))

    def end_session(self, number: int) -> None:
        """Remove a client's lock, lease, registers and queue; the outputs stay on for the lease."""
        if self.owner == number:
            self.owner = -1
        if self.keeper == number:
            self.keeper = -1
        if self.lessee == number:
            self.set_lease(LEASE)
        self.ring.end_session(number)
        fresh = status.Session(number)
        fresh.operation.condition = self.operation
        fresh.questionable.condition = self.questionable
        self.sessions[number] = fresh
        # every session reports start-up errors until settings are stored or outputs are on
        for code in (self.trouble, 124 if self.cause == "WATCHDOG" and not self.ran else 0):
            if code:
                fresh.push(code)
        fresh.standard = 0

    def set_output(self, pump: float, vent: int) -> None:
        """Set pump (-1 to 1) and vent (1: open); power the valve if its rest position differs."""
        rest_state = self.settings.rest
        self.pump, self.vent = pump, vent
        self.hal.set_outputs(pump, 0 if rest_state == 0 or vent == (rest_state == OPEN) else 1)

    def rest_outputs(self) -> None:
        """Put the outputs into the safe state: pump off, vent valve unpowered."""
        self.set_output(0.0, 1 if self.settings.rest == OPEN else 0)

    def latch_fault(self, code: int) -> None:
        """Latch a fault, make the outputs safe immediately, and report it to all clients."""
        self.rest_outputs()
        self.state, self.fault = FAULT, code
        self.report_event(code if code >= 100 else 100 + code)

    def switch_off(self) -> None:
        """Switch the outputs off; a latched fault stays."""
        self.rest_outputs()
        if self.state in (RUN, DRIVE):
            self.state = SAFE

    def explain_power_loss(self) -> str:
        """Return the reason why pump and valve have no power, or ""."""
        is_stopped = self.hal.is_stop_pressed()
        if not self.hal.has_supply():
            return "the supply of the pump and the valve is low or off"
        return "the emergency stop is open" if is_stopped else ""

    def explain_refusal(self) -> str:
        """Return the reason why the outputs cannot be switched on, or ""."""
        settings = self.settings
        if self.state == FAULT:
            return "a fault is latched" + CLEAR
        if not settings.safe:
            return "OUTP:SAFE is not declared"
        if not settings.rest:
            return "OUTP:VENT:REST is not declared"
        if (settings.safe == RELEASE) != (settings.rest == OPEN):
            return "without power the vent does not go to the safe state"
        if settings.law is None:
            return "no controller; CONT:LAW sets one"
        if settings.law[0][14] != (1.0 if settings.safe == RELEASE else 0.0):
            return "the controller's safe state differs from OUTP:SAFE"
        watch = settings.law[1]
        if not watch[5] <= self.reading < watch[6]:
            return "the sensor reading is out of range"
        power_loss = self.explain_power_loss()
        if power_loss:
            return power_loss
        if self.target > self.reach:
            return "the target is beyond the controller's reach"
        return ""

    def switch_on(self) -> None:
        """Start the law from its initial state."""
        if self.state == RUN:
            return
        obstacle = self.explain_refusal()
        if obstacle or self.state == DRIVE:
            raise ScpiError(-221, obstacle or "DIAG:DRIV is running")
        self.hal.arm_watchdog()
        self.state_of_law = law.fresh()
        self.openings = []
        self.apart = 0
        self.ran = True
        self.state = RUN

    def drive_outputs(self, pump: float, vent: int, time: float) -> None:
        """Drive the outputs directly, for at most 5 s in total; then return to SAFE."""
        if self.state != DRIVE:
            self.require_safe()
            self.allowed = DRIVEN
        elif time * 1e6 > self.allowed:
            raise ScpiError(-221, "only %.2f s of driving are left" % (self.allowed * 1e-6))
        if not self.settings.rest:
            raise ScpiError(-221, "OUTP:VENT:REST is not declared")
        power_loss = self.explain_power_loss()
        if power_loss:
            raise ScpiError(-221, power_loss)
        self.until = int(time * 1e6)
        self.state = DRIVE
        self.hal.arm_watchdog()
        self.driven = (pump, vent)

    def tick(self, late: int) -> None:
        """Process one sample: read, evaluate, command, record; `late` is its delay [us]."""
        start = self.hal.ticks_us()
        self.hal.feed_watchdog()
        interval = ticks.diff(start, self.last)
        self.last = start
        self.micros = (self.micros + interval) & 0xFFFFFFFF
        self.count += 1
        self.left = max(self.left - interval, 0)
        reading, self.raw, self.warmth, diagnostic = self.hal.read_sensor()
        self.reading = (reading - self.settings.offset) * self.settings.gain
        is_stopped = self.hal.is_stop_pressed()
        self.low_supply = 0 if self.hal.has_supply() else self.low_supply + 1
        # the stop is sensed downstream of the supply: without a supply its state is unknown
        is_stopped = is_stopped and not self.low_supply
        if self.state == RUN:
            self.regulate(late, is_stopped, diagnostic)
        elif self.state == DRIVE:
            self.until -= interval
            self.allowed -= interval
            if is_stopped or self.left == 0 or self.until <= 0 or self.low_supply >= SUPPLY_SAMPLES:
                self.switch_off()
            else:
                self.set_output(*self.driven)
        self.watch_zero()
        if self.capture.tick(self.micros):
            self.report_event(127, "of the accelerometer")
        if self.completing:
            self.complete_operations()
        flags = self.vent | (2 if self.pump < 0 else 0) | self.sync << 2 | (8 if is_stopped else 0)
        if self.contact is not None and self.contact():
            flags |= 16
        power = min(int(abs(self.pump) * 255 + 0.5), 255)
        if self.ring.store_record(
            self.micros, self.reading, self.target, self.raw, self.warmth, power, flags,
            self.state, self.fault,
        ) and self.ring.lost == 1:  # fmt: skip
            self.report_event(127)
        self.update_conditions(late)
        self.slowest = max(self.slowest, ticks.diff(self.hal.ticks_us(), start))

    def regulate(self, late: int, stopped: bool, diagnostic: int) -> None:
        """Process a sample in RUN: first the faults, then the law."""
        if stopped:
            self.latch_fault(123)
        elif self.low_supply >= SUPPLY_SAMPLES:
            self.latch_fault(122)
        elif self.left == 0:
            self.latch_fault(120)
        elif late > OVERRUN:
            self.latch_fault(121)
        else:
            was = self.vent
            self.state_of_law, pump, vent, fault = law.step(
                self.settings.law, self.state_of_law, self.reading, self.target
            )
            if fault:
                # a pump without power produces no vacuum, so the supply is the cause
                self.latch_fault(122 if self.low_supply else fault)
                if diagnostic:
                    self.report_event(129)
                return
            if self.has_disagreement(self.settings.law[1]):
                self.latch_fault(128)
                return
            self.set_output(pump, vent)
            if vent and not was and self.target > 0.0:
                self.openings = self.openings[1 - VENTS :] + [self.count]

    def has_disagreement(self, watch) -> bool:
        """Return whether a second sensor, if present, has differed long enough for a fault."""
        second_reading = None if self.second is None else self.second()
        if second_reading is None:
            return False
        is_near = abs(second_reading - self.reading) <= SENSOR_TOLERANCE * watch[6]
        self.apart = 0 if is_near else self.apart + 1
        return self.apart >= watch[7]

    def watch_zero(self) -> None:
        """Use the sensor's reading as its zero once the vent has been open for long enough."""
        self.vented = self.vented + 1 if self.vent and self.pump == 0.0 else 0
        self.zeroed = min(self.zeroed + 1, NEVER)
        law = self.settings.law
        if law is not None and self.vented > law[1][15] and self.reading == self.reading:
            self.zero, self.zeroed = self.reading, 0

    def complete_operations(self) -> None:
        """Set bit 0 of the event register for `*OPC` once no capture is waiting or running."""
        self.completing = self.capture.is_busy()
        if self.completing:
            return
        for session in self.sessions:
            if session.completes:
                session.standard |= status.COMPLETE
                session.completes = False

    def update_conditions(self, late: int) -> None:
        """Set the conditions of the registers for this sample; `late` is its delay [us]."""
        place = 0 if late <= 100 else 1 if late <= 1000 else 2 if late <= 10000 else 3
        self.lateness[place if late <= OVERRUN else 4] += 1
        self.late += late > 1000
        self.worst = max(self.worst, late)
        operation = status.VENT_OPEN if self.vent else 0
        if self.capture.state == capture.WAITING:
            operation |= status.AWAITS
        elif self.capture.state == capture.RUNNING:
            operation |= status.CAPTURES
        if self.state == RUN:
            operation |= status.OUTPUTS_ON
            if not law.is_reached(self.settings.law[0], self.reading, self.target, 0.0):
                operation |= status.SETTLING
            if self.left < self.lease * 250000:
                operation |= status.LEASE_SHORT
        doubt = 0
        if late > 1000:
            doubt |= status.LATE
        if self.low_supply:
            doubt |= status.SUPPLY
        if self.zeroed > DAY or not self.settings.sensor:
            doubt |= status.ZERO_OLD
        if self.state == FAULT:
            doubt |= status.LATCHED
        if self.state == RUN and self.state_of_law[1][1] > 0.0:
            doubt |= status.DOUBTFUL
        if len(self.openings) == VENTS and self.openings[-1] - self.openings[0] <= VENT_WINDOW:
            doubt |= status.DOUBTFUL
        if self.ring.lost:
            doubt |= status.LOST
        if self.cause == "WATCHDOG":
            doubt |= status.BY_WATCHDOG
        # update each only on change: all sixteen take the chip a long time, and changes are rare
        if operation != self.operation:
            self.operation = operation
            for session in self.sessions:
                session.operation.set_condition(operation)
        if doubt != self.questionable:
            self.questionable = doubt
            for session in self.sessions:
                session.questionable.set_condition(doubt)

    def self_test(self) -> int:
        """Return the sum of faults: 1 sensor, 2 settings, 4 law, 8 supply, 16 stop, 32 flash."""
        code = 0 if self.reading == self.reading else 1
        code |= 32 if self.trouble == -314 else 2 if self.trouble else 0
        code |= 0 if is_law_sound() else 4
        code |= 8 if self.low_supply else 0
        return code | (16 if self.hal.is_stop_pressed() and not self.low_supply else 0)

    def fault_text(self) -> str:
        """Return the fault as `5,"NO_VACUUM"`, or `0,"HEALTHY"`."""
        name = FAULTS.get(self.fault) or status.DEVICE.get(self.fault, "HEALTHY")
        return '%d,"%s"' % (self.fault, name)


def is_law_sound() -> bool:
    """Return whether the law controls a simulated plant and detects that its pump has failed."""
    state, vacuum, code, pump, n = law.fresh(), 0.0, 0, 0.0, 0
    for n in range(TESTED):
        state, pump, _vent, code = law.step(SELF_TEST, state, vacuum, 60000.0)
        if code:
            break
        gives = pump * 0.1 * (95000.0 - vacuum) if n < DIES else 0.0
        vacuum += gives - 0.01 * vacuum
        if n == DIES - 1 and abs(vacuum - 60000.0) > 600.0:
            return False
    return n >= DIES and code == law.NO_VACUUM and pump == 0.0
