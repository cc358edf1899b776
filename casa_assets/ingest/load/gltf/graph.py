"""glTF node graph -> world matrices of the nodes that carry a mesh; no recursion, no node twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.gltf.tree import JsonObject
from casa_assets.ingest.load.notes import Notes

Matrix = npt.NDArray[np.float64]

MAX_NAMES = 16
# A quaternion shorter than this states no rotation.
_SHORTEST = 1e-9

_IDENTITY16 = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class MeshInstance:
    """A mesh at its place.

    Attributes:
        node: index of the node, or None for a mesh that no node carries.
        mesh: index of the mesh.
        world_from_mesh: (4, 4), file units.
        names: of the nodes from the root down to this one; a node without a name is called by its number.
        copy_number: from 1, of a copy that a list of places makes; 0 without one.
    """

    node: int | None
    mesh: int
    world_from_mesh: Matrix
    names: tuple[str, ...] = ()
    copy_number: int = 0


@dataclass(frozen=True)
class SceneGraph:
    """Placed meshes of the shown scene, and the world matrix of every node in it."""

    placed: tuple[MeshInstance, ...]
    world_from_node: dict[int, Matrix]


def read_graph(document: JsonObject, notes: Notes) -> SceneGraph:
    """Walk the shown scene; fall back to all root nodes, then to bare meshes, each with a note.

    Raises:
        Rejected: BAD_SCENE_GRAPH (a node reached twice: a cycle, or instances without end), OUT_OF_BOUNDS.
    """
    nodes = document.items("nodes")
    roots = _scene_roots(document)
    if roots is not None:
        graph = _walk(document, nodes, roots, notes)
        if graph.placed or not document.array("meshes"):
            return graph
    notes.add(
        codes.MESH_OUTSIDE_SCENE,
        "scenes",
        "no mesh stands in the shown scene; all meshes of the file are used",
    )
    children = {_index(child, node) for node in nodes for child in node.array("children")}
    graph = _walk(document, nodes, [i for i in range(len(nodes)) if i not in children], notes)
    if graph.placed:
        return graph
    if nodes and len(children) >= len(nodes):
        message = "glTF nodes: every node has a parent, so they form a cycle; export it again"
        raise Rejected(codes.BAD_SCENE_GRAPH, message)
    bare = tuple(MeshInstance(None, i, np.eye(4)) for i in range(len(document.items("meshes"))))
    return SceneGraph(bare, graph.world_from_node)


def _scene_roots(document: JsonObject) -> list[int] | None:
    scenes = document.array("scenes")
    if not scenes:
        return None
    scene = document.pick(document.count("scene", 0), "scenes")
    return [_index(value, scene) for value in scene.array("nodes")]


def _walk(document: JsonObject, nodes: list[JsonObject], roots: list[int], notes: Notes) -> SceneGraph:
    worlds: dict[int, Matrix] = {}
    placed: list[MeshInstance] = []
    above: tuple[str, ...] = ()
    stack = [(root, np.eye(4), above) for root in reversed(roots)]
    meshes = len(document.array("meshes"))
    while stack:
        index, parent, above = stack.pop()
        if index >= len(nodes):
            raise Rejected(codes.OUT_OF_BOUNDS, f"glTF nodes: index {index} of {len(nodes)}; export the file again")
        if index in worlds:
            message = f"glTF nodes/{index}: reached twice (a cycle or a shared child); export the file again"
            raise Rejected(codes.BAD_SCENE_GRAPH, message)
        node = nodes[index]
        with np.errstate(over="ignore", invalid="ignore"):
            worlds[index] = parent @ local_matrix(node, notes)
        # A chain of nodes may be as deep as the file is long: names of so many levels are kept and no more.
        names = (*above, node.text("name") or f"node_{index}") if len(above) < MAX_NAMES else above
        if node.has("mesh"):
            mesh = node.count("mesh")
            if mesh >= meshes:
                raise Rejected(codes.OUT_OF_BOUNDS, f"glTF {node.place}/mesh: {mesh} of {meshes}; export it again")
            placed.append(MeshInstance(index, mesh, worlds[index], names))
        stack.extend((_index(child, node), worlds[index], names) for child in reversed(node.array("children")))
    return SceneGraph(tuple(placed), worlds)


def local_matrix(node: JsonObject, notes: Notes) -> Matrix:
    """(4, 4) parent_from_node, file units."""
    if node.has("matrix"):
        return np.array(node.numbers("matrix", _IDENTITY16)).reshape(4, 4).T
    x, y, z, w = node.numbers("rotation", (0.0, 0.0, 0.0, 1.0))
    if x * x + y * y + z * z + w * w < _SHORTEST**2:
        notes.add(codes.BAD_ROTATION, node.place, "the rotation quaternion is zero; read as no rotation")
    translation, scale = node.numbers("translation", (0.0, 0.0, 0.0)), node.numbers("scale", (1.0, 1.0, 1.0))
    return placing_matrix(translation, (x, y, z, w), scale)


def placing_matrix(translation: Sequence[float], rotation: Sequence[float], scale: Sequence[float]) -> Matrix:
    """(4, 4) parent_from_node of a translation, a quaternion x, y, z, w (of no length: no turn) and a scale."""
    x, y, z, w = rotation
    length = float(np.sqrt(x * x + y * y + z * z + w * w))
    if length < _SHORTEST:
        x, y, z, w, length = 0.0, 0.0, 0.0, 1.0, 1.0
    x, y, z, w = x / length, y / length, z / length, w / length
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    out = np.eye(4)
    out[:3, :3] = turn * np.array(scale)
    out[:3, 3] = translation
    return out


def _index(value: object, node: JsonObject) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise Rejected(codes.BAD_SCHEMA, f"glTF {node.place}: {str(value)[:20]!r} is no node index; export it again")
    return value
