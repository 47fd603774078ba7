"""Every header of the instrument: its parameters, who may use it and when, and what it does.

Flags: L is refused to others while the instrument is locked, S is for SAFE alone.
"""

import binascii
import struct

import built
import ring
import status
import store
from bench import FAULT as FAULTED
from bench import LEASE, RUN, SAFE, STATES, STEPS
from scpi import Choice, Node, Number, Rule, ScpiError, Text, grow

VERSION = "0.1"
NO_NUMBER = "9.91E37"
SWITCH = "OFF|ON"


def shown(value: float) -> str:
    """A number as SCPI prints it."""
    return "%.9g" % value if value == value else NO_NUMBER


def block(data: bytes) -> bytes:
    """A definite-length block."""
    size = b"%d" % len(data)
    return b"#%d" % len(size) + size + data


def bytes_of(text: str) -> "bytes | None":
    """What hexadecimal digits stand for, None where they are none."""
    try:
        return binascii.unhexlify(text)
    except ValueError:
        return None


# ---- IEEE 488.2


def clear(bench, session) -> None:
    session.clear()


def identity(bench, session) -> str:
    model, serial = bench.hal.identity()
    digits = "double" if 1.0 + 1e-12 != 1.0 else "single"
    return "layerjam,%s,%s,%s/law-%s/%s" % (model, serial, VERSION, built.LAW[:8], digits)


def events(bench, session) -> int:
    seen, session.standard = session.standard, 0
    return seen


def enable(bench, session, mask: int) -> None:
    session.standard_enable = mask


def enabled(bench, session) -> int:
    return session.standard_enable


def serve(bench, session, mask: int) -> None:
    session.service_enable = mask & ~64


def served(bench, session) -> int:
    return session.service_enable


def complete(bench, session) -> None:
    session.standard |= status.COMPLETE


def one(bench, session) -> int:
    return 1


def none(bench, session) -> None:
    return None


def reset(bench, session) -> None:
    bench.off()
    bench.target, bench.sync = 0.0, 0


def trigger(bench, session) -> None:
    raise ScpiError(-211, "nothing waits for one")


def byte(bench, session) -> int:
    return session.byte()


def self_test(bench, session) -> int:
    return bench.self_test()


def options(bench, session) -> str:
    return "0"


# ---- SYSTem and STATus


def error(bench, session) -> str:
    return session.next(built.FAULTS)


def errors(bench, session) -> str:
    out = [session.next(built.FAULTS)]
    while session.errors:
        out.append(session.next(built.FAULTS))
    return ",".join(out)


def error_count(bench, session) -> int:
    return len(session.errors)


def scpi_version(bench, session) -> str:
    return "1999.0"


def lock(bench, session) -> int:
    if bench.owner < 0:
        bench.owner = session.number
    return 1 if bench.owner == session.number else 0


def unlock(bench, session) -> None:
    bench.owner = -1


def owner(bench, session) -> str:
    mine = bench.owner == session.number
    return '"NONE"' if bench.owner < 0 else '"SELF"' if mine else '"SESSION %d"' % bench.owner


def lease(bench, session, time: float) -> None:
    bench.lease = time


def leased(bench) -> float:
    return bench.lease


def boot(bench, session) -> str:
    up = bench.count // STEPS
    return '"%08X","%s",%d,"%s"' % (bench.boot, bench.cause, up, built.FIRMWARE[:16])


def timing(bench, session) -> str:
    bins = ",".join([str(count) for count in bench.lateness])
    return "%d,%d,%s,%s,%s,%s" % (
        bench.count, bench.late, shown(bench.worst * 1e-6), shown(bench.slowest * 1e-6),
        shown(bench.hal.collected * 1e-6), bins,
    )  # fmt: skip


def settings_store(bench, session) -> None:
    if bench.hal.since_save() < 1000000:
        raise ScpiError(-221, "settings are stored once a second at most")
    store.save(bench.hal, bench.settings)
    bench.trouble = 0


def settings_default(bench, session) -> None:
    generation, bench.settings = bench.settings.generation, store.Settings()
    bench.settings.generation = generation
    bench.learn()
    bench.rest()


def settings_count(bench, session) -> int:
    return bench.settings.generation


def headers(bench, session) -> bytes:
    return block("\n".join([name for name, _, _ in TABLE]).encode())


def maintenance(bench, session) -> None:
    bench.hal.maintenance()


def restart(bench, session) -> None:
    bench.rest()
    bench.hal.reset()


def preset(bench, session) -> None:
    session.operation.enable = session.questionable.enable = 0


def register(name: str) -> list:
    """The five headers of one of the two SCPI registers."""

    def event(bench, session) -> int:
        return getattr(session, name).taken()

    def condition(bench, session) -> int:
        return getattr(session, name).condition

    def mask(bench, session, value: int) -> None:
        getattr(session, name).enable = value

    def masked(bench, session) -> int:
        return getattr(session, name).enable

    head = "STATus:" + ("OPERation" if name == "operation" else "QUEStionable")
    return [
        (head + "[:EVENt]", None, Rule(event)),
        (head + ":CONDition", None, Rule(condition)),
        (head + ":ENABle", Rule(mask, (Number("mask", "", 0, 32767, whole=1),)), Rule(masked)),
    ]


