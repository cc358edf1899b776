"""Parts of the MJCF writer, for exports that write another kind of MJCF."""

from __future__ import annotations

from casa_assets.formats.mjcf import write as write_mjcf
from casa_assets.formats.mjcf.batch import DEFAULT as BATCH_DEFAULT
from casa_assets.formats.mjcf.batch import FIRST_MEETING as BATCH_FIRST_MEETING
from casa_assets.formats.mjcf.batch import LAST_MEETING as BATCH_LAST_MEETING
from casa_assets.formats.mjcf.batch import THINGS as BATCH_THINGS
from casa_assets.formats.mjcf.batch import write as write_batch
from casa_assets.formats.mjcf.document import BodyContext, add_body, add_labels
from casa_assets.formats.mjcf.kitchen import FILE as SCENE_FILE
from casa_assets.formats.mjcf.kitchen import add_lights_and_cameras, add_sky
from casa_assets.formats.mjcf.shapes import (
    OUTER_REGIONS,
    Meshes,
    MeshUse,
    add_material,
    add_mesh,
    add_region,
    add_size_sites,
    add_texture,
    gather_meshes,
    material_names,
    mesh_uses,
    texture_files,
)
from casa_assets.formats.values import ROBOSUITE_GROUPS, VIEWER_GROUPS, numbers

__all__ = [
    "add_body",
    "add_labels",
    "add_lights_and_cameras",
    "add_material",
    "add_mesh",
    "add_region",
    "add_size_sites",
    "add_sky",
    "add_texture",
    "BATCH_DEFAULT",
    "BATCH_FIRST_MEETING",
    "BATCH_LAST_MEETING",
    "BATCH_THINGS",
    "BodyContext",
    "gather_meshes",
    "material_names",
    "mesh_uses",
    "Meshes",
    "MeshUse",
    "numbers",
    "OUTER_REGIONS",
    "ROBOSUITE_GROUPS",
    "SCENE_FILE",
    "texture_files",
    "VIEWER_GROUPS",
    "write_batch",
    "write_mjcf",
]
