"""Provenance -> stage, model and SimReady metadata."""

from __future__ import annotations

from pxr import Gf, Kind, Sdf, Usd, UsdGeom, UsdPhysics

from casa_assets.model.asset.asset import Asset

# The day on which this writer's output last changed, not the day of the run: a clock in the file would make two runs
# over the same asset differ. Move it whenever the bytes that the writer makes change.
WRITER_DATE = "2026-11-21"
WRITER_VERSION = "1"
UNKNOWN = "unknown"  # SimReady wants a word; an empty one would be refused


def set_stage(stage: Usd.Stage, root: Usd.Prim) -> None:
    """z up, metres, kilograms, `root` as the default prim."""
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    stage.SetDefaultPrim(root)


def set_model(root: Usd.Prim, asset: Asset) -> None:
    """Kind and assetInfo."""
    model = Usd.ModelAPI(root)
    model.SetKind(Kind.Tokens.component)
    model.SetAssetName(asset.id)
    model.SetAssetIdentifier(Sdf.AssetPath(f"./{asset.id}.usda"))
    model.SetAssetVersion(WRITER_VERSION)


def set_provenance(layer: Sdf.Layer, asset: Asset) -> None:
    """The fields that SimReady asks for, with the asset's own values.

    Ref: SimReady Foundation requirement SR.004.
    """
    lower, upper = asset.bounds
    origin = asset.provenance
    layer.customLayerData = {
        "SimReady_Metadata": {
            "asset_name": asset.id,
            "asset_type": "prop",
            "category": asset.labels.category,
            "author": origin.author or UNKNOWN,
            "asset_license": origin.licence or UNKNOWN,
            "source_file": origin.path,
            "usd_date_generated": WRITER_DATE,
            "qcode": asset.labels.qcode.id,
            "rigid_body_count": len(asset.links),
            "asset_extents": Gf.Vec3f(*(float(n) for n in upper - lower)),
            "mass": asset.mass,
        }
    }
