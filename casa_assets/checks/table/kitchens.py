"""Checks of a kitchen as a designer, a mobile robot and a list of tasks see it."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.design.robot import reach
from casa_assets.checks.design.rules import aisles, appliances, doorways, grade
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.checks.robots.verdict import joints_are_reached
from casa_assets.checks.start_states import verdict
from casa_assets.checks.start_states.verdict import StatesSubject
from casa_assets.model.issue import Severity
from casa_assets.model.kitchen.robot import SceneRobots

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("NKB001", "Doorway width", ERROR, DesignSubject, doorways.doorways_are_wide_enough, "doorway_m", "m",
          "Doors and passages leave at least {limit:g} m clear with the leaf open (NKBA 1); make the opening wider."),
    Check("NKB002", "Entry door swing", ERROR, DesignSubject, doorways.entry_doors_swing_freely, "swing_m", "m",
          "The leaf of an entry door overlaps no appliance and no appliance door by more than {mm:g} mm seen from "
          "above (NKBA 2); turn the swing, or move the appliance."),
    Check("NKB003", "Appliance doors apart", ERROR, DesignSubject, doorways.appliance_doors_swing_apart, "swing_m", "m",
          "The areas that the doors of two appliances sweep overlap by at most {mm:g} mm seen from above (NKBA 2); "
          "move one of the appliances."),
    Check("NKB004", "Work aisle", ERROR, DesignSubject, aisles.work_aisles_are_wide_enough, "work_aisle_m", "m",
          "Fronts that face each other are at least {limit:g} m apart, unless the plan says `compact: true` (NKBA 6); "
          "move the rows apart."),
    Check("NKB005", "Work aisle, compact", ERROR, DesignSubject, aisles.compact_work_aisles_are_wide_enough,
          "compact_aisle_m", "m",
          "In a plan that says `compact: true`, fronts that face each other are at least {limit:g} m apart; move the "
          "rows apart."),
    Check("NKB006", "Walkway width", ERROR, DesignSubject, aisles.walkways_are_wide_enough, "walkway_m", "m",
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
    Check("NAV001", "Reachable fixtures", ERROR, DesignSubject, reach.fixtures_are_reachable, "unreached", "",
          "A base of 0.30 m radius reaches every fixture from an entry (at most {limit:g} are not reached); leave "
          "free floor before them, and a way to it."),
    Check("NAV002", "Reachable when open", ERROR, DesignSubject, reach.opened_fixtures_are_reachable, "unreached", "",
          "A base of 0.30 m radius has a place to stand at every fixture with its door or drawer open (at most "
          "{limit:g} without); leave free floor beside the open part."),
    Check("NAV003", "Entries lead in", ERROR, DesignSubject, reach.entries_lead_in, "unreached", "",
          "A base of 0.30 m radius can enter the kitchen through every door and passage (at most {limit:g} are "
          "blocked); clear what stands before them."),
    Check("TSK001", "Tasks supported", ERROR, DesignSubject, reach.tasks_are_supported, "tasks_lacking", "",
          "In a plan that says `all_tasks: true`, each of the 25 atomic tasks of RoboCasa v0.2 has its fixtures, "
          "joints and sites within reach (at most {limit:g} lack one); add what the task lacks."),
    Check("TSK002", "Room for task objects", ERROR, DesignSubject, reach.task_objects_find_room, "task_rate", "",
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
)
# fmt: on
