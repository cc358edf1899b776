"""All checks: rows of assets and scenes, with those of objects.py and library.py; `./dev docs` prints them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from casa_assets.checks import filters, library, objects
from casa_assets.checks.asset import plausibility, visual
from casa_assets.checks.check import NO_WAIVERS, Check, Package, report_not_run, run
from casa_assets.checks.design import grade, rules, subject
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.motion import joints
from casa_assets.checks.package import mjcf, usd
from casa_assets.checks.robots import joints_are_reached
from casa_assets.checks.runtime import behavior, contract
from casa_assets.checks.scene import engine_sizes, formats, light_forms, opening, placement, rest
from casa_assets.checks.scene.formats import SceneFiles
from casa_assets.checks.scene.light_forms import BatchSubject
from casa_assets.checks.scene.placement import PreviewImages
from casa_assets.checks.scene.rest import MeasuredSpeed
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.start_states import stage
from casa_assets.checks.start_states.stage import StatesSubject
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report, Severity
from casa_assets.model.kitchen.robot import SceneRobots
from casa_assets.model.kitchen.scene import EngineSizes

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# How the drop is done. Ref: SimReady Foundation, FET003 base neutral simulation.
DROP = ("drop_height_factor", "drop_min_height_m", "drop_rest_m", "drop_rest_s", "drop_rate_hz", "drop_limit_s")

# fmt: off
ASSET_ROWS: tuple[Check, ...] = (
    # Asset.
    Check("AST001", "Overall size", ERROR, Asset, plausibility.size_is_bounded, "max_extent_m", "m",
          "The longest side of all that is seen is at most {limit:g} m; if it is longer, correct the unit of length of "
          "the source."),
    Check("AST002", "Collider thickness", ERROR, Asset, plausibility.colliders_are_thick_enough, "min_extent_m", "m",
          "The collision shapes of each link are at least {mm:g} mm thick, so that nothing passes through in one step; "
          "thicken the sheet or correct the scale."),
    Check("AST003", "Density, upper bound", ERROR, Asset, plausibility.density_is_not_too_high, "density_high", "",
          "Mass over the volume of a link's collision shapes is at most {limit:g} times the density of water; correct "
          "the mass, or fill gaps between the shapes."),
    Check("AST004", "Density, lower bound", WARNING, Asset, plausibility.density_is_not_too_low, "density_low", "",
          "Mass over the volume of a link's collision shapes is at least {limit:g} times the density of water; correct "
          "the mass, unless the thing really is hollow."),
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
    Check("AST009", "Collider bounds", ERROR, Asset, plausibility.colliders_match_visual_bounds, "collider_bounds_m",
          "m", "Per link, the boxes around what is seen and what collides differ by at most {mm:g} mm, or 2 % of its "
          "longest side where that is more; fit the collision shapes "
          "again.", ("collider_bounds_ratio", "collider_bounds_built_m")),
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
    Check("AST016", "Collider coverage", ERROR, Asset, plausibility.visible_surface_is_covered, "collider_bare", "",
          "At most {limit:.0%} of a link's visible surface lies away from every collision shape; add shapes, or close "
          "the holes of the mesh."),
    Check("AST017", "Inertia of the shapes", ERROR, Asset, plausibility.inertia_matches_colliders, "gyration_share", "",
          "The radius of gyration of a link is at most {limit:g} of half the diagonal of its shapes, and at least 15 % "
          "of that, with the centre of mass inside them; compute the inertia from the shapes."),
    Check("AST018", "Open rooms", WARNING, Asset, plausibility.open_rooms_stay_open, "room_closed", "",
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
          "Every mesh with a picture has texture coordinates that are finite and not all one point; unwrap it, or drop "
          "the picture."),
    Check("VIS006", "Texture size", ERROR, Asset, visual.texture_size_is_bounded, "texture_px", "px",
          "Every picture is at most {limit:g} pixels along its longer side, and as large as the record says; scale it "
          "down."),
    Check("VIS007", "Vertices per mesh", ERROR, Asset, visual.meshes_have_enough_vertices, None, "",
          "Every visible mesh has at least 4 vertices, below which MuJoCo refuses to compile; join it to another "
          "mesh."),
    Check("VIS008", "Duplicate meshes", ERROR, Asset, visual.meshes_are_unique, None, "",
          "No visible mesh lies exactly on another one, which would flicker; leave one of the two out."),
    Check("VIS009", "Texture scale", ERROR, Asset, visual.texture_scale_is_true, "uv_stretch", "",
          "Pictures that repeat are shown at true size, to {limit:.0%} over 99 % of a mesh's area; texture coordinates "
          "are metres divided by the size of the picture."),
    Check("VIS010", "Coplanar faces", ERROR, Asset, visual.coplanar_faces_do_not_overlap, "flicker_m2", "m^2",
          "Two meshes of different looks share at most {mm2:g} mm^2 of coplanar surface, which would flicker; set one "
          "of them back by 0.2 mm."),

    # Motion, behaviour and contracts.
    Check("KIN001", "Opens by hand", ERROR, Package, joints.joints_open_by_hand, "reach_share", "",
          "Each joint covers {limit:.0%} of its range in both directions within 2 s under 20 N at its grip, with "
          "contacts on; ease friction, or clear what the part meets."),
    Check("KIN002", "Joint resistance", ERROR, Package, joints.joints_open_by_hand_without_contacts, "reach_share", "",
          "Each joint covers {limit:.0%} of its range in both directions within 2 s under 20 N at its grip, with "
          "contacts off; lower its friction, damping or spring."),
    Check("KIN003", "Starting force", ERROR, Package, joints.starting_force_is_moderate, "hand_force_n", "N",
          "The force at the grip that starts each closed joint is between {hand_force_least_n:g} N and {limit:g} N "
          "(ADA 309.4); adjust its friction or spring.", ("hand_force_least_n",)),
    Check("KIN004", "Buttons spring back", ERROR, Package, joints.keys_spring_back, "spring_back_share", "",
          "A button with a spring that was pressed and let go is back to {limit:.0%} of its stroke within 2 s; stiffen "
          "the spring, or lower friction."),
    Check("KIN005", "Clearance of moving parts", ERROR, Package, joints.moving_parts_keep_clear, "clearance_m", "m",
          "No part goes deeper than {mm:g} mm into another over the whole range of a joint, alone and beside each "
          "other open joint; make room between them."),
    Check("KIN006", "Joints stay put", ERROR, Package, joints.joints_stay_put, "drift_share", "",
          "Left alone for 5 s, closed and in each named pose, no joint drifts by more than {limit:.0%} of its range; "
          "raise friction, or balance the part."),
    Check("KIN007", "Grips fit a gripper", ERROR, Asset, plausibility.grips_fit_a_gripper, "gripper_m", "m",
          "Each joint names a labelled grip that moves with it, is free to be reached, and is at most {limit:g} m "
          "thick; name, shrink or uncover the grip."),
    Check("KIN008", "Axis-aligned joints", ERROR, Asset, plausibility.joint_axes_are_aligned, "axis_off_rad", "rad",
          "Joint axes of built things lie along x, y or z to {limit:g} rad, as loaders that scale fixtures expect; "
          "turn the part straight."),
    Check("KIN009", "Travel of found joints", WARNING, Package, joints.joints_reach_full_range, "travel_share", "",
          "The share of joints of an articulated mesh that go through their whole range under 20 N without collision "
          "is at least {limit:.0%}; shorten the ranges, or clear what the parts meet."),
    Check("KIN010", "Joints rest in range", ERROR, Package, joints.joints_rest_in_range, "range_excess", "rad or m",
          "Left alone for 2 s, closed, no joint stands more than {limit:g} rad or m outside its range; stiffen its "
          "limit, or ease the spring that presses it there."),
    Check("KIN011", "Room for fingers", ERROR, Asset, plausibility.fingers_have_room, "finger_m", "m",
          "Fingers of {limit:g} m find room on both sides of each handle and knob of what a family built; let it stand "
          "out, or deepen the recess behind it."),
    Check("HOL001", "Usable interiors", ERROR, Package, behavior.interiors_hold_a_ball, "hollow_m", "m",
          "A ball of 6 cm (smaller in narrow regions) laid into each interior region comes to rest within {mm:g} mm of "
          "its floor and sides; clear the region, or correct its box."),
    Check("CON001", "Contract: links and joints", ERROR, Package, contract.links_and_joints_meet_contract, None, "",
          "The links and joints that RoboCasa looks up by name exist, with the kind, axis, sign, range and depth that "
          "it expects; rename or correct them."),
    Check("CON002", "Contract: sites", ERROR, Package, contract.sites_meet_contract, None, "",
          "The sites that RoboCasa looks up by name, such as a flame or a stream of water, exist on the links where it "
          "looks; add or move them."),
    Check("CON003", "Contract: colliders", ERROR, Package, contract.colliders_and_visuals_meet_contract, None, "",
          "The colliders and visuals that RoboCasa looks up by name exist with the labels it expects, and no other has "
          "a name that RoboCasa would take for one of them; rename them."),
    Check("CON004", "Contract: regions", ERROR, Package, contract.regions_meet_contract, "main_gap_m", "m",
          "The regions that RoboCasa looks up exist, `main` encloses what is seen to {mm:g} mm, and interiors lie "
          "within it; correct the boxes of the regions."),
    Check("CON005", "Contract: XML paths", ERROR, Package, contract.xml_paths_meet_contract, None, "",
          "Everything that RoboCasa finds by literal paths in model.xml is at those paths; move the elements to where "
          "it looks."),
    Check("CON006", "Contract: thresholds", ERROR, Package, contract.thresholds_meet_contract, None, "",
          "RoboCasa's thresholds lie within the ranges of their joints, and named poses stand as the contract says; "
          "widen the range, or correct the pose."),
    Check("CON008", "Contract: places", ERROR, Package, contract.places_meet_contract, None, "",
          "Regions and sites are where RoboCasa takes them to be by the numbers written in model.xml, and those in "
          "which it puts things are high enough, stay where they are and have a floor; move the frame or the box."),
    Check("BEH001", "Reachable values", ERROR, Asset, behavior.values_are_reachable, None, "",
          "Every value of every variable of the behaviour can be brought about by moving joints and touching "
          "colliders; add a rule, or drop the value."),
    Check("BEH002", "Visible effects", ERROR, Asset, behavior.effects_are_visible, None, "",
          "Every effect of the behaviour acts on a site, visual or region that can show it; correct its target, colour "
          "or size."),
    Check("BEH003", "Behaviour as specified", ERROR, Package, behavior.behavior_meets_contract, None, "",
          "Operated in MuJoCo step by step, the thing takes the values that its contract names at the contract's "
          "thresholds; correct the rule that differs."),

    # Files.
    Check("MJC001", "MJCF compiles", ERROR, Package, mjcf.mjcf_compiles, None, "",
          "MuJoCo compiles model.xml and scene.xml without an error; read the error and correct the element that it "
          "names."),
    Check("MJC002", "MJCF without warnings", ERROR, Package, mjcf.mjcf_compiles_without_warnings, None, "",
          "MuJoCo compiles model.xml and scene.xml without a warning; correct what the warning names."),
    Check("MJC003", "MJCF conventions", ERROR, Package, mjcf.mjcf_follows_conventions, None, "",
          "Names, groups, sizes and files in model.xml are as robosuite and RoboCasa read them; correct the elements "
          "that are listed."),
    Check("MJC004", "Massless visuals", ERROR, Package, mjcf.visuals_are_massless, None, "",
          "Visual geoms have zero mass and no contacts (contype and conaffinity 0); correct those that are listed."),
    Check("MJC005", "MJCF equals record", ERROR, Package, mjcf.mjcf_equals_record, "parity_length_m", "m",
          "Masses, poses, joints and bounds of the compiled MJCF equal the asset's record to {limit:g}; please report "
          "a difference, it is a fault of the program."),
    Check("MJC006", "Comes to rest", ERROR, Package, mjcf.comes_to_rest_after_drop, "drop_limit_s", "s",
          "Dropped on a floor from twice its height, the asset is at rest within {limit:g} s and does not fall "
          "through; correct its collision shapes or inertia.", DROP),
    Check("MJC007", "Stands upright", WARNING, Package, mjcf.stays_upright_after_drop, "drop_tip_deg", "deg",
          "After the drop the asset is tilted by at most {limit:g} degrees; correct its orientation, or its "
          "foot.", DROP),
    Check("MJC008", "Rests on the floor", ERROR, Package, mjcf.rests_on_floor_after_drop, "drop_penetration_m", "m",
          "At rest after the drop, the asset is at most {mm:g} mm deep in the floor; correct its collision shapes or "
          "mass.", DROP),
    Check("MJC009", "Joints move freely", ERROR, Package, mjcf.joints_move_without_collision, "sweep_penetration_m",
          "m", "Over the range of each joint in the written file, parts go at most {mm:g} mm into each other; shorten "
          "the range, or make room."),
    Check("USD001", "USD opens", ERROR, Package, usd.usd_opens, None, "",
          "The USD layers, flat and nested, open and compose without complaint and have a default prim; correct what "
          "USD names."),
    Check("USD002", "SimReady profile", ERROR, Package, usd.usd_meets_simready_profile, None, "",
          "The USD package meets NVIDIA's SimReady profile Robotics-Prop 4.0.0; correct the requirements that are "
          "listed."),
    Check("USD003", "OpenUSD validators", ERROR, Package, usd.usd_passes_openusd_validators, None, "",
          "OpenUSD's own validators find nothing in the USD package; correct the prims that they name."),
    Check("USD004", "USD in MuJoCo", ERROR, Package, usd.usd_imports_into_mujoco, None, "",
          "MuJoCo imports the USD files without an error or a warning; a warning means that MuJoCo left something "
          "out."),
    Check("USD005", "USD pictures", ERROR, Package, usd.usd_pictures_are_png, None, "",
          "Every picture that the USD names is a readable PNG in the package, and the thumbnail has 256 x 256 pixels; "
          "add or convert the picture."),
    Check("PAR001", "MJCF equals USD in MuJoCo", ERROR, Package, usd.mujoco_reads_both_alike, "parity_relative", "",
          "Bodies, masses, joints and looks that MuJoCo reads from the USD equal those from the MJCF to {limit:g}, "
          "except lengths (PAR004); please report a difference, it is a fault of the program."),
    Check("PAR002", "MJCF equals USD in OpenUSD", ERROR, Package, usd.openusd_reads_as_mujoco, "parity_relative", "",
          "Bodies, masses, joints and looks that UsdPhysics reads equal those that MuJoCo reads from the MJCF to "
          "{limit:g}, except lengths (PAR004); please report a difference, it is a fault of the program."),
    Check("PAR003", "Contact parameters", ERROR, Package, usd.contact_parameters_agree, "parity_relative", "",
          "Contact and joint parameters that MuJoCo reads from MJCF and USD agree to {limit:g}; please report a "
          "difference, it is a fault of the program."),
    Check("PAR004", "Lengths in both formats", ERROR, Package, usd.lengths_agree, "parity_length_m", "m",
          "Positions, sizes and joint travel in MJCF and USD agree to {limit:g} m for both readers; please report a "
          "difference, it is a fault of the program."),

    # Filters of downloaded meshes.
    Check("FLT001", "See-through surface", WARNING, Asset, filters.surface_is_opaque, "see_through", "",
          "At most {limit:.0%} of what is seen from all around shows back faces, which viewers leave out; close the "
          "holes, or thicken the walls."),
    Check("FLT002", "Missing side", ERROR, Package, filters.no_side_is_missing, "missing_side", "",
          "From no direction does more than {limit:.0%} of the outline of a solid thing show back faces; close that "
          "side."),
    Check("FLT003", "Mixed winding", ERROR, Asset, filters.winding_is_consistent, "mixed_winding", "",
          "Neighbouring faces wind against each other along at most {limit:.0%} of the length of shared edges; make "
          "the winding consistent."),
    Check("FLT004", "Flat cards", ERROR, Asset, filters.no_flat_cards, "flat_cards", "",
          "At most {limit:.0%} of what is seen is flat sheets that are seen from both sides, like a billboard; model "
          "the thing in the round."),
    Check("FLT005", "Separate parts", ERROR, Asset, filters.mesh_is_connected, "parts_apart", "",
          "The mesh has at most {limit:g} large connected part, since a rigid body is one thing; split the file by "
          "object, or join the parts."),
    Check("FLT006", "Ground plane", ERROR, Package, filters.no_ground_plane, "ground_width", "",
          "The lowest layer is at most {limit:g} times wider than all above it, unless that is usual for the category; "
          "export the mesh without the ground it stands on."),
    Check("FLT007", "Known category", WARNING, Package, filters.category_is_known, None, "",
          "The category is known, so that its usual size, pose and mass can be used; state it with --category."),
    Check("FLT008", "Usual proportions", WARNING, Package, filters.proportions_fit_category, "odd_shape", "",
          "At its best scale, every side is within a factor {limit:g} of the range of the category; correct the "
          "category if it is another thing."),
    Check("FLT009", "Open vessel", WARNING, Package, filters.vessel_is_open, "vessel_room", "",
          "As it stands, a vessel holds water in at least {limit:.0%} of its convex hull; correct its pose, or open "
          "the lid."),
    Check("FLT010", "Too dark", ERROR, Asset, filters.is_not_too_dark, "dark", "",
          "The mean luminance of what is seen is at least {limit:g} in white light; set the colours of its materials."),
    Check("FLT011", "Plain grey", WARNING, Asset, filters.is_not_plain_grey, "plain", "",
          "Colours differ from one plain grey by at least {limit:g} of the displayed range; bring the materials or a "
          "picture along."),
    Check("FLT012", "Texture sharpness", WARNING, Asset, filters.textures_are_sharp, "picture_points", "",
          "Along the longest side, at least {limit:g} points of the picture can be told apart; bring a larger or "
          "sharper picture."),
    Check("FLT013", "Load time", WARNING, Asset, filters.load_time_is_bounded, "load_ms", "ms",
          "Loading takes at most {limit:g} ms, estimated from triangles and pixels; simplify the mesh, or scale its "
          "pictures down."),
    Check("FLT014", "Plausible inertia", ERROR, Asset, filters.inertia_is_plausible, "inertia_factor", "",
          "Moments of inertia are within a factor {limit:g} of those of the collision shapes filled evenly; measure "
          "the inertia again."),
    Check("FLT015", "Lies still", ERROR, Package, filters.lies_still, "wander_m", "m",
          "Put down and left alone, no corner moves by more than {mm:g} mm within 3 s once the thing has settled; "
          "correct its collision shapes."),
    Check("FLT016", "Does not fall over", ERROR, Package, filters.does_not_fall_over, "stand_tip_deg", "deg",
          "Put down as it stands, a thing that stands tilts by at most {limit:g} degrees; correct its pose, or its "
          "foot."),
    Check("FLT017", "Stacks on another", WARNING, Package, filters.stacks_on_another, "stack_off", "",
          "A second one let down on a stackable thing stays within {limit:g} widths of its middle; correct the pose, "
          "the foot or the rim."),
    Check("FLT018", "Fits a gripper", WARNING, Package, filters.fits_a_gripper, "gripper_m", "m",
          "A thing that is said to be graspable has a body, rim or handle at most {limit:g} m wide; correct its size, "
          "or do not call it graspable."),
)
# fmt: on


# fmt: off
SCENE_ROWS: tuple[Check, ...] = (
    # Scenes: MJCF, USD and light form, cameras, budgets and speed.
    Check("SCN001", "Scene loads", ERROR, SceneSubject, rest.scene_loads_without_warnings, None, "",
          "MuJoCo reads scene.xml and simulates 5 s of it without an error or a warning; correct what it names."),
    Check("SCN002", "No contact at the start", ERROR, SceneSubject, rest.no_penetration_at_start, "scene_start_m", "m",
          "In the start pose, no two things overlap by more than {mm:g} mm; move one of them, or shrink its shape."),
    Check("SCN003", "Settles apart", ERROR, SceneSubject, rest.no_penetration_after_settling, "scene_settled_m", "m",
          "After 1 s no two things overlap by more than {mm:g} mm; look for the weight or spring that presses them "
          "together."),
    Check("SCN004", "Joints stay put", ERROR, SceneSubject, rest.joints_stay_put, "drift_share", "",
          "Left alone for 5 s, no joint drifts by more than {limit:.0%} of its range; look for what touches it, and at "
          "its friction and spring."),
    Check("SCN005", "Doors and drawers open", ERROR, SceneSubject, opening.joints_open_without_collision,
          "scene_clash_m", "m", "Moved through its range, alone and beside each open neighbour, with what lies in it, "
          "no part of the kitchen runs more than {mm:g} mm into anything, with the lids of objects closed; make room, "
          "or change the swing."),
    Check("SCN006", "Opens by hand in place", ERROR, SceneSubject, opening.joints_open_by_hand, "reach_share", "",
          "Each joint but those of objects (`scenes new --objects`) covers {limit:.0%} of its range within 2 s under "
          "20 N at its grip, in the whole scene; clear what it meets, or ease its friction."),
    Check("SCN007", "Fixed things overlap", ERROR, SceneSubject, placement.fixed_things_do_not_overlap,
          "scene_overlap_m", "m", "No two fixed things overlap by more than {mm:g} mm; move one of them, or make it "
          "smaller."),
    Check("SCN008", "Floating things", ERROR, SceneSubject, placement.fixed_things_are_supported, "scene_floating", "",
          "Every fixed thing rests on the floor, a wall, the ceiling, or a thing that these hold (at most {limit:g} do "
          "not); set it on what carries it."),
    Check("SCN009", "Inside the room", ERROR, SceneSubject, placement.things_are_inside_room, "scene_outside_m", "m",
          "Nothing reaches more than {mm:g} mm beyond floor, walls and ceiling; move it in."),
    Check("SCN010", "Number of bodies", ERROR, SceneSubject, rest.body_count_is_bounded, "scene_bodies", "",
          "The model has at most {limit:g} bodies; merge links that never move against each other."),
    Check("SCN011", "Loose things stay put", ERROR, SceneSubject, rest.loose_things_stay_put, "scene_drift_m", "m",
          "Nothing that stands by its weight moves by more than {mm:g} mm in 5 s; set it down where it stands firmly."),
    Check("SCN012", "Number of colliders", ERROR, SceneSubject, rest.collider_count_is_bounded, "scene_shapes", "",
          "The model has at most {limit:g} collision shapes; merge some, or leave a thing out."),
    Check("SCN013", "Degrees of freedom", ERROR, SceneSubject, rest.degrees_of_freedom_are_bounded, "scene_freedoms",
          "", "The kitchen has at most {limit:g} degrees of freedom, those of objects (`scenes new --objects`) not "
          "counted, because solver time grows with their number; fix what nobody has to move."),
    Check("SCN014", "Hull vertices", ERROR, SceneSubject, rest.hull_vertex_count_is_bounded, "scene_vertices", "",
          "The collision hulls have at most {limit:g} vertices in all, counted per instance; use boxes and cylinders."),
    Check("SCN015", "Texture memory", ERROR, SceneSubject, rest.texture_memory_is_bounded, "scene_pictures_mb", "MB",
          "All pictures take at most {limit:g} MB decoded, so that one GPU holds many scenes; share pictures, or scale "
          "them down."),
    Check("SCN016", "Contacts at rest", ERROR, SceneSubject, rest.contact_count_is_bounded, "scene_contacts", "",
          "At most {limit:g} pairs of shapes touch while nothing moves, because each costs time in every step; set "
          "things down on fewer feet."),
    Check("SCN017", "MJCF equals USD", ERROR, SceneFiles, formats.formats_agree, "scene_disagreements", "",
          "Bodies, poses, joints, masses, shapes and labels are the same in scene.xml, scene.usda and "
          "scene_nested.usda (at most {limit:g} differ); please report a difference, it is a fault of the program."),
    Check("SCN018", "USD scene loads", ERROR, SceneFiles, formats.usd_scene_loads_without_warnings, None, "",
          "scene.usda and scene_nested.usda compose without complaint, have a default prim, and MuJoCo imports them "
          "without a warning; correct what the reader names."),
    Check("SCN019", "OpenUSD validators", ERROR, SceneFiles, formats.usd_scene_passes_openusd_validators, None, "",
          "OpenUSD's own validators find nothing in scene.usda and scene_nested.usda; correct the prims that they "
          "name."),
    Check("SCN020", "SimReady rules", ERROR, SceneFiles, formats.usd_scene_meets_simready_rules, None, "",
          "scene.usda meets SimReady Robotics-Prop 4.0.0, but for rules on the package of a single prop; correct the "
          "requirements that are listed."),
    Check("SCN021", "Light form: same mechanism", ERROR, SceneFiles, light_forms.mechanism_is_the_same, None, "",
          "scene_light.xml loads without warnings, has no meshes or pictures, and has the joints, masses and poses of "
          "the full form; build it again from the same scene."),
    Check("SCN022", "Light form: settles apart", ERROR, SceneFiles, light_forms.light_form_settles_apart,
          "scene_settled_m", "m", "In the light form no two things overlap by more than {mm:g} mm, at the start and "
          "after 1 s; correct the primitive shapes."),
    Check("SCN023", "Cameras see all walls", ERROR, SceneSubject, placement.cameras_see_every_wall, "scene_wall_seen",
          "", "Each wall fills at least {limit:.0%} of the picture of some camera; turn a camera to the wall, or add "
          "one."),
    Check("SCN024", "No black pictures", ERROR, PreviewImages, placement.previews_are_not_black, "scene_black", "",
          "At most {limit:.0%} of each preview is black; add a light there, or move the camera out of what it stands "
          "in."),
    Check("SCN025", "No burnt-out pictures", ERROR, PreviewImages, placement.previews_are_not_burnt_out, "scene_white",
          "", "At most {limit:.0%} of each preview is pure white; lower the light, or choose a darker finish."),
    Check("SCN026", "Load time", WARNING, MeasuredSpeed, rest.load_time_is_bounded, "scene_load_ms", "ms",
          "MuJoCo compiles the scene within {limit:g} ms on the machine of the check; use fewer vertices and smaller "
          "pictures."),
    Check("SCN027", "Simulation speed", WARNING, MeasuredSpeed, rest.simulation_is_fast_enough, "scene_pace", "",
          "At rest, one core simulates at least {limit:g} s of the scene per second; use fewer contacts and joints."),
    Check("SCN028", "Light form: things stay put", ERROR, SceneFiles, light_forms.light_things_stay_put,
          "scene_drift_m", "m", "In the light form nothing that stands by its weight moves by more than {mm:g} mm in 5 "
          "s; correct the footprint of its primitive shapes."),

    # Kitchens as a designer, a mobile robot and a list of tasks see them.
    Check("NKB001", "Doorway width", ERROR, DesignSubject, rules.doorways_are_wide_enough, "doorway_m", "m",
          "Doors and passages leave at least {limit:g} m clear with the leaf open (NKBA 1); make the opening wider."),
    Check("NKB002", "Entry door swing", ERROR, DesignSubject, rules.entry_doors_swing_freely, "swing_m", "m",
          "The leaf of an entry door overlaps no appliance and no appliance door by more than {mm:g} mm seen from "
          "above (NKBA 2); turn the swing, or move the appliance."),
    Check("NKB003", "Appliance doors apart", ERROR, DesignSubject, rules.appliance_doors_swing_apart, "swing_m", "m",
          "The areas that the doors of two appliances sweep overlap by at most {mm:g} mm seen from above (NKBA 2); "
          "move one of the appliances."),
    Check("NKB004", "Work aisle", ERROR, DesignSubject, rules.work_aisles_are_wide_enough, "work_aisle_m", "m",
          "Fronts that face each other are at least {limit:g} m apart, unless the plan says `compact: true` (NKBA 6); "
          "move the rows apart."),
    Check("NKB005", "Work aisle, compact", ERROR, DesignSubject, rules.compact_work_aisles_are_wide_enough,
          "compact_aisle_m", "m", "In a plan that says `compact: true`, fronts that face each other are at least "
          "{limit:g} m apart; move the rows apart."),
    Check("NKB006", "Walkway width", ERROR, DesignSubject, rules.walkways_are_wide_enough, "walkway_m", "m",
          "Ways between things, and along walls, are at least {limit:g} m wide (NKBA 7); move or narrow what stands "
          "beside them."),
    Check("NKB007", "Room at the dishwasher", ERROR, DesignSubject, rules.dishwashers_have_standing_room,
          "dishwasher_m", "m", "A dishwasher is at least {limit:g} m from what stands at a right angle to it (NKBA "
          "13); move it along its row."),
    Check("NKB008", "Hood height", ERROR, DesignSubject, rules.hoods_clear_cooktops, "hood_m", "m",
          "A hood hangs at least {limit:g} m over the cooktop (NKBA 18); hang it higher."),
    Check("NKB009", "Clearance over cooktops", ERROR, DesignSubject, rules.cabinets_clear_cooktops, "over_cooktop_m",
          "m", "Cabinets and shelves hang at least {limit:g} m over a cooktop that has no hood (NKBA 18); remove or "
          "raise them, or add a hood."),
    Check("NKB010", "No window over cooktops", ERROR, DesignSubject, rules.no_openable_window_over_cooktops, "window_m",
          "m", "No window that opens is over a cooktop (at most {limit:g} m of it, NKBA 20); move the cooktop, or fix "
          "the sash."),
    Check("NKB011", "Distance from corners", ERROR, DesignSubject, rules.appliances_keep_off_corners, "corner_m", "m",
          "Appliances are at least {limit:g} m from an inside corner of the worktops (LSU AgCenter); move them along "
          "the row."),
    Check("NKB012", "Design score", WARNING, DesignSubject, grade.design_score_is_high_enough, "design_score", "",
          "At least {limit:g} of 100 advisory design rules that apply are followed (NKBA, LSU, trade sizes); see the "
          "section Design for those that are not."),
    Check("NAV001", "Reachable fixtures", ERROR, DesignSubject, subject.fixtures_are_reachable, "unreached", "",
          "A base of 0.30 m radius reaches every fixture from an entry (at most {limit:g} are not reached); leave free "
          "floor before them, and a way to it."),
    Check("NAV002", "Reachable when open", ERROR, DesignSubject, subject.opened_fixtures_are_reachable, "unreached", "",
          "A base of 0.30 m radius has a place to stand at every fixture with its door or drawer open (at most "
          "{limit:g} without); leave free floor beside the open part."),
    Check("NAV003", "Entries lead in", ERROR, DesignSubject, subject.entries_lead_in, "unreached", "",
          "A base of 0.30 m radius can enter the kitchen through every door and passage (at most {limit:g} are "
          "blocked); clear what stands before them."),
    Check("TSK001", "Tasks supported", ERROR, DesignSubject, subject.tasks_are_supported, "tasks_lacking", "",
          "In a plan that says `all_tasks: true`, each of the 25 atomic tasks of RoboCasa v0.2 has its fixtures, "
          "joints and sites within reach (at most {limit:g} lack one); add what the task lacks."),
    Check("TSK002", "Room for task objects", ERROR, DesignSubject, subject.task_objects_find_room, "task_rate", "",
          "At least {limit:.0%} of 200 drawn objects find a free place within reach, for each task; clear the surface, "
          "or make it larger."),
    Check("ROB001", "Joints a robot reaches", ERROR, SceneRobots, joints_are_reached, "robot_reach", "",
          "At least {limit:.0%} of the joints with a handle, knob, button or lever are reached by PandaOmron from the "
          "parking place, free of contact; free the grip, or the floor before it."),
    Check("STA001", "Start states fit", ERROR, StatesSubject, stage.states_fit_their_scene, None, "",
          "The start states have the joints of scene.xml in its order, and were made for exactly this file; draw them "
          "again with scenes states."),
    Check("STA002", "Start states apart", ERROR, StatesSubject, stage.states_have_no_deep_contact, "state_contact_m",
          "m", "Simulated again for 2 s, no two shapes of a start state are more than {mm:g} mm in each other; draw it "
          "again."),
    Check("STA003", "Start states at rest", ERROR, StatesSubject, stage.states_stay_put, "state_motion_m", "m",
          "Simulated again for 2 s, no corner of any shape of a start state moves by more than {mm:g} mm; draw it "
          "again."),
    Check("STA004", "Robot parked in room", ERROR, StatesSubject, stage.states_leave_room_for_the_robot,
          "states_blocked", "", "In every start state the boxes around a robot in its home pose are empty (at most "
          "{limit:g} states are not so); draw them again."),
    Check("STA005", "Start states differ", ERROR, StatesSubject, stage.states_differ, "state_difference", "",
          "In any two start states a joint, a thing or the base differs by {limit:g} m or rad at least; draw one of "
          "them again."),

    # Batch forms.
    Check("BAT001", "Batch form loads", ERROR, BatchSubject, light_forms.batch_form_loads, None, "",
          "scene_batch.xml loads without warnings, is made of boxes, spheres, cylinders and capsules, its pictures are "
          "small, and its joints are those of the light form; build it again from the same scene."),
    Check("BAT002", "Batch form: colliders", ERROR, BatchSubject, light_forms.collider_count_is_bounded, "batch_shapes",
          "", "At most {limit:g} primitives of the batch form touch anything; lock more joints with --joints, or leave "
          "things out of the plan."),
    Check("BAT003", "Batch form: candidate pairs", ERROR, BatchSubject, light_forms.pair_count_is_bounded,
          "batch_pairs", "", "An engine has to look at no more than {limit:g} pairs of primitives in every step; lock "
          "more joints with --joints, or leave things out."),
    Check("BAT004", "Batch form: asleep at rest", ERROR, BatchSubject, light_forms.nothing_is_awake_at_rest,
          "batch_awake", "", "Left alone for 0.5 s, at most {limit:g} degrees of freedom are awake or constrained; "
          "find what touches or moves there."),
    Check("BAT005", "Batch form: settles apart", ERROR, BatchSubject, light_forms.batch_form_settles_apart,
          "scene_settled_m", "m", "In the batch form no two things overlap by more than {mm:g} mm, at the start and "
          "after 1 s awake; correct the light form that it is made from."),
    Check("BAT006", "Batch form: things stay put", ERROR, BatchSubject, light_forms.batch_things_stay_put,
          "scene_drift_m", "m", "In the batch form nothing that stands by its weight moves by more than {mm:g} mm in 5 "
          "s awake; correct the light form that it is made from."),
    Check("BAT007", "Batch form: same surfaces", ERROR, BatchSubject, light_forms.surfaces_are_kept, "batch_rays_off",
          "", "At most {limit:.0%} of rays in the room meet the batch form more than 5 mm nearer or farther than the "
          "light form, closed and open; give it more primitives with --primitives."),
    Check("BAT008", "Batch form: room inside", ERROR, BatchSubject, light_forms.room_inside_is_kept, "batch_filled", "",
          "No region that stays open is filled by more than {limit:.0%} of what is free in the light form; give it "
          "more primitives with --primitives."),
    Check("BAT009", "Batch form: opens by hand", ERROR, BatchSubject, light_forms.joints_open_by_hand, "reach_share",
          "", "Each joint of a fixture covers {limit:.0%} of its range within 2 s under 20 N at its grip in the batch "
          "form; look for what it meets there."),
    Check("BAT010", "Batch form: awake in use", ERROR, EngineSizes, engine_sizes.few_are_awake_in_use,
          "batch_awake_in_use", "", "With a robot of nine joints and one fixture in use at most {limit:g} degrees of "
          "freedom are awake; look for what leans on what is opened."),
)
# fmt: on


TABLE: tuple[Check, ...] = (*ASSET_ROWS, *objects.ROWS, *library.ROWS, *SCENE_ROWS)
LOADS = "SCN001"
UNLOADED = "MuJoCo cannot read scene.xml (SCN001)"


def explained(limits: Mapping[str, float]) -> dict[str, str]:
    """Code -> title and description of every check, such as `Overall size: The longest side ...`."""
    return {row.code: f"{row.title}: {row.describe(limits)}" for row in TABLE}


def run_scene(
    subject: SceneSubject,
    limits: Mapping[str, float],
    waived: Mapping[str, str] = NO_WAIVERS,
    table: Iterable[Check] = TABLE,
) -> Report:
    """Report of every check of a scene and its file; where MuJoCo cannot read the file all but the first are not run.

    `waived`: code -> reason of checks that are not run. Raises KeyError: the registry lacks a limit that a row names.
    """
    rows = [row for row in table if row.subject is SceneSubject]
    name = subject.scene.id
    if not subject.loaded.error:
        return run(subject, name, limits, waived, rows)
    loads = run(subject, name, limits, waived, [row for row in rows if row.code == LOADS])
    others = [row for row in rows if row.code != LOADS]
    return loads + report_not_run((SceneSubject,), name, limits, UNLOADED, waived, others)
