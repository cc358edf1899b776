"""Sliding parts of refrigerators: crispers and baskets behind a door, and freezer drawers."""

from __future__ import annotations

from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.kit.solids.blocks import board, box
from casa_assets.families.parts.appliance.look import ApplianceLook
from casa_assets.families.parts.refrigerator.case import DOOR_GAP, LINER_THICKNESS
from casa_assets.families.parts.refrigerator.door import FridgeDoor, add_face, add_pull
from casa_assets.families.parts.refrigerator.gasket import gasket_frame
from casa_assets.model.record import Vec3

WALL_THICKNESS = 0.0035  # metres; injection moulded
LIP_DEPTH = 0.024  # how far the lip of a crisper stands out before its front
CRISPER_PULL = 0.62  # part of its depth that a crisper slides out
SIDE_CLEARANCE = 0.006  # metres at each side of what slides


def crisper_travel(depth: float) -> float:
    """How far a crisper of a depth slides out, metres."""
    return round(CRISPER_PULL * depth, 3)


def crisper_reach(front: float, back: float) -> float:
    """How far before y = 0 the lip of a crisper between two y comes, metres."""
    return crisper_travel(back - front - LIP_DEPTH) - front


def add_crisper(
    builder: AssetBuilder,
    name: str,
    behind: str,
    lower: Vec3,
    upper: Vec3,
    look: ApplianceLook,
    finish: str = "plastic_clear",
) -> None:
    """A drawer in a room, open on top; its link is `name`, its joint `<name>_joint`.

    Args:
        behind: joint of the door in front of it.
        lower, upper: corners of the space it may take, metres; lower[1] is where its lip begins.
        finish: of its body.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    builder.link(name, at=((x0 + x1) / 2, y0 + LIP_DEPTH, z0))
    w, d, h, e = x1 - x0, y1 - y0 - LIP_DEPTH, z1 - z0, WALL_THICKNESS
    half, rim = w / 2, 0.012
    for solid, part in (
        (board((-half, 0.0, 0.0), (half, d, e), 0.001), "bottom"),
        (board((-half, 0.0, e), (half, e + 0.002, h - rim), 0.001), "front"),
        (board((-half, d - e, e), (half, d, h - rim), 0.001), "back"),
        (board((-half, e + 0.002, e), (-half + e, d - e, h - rim), 0.001), "left"),
        (board((half - e, e + 0.002, e), (half, d - e, h - rim), 0.001), "right"),
    ):
        builder.add(name, solid, finish, label="drawer", collider=f"{name}_{part}", density="ribbed_plastic")
    for solid in (
        board((-half - 0.002, -0.003, h - 0.03), (half + 0.002, e + 0.003, h), 0.002, 2),
        board((-half - 0.002, e + 0.0032, h - rim), (-half + e + 0.002, d, h), 0.001),
        board((half - e - 0.002, e + 0.0032, h - rim), (half + 0.002, d, h), 0.001),
    ):
        builder.add(name, solid, look.trim, label="drawer", collider=False, density="ribbed_plastic")
    width = min(0.3, 0.7 * w)
    lip = box((width, LIP_DEPTH - 0.0034, 0.007), (0.0, -0.0032 - (LIP_DEPTH - 0.0034) / 2, h - 0.0065), 0.002, 2)
    hook = box((width, 0.006, 0.014), (0.0, -LIP_DEPTH + 0.003, h - 0.014), 0.002)
    collider_box = board((-width / 2, -LIP_DEPTH, h - 0.021), (width / 2, -0.003, h - 0.003), 0.0)
    for solid in (lip, hook):
        builder.add(name, solid, look.trim, label="handle", collider=False, density="ribbed_plastic")
    builder.add_collider(name, collider_box, look.trim, "handle", f"{name}_handle_main")
    travel = crisper_travel(d)
    builder.slide(
        f"{name}_joint", name, (0.0, 1.0, 0.0), (-travel, 0.0), f"{name}_handle_main", start_n=6.0, behind=behind
    )
    builder.region(name, (-half + e, e + 0.002, e), (half - e, d - e, h - 0.004), link=name)


def add_pull_out(builder: AssetBuilder, door: FridgeDoor, look: ApplianceLook, region: str) -> None:
    """Add a front with a deep basket behind it that slide out together; link and joint are those of `door`."""
    t, w, h, r = look.thick, door.width, door.height, door.compartment
    builder.link(door.link, at=(door.lower[0], -DOOR_GAP - t, door.lower[1]))
    add_face(builder, door, look)
    seal = gasket_frame((0.012, 0.012), (w - 0.012, h - 0.012), t + 2e-4, t + DOOR_GAP - 3e-4)
    builder.add(door.link, seal, "gasket_grey", "gasket", collider=False, density="magnetic_gasket")
    add_pull(builder, door, look)
    x0, x1 = (
        r.lower[0] + LINER_THICKNESS + SIDE_CLEARANCE + 0.012 - door.lower[0],
        r.upper[0] - LINER_THICKNESS - SIDE_CLEARANCE - 0.012 - door.lower[0],
    )
    z0 = max(r.lower[2] + 0.012 - door.lower[1], 0.03)
    z1 = min(r.upper[2] - 0.02 - door.lower[1], h - 0.03)
    z1 = z0 + 0.8 * (z1 - z0)
    y0, y1, e = t + DOOR_GAP, t + DOOR_GAP + r.upper[1] - 0.03, 0.004
    for solid, part in (
        (board((x0, y0, z0), (x1, y1, z0 + e), 0.001), "bottom"),
        (board((x0, t + 1e-4, z0 + e), (x1, y0 + 0.01, z1), 0.001), "front"),
        (board((x0, y1 - e, z0 + e), (x1, y1, z1), 0.001), "back"),
        (board((x0, y0 + 0.01, z0 + e), (x0 + e, y1 - e, z1), 0.001), "left"),
        (board((x1 - e, y0 + 0.01, z0 + e), (x1, y1 - e, z1), 0.001), "right"),
    ):
        builder.add(
            door.link, solid, "plastic_white", "drawer", collider=f"{door.name}_basket_{part}", density="ribbed_plastic"
        )
    for x in (x0 - 0.0105, x1 + 0.0005):
        rail = board((x, y0 + 0.012, z0 + 0.03), (x + 0.01, y1 - 0.06, z0 + 0.05), 0.001)
        builder.add(door.link, rail, "steel_galvanised", "rail", collider=False, density="drawer_runner")
    travel = round(0.82 * (y1 - y0), 3)
    grip_name = f"{door.link}_handle_main"
    builder.slide(door.joint, door.link, (0.0, 1.0, 0.0), (-travel, 0.0), grip_name, start_n=11.0)
    builder.region(region, (x0 + e, y0 + 0.01, z0 + e), (x1 - e, y1 - e, z1), link=door.link)
