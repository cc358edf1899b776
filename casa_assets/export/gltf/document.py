"""Asset -> GLB.

Metres. One root node turns our z up into glTF's y up; below it all frames are those of the record. `extras`:

| node | `extras` |
|---|---|
| root | `casa_assets` (version of this table), `id`, `kind` (`asset` or `scene`), `poses`: name -> joint -> position |
| copy of an asset in a scene | `placement`: `name`, `asset`, `category`, `layer` |
| link | `link`, and if a joint moves it `joint`: `name`, `type` (`hinge` or `slide`), `axis` and `anchor` in the |
| | frame of the link, `range`, `rest` (position in the file), `states` (value -> share of the range), `behind` |
| drawn node | `layer` (see LayerName); for a collider or a region also its name and kind |

A link moves by `motion(position - rest)` after the pose of its node: about the axis through the anchor (rad), or along
the axis (m). Names are paths: `door`, or in a scene `fridge/door`; the name of its joint is `fridge/door_joint`.
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
    """A GLB while it is being built: one root node, and the nodes below it."""

    def __init__(self, name: str, kind: str, picture_px: int) -> None:
        """Start with the root node; `kind`: `asset` or `scene`; `picture_px`: maximum pixels along a picture's side."""
        self.binary = Binary()
        self.meshes = Meshes(self.binary, Materials(self.binary, picture_px))
        self.nodes = Nodes()
        self.extras: dict[str, Any] = {"casa_assets": EXTRAS_VERSION, "id": name, "kind": kind}
        self.root = self.nodes.add({"name": name, "extras": self.extras, **placed(Y_UP)})
        self.cameras: list[dict[str, Any]] = []

    def bytes(self) -> bytes:
        """Return the file."""
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
    """Return the GLB of an asset; the same asset gives the same bytes.

    Its joints are in the first of its named poses, or at zero.

    Args:
        layers: layers in addition to the visuals.
        picture_px: maximum pixels along a side of a picture.
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
