"""Checks of a whole scene: MJCF, USD and light form, cameras, budgets and speed."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.scene import views
from casa_assets.checks.scene.formats import light_form, parity, usd_layer
from casa_assets.checks.scene.formats.files import SceneFiles
from casa_assets.checks.scene.motion import budget, opening, pulling, rest
from casa_assets.checks.scene.motion.budget import MeasuredSpeed
from casa_assets.checks.scene.placement import inside, overlap, support
from casa_assets.checks.scene.subject import SceneSubject
from casa_assets.checks.scene.views import PreviewImages
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
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
    Check("SCN006", "Opens by hand in place", ERROR, SceneSubject, pulling.joints_open_by_hand, "reach_share", "",
          "Each joint but those of objects (`scenes new --objects`) covers {limit:.0%} of its range within 2 s "
          "under 20 N at its grip, in the whole scene; clear what it meets, or ease its friction."),
    Check("SCN007", "Fixed things overlap", ERROR, SceneSubject, overlap.fixed_things_do_not_overlap,
          "scene_overlap_m", "m",
          "No two fixed things overlap by more than {mm:g} mm; move one of them, or make it smaller."),
    Check("SCN008", "Floating things", ERROR, SceneSubject, support.fixed_things_are_supported, "scene_floating", "",
          "Every fixed thing rests on the floor, a wall, the ceiling, or a thing that these hold (at most {limit:g} "
          "do not); set it on what carries it."),
    Check("SCN009", "Inside the room", ERROR, SceneSubject, inside.things_are_inside_room, "scene_outside_m", "m",
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
)
# fmt: on
