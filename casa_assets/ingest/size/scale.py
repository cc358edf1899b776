"""Choose metres per unit: as the file states where plausible, else a usual unit, else by the usual size per axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import erf, log, pi, sqrt

import numpy as np

from casa_assets.core.rounding import significant
from casa_assets.core.typing import Floats
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.geometry.mesh.measure import signed_volume
from casa_assets.geometry.solid.hull import convex_hull
from casa_assets.ingest.draft import Draft, warning
from casa_assets.ingest.size.size_phrases import StatedSize, parse_size_phrases
from casa_assets.model.issue import Issue
from casa_assets.model.registry.category import Category, MatterFill

# Units that meshes are drawn in, metres.
UNITS: dict[str, float] = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001, "inch": 0.0254}
# How often each is meant where the format states none, and where what it states cannot be; the rest is no unit at all:
# sculpted by eye, or normalised.
UNIT_PRIOR_SILENT = {"metre": 0.40, "centimetre": 0.17, "millimetre": 0.20, "inch": 0.08}
UNIT_PRIOR_WRONG = {"metre": 0.02, "centimetre": 0.25, "millimetre": 0.25, "inch": 0.12}
UNIT_PRIOR_GENERATED = {"metre": 0.20, "centimetre": 0.02, "millimetre": 0.02, "inch": 0.01}
# What no unit says is spread over that many nats: five decades.
PRIOR_NATS = 11.5
# A longest side or a diagonal of one of these is the work of a normaliser, to a thousandth.
NORMALISED_LENGTHS = (0.5, 1.0, 2.0, 10.0, 100.0)
# A guess is right when it is within this factor of the truth.
CORRECT_FACTOR = 1.25
# A size that the category alone gives is never surer than this: there are odd ones everywhere.
MAX_CONFIDENCE = 0.85
# Nor is any unit where nobody knows what the thing is.
MAX_CONFIDENCE_UNKNOWN = 0.6
# Spread of a stated length about the side that it names, and of a stated volume about the size that it makes; log.
LENGTH_SPREAD, VOLUME_SPREAD = 0.06, 0.12
# What it holds over the volume of its hull.
CAPACITY_SHARE = {MatterFill.VESSEL: 0.7, MatterFill.HOLLOW: 0.6, MatterFill.FILLED: 0.85, MatterFill.SOLID: 1.0}


@dataclass(frozen=True)
class SizePrior:
    """Metres per unit as a log normal before the file's units are looked at, and where it comes from."""

    middle: float
    spread: float
    message: str


@dataclass(frozen=True)
class ScaleDecision:
    """Metres per unit, the name of that, confidence 0..1, evidence."""

    factor: float
    value: str
    confidence: float
    reason: str


def scale(
    draft: Draft,
    category: Category,
    slack: float,
    texts: Sequence[str] = (),
    generated: bool = False,
    size_m: float = 0,
) -> Draft:
    """Bring the parts to metres.

    Args:
        draft: z up, file units.
        category: its extents are the prior, per axis.
        slack: how far outside the usual range a stated size is still believed, as a ratio > 1.
        texts: titles and prompts, which may name a size. generated: from a text-to-3D generator.
        size_m: longest side as a person decided it, metres; 0 where nobody did.
    Raises:
        Rejected: the size is not finite (MSH003).
    """
    vertices = draft.surface.vertices
    extents = np.ptp(vertices, axis=0)
    longest = float(extents.max())
    if not np.isfinite(longest) or longest <= 0 or longest > 1e30:
        raise Rejected("MSH003", f"the longest side is {longest:g} file units; no unit makes a thing of that")
    if size_m > 0:
        found = ScaleDecision(size_m / longest, "decided", 1.0, f"a person decided that it is {size_m:g} m long")
    else:
        belief = _belief(vertices, extents, category, parse_size_phrases(texts))
        found = _decide(extents, draft.metres_per_unit, category, slack, belief, generated)
    factor = significant(found.factor, 9)
    notes: tuple[Issue, ...] = ()
    if found.value not in ("as_stated", "metre", "decided"):
        notes = (warning("MSH014", "scale", f"rescaled by {found.factor:.6g}: {found.reason}"),)
    parts = tuple(p.replace(mesh=p.mesh.with_vertices(p.mesh.vertices * factor, p.mesh.normals)) for p in draft.parts)
    return draft.replace(
        parts=parts,
        metres_per_unit=1.0,
        guesses=draft.guessed("scale", f"{factor:.6g} m per unit ({found.value})", found.confidence, found.reason),
        notes=draft.noted(*notes),
    )


