"""Take a model apart into its things: by nodes, by contact and by distance. Equal things become one with a count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.core.numeric import Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.text import UniqueNames
from casa_assets.ingest.draft import warning
from casa_assets.ingest.repair.components import Components
from casa_assets.ingest.texture import submesh
from casa_assets.ingest.things.signs import (
    MAX_COMPONENTS,
    Contacts,
    alike_pieces,
    components_of,
    grounds,
    up_axes,
    walls_of,
)
from casa_assets.mesh.topology import connected_groups
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import RawModel, RawPart

# Things that are taken out of one file, the largest first; a choice.
MAX_THINGS = 256
# A group of pieces smaller than this share of the largest thing belongs to the thing that is nearest; a choice.
CRUMB = 0.06
# Equal things differ by no more than this share of their size once one lies on the other.
EQUAL = 1e-3


@dataclass(frozen=True)
class Thing:
    """One thing of a file: an id that is unique in it, its parts as they lie there, and how many equal ones it has."""

    name: str
    parts: tuple[RawPart, ...]
    count: int = 1


@dataclass(frozen=True)
class Things:
    """The things of a file, the largest first, and how many more there are than are taken."""

    taken: tuple[Thing, ...]
    left_out: int = 0


def things_of(model: RawModel) -> Things:
    """The things of a model; one that is as the model where it cannot be taken apart."""
    components, owner = components_of(model)
    if components.count == 1 or components.count > MAX_COMPONENTS:
        return Things((Thing(_name(model, np.arange(len(model.parts))), model.parts),))
    label = _thing_of_component(model, components, owner)
    sizes = [float(components.extents_of(label == k).max()) for k in range(int(label.max()) + 1)]
    order = sorted(range(len(sizes)), key=lambda k: (-sizes[k], int(np.flatnonzero(label == k)[0])))
    face_label = label[components.label]
    found: list[Thing] = []
    names = UniqueNames()
    for k in order:
        parts = _parts(model, owner, face_label == k)
        twin = next((i for i, one in enumerate(found) if _are_equal(one.parts, parts)), None)
        if twin is not None:
            found[twin] = Thing(found[twin].name, found[twin].parts, found[twin].count + 1)
        else:
            found.append(Thing(names.unique(_name(model, np.unique(owner[face_label == k])), "thing"), parts))
    return Things(tuple(found[:MAX_THINGS]), max(0, len(found) - MAX_THINGS))


def model_of_thing(model: RawModel, name: str, file: str) -> RawModel:
    """One object of a model alone, with a note on where it is from. Raises Rejected: there is none of that name."""
    things = things_of(model)
    thing = next((one for one in things.taken if one.name == name), None)
    if thing is None:
        raise Rejected(codes.NO_GEOMETRY, f"{file}: holds nothing called {name!r}; run again with --split")
    message = f"one of {len(things.taken)} different things in {file}"
    if thing.count > 1:
        message += f"; there are {thing.count} equal ones"
    if things.left_out:
        message += f"; {things.left_out} more are left out, for more than {MAX_THINGS} are not taken"
    notes = (*model.notes, warning(codes.TAKEN_APART, name, message))
    return model.replace(parts=thing.parts, notes=notes, joints=0, instances=0)


def _thing_of_component(model: RawModel, components: Components, owner: Ints) -> Ints:
    """(N,) number of the thing that each component belongs to."""
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


def _parts(model: RawModel, owner: Ints, keep: Ints) -> tuple[RawPart, ...]:
    """The parts with the faces that are kept, (F,) over all parts."""
    out = []
    for number in np.unique(owner[keep]):
        part = model.parts[number]
        own = keep[owner == number]
        mesh = part.mesh if own.all() else submesh(part.mesh, part.mesh.faces[own], keep_normals=True)
        out.append(part.replace(mesh=mesh, copy_number=0))
    return tuple(out)


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
