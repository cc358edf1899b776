"""Checks of the batch form of a kitchen, for engines that step thousands of copies at once."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.scene.batch import engine_sizes, opening, rest, size, surfaces
from casa_assets.checks.scene.batch.subject import BatchSubject
from casa_assets.model.issue import Severity
from casa_assets.model.kitchen.batch_scene import EngineSizes

ERROR = Severity.ERROR

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("BAT001", "Batch form loads", ERROR, BatchSubject, size.batch_form_loads, None, "",
          "scene_batch.xml loads without warnings, is made of boxes, spheres, cylinders and capsules, its pictures are "
          "small, and its joints are those of the light form; build it again from the same scene."),
    Check("BAT002", "Batch form: colliders", ERROR, BatchSubject, size.collider_count_is_bounded, "batch_shapes", "",
          "At most {limit:g} primitives of the batch form touch anything; lock more joints with --joints, or leave "
          "things out of the plan."),
    Check("BAT003", "Batch form: candidate pairs", ERROR, BatchSubject, size.pair_count_is_bounded, "batch_pairs", "",
          "An engine has to look at no more than {limit:g} pairs of primitives in every step; lock more joints with "
          "--joints, or leave things out."),
    Check("BAT004", "Batch form: asleep at rest", ERROR, BatchSubject, size.nothing_is_awake_at_rest, "batch_awake", "",
          "Left alone for 0.5 s, at most {limit:g} degrees of freedom are awake or constrained; find what touches or "
          "moves there."),
    Check("BAT005", "Batch form: settles apart", ERROR, BatchSubject, rest.no_penetration, "scene_settled_m", "m",
          "In the batch form no two things overlap by more than {mm:g} mm, at the start and after 1 s awake; correct "
          "the light form that it is made from."),
    Check("BAT006", "Batch form: things stay put", ERROR, BatchSubject, rest.loose_things_stay_put, "scene_drift_m",
          "m",
          "In the batch form nothing that stands by its weight moves by more than {mm:g} mm in 5 s awake; correct the "
          "light form that it is made from."),
    Check("BAT007", "Batch form: same surfaces", ERROR, BatchSubject, surfaces.surfaces_are_kept, "batch_rays_off", "",
          "At most {limit:.0%} of rays in the room meet the batch form more than 5 mm nearer or farther than the light "
          "form, closed and open; give it more primitives with --primitives."),
    Check("BAT008", "Batch form: room inside", ERROR, BatchSubject, surfaces.room_inside_is_kept, "batch_filled", "",
          "No region that stays open is filled by more than {limit:.0%} of what is free in the light form; give it "
          "more primitives with --primitives."),
    Check("BAT009", "Batch form: opens by hand", ERROR, BatchSubject, opening.joints_open_by_hand, "reach_share", "",
          "Each joint of a fixture covers {limit:.0%} of its range within 2 s under 20 N at its grip in the batch "
          "form; look for what it meets there."),
    Check("BAT010", "Batch form: awake in use", ERROR, EngineSizes, engine_sizes.few_are_awake_in_use,
          "batch_awake_in_use", "",
          "With a robot of nine joints and one fixture in use at most {limit:g} degrees of freedom are awake; look "
          "for what leans on what is opened."),
)
# fmt: on
