"""Asset -> USD package. Decides nothing: what is written is in the asset.

<id>/
  usd/<id>.usda
  usd/textures/                the pictures; model.xml may refer to them here
  usd/.thumbs/256x256/<id>.usda.png

/<id>                          kind component, labels
  /visualMaterials /physicsMaterials /physicsJoints
  /object                      rigid body, base of the articulation where there are joints
    /visual /collision /sites
  /door                        rigid body, a sibling: physics nests by joints, not by paths
"""

from __future__ import annotations

from pxr import Sdf, Usd, UsdGeom

from casa_assets.export.usd import behavior, body, contact, joint, keyframe, label, material, metadata, site
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files

FOLDER = "usd"
TEXTURES = "textures"  # inside the folder of the layer: SimReady refuses what is reached through `..`


def write(asset: Asset, thumbnail: bytes) -> Files:
    """The USD package of an asset, paths relative to the asset's folder.

    Args:
        asset: what to write.
        thumbnail: PNG, 256 x 256, of the asset.
    Returns:
        `usd/<id>.usda`, its thumbnail, and `usd/textures/<file name>` for every picture that the layer refers to.
    """
    name = f"{asset.id}.usda"
    entries = {
        f"{FOLDER}/{name}": layer_text(asset).encode("utf-8"),
        f"{FOLDER}/.thumbs/256x256/{name}.png": thumbnail,
    }
    for item in asset.materials:
        entries |= {f"{FOLDER}/{TEXTURES}/{t.file_name}": t.png for t in item.textures}
    return Files.of(entries)


def layer_text(asset: Asset, textures: str = f"./{TEXTURES}") -> str:
    """The root layer as usda text: the same text for the same asset, whatever was written before.

    Args:
        asset: what to write.
        textures: leads from the layer to the folder of the pictures.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    root = UsdGeom.Xform.Define(stage, Sdf.Path.absoluteRootPath.AppendChild(asset.id)).GetPrim()
    path = root.GetPath()
    metadata.set_stage(stage, root)
    metadata.set_model(root, asset)
    metadata.set_provenance(layer, asset)
    label.attach_all(root, asset)
    looks = material.define_all(stage, path, asset, textures)
    for link in asset.links:
        body.define(stage, path.AppendChild(link.name), asset, link, looks)
    joint.define_all(stage, path, asset)
    site.define_all(stage, path, asset)
    contact.filter_all(stage, path, asset)
    behavior.define_all(stage, root, asset)
    keyframe.define_all(stage, root, asset)
    text: str = layer.ExportToString()
    return text
