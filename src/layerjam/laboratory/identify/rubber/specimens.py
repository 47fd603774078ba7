"""Specimens of the enclosure's silicone: one row per specimen, and one result per material."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layerjam.brake.device.load import materials
from layerjam.core.errors import FitError, are_text
from layerjam.core.toml_files.toml import parse_toml
from layerjam.core.units import parse
from layerjam.laboratory.identify.provenance import sha256
from layerjam.laboratory.identify.rubber import hyperelastic
from layerjam.laboratory.identify.rubber import tensile as rubber
from layerjam.laboratory.measure.options import ReadingOptions
from layerjam.laboratory.measure.trace import Array

Read = tuple[rubber.Specimen, rubber.Moduli, dict[str, hyperelastic.Fit], str]
"""A specimen, its moduli, the models fitted to it, and the name of the chosen model."""
Sheets = Mapping[str, tuple[str, float]]
FEWEST = 20
"""Smallest number of samples for a model fit."""


def load_sheets() -> dict[str, tuple[str, float]]:
    """Return {silicone in the catalogue: (maker's name, 100 % modulus [Pa] there)}."""
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
    limit: float | None,
    options: ReadingOptions,
    tare: bool = False,
) -> Read:
    """Return a file's specimen, its moduli in the strain `window`, and models up to `limit`.

    Raises the errors of `read_rubber` and `specimen_moduli`, and FitError for too few samples.
    """
    specimen = rubber.read_rubber(
        path, area=area, gauge_length=gauge_length, options=options, tare=tare
    )
    moduli = rubber.specimen_moduli(specimen, window)
    models = fit_models(specimen.strain, specimen.stress, limit)
    return specimen, moduli, models, hyperelastic.choose_model(models)[0]


def fit_models(strain: Array, stress: Array, limit: float | None) -> dict[str, hyperelastic.Fit]:
    """Fit every model to stress [Pa] and strain [-], shape (N,), up to the strain `limit`."""
    is_inside = strain <= (np.inf if limit is None else limit)
    if is_inside.sum() < FEWEST:
        samples = are_text(int(is_inside.sum()), "sample")
        raise FitError(f"fit to: {samples} below that strain; {FEWEST} are needed")
    return hyperelastic.fit_models(strain[is_inside], stress[is_inside])


def find_silicone(
    specimen: rubber.Specimen, material: str | None, sheets: Sheets
) -> tuple[str, str] | None:
    """Return (silicone in the catalogue, source); None if it is unknown."""
    if material is not None:
        return material, "as given"
    return rubber.find_material(specimen, {k: name for k, (name, _) in sheets.items()})


def make_fit_row(fit: hyperelastic.Fit) -> dict[str, Any]:
    """Return one model as a table row, in SI units."""
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


def make_row(specimen_read: Read, name: tuple[str, str] | None, sheets: Sheets) -> dict[str, Any]:
    """Return one specimen as a table row, in SI units; `name` is from `find_silicone`."""
    specimen, moduli, models, model = specimen_read
    material, basis = name or (None, None)
    sheet = sheets[material][1] if material else None
    return {
        "material": material,
        "material_by": basis,
        "modulus_100": moduli.modulus_100,
        "modulus_100_se": moduli.modulus_100_se,
        "data_sheet": sheet,
        "difference": _relative_difference(moduli.modulus_100, sheet),
        "initial_modulus": moduli.initial,
        "initial_modulus_se": moduli.initial_se,
        "modulus_300": moduli.modulus_300,
        "strength": moduli.strength,
        "strain_at_end": moduli.strain_at_end,
        "model": model,
        **make_fit_row(models[model]),
        "zero": specimen.zero and specimen.zero.force,
        "zero_effect": moduli.zero_effect,
        "drift_effect": moduli.drift_effect,
        "resolution_effect": moduli.resolution_effect,
        "resolution": specimen.quantum,
        "sha256": sha256(specimen.path),
    }


def make_rows(
    specimens: Mapping[str, Read], material: str | None, sheets: Sheets
) -> dict[str, dict[str, Any]]:
    """Return each specimen, {path: Read}, as a table row; `material` is the silicone given."""
    return {
        path: make_row(row, find_silicone(row[0], material, sheets), sheets)
        for path, row in specimens.items()
    }


def _relative_difference(value: float | None, sheet: float | None) -> float | None:
    return value / sheet - 1 if value is not None and sheet else None


def pool(
    specimens: Sequence[Read], rows: Sequence[Mapping[str, Any]], limit: float | None
) -> dict[str, Any]:
    """Return means and SDs over specimens of one material, and models fitted to all curves.

    The result is empty if the rows name several materials.
    """
    if len({row["material"] for row in rows}) > 1:
        return {}
    fits_by_name = specimens[0][2]
    if len(specimens) > 1:
        parts = [hyperelastic.bin_by_strain(s.strain, s.stress) for s, *_ in specimens]
        x, y = (np.concatenate([p[i] for p in parts]) for i in range(2))
        order = np.argsort(x, kind="stable")
        fits_by_name = fit_models(x[order], y[order], limit)
    model, reason = hyperelastic.choose_model(fits_by_name)
    sheet = rows[0]["data_sheet"]
    out: dict[str, Any] = {"material": rows[0]["material"], "data_sheet": sheet}
    out |= {"specimens": len(rows), "model": model, "why": reason}
    for key in ("modulus_100", "initial_modulus", "modulus_300", "strength", "strain_at_end"):
        column = [row[key] for row in rows]
        if None not in column:
            out[key] = float(np.mean(column))
            if key in ("modulus_100", "initial_modulus") and len(column) > 1:
                out[f"{key}_sd"] = float(np.std(column, ddof=1))
    out["difference"] = _relative_difference(out.get("modulus_100"), sheet)
    models = {name: make_fit_row(fit) for name, fit in fits_by_name.items()}
    return {**models[model], **out, "models": models}
