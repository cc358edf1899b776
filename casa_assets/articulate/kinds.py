"""Kinds of appliances: which one an object is, by its name, its proportions and the parts that move."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from casa_assets.articulate.plan import Articulation, HingeEdge, PartKind
from casa_assets.core.numeric import Floats
from casa_assets.model.asset.parts import JointKind
from casa_assets.model.registry.category import Vocabulary, VocabularyMatch

Extent = tuple[float, float, float]  # width, depth, height, any unit
# Deviation of log proportions; factors where controls are elsewhere, or missing; likelihood of a shape like no other.
PROPORTION_SIGMA, OTHER_PLACEMENT_FACTOR, NO_CONTROLS_FACTOR, UNKNOWN_SHAPE_FLOOR = 0.15, 0.25, 0.5, 3e-3
# Other names of kinds, by the id of their fixture.
KIND_NAMES: Mapping[str, tuple[str, ...]] = {
    "base_cabinet": ("cabinet", "kitchen cabinet", "cupboard", "sideboard", "credenza"),
    "wall_cabinet": ("upper cabinet", "hanging cabinet"),
    "tall_cabinet": ("pantry", "larder"),
    "wardrobe": ("closet", "armoire"),
    "drawer_stack": ("drawer", "chest of drawers", "drawer unit", "dresser", "drawer cabinet", "chest with drawers"),
    "nightstand": ("night stand", "bedside table", "bedside cabinet"),
    "safe": ("strongbox", "safe box"),
    "desk": ("writing desk", "office desk", "study table"),
    "table": ("coffee table", "side table", "console table", "dining table"),
    "sink_base": ("sink cabinet",),
    "island_base": ("island", "kitchen island"),
    "range": ("stove", "cooker", "kitchen stove", "oven range", "gas stove", "electric stove"),
    "hob": ("cooktop", "stovetop", "stove top", "cook top"),
    "wall_oven": ("oven", "built in oven"),
    "microwave": ("microwave oven",),
    "refrigerator": ("fridge", "freezer", "fridge freezer"),
    "dishwasher": ("dish washer",),
    "washing_machine": ("washer", "clothes washer", "laundry machine"),
    "dryer": ("tumble dryer", "clothes dryer"),
    "coffee_machine": ("coffee maker", "espresso machine", "espresso maker"),
    "toaster": (),
    "toaster_oven": ("mini oven",),
    "kettle": ("electric kettle", "water boiler"),
    "sink": ("faucet", "basin faucet", "tap", "kitchen sink"),
    "hood": ("range hood", "cooker hood", "extractor"),
    "blender": (),
    "stand_mixer": ("mixer", "food mixer"),
}
_VOCABULARY = Vocabulary.of(
    ((name, kind) for kind, others in KIND_NAMES.items() for name in (kind, *others)),
    ("range", "tap", "island", "table", "safe"),
    ("with", "without", "w", "for", "from", "in", "on", "by", "near", "under"),
)
# Probability of a trait that is not listed for a category.
RARE_TRAIT = 0.03
Shapes = tuple[Extent, ...]
# Usual proportions of each kind, and how often it has each trait (`FORM_TRAITS`, `_traits`). Set from what makers list.
_KINDS = """
microwave: 1 x 0.75 x 0.58, 1 x 0.85 x 0.52; fronts 0.03, door 0.95, buttons 0.6, knobs 0.3, keys 0.5, turntable 0.5,
  beside 0.7, folds 0.15, wide 0.7, covers 0.85
toaster_oven: 1 x 0.8 x 0.6; fronts 0.05, door 0.95, knobs 0.8, row 0.5, rack 0.5, beside 0.6, folds 0.97, wide 0.9,
  legs 0.1, covers 0.8
wall_oven: 1 x 0.95 x 1, 0.6 x 0.55 x 1; fronts 0.2, door 0.95, knobs 0.6, buttons 0.4, row 0.4, keys 0.15, rack 0.5,
  racks 0.25, folds 0.95, doors 0.15, wide 0.7, covers 0.85
range: 0.8 x 0.7 x 1, 0.65 x 0.65 x 1; fronts 0.55, door 0.95, knobs 0.9, buttons 0.2, row 0.75, keys 0.1, rack 0.5,
  racks 0.2, folds 0.9, drawer 0.5, above 0.2, doors 0.15, wide 0.7, covers 0.6
