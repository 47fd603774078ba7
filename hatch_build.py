"""Build hook: a wheel contains the C kernel for each platform if the package ziglang is there."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
import tempfile
from itertools import product
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


def build_engines(folder: Path) -> list[Path]:
    """Compile LIBRARIES reproducibly for every machine in TARGETS; return the files in `folder`.

    If $LAYERJAM_SYSTEMS lists systems, such as "linux darwin", only their machines are included.
    Raises ValueError if it lists an unknown one, and CompilerError if the Python package ziglang is
    missing.
    """
    from layerjam.brake.kernel.compiler import (
        FLAGS,
        LIBRARIES,
        TARGETS,
        engine_name,
        find_cross_compiler,
        run_compiler,
    )

    paths = []
    known = {system for system, _ in TARGETS}
    systems = set(os.environ.get("LAYERJAM_SYSTEMS", "").split()) or known
    if unknown := systems - known:
        names = ", ".join(sorted(unknown))
        raise ValueError(f"LAYERJAM_SYSTEMS: {names} is not one of {', '.join(sorted(known))}")
    targets = [(machine, target) for machine, target in TARGETS.items() if machine[0] in systems]
    for sources, (machine, target) in product(LIBRARIES, targets):
        path = folder / engine_name(sources, (), machine)
        # omit debug information, which would contain the source folder
        options = [*FLAGS, "-g0", "-s", "-shared"]
        if machine[0] != "win32":
            options.append("-fPIC")
        if machine[0] == "darwin":  # without the name, it would contain the temporary folder
            options.append(f"-Wl,-install_name,@rpath/{path.name}")
        words = [*find_cross_compiler(target), *options, *map(str, sources)]
        run_compiler(words, path, libraries=("-lm",))
        paths.append(path)
    return paths


class KernelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the kernel into a temporary folder; nothing is written into the sources."""

    folder: str | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the compiled kernels to a wheel; without ziglang users' machines compile it."""
        if version == "editable" or importlib.util.find_spec("ziglang") is None:
            return
        sys.path.insert(0, str(Path(self.root) / "src"))
        self.folder = tempfile.mkdtemp(prefix="layerjam-kernel-")
        for path in build_engines(Path(self.folder)):
            build_data["force_include"][str(path)] = f"layerjam/brake/kernel/built/{path.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the temporary folder."""
        if self.folder is not None:
            shutil.rmtree(self.folder)
