"""Rigged glTF meshes -> vertices in their rest pose."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from casa_assets.core.typing import Floats
from casa_assets.ingest.load.gltf.accessor import Accessors
from casa_assets.ingest.load.gltf.graph import MeshInstance, SceneGraph
from casa_assets.ingest.load.gltf.tree import JsonObject


def rest_vertices(
    document: JsonObject,
    accessors: Accessors,
    graph: SceneGraph,
    placed: MeshInstance,
    attributes: JsonObject,
    used: npt.NDArray[np.int64],
    vertices: Floats,
) -> Floats | None:
    """(V, 3) vertices moved by their joints at rest, file frame; None where the mesh is not rigged or not readably so.

    Ref: glTF 2.0, 3.7.3: the node of a skinned mesh does not move it, its joints do.
    """
    if placed.node is None or not attributes.has("JOINTS_0") or not attributes.has("WEIGHTS_0"):
        return None
    node = document.pick(placed.node, "nodes")
    if not node.has("skin"):
        return None
    matrices = _joint_matrices(document, accessors, graph, document.pick(node.count("skin"), "skins"))
    joints = accessors.floats(attributes.count("JOINTS_0"), (4,))
    weights = accessors.floats(attributes.count("WEIGHTS_0"), (4,))
    if matrices is None or min(len(joints), len(weights)) <= int(used[-1]):
        return None
    joints, weights = joints[used].astype(np.int64), weights[used]
    total = weights.sum(axis=1)
    if not np.isfinite(weights).all() or (total <= 1e-6).any() or not 0 <= joints.min() <= joints.max() < len(matrices):
        return None
    weights = weights / total[:, None]
    out = np.zeros_like(vertices)
    for k in range(4):
        m = matrices[joints[:, k]]
        out += weights[:, k, None] * (np.einsum("vij,vj->vi", m[:, :3, :3], vertices) + m[:, :3, 3])
    return out


def joint_count(document: JsonObject, graph: SceneGraph) -> int:
    """Joints of the largest skin that moves a placed mesh; 0 where none does."""
    nodes = [document.pick(placed.node, "nodes") for placed in graph.placed if placed.node is not None]
    skins = {node.count("skin") for node in nodes if node.has("skin")}
    return max((len(document.pick(skin, "skins").array("joints")) for skin in skins), default=0)


def _joint_matrices(document: JsonObject, accessors: Accessors, graph: SceneGraph, skin: JsonObject) -> Floats | None:
    """(J, 4, 4) file_from_bind of every joint, or None where a joint stands outside the scene."""
    joints = [j for j in skin.array("joints") if isinstance(j, int) and j in graph.world_from_node]
    if not joints or len(joints) != len(skin.array("joints")):
        return None
    worlds = np.array([graph.world_from_node[j] for j in joints])
    if skin.has("inverseBindMatrices"):
        inverse = accessors.floats(skin.count("inverseBindMatrices"), (16,))
        if len(inverse) < len(joints):
            return None
        worlds = worlds @ inverse[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    return worlds if np.isfinite(worlds).all() else None
