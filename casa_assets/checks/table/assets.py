"""Checks of the asset record: its shapes and mass, and what is seen of it."""

from __future__ import annotations

from casa_assets.checks.asset import (
    coincident_faces,
    collider_coverage,
    grip,
    open_room,
    plausibility,
    texture_scale,
    visual,
)
from casa_assets.checks.check import Check
from casa_assets.checks.package.package import Package
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("AST001", "Overall size", ERROR, Asset, plausibility.size_is_bounded, "max_extent_m", "m",
          "The longest side of all that is seen is at most {limit:g} m; if it is longer, correct the unit of length "
          "of the source."),
    Check("AST002", "Collider thickness", ERROR, Asset, plausibility.colliders_are_thick_enough, "min_extent_m", "m",
          "The collision shapes of each link are at least {mm:g} mm thick, so that nothing passes through in one "
          "step; thicken the sheet or correct the scale."),
    Check("AST003", "Density, upper bound", ERROR, Asset, plausibility.density_is_not_too_high, "density_high", "",
          "Mass over the volume of a link's collision shapes is at most {limit:g} times the density of water; correct "
          "the "
          "mass, or fill gaps between the shapes."),
    Check("AST004", "Density, lower bound", WARNING, Asset, plausibility.density_is_not_too_low, "density_low", "",
          "Mass over the volume of a link's collision shapes is at least {limit:g} times the density of water; "
          "correct the "
          "mass, unless the thing really is hollow."),
    Check("AST005", "Number of colliders", ERROR, Asset, plausibility.collider_count_is_bounded, "hull_count", "",
          "No link has more than {limit:g} collision shapes, because contact cost grows with their number; merge some "
          "of them."),
    Check("AST006", "Hull size", ERROR, Asset, plausibility.hull_vertex_count_is_bounded, "hull_vertices", "",
          "No convex hull has more than {limit:g} vertices, which is what GPU collision pipelines accept; rebuild the "
          "hull with fewer vertices."),
    Check("AST007", "Hull convexity", ERROR, Asset, plausibility.hulls_are_convex, "rounding_m", "m",
          "Every collision hull is closed and no vertex lies more than {limit:g} m outside one of its faces; replace "
          "it by the convex hull of its vertices."),
    Check("AST008", "Mass inside colliders", ERROR, Asset, plausibility.mass_lies_inside_colliders, "rounding_m", "m",
          "The centre of mass lies in the bounding box of a link's collision shapes, and the inertia is that of a mass "
          "which fits into this box, to {limit:g} m; measure mass and inertia again."),
    Check("AST009", "Collider bounds", ERROR, Asset, plausibility.colliders_match_visual_bounds,
          "collider_bounds_m", "m",
          "Per link, the boxes around what is seen and what collides differ by at most {mm:g} mm, or 2 % of its "
          "longest side where that is more; fit the collision shapes again.",
          ("collider_bounds_ratio", "collider_bounds_built_m")),
    Check("AST010", "Origin at the base", ERROR, Asset, plausibility.origin_is_at_base_center, "origin_m", "m",
          "The origin of a free asset is within {mm:g} mm of the middle of its footprint, on the ground; move the "
          "origin there."),
    Check("AST011", "Licence stated", WARNING, Asset, plausibility.licence_is_stated, None, "",
          "The source states the licence under which the mesh may be used; ask its author before you pass the asset "
          "on."),
    Check("AST012", "Collider on each link", ERROR, Asset, plausibility.visible_links_have_colliders, None, "",
          "Every link that is seen has at least one collision shape; give one to each link that has none."),
    Check("AST013", "Mass of the category", ERROR, Package, plausibility.mass_fits_category, "mass_range_slack", "",
          "The mass is within a factor {limit:g} of the range that is usual for the category; correct the mass or the "
          "category."),
    Check("AST014", "Size of the category", WARNING, Package, plausibility.size_fits_category, "size_slack", "",
          "The longest side is within a factor {limit:g} of the range that is usual for the category; correct the "
          "scale or the category."),
    Check("AST015", "Closed at zero", ERROR, Asset, plausibility.joints_are_closed_at_zero, None, "",
          "The range of every joint contains zero; of a joint with named states (closed, open) zero is an end of the "
          "range; shift the range so that zero is closed."),
    Check("AST016", "Collider coverage", ERROR, Asset, collider_coverage.visible_surface_is_covered,
          "collider_bare", "",
          "At most {limit:.0%} of a link's visible surface lies away from every collision shape; add shapes, or close "
          "the holes of the mesh."),
    Check("AST017", "Inertia of the shapes", ERROR, Asset, grip.inertia_matches_colliders, "gyration_share", "",
          "The radius of gyration of a link is at most {limit:g} of half the diagonal of its shapes, and at least 15 "
          "% of that, with the centre of mass inside them; compute the inertia from the shapes."),
    Check("AST018", "Open rooms", WARNING, Asset, open_room.open_rooms_stay_open, "room_closed", "",
          "Collision shapes fill or close off at most {limit:.0%} of each open room of a mesh, such as the inside of a "
          "vessel or a compartment; fit the shapes again, or decide in review.csv, where ingest puts such assets."),
    Check("VIS001", "Degenerate triangles", ERROR, Asset, visual.triangles_have_area, None, "",
          "No visible triangle has zero area, since it has no normal; remove such triangles."),
    Check("VIS002", "Normals face outwards", ERROR, Asset, visual.normals_face_outwards, "flipped_normals", "",
          "At most {limit:.0%} of a mesh's area has normals that point against its front, and all normals have length "
          "one; recompute the normals from the triangles."),
    Check("VIS003", "Inside-out parts", ERROR, Asset, visual.closed_parts_wind_outwards, "inverted_area", "",
          "At most {limit:.0%} of a link's surface lies on closed parts that wind inwards; flip the winding of those "
          "triangles."),
    Check("VIS004", "Triangle count", WARNING, Asset, visual.triangle_count_is_bounded, "visual_faces", "",
          "The asset shows at most {limit:g} triangles, so that scenes of hundreds of assets load; simplify it "
          "further."),
    Check("VIS005", "Texture coordinates", ERROR, Asset, visual.textured_meshes_are_unwrapped, None, "",
          "Every mesh with a picture has texture coordinates that are finite and not all one point; unwrap it, or "
          "drop the picture."),
    Check("VIS006", "Texture size", ERROR, Asset, visual.texture_size_is_bounded, "texture_px", "px",
          "Every picture is at most {limit:g} pixels along its longer side, and as large as the record says; scale it "
          "down."),
    Check("VIS007", "Vertices per mesh", ERROR, Asset, visual.meshes_have_enough_vertices, None, "",
          "Every visible mesh has at least 4 vertices, below which MuJoCo refuses to compile; join it to another "
          "mesh."),
    Check("VIS008", "Duplicate meshes", ERROR, Asset, visual.meshes_are_unique, None, "",
          "No visible mesh lies exactly on another one, which would flicker; leave one of the two out."),
    Check("VIS009", "Texture scale", ERROR, Asset, texture_scale.texture_scale_is_true, "uv_stretch", "",
          "Pictures that repeat are shown at true size, to {limit:.0%} over 99 % of a mesh's area; texture "
          "coordinates are metres divided by the size of the picture."),
    Check("VIS010", "Coplanar faces", ERROR, Asset, coincident_faces.coplanar_faces_do_not_overlap, "flicker_m2", "m^2",
          "Two meshes of different looks share at most {mm2:g} mm^2 of coplanar surface, which would flicker; set one "
          "of them back by 0.2 mm."),
)
# fmt: on
