"""All checks, one literal table; docs/checks.md is printed from it."""

from __future__ import annotations

from casa_assets.checks import mjcf, parity, usd
from casa_assets.checks.check import Check
from casa_assets.checks.package import Package
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

TABLE: tuple[Check, ...] = (
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
)
