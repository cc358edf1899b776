"""Checks of the written MJCF and USD, and that they say the same."""

from __future__ import annotations

from casa_assets.checks.check import Check
from casa_assets.checks.package import mjcf, parity, usd
from casa_assets.checks.package.package import Package
from casa_assets.model.issue import Severity

ERROR, WARNING = Severity.ERROR, Severity.WARNING

# How the drop is done. Ref: SimReady Foundation, FET003 base neutral simulation.
DROP = ("drop_height_factor", "drop_min_height_m", "drop_rest_m", "drop_rest_s", "drop_rate_hz", "drop_limit_s")

# fmt: off
ROWS: tuple[Check, ...] = (
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
          "After the drop the asset is tilted by at most {limit:g} degrees; correct its orientation, or its foot.",
          DROP),
    Check("MJC008", "Rests on the floor", ERROR, Package, mjcf.rests_on_floor_after_drop, "drop_penetration_m", "m",
          "At rest after the drop, the asset is at most {mm:g} mm deep in the floor; correct its collision shapes or "
          "mass.", DROP),
    Check("MJC009", "Joints move freely", ERROR, Package, mjcf.joints_move_without_collision,
          "sweep_penetration_m", "m",
          "Over the range of each joint in the written file, parts go at most {mm:g} mm into each other; shorten the "
          "range, or make room."),
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
    Check("PAR001", "MJCF equals USD in MuJoCo", ERROR, Package, parity.mujoco_reads_both_alike, "parity_relative", "",
          "Bodies, masses, joints and looks that MuJoCo reads from the USD equal those from the MJCF to {limit:g}, "
          "except lengths (PAR004); please report a difference, it is a fault of the program."),
    Check("PAR002", "MJCF equals USD in OpenUSD", ERROR, Package, parity.openusd_reads_as_mujoco, "parity_relative", "",
          "Bodies, masses, joints and looks that UsdPhysics reads equal those that MuJoCo reads from the MJCF to "
          "{limit:g}, except lengths (PAR004); please report a difference, it is a fault of the program."),
    Check("PAR003", "Contact parameters", ERROR, Package, parity.contact_parameters_agree, "parity_relative", "",
          "Contact and joint parameters that MuJoCo reads from MJCF and USD agree to {limit:g}; please report a "
          "difference, it is a fault of the program."),
    Check("PAR004", "Lengths in both formats", ERROR, Package, parity.lengths_agree, "parity_length_m", "m",
          "Positions, sizes and joint travel in MJCF and USD agree to {limit:g} m for both readers; please report a "
          "difference, it is a fault of the program."),
)
# fmt: on
