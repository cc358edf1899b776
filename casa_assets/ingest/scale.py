"""How long is a unit: the file's word where it is plausible, else the unit that is, else the usual size."""

from __future__ import annotations

import numpy as np

from casa_assets.errors import Rejected
from casa_assets.ingest.draft import Draft, warning
from casa_assets.model.category import Category
from casa_assets.model.issue import Issue

# Units that meshes are drawn in, metres.
UNITS: dict[str, float] = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001, "inch": 0.0254}


def scale(draft: Draft, category: Category, slack: float) -> Draft:
    """Bring the parts to metres.

    Args:
        draft: z up, file units.
        category: longest_m is the prior.
        slack: how far outside the usual range a stated size is still believed, as a ratio > 1.
    Raises:
        Rejected: the size is not finite (MSH003).
    """
    vertices, _ = draft.soup()
    longest = float(np.ptp(vertices, axis=0).max())
    if not np.isfinite(longest) or longest <= 0 or longest > 1e30:
        raise Rejected("MSH003", f"the longest side is {longest:g} file units; no unit makes a thing of that")
    factor, value, confidence, because = _decide(longest, draft.metres_per_unit, category, slack)
    notes: tuple[Issue, ...] = ()
    if value not in ("as_stated", "metre"):
        notes = (warning("MSH014", "scale", f"rescaled by {factor:.6g}: {because}"),)
    factor = float(f"{factor:.9g}")
    parts = tuple(p.replace(mesh=p.mesh.with_vertices(p.mesh.vertices * factor, p.mesh.normals)) for p in draft.parts)
    return draft.replace(
        parts=parts,
        metres_per_unit=1.0,
        guesses=draft.guessed("scale", f"{factor:.6g} m per unit ({value})", confidence, because),
        notes=draft.noted(*notes),
    )


def _decide(longest: float, stated: float | None, category: Category, slack: float) -> tuple[float, str, float, str]:
    """Factor, its name, confidence 0..1, evidence."""
    span = category.longest_m
    usual = f"a {category.id} is {span.low:g} to {span.high:g} m long"
    if stated is not None and span.low / slack <= longest * stated <= span.high * slack:
        inside = span.low <= longest * stated <= span.high
        return stated, "as_stated", 0.97 if inside else 0.8, f"the file's unit gives {longest * stated:.3g} m; {usual}"
    fits = {
        name: abs(float(np.log(longest * unit / span.typical)))
        for name, unit in UNITS.items()
        if span.low / slack <= longest * unit <= span.high * slack
    }
    # A model that is exactly one unit long was normalised: its size says nothing, unless one metre is usual.
    normalised = abs(longest - 1.0) < 1e-3 or abs(longest - 2.0) < 1e-3
    if fits and not (normalised and "metre" not in fits):
        name = min(fits, key=lambda n: fits[n])
        return (
            UNITS[name],
            name,
            0.85,
            f"{longest:.4g} units read as {name}s are {longest * UNITS[name]:.3g} m; {usual}",
        )
    factor = span.typical / longest
    spread = float(np.log(span.high / span.low))
    return (
        factor,
        "usual_size",
        max(0.2, 0.75 - 0.25 * spread),
        f"no unit fits {longest:.4g} units; set to the usual {span.typical:g} m",
    )
