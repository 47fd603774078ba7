"""What `recompute` does with a published dataset."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from layerjam.commands.dataset_stages import STAGES, USES, computed, how_of, values_of
from layerjam.commands.declare import Progress
from layerjam.dataset import checksums, comparison, crate
from layerjam.dataset.recipe import read_recipe, versions
from layerjam.dataset.unpack import opened
from layerjam.errors import FileError


def again(source: Path, tell: Progress) -> dict[str, Any]:
    """Compute a dataset's numbers once more; what the result's keys say of it."""
    with opened(source) as root:
        recipe, listed = read_recipe(root), checksums.read(root)
        changed = checksums.changed(root, listed)
        known = {*listed, checksums.NAME, crate.METADATA}
        added = [name for name in checksums.inside(root) if name not in known]
        try:
            published = json.loads((root / recipe.results).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            raise FileError(root / recipe.results, "holds no results that can be read") from None
        used = {use: list(getattr(recipe, use)) for use in USES}
        content = computed(root, recipe.brake, used, how_of(recipe, root), tell)
        made = values_of(content, root, used)
    wanted = {stage: published.get(stage) for stage in STAGES if published.get(stage)}
    differs = list(comparison.differences(wanted, made, recipe.results))
    return dict(
        equal=not (differs or changed),
        numbers=comparison.count(wanted),
        differs=[vars(one) for one in differs],
        changed_files=changed,
        added_files=added,
        versions={"published": dict(recipe.versions), "recomputed": versions()},
        record=differs,
    )
