"""Asset -> USD package.

<id>/
  usd/<id>.usda
  usd/nested/<id>.usda         the same with bodies below the bodies that carry them, if there are several
  usd/textures/                the pictures; model.xml may refer to them here
  usd/.thumbs/256x256/<id>.usda.png

/<id>                          kind component, labels
  /visualMaterials /physicsMaterials /physicsJoints
  /object                      rigid body, base of the articulation if there are joints
    /visual /collision /sites
  /door                        rigid body, a sibling of `object`: bodies are connected by joints, not by paths
"""

from __future__ import annotations

from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics

from casa_assets.export.usd import body, contact, joint, keyframe, label, material, nested, site
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files

FOLDER = "usd"
TEXTURES = "textures"  # inside the folder of the layer: SimReady refuses paths with `..`
# The day on which this writer's output last changed, not the day of the run, which would make two runs over the same
# asset differ. Change it whenever the bytes that the writer makes change.
WRITER_DATE = "2026-11-22"
WRITER_VERSION = "1"
UNKNOWN = "unknown"  # SimReady refuses an empty string


def write(asset: Asset, thumbnail: bytes) -> Files:
    """Return the USD package of an asset, paths relative to the asset's folder.

    Args:
        asset: the asset.
        thumbnail: PNG, 256 x 256, of the asset.
    Returns:
        `usd/<id>.usda`, its thumbnail, `usd/textures/<file name>` for every picture that the layer refers to, and
        `usd/nested/<id>.usda` if there are several links.
    """
    name = f"{asset.id}.usda"
    entries = {
        f"{FOLDER}/{name}": layer_text(asset).encode("utf-8"),
        f"{FOLDER}/.thumbs/256x256/{name}.png": thumbnail,
    }
    if len(asset.links) > 1:
        entries[f"{FOLDER}/{nested.FOLDER}/{name}"] = nested.asset_text(asset).encode("utf-8")
    for look in asset.materials:
        entries |= {f"{FOLDER}/{TEXTURES}/{t.file_name}": t.png for t in look.textures}
    return Files.of(entries)


def layer_text(asset: Asset, textures: str = f"./{TEXTURES}") -> str:
    """Return the root layer as usda text: the same asset gives the same text, whatever was written before.

    Args:
        asset: the asset.
        textures: path from the layer to the folder of the pictures.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    root = UsdGeom.Xform.Define(stage, Sdf.Path.absoluteRootPath.AppendChild(asset.id)).GetPrim()
    path = root.GetPath()
    set_stage(stage, root)
    _set_model(root, asset)
    _set_provenance(layer, asset)
    label.attach_all(root, asset)
    materials = material.define_all(stage, path, asset, textures)
    for link in asset.links:
        body.define(stage, path.AppendChild(link.name), asset, link, materials)
    joint.define_all(stage, path, asset)
    site.define_all(stage, path, asset)
    contact.filter_all(stage, path, asset)
    label.define_behavior(stage, root, asset)
    keyframe.define_all(stage, root, asset)
    text: str = layer.ExportToString()
    return text


def set_stage(stage: Usd.Stage, root: Usd.Prim) -> None:
    """Set z up, metres, kilograms, and `root` as the default prim."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(root)


def _set_model(root: Usd.Prim, asset: Asset) -> None:
    """Kind and assetInfo."""
    model = Usd.ModelAPI(root)
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(asset.id)
    model.SetAssetIdentifier(Sdf.AssetPath(f"./{asset.id}.usda"))
    model.SetAssetVersion(WRITER_VERSION)


def _set_provenance(layer: Sdf.Layer, asset: Asset) -> None:
    """The fields that SimReady asks for, with the asset's own values.

    Ref: SimReady Foundation requirement SR.004.
    """
    lower, upper = asset.bounds
    provenance = asset.provenance
    layer.customLayerData = {
        "SimReady_Metadata": {
            "asset_name": asset.id,
            "asset_type": "prop",
            "category": asset.labels.category,
            "author": provenance.author or UNKNOWN,
            "asset_license": provenance.licence or UNKNOWN,
            "source_file": provenance.path,
            "usd_date_generated": WRITER_DATE,
            "qcode": asset.labels.qcode.id,
            "rigid_body_count": len(asset.links),
            "asset_extents": Gf.Vec3f(*(float(n) for n in upper - lower)),
            "mass": asset.mass,
        }
    }
