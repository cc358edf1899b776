"""Checks of what moves, of what runtimes look up by name, and of behaviours."""

from __future__ import annotations

from casa_assets.checks.asset import finger_room, grip
from casa_assets.checks.check import Check
from casa_assets.checks.motion import clearance, hand_force, joint_travel
from casa_assets.checks.package.package import Package
from casa_assets.checks.runtime import behavior, contract, hollow_regions
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# fmt: off
ROWS: tuple[Check, ...] = (
    Check("KIN001", "Opens by hand", ERROR, Package, hand_force.joints_open_by_hand, "reach_share", "",
          "Each joint covers {limit:.0%} of its range in both directions within 2 s under 20 N at its grip, with "
          "contacts on; ease friction, or clear what the part meets."),
    Check("KIN002", "Joint resistance", ERROR, Package, hand_force.joints_open_by_hand_without_contacts,
          "reach_share", "",
          "Each joint covers {limit:.0%} of its range in both directions within 2 s under 20 N at its grip, with "
          "contacts off; lower its friction, damping or spring."),
    Check("KIN003", "Starting force", ERROR, Package, hand_force.starting_force_is_moderate, "hand_force_n", "N",
          "The force at the grip that starts each closed joint is between {hand_force_least_n:g} N and {limit:g} N "
          "(ADA 309.4); adjust its friction or spring.", ("hand_force_least_n",)),
    Check("KIN004", "Buttons spring back", ERROR, Package, hand_force.keys_spring_back, "spring_back_share", "",
          "A button with a spring that was pressed and let go is back to {limit:.0%} of its stroke within 2 s; "
          "stiffen the "
          "spring, or lower friction."),
    Check("KIN005", "Clearance of moving parts", ERROR, Package, clearance.moving_parts_keep_clear, "clearance_m", "m",
          "No part goes deeper than {mm:g} mm into another over the whole range of a joint, alone and beside each "
          "other open joint; make room between them."),
    Check("KIN006", "Joints stay put", ERROR, Package, hand_force.joints_stay_put, "drift_share", "",
          "Left alone for 5 s, closed and in each named pose, no joint drifts by more than {limit:.0%} of its range; "
          "raise friction, or balance the part."),
    Check("KIN007", "Grips fit a gripper", ERROR, Asset, grip.grips_fit_a_gripper, "gripper_m", "m",
          "Each joint names a labelled grip that moves with it, is free to be reached, and is at most {limit:g} m "
          "thick; name, shrink or uncover the grip."),
    Check("KIN008", "Axis-aligned joints", ERROR, Asset, grip.joint_axes_are_aligned, "axis_off_rad", "rad",
          "Joint axes of built things lie along x, y or z to {limit:g} rad, as loaders that scale fixtures expect; "
          "turn the part straight."),
    Check("KIN009", "Travel of found joints", WARNING, Package, joint_travel.joints_reach_full_range,
          "travel_share", "",
          "The share of joints of an articulated mesh that go through their whole range under 20 N without collision "
          "is at least {limit:.0%}; shorten the ranges, or clear what the parts meet."),
    Check("KIN010", "Joints rest in range", ERROR, Package, hand_force.joints_rest_in_range, "range_excess",
          "rad or m",
          "Left alone for 2 s, closed, no joint stands more than {limit:g} rad or m outside its range; stiffen its "
          "limit, or ease the spring that presses it there."),
    Check("KIN011", "Room for fingers", ERROR, Asset, finger_room.fingers_have_room, "finger_m", "m",
          "Fingers of {limit:g} m find room on both sides of each handle and knob of what a family built; let it stand "
          "out, or deepen the recess behind it."),
    Check("HOL001", "Usable interiors", ERROR, Package, hollow_regions.interiors_hold_a_ball, "hollow_m", "m",
          "A ball of 6 cm (smaller in narrow regions) laid into each interior region comes to rest within {mm:g} mm "
          "of its floor and sides; clear the region, or correct its box."),
    Check("CON001", "Contract: links and joints", ERROR, Package, contract.links_and_joints_meet_contract, None, "",
          "The links and joints that RoboCasa looks up by name exist, with the kind, axis, sign, range and depth "
          "that it expects; rename or correct them."),
    Check("CON002", "Contract: sites", ERROR, Package, contract.sites_meet_contract, None, "",
          "The sites that RoboCasa looks up by name, such as a flame or a stream of water, exist on the links "
          "where it looks; add or move them."),
    Check("CON003", "Contract: colliders", ERROR, Package, contract.colliders_and_visuals_meet_contract, None, "",
          "The colliders and visuals that RoboCasa looks up by name exist with the labels it expects, and no other "
          "has a name that RoboCasa would take for one of them; rename them."),
    Check("CON004", "Contract: regions", ERROR, Package, contract.regions_meet_contract, "main_gap_m", "m",
          "The regions that RoboCasa looks up exist, `main` encloses what is seen to {mm:g} mm, and interiors lie "
          "within it; correct the boxes of the regions."),
    Check("CON005", "Contract: XML paths", ERROR, Package, contract.xml_paths_meet_contract, None, "",
          "Everything that RoboCasa finds by literal paths in model.xml is at those paths; move the elements to "
          "where it looks."),
    Check("CON006", "Contract: thresholds", ERROR, Package, contract.thresholds_meet_contract, None, "",
          "RoboCasa's thresholds lie within the ranges of their joints, and named poses stand as the contract "
          "says; widen the range, or correct the pose."),
    Check("CON008", "Contract: places", ERROR, Package, contract.places_meet_contract, None, "",
          "Regions and sites are where RoboCasa takes them to be by the numbers written in model.xml, and those in "
          "which it puts things are high enough, stay where they are and have a floor; move the frame or the box."),
    Check("BEH001", "Reachable values", ERROR, Asset, behavior.values_are_reachable, None, "",
          "Every value of every variable of the behaviour can be brought about by moving joints and touching "
          "colliders; add a rule, or drop the value."),
    Check("BEH002", "Visible effects", ERROR, Asset, behavior.effects_are_visible, None, "",
          "Every effect of the behaviour acts on a site, visual or region that can show it; correct its target, "
          "colour or size."),
    Check("BEH003", "Behaviour as specified", ERROR, Package, behavior.behavior_meets_contract, None, "",
          "Operated in MuJoCo step by step, the thing takes the values that its contract names at the contract's "
          "thresholds; correct the rule that differs."),
)
# fmt: on
