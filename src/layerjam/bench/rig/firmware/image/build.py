"""Building a board's image from Debian packages alone: `make firmware`.

MicroPython's source code, the chip maker's library and the USB stack are from Debian 13. They are
fetched from this machine's mirror with apt's signature check, and compiled with the machine's own
compiler. Our files and the control law are frozen into the image.
"""

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from layerjam.bench.rig import uf2
from layerjam.bench.rig.board import firmware_files, law_hash

FOLDER = Path(__file__).parent
SUITE = "trixie"
SOURCES = {"micropython": "1.25.0+ds-1"}
"""{Debian source: version}."""
BINARIES = {"pico-sdk-source": "2.1.1-1", "tinyusb-source": "0.18.0+dfsg-1"}
"""{Debian package that contains sources: version}."""
KEYS = "/usr/share/keyrings/debian-archive-keyring.gpg"
TOOLS = ("apt-get", "dpkg-source", "dpkg-deb", "cmake", "make", "gcc", "arm-none-eabi-gcc")
NEEDED = (
    "build-essential cmake dpkg-dev python3 debian-archive-keyring gcc-arm-none-eabi "
    "libnewlib-arm-none-eabi"
)
BOARD = "LAYERJAM_PICO"
RAM_END = 0x20040000
RING_SIZE, FAST_SIZE = 24 << 10, 32 << 10
"""Bytes reserved at the end of memory, which the collector does not search: for the samples, and
for those of the accelerometer, which DMA needs aligned to a multiple of their size."""
CHANGES = {
    "micropython/ports/rp2/CMakeLists.txt": [
        (r"(set\(MICROPY_SSL_MBEDTLS )ON", r"\1OFF"),
        (r"\n *mbedtls/mbedtls_port\.c", ""),
        (r"(target_link_libraries\(\$\{MICROPY_TARGET\} )micropy_lib_mbedtls", r"\1m"),
        (r"\n( *)(\$\{MICROPY_PY_DIR\}/)map\.c\n", r"\n\1\2gc.c\n\1\2map.c\n"),
    ],
    "micropython/ports/rp2/mpconfigport.h": [
        (r"(#define MICROPY_SSL_MBEDTLS +)\(1\)", r"\1(0)"),
        (r"(#define MICROPY_PY_HASHLIB_SHA1 +)\(1\)", r"\1(0)"),
        (r"(#define MICROPY_PY_CRYPTOLIB +)\(1\)", r"\1(0)"),
        (r"(#define MICROPY_FLOAT_IMPL +\(MICROPY_FLOAT_IMPL_)FLOAT", r"\1DOUBLE"),
    ],
    "micropython/ports/rp2/mphalport.h": [
        (r"(#define MICROPY_HW_USB_CDC_TX_TIMEOUT )\(500\)", r"\1(0)")
    ],
    "micropython/ports/rp2/memmap_mp_rp2040.ld": [
        (r"(__GcHeapEnd = ORIGIN\(RAM\) \+ LENGTH\(RAM\));", rf"\1 - {RING_SIZE + FAST_SIZE};")
    ],
    "library/usr/src/pico-sdk/src/rp2_common/pico_cxx_options/CMakeLists.txt": [
        (r" *target_sources\(pico_cxx_options INTERFACE\s+\S+new_delete\.cpp\s+\)", "")
    ],
}
"""{unpacked file: replacements in it}.

TLS, SHA-1 and AES are removed, because Debian's source lacks their dependencies. With double
precision the law gives exactly the same results as in CPython. The USB timeout is zero, so that a
host that does not read cannot delay a sample. The collector is compiled for speed, like the
interpreter. The heap ends where the reserved memory begins. An unused C++ file that would need
1.5 GB of libraries is left out.
"""
RESERVED = f"RING, FAST = {RAM_END - FAST_SIZE - RING_SIZE}, {RAM_END - FAST_SIZE}\n"
MANIFEST = 'freeze("$(PORT_DIR)/modules")\nfreeze({folder!r})\n'


def recipe_hash() -> str:
    """Return the SHA-256 of this file and the board's definition: the recipe for the image."""
    paths = [FOLDER / name for name in ("build.py", "mpconfigboard.cmake", "mpconfigboard.h")]
    return hashlib.sha256(b"".join(path.read_bytes() for path in paths)).hexdigest()