# ---- vacuum and outputs


def reach(bench) -> float:
    return bench.reach


def vacuum(bench, session, value: float) -> None:
    if value != bench.target:
        bench.openings = []
    bench.target = value


def target(bench) -> float:
    return bench.target


def output(bench, session, on: int) -> None:
    if on:
        bench.may(session, "L")
        bench.on()
    else:
        bench.off()


def output_now(bench, session) -> int:
    return 1 if bench.state == RUN else 0


def abort(bench, session) -> None:
    bench.off()


def safe_state(bench, session, place: int) -> None:
    bench.settings.safe = place + 1


def safe_state_now(bench, session) -> str:
    return ("NONE", "REL", "HOLD")[bench.settings.safe]


def vent_rest(bench, session, place: int) -> None:
    bench.settings.rest = place + 1
    bench.rest()


def vent_rest_now(bench, session) -> str:
    return ("NONE", "OPEN", "CLOS")[bench.settings.rest]


def tripped(bench, session) -> int:
    return 1 if bench.state == FAULTED else 0


def fault(bench, session) -> str:
    return bench.fault_text()


def fault_clear(bench, session) -> None:
    bench.fault = 0
    if bench.state == FAULTED:
        bench.state = SAFE


def sync(bench, session, on: int) -> None:
    bench.sync = on


def synced(bench, session) -> int:
    return bench.sync


def law_set(bench, session, text: str, check: str) -> None:
    raw, crc = bytes_of(text), bytes_of(check)
    if raw is None or crc is None:
        raise ScpiError(-230, "the law is hexadecimal")
    if len(raw) != 8 * store.LAW:
        raise ScpiError(-230, "the law has %d hexadecimal digits" % (16 * store.LAW))
    if crc != struct.pack(">I", binascii.crc32(raw)):
        raise ScpiError(-230, "the checksum is another")
    made, wrong = store.law_of(raw)
    if wrong:
        raise ScpiError(-222, wrong)
    bench.settings.law = made
    bench.learn()
    bench.target = min(bench.target, bench.reach)


def law_now(bench, session) -> str:
    if bench.settings.law is None:
        raise ScpiError(-221, "no regulator; CONT:LAW")
    raw = store.flat(bench.settings.law)
    return '"%s","%08X"' % (str(binascii.hexlify(raw), "ascii").upper(), binascii.crc32(raw))


def zero(bench, session) -> None:
    made = bench.settings.law
    if made is None or bench.vented <= made[1][15]:
        raise ScpiError(-221, "the vent is not open for long enough")
    if not abs(bench.reading) <= 0.05 * made[1][6]:
        raise ScpiError(-222, "the zero is within 5 % of the sensor's range")
    bench.settings.offset += bench.reading / bench.settings.gain


def zero_now(bench, session) -> str:
    age = NO_NUMBER if bench.zeroed > 1 << 39 else shown(bench.zeroed / STEPS)
    return shown(bench.zero) + "," + age


def calibrate(bench, session, offset: float, gain: float, name: str) -> None:
    made = bench.settings
    made.offset, made.gain, made.sensor = offset, gain, name


def calibration(bench, session) -> str:
    made = bench.settings
    return '%s,%s,"%s"' % (shown(made.offset), shown(made.gain), made.sensor)


def measure(bench, session) -> str:
    return shown(bench.reading)


def fetch_all(bench, session) -> str:
    return "%d,%s,%s,%s,%d,%s,%d" % (
        bench.ring.next - 1, shown(bench.reading), shown(bench.target), shown(bench.pump),
        bench.vent, STATES[bench.state], bench.fault,
    )  # fmt: skip


def stream(bench, session, count: int = 100) -> bytes:
    return block(bench.ring.fetch(count))


def acknowledge(bench, session, seq: int) -> None:
    held = bench.ring
    if not held.acknowledge(seq, session.number):
        raise ScpiError(-222, "seq is %d to %d" % (held.kept, held.next - 1))


def stream_next(bench, session) -> int:
    return bench.ring.kept


def stream_lost(bench, session) -> int:
    return bench.ring.lost


def stream_format(bench, session) -> str:
    return '"%s","%s"' % (ring.LAYOUT, ring.NAMES)


def drive(bench, session, pump: float, vent: int, time: float) -> None:
    bench.drive(pump, vent, time)


def setting(header: str, param: Number, take, now, flags: str) -> tuple:
    """A header that sets a number and asks for it; the query also for MIN, MAX and DEF."""

    def ask(bench, session, word=None) -> str:
        return shown(now(bench) if word is None else word)

    return header, Rule(take, (param,), flags=flags), Rule(ask, (Bound(param),), 0)


class Bound:
    """MIN, MAX or DEF of a setting."""

    def __init__(self, param: Number) -> None:
        self.param, self.name = param, param.name

    def read(self, text: str, bench) -> float:
        """The bound."""
        value = self.param.named(text.upper(), bench)
        if value is None:
            raise ScpiError(-224 if text[:1].isalpha() else -104, "MIN, MAX or DEF")
        return value


