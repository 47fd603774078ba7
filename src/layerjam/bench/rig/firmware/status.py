"""One client's registers and error queue (IEEE 488.2, SCPI-99 volume 1, chapter 20)."""

from scpi import TEXTS

DEEP = 16
"""Largest number of errors in a queue; if there are more, the last is "Queue overflow"."""
DEVICE = {
    120: "LEASE_EXPIRED",
    121: "TICK_OVERRUN",
    122: "SUPPLY_LOW",
    123: "EMERGENCY_STOP",
    124: "WATCHDOG_RESET",
    125: "SETTINGS_OLD_SLOT",
    126: "LINE_CORRUPT",
    127: "RING_OVERRUN",
    128: "SENSORS_DISAGREE",
    129: "SENSOR_DIAGNOSTIC",
}
SETTLING, CAPTURES, AWAITS, OUTPUTS_ON = 2, 16, 32, 256
VENT_OPEN, LEASE_SHORT, MAINTENANCE = 512, 1024, 16384
"""Bits of the operation register."""
LATE, SUPPLY, ZERO_OLD, LATCHED = 4, 8, 256, 512
DOUBTFUL, LOST, BY_WATCHDOG = 1024, 2048, 4096
"""Bits of the questionable register."""
COMPLETE, QUERY, DEVICE_ERROR, EXECUTION, COMMAND, POWER_ON = 1, 4, 8, 16, 32, 128
"""Bits of the standard event register."""


class Register:
    """Condition, event and enable register; rises of a condition are stored as events."""

    def __init__(self) -> None:
        self.condition = 0
        self.event = 0
        self.enable = 0

    def set_condition(self, condition: int) -> None:
        """Set the condition to that of the bench."""
        self.event |= condition & ~self.condition
        self.condition = condition

    def take_event(self) -> int:
        """Return the event register and clear it."""
        event, self.event = self.event, 0
        return event


class Session:
    """State of the instrument for one client."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.operation = Register()
        self.questionable = Register()
        self.standard = POWER_ON
        self.standard_enable = 0
        self.service_enable = 0
        self.errors: list[tuple[int, str]] = []
        self.completes = False
        """Whether `*OPC` waits for the end of a capture."""
        self.held = None
        """Suspended line: its remaining text, its header path, and the responses so far."""

    def push(self, code: int, detail: str = "") -> None:
        """Add an error; its class is set in the standard event register."""
        if code > 0 or -399 <= code <= -300:
            self.standard |= DEVICE_ERROR
        elif -299 <= code <= -200:
            self.standard |= EXECUTION
        elif -199 <= code <= -100:
            self.standard |= COMMAND
        if len(self.errors) >= DEEP:
            self.errors[-1] = (-350, "")
        else:
            self.errors.append((code, detail))

    def take_error(self, names: dict) -> str:
        """Return the oldest error, or `0,"No error"`."""
        return (
            format_error(*self.errors.pop(0), names) if self.errors else format_error(0, "", names)
        )

    def status_byte(self) -> int:
        """Return the status byte; bit 6 summarises the bits that `*SRE` enables."""
        byte = 4 if self.errors else 0
        if self.questionable.event & self.questionable.enable:
            byte |= 8
        if self.standard & self.standard_enable:
            byte |= 32
        if self.operation.event & self.operation.enable:
            byte |= 128
        return byte | 64 if byte & self.service_enable & ~64 else byte

    def clear(self) -> None:
        """Clear events, the queue and a waiting `*OPC` (`*CLS`); enable registers are kept."""
        self.standard = 0
        self.completes = False
        self.operation.event = self.questionable.event = 0
        self.errors = []


def format_error(code: int, detail: str, names: dict) -> str:
    """Return an error in SCPI format; `names` are those of the law's faults."""
    text = names.get(code - 100) or DEVICE.get(code) if code > 0 else TEXTS.get(code)
    text = text or "Error"
    if detail:
        text += ";" + detail.replace('"', "'")
    return '%d,"%s"' % (code, text[:240])
