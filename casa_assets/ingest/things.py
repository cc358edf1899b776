"""Distinguish one object from several things, a scene, a figure or a part; take a file apart into its things."""

from __future__ import annotations

import math
import posixpath
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.errors import Rejected
from casa_assets.formats.read import formats
from casa_assets.formats.read.text import UniqueNames, printable
from casa_assets.ingest.components import Components, box_gaps, split_components
from casa_assets.ingest.draft import keep_faces, merge_parts, warning
from casa_assets.mesh.solid.deviation import samples_with_faces
from casa_assets.mesh.surface import connected_groups, face_normals
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.asset import Guess
from casa_assets.model.registry.category import Category, Vocabulary, VocabularyMatch, singulars, split_words
from casa_assets.model.registry.rows import OtherThingsWords
from casa_assets.model.source import Bundle, RawModel, RawPart, Source, Up

# Surfaces nearer than this share of the longest side touch; a choice, above the distance of the samples.
TOUCH_SHARE = 0.012
# Samples on all components; of one that has fewer than these, corners of its faces count too.
SAMPLES, FEW_SAMPLES = 40_000, 300
# All numbers are choices, fitted on sound meshes and on half of others; sizes are shares of the longest side.
MAX_COMPONENTS = 4000
# A group of pieces is a separate thing where it is so large and touches no other one.
LARGE_GROUP = 0.3
# So are this many smaller ones whose middle lies beside the largest.
SMALL_GROUP, MIN_SMALL = 0.05, 3
# Sides of alike pieces differ by no more than this share; they are so large, and no side of compact ones is shorter.
ALIKE, ALIKE_SIZE, COMPACT = 0.06, 0.2, 0.65
# Between the tops of legs and what rests on them is no more than this.
LEG_SLACK = 0.03
# Pieces that are all alike make up so much of the area.
ALL_ALIKE = 0.85
# A ground is so thin and covers so much of the floor plan; a thing on it is so large, and so high for its width.
GROUND_THICKNESS, GROUND_COVER, ON_GROUND_SIZE, ON_GROUND_HEIGHT = 0.15, 0.6, 0.06, 0.6
MIN_ON_GROUND = 5
# Walls: this share of a component lies along three perpendicular planes, at the side of the box; it reaches
# over so much of it. What spans so much of the room is a shelf of it and no thing in it.
PLANAR, SIDE_DEPTH, SIDE_COVER, SPANNING, IN_ROOM_SIZE = 0.8, 0.03, 0.5, 0.8, 0.08
MIN_IN_CORNER, MIN_IN_ROOM = 3, 12
# Probabilities are choices, fitted like those above. A category that is less sure than this has a weak word.
ALWAYS, OTHER, PART, PLURAL, MANY_KINDS, OWN_KINDS = 0.65, 0.6, 0.65, 0.4, 0.7, 0.2
WEAKLY_TOLD = 0.62
# Nodes named after this many categories are several things.
MIN_KINDS = 3
_WHAT = {
    "figures": "a person or an animal",
    "places": "a place",
    "shapes": "a shape to test with",
    "outdoors": "something from outdoors",
    "arms": "a weapon",
}
# What exporters and authors put behind a name, besides single letters.
_ENDINGS = frozenset({"low", "high", "lod", "visual", "mesh", "model", "obj", "textured", "simple", "left", "right"})
SUBJECT = "things"
ONE = "one object"
# Below this probability nothing is said.
MIN_PROBABILITY = 0.25
# Bones from which on a rig is that of a figure, and how probable that is; a choice.
MIN_JOINTS, FIGURE = 5, 0.8
MANY_COPIES = 0.95
# A category whose name has one of these words is several things, and rightly so.
COLLECTIVE = frozenset({"stack", "set", "bunch", "pack", "pile", "pair"})
# Things that are taken out of one file, the largest first; a choice.
MAX_THINGS = 256
# A group of pieces smaller than this share of the largest thing belongs to the thing that is nearest; a choice.
CRUMB = 0.06
# Equal things differ by no more than this share of their size once one lies on the other.
EQUAL = 1e-3


