"""`sleeve`: modulus and hyperelastic fit of the sleeve's silicone."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from layerjam.commands.answer import Answer, AnyBrake, Quantity, brake_at, si
from layerjam.commands.files import Paths, write_brake
from layerjam.device.file import BrakeFile, updated_text
from layerjam.device.load import materials
from layerjam.errors import FileError, FitError, LayerjamError, QuantityError, UnknownNameError
from layerjam.identify.provenance import sha256
from layerjam.identify.rubber import hyperelastic
from layerjam.identify.rubber import tensile as rubber
from layerjam.measure.options import ReadingOptions
from layerjam.records.source import Source
from layerjam.records.toml import parse_toml
from layerjam.units import QuantitySpec, parse, show

T = TypeVar("T")
AREA = QuantitySpec("m^2", "cross-section of the specimen", lo=1e-9, hi=1e-1)
GAUGE_LENGTH = QuantitySpec("m", "length of the specimen that stretches", lo=1e-4, hi=10)
STRAIN = QuantitySpec("1", "engineering strain", hi=30)


def sleeve(
    files: Paths,
    *,
    area: Quantity | None = None,
    gauge_length: Quantity | None = None,
    window: tuple[Quantity, Quantity] = rubber.WINDOW,
    fit_to: Quantity | None = None,
    material: str | None = None,
    columns: str | None = None,
    decimal: str | None = None,
    brake: AnyBrake | None = None,
    out: str | Path | None = None,
    partial: bool = False,
    force: bool = False,
) -> Answer:
    """Modulus and hyperelastic fit of the sleeve's silicone from ASTM D412 curves.

    `window` is the strain of the initial slope, `fit_to` the largest strain that is fitted. Each
    file is one specimen; specimens of one material are pooled. `material` names the silicone of the
    catalogue to compare with, where the files do not. With `brake` and `out` the mean 100 % modulus
    is written into a copy of the brake. `record` is
    {path: (Specimen, Moduli, {model: Fit}, model)}.
    """
    if (brake is None) != (out is None):
        raise QuantityError("brake and out: give both to write a brake, or neither")
    target = brake_at(brake, None) if brake is not None else None
    section = None if area is None else si(area, AREA, "area")
    length = None if gauge_length is None else si(gauge_length, GAUGE_LENGTH, "gauge length")
    span = si(window[0], STRAIN, "from"), si(window[1], STRAIN, "to")
    if span[0] >= span[1]:
        raise QuantityError(f"from: {span[0]:.3g} is not below to, {span[1]:.3g}")
    top = None if fit_to is None else si(fit_to, STRAIN, "fit to")
    sheets = data_sheets()
    if material is not None and material not in sheets:
        raise UnknownNameError("silicone", material, sheets)

    def use(path: str) -> tuple[rubber.Specimen, rubber.Moduli, dict[str, hyperelastic.Fit], str]:
        specimen = rubber.read_rubber(
            path,
            area=section,
            gauge_length=length,
            options=ReadingOptions(columns=columns, decimal=decimal),
        )
        found = rubber.moduli(specimen, span)
        fits = _fits(specimen.strain, specimen.stress, top)
        return specimen, found, fits, hyperelastic.choose(fits)[0]

    done, refused = _each(files, use)
    names = {p: _material(s, material, sheets) for p, (s, *_) in done.items()}
    warnings = [w for s, m, *_ in done.values() for w in (*s.warnings, *m.warnings)]
    per_file = {path: _of_file(*made, names[path], sheets) for path, made in done.items()}
    kinds = {n[0] if n else None for n in names.values()}
    one = len(kinds) == 1
    values = _pooled(list(done.values()), list(per_file.values()), top) if one else dict.fromkeys(
        _POOLED)  # fmt: skip
    if not one:
        warnings.append(
            "the files are of several materials, so there is no mean; each stands in 'files'"
        )
    written = None
    if target is not None:
        if values["modulus_100"] is None:
            raise FitError("out: no brake is written without one 100 % modulus of all the files")
        text = _with_modulus(target, values, done)
        written, said = write_brake(
            out, lambda stem: updated_text(target, stem, text), force, bool(refused), partial
        )
        warnings += said
        if written and target.brake.scale_factor != 1.0:
            warnings.append(
                f"the scale factor {target.brake.scale_factor:g} was found with the old sleeve; "
                "run 'layerjam calibrate' again"
            )
    return Answer(
        values={
            **values,
            "window": list(span),
            "files": per_file,
            "understood": {p: list(s.understood) for p, (s, *_) in done.items()},
            "refused": refused,
            "file": written,
        },
        units={
            **dict.fromkeys(
                ("modulus_100", "modulus_100_sd", "modulus_300", "initial_modulus",
                 "initial_modulus_sd", "strength", "model_modulus", "rmse", "data_sheet"), "Pa"),
            **dict.fromkeys(("strain_at_end", "window", "strain_range", "difference",
                             "error_at_100", "specimens"), "1"),
        },
        warnings=warnings,
        refused=refused,
        record=done,
    )  # fmt: skip


_POOLED = (
    "material", "specimens", "modulus_100", "modulus_100_sd", "data_sheet", "difference",
    "initial_modulus", "initial_modulus_sd", "modulus_300", "strength", "strain_at_end", "model",
    "parameters", "why", "model_modulus", "strain_range", "rmse", "error_at_100", "stable",
    "models",
)  # fmt: skip


def data_sheets() -> dict[str, tuple[str, float]]:
    """{silicone of the catalogue: (maker's name, 100 % modulus [Pa] as the catalogue has it)}."""
    out = {}
    for key, text in materials()["silicones"].items():
        tables = parse_toml(text, f"material {key}")
        entry = tables["modulus"]
        value = entry["value"] if isinstance(entry, dict) else entry
        out[key] = (str(tables.get("name", key)), parse(value, "Pa", f"{key} modulus"))
    return out


def _fits(x: Any, y: Any, top: float | None) -> dict[str, hyperelastic.Fit]:
    inside = x <= (np.inf if top is None else top)
    if inside.sum() < 20:
        raise FitError(f"fit to: {int(inside.sum())} samples lie below that strain, 20 are needed")
    return hyperelastic.fit_all(x[inside], y[inside])


def _material(
    specimen: rubber.Specimen, given: str | None, sheets: Mapping[str, tuple[str, float]]
) -> tuple[str, str] | None:
    if given is not None:
        return given, "as given"
    return rubber.material_of(specimen, {k: name for k, (name, _) in sheets.items()})


def _of_fit(fit: hyperelastic.Fit) -> dict[str, Any]:
    """One model as JSON has it."""
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


def _of_file(
    specimen: rubber.Specimen, found: rubber.Moduli, fits: Mapping[str, hyperelastic.Fit],
    model: str, name: tuple[str, str] | None, sheets: Mapping[str, tuple[str, float]],
) -> dict[str, Any]:  # fmt: skip
    sheet = sheets[name[0]][1] if name else None
    at_100 = found.modulus_100
    return {
        "material": name[0] if name else None,
        "material_by": name[1] if name else None,
        "modulus_100": at_100,
        "modulus_100_se": found.modulus_100_se,
        "data_sheet": sheet,
        "difference": at_100 / sheet - 1 if at_100 is not None and sheet else None,
        "initial_modulus": found.initial,
        "initial_modulus_se": found.initial_se,
        "modulus_300": found.modulus_300,
        "strength": found.strength,
        "strain_at_end": found.strain_at_end,
        "model": model,
        **_of_fit(fits[model]),
        "sha256": sha256(specimen.path),
    }


def _pooled(
    done: Sequence[tuple[rubber.Specimen, rubber.Moduli, dict[str, hyperelastic.Fit], str]],
    rows: Sequence[Mapping[str, Any]],
    top: float | None,
) -> dict[str, Any]:
    """Means and scatter over specimens of one material, and the fit to all their curves."""
    fits = done[0][2]
    if len(done) > 1:
        parts = [hyperelastic.binned(s.strain, s.stress) for s, *_ in done]
        x, y = (np.concatenate([p[i] for p in parts]) for i in range(2))
        order = np.argsort(x, kind="stable")
        fits = _fits(x[order], y[order], top)
    model, why = hyperelastic.choose(fits)
    out: dict[str, Any] = dict.fromkeys(_POOLED)
    out |= {"material": rows[0]["material"], "specimens": len(rows), "model": model, "why": why}
    out["data_sheet"] = rows[0]["data_sheet"]
    for key in ("modulus_100", "initial_modulus", "modulus_300", "strength", "strain_at_end"):
        column = [row[key] for row in rows]
        if None not in column:
            out[key] = float(np.mean(column))
            if f"{key}_sd" in out and len(column) > 1:
                out[f"{key}_sd"] = float(np.std(column, ddof=1))
    if out["modulus_100"] is not None and out["data_sheet"]:
        out["difference"] = out["modulus_100"] / out["data_sheet"] - 1
    chosen = _of_fit(fits[model])
    out |= {k: v for k, v in chosen.items() if k in out}
    out["models"] = {name: _of_fit(fit) for name, fit in fits.items()}
    return out


def _with_modulus(
    file: BrakeFile, values: Mapping[str, Any], done: Mapping[str, Any]
) -> dict[str, tuple[float, Source]]:
    names = ", ".join(f"{Path(p).name} (SHA-256 {sha256(p)[:12]})" for p in done)
    sd = values["modulus_100_sd"]
    source = Source(
        kind="measured",
        text=f"tensile test after ASTM D412, engineering stress at 100 %, first loading; {names}",
        spread=f"SD {show(sd, 'Pa')} over {values['specimens']} specimens" if sd else "",
    )
    return {"enclosure.modulus": (float(values["modulus_100"]), source)}


def _each(files: Paths, use: Callable[[str], T]) -> tuple[dict[str, T], dict[str, str]]:
    """{path: `use` of it} of the files that can be used, and {path: why} of the others."""
    done: dict[str, T] = {}
    refused: dict[str, str] = {}
    seen: dict[str, str] = {}
    for entry in files:
        path = str(entry)
        try:
            made = use(path)
            digest = sha256(path)
            if digest in seen:
                raise FitError(f"holds the same measurement as {seen[digest]}, which counts once")
            seen[digest] = path
            done[path] = made
        except FileError as error:
            refused[path] = (f"line {error.line}: " if error.line else "") + error.reason
        except LayerjamError as error:
            refused[path] = str(error).removeprefix(f"{path}: ")
    if not done:
        if not refused:
            raise FitError("no file was given")
        path, why = next(iter(refused.items()))
        more = f" ({len(refused) - 1} more files were refused too)" if len(refused) > 1 else ""
        raise FileError(path, why + more)
    return done, refused
