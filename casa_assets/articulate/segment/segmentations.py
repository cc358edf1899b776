"""List the ways in which a mesh may fall into fragments; each is followed to a plan before one is chosen.

No single rule fits all makers: some export each part as a separate piece that shares positions with the body, so that
welding by position joins door and body; others split one board into many pieces, and welding puts it together again.
"""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from casa_assets.articulate.segment.flat_sheets import FlatSheets, find_flat_sheets, split_at_holes
from casa_assets.articulate.segment.fragment_measures import corners_of_labels
from casa_assets.articulate.segment.welded_mesh import Bools, WeldedMesh, weld_by_edges
from casa_assets.core.typing import Ints
from casa_assets.geometry.mesh.topology import connected_groups, merge_rows

# A file of more pieces than this, or of pieces with fewer faces than this in the mean, is split at every crease: its
# pieces say nothing about its parts.
MAX_PIECES, MIN_FACES_PER_PIECE = 1500, 3.0
# Pieces of a fragment are told apart only where it spans this share of the object along two axes.
LARGE_EXTENT_SHARE = 0.6
# Pieces whose longest side is at most this share of the diagonal join those of their kind that they share edges with:
# they are facets of knobs, posts and bars of handles. Ref: knobs and buttons are at most 0.121 long (controls.py).
SMALL_PIECE = 0.14
# Neighbouring faces whose normals are further apart than this meet in a crease: cosine of 37 degrees.
CREASE_COS = 0.8
# Fewest and most nodes that may be the parts of an object.
MIN_NODES, MAX_NODES = 3, 300


class Segmentation(StrEnum):
    """Way in which a mesh is split into fragments."""

    CREASES = "welded, cut at concave creases"
    HOLES = "welded, cut at holes of flat sheets"
    WELDED = "welded"
    PIECES = "pieces"
    LARGE_SPLIT = "pieces of large fragments"
    COLOURLESS = "welded across materials"
    NODES = "nodes"


def segmentations(mesh: WeldedMesh) -> dict[Segmentation, Ints]:
    """Return the (F,) fragment labels of each different way to split a mesh, the way that fits most meshes first.

    Labels are numbered by first face; faces without area have -1.
    """
    welded = mesh.fragment_labels
    alive = welded >= 0
    if not alive.any():
        return {Segmentation.WELDED: welded}
    candidates: dict[Segmentation, Ints] = {}
    sheets = find_flat_sheets(mesh)
    colours = mesh.material_index[mesh.duplicate_of]
    split = _with_small_ones_joined(mesh, _split_at_creases(mesh), sheets)
    candidates[Segmentation.CREASES] = _numbered(alive, split, colours)
    if sheets.has_hole.any():
        split = _with_small_ones_joined(mesh, split_at_holes(mesh, sheets), sheets)
        candidates[Segmentation.HOLES] = _numbered(alive, split, colours)
    candidates[Segmentation.WELDED] = welded
    pieces = mesh.piece_index[mesh.duplicate_of]
    count = len(np.unique(pieces[alive]))
    if 1 < count <= MAX_PIECES and alive.sum() >= MIN_FACES_PER_PIECE * count:
        pieces = _with_small_ones_joined(mesh, pieces, sheets)
        candidates[Segmentation.PIECES] = _numbered(alive, pieces, colours)
        large = _is_large(mesh, welded)
        split = np.where(large[np.maximum(welded, 0)], pieces + 1, 0)
        candidates[Segmentation.LARGE_SPLIT] = _numbered(alive, welded, split)
    if len(np.unique(mesh.material_index[alive])) > 1:
        candidates[Segmentation.COLOURLESS] = weld_by_edges(mesh, by_material=False)
    if MIN_NODES <= len(np.unique(mesh.node_index[alive])) <= MAX_NODES:
        candidates[Segmentation.NODES] = _numbered(alive, mesh.node_index[mesh.duplicate_of])
    found: dict[Segmentation, Ints] = {}
    for way, labels in candidates.items():
        others = [welded] if way is not Segmentation.WELDED else []
        if not any(np.array_equal(labels, other) for other in [*others, *found.values()]):
            found[way] = labels
    return found


def _split_at_creases(mesh: WeldedMesh) -> Ints:
    """Return the (F,) number of what is connected without crossing a concave crease, as parts meet what bears them."""
    left, right = mesh.solid_neighbors
    middle = mesh.points[mesh.faces].mean(axis=1)
    bent = (mesh.normals[left] * mesh.normals[right]).sum(axis=1) < CREASE_COS
    inwards = np.where(_wind_inwards(mesh), -1.0, 1.0)[left]
    concave = inwards * ((middle[right] - middle[left]) * mesh.normals[left]).sum(axis=1) > 0.0
    whole = ~(bent & concave)
    return connected_groups(len(mesh.faces), left[whole], right[whole])[mesh.duplicate_of]


def _wind_inwards(mesh: WeldedMesh) -> Bools:
    """Mark the (F,) faces of welded fragments whose volume about their middle is negative."""
    label = np.maximum(mesh.fragment_labels, 0)
    # The two copies of a face that is there twice would cancel each other.
    counts = (mesh.fragment_labels >= 0) & (mesh.duplicate_of == np.arange(len(label)))
    count = np.maximum(np.bincount(label), 1)[:, None]
    corners = mesh.points[mesh.faces]
    middle = np.stack([np.bincount(label, corners.mean(axis=1)[:, k]) for k in range(3)], axis=1) / count
    corners = corners - middle[label][:, None]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    found: Bools = np.bincount(label, np.where(counts, volume, 0.0))[label] < 0.0
    return found


def _with_small_ones_joined(mesh: WeldedMesh, pieces: Ints, sheets: FlatSheets) -> Ints:
    """Return the (F,) pieces with those joined that are small, share an edge, and are small together.

    A piece that is a sheet with a hole is part of the body, and joins nothing.
    """
    lower, upper = corners_of_labels(mesh, pieces)
    small = (upper - lower).max(axis=1) <= SMALL_PIECE * mesh.diagonal
    left, right = (pieces[faces] for faces in mesh.solid_neighbors)
    is_more = np.zeros(len(small), dtype=bool)  # than a sheet with a hole
    is_more[pieces[~sheets.has_hole[sheets.sheet] & (mesh.areas > 0.0)]] = True
    small &= is_more
    both = small[left] & small[right] & (left != right)
    count = len(small)
    joined = connected_groups(count, left[both], right[both])
    lower, upper = corners_of_labels(mesh, joined[pieces])
    together = (upper - lower).max(axis=1) <= SMALL_PIECE * mesh.diagonal
    found: Ints = np.where(together[joined], joined, joined.max(initial=0) + 1 + np.arange(count))[pieces]
    return found


def _is_large(mesh: WeldedMesh, label: Ints) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Mark the (N,) fragments that span most of the object along two axes."""
    lower, upper = corners_of_labels(mesh, label)
    wide = (upper - lower) >= LARGE_EXTENT_SHARE * np.ptp(mesh.points, axis=0)
    found: np.ndarray[tuple[int], np.dtype[np.bool_]] = wide.sum(axis=1) >= 2
    return found


def _numbered(alive: np.ndarray[tuple[int], np.dtype[np.bool_]], *keys: Ints) -> Ints:
    """Return (F,) labels of faces that agree in all keys, numbered by first face; -1 for faces without area."""
    labels = np.full(len(alive), -1, dtype=np.int64)
    _, labels[alive] = merge_rows(np.column_stack(keys)[alive].astype(np.float64))
    return labels
