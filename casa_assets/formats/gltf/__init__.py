"""Asset or Scene -> one binary glTF file (GLB) for viewing: visuals, and on request colliders and regions.

A GLB has no physics. The data that a viewer needs to move the parts are in the `extras` of its nodes; see `document`.
"""

from casa_assets.formats.gltf.document import EVERYTHING, SEEN_ALONE, Layers, asset_glb, scene_glb

__all__ = ["EVERYTHING", "SEEN_ALONE", "Layers", "asset_glb", "scene_glb"]