class Contacts:
    """Contacts between the components of a surface: (K, 2) that touch, each pair once."""

    def __init__(self, components: Components) -> None:
        self.components = components
        reach = TOUCH_SHARE * float(np.ptp(components.points, axis=0).max())
        samples, face = samples_with_faces(components.points, components.faces, SAMPLES)
        # A small component may have got few samples or none: corners of this many of its faces join them.
        few = np.bincount(components.label[face], minlength=components.count) < FEW_SAMPLES
        faces = np.bincount(components.label, minlength=components.count)
        by_label = np.argsort(components.label, kind="stable")
        rank = np.empty_like(by_label)
        rank[by_label] = np.arange(len(by_label)) - np.repeat(np.cumsum(faces) - faces, faces)
        step = np.maximum(1, faces // FEW_SAMPLES)[components.label]
        corners = few[components.label] & (rank % step == 0)
        places = np.concatenate((samples, components.points[components.faces[corners]].reshape(-1, 3)))
        label = np.concatenate((components.label[face], np.repeat(components.label[corners], 3)))
        cells = np.column_stack((np.round(places / max(reach / 2, 1e-30)).astype(np.int64), label))
        first = np.unique(cells, axis=0, return_index=True)[1]
        places, label = places[first], label[first]
        near = cKDTree(places).query_pairs(reach, output_type="ndarray")
        touching = np.sort(label[near], axis=1)
        self.pairs: Ints = np.unique(touching[touching[:, 0] != touching[:, 1]], axis=0)

    def groups(self, among: Mask) -> list[Ints]:
        """Components that hang together by contact, without those that are not `among` (N,); largest group first."""
        kept = self.pairs[among[self.pairs].all(axis=1)]
        label = connected_groups(self.components.count, kept[:, 0], kept[:, 1])
        found = [np.flatnonzero(among & (label == k)) for k in np.unique(label[among])]
        return sorted(found, key=lambda rows: (-float(self.components.extents_of(rows).max()), int(rows[0])))


class Sign(NamedTuple):
    """Evidence against a single object: the probability, 0..1, that it is not one in this case, and the reason."""

    probability: float
    reason: str


def signs_of_form(model: RawModel) -> list[Sign]:
    """Signs in the surfaces of a model: none of one piece; of too many pieces to compare, their number alone."""
    if not any(len(part.mesh.faces) for part in model.parts):
        return []
    components, _ = components_of(model)
    if components.count == 1 or float(np.ptp(components.points, axis=0).max()) <= 0:
        return []
    if components.count > MAX_COMPONENTS:
        return [Sign(0.6, f"it is made of {components.count} separate pieces")]
    contacts = Contacts(components)
    ups, groups = up_axes(model), contacts.groups(np.ones(components.count, dtype=bool))
    found = [
        _apart(contacts, groups, ups),
        _beside(contacts, groups, ups),
        _alike(components, ups),
        *(_on_ground(contacts, up) for up in ups),
        _room(contacts),
    ]
    return [sign for sign in found if sign is not None]


def up_axes(model: RawModel) -> tuple[int, ...]:
    """Axes that may point up: the one that the file states, else y or z."""
    return {Up.X: (0,), Up.Y: (1,), Up.Z: (2,)}[model.up] if model.up else (1, 2)


def _apart(contacts: Contacts, groups: Sequence[Ints], ups: Sequence[int]) -> Sign | None:
    """Large groups of pieces that touch nothing of each other and lie side by side."""
    sizes = [float(contacts.components.extents_of(rows).max()) for rows in groups]
    large = [rows for rows, size in zip(groups, sizes, strict=True) if size >= LARGE_GROUP * sizes[0]]
    if len(large) < 2:
        return None
    # What lies above each other, or in each other, is one thing modelled with gaps more often than several.
    lower = np.array([contacts.components.lower[rows].min(axis=0) for rows in large])
    upper = np.array([contacts.components.upper[rows].max(axis=0) for rows in large])
    counts = []
    for up in ups:
        plan = np.delete(np.arange(3), up)
        beside = box_gaps(lower[:, plan], upper[:, plan]) > 0
        counts.append(int(connected_components(~beside, directed=False)[0]))
    if min(counts) > 1:
        return Sign(0.8, f"{min(counts)} groups of pieces stand apart from each other")
    return Sign(0.3, f"{len(large)} groups of pieces do not touch each other")


def _beside(contacts: Contacts, groups: Sequence[Ints], ups: Sequence[int]) -> Sign | None:
    """Smaller groups of pieces on the floor around the largest one, such as the men next to a chess board.

    They differ in form, or in how they lie: wheels, feet and knobs that hang in the air next to an object do not.
    """
    lower = np.array([contacts.components.lower[rows].min(axis=0) for rows in groups])
    upper = np.array([contacts.components.upper[rows].max(axis=0) for rows in groups])
    extents, middle = upper - lower, (lower + upper) / 2
    main = int(np.argmax(extents.max(axis=1)))
    longest = float(extents[main].max())
    is_small = (extents.max(axis=1) >= SMALL_GROUP * longest) & (extents.max(axis=1) < LARGE_GROUP * longest)
    counts = []
    for up in ups:
        plan = np.delete(np.arange(3), up)
        apart = (middle[:, plan] > upper[main, plan]).any(axis=1) | (middle[:, plan] < lower[main, plan]).any(axis=1)
        found = is_small & apart & (lower[:, up] <= lower[:, up].min() + LEG_SLACK * longest)
        differ = found.any() and bool((np.ptp(extents[found], axis=0) > ALIKE * extents[found].max()).any())
        counts.append(int(found.sum()) if differ else 0)
    return Sign(0.75, f"{min(counts)} smaller things lie beside it") if min(counts) >= MIN_SMALL else None


def _alike(components: Components, ups: Sequence[int]) -> Sign | None:
    """Compact pieces of one form, or a model made of pieces of one form only; legs of an object do not count."""
    same, is_all = alike_pieces(components)
    if not len(same) or any(_are_legs(components, same, up) for up in ups):
        return None
    if is_all:
        return Sign(0.7, f"it is made of {len(same)} pieces of one form and nothing else")
    return Sign(0.75, f"it holds {len(same)} pieces of one form")


def _are_legs(components: Components, same: Ints, up: int) -> bool:
    """True if everything rests on these pieces of one form, and one other piece rests on all of them."""
    slack = LEG_SLACK * float(np.ptp(components.points, axis=0).max())
    lower, upper = components.lower, components.upper
    if (lower[same, up] > lower[:, up].min() + slack).any():
        return False
    plan = [k for k in range(3) if k != up]
    middle = (lower[same] + upper[same])[:, plan] / 2
    others = np.setdiff1d(np.arange(components.count), same)
    rests = (np.abs(lower[others, None, up] - upper[None, same, up]) <= slack).all(axis=1)
    covers = (lower[others][:, None, plan] <= middle) & (middle <= upper[others][:, None, plan])
    return bool((rests & covers.all(axis=(1, 2))).any())


def alike_pieces(components: Components) -> tuple[Ints, bool]:
    """(K,) separate components of one form, compact ones unless they are all there is; whether they are all."""
    spread, area = _spreads(components)
    longest = float(np.ptp(components.points, axis=0).max())
    for sample in np.argsort(-components.longest_side, kind="stable"):
        if components.longest_side[sample] < ALIKE_SIZE * longest:
            break
        same = (np.abs(spread - spread[sample]) <= ALIKE * spread[sample, 0]).all(axis=1)
        same &= np.abs(area - area[sample]) <= 2 * ALIKE * area[sample]
        rows = np.flatnonzero(same)
        is_all = len(rows) >= 2 and bool(area[rows].sum() >= ALL_ALIKE * area.sum())
        is_compact = len(rows) >= 3 and bool(spread[sample, 2] >= COMPACT * spread[sample, 0])
        if (is_all or is_compact) and _outermost_count(components, rows) >= (2 if is_all else 3):
            return rows, is_all
    return np.zeros(0, dtype=np.int64), False


def _outermost_count(components: Components, rows: Ints) -> int:
    """How many of these components lie within the box of no other: the inner wall of a bowl is no second bowl."""
    lower, upper = components.lower[rows], components.upper[rows]
    is_within = (lower[:, None] >= lower).all(axis=2) & (upper[:, None] <= upper).all(axis=2)
    # Of equal boxes the first one counts.
    is_within &= ~(is_within.T & np.triu(np.ones_like(is_within)))
    return int((~is_within.any(axis=1)).sum())


def _spreads(components: Components) -> tuple[Floats, Floats]:
    """(N, 3) standard deviations of the area of each component along its own axes, largest first; (N,) areas."""
    corners = components.points[components.faces]
    area = face_normals(components.points, components.faces)[1]
    total = np.maximum(np.bincount(components.label, area, components.count), 1e-300)
    # The middles of the edges give the second moments of a triangle exactly.
    middles = (corners + corners[:, [1, 2, 0]]) / 2
    label, weight = np.repeat(components.label, 3), np.repeat(area / 3, 3)
    flat = middles.reshape(-1, 3)
    mean = np.stack([np.bincount(label, weight * flat[:, k], components.count) for k in range(3)], axis=1)
    flat = flat - (mean / total[:, None])[label]
    moments = np.zeros((components.count, 3, 3))
    for i in range(3):
        for j in range(3):
            moments[:, i, j] = np.bincount(label, weight * flat[:, i] * flat[:, j], components.count) / total
    return np.sqrt(np.maximum(np.linalg.eigvalsh(moments)[:, ::-1], 0)), total


def _on_ground(contacts: Contacts, up: int) -> Sign | None:
    """Things side by side on a sheet or slab that lies under all of them."""
    components = contacts.components
    whole = np.ptp(components.points, axis=0)
    plan = [k for k in range(3) if k != up]
    is_ground = grounds(components, up)
    if not is_ground.any() or is_ground.all():
        return None
    top = components.upper[is_ground, up].max()
    groups = []
    for rows in contacts.groups(~is_ground):
        sides, foot = components.extents_of(rows), components.lower[rows, up].min()
        stands = abs(foot - top) <= 0.5 * sides[up] and sides[up] >= ON_GROUND_HEIGHT * sides[plan].min()
        if stands and sides.max() >= ON_GROUND_SIZE * whole.max():
            groups.append(sides)
    is_many = len(groups) >= MIN_ON_GROUND
    is_few = len(groups) > 1 and min(float(s.max()) for s in groups[:2]) >= LARGE_GROUP * whole.max()
    return Sign(0.8, f"{len(groups)} things stand on one ground") if is_many or is_few else None


def grounds(components: Components, up: int) -> Mask:
    """(N,) sheets and slabs at the bottom that lie under most of the rest; `up` is the axis that points up."""
    extents, bottom = components.upper - components.lower, components.lower.min(axis=0)
    whole = np.ptp(components.points, axis=0)
    plan = [k for k in range(3) if k != up]
    thickness = GROUND_THICKNESS * extents[:, plan].min(axis=1)
    is_ground: Mask = (
        (extents[:, up] <= thickness)
        & (extents[:, plan] >= GROUND_COVER * whole[plan]).all(axis=1)
        & (components.upper[:, up] - bottom[up] <= GROUND_THICKNESS * whole[plan].min())
    )
    return is_ground


def _room(contacts: Contacts) -> Sign | None:
    """Walls, of a corner at least, around things that do not touch each other."""
    components = contacts.components
    whole = np.ptp(components.points, axis=0)
    walls = walls_of(components, whole)
    sides = _sides_of_box(components, walls)
    if sides.any(axis=1).sum() < 2:
        return None
    slack = SIDE_DEPTH * whole
    lower, upper = components.lower[walls].min(axis=0) - slack, components.upper[walls].max(axis=0) + slack
    free = []
    for rows in contacts.groups(~walls):
        extents = components.extents_of(rows)
        is_in = (components.lower[rows] >= lower).all() and (components.upper[rows] <= upper).all()
        if is_in and extents.max() >= IN_ROOM_SIZE * whole.max() and (extents < SPANNING * whole).all():
            free.append(extents)
    is_corner = not sides.all(axis=1).any()
    if len(free) < (MIN_IN_CORNER if is_corner else MIN_IN_ROOM):
        return None
    return Sign(0.85, f"walls stand around {len(free)} things that do not touch each other")


def walls_of(components: Components, whole: Floats) -> Mask:
    """(N,) components of planes along the axes that reach over most of the box in two directions at least."""
    reach = ((components.upper - components.lower) >= SPANNING * whole).sum(axis=1) >= 2
    normals, area = face_normals(components.points, components.faces)
    is_along = np.abs(normals).max(axis=1) > 0.98
    planar = np.bincount(components.label, area * is_along, components.count)
    return np.asarray(reach & (planar >= PLANAR * np.bincount(components.label, area, components.count)))


def _sides_of_box(components: Components, walls: Mask) -> Mask:
    """(3, 2) sides of the box around all, lower and upper of each axis, that walls cover."""
    lower, whole = components.points.min(axis=0), np.ptp(components.points, axis=0)
    faces = components.faces[walls[components.label]]
    out = np.zeros((3, 2), dtype=bool)
    if not len(faces):
        return out
    normals, area = face_normals(components.points, faces)
    middle = (components.points[faces].mean(axis=1) - lower) / np.maximum(whole, 1e-30)
    for axis in range(3):
        face_area = float(np.prod(np.delete(whole, axis)))
        is_flat = np.abs(normals[:, axis]) > 0.98
        for end, depth in enumerate((middle[:, axis], 1 - middle[:, axis])):
            out[axis, end] = area[is_flat & (depth < SIDE_DEPTH)].sum() >= SIDE_COVER * face_area
    return out


def components_of(model: RawModel) -> tuple[Components, Ints]:
    """Components of the surface of a model, and the part (K,) that each of the faces belongs to."""
    surface = merge_parts(model.parts)
    owner = np.repeat(np.arange(len(model.parts)), [len(p.mesh.faces) for p in model.parts])
    return split_components(surface.vertices, surface.faces, surface.point_of_vertex), owner


# Names ----------------------------------------------------------------------------------------------------------------


def signs_of_words(source: Source, vocabulary: Vocabulary, words: OtherThingsWords) -> list[Sign]:
    """Signs in the name of the file, or of the node, and in the title; each kind of sign once."""
    found: dict[str, Sign] = {}
    for text in _texts(source):
        match = vocabulary.find([text])
        for key, sign in _signs_of(text, match, vocabulary, words):
            found.setdefault(key, sign)
    return list(found.values())


def sign_of_nodes(nodes: Iterable[Sequence[str]], source: Source, vocabulary: Vocabulary) -> Sign | None:
    """A sign if nodes are named after several categories: a table, a lamp and a vase are no parts of one thing.

    It says little where the file itself is named after a category: a hamburger is made of a bun, cheese and tomatoes.
    """
    kinds: dict[str, str] = {}
    for name in sorted({name for path in nodes for name in path}):
        match = vocabulary.find([name])
        if match is not None and not match.weak and match.confidence >= WEAKLY_TOLD:
            kinds.setdefault(match.id, name)
    if len(kinds) < MIN_KINDS:
        return None
    named = ", ".join(repr(name[:40]) for name in list(kinds.values())[:4])
    own = [vocabulary.find([text]) for text in _texts(source)]
    is_named = any(match is not None and not match.weak and match.confidence >= WEAKLY_TOLD for match in own)
    probability = OWN_KINDS if is_named else MANY_KINDS
    return Sign(probability, f"its nodes are named after {len(kinds)} kinds of things ({named})")


def _texts(source: Source) -> list[str]:
    """Texts that name the object: the node of a file taken apart, else the name of the file and the title."""
    if source.node:
        return [source.node]
    stem = posixpath.splitext(posixpath.basename(source.path))[0]
    return [text for text in (stem, source.title) if text]


def _signs_of(
    text: str, match: VocabularyMatch | None, vocabulary: Vocabulary, words: OtherThingsWords
) -> list[tuple[str, Sign]]:
    every = split_words(text)
    while len(every) > 1 and (len(every[-1]) == 1 or every[-1] in _ENDINGS):
        every.pop()
    if not every:
        return []
    found: list[tuple[str, Sign]] = []
    stems = {singular for word in every for singular in singulars(word)}
    if hit := sorted(stems & set(words.always)):
        found.append(("always", Sign(ALWAYS, f"{hit[0]!r} in {text[:60]!r} is no household object")))
    last = every[-1]
    covers_last = vocabulary.find([last]) is not None
    if not covers_last and last in words.parts and len(every) > 1:
        found.append(("part", Sign(PART, f"{last!r} in {text[:60]!r} is a part of something")))
    # The plural of a word that names a category or a portion; some names are plurals themselves.
    if last not in vocabulary.words and any(one != last and one in vocabulary.words for one in singulars(last)):
        found.append(("plural", Sign(PLURAL, f"{text[:60]!r} speaks of several things")))
    if match is None or match.weak or match.confidence < WEAKLY_TOLD:
        for group, what in _WHAT.items():
            if hit := sorted(stems & set(getattr(words, group))):
                found.append(("other", Sign(OTHER, f"{hit[0]!r} in {text[:60]!r} speaks of {what}")))
                break
    return found


# Guess ----------------------------------------------------------------------------------------------------------------


def guess_of_things(
    model: RawModel, source: Source, category: Category, vocabulary: Vocabulary, words: OtherThingsWords
) -> Guess | None:
    """The guess that a file holds one object, with the signs against it; None if they hardly speak against it."""
    signs = signs_of_words(source, vocabulary, words)
    if model.instances > 1:
        signs.append(Sign(MANY_COPIES, f"a list of places puts {model.instances} copies of meshes"))
    elif not COLLECTIVE & set(split_words(category.id)):
        signs += signs_of_form(model)
    if model.joints >= MIN_JOINTS:
        signs.append(Sign(FIGURE, f"a rig of {model.joints} bones moves it, as it does a figure"))
    named = sign_of_nodes([part.nodes or (part.name,) for part in model.parts], source, vocabulary)
    if named is not None:
        signs.append(named)
    alone = math.prod(1 - sign.probability for sign in signs)
    if 1 - alone < MIN_PROBABILITY:
        return None
    reason = "; ".join(sign.reason for sign in sorted(signs, key=lambda sign: -sign.probability))
    return Guess(subject=SUBJECT, value=ONE, confidence=round(alone, 2), reason=reason)


@dataclass(frozen=True)
class Thing:
    """One thing of a file: an id that is unique in it, its parts as they lie there, and how many equal ones it has."""

    name: str
    parts: tuple[RawPart, ...]
    count: int = 1


def things_of(model: RawModel) -> list[Thing]:
    """The things of a model, the largest first; one that is as the model where it cannot be taken apart."""
    components, owner = components_of(model)
    if components.count == 1 or components.count > MAX_COMPONENTS:
        return [Thing(_name(model, np.arange(len(model.parts))), model.parts)]
    label = _thing_of_component(model, components, owner)
    sizes = [float(components.extents_of(label == k).max()) for k in range(int(label.max()) + 1)]
    order = sorted(range(len(sizes)), key=lambda k: (-sizes[k], int(np.flatnonzero(label == k)[0])))
    face_label = label[components.label]
    found: list[Thing] = []
    names = UniqueNames()
    for k in order:
        parts = tuple(part.replace(copy_number=0) for part in keep_faces(model.parts, face_label == k))
        twin = next((i for i, one in enumerate(found) if _are_equal(one.parts, parts)), None)
        if twin is not None:
            found[twin] = Thing(found[twin].name, found[twin].parts, found[twin].count + 1)
        else:
            found.append(Thing(names.unique(_name(model, np.unique(owner[face_label == k])), "thing"), parts))
    return found


def model_of_thing(model: RawModel, name: str, file: str) -> RawModel:
    """One object of a model alone, with a note on where it is from. Raises Rejected: there is none of that name."""
    things = things_of(model)
    taken = things[:MAX_THINGS]
    thing = next((one for one in taken if one.name == name), None)
    if thing is None:
        raise Rejected(codes.NO_GEOMETRY, f"{file}: holds nothing called {name!r}; run again with --split")
    message = f"one of {len(taken)} different things in {file}"
    if thing.count > 1:
        message += f"; there are {thing.count} equal ones"
    if len(things) > MAX_THINGS:
        message += f"; {len(things) - MAX_THINGS} more are left out, for more than {MAX_THINGS} are not taken"
    notes = (*model.notes, warning(codes.TAKEN_APART, name, message))
    return model.replace(parts=thing.parts, notes=notes, joints=0, instances=0)


def _thing_of_component(model: RawModel, components: Components, owner: Ints) -> Ints:
    contacts = Contacts(components)
    whole = np.ptp(components.points, axis=0)
    is_under = np.any([grounds(components, up) for up in up_axes(model)], axis=0) | walls_of(components, whole)
    is_alike = np.zeros(components.count, dtype=bool)
    is_alike[alike_pieces(components)[0]] = True
    first_face = np.unique(components.label, return_index=True)[1]
    part = owner[first_face]
    group = _groups_of_nodes(model)[part]
    copy = np.array([p.copy_number for p in model.parts])[part]
    one, other = contacts.pairs.T if len(contacts.pairs) else np.zeros((2, 0), dtype=np.int64)
    is_joined = (
        (is_under[one] == is_under[other])
        & ~(is_alike[one] & is_alike[other])
        & (copy[one] == copy[other])
        & (group[one] == group[other])
    )
    # A piece of something alike and what else is there belong together only where that is a crumb on it.
    mixed = is_alike[one] != is_alike[other]
    size = components.longest_side
    is_joined &= ~mixed | (np.minimum(size[one], size[other]) < 0.3 * np.maximum(size[one], size[other]))
    rows, columns = one[is_joined], other[is_joined]
    # Of what a crumb touches it belongs to the first alone, or it would join them.
    crumbs = np.where(is_alike[rows], columns, np.where(is_alike[columns], rows, -1))
    is_first = np.ones(len(rows), dtype=bool)
    is_first[crumbs >= 0] = False
    is_first[np.flatnonzero(crumbs >= 0)[np.unique(crumbs[crumbs >= 0], return_index=True)[1]]] = True
    rows, columns = rows[is_first], columns[is_first]
    # A copy is whole, whatever it touches.
    keys = {key: number for number, key in enumerate(dict.fromkeys((p.nodes, p.copy_number) for p in model.parts))}
    key = np.array([keys[p.nodes, p.copy_number] for p in model.parts])[part]
    first_of_copy = np.unique(key, return_index=True)[1][key]
    rows = np.concatenate((rows, np.flatnonzero(copy > 0)))
    columns = np.concatenate((columns, first_of_copy[copy > 0]))
    return _with_crumbs(components, connected_groups(components.count, rows, columns), copy)


def _with_crumbs(components: Components, label: Ints, copy: Ints) -> Ints:
    """The labels, renumbered, with groups that are small compared with the largest given to the nearest large one."""
    count = int(label.max()) + 1
    lower, upper = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(lower, label, components.lower)
    np.maximum.at(upper, label, components.upper)
    size = (upper - lower).max(axis=1)
    is_copy = np.zeros(count, dtype=bool)
    is_copy[label[copy > 0]] = True
    is_large = (size >= CRUMB * size.max()) | is_copy
    large = np.flatnonzero(is_large)
    target = np.arange(count)
    for k in np.flatnonzero(~is_large):
        gaps = np.linalg.norm(np.maximum(0, np.maximum(lower[large] - upper[k], lower[k] - upper[large])), axis=1)
        # Of those that are equally near, the smallest: what lies on a table within the walls belongs to the table.
        nearest = large[gaps <= gaps.min() + 1e-12]
        target[k] = nearest[np.argmin(size[nearest])]
    return np.unique(target[label], return_inverse=True)[1].reshape(-1).astype(np.int64)


def _groups_of_nodes(model: RawModel) -> Ints:
    """(K,) group of each part: parts that the file keeps in different groups of nodes are not joined by contact.

    The groups are the children of the node that holds all, if some of them hold several nodes themselves. A flat list
    of nodes says nothing: they may as well be the legs and the seat of a chair.
    """
    paths = [part.nodes for part in model.parts]
    depth = 0
    while all(len(path) > depth + 1 for path in paths) and len({path[depth] for path in paths}) == 1:
        depth += 1
    heads = [path[depth] if len(path) > depth else "" for path in paths]
    leaves = {(head, path) for head, path in zip(heads, paths, strict=True)}
    is_nested = len(leaves) > len(set(heads)) > 1
    if not is_nested:
        return np.zeros(len(paths), dtype=np.int64)
    return np.unique(heads, return_inverse=True)[1].reshape(-1).astype(np.int64)


def _name(model: RawModel, parts: Ints) -> str:
    """Name of the deepest node that holds these parts and not all of the file; else of the first of them."""
    paths = [model.parts[number].nodes for number in parts]
    shared = 0
    while all(len(path) > shared for path in paths) and len({path[shared] for path in paths}) == 1:
        shared += 1
    return paths[0][shared - 1] if shared else model.parts[int(parts[0])].name


def _are_equal(one: Sequence[RawPart], other: Sequence[RawPart]) -> bool:
    """True if one thing is the other moved and turned: the same faces and materials, and corners that fit."""
    if len(one) != len(other):
        return False
    for a, b in zip(one, other, strict=True):
        if a.material.id != b.material.id or not np.array_equal(a.mesh.faces, b.mesh.faces):
            return False
    first, second = (np.concatenate([part.mesh.vertices for part in parts]) for parts in (one, other))
    if first.shape != second.shape:
        return False
    first, second = first - first.mean(axis=0), second - second.mean(axis=0)
    if abs(np.linalg.norm(first) / max(float(np.linalg.norm(second)), 1e-300) - 1) > EQUAL:
        return False
    left, _, right = np.linalg.svd(first.T @ second)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right)) or 1.0])
    return bool(np.abs(first @ left @ sign @ right - second).max() <= EQUAL * np.abs(first).max())


def load(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """Read a mesh; `limits`: as in registry/limits.yaml. Raises Rejected: unreadable, or the thing is not there."""
    model = formats.load(bundle, limits)
    return model_of_thing(model, bundle.thing, printable(bundle.main)) if bundle.thing else model
