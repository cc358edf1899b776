"""Asset -> GLB.

Metres. One root node turns our z up into glTF's y up; below it every node has the frames of the record. `extras` hold:

| node | `extras` |
|---|---|
| root | `casa_assets` (version of this table), `id`, `kind` (`asset` or `scene`), `poses`: name -> joint -> position |
| copy of an asset in a scene | `placement`: `name`, `asset`, `category`, `layer` |
| link | `link`, and where a joint moves it `joint`: `name`, `type` (`hinge` or `slide`), `axis` and `anchor` in the |
| | frame of the link, `range`, `rest` (where it stands in the file), `states` (value -> share of the range), `behind` |
| what is shown | `layer` (see LayerName); a collider and a region come with their names and kinds |

A link moves by `motion(position - rest)` after the pose of its node: about the axis through the anchor (rad), or along
the axis (m). Names are paths: `door`, in a scene `fridge/door`; that of a joint is `fridge/door_joint`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from casa_assets.export.gltf import body
from casa_assets.export.gltf.binary import Binary, glb
from casa_assets.export.gltf.body import Copy, Nodes
from casa_assets.export.gltf.layer import SEEN_ALONE, Layers
from casa_assets.export.gltf.material import Materials
from casa_assets.export.gltf.number import placed, rounded
from casa_assets.export.gltf.visual import Meshes
from casa_assets.model.asset.asset import Asset, JointValue
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.pose import Pose

EXTRAS_VERSION = 1
PICTURE_PX = 512
# Turns z up into y up.
Y_UP = Pose(quaternion=(0.5**0.5, -(0.5**0.5), 0.0, 0.0))


class Document:
    """A GLB as it grows: one root node, and what is put below it."""

    def __init__(self, name: str, kind: str, picture_px: int) -> None:
        """Only the root node; `kind` is `asset` or `scene`, `picture_px` the most pixels along a side of a picture."""
        self.binary = Binary()
        self.meshes = Meshes(self.binary, Materials(self.binary, picture_px))
        self.nodes = Nodes()
        self.extras: dict[str, Any] = {"casa_assets": EXTRAS_VERSION, "id": name, "kind": kind}
        self.root = self.nodes.add({"name": name, "extras": self.extras, **placed(Y_UP)})
        self.cameras: list[dict[str, Any]] = []

    def bytes(self) -> bytes:
        """The file."""
        members: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "casa-assets"},
            "scene": 0,
            "scenes": [{"name": self.extras["id"], "nodes": [self.root]}],
            "nodes": self.nodes.rows,
            **({"meshes": self.meshes.rows} if self.meshes.rows else {}),
            **({"cameras": self.cameras} if self.cameras else {}),
            **self.meshes.materials.document(),
        }
        return glb(members, self.binary)


def asset_glb(asset: Asset, layers: Layers = SEEN_ALONE, picture_px: int = PICTURE_PX) -> bytes:
    """The GLB of an asset, its joints at the first of its named poses or at zero; the same asset is the same bytes.

    Args:
        layers: what it holds besides what is seen. picture_px: most pixels along a side of a picture.
    """
    document = Document(asset.id, "asset", picture_px)
    document.extras["poses"] = {key.name: values(key.joints) for key in asset.keyframes}
    document.extras["category"] = asset.labels.category
    start = joint_positions(asset.keyframes[0].joints) if asset.keyframes else {}
    body.add_all(document.nodes, document.meshes, Copy(asset, positions=start), document.root, layers)
    return document.bytes()


def values(joints: Iterable[JointValue] | Mapping[str, float], prefix: str = "") -> dict[str, float]:
    """Name of a joint in the file -> position, rad or m."""
    positions = joints if isinstance(joints, Mapping) else joint_positions(joints)
    return {prefix + name: rounded([at])[0] for name, at in positions.items()}
