"""Choose metres per unit: by the file, by sizes in titles and prompts, else by the usual size of the category."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import erf, log, pi, sqrt

import numpy as np

from casa_assets.core.numeric import Floats, significant
from casa_assets.errors import DegenerateShape, Rejected
from casa_assets.ingest.draft import Draft, warning
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import signed_volume
from casa_assets.model.issue import ASKED_CODE, Issue
from casa_assets.model.registry.category import FALLBACK, Category, MatterFill

_NUMBER = r"(?<![\w.])(\d{1,4}(?:[.,]\d{1,3})?)"
# Ref: exact definitions of the inch (25.4 mm), the US fluid ounce, quart and gallon.
_LENGTHS = {
    "mm": (0.001, r"mm|millimet(?:er|re)s?"),
    "cm": (0.01, r"cm|centimet(?:er|re)s?"),
    "inch": (0.0254, r"\"|''|”|″|in|inch(?:es)?"),
    "foot": (0.3048, r"ft|foot|feet"),
}
_VOLUMES = {
    "millilitre": (1e-6, r"ml|millilit(?:er|re)s?"),
    "centilitre": (1e-5, r"cl"),
    "litre": (1e-3, r"l|lit(?:er|re)s?"),
    "ounce": (2.957353e-5, r"(?:fl\.?\s*)?oz|(?:fluid )?ounces?"),
    "quart": (9.463529e-4, r"qt|quarts?"),
    "gallon": (3.785412e-3, r"gal|gallons?"),
}
# Standard deviations by which a word shifts the usual size; choices.
_SHIFTS = {
    word: shift
    for shift, words in (
        (-1.5, "tiny"),
        (-1.3, "mini miniature"),
        (-1.2, "espresso demitasse"),
        (-0.8, "small little travel"),
        (-0.6, "kids"),
        (0.8, "large big family"),
        (1.0, "xl"),
        (1.3, "jumbo huge"),
        (1.5, "giant"),
    )
    for word in words.split()
}
# Units that meshes are drawn in, metres.
UNITS: dict[str, float] = {"metre": 1.0, "centimetre": 0.01, "millimetre": 0.001, "inch": 0.0254}
# Prior of each unit if the format states none, if the stated one is implausible, and for generated meshes; estimates.
# The rest is no unit at all: sculpted by eye, or normalised.
UNIT_PRIOR_SILENT = {"metre": 0.40, "centimetre": 0.17, "millimetre": 0.20, "inch": 0.08}
UNIT_PRIOR_WRONG = {"metre": 0.02, "centimetre": 0.25, "millimetre": 0.25, "inch": 0.12}
UNIT_PRIOR_GENERATED = {"metre": 0.20, "centimetre": 0.02, "millimetre": 0.02, "inch": 0.01}
# Scales without a unit are spread evenly over this range of logarithms: five decades.
PRIOR_NATS = 11.5
# A mesh whose longest side or diagonal is one of these, to a thousandth, was normalised.
NORMALISED_LENGTHS = (0.5, 1.0, 2.0, 10.0, 100.0)
# Share of the stated units that are right where they make a size that a thing of a house can have; an estimate.
STATED_UNIT_RIGHT = 0.5
# Sizes of things of a house, metres.
HOUSEHOLD_M = (0.005, 3.0)
# Spread (log) of how far odd things of a kind leave its range, and the share of things that are odd; choices.
ODD_SPREAD, ODD_SHARE = 0.35, 0.5
# How many times likelier a size in metres is usual for a category if the thing is of it than if it is not; an estimate.
SIZE_FITS_ODDS = 2.5
# A usual size counts as right within this factor of the truth, as far as most kinds differ; choices, as below.
CORRECT_FACTOR = 1.7
# Largest confidence of a size that comes from the category alone, since there are odd sizes in each.
MAX_CONFIDENCE = 0.85
# Largest confidence if the category is unknown.
MAX_CONFIDENCE_UNKNOWN = 0.6
# Spread (log) of the side that a stated length names, and of the size that a stated volume makes.
LENGTH_SPREAD, VOLUME_SPREAD = 0.06, 0.12
# Capacity over the volume of the hull.
CAPACITY_SHARE = {MatterFill.VESSEL: 0.7, MatterFill.HOLLOW: 0.6, MatterFill.FILLED: 0.85, MatterFill.SOLID: 1.0}


@dataclass(frozen=True)
class StatedSize:
    """Sizes in titles and prompts: lengths, m, capacities, m^3, `shift` in standard deviations, and the phrases."""

    lengths: tuple[float, ...] = ()
    volumes: tuple[float, ...] = ()
    shift: float = 0.0
    words: tuple[str, ...] = ()


def parse_size_phrases(texts: Sequence[str]) -> StatedSize:
    """Parse titles and prompts, such as `Frypan 8"` or `a large 1.5 l pitcher`."""
    lengths: list[float] = []
    volumes: list[float] = []
    words: list[str] = []
    shift = 0.0
    for text in texts:
        lowered = text.lower()
        for values, table in ((lengths, _LENGTHS), (volumes, _VOLUMES)):
            for unit_size, pattern in table.values():
                for match in re.finditer(rf"{_NUMBER}[\s-]?(?:{pattern})(?!\w)", lowered):
                    values.append(float(match[1].replace(",", ".")) * unit_size)
                    words.append(match[0].strip())
        for word in re.findall(r"[a-z]+", lowered):
            if word in _SHIFTS and abs(_SHIFTS[word]) > abs(shift):
                shift = _SHIFTS[word]
                words.append(word)
    return StatedSize(
        tuple(v for v in dict.fromkeys(lengths) if v > 0),
        tuple(v for v in dict.fromkeys(volumes) if v > 0),
        shift,
        tuple(dict.fromkeys(words)),
    )


@dataclass(frozen=True)
class SizePrior:
    """Log-normal prior of metres per unit: mean and standard deviation of the logarithm, and its source in words."""

    center: float
    spread: float
    message: str


@dataclass(frozen=True)
class ScaleDecision:
    """Metres per unit, the name of the unit or method, confidence 0..1, and the reason.

    `category_confidence`: in the category, once the size is weighed too; None if the size says nothing about it.
    `is_overruled`: the file states another unit.
    """

    factor: float
    value: str
    confidence: float
    reason: str
    category_confidence: float | None = None
    is_overruled: bool = False


def scale(
    draft: Draft,
    category: Category,
    size_slack: float,
    texts: Sequence[str] = (),
    generated: bool = False,
    override_size_m: float = 0,
) -> Draft:
    """Bring the parts to metres.

    `draft`: z up, file units. `category`: its extents are the prior, per axis. `size_slack`: ratio > 1 by which a
    stated size may lie outside the usual range. `texts`: titles and prompts, which may name a size. `generated`: from a
    text-to-3D generator. `override_size_m`: longest side as a person decided it, metres; 0 where nobody did. Raises
    Rejected: the size is not finite (MSH003).
    """
    vertices = draft.surface.vertices
    extents = np.ptp(vertices, axis=0)
    longest = float(extents.max())
    if not np.isfinite(longest) or longest <= 0 or longest > 1e30:
        raise Rejected("MSH003", f"the longest side is {longest:g} file units; no unit makes a thing of that")
    if override_size_m > 0:
        reason = f"a person decided that it is {override_size_m:g} m long"
        decision = ScaleDecision(override_size_m / longest, "decided", 1.0, reason)
    else:
        belief = _belief(vertices, extents, category, parse_size_phrases(texts))
        decision = _decide(extents, draft.metres_per_unit, category, size_slack, belief, generated)
        decision = _weighed_with_category(decision, longest, draft, category, _is_normalised(extents) or generated)
    factor = significant(decision.factor, 9)
    notes: list[Issue] = []
    if decision.value not in ("as_stated", "metre", "decided"):
        notes.append(warning("MSH014", "scale", f"rescaled by {decision.factor:.6g}: {decision.reason}"))
    if decision.is_overruled:
        message = f"the file states {draft.metres_per_unit:g} m per unit, taken are {decision.factor:.6g}"
        notes.append(warning(ASKED_CODE, "scale", f"{message}: {decision.reason}"))
    if decision.category_confidence is not None:
        draft = draft.with_confidence("category", decision.category_confidence)
    parts = tuple(p.replace(mesh=p.mesh.with_vertices(p.mesh.vertices * factor, p.mesh.normals)) for p in draft.parts)
    value = f"{factor:.6g} m per unit ({decision.value})"
    guesses = draft.guessed("scale", value, decision.confidence, decision.reason)
    return draft.replace(parts=parts, metres_per_unit=1.0, guesses=guesses, notes=draft.noted(*notes))


def _weighed_with_category(
    decision: ScaleDecision, longest: float, draft: Draft, category: Category, says_nothing: bool
) -> ScaleDecision:
    """The decision after a size that the file states and the category forbids was weighed against the category.

    Either the unit is wrong, or the thing is an odd one of its kind, or it is of another kind. The more the name alone
    says what it is, the sooner the stated size is kept and the kind doubted. A normalised mesh `says_nothing`.
    """
    unit_m = draft.metres_per_unit
    sure = draft.confidence_in("category")
    if decision.value in ("as_stated", "metre"):
        if says_nothing or category.id == FALLBACK:
            return decision
        # Nobody had to change the size: that it is usual for its kind speaks for the name.
        odds = SIZE_FITS_ODDS * sure
        return replace(decision, category_confidence=odds / (odds + 1 - sure))
    if unit_m is None or decision.factor == unit_m:
        return decision
    size_m = longest * unit_m
    if says_nothing or category.id == FALLBACK or not HOUSEHOLD_M[0] <= size_m <= HOUSEHOLD_M[1]:
        return replace(decision, is_overruled=True)
    beyond = max(log(size_m / category.longest_m.high), log(category.longest_m.low / size_m), 0.0)
    odd = STATED_UNIT_RIGHT * sure * ODD_SHARE * float(np.exp(-0.5 * (beyond / ODD_SPREAD) ** 2))
    other_kind = STATED_UNIT_RIGHT * (1 - sure)
    wrong_unit = (1 - STATED_UNIT_RIGHT) * sure
    total = odd + other_kind + wrong_unit
    category_confidence = (odd + wrong_unit) / total
    if odd + other_kind > wrong_unit:
        reason = f"the file's unit gives {size_m:.3g} m, which is odd for a {category.id}"
        reason += "; kept, for it may be no such thing"
        return ScaleDecision(unit_m, "as_stated", (odd + other_kind) / total, reason, category_confidence)
    confidence = decision.confidence * wrong_unit / total
    return replace(decision, confidence=confidence, category_confidence=category_confidence, is_overruled=True)


def _belief(vertices: Floats, extents: Floats, category: Category, stated: StatedSize) -> SizePrior:
    """Prior of metres per unit: by the usual size along each axis, and by sizes in titles and prompts."""
    sides = category.extents
    sides_in_plan = sorted(sides[:2], key=lambda s: s.typical)
    mesh_sides = np.maximum(np.array([*sorted(extents[:2]), extents[2]]), 1e-3 * extents.max())
    spans = (*sides_in_plan, sides[2])
    spread = np.array([max(log(s.high / s.low) / 4, 0.06) for s in spans])
    log_scale_per_axis = np.log(np.array([s.typical for s in spans]) / mesh_sides)
    # Short sides say less, since a handle or a rim can double them.
    doubt = spread**2 + (0.45 * (1 - mesh_sides / mesh_sides.max())) ** 2
    weight = 1 / doubt
    center = float((weight * log_scale_per_axis).sum() / weight.sum())
    category_spread = float(np.sqrt((weight * spread**2).sum() / weight.sum()))
    disagreement = float(np.sqrt((weight * (log_scale_per_axis - center) ** 2).sum() / weight.sum()))
    spread_of_mean = sqrt(category_spread**2 + disagreement**2 / 2)
    lowest, highest = (log(v / float(extents.max())) for v in (category.longest_m.low, category.longest_m.high))
    center += stated.shift * spread_of_mean
    if not lowest <= center <= highest:  # odd proportions: the longest side is taken to be the usual one
        center = log(category.longest_m.typical / float(extents.max()))
        spread_of_mean = max(spread_of_mean, (highest - lowest) / 4)
    message = f"the usual size of a {category.id}, along all three axes"
    if stated.shift:
        message += f", and the words {', '.join(stated.words)}"
    usual = SizePrior(center, spread_of_mean, message)
    return _stated_size(vertices, extents, category, stated, usual) or usual


def _stated_size(
    vertices: Floats, extents: Floats, category: Category, stated: StatedSize, category_prior: SizePrior
) -> SizePrior | None:
    """Prior from lengths and volumes in words; None if none of them makes a usual size."""
    options = [(log(length / float(side)), LENGTH_SPREAD) for length in stated.lengths for side in extents if side > 0]
    if stated.volumes:
        try:
            volume = signed_volume(*convex_hull(vertices)) * CAPACITY_SHARE[category.build]
            options += [(log(v / volume) / 3, VOLUME_SPREAD) for v in stated.volumes]
        except DegenerateShape:
            pass
    distances = [(abs(m - category_prior.center), m, s) for m, s in options]
    plausible = [one for one in distances if one[0] < 1.5 * category_prior.spread]
    if not plausible:
        return None
    _, center, spread = min(plausible)
    return SizePrior(center, spread, f"the words {', '.join(stated.words)}")


def _decide(
    extents: Floats,
    file_unit_m: float | None,
    category: Category,
    size_slack: float,
    prior: SizePrior,
    is_generated: bool,
) -> ScaleDecision:
    longest = float(extents.max())
    longest_range = category.longest_m
    usual = f"a {category.id} is {longest_range.low:g} to {longest_range.high:g} m long"
    is_normalised = _is_normalised(extents)
    min_size_m, max_size_m = longest_range.low / size_slack, longest_range.high * size_slack
    size = longest * (file_unit_m or 0.0)
    if file_unit_m is not None and min_size_m <= size <= max_size_m and not (is_normalised and is_generated):
        confidence = 0.97 if longest_range.low <= size <= longest_range.high else 0.8
        if is_normalised:
            confidence = min(confidence, 0.45)
        if category.id == FALLBACK:
            confidence = min(confidence, MAX_CONFIDENCE_UNKNOWN)
        return ScaleDecision(file_unit_m, "as_stated", confidence, f"the file's unit gives {size:.3g} m; {usual}")
    unit_prior = UNIT_PRIOR_SILENT if file_unit_m is None else UNIT_PRIOR_WRONG
    if is_generated:
        unit_prior = UNIT_PRIOR_GENERATED
    # The size of a normalised mesh says nothing about its unit.
    weights = {name: share * (0.02 if is_normalised else 1.0) for name, share in unit_prior.items()}
    no_unit_odds = (1 - sum(weights.values())) / PRIOR_NATS
    odds = {
        name: weights[name] * _density(log(unit), prior)
        for name, unit in UNITS.items()
        if min_size_m <= longest * unit <= max_size_m and unit != file_unit_m
    }
    total = no_unit_odds + sum(odds.values())
    name = max(odds, key=lambda n: odds[n]) if odds else ""
    if name and odds[name] > no_unit_odds:
        size = longest * UNITS[name]
        plural = "inches" if name == "inch" else f"{name}s"
        message = f"{longest:.4g} units read as {plural} are {size:.3g} m; {usual}"
        max_confidence = MAX_CONFIDENCE_UNKNOWN if category.id == FALLBACK else 0.97
        return ScaleDecision(UNITS[name], name, min(max_confidence, odds[name] / total), message)
    factor = float(np.exp(prior.center))
    confidence = erf(log(CORRECT_FACTOR) / (sqrt(2) * prior.spread)) * (no_unit_odds / total)
    cause = "normalised to one unit" if is_normalised else f"no unit fits {longest:.4g} units"
    message = f"{cause}; set to {factor * longest:.3g} m by {prior.message}"
    return ScaleDecision(factor, "usual_size", min(confidence, MAX_CONFIDENCE), message)


def _density(value: float, prior: SizePrior) -> float:
    """Density of the prior at a logarithm, per nat, with a spread of at least 0.12."""
    spread = max(prior.spread, 0.12)
    return float(np.exp(-0.5 * ((value - prior.center) / spread) ** 2)) / (spread * sqrt(2 * pi))


def _is_normalised(extents: Floats) -> bool:
    longest, diagonal = float(extents.max()), float(np.linalg.norm(extents))
    has_usual_length = any(abs(longest / length - 1) < 1e-3 for length in NORMALISED_LENGTHS)
    return has_usual_length or any(abs(size - 1.0) < 1e-4 for size in (diagonal, diagonal / 2))