BYTE = (Number("mask", "", 0, 255, whole=1),)
SEQ = Number("seq", "", 0, 4294967295.0, whole=1)
TABLE = [
    ("*CLS", Rule(clear), None),
    ("*ESE", Rule(enable, BYTE), Rule(enabled)),
    ("*ESR", None, Rule(events)),
    ("*IDN", None, Rule(identity)),
    ("*OPC", Rule(complete), Rule(one)),
    ("*OPT", None, Rule(options)),
    ("*RST", Rule(reset, flags="L"), None),
    ("*SRE", Rule(serve, BYTE), Rule(served)),
    ("*STB", None, Rule(byte)),
    ("*TRG", Rule(trigger, flags="L"), None),
    ("*TST", None, Rule(self_test)),
    ("*WAI", Rule(none), None),
    ("SYSTem:ERRor[:NEXT]", None, Rule(error)),
    ("SYSTem:ERRor:ALL", None, Rule(errors)),
    ("SYSTem:ERRor:COUNt", None, Rule(error_count)),
    ("SYSTem:VERSion", None, Rule(scpi_version)),
    ("SYSTem:LOCK:REQuest", None, Rule(lock)),
    ("SYSTem:LOCK:RELease", Rule(unlock, flags="L"), None),
    ("SYSTem:LOCK:OWNer", None, Rule(owner)),
    setting("SYSTem:LEASe[:TIME]", Number("lease", "s", 0.2, 600.0, LEASE), lease, leased, "L"),
    ("SYSTem:BOOT", None, Rule(boot)),
    ("SYSTem:TIMing", None, Rule(timing)),
    ("SYSTem:SETTings:STORe", Rule(settings_store, flags="SL"), None),
    ("SYSTem:SETTings:DEFault", Rule(settings_default, flags="SL"), None),
    ("SYSTem:SETTings:COUNt", None, Rule(settings_count)),
    ("SYSTem:HELP:HEADers", None, Rule(headers)),
    ("SYSTem:MAINtenance", Rule(maintenance, flags="SL"), None),
    ("SYSTem:RESet", Rule(restart, flags="SL"), None),
    ("STATus:PRESet", Rule(preset), None),
    setting(
        "[SOURce]:VACuum[:LEVel][:IMMediate]", Number("vacuum", "Pa", 0.0, reach, 0.0), vacuum,
        target, "L",
    ),
    ("OUTPut[:STATe]", Rule(output, (Choice("state", SWITCH),)), Rule(output_now)),
    ("ABORt", Rule(abort), None),
    (
        "OUTPut:SAFE",
        Rule(safe_state, (Choice("safe state", "RELease|HOLD"),), flags="SL"),
        Rule(safe_state_now),
    ),
    (
        "OUTPut:VENT:REST",
        Rule(vent_rest, (Choice("vent without power", "OPEN|CLOSed"),), flags="SL"),
        Rule(vent_rest_now),
    ),
    ("OUTPut:PROTection:TRIPped", None, Rule(tripped)),
    ("OUTPut:PROTection:FAULt", None, Rule(fault)),
    ("OUTPut:PROTection:CLEar", Rule(fault_clear, flags="L"), None),
    ("OUTPut:SYNC", Rule(sync, (Choice("marker", SWITCH),), flags="L"), Rule(synced)),
    (
        "CONTrol:LAW",
        Rule(law_set, (Text("law", 16 * store.LAW), Text("checksum", 8)), flags="SL"),
        Rule(law_now),
    ),
    ("SENSe:VACuum:ZERO", Rule(zero, flags="SL"), Rule(zero_now)),
    (
        "SENSe:VACuum:CALibration",
        Rule(
            calibrate,
            (Number("zero", "Pa", -1e5, 1e5), Number("gain", "", 0.8, 1.25), Text("name", 40)),
            flags="SL",
        ),
        Rule(calibration),
    ),
    ("MEASure[:VACuum]", None, Rule(measure)),
    ("FETCh:ALL", None, Rule(fetch_all)),
    (
        "FETCh:STReam",
        None,
        Rule(stream, (Number("records", "", 1, ring.MOST, 100, whole=1),), 0),
    ),
    ("STReam:ACKnowledge", Rule(acknowledge, (SEQ,), flags="L"), None),
    ("STReam:NEXT", None, Rule(stream_next)),
    ("STReam:LOST", None, Rule(stream_lost)),
    ("STReam:FORMat", None, Rule(stream_format)),
    (
        "DIAGnostic:DRIVe",
        Rule(
            drive,
            (Number("pump", "", -1, 1), Number("vent", "", 0, 1, whole=1),
             Number("time", "s", 0, 5)),
            flags="SL",
        ),
        None,
    ),
]  # fmt: skip
TABLE += register("operation") + register("questionable")


def tree() -> Node:
    """The tree of all headers."""
    root = Node()
    for header, command, query in TABLE:
        grow(root, header, command, query)
    return root
