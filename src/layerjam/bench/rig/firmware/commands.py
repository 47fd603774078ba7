"""Headers of this instrument: vacuum, outputs, law, sensor, and ring of samples.

The flags are those of `common.py`; C marks a command that other clients may send despite a lock.
"""

import binascii
import struct

import ring
import store
from acceleration import CAPTURE
from common import COMMON, NO_NUMBER, format_block, format_number, make_call, make_setting, quote
from scpi import Choice, Node, Number, Rule, ScpiError, Text, add_header

from bench import FAULT as FAULTED
from bench import RUN, SAFE, STATES, STEPS

SWITCH = "OFF|ON"


def parse_hex(text: str) -> "bytes | None":
    """Return the bytes that hexadecimal digits represent; None if the text is not hexadecimal."""
    try:
        return binascii.unhexlify(text)
    except ValueError:
        return None


def read_reach(bench) -> float:
    return bench.reach


def set_target(bench, session, value: float) -> None:
    if value != bench.target:
        bench.openings = []
    bench.target = value


def read_target(bench) -> float:
    return bench.target


def set_output(bench, session, switch: int) -> None:
    if switch:
        bench.check_allowed(session, "L")
        bench.switch_on()
    else:
        bench.switch_off()


def read_output(bench, session) -> int:
    return 1 if bench.state == RUN else 0


def abort(bench, session) -> None:
    bench.switch_off()
    bench.capture.stop()


def set_safe_state(bench, session, place: int) -> None:
    bench.settings.safe = place + 1


def read_safe_state(bench, session) -> str:
    return ("NONE", "REL", "HOLD")[bench.settings.safe]


def set_vent_rest(bench, session, place: int) -> None:
    bench.settings.rest = place + 1
    bench.rest_outputs()


def read_vent_rest(bench, session) -> str:
    return ("NONE", "OPEN", "CLOS")[bench.settings.rest]


def is_tripped(bench, session) -> int:
    return 1 if bench.state == FAULTED else 0


def clear_fault(bench, session) -> None:
    bench.fault = 0
    if bench.state == FAULTED:
        bench.state = SAFE


def set_sync(bench, session, switch: int) -> None:
    bench.sync = switch


def set_law(bench, session, text: str, check: str) -> None:
    raw, crc = parse_hex(text), parse_hex(check)
    if raw is None or crc is None:
        raise ScpiError(-230, "the law must be hexadecimal")
    if len(raw) != 8 * store.LAW:
        raise ScpiError(-230, "the law must have %d hexadecimal digits" % (16 * store.LAW))
    if crc != struct.pack(">I", binascii.crc32(raw)):
        raise ScpiError(-230, "the checksum does not match")
    law, wrong = store.parse_law(raw)
    if wrong:
        raise ScpiError(-222, wrong)
    bench.settings.law = law
    bench.update_limits()
    bench.target = min(bench.target, bench.reach)


def read_law(bench, session) -> str:
    if bench.settings.law is None:
        raise ScpiError(-221, "no controller; CONT:LAW sets one")
    raw = store.flatten_law(bench.settings.law)
    return '"%s","%08X"' % (str(binascii.hexlify(raw), "ascii").upper(), binascii.crc32(raw))


def set_zero(bench, session) -> None:
    law = bench.settings.law
    if law is None or bench.vented <= law[1][15]:
        raise ScpiError(-221, "the vent has not been open for long enough")
    if not abs(bench.reading) <= 0.05 * law[1][6]:
        raise ScpiError(-222, "the zero must be within 5 % of the sensor's range")
    bench.settings.offset += bench.reading / bench.settings.gain


def read_zero(bench, session) -> str:
    age = NO_NUMBER if bench.zeroed > 1 << 39 else format_number(bench.zeroed / STEPS)
    return format_number(bench.zero) + "," + age


def calibrate(bench, session, offset: float, gain: float, name: str) -> None:
    settings = bench.settings
    settings.offset, settings.gain, settings.sensor = offset, gain, name


def read_calibration(bench, session) -> str:
    settings = bench.settings
    return "%s,%s,%s" % (
        format_number(settings.offset),
        format_number(settings.gain),
        quote(settings.sensor),
    )


def measure_vacuum(bench, session) -> str:
    return format_number(bench.reading)


