"""Checks of whole scenes: their files and motion, what a designer and a robot want of a kitchen, and the batch form."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.design import subject
from casa_assets.checks.design.rules import appliances, doorways, grade
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.robots.tasks import joints_are_reached
from casa_assets.checks.scene import views
from casa_assets.checks.scene.batch import engine_sizes, form, surfaces
from casa_assets.checks.scene.batch.form import BatchSubject
from casa_assets.checks.scene.formats import light_form, parity, usd_layer
from casa_assets.checks.scene.formats.light_form import SceneFiles
from casa_assets.checks.scene.motion import budget, opening, rest
from casa_assets.checks.scene.motion.budget import MeasuredSpeed
from casa_assets.checks.scene.placement import support
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.scene.views import PreviewImages
from casa_assets.checks.start_states import verdict
from casa_assets.checks.start_states.verdict import StatesSubject
from casa_assets.model.issue import Severity
from casa_assets.model.kitchen.robot import SceneRobots
from casa_assets.model.kitchen.scene import EngineSizes

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    # Scenes: MJCF, USD and light form, cameras, budgets and speed.
    Check("SCN001", "Scene loads", ERROR, SceneSubject, rest.scene_loads_without_warnings, None, "",
          "MuJoCo reads scene.xml and simulates 5 s of it without an error or a warning; correct what it names."),
    Check("SCN002", "No contact at the start", ERROR, SceneSubject, rest.no_penetration_at_start, "scene_start_m", "m",
          "In the start pose, no two things overlap by more than {mm:g} mm; move one of them, or shrink its shape."),
    Check("SCN003", "Settles apart", ERROR, SceneSubject, rest.no_penetration_after_settling, "scene_settled_m", "m",
          "After 1 s no two things overlap by more than {mm:g} mm; look for the weight or spring that presses them "
          "together."),
    Check("SCN004", "Joints stay put", ERROR, SceneSubject, rest.joints_stay_put, "drift_share", "",
          "Left alone for 5 s, no joint drifts by more than {limit:.0%} of its range; look for what touches it, and "
          "at its friction and spring."),
    Check("SCN005", "Doors and drawers open", ERROR, SceneSubject, opening.joints_open_without_collision,
          "scene_clash_m", "m",
          "Moved through its range, alone and beside each open neighbour, with what lies in it, no part of the kitchen "
          "runs more than {mm:g} mm into anything, with the lids of objects closed; make room, or change the swing."),
    Check("SCN006", "Opens by hand in place", ERROR, SceneSubject, opening.joints_open_by_hand, "reach_share", "",
          "Each joint but those of objects (`scenes new --objects`) covers {limit:.0%} of its range within 2 s "
          "under 20 N at its grip, in the whole scene; clear what it meets, or ease its friction."),
    Check("SCN007", "Fixed things overlap", ERROR, SceneSubject, support.fixed_things_do_not_overlap,
          "scene_overlap_m", "m",
          "No two fixed things overlap by more than {mm:g} mm; move one of them, or make it smaller."),
    Check("SCN008", "Floating things", ERROR, SceneSubject, support.fixed_things_are_supported, "scene_floating", "",
          "Every fixed thing rests on the floor, a wall, the ceiling, or a thing that these hold (at most {limit:g} "
          "do not); set it on what carries it."),
    Check("SCN009", "Inside the room", ERROR, SceneSubject, support.things_are_inside_room, "scene_outside_m", "m",
          "Nothing reaches more than {mm:g} mm beyond floor, walls and ceiling; move it in."),
    Check("SCN010", "Number of bodies", ERROR, SceneSubject, budget.body_count_is_bounded, "scene_bodies", "",
          "The model has at most {limit:g} bodies; merge links that never move against each other."),
    Check("SCN011", "Loose things stay put", ERROR, SceneSubject, rest.loose_things_stay_put, "scene_drift_m", "m",
          "Nothing that stands by its weight moves by more than {mm:g} mm in 5 s; set it down where it stands firmly."),
    Check("SCN012", "Number of colliders", ERROR, SceneSubject, budget.collider_count_is_bounded, "scene_shapes", "",
          "The model has at most {limit:g} collision shapes; merge some, or leave a thing out."),
    Check("SCN013", "Degrees of freedom", ERROR, SceneSubject, budget.degrees_of_freedom_are_bounded,
          "scene_freedoms", "",
          "The kitchen has at most {limit:g} degrees of freedom, those of objects (`scenes new --objects`) not "
          "counted, because solver time grows with their number; fix what nobody has to move."),
    Check("SCN014", "Hull vertices", ERROR, SceneSubject, budget.hull_vertex_count_is_bounded, "scene_vertices", "",
          "The collision hulls have at most {limit:g} vertices in all, counted per instance; use boxes and cylinders."),
    Check("SCN015", "Texture memory", ERROR, SceneSubject, budget.texture_memory_is_bounded, "scene_pictures_mb", "MB",
          "All pictures take at most {limit:g} MB decoded, so that one GPU holds many scenes; share pictures, or "
          "scale them down."),
    Check("SCN016", "Contacts at rest", ERROR, SceneSubject, budget.contact_count_is_bounded, "scene_contacts", "",
          "At most {limit:g} pairs of shapes touch while nothing moves, because each costs time in every step; set "
          "things down on fewer feet."),
    Check("SCN017", "MJCF equals USD", ERROR, SceneFiles, parity.formats_agree, "scene_disagreements", "",
          "Bodies, poses, joints, masses, shapes and labels are the same in scene.xml, scene.usda and "
          "scene_nested.usda (at most {limit:g} differ); please report a difference, it is a fault of the program."),
    Check("SCN018", "USD scene loads", ERROR, SceneFiles, usd_layer.usd_scene_loads_without_warnings, None, "",
          "scene.usda and scene_nested.usda compose without complaint, have a default prim, and MuJoCo imports them "
          "without a warning; correct what the reader names."),
    Check("SCN019", "OpenUSD validators", ERROR, SceneFiles, usd_layer.usd_scene_passes_openusd_validators, None, "",
          "OpenUSD's own validators find nothing in scene.usda and scene_nested.usda; correct the prims that they "
          "name."),
    Check("SCN020", "SimReady rules", ERROR, SceneFiles, usd_layer.usd_scene_meets_simready_rules, None, "",
          "scene.usda meets SimReady Robotics-Prop 4.0.0, but for rules on the package of a single prop; correct the "
          "requirements that are listed."),
    Check("SCN021", "Light form: same mechanism", ERROR, SceneFiles, light_form.mechanism_is_the_same, None, "",
          "scene_light.xml loads without warnings, has no meshes or pictures, and has the joints, masses and poses of "
          "the full form; build it again from the same scene."),
    Check("SCN022", "Light form: settles apart", ERROR, SceneFiles, light_form.no_penetration_after_settling,
          "scene_settled_m", "m",
          "In the light form no two things overlap by more than {mm:g} mm, at the start and after 1 s; correct the "
          "primitive shapes."),
    Check("SCN023", "Cameras see all walls", ERROR, SceneSubject, views.cameras_see_every_wall, "scene_wall_seen", "",
          "Each wall fills at least {limit:.0%} of the picture of some camera; turn a camera to the wall, or add one."),
    Check("SCN024", "No black pictures", ERROR, PreviewImages, views.previews_are_not_black, "scene_black", "",
          "At most {limit:.0%} of each preview is black; add a light there, or move the camera out of what it stands "
          "in."),
    Check("SCN025", "No burnt-out pictures", ERROR, PreviewImages, views.previews_are_not_burnt_out, "scene_white", "",
          "At most {limit:.0%} of each preview is pure white; lower the light, or choose a darker finish."),
    Check("SCN026", "Load time", WARNING, MeasuredSpeed, budget.load_time_is_bounded, "scene_load_ms", "ms",
          "MuJoCo compiles the scene within {limit:g} ms on the machine of the check; use fewer vertices and smaller "
          "pictures."),
    Check("SCN027", "Simulation speed", WARNING, MeasuredSpeed, budget.simulation_is_fast_enough, "scene_pace", "",
          "At rest, one core simulates at least {limit:g} s of the scene per second; use fewer contacts and joints."),
    Check("SCN028", "Light form: things stay put", ERROR, SceneFiles, light_form.loose_things_stay_put,
          "scene_drift_m", "m",
          "In the light form nothing that stands by its weight moves by more than {mm:g} mm in 5 s; correct the "
          "footprint of its primitive shapes."),

    # Kitchens as a designer, a mobile robot and a list of tasks see them.
    Check("NKB001", "Doorway width", ERROR, DesignSubject, doorways.doorways_are_wide_enough, "doorway_m", "m",
          "Doors and passages leave at least {limit:g} m clear with the leaf open (NKBA 1); make the opening wider."),
    Check("NKB002", "Entry door swing", ERROR, DesignSubject, doorways.entry_doors_swing_freely, "swing_m", "m",
          "The leaf of an entry door overlaps no appliance and no appliance door by more than {mm:g} mm seen from "
          "above (NKBA 2); turn the swing, or move the appliance."),
    Check("NKB003", "Appliance doors apart", ERROR, DesignSubject, doorways.appliance_doors_swing_apart, "swing_m", "m",
          "The areas that the doors of two appliances sweep overlap by at most {mm:g} mm seen from above (NKBA 2); "
          "move one of the appliances."),
    Check("NKB004", "Work aisle", ERROR, DesignSubject, doorways.work_aisles_are_wide_enough, "work_aisle_m", "m",
          "Fronts that face each other are at least {limit:g} m apart, unless the plan says `compact: true` (NKBA 6); "
          "move the rows apart."),
    Check("NKB005", "Work aisle, compact", ERROR, DesignSubject, doorways.compact_work_aisles_are_wide_enough,
          "compact_aisle_m", "m",
          "In a plan that says `compact: true`, fronts that face each other are at least {limit:g} m apart; move the "
          "rows apart."),
    Check("NKB006", "Walkway width", ERROR, DesignSubject, doorways.walkways_are_wide_enough, "walkway_m", "m",
          "Ways between things, and along walls, are at least {limit:g} m wide (NKBA 7); move or narrow what stands "
          "beside them."),
    Check("NKB007", "Room at the dishwasher", ERROR, DesignSubject, appliances.dishwashers_have_standing_room,
          "dishwasher_m", "m",
          "A dishwasher is at least {limit:g} m from what stands at a right angle to it (NKBA 13); move it along its "
          "row."),
    Check("NKB008", "Hood height", ERROR, DesignSubject, appliances.hoods_clear_cooktops, "hood_m", "m",
          "A hood hangs at least {limit:g} m over the cooktop (NKBA 18); hang it higher."),
    Check("NKB009", "Clearance over cooktops", ERROR, DesignSubject, appliances.cabinets_clear_cooktops,
          "over_cooktop_m", "m",
          "Cabinets and shelves hang at least {limit:g} m over a cooktop that has no hood (NKBA 18); remove or raise "
          "them, or add a hood."),
    Check("NKB010", "No window over cooktops", ERROR, DesignSubject, appliances.no_openable_window_over_cooktops,
          "window_m", "m",
          "No window that opens is over a cooktop (at most {limit:g} m of it, NKBA 20); move the cooktop, or fix "
          "the sash."),
    Check("NKB011", "Distance from corners", ERROR, DesignSubject, appliances.appliances_keep_off_corners,
          "corner_m", "m",
          "Appliances are at least {limit:g} m from an inside corner of the worktops (LSU AgCenter); move them along "
          "the row."),
    Check("NKB012", "Design score", WARNING, DesignSubject, grade.design_score_is_high_enough, "design_score", "",
          "At least {limit:g} of 100 advisory design rules that apply are followed (NKBA, LSU, trade sizes); see the "
          "section Design for those that are not."),
    Check("NAV001", "Reachable fixtures", ERROR, DesignSubject, subject.fixtures_are_reachable, "unreached", "",
          "A base of 0.30 m radius reaches every fixture from an entry (at most {limit:g} are not reached); leave "
          "free floor before them, and a way to it."),
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
          "At least {limit:.0%} of 200 drawn objects find a free place within reach, for each task; clear the "
          "surface, or make it larger."),
    Check("ROB001", "Joints a robot reaches", ERROR, SceneRobots, joints_are_reached, "robot_reach", "",
          "At least {limit:.0%} of the joints with a handle, knob, button or lever are reached by PandaOmron from the "
          "parking place, free of contact; free the grip, or the floor before it."),
    Check("STA001", "Start states fit", ERROR, StatesSubject, verdict.states_fit_their_scene, None, "",
          "The start states have the joints of scene.xml in its order, and were made for exactly this file; draw them "
          "again with scenes states."),
    Check("STA002", "Start states apart", ERROR, StatesSubject, verdict.states_have_no_deep_contact,
          "state_contact_m", "m",
          "Simulated again for 2 s, no two shapes of a start state are more than {mm:g} mm in each other; draw it "
          "again."),
    Check("STA003", "Start states at rest", ERROR, StatesSubject, verdict.states_stay_put, "state_motion_m", "m",
          "Simulated again for 2 s, no corner of any shape of a start state moves by more than {mm:g} mm; draw it "
          "again."),
    Check("STA004", "Robot parked in room", ERROR, StatesSubject, verdict.states_leave_room_for_the_robot,
          "states_blocked", "",
          "In every start state the boxes around a robot in its home pose are empty (at most {limit:g} states are not "
          "so); draw them again."),
    Check("STA005", "Start states differ", ERROR, StatesSubject, verdict.states_differ, "state_difference", "",
          "In any two start states a joint, a thing or the base differs by {limit:g} m or rad at least; draw one of "
          "them again."),

    # Batch forms.
    Check("BAT001", "Batch form loads", ERROR, BatchSubject, form.batch_form_loads, None, "",
          "scene_batch.xml loads without warnings, is made of boxes, spheres, cylinders and capsules, its pictures are "
          "small, and its joints are those of the light form; build it again from the same scene."),
    Check("BAT002", "Batch form: colliders", ERROR, BatchSubject, form.collider_count_is_bounded, "batch_shapes", "",
          "At most {limit:g} primitives of the batch form touch anything; lock more joints with --joints, or leave "
          "things out of the plan."),
    Check("BAT003", "Batch form: candidate pairs", ERROR, BatchSubject, form.pair_count_is_bounded, "batch_pairs", "",
          "An engine has to look at no more than {limit:g} pairs of primitives in every step; lock more joints with "
          "--joints, or leave things out."),
    Check("BAT004", "Batch form: asleep at rest", ERROR, BatchSubject, form.nothing_is_awake_at_rest, "batch_awake", "",
          "Left alone for 0.5 s, at most {limit:g} degrees of freedom are awake or constrained; find what touches or "
          "moves there."),
    Check("BAT005", "Batch form: settles apart", ERROR, BatchSubject, form.no_penetration, "scene_settled_m", "m",
          "In the batch form no two things overlap by more than {mm:g} mm, at the start and after 1 s awake; correct "
          "the light form that it is made from."),
    Check("BAT006", "Batch form: things stay put", ERROR, BatchSubject, form.loose_things_stay_put, "scene_drift_m",
          "m",
          "In the batch form nothing that stands by its weight moves by more than {mm:g} mm in 5 s awake; correct the "
          "light form that it is made from."),
    Check("BAT007", "Batch form: same surfaces", ERROR, BatchSubject, surfaces.surfaces_are_kept, "batch_rays_off", "",
          "At most {limit:.0%} of rays in the room meet the batch form more than 5 mm nearer or farther than the light "
          "form, closed and open; give it more primitives with --primitives."),
    Check("BAT008", "Batch form: room inside", ERROR, BatchSubject, surfaces.room_inside_is_kept, "batch_filled", "",
          "No region that stays open is filled by more than {limit:.0%} of what is free in the light form; give it "
          "more primitives with --primitives."),
    Check("BAT009", "Batch form: opens by hand", ERROR, BatchSubject, form.joints_open_by_hand, "reach_share", "",
          "Each joint of a fixture covers {limit:.0%} of its range within 2 s under 20 N at its grip in the batch "
          "form; look for what it meets there."),
    Check("BAT010", "Batch form: awake in use", ERROR, EngineSizes, engine_sizes.few_are_awake_in_use,
          "batch_awake_in_use", "",
          "With a robot of nine joints and one fixture in use at most {limit:g} degrees of freedom are awake; look "
          "for what leans on what is opened."),
)
# fmt: on
