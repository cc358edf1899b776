"""All checks, one literal table; docs/checks.md is printed from it."""

from __future__ import annotations

from casa_assets.checks import (
    alike,
    asset,
    behavior,
    clearance,
    contract,
    cover,
    flicker,
    force,
    grip,
    hollow,
    mjcf,
    parity,
    travel,
    unwrap,
    usd,
    visual,
)
from casa_assets.checks.alike import Shelf
from casa_assets.checks.check import Check
from casa_assets.checks.design import affords, aisles, appliances, grade, reach, ways
from casa_assets.checks.design.subject import DesignSubject as Plan
from casa_assets.checks.filters import colour, hold, kind, sizes, still, surface, weight
from casa_assets.checks.filters.sizes import Sizes
from casa_assets.checks.package import Package
from casa_assets.checks.scene import (
    agree,
    budget,
    inside,
    layer,
    light,
    opening,
    overlap,
    pulling,
    rest,
    support,
    views,
)
from casa_assets.checks.scene.budget import Speed
from casa_assets.checks.scene.files import SceneFiles
from casa_assets.checks.scene.subject import SceneSubject as Kitchen
from casa_assets.checks.scene.views import Pictures
from casa_assets.model.asset import Asset
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

TABLE: tuple[Check, ...] = (
    # the asset itself
    Check("AST001", ERROR, Asset, asset.fits_in_a_kitchen, "max_extent_m", "m", "A mug of 80 m is a mistaken unit."),
    Check("AST002", ERROR, Asset, asset.is_thick_enough, "min_extent_m", "m", "A sheet of no thickness stops nothing."),
    Check("AST003", ERROR, Asset, asset.is_not_too_dense, "density_high", "", "Too dense: shapes that miss the body."),
    Check("AST004", WARNING, Asset, asset.is_not_too_light, "density_low", "", "Foam flies off at the first touch."),
    Check("AST005", ERROR, Asset, asset.has_few_shapes, "hull_count", "", "Contact cost grows with their number."),
    Check("AST006", ERROR, Asset, asset.has_small_hulls, "hull_vertices", "", "GPU pipelines drop larger hulls."),
    Check("AST007", ERROR, Asset, asset.has_convex_hulls, "rounding_m", "m", "Contact takes convexity for granted."),
    Check("AST008", ERROR, Asset, asset.has_mass_inside, "rounding_m", "m", "A balance point in the air tips it over."),
    Check("AST009", ERROR, Asset, asset.is_touched_as_seen, "collider_bounds_m", "m", "A hand grasps what it sees."),
    Check("AST010", ERROR, Asset, asset.stands_on_its_origin, "origin_m", "m", "Whoever places it places its origin."),
    Check("AST011", WARNING, Asset, asset.has_a_licence, None, "", "What nobody licensed cannot be passed on."),
    Check("AST012", ERROR, Asset, asset.can_be_touched, None, "", "A robot must not reach through what it sees."),
    Check("AST013", ERROR, Package, asset.has_usual_mass, "mass_range_slack", "", "A grip is planned by weight."),
    Check("AST014", WARNING, Package, asset.has_usual_size, "size_slack", "", "A gripper has one width."),
    Check("AST015", ERROR, Asset, asset.closes_at_zero, None, "", "Zero is closed: a joint starts there."),
    Check("AST016", ERROR, Asset, cover.is_covered, "collider_bare", "", "What is bare of shapes is passed through."),
    Check(
        "AST017", ERROR, Asset, grip.is_spread_like_matter, "gyration_share", "", "Inertia decides how a door swings."
    ),
    # what is seen
    Check("VIS001", ERROR, Asset, visual.has_whole_triangles, None, "", "A triangle without area has no normal."),
    Check("VIS002", ERROR, Asset, visual.is_lit_from_outside, "flipped_normals", "", "Else light falls on the back."),
    Check("VIS003", ERROR, Asset, visual.is_not_inside_out, "inverted_area", "", "Viewers leave out what faces away."),
    Check("VIS004", WARNING, Asset, visual.has_few_faces, "visual_faces", "", "A scene has hundreds of assets."),
    Check("VIS005", ERROR, Asset, visual.has_room_for_textures, None, "", "It would show one colour of it."),
    Check("VIS006", ERROR, Asset, visual.has_small_textures, "texture_px", "px", "Pictures fill a GPU's memory first."),
    Check("VIS007", ERROR, Asset, visual.has_enough_vertices, None, "", "MuJoCo refuses meshes of fewer than four."),
    Check("VIS008", ERROR, Asset, visual.is_seen_once, None, "", "Two surfaces in one place flicker."),
    Check("VIS009", ERROR, Asset, unwrap.is_true_to_size, "uv_stretch", "", "A tile has one size in a whole kitchen."),
    Check("VIS010", ERROR, Asset, flicker.shows_one_face, "flicker_m2", "m^2", "Two faces in one place flicker."),
    # what moves
    Check("KIN001", ERROR, Package, force.opens_under_a_hand, "reach_share", "", "A door that sticks is a wall."),
    Check("KIN002", ERROR, Package, force.opens_by_itself_alone, "reach_share", "", "Too stiff is too stiff anywhere."),
    Check("KIN003", ERROR, Package, force.starts_gently, "hand_force_n", "N", "ADA 309.4 grants a hand no more."),
    Check("KIN004", ERROR, Package, force.springs_back, "spring_back_share", "", "A key that stays in works once."),
    Check("KIN005", ERROR, Package, clearance.keeps_clear, "clearance_m", "m", "Loaders drop excludes: form must do."),
    Check("KIN006", ERROR, Package, force.stays_put, "drift_share", "", "What drifts spoils every episode."),
    Check("KIN007", ERROR, Asset, grip.has_a_handle, "gripper_m", "m", "A policy has to know what to take."),
    Check("KIN008", ERROR, Asset, grip.is_upright, "axis_off_rad", "rad", "Scaling loaders know upright axes only."),
    Check(
        "KIN009", WARNING, Package, travel.goes_all_its_way, "travel_share", "", "What sticks half way is half open."
    ),
    Check("HOL001", ERROR, Package, hollow.holds_a_ball, "hollow_m", "m", "What cannot hold a thing is no interior."),
    # what runtimes look for
    Check("CON001", ERROR, Package, contract.has_links_and_joints, None, "", "A runtime finds a door by its name."),
    Check("CON002", ERROR, Package, contract.has_sites, None, "", "A flame or a stream is a site of a given name."),
    Check("CON003", ERROR, Package, contract.has_shapes, None, "", "A key is pressed where its named geom is touched."),
    Check("CON004", ERROR, Package, contract.has_regions, "main_gap_m", "m", "Layouts place the region main."),
    Check("CON005", ERROR, Package, contract.is_found_in_the_file, None, "", "Runtimes walk literal paths in the XML."),
    Check("CON006", ERROR, Package, contract.reaches_thresholds, None, "", "A knob that stops short is never on."),
    Check("CON007", WARNING, Package, contract.is_spelled_as_read, None, "", "Runtimes tell capitals apart."),
    Check("BEH001", ERROR, Asset, behavior.can_take_every_value, None, "", "What no robot can bring about is no task."),
    Check("BEH002", ERROR, Asset, behavior.is_seen_to_change, None, "", "A policy learns from what it sees."),
    Check("BEH003", ERROR, Package, behavior.does_as_asked, None, "", "Data that nobody ran is a wish."),
    # MJCF package
    Check("MJC001", ERROR, Package, mjcf.compiles, None, "", "A file that does not compile is of no use to anyone."),
    Check("MJC002", ERROR, Package, mjcf.loads_in_silence, None, "", "What MuJoCo warns of today it refuses tomorrow."),
    Check("MJC003", ERROR, Package, mjcf.keeps_the_rules, None, "", "robosuite and robocasa read names, not meanings."),
    Check("MJC004", ERROR, Package, mjcf.visuals_weigh_nothing, None, "", "A visual with mass counts matter twice."),
    Check("MJC005", ERROR, Package, mjcf.agrees_with_asset, "parity_length_m", "m", "The file says what was decided."),
    Check("MJC006", ERROR, Package, mjcf.comes_to_rest, "drop_limit_s", "s", "What never rests spoils every scene."),
    Check("MJC007", WARNING, Package, mjcf.stays_upright, "drop_tip_deg", "deg", "What tips was oriented wrongly."),
    Check("MJC008", ERROR, Package, mjcf.rests_on_the_floor, "drop_penetration_m", "m", "A thing lies on, not in."),
    Check("MJC009", ERROR, Package, mjcf.joints_move_freely, "sweep_penetration_m", "m", "A jammed door is a wall."),
    # USD package
    Check("USD001", ERROR, Package, usd.opens, None, "", "A layer that USD complains of breaks whoever refers to it."),
    Check("USD002", ERROR, Package, usd.is_simready, None, "", "SimReady Robotics-Prop 4.0.0 is what others gate on."),
    Check("USD003", ERROR, Package, usd.is_valid, None, "", "OpenUSD's own validators know what USD means."),
    Check("USD004", ERROR, Package, usd.imports_into_mujoco, None, "", "What MuJoCo warns of it has left out."),
    Check("USD005", ERROR, Package, usd.pictures_are_png, None, "", "A missing picture is a white thing in viewers."),
    # MJCF and USD
    Check("PAR001", ERROR, Package, parity.agrees_in_mujoco, "parity_relative", "", "One thing, two files, a reader."),
    Check("PAR002", ERROR, Package, parity.agrees_in_usd, "parity_relative", "", "One thing, two files, two readers."),
    Check("PAR003", ERROR, Package, parity.contacts_and_joints_agree, "parity_relative", "", "Contact is the grasp."),
    Check("PAR004", ERROR, Package, parity.lengths_agree, "parity_length_m", "m", "A part out of place jams."),
    # what strangers' meshes are unfit for
    Check("FLT001", WARNING, Asset, surface.is_opaque, "see_through", "", "Viewers leave out the backs of faces."),
    Check("FLT002", ERROR, Package, surface.has_all_sides, "missing_side", "", "A robot lifts and turns it."),
    Check("FLT003", ERROR, Asset, surface.winds_one_way, "mixed_winding", "", "Half of it would be lit from within."),
    Check("FLT004", ERROR, Asset, surface.is_no_card, "flat_cards", "", "A card is nothing from the side."),
    Check("FLT005", ERROR, Asset, surface.hangs_together, "parts_apart", "", "One body is one thing."),
    Check("FLT006", ERROR, Package, surface.stands_on_no_ground, "ground_width", "", "Nobody lifts a mug by a table."),
    Check("FLT007", WARNING, Package, kind.is_of_known_kind, None, "", "Tasks ask for things by their names."),
    Check("FLT008", WARNING, Package, kind.has_usual_proportions, "odd_shape", "", "It may be something else."),
    Check("FLT009", WARNING, Package, kind.opens_as_its_kind, "vessel_room", "", "Tasks put things into vessels."),
    Check("FLT010", ERROR, Asset, colour.is_lit, "dark", "", "A camera sees a hole."),
    Check("FLT011", WARNING, Asset, colour.is_coloured, "plain", "", "Policies trained on grey fail on colours."),
    Check("FLT012", WARNING, Asset, colour.has_sharp_pictures, "picture_points", "", "A wrist camera comes near."),
    Check("FLT013", WARNING, Asset, weight.loads_fast, "load_ms", "ms", "A scene has hundreds of assets."),
    Check("FLT014", ERROR, Asset, weight.turns_like_its_shapes, "inertia_factor", "", "Else it spins in the hand."),
    Check("FLT015", ERROR, Package, still.stays_put, "wander_m", "m", "What walks by itself spoils every episode."),
    Check("FLT016", ERROR, Package, still.stands, "stand_tip_deg", "deg", "A scene begins with everything upright."),
    Check("FLT017", WARNING, Package, still.stacks, "stack_off", "", "Tasks stack what is said to stack."),
    Check("FLT018", WARNING, Package, hold.can_be_taken, "gripper_m", "m", "Tasks take what is said to be graspable."),
    # a library as a whole
    Check("LIB001", WARNING, Shelf, alike.has_no_form_twice, "alike_form", "", "A test on known forms proves little."),
    Check("LIB002", WARNING, Shelf, alike.has_no_look_twice, "alike_look", "", "What looks the same adds no variety."),
    Check("LIB003", WARNING, Shelf, alike.looks_like_its_kind, "look_rank", "", "Tasks ask for things by their names."),
    Check("LIB004", WARNING, Sizes, sizes.are_like_the_others, "size_off", "", "A unit is mistaken, or a category."),
    # a whole scene
    Check("SCN001", ERROR, Kitchen, rest.loads_in_silence, None, "", "What MuJoCo warns of today it refuses tomorrow."),
    Check("SCN002", ERROR, Kitchen, rest.begins_apart, "scene_start_m", "m", "What begins in another jumps out of it."),
    Check("SCN003", ERROR, Kitchen, rest.settles_apart, "scene_settled_m", "m", "What is pressed in is held fast."),
    Check("SCN004", ERROR, Kitchen, rest.keeps_joints, "drift_share", "", "What drifts spoils every episode."),
    Check("SCN005", ERROR, Kitchen, opening.opens_wide, "scene_clash_m", "m", "A door that runs into another is shut."),
    Check("SCN006", ERROR, Kitchen, pulling.opens_in_place, "reach_share", "", "A robot has to get it open by hand."),
    Check("SCN007", ERROR, Kitchen, overlap.nothing_overlaps, "scene_overlap_m", "m", "Two things need two places."),
    Check("SCN008", ERROR, Kitchen, support.nothing_floats, "scene_floating", "", "In a house everything is held up."),
    Check("SCN009", ERROR, Kitchen, inside.stays_inside, "scene_outside_m", "m", "A room ends at its walls."),
    Check("SCN010", ERROR, Kitchen, budget.has_few_bodies, "scene_bodies", "", "A step costs more than their number."),
    Check(
        "SCN011", ERROR, Kitchen, rest.keeps_things, "scene_drift_m", "m", "What slides away is not where it was put."
    ),
    Check("SCN012", ERROR, Kitchen, budget.has_few_shapes, "scene_shapes", "", "Each may meet each other one."),
    Check("SCN013", ERROR, Kitchen, budget.has_few_freedoms, "scene_freedoms", "", "Solvers grow with their square."),
    Check("SCN014", ERROR, Kitchen, budget.has_few_vertices, "scene_vertices", "", "Hulls are searched by vertex."),
    Check("SCN015", ERROR, Kitchen, budget.has_small_pictures, "scene_pictures_mb", "MB", "GPUs hold many scenes."),
    Check(
        "SCN016", ERROR, Kitchen, budget.touches_little, "scene_contacts", "", "Contacts at rest cost in every step."
    ),
    Check("SCN017", ERROR, SceneFiles, agree.formats_agree, "scene_disagreements", "", "One kitchen, two files."),
    Check("SCN018", ERROR, SceneFiles, layer.opens_in_silence, None, "", "What a reader warns of it has left out."),
    Check("SCN019", ERROR, SceneFiles, layer.is_valid, None, "", "OpenUSD's own validators know what USD means."),
    Check("SCN020", ERROR, SceneFiles, layer.keeps_simready_rules, None, "", "Pipelines gate on these rules."),
    Check("SCN021", ERROR, SceneFiles, light.is_the_same_machine, None, "", "Trained in one form, used in the other."),
    Check("SCN022", ERROR, SceneFiles, light.settles_apart, "scene_settled_m", "m", "Coarse shapes reach farther."),
    Check("SCN023", ERROR, Kitchen, views.show_every_wall, "scene_wall_seen", "", "What nobody sees nobody checks."),
    Check("SCN024", ERROR, Pictures, views.are_lit, "scene_black", "", "A black picture shows no kitchen."),
    Check("SCN025", ERROR, Pictures, views.are_not_burnt_out, "scene_white", "", "White out is lost for good."),
    Check("SCN026", WARNING, Speed, budget.loads_soon, "scene_load_ms", "ms", "Every worker of a batch loads it."),
    Check("SCN027", WARNING, Speed, budget.keeps_pace, "scene_pace", "", "Training waits for the slowest scene."),
    Check("SCN028", ERROR, SceneFiles, light.keeps_things, "scene_drift_m", "m", "Coarse feet let things fall over."),
    # a kitchen as a designer looks at it
    Check("NKB001", ERROR, Plan, ways.is_entered, "doorway_m", "m", "People and robots come through it."),
    Check("NKB002", ERROR, Plan, ways.enters_freely, "swing_m", "m", "Who comes in must not hit who cooks."),
    Check("NKB003", ERROR, Plan, ways.opens_apart, "swing_m", "m", "Two open doors must not lock each other."),
    Check("NKB004", ERROR, Plan, aisles.is_roomy, "work_aisle_m", "m", "A cook bends down between two fronts."),
    Check("NKB005", ERROR, Plan, aisles.is_roomy_enough, "compact_aisle_m", "m", "Less is no kitchen at all."),
    Check("NKB006", ERROR, Plan, aisles.lets_pass, "walkway_m", "m", "Two people pass each other sideways."),
    Check("NKB007", ERROR, Plan, appliances.has_standing_room, "dishwasher_m", "m", "It is loaded from beside it."),
    Check("NKB008", ERROR, Plan, appliances.is_below_a_hood, "hood_m", "m", "Flames and heads need the room."),
    Check("NKB009", ERROR, Plan, appliances.is_below_nothing_else, "over_cooktop_m", "m", "Wood over flames burns."),
    Check("NKB010", ERROR, Plan, appliances.is_not_below_a_window, "window_m", "m", "Draughts put out flames."),
    Check("NKB011", ERROR, Plan, appliances.keeps_off_corners, "corner_m", "m", "Handles round a corner clash."),
    Check("NKB012", WARNING, Plan, grade.is_well_designed, "design_score", "", "Rules of taste are often broken."),
    # its floor as a robot drives on it
    Check("NAV001", ERROR, Plan, reach.is_reached, "unreached", "", "What nobody gets to might as well be painted."),
    Check("NAV002", ERROR, Plan, reach.is_reached_open, "unreached", "", "Who opens a door has to stand somewhere."),
    Check("NAV003", ERROR, Plan, reach.is_entered_by_base, "unreached", "", "A door that leads nowhere is a wall."),
    # what can be done in it
    Check("TSK001", ERROR, Plan, affords.affords_every_task, "tasks_lacking", "", "Lists of exceptions spoil a set."),
    Check("TSK002", ERROR, Plan, affords.has_room_for_things, "task_rate", "", "Resets that find no room never end."),
)