def fetch_all_values(bench, session) -> str:
    return "%d,%s,%s,%s,%d,%s,%d" % (
        bench.ring.next - 1, format_number(bench.reading), format_number(bench.target),
        format_number(bench.pump), bench.vent, STATES[bench.state], bench.fault,
    )  # fmt: skip


def fetch_records(bench, session, count: int = 100) -> bytes:
    return format_block(bench.ring.fetch_records(count, session.number))


def acknowledge(bench, session, seq: int) -> None:
    ring = bench.ring
    if not ring.acknowledge(seq, session.number):
        first = ring.find_start(session.number)
        raise ScpiError(-222, "seq must be %d to %d" % (first, ring.next - 1))


def find_next_record(bench, session) -> int:
    return bench.ring.find_start(session.number)


def describe_stream_format(bench, session) -> str:
    return '"%s","%s"' % (ring.LAYOUT, ring.NAMES)


SEQ = Number("seq", "", 0, 4294967295.0, is_whole=1)
TABLE = [
    make_setting(
        "[SOURce]:VACuum[:LEVel][:IMMediate]",
        Number("vacuum", "Pa", 0.0, read_reach, 0.0, empty="no controller; CONT:LAW sets one"),
        set_target, read_target, "L",
    ),
    ("OUTPut[:STATe]", Rule(set_output, (Choice("state", SWITCH),), flags="C"), Rule(read_output)),
    ("ABORt", Rule(abort), None),
    (
        "OUTPut:SAFE",
        Rule(set_safe_state, (Choice("safe state", "RELease|HOLD"),), flags="SL"),
        Rule(read_safe_state),
    ),
    (
        "OUTPut:VENT:REST",
        Rule(set_vent_rest, (Choice("position of the unpowered vent", "OPEN|CLOSed"),), flags="SL"),
        Rule(read_vent_rest),
    ),
    ("OUTPut:PROTection:TRIPped", None, Rule(is_tripped)),
    ("OUTPut:PROTection:FAULt", None, Rule(make_call("bench.fault_text"))),
    ("OUTPut:PROTection:CLEar", Rule(clear_fault, flags="L"), None),
    ("OUTPut:SYNC", Rule(set_sync, (Choice("marker", SWITCH),), flags="L"),
     Rule(make_call("bench.sync"))),
    (
        "CONTrol:LAW",
        Rule(set_law, (Text("law", 16 * store.LAW), Text("checksum", 8)), flags="SL"),
        Rule(read_law),
    ),
    ("SENSe:VACuum:ZERO", Rule(set_zero, flags="SL"), Rule(read_zero)),
    (
        "SENSe:VACuum:CALibration",
        Rule(
            calibrate,
            (Number("zero", "Pa", -1e5, 1e5), Number("gain", "", 0.8, 1.25), Text("name", 40)),
            flags="SL",
        ),
        Rule(read_calibration),
    ),
    ("MEASure[:VACuum]", None, Rule(measure_vacuum)),
    ("FETCh:ALL", None, Rule(fetch_all_values)),
    (
        "FETCh:STReam",
        None,
        Rule(fetch_records, (Number("records", "", 1, ring.BLOCK, 100, is_whole=1),), 0),
    ),
    ("STReam:ACKnowledge", Rule(acknowledge, (SEQ,)), None),
    ("STReam:NEXT", None, Rule(find_next_record)),
    ("STReam:LOST", None, Rule(make_call("bench.ring.lost"))),
    ("STReam:FORMat", None, Rule(describe_stream_format)),
    (
        "DIAGnostic:DRIVe",
        Rule(
            make_call("bench.drive_outputs"),
            (Number("pump", "", -1, 1), Number("vent", "", 0, 1, is_whole=1),
             Number("time", "s", 0, 5)),
            flags="L",
        ),
        None,
    ),
]  # fmt: skip
TABLE = COMMON + TABLE + CAPTURE


def build_tree(bench) -> Node:
    """Return the tree of all headers; `bench.headers` stores their names."""
    root = Node()
    bench.headers = [
        header + ("/qonly/" if command is None else "/nquery/" if query is None else "")
        for header, command, query in TABLE
    ]
    for header, command, query in TABLE:
        add_header(root, header, command, query)
    return root