dishwasher: 0.7 x 0.7 x 1, 0.53 x 0.7 x 1; fronts 0.04, door 0.98, buttons 0.5, knobs 0.1, row 0.3, keys 0.3, rack
  0.6, racks 0.5, folds 0.97, tall 0.6, covers 0.97
refrigerator: 0.42 x 0.4 x 1, 0.5 x 0.42 x 1, 0.36 x 0.36 x 1; fronts 0.85, door 0.98, doors 0.75, drawer 0.3, drawers
  0.1, pair 0.3, tall 0.85, covers 0.6, buttons 0.1, keys 0.05
base_cabinet: 0.7 x 0.7 x 1, 1.05 x 0.7 x 1, 0.4 x 0.7 x 1, 1 x 0.5 x 0.7, 1 x 0.3 x 0.55; fronts 0.85, door 0.85,
  doors 0.6, drawer 0.5, drawers 0.35, pair 0.6, tall 0.6, legs 0.15, covers 0.35, wide 0.15
wall_cabinet: 0.85 x 0.4 x 1, 0.45 x 0.4 x 1, 1 x 0.35 x 0.45, 1 x 0.4 x 1; fronts 0.65, door 0.97, doors 0.65, pair
  0.55, tall 0.6, wide 0.2, covers 0.4
tall_cabinet: 0.3 x 0.28 x 1, 0.5 x 0.28 x 1; fronts 0.8, door 0.97, doors 0.8, drawer 0.25, drawers 0.2, pair 0.5,
  tall 0.85, covers 0.3
drawer_stack: 0.7 x 0.7 x 1, 1 x 0.5 x 0.7, 0.45 x 0.7 x 1, 0.8 x 0.5 x 1; fronts 0.95, drawer 0.98, drawers 0.95,
  door 0.08, doors 0.04, pair 0.35, wide 0.9, legs 0.15
washing_machine: 0.7 x 0.68 x 1, 0.7 x 0.55 x 1; fronts 0.55, door 0.97, round 0.9, drawer 0.6, knobs 0.75, buttons
  0.5, keys 0.3, covers 0.15
dryer: 0.7 x 0.68 x 1; fronts 0.1, door 0.97, round 0.4, knobs 0.7, buttons 0.5, keys 0.3, drawer 0.1, covers 0.2
desk: 1 x 0.5 x 0.55, 1 x 0.45 x 0.5; fronts 0.85, drawer 0.95, drawers 0.85, door 0.2, doors 0.04, legs 0.9, wide
  0.9, pair 0.3
table: 1 x 0.65 x 0.62, 1 x 0.5 x 0.4, 0.7 x 0.7 x 1, 1 x 0.35 x 0.8; fronts 0.6, drawer 0.95, drawers 0.6, door 0.08,
  legs 0.95, wide 0.95, pair 0.5
nightstand: 0.85 x 0.7 x 1, 1 x 0.8 x 1; fronts 0.7, drawer 0.9, drawers 0.5, door 0.3, doors 0.05, legs 0.85, wide
  0.85, covers 0.1
wardrobe: 0.55 x 0.28 x 1, 0.7 x 0.28 x 1, 0.9 x 0.3 x 1; fronts 0.95, door 0.98, doors 0.93, drawer 0.35, drawers
  0.25, pair 0.9, tall 0.95
safe: 1 x 0.95 x 1, 1 x 0.9 x 1.3, 1 x 0.9 x 0.75; fronts 0.04, door 0.97, knobs 0.7, buttons 0.5, keys 0.5, covers
  0.95
