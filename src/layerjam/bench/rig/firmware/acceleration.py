"""SCPI headers for the accelerometer's record and its trigger."""

import binascii

from capture import READ
from common import format_block, make_call, make_setting
from scpi import Choice, Number, Rule


def capture_setting(header: str, number: Number, name: str, flags: str) -> tuple:
    """Return the header of a numeric capture setting, which cannot be set while a capture runs."""

    def set_value(bench, session, value) -> None:
        bench.capture.require_idle()
        setattr(bench.capture, name, value)

    def read_value(bench):
        return getattr(bench.capture, name)

    return make_setting(header, number, set_value, read_value, flags)


def set_source(bench, session, place: int) -> None:
    bench.capture.require_idle()
    bench.capture.source = place


def read_source(bench, session) -> str:
    return ("IMM", "BUS", "ACC", "EXT")[bench.capture.source]


def read_scale(bench, session) -> str:
    return '"%s"' % str(binascii.hexlify(bench.capture.pack_scale()), "ascii").upper()


def read_data(bench, session, first: int, count: int) -> bytes:
    return format_block(bench.capture.data(first, count))


CAPTURE = [
    capture_setting(
        "SENSe:ACCeleration:RATE", Number("rate", "Hz", 500, 20000, 8000, is_whole=1), "rate", "SL"
    ),
    capture_setting("SENSe:ACCeleration:PRE", Number("pre", "s", 0.0, 0.5, 0.1), "before", "SL"),
    capture_setting("SENSe:ACCeleration:POST", Number("post", "s", 0.01, 1.5, 0.5), "after", "SL"),
    (
        "TRIGger:SOURce",
        Rule(set_source, (Choice("source", "IMMediate|BUS|ACCeleration|EXTernal"),), flags="L"),
        Rule(read_source),
    ),
    capture_setting("TRIGger:LEVel", Number("level", "g", 0.5, 200.0, 5.0), "level", "L"),
    capture_setting("TRIGger:FALL", Number("fall", "s", 0.0, 0.5, 0.03), "fall", "L"),
    ("INITiate", Rule(make_call("bench.capture.start"), flags="L"), None),
    ("FETCh:ACCeleration:STATe", None, Rule(make_call("bench.capture.format_state"))),
    ("FETCh:ACCeleration:SCALe", None, Rule(read_scale)),
    (
        "FETCh:ACCeleration:DATA",
        None,
        Rule(
            read_data,
            (Number("first", "", 0, 16383, is_whole=1), Number("samples", "", 1, READ, is_whole=1)),
        ),
    ),
]
