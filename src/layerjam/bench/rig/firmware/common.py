"""Headers that every instrument has (IEEE 488.2, SCPI-99), in a table with their functions.

Flags: L is rejected from clients other than the one that has the lock, S is allowed only in SAFE, W
waits until no capture is waiting or running.
"""

import gc

import built
import store
from scpi import Number, Rule, ScpiError

from bench import LEASE, STEPS

VERSION = "0.1"
NO_NUMBER = "9.91E37"


def format_number(value: float) -> str:
    """Return a number in SCPI format."""
    return "%.9g" % value if value == value else NO_NUMBER


def quote(text: str) -> str:
    """Return a string in SCPI format, with the quotes inside it doubled."""
    return '"' + text.replace('"', '""') + '"'


def format_block(data: bytes) -> bytes:
    """Return a definite-length block."""
    size = b"%d" % len(data)
    return b"#%d" % len(size) + size + data


def make_call(path: str):
    """Return the action that returns the value, or calls the method, at a dotted path."""
    root, *names = path.split(".")

    def execute(bench, session, *values):
        target = bench if root == "bench" else session
        for name in names:
            target = getattr(target, name)
        return target(*values) if callable(target) else target

    return execute


def make_constant(value):
    """Return a query with a constant response, or a command without effect."""
    return lambda bench, session: value


def read_identity(bench, session) -> str:
    model, serial = bench.hal.identity()
    digits = "double" if 1.0 + 1e-12 != 1.0 else "single"
    return "layerjam,%s,%s,%s/law-%s/%s" % (model, serial, VERSION, built.LAW[:8], digits)


def take_events(bench, session) -> int:
    event, session.standard = session.standard, 0
    return event


def enable_events(bench, session, mask: int) -> None:
    session.standard_enable = mask


def enable_service(bench, session, mask: int) -> None:
    session.service_enable = mask & ~64


def request_completion(bench, session) -> None:
    session.completes = True
    bench.complete_operations()


def reset(bench, session) -> None:
    bench.switch_off()
    session.completes = False
    bench.capture.reset()
    bench.target, bench.sync = 0.0, 0
    bench.set_lease(LEASE)


# ---- SYSTem and STATus


def take_error(bench, session) -> str:
    return session.take_error(built.FAULTS)


def take_errors(bench, session) -> str:
    out = [session.take_error(built.FAULTS)]
    while session.errors:
        out.append(session.take_error(built.FAULTS))
    return ",".join(out)


def count_errors(bench, session) -> int:
    return len(session.errors)


def lock_session(bench, session) -> int:
    if bench.owner < 0:
        bench.owner = session.number
    return 1 if bench.owner == session.number else 0


def unlock_session(bench, session) -> None:
    bench.owner = -1


def read_owner(bench, session) -> str:
    mine = bench.owner == session.number
    return '"NONE"' if bench.owner < 0 else '"SELF"' if mine else '"SESSION %d"' % bench.owner


def set_lease(bench, session, time: float) -> None:
    bench.set_lease(time, session.number)


def read_lease(bench) -> float:
    return bench.lease


def read_boot(bench, session) -> str:
    up = bench.count // STEPS
    return '"%08X","%s",%d,"%s"' % (bench.boot, bench.cause, up, built.FIRMWARE[:16])


def read_timing(bench, session) -> str:
    bins = ",".join([str(count) for count in bench.lateness])
    return "%d,%d,%s,%s,%s,%s" % (
        bench.count, bench.late, format_number(bench.worst * 1e-6),
        format_number(bench.slowest * 1e-6), format_number(bench.hal.collected * 1e-6), bins,
    )  # fmt: skip


def read_memory(bench, session) -> str:
    """Return the bytes in use after a garbage collection and the free bytes; NaN if unknown."""
    gc.collect()
    used, left = getattr(gc, "mem_alloc", None), getattr(gc, "mem_free", None)
    if used is None or left is None:
        return NO_NUMBER + "," + NO_NUMBER
    return "%d,%d" % (used(), left())


def store_settings(bench, session) -> None:
    if bench.hal.time_since_save() < 1000000:
        raise ScpiError(-221, "settings are stored at most once a second")
    store.save(bench.hal, bench.settings)
    bench.trouble = 0


def reset_settings(bench, session) -> None:
    generation, bench.settings = bench.settings.generation, store.Settings()
    bench.settings.generation = generation
    bench.update_limits()
    bench.rest_outputs()


def list_headers(bench, session) -> bytes:
    return format_block("\n".join(bench.headers).encode())