hob: 1 x 0.7 x 0.13; knobs 0.8, row 0.7, above 0.8
toaster: 1 x 0.6 x 0.65, 0.62 x 1 x 0.68; lever 0.9, knobs 0.5, buttons 0.4
coffee_machine: 0.7 x 0.9 x 1; buttons 0.7, knobs 0.3, lever 0.2
kettle: 0.8 x 0.65 x 1; lid 0.7, buttons 0.3, lever 0.3
sink: 0.3 x 0.6 x 1, 1 x 0.7 x 0.75; lever 0.8, spout 0.4
"""
# Traits that the form shows before any joint is decided; `Articulation.traits` lists those that are there.
FORM_TRAITS = ("fronts", "row", "keys", "pair", "wide", "tall", "covers", "legs", "round")
# Standard deviation of log proportions within a category, and the highest confidence of this guess.
KIND_PROPORTION_SIGMA, MAX_CONFIDENCE = 0.28, 0.6
# Probability of a kind that the user or a name states. Ref: `IS_A_NAME` in model/registry/category.py.
STATED_SHARE = 0.93


class ControlPlacement(StrEnum):
    """Position of the knobs and buttons of a front."""

    NONE = "none"
    ASIDE = "aside"
    ABOVE = "above"


# Width, depth and height of usual things, how usual they are, and where their controls are. Ref: `shape` in
# registry/fixtures.yaml, with the variants that trade catalogues list.
USUAL_PROPORTIONS: tuple[tuple[Extent, float, ControlPlacement], ...] = (
    ((0.7, 0.7, 1.0), 1.5, ControlPlacement.NONE),  # base cabinets, then wide and narrow ones
    ((1.05, 0.7, 1.0), 1.0, ControlPlacement.NONE),
    ((0.4, 0.7, 1.0), 1.0, ControlPlacement.NONE),
    ((0.85, 0.4, 1.0), 1.0, ControlPlacement.NONE),  # wall cabinets
    ((0.45, 0.4, 1.0), 0.7, ControlPlacement.NONE),
    ((1.0, 0.35, 0.45), 0.5, ControlPlacement.NONE),
    ((0.3, 0.28, 1.0), 0.6, ControlPlacement.NONE),  # tall cabinets
    ((0.5, 0.28, 1.0), 0.6, ControlPlacement.NONE),
    ((1.0, 0.5, 0.7), 1.0, ControlPlacement.NONE),  # islands, chests and tables
    ((1.0, 0.6, 0.6), 0.7, ControlPlacement.NONE),
    ((0.42, 0.4, 1.0), 1.5, ControlPlacement.NONE),  # fridges
    ((0.5, 0.42, 1.0), 0.7, ControlPlacement.NONE),
    ((0.8, 0.7, 1.0), 1.0, ControlPlacement.ABOVE),  # ranges, dishwashers, ovens
    ((0.7, 0.7, 1.0), 1.3, ControlPlacement.ABOVE),
    ((1.0, 0.95, 1.0), 1.0, ControlPlacement.ABOVE),
    ((1.0, 0.7, 0.12), 0.7, ControlPlacement.NONE),  # hobs
    ((1.0, 0.75, 0.58), 2.0, ControlPlacement.ASIDE),  # microwaves
    ((1.0, 0.85, 0.52), 1.0, ControlPlacement.ASIDE),
    ((1.0, 0.75, 0.58), 1.0, ControlPlacement.NONE),
    ((1.0, 0.8, 0.6), 1.0, ControlPlacement.ASIDE),  # toaster ovens
    ((1.0, 0.6, 0.65), 0.7, ControlPlacement.NONE),  # toasters, long side or end to the front
    ((0.62, 1.0, 0.68), 0.7, ControlPlacement.NONE),
    ((0.7, 0.9, 1.0), 0.7, ControlPlacement.NONE),  # coffee machines
    ((0.8, 0.65, 1.0), 0.3, ControlPlacement.NONE),  # kettles
)


def _kind(shapes: str, often: str) -> tuple[Shapes, Mapping[str, float]]:
    extents = [tuple(float(side) for side in shape.split(" x ")) for shape in shapes.split(", ")]
    chances = {trait: float(chance) for trait, chance in (word.split() for word in often.split(", "))}
    return tuple((wide, deep, high) for wide, deep, high in extents), chances


KIND_TRAITS: Mapping[str, tuple[Shapes, Mapping[str, float]]] = {
    kind: _kind(*row.split("; "))
    for kind, row in (line.split(": ") for line in _KINDS.replace("\n  ", " ").strip().splitlines())
}


def shape_likelihood(extent: Extent, controls: ControlPlacement) -> float:
    """Return the log likelihood of proportions for an object with controls in that place."""
    away = _away(extent, [e for e, _, _ in USUAL_PROPORTIONS])
    often = np.array([w for _, w, _ in USUAL_PROPORTIONS])
    fits = np.array(
        [
            1.0 if c is controls else NO_CONTROLS_FACTOR if c is ControlPlacement.NONE else OTHER_PLACEMENT_FACTOR
            for _, _, c in USUAL_PROPORTIONS
        ]
    )
    share = often * fits * np.exp(-away / PROPORTION_SIGMA**2 / 2)
    return float(np.log(share.sum() / often.sum() + UNKNOWN_SHAPE_FLOOR))


def _away(extent: Extent, shapes: Sequence[Extent]) -> Floats:
    """Return the (N,) squared distances of proportions from usual ones, in logarithms."""
    log = np.log(np.maximum(np.array(extent, dtype=np.float64), 1e-3))
    usual = np.log(np.array(shapes))
    away = (log - log.mean()) - (usual - usual.mean(axis=1, keepdims=True))
    return np.asarray((away**2).sum(axis=1))


def kind_named(hints: Sequence[str]) -> VocabularyMatch | None:
    """Return the category (id of its fixture) named in file names or titles, by whole words; best hint first."""
    return _VOCABULARY.find(hints)


def kind_by_parts(extent: Extent, articulation: Articulation) -> tuple[str, float]:
    """Return the likeliest category by proportions and moving parts, and a confidence that is never high."""
    if not articulation.parts:
        return "", 0.0
    shares = kind_shares(extent, traits_of_parts(articulation))
    best = max(shares, key=lambda kind: round(shares[kind], 9))
    return best, round(MAX_CONFIDENCE * shares[best], 3)


def kind_shares(
    extent: Extent, has: Mapping[str, bool], fronts: Mapping[str, float] = MappingProxyType({})
) -> dict[str, float]:
    """Return the probability of each kind by proportions and traits; they sum to 1.

    Args:
        has: traits that were looked for, and whether each is there.
        fronts: log likelihood of the form of its fronts for each kind; that of "" is for all others.
    """
    scores = []
    for kind, (shapes, often) in KIND_TRAITS.items():
        fit = float(np.exp(-_away(extent, shapes) / KIND_PROPORTION_SIGMA**2 / 2).mean())
        score = math.log(fit + UNKNOWN_SHAPE_FLOOR)
        for trait, there in has.items():
            chance = often.get(trait, RARE_TRAIT)
            score += math.log(chance if there else 1.0 - chance)
        scores.append(score + fronts.get(kind, fronts.get("", 0.0)))
    odds = np.exp(np.array(scores) - max(scores))
    return dict(zip(KIND_TRAITS, (odds / odds.sum()).tolist(), strict=True))


def kinds_known(extent: Extent, has: Mapping[str, bool], fronts: Mapping[str, float], stated: str) -> dict[str, float]:
    """Return the probability of each kind where a name may state one: that one `STATED_SHARE`, the others the rest."""
    by_form = kind_shares(extent, has, fronts)
    if not stated:
        return by_form
    shares = {kind: (1.0 - STATED_SHARE) * share for kind, share in by_form.items()}
    shares[stated] = shares.get(stated, 0.0) + STATED_SHARE
    return shares


def traits_of_parts(articulation: Articulation) -> dict[str, bool]:
    """Return which traits of KIND_TRAITS an object has."""
    parts = articulation.parts
    doors = [p for p in parts if p.kind is PartKind.DOOR]
    drawers = [p for p in parts if p.kind is PartKind.DRAWER]
    knobs = [p for p in parts if p.kind is PartKind.KNOB]
    small = [p for p in parts if p.kind in (PartKind.KNOB, PartKind.BUTTON)]
    trays = [p for p in parts if p.kind is PartKind.TRAY]
    across = [p.joint.anchor[0] for p in small]
    return {
        "door": bool(doors),
        "doors": len(doors) > 1,
        "folds": any(p.joint.edge is HingeEdge.BOTTOM for p in doors),
        "drawer": bool(drawers),
        "drawers": len(drawers) > 1,
        "knobs": bool(knobs),
        "above": any(abs(p.joint.axis[2]) > 0.7 for p in knobs),
        "buttons": any(p.kind is PartKind.BUTTON for p in parts),
        "beside": bool(across) and abs(sum(across) / len(across)) > 0.2,
        "turntable": any(p.joint.kind is JointKind.HINGE for p in trays),
        "rack": any(p.joint.kind is JointKind.SLIDE for p in trays),
        "racks": sum(p.joint.kind is JointKind.SLIDE for p in trays) > 1,
        "lever": any(p.kind is PartKind.LEVER for p in parts),
        "spout": any(p.kind is PartKind.SPOUT for p in parts),
        "lid": any(p.kind is PartKind.LID for p in parts),
    } | {trait: trait in articulation.traits for trait in FORM_TRAITS}
