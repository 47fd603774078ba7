"""Specimens of the enclosure's silicone: each as a row, and those of one material as one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.device.load import materials
from layerjam.errors import FitError
from layerjam.identify.provenance import sha256
from layerjam.identify.rubber import hyperelastic
from layerjam.identify.rubber import tensile as rubber
from layerjam.measure.options import ReadingOptions
from layerjam.measure.trace import Array
from layerjam.records.toml import parse_toml
from layerjam.units import parse

Read = tuple[rubber.Specimen, rubber.Moduli, dict[str, hyperelastic.Fit], str]
"""A specimen, its moduli, the models fitted to it, and the name of the one that was chosen."""
Sheets = Mapping[str, tuple[str, float]]
FEWEST = 20
"""Samples that a model is fitted to at least."""


def data_sheets() -> dict[str, tuple[str, float]]:
    """{silicone of the catalogue: (maker's name, 100 % modulus [Pa] as the catalogue has it)}."""
    out = {}
    for key, text in materials()["silicones"].items():
        tables = parse_toml(text, f"material {key}")
        entry = tables["modulus"]
        value = entry["value"] if isinstance(entry, dict) else entry
        out[key] = (str(tables.get("name", key)), parse(value, "Pa", f"{key} modulus"))
    return out


def read(
    path: str | Path,
    *,
    area: float | None,
    gauge_length: float | None,
    window: tuple[float, float],
    most: float | None,
    options: ReadingOptions,
) -> Read:
    """A file's specimen, its moduli over the strains of `window`, and models up to `most`.

    Raises what `read_rubber` and `moduli` raise, and FitError where too few samples are fitted.
    """
    specimen = rubber.read_rubber(path, area=area, gauge_length=gauge_length, options=options)
    found = rubber.moduli(specimen, window)
    fitted = fits(specimen.strain, specimen.stress, most)
    return specimen, found, fitted, hyperelastic.choose(fitted)[0]


def fits(strain: Array, stress: Array, most: float | None) -> dict[str, hyperelastic.Fit]:
    """Every model fitted to stress [Pa] over strain [-], shape (N,), up to the strain `most`."""
    inside = strain <= (np.inf if most is None else most)
    if inside.sum() < FEWEST:
        raise FitError(
            f"fit to: {int(inside.sum())} samples lie below that strain, {FEWEST} are needed"
        )
    return hyperelastic.fit_all(strain[inside], stress[inside])


def material_of(
    specimen: rubber.Specimen, given: str | None, sheets: Sheets
) -> tuple[str, str] | None:
    """(silicone of the catalogue, how it is known), None where it is not."""
    if given is not None:
        return given, "as given"
    return rubber.material_of(specimen, {k: name for k, (name, _) in sheets.items()})


def row_of_fit(fit: hyperelastic.Fit) -> dict[str, Any]:
    """One model as a table has it, SI."""
    return {
        "parameters": dict(fit.parameters),
        "model_modulus": fit.initial_modulus,
        "rmse": fit.rmse,
        "cross_validated_rmse": fit.cv_rmse,
        "aicc": fit.aicc,
        "stable": fit.stable,
        "stable_to": dict(fit.stable_to),
        "strain_range": list(fit.strain_range),
        "error_at_100": fit.error_at_100,
    }


def row_of(made: Read, name: tuple[str, str] | None, sheets: Sheets) -> dict[str, Any]:
    """One specimen as a table has it, SI; `name` as `material_of` gives it."""
    specimen, found, fitted, model = made
    material, by = name or (None, None)
    sheet = sheets[material][1] if material else None
    return {
        "material": material,
        "material_by": by,
        "modulus_100": found.modulus_100,
        "modulus_100_se": found.modulus_100_se,
        "data_sheet": sheet,
        "difference": _over(found.modulus_100, sheet),
        "initial_modulus": found.initial,
        "initial_modulus_se": found.initial_se,
        "modulus_300": found.modulus_300,
        "strength": found.strength,
        "strain_at_end": found.strain_at_end,
        "model": model,
        **row_of_fit(fitted[model]),
        "sha256": sha256(specimen.path),
    }


def _over(value: float | None, sheet: float | None) -> float | None:
    """How much a modulus is over that of the data sheet, as a part of the latter."""
    return value / sheet - 1 if value is not None and sheet else None


def pooled(
    done: Sequence[Read], rows: Sequence[Mapping[str, Any]], most: float | None
) -> dict[str, Any]:
    """Means and SDs over specimens of one material, and the models fitted to all their curves."""
    fitted = done[0][2]
    if len(done) > 1:
        parts = [hyperelastic.binned(s.strain, s.stress) for s, *_ in done]
        x, y = (np.concatenate([p[i] for p in parts]) for i in range(2))
        order = np.argsort(x, kind="stable")
        fitted = fits(x[order], y[order], most)
    model, why = hyperelastic.choose(fitted)
    sheet = rows[0]["data_sheet"]
    out: dict[str, Any] = {"material": rows[0]["material"], "data_sheet": sheet}
    out |= {"specimens": len(rows), "model": model, "why": why}
    for key in ("modulus_100", "initial_modulus", "modulus_300", "strength", "strain_at_end"):
        column = [row[key] for row in rows]
        if None not in column:
            out[key] = float(np.mean(column))
            if key in ("modulus_100", "initial_modulus") and len(column) > 1:
                out[f"{key}_sd"] = float(np.std(column, ddof=1))
    out["difference"] = _over(out.get("modulus_100"), sheet)
    models = {name: row_of_fit(fit) for name, fit in fitted.items()}
    return {**models[model], **out, "models": models}