def restart_board(bench, session) -> None:
    bench.rest_outputs()
    bench.leaving = bench.count


def preset_registers(bench, session) -> None:
    session.operation.enable = session.questionable.enable = 0


def make_register(name: str) -> list:
    """Return the five headers of one of the two SCPI registers."""

    def event(bench, session) -> int:
        return getattr(session, name).take_event()

    def condition(bench, session) -> int:
        return getattr(session, name).condition

    def mask(bench, session, value: int) -> None:
        getattr(session, name).enable = value & 32767  # bit 15 is always 0 (SCPI-99, 20.1)

    def query(bench, session) -> int:
        return getattr(session, name).enable

    head = "STATus:" + ("OPERation" if name == "operation" else "QUEStionable")
    return [
        (head + "[:EVENt]", None, Rule(event)),
        (head + ":CONDition", None, Rule(condition)),
        (head + ":ENABle", Rule(mask, (Number("mask", "", 0, 65535, is_whole=1),)), Rule(query)),
    ]


def make_setting(header: str, param: Number, take, read_value, flags: str) -> tuple:
    """Return a header that sets and queries a number; the query also accepts MIN, MAX and DEF."""

    def ask(bench, session, word=None) -> str:
        return format_number(read_value(bench) if word is None else word)

    return header, Rule(take, (param,), flags=flags), Rule(ask, (Bound(param),), 0)


class Bound:
    """Parameter MIN, MAX or DEF of the query of a setting."""

    def __init__(self, param: Number) -> None:
        self.param, self.name = param, param.name

    def read(self, text: str, bench) -> float:
        """Return the bound that a text names."""
        value = self.param.resolve_bound(text.upper(), bench)
        if value is None:
            raise ScpiError(-224 if text[:1].isalpha() else -104, "MIN, MAX or DEF")
        return value


BYTE = (Number("mask", "", 0, 255, is_whole=1),)
COMMON = [
    ("*CLS", Rule(make_call("session.clear")), None),
    ("*ESE", Rule(enable_events, BYTE), Rule(make_call("session.standard_enable"))),
    ("*ESR", None, Rule(take_events)),
    ("*IDN", None, Rule(read_identity)),
    ("*OPC", Rule(request_completion), Rule(make_constant(1), flags="W")),
    ("*OPT", None, Rule(make_constant("0"))),
    ("*RST", Rule(reset, flags="L"), None),
    ("*SRE", Rule(enable_service, BYTE), Rule(make_call("session.service_enable"))),
    ("*STB", None, Rule(make_call("session.status_byte"))),
    ("*TRG", Rule(make_call("bench.capture.trigger"), flags="L"), None),
    ("*TST", None, Rule(make_call("bench.self_test"))),
    ("*WAI", Rule(make_constant(None), flags="W"), None),
    ("SYSTem:ERRor[:NEXT]", None, Rule(take_error)),
    ("SYSTem:ERRor:ALL", None, Rule(take_errors)),
    ("SYSTem:ERRor:COUNt", None, Rule(count_errors)),
    ("SYSTem:VERSion", None, Rule(make_constant("1999.0"))),
    ("SYSTem:LOCK:REQuest", None, Rule(lock_session)),
    ("SYSTem:LOCK:RELease", Rule(unlock_session, flags="L"), None),
    ("SYSTem:LOCK:OWNer", None, Rule(read_owner)),
    make_setting("SYSTem:LEASe[:TIME]", Number("lease", "s", 0.2, 600.0, LEASE),
                 set_lease, read_lease, "L"),
    ("SYSTem:BOOT", None, Rule(read_boot)),
    ("SYSTem:TIMing", None, Rule(read_timing)),
    ("SYSTem:MEMory", None, Rule(read_memory)),
    ("SYSTem:SETTings:STORe", Rule(store_settings, flags="SL"), None),
    ("SYSTem:SETTings:DEFault", Rule(reset_settings, flags="SL"), None),
    ("SYSTem:SETTings:COUNt", None, Rule(make_call("bench.settings.generation"))),
    ("SYSTem:HELP:HEADers", None, Rule(list_headers)),
    ("SYSTem:MAINtenance", Rule(make_call("bench.hal.enter_maintenance"), flags="SL"), None),
    ("SYSTem:RESet", Rule(restart_board, flags="SL"), None),
    ("STATus:PRESet", Rule(preset_registers), None),
]  # fmt: skip
COMMON += make_register("operation") + make_register("questionable")
