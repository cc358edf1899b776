"""Checks of other people's meshes: what makes one unfit for simulation or training."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.filters import colour, cost, graspable, kind, stability, surface
from casa_assets.checks.package.package import Package
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("FLT001", "See-through surface", WARNING, Asset, surface.surface_is_opaque, "see_through", "",
          "At most {limit:.0%} of what is seen from all around shows back faces, which viewers leave out; close the "
          "holes, or thicken the walls."),
    Check("FLT002", "Missing side", ERROR, Package, surface.no_side_is_missing, "missing_side", "",
          "From no direction does more than {limit:.0%} of the outline of a solid thing show back faces; close that "
          "side."),
    Check("FLT003", "Mixed winding", ERROR, Asset, surface.winding_is_consistent, "mixed_winding", "",
          "Neighbouring faces wind against each other along at most {limit:.0%} of the length of shared edges; make "
          "the winding consistent."),
    Check("FLT004", "Flat cards", ERROR, Asset, surface.no_flat_cards, "flat_cards", "",
          "At most {limit:.0%} of what is seen is flat sheets that are seen from both sides, like a billboard; model "
          "the thing in the round."),
    Check("FLT005", "Separate parts", ERROR, Asset, surface.mesh_is_connected, "parts_apart", "",
          "The mesh has at most {limit:g} large connected part, since a rigid body is one thing; split the file by "
          "object, or join the parts."),
    Check("FLT006", "Ground plane", ERROR, Package, surface.no_ground_plane, "ground_width", "",
          "The lowest layer is at most {limit:g} times wider than all above it, unless that is usual for the "
          "category; export the mesh without the ground it stands on."),
    Check("FLT007", "Known category", WARNING, Package, kind.category_is_known, None, "",
          "The category is known, so that its usual size, pose and mass can be used; state it with --category."),
    Check("FLT008", "Usual proportions", WARNING, Package, kind.proportions_fit_category, "odd_shape", "",
          "At its best scale, every side is within a factor {limit:g} of the range of the category; correct the "
          "category if it is another thing."),
    Check("FLT009", "Open vessel", WARNING, Package, kind.vessel_is_open, "vessel_room", "",
          "As it stands, a vessel holds water in at least {limit:.0%} of its convex hull; correct its pose, or open "
          "the lid."),
    Check("FLT010", "Too dark", ERROR, Asset, colour.is_not_too_dark, "dark", "",
          "The mean luminance of what is seen is at least {limit:g} in white light; set the colours of its materials."),
    Check("FLT011", "Plain grey", WARNING, Asset, colour.is_not_plain_grey, "plain", "",
          "Colours differ from one plain grey by at least {limit:g} of the displayed range; bring the materials or a "
          "picture along."),
    Check("FLT012", "Texture sharpness", WARNING, Asset, colour.textures_are_sharp, "picture_points", "",
          "Along the longest side, at least {limit:g} points of the picture can be told apart; bring a larger or "
          "sharper picture."),
    Check("FLT013", "Load time", WARNING, Asset, cost.load_time_is_bounded, "load_ms", "ms",
          "Loading takes at most {limit:g} ms, estimated from triangles and pixels; simplify the mesh, or scale its "
          "pictures down."),
    Check("FLT014", "Plausible inertia", ERROR, Asset, cost.inertia_is_plausible, "inertia_factor", "",
          "Moments of inertia are within a factor {limit:g} of those of the collision shapes filled evenly; measure "
          "the inertia again."),
    Check("FLT015", "Lies still", ERROR, Package, stability.lies_still, "wander_m", "m",
          "Put down and left alone, no corner moves by more than {mm:g} mm within 3 s once the thing has settled; "
          "correct its collision shapes."),
    Check("FLT016", "Does not fall over", ERROR, Package, stability.does_not_fall_over, "stand_tip_deg", "deg",
          "Put down as it stands, a thing that stands tilts by at most {limit:g} degrees; correct its pose, or its "
          "foot."),
    Check("FLT017", "Stacks on another", WARNING, Package, stability.stacks_on_another, "stack_off", "",
          "A second one let down on a stackable thing stays within {limit:g} widths of its middle; correct the pose, "
          "the foot or the rim."),
    Check("FLT018", "Fits a gripper", WARNING, Package, graspable.fits_a_gripper, "gripper_m", "m",
          "A thing that is said to be graspable has a body, rim or handle at most {limit:g} m wide; correct its size, "
          "or do not call it graspable."),
)
# fmt: on