def source_hashes() -> dict[str, str]:
    """Return the sources of an image; an image with the same hashes is up to date."""
    return {
        "law_sha256": law_hash(),
        "firmware_sha256": re.findall("FIRMWARE = '(.*)'", firmware_files("pico")["built.py"])[0],
        "recipe_sha256": recipe_hash(),
    }


def is_current(out: Path) -> bool:
    """Return whether a folder contains the image built from these sources."""
    image, facts = out / "layerjam-pico.uf2", out / "layerjam-pico.json"
    if not image.exists() or not facts.exists():
        return False
    earlier = json.loads(facts.read_text("utf-8"))
    digest = hashlib.sha256(image.read_bytes()).hexdigest()
    return {**source_hashes(), "image_sha256": digest}.items() <= earlier.items()


class BuildError(Exception):
    """Raised if the image cannot be built; the message is one sentence."""


def run_command(command: Sequence[str], folder: Path, log: Path, **more: str) -> str:
    """Return the output of a command; raises BuildError with its last lines if it fails."""
    process = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, env={**os.environ, **more}
    )
    with log.open("a", encoding="utf-8") as file:
        file.write(f"$ {' '.join(command)}\n{process.stdout}{process.stderr}\n")
    if process.returncode:
        last = "\n".join((process.stdout + process.stderr).strip().splitlines()[-12:])
        raise BuildError(
            f"{command[0]} failed ({process.returncode}); see its output in {log}\n{last}"
        )
    return process.stdout


def find_mirrors(log: Path) -> list[str]:
    """Return the addresses from which this machine's apt fetches Debian's main packages."""
    output = run_command(
        ["apt-get", "indextargets", "--format", "$(REPO_URI)", "Created-By: Packages",
         "Component: main", "Origin: Debian", "Label: Debian"],
        Path("/"), log,
    )  # fmt: skip
    addresses = list(dict.fromkeys(line.strip() for line in output.splitlines() if line.strip()))
    if not addresses:
        raise BuildError("apt has no Debian mirror on this machine; run 'apt-get update' as root")
    return addresses


def fetch_packages(work: Path, log: Path) -> Path:
    """Return a folder with Debian 13's packages, fetched once; this machine's apt is unchanged."""
    versions = {**SOURCES, **BINARIES}
    packages, marker = work / "debian", work / "debian" / "fetched.json"
    if marker.exists() and json.loads(marker.read_text()) == versions:
        return packages
    shutil.rmtree(packages, ignore_errors=True)
    for name in ("lists/partial", "archives/partial"):
        (packages / name).mkdir(parents=True)
    (packages / "debian.sources").write_text(
        f"Types: deb deb-src\nURIs: {' '.join(find_mirrors(log))}\nSuites: {SUITE}\n"
        f"Components: main\nSigned-By: {KEYS}\n",
        encoding="utf-8",
    )
    options = {
        "Dir::Etc::SourceList": packages / "debian.sources",
        "Dir::Etc::SourceParts": "/dev/null",
        "Dir::State::Lists": packages / "lists",
        "Dir::Cache": packages,
        "APT::Sandbox::User": "root",
    }
    apt = ["apt-get", "-q"]
    for name, value in options.items():
        apt += ["-o", f"{name}={value}"]
    run_command([*apt, "update"], packages, log)
    source = [f"{name}={version}" for name, version in SOURCES.items()]
    run_command([*apt, "source", "--download-only", *source], packages, log)
    run_command([*apt, "download", *(f"{n}={v}" for n, v in BINARIES.items())], packages, log)
    marker.write_text(json.dumps(versions), encoding="utf-8")
    return packages


def unpack_sources(packages: Path, work: Path, log: Path) -> tuple[Path, Path]:
    """Return the folders of MicroPython and the maker's library, changed only by CHANGES."""
    tree, library = work / "micropython", work / "library"
    for folder in (tree, library):
        shutil.rmtree(folder, ignore_errors=True)
    library.mkdir()
    (description,) = packages.glob("micropython_*.dsc")
    run_command(["dpkg-source", "--no-check", "-x", str(description), str(tree)], work, log)
    for package in sorted(packages.glob("*.deb")):
        run_command(["dpkg-deb", "-x", str(package), str(library)], work, log)
    for name, changes in CHANGES.items():
        text = (work / name).read_text(encoding="utf-8")
        for old, new in changes:
            text, count = re.subn(old, new, text)
            if count != 1:
                raise BuildError(f"{name} does not match {SOURCES}, {BINARIES}: {old} not found")
        (work / name).write_text(text, encoding="utf-8")
    return tree, library


