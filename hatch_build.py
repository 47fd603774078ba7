"""Build hook: a wheel contains the C kernel for each platform if the package ziglang is there."""

from __future__ import annotations

import importlib.util
import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class KernelHook(BuildHookInterface):  # type: ignore[type-arg]
    """Compiles the kernel into a temporary folder; nothing is written into the sources."""

    folder: str | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the compiled kernels to a wheel; without ziglang users' machines compile it."""
        if version == "editable" or importlib.util.find_spec("ziglang") is None:
            return
        sys.path.insert(0, str(Path(self.root) / "src"))
        from layerjam.brake.kernel.compiler import build_shipped_engines

        self.folder = tempfile.mkdtemp(prefix="layerjam-kernel-")
        for path in build_shipped_engines(Path(self.folder)):
            build_data["force_include"][str(path)] = f"layerjam/brake/kernel/built/{path.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the temporary folder."""
        if self.folder is not None:
            shutil.rmtree(self.folder)