def _belief(vertices: Floats, extents: Floats, category: Category, words: StatedSize) -> SizePrior:
    """Metres per unit by the category's size along every axis, and by what is said of it."""
    sides = category.extents
    plan = sorted(sides[:2], key=lambda s: s.typical)
    have = np.maximum(np.array([*sorted(extents[:2]), extents[2]]), 1e-3 * extents.max())
    spans = (*plan, sides[2])
    spread = np.array([max(log(s.high / s.low) / 4, 0.06) for s in spans])
    each = np.log(np.array([s.typical for s in spans]) / have)
    # What is short says less: a handle or a rim more or less doubles it.
    doubt = spread**2 + (0.45 * (1 - have / have.max())) ** 2
    weight = 1 / doubt
    middle = float((weight * each).sum() / weight.sum())
    wide = float(np.sqrt((weight * spread**2).sum() / weight.sum()))
    split = float(np.sqrt((weight * (each - middle) ** 2).sum() / weight.sum()))
    sigma = sqrt(wide**2 + split**2 / 2)
    low, high = (log(v / float(extents.max())) for v in (category.longest_m.low, category.longest_m.high))
    middle = float(np.clip(middle + words.shift * sigma, low, high))
    message = f"the usual size of a {category.id}, along all three axes"
    if words.shift:
        message += f", and the words {', '.join(words.words)}"
    hint = _stated_size(vertices, extents, category, words, SizePrior(middle, sigma, message))
    return hint if hint is not None else SizePrior(middle, sigma, message)


def _stated_size(
    vertices: Floats, extents: Floats, category: Category, words: StatedSize, usual: SizePrior
) -> SizePrior | None:
    """Prior from lengths and volumes in words; None where none of them makes a usual size."""
    options = [(log(length / float(side)), LENGTH_SPREAD) for length in words.lengths for side in extents if side > 0]
    if words.volumes:
        try:
            volume = signed_volume(*convex_hull(vertices)) * CAPACITY_SHARE[category.build]
            options += [(log(v / volume) / 3, VOLUME_SPREAD) for v in words.volumes]
        except DegenerateShape:
            pass
    near = [(abs(m - usual.middle), m, s) for m, s in options if abs(m - usual.middle) < 1.5 * usual.spread]
    if not near:
        return None
    _, middle, spread = min(near)
    return SizePrior(middle, spread, f"the words {', '.join(words.words)}")


def _decide(
    extents: Floats, stated: float | None, category: Category, slack: float, belief: SizePrior, generated: bool
) -> ScaleDecision:
    longest = float(extents.max())
    span = category.longest_m
    usual = f"a {category.id} is {span.low:g} to {span.high:g} m long"
    normal = _is_normalised(extents)
    low, high = span.low / slack, span.high * slack
    if stated is not None and low <= longest * stated <= high and not (normal and generated):
        confidence = 0.97 if span.low <= longest * stated <= span.high else 0.8
        if normal:
            confidence = min(confidence, 0.45)
        if category.id == "object":
            confidence = min(confidence, MAX_CONFIDENCE_UNKNOWN)
        return ScaleDecision(
            stated, "as_stated", confidence, f"the file's unit gives {longest * stated:.3g} m; {usual}"
        )
    table = UNIT_PRIOR_GENERATED if generated else UNIT_PRIOR_SILENT if stated is None else UNIT_PRIOR_WRONG
    # A model that is exactly one unit long was normalised: its size says nothing.
    weights = {name: share * (0.02 if normal else 1.0) for name, share in table.items()}
    free = (1 - sum(weights.values())) / PRIOR_NATS
    odds = {
        name: weights[name] * _density(log(unit), belief)
        for name, unit in UNITS.items()
        if low <= longest * unit <= high and unit != stated
    }
    total = free + sum(odds.values())
    name = max(odds, key=lambda n: odds[n]) if odds else ""
    if name and odds[name] > free:
        size = longest * UNITS[name]
        plural = "inches" if name == "inch" else f"{name}s"
        message = f"{longest:.4g} units read as {plural} are {size:.3g} m; {usual}"
        # Where it was no unit after all, the usual size is what would have been guessed: right as often as that is.
        most = MAX_CONFIDENCE_UNKNOWN if category.id == "object" else 0.97
        return ScaleDecision(UNITS[name], name, min(most, odds[name] / total), message)
    factor = float(np.clip(np.exp(belief.middle), span.low / longest, span.high / longest))
    confidence = erf(log(CORRECT_FACTOR) / (sqrt(2) * belief.spread)) * (free / total)
    why = "normalised to one unit" if normal else f"no unit fits {longest:.4g} units"
    message = f"{why}; set to {factor * longest:.3g} m by {belief.message}"
    return ScaleDecision(factor, "usual_size", min(confidence, MAX_CONFIDENCE), message)


def _density(value: float, belief: SizePrior) -> float:
    """Density of the log normal, per nat; units are never quite as sharp as a stated length."""
    spread = max(belief.spread, 0.12)
    return float(np.exp(-0.5 * ((value - belief.middle) / spread) ** 2)) / (spread * sqrt(2 * pi))


def _is_normalised(extents: Floats) -> bool:
    diagonal = float(np.linalg.norm(extents))
    sizes = (float(extents.max()), diagonal, diagonal / 2)
    return any(abs(size / one - 1) < 1e-3 for size in sizes[:1] for one in NORMALISED_LENGTHS) or any(
        abs(size - 1.0) < 1e-4 for size in sizes[1:]
    )