def compile_program(tree: Path, library: Path, work: Path, log: Path, jobs: int) -> Path:
    """Return the program for the flash memory, with firmware and law frozen into it."""
    frozen, board = work / "frozen", work / BOARD
    for folder in (frozen, board):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
    for name, text in firmware_files("pico").items():
        (frozen / name).write_text(text, encoding="utf-8")
    (frozen / "reserved.py").write_text(RESERVED, encoding="utf-8")
    manifest = work / "manifest.py"
    manifest.write_text(MANIFEST.format(folder=str(frozen)), encoding="utf-8")
    for name in ("mpconfigboard.h", "mpconfigboard.cmake"):
        shutil.copy(FOLDER / name, board / name)
    sdk = find_file(library, "pico_sdk_init.cmake").parent
    usb = find_file(library, "src/tusb.h").parents[1]
    shutil.rmtree(tree / "lib" / "tinyusb", ignore_errors=True)
    (tree / "lib" / "tinyusb").symlink_to(usb)
    # the same sources must produce the same image at any time and in any folder
    epoch = run_command(
        ["dpkg-parsechangelog", "-l", str(tree / "debian/changelog"), "-STimestamp"], work, log
    )
    same = {"SOURCE_DATE_EPOCH": epoch.strip(), "GIT_DIR": "/nonexistent"}
    run_command(["make", "-C", str(tree / "mpy-cross"), f"-j{jobs}"], work, log, **same)
    build = work / "build"
    shutil.rmtree(build, ignore_errors=True)
    run_command(
        ["cmake", "-S", str(tree / "ports" / "rp2"), "-B", str(build), "-DPICO_NO_PICOTOOL=1",
         f"-DMICROPY_BOARD={BOARD}", f"-DMICROPY_BOARD_DIR={board}", "-DPICO_BUILD_DOCS=0",
         f"-DMICROPY_LIB_DIR={tree}",
         f"-DMICROPY_FROZEN_MANIFEST={manifest}", f"-DPICO_SDK_PATH_OVERRIDE={sdk}"],
        work, log, **same,
    )  # fmt: skip
    run_command(["cmake", "--build", str(build), f"-j{jobs}"], work, log, **same)
    return build / "firmware.bin"


def find_file(folder: Path, name: str) -> Path:
    """Return the file of that name in a folder and its subfolders."""
    paths = sorted(folder.rglob(name))
    if not paths:
        raise BuildError(f"Debian's packages do not contain {name}")
    return paths[0]


def main() -> int:
    """Build the image and print its metadata."""
    words = argparse.ArgumentParser(description="Build the image of a Raspberry Pi Pico.")
    words.add_argument("--out", type=Path, default=Path("out/firmware"), help="folder")
    words.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    words.add_argument(
        "--if-changed", action="store_true", help="build only if the sources have changed"
    )
    args = words.parse_args()
    if args.if_changed and is_current(args.out):
        return 0
    work = args.out.resolve() / "work"
    work.mkdir(parents=True, exist_ok=True)
    log, start = work / "build.log", time.monotonic()
    log.unlink(missing_ok=True)
    made_of = source_hashes()
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    try:
        if missing:
            raise BuildError(f"missing: {' '.join(missing)}; run 'apt-get install {NEEDED}'")
        packages = fetch_packages(work, log)
        program = compile_program(*unpack_sources(packages, work, log), work, log, args.jobs)
    except BuildError as error:
        print(error, file=sys.stderr)
        return 1
    image = args.out / "layerjam-pico.uf2"
    image.write_bytes(uf2.encode_uf2(program.read_bytes(), uf2.RP2040))
    facts = {
        "image": image.name,
        "image_sha256": hashlib.sha256(image.read_bytes()).hexdigest(),
        "program_bytes": program.stat().st_size,
        **made_of,
        "debian": {**SOURCES, **BINARIES},
        "seconds": round(time.monotonic() - start, 1),
    }
    (args.out / "layerjam-pico.json").write_text(json.dumps(facts, indent=2) + "\n")
    print(json.dumps(facts, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
