"""A small importer of FMUs by ctypes: co-simulation, for tests without one from outside."""

from __future__ import annotations

import ctypes
import zipfile
from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

D, U, B, P, S = (
    ctypes.c_double,
    ctypes.c_uint32,
    ctypes.c_bool,
    ctypes.c_void_p,
    ctypes.c_char_p,
)
SIZE = ctypes.c_size_t
LOG3 = ctypes.CFUNCTYPE(None, P, ctypes.c_int, S, S)
LOG2 = ctypes.CFUNCTYPE(None, P, S, ctypes.c_int, S, S, S)
FOLDERS = {"3": "x86_64-linux", "2": "linux64"}


class Callbacks(ctypes.Structure):
    _fields_ = (("log", LOG2), ("make", P), ("free", P), ("finished", P), ("environment", P))


class Refused(Exception):
    """The FMU answered an error, with its message."""


class Unit:
    """One instance. Raises Refused with the FMU's own message."""

    def __init__(
        self,
        archive: Path,
        folder: Path,
        version: str,
        *,
        token: str | None = None,
        exchange: bool = False,
    ):
        self.version, self.said = version, ""
        with zipfile.ZipFile(archive) as packed:
            packed.extractall(folder)
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        listed = "ModelVariables/*" if version == "3" else "ModelVariables/ScalarVariable"
        self.references = {
            one.attrib["name"]: int(one.attrib["valueReference"]) for one in root.findall(listed)
        }
        real = root.attrib["instantiationToken" if version == "3" else "guid"]
        binary = next((folder / "binaries" / FOLDERS[version]).iterdir())
        self.library = ctypes.CDLL(str(binary))
        self._log3 = LOG3(lambda _e, _s, _c, message: self._note(message))
        self._log2 = LOG2(lambda _e, _n, _s, _c, _f, message: self._note(message))
        given = (token or real).encode()
        if version == "3":
            self.handle = self._made3(given, folder / "resources", exchange)
        else:
            self._back = Callbacks(log=self._log2)
            make = self.library.fmi2Instantiate
            make.restype, make.argtypes = P, (S, ctypes.c_int, S, S, P, ctypes.c_int, ctypes.c_int)
            where = (folder / "resources").as_uri().encode()
            self.handle = make(
                b"one", int(not exchange), given, where, ctypes.byref(self._back), 0, 0
            )
        if not self.handle:
            raise Refused(self.said)

    def _made3(self, token: bytes, folder: Path, exchange: bool) -> int | None:
        where = str(folder).encode() + b"/"
        if exchange:
            make = self.library.fmi3InstantiateModelExchange
            make.restype, make.argtypes = P, (S, S, S, B, B, P, LOG3)
            return make(b"one", token, where, False, False, None, self._log3)
        make = self.library.fmi3InstantiateCoSimulation
        make.restype, make.argtypes = P, (S, S, S, B, B, B, B, P, SIZE, P, LOG3, P)
        flags = (False, False, False, False)
        return make(b"one", token, where, *flags, None, 0, None, self._log3, None)

    def _note(self, message: bytes) -> None:
        self.said = message.decode()

    def call(self, name: str, *args: object) -> None:
        status = getattr(self.library, f"fmi{self.version}{name}")(P(self.handle), *args)
        if status != 0:
            raise Refused(self.said)

    def set(self, **values: float) -> None:
        self.set_by({name.replace("__", "."): value for name, value in values.items()})

    def set_by(self, values: Mapping[str, float]) -> None:
        n = len(values)
        references = (U * n)(*(self.references.get(name, 999) for name in values))
        numbers = (D * n)(*values.values())
        if self.version == "3":
            self.call("SetFloat64", references, SIZE(n), numbers, SIZE(n))
        else:
            self.call("SetReal", references, SIZE(n), numbers)

    def get(self, name: str) -> float:
        made, reference = (D * 1)(), (U * 1)(self.references.get(name, 999))
        if self.version == "3":
            self.call("GetFloat64", reference, SIZE(1), made, SIZE(1))
        else:
            self.call("GetReal", reference, SIZE(1), made)
        return made[0]

    def flag(self, name: str) -> bool:
        reference = (U * 1)(self.references[name])
        if self.version == "3":
            made = (B * 1)()
            self.call("GetBoolean", reference, SIZE(1), made, SIZE(1))
            return made[0]
        whole = (ctypes.c_int * 1)()
        self.call("GetBoolean", reference, SIZE(1), whole)
        return bool(whole[0])

    def start(self, **values: float) -> None:
        if self.version == "3":
            self.call("EnterInitializationMode", B(False), D(0), D(0), B(False), D(0))
        else:
            self.call("EnterInitializationMode")
        self.set(**values)
        self.call("ExitInitializationMode")

    def step(self, time: float, length: float) -> None:
        if self.version == "3":
            outs = [ctypes.byref(B()) for _ in range(3)]
            last = ctypes.byref(D())
            self.call("DoStep", D(time), D(length), B(True), *outs, last)
        else:
            self.call("DoStep", D(time), D(length), ctypes.c_int(1))

    def pull(self, path: np.ndarray, vacuum: np.ndarray) -> np.ndarray:
        """Forces [N] along a history, one step each, straight from point to point."""
        made = []
        for i, (elongation, under) in enumerate(zip(path, vacuum, strict=True)):
            self.set(elongation=elongation, vacuum=under)
            self.step(float(i), 1.0)
            made.append(self.get("force"))
        return np.array(made)

    def slope(self, output: str, of: str) -> float:
        unknown, known = (U * 1)(self.references[output]), (U * 1)(self.references[of])
        seed, made = (D * 1)(1.0), (D * 1)()
        n = SIZE(1)
        if self.version == "3":
            self.call("GetDirectionalDerivative", unknown, n, known, n, seed, n, made, n)
        else:
            self.call("GetDirectionalDerivative", unknown, n, known, n, seed, made)
        return made[0]

    def saved(self) -> bytes:
        name = "FMUState" if self.version == "3" else "FMUstate"
        state, size = P(), SIZE()
        self.call(f"Get{name}", ctypes.byref(state))
        self.call(f"Serialized{name}Size", state, ctypes.byref(size))
        made = (ctypes.c_ubyte * size.value)()
        self.call(f"Serialize{name}", state, made, size)
        self.call(f"Free{name}", ctypes.byref(state))
        return bytes(made)

    def restore(self, given: bytes) -> None:
        name = "FMUState" if self.version == "3" else "FMUstate"
        back = "Deserialize" if self.version == "3" else "DeSerialize"
        state = P()
        made = (ctypes.c_ubyte * len(given))(*given)
        self.call(f"{back}{name}", made, SIZE(len(given)), ctypes.byref(state))
        self.call(f"Set{name}", state)
        self.call(f"Free{name}", ctypes.byref(state))
