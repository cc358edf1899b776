"""Write scene.json for task frameworks: placements, joints and regions in the world frame."""

from __future__ import annotations

from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from casa_assets.checks.design.subject import DesignSubject, whereabouts
from casa_assets.core.numeric import decimals
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest, OrderItem
from casa_assets.layouts.spaces import Space, count_of_things, find_spaces, largest_box, world_bounds
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.choices import Surface
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.model.kitchen.style import Style
from casa_assets.model.pose import Pose
from casa_assets.registry.habits import load_habits
from casa_assets.textures.run.pictures import credits_of_pictures

if TYPE_CHECKING:
    from casa_assets.layouts.run.recipe import SceneRecipe

FORMAT = 1


def design_of(kitchen: KitchenRequest, scene: Scene) -> DesignSubject:
    """Return a kitchen as the subject of its design checks, also used to find parking places and tasks of a robot."""
    return DesignSubject(facts_of(kitchen, scene))


def describe(
    recipe: SceneRecipe, kitchen: KitchenRequest, scene: Scene, design: DesignSubject | None = None
) -> dict[str, Any]:
    """The content of scene.json. Lengths in metres, angles in radians, quaternions (w, x, y, z), frame of the world.

    `design` saves what a caller has found of this kitchen already.
    """
    design = design or design_of(kitchen, scene)
    items = {w.name: w for w in kitchen.items}
    pictures = credits_of_pictures({material.id for asset in scene.assets for material in asset.materials})
    makers = _credits(kitchen, scene)
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    behind = {h.back.id: h.wall.id for h in kitchen.holes if h.back is not None}  # niche -> the wall that it is in
    return {
        "format": FORMAT,
        "id": scene.id,
        "plan": recipe.plan,
        "style": recipe.style,
        "seed": recipe.seed,
        "parameters": dict(sorted(kitchen.parameters.items())),
        "surfaces": kitchen.style.surfaces,
        "covers": surface_finishes(kitchen.style),
        **({"models": dict(recipe.models)} if recipe.models else {}),
        **({"textures": pictures} if pictures else {}),
        **({"credits": makers} if makers else {}),
        "generator": f"casa-assets {version('casa-assets')}",
        "room": {
            "outline": [list(p) for p in kitchen.room.outline],
            "bounds": [[x0, y0, 0.0], [x1, y1, kitchen.room.height]],
            "walls": [
                {"id": w.id, "open": w.open, "from": list(w.frame.at(0, 0)), "to": list(w.frame.at(w.length, 0))}
                for w in kitchen.room.walls
            ],
            "openings": [
                {
                    "id": h.opening.id,
                    "kind": h.opening.kind.value,
                    "wall": behind.get(h.wall.id, h.wall.id),
                    "from": list(h.wall.frame.at(h.left, 0, h.bottom)),
                    "to": list(h.wall.frame.at(h.right, 0, h.top)),
                    **({"closet": True} if h.opening.closet else {}),
                }
                for h in kitchen.holes
            ],
        },
        "fixtures": [_fixture(p, scene.asset_of[p.name], items[p.name]) for p in scene.placements if p.resting is None],
        **({"objects": [_object(p, scene.asset_of[p.name]) for p in scene.objects]} if scene.objects else {}),
        "spawn": [_spawn(space, scene) for space in find_spaces(scene, load_habits().spaces)],
        "cameras": [{"name": c.name, **_pose(c.pose), "fov_y_deg": c.fov_y_deg} for c in scene.cameras],
        **whereabouts(design),
    }


def _credits(kitchen: KitchenRequest, scene: Scene) -> list[dict[str, str]]:
    """Makers of the assets of libraries in a kitchen, in the order of their ids."""
    assets, names = scene.asset_of, {item.name for item in kitchen.items if item.choice.is_library}
    found = {assets[name].id: assets[name].provenance for name in names}
    return [
        {
            "asset": asset,
            "title": made.title or made.path.rsplit("/", 1)[-1],
            **{name: getattr(made, name) for name in ("licence", "author", "uri", "generator", "sha256")},
        }
        for asset, made in sorted(found.items())
    ]


def surface_finishes(style: Style) -> dict[str, list[str]]:
    """Finishes that each of the four surfaces is covered with; another choice takes the place of all of them."""
    groups = (style.cabinets.upper, style.cabinets.tall, style.cabinets.island)
    more = {Surface.COUNTER.value: [style.island.face], Surface.CABINET.value: [g.face for g in groups if g.face]}
    return {surface: sorted({name, *more.get(surface, ())}) for surface, name in style.surfaces.items()}


def _fixture(placement: Placement, asset: Asset, item: OrderItem) -> dict[str, Any]:
    regions = {
        r.name: {
            "link": r.link,
            "kind": r.kind,
            "size": list(r.size),
            **_pose(placement.pose @ asset.asset_from_link(r.link) @ r.pose),
        }
        for r in asset.regions
    }
    joints = {
        j.name: {
            "name": f"{placement.name}__{j.name}",
            "kind": j.kind.value,
            "range": list(j.range),
            **{key: part and f"{placement.name}__{part}" for key, part in (("grip", j.grip), ("behind", j.behind))},
        }
        for j in asset.joints
    }
    return {
        "name": placement.name,
        "role": item.role,
        "unit": item.unit,
        "run": item.run,
        "layer": placement.layer.value,
        "asset": asset.id,
        "family": item.choice.family,
        "preset": item.choice.name,
        "category": asset.labels.category,
        "contract": asset.contract,
        "base": asset.base.value,
        **_pose(placement.pose),
        "mass_kg": round(asset.mass, 4),
        "joints": joints,
        "states": sorted({f"{s.joint}.{s.name}" for s in asset.states}),
        "regions": regions,
        "sites": {s.name: {"site": f"{placement.name}__{s.name}", "kind": s.kind} for s in asset.sites},
        "parts": sorted({v.label for k in asset.links for v in k.visuals if v.label}),
    }


def _object(placement: Placement, asset: Asset) -> dict[str, Any]:
    assert placement.resting is not None, "objects rest in something"
    return {
        "name": placement.name,
        "asset": asset.id,
        "category": asset.labels.category,
        **_pose(placement.pose),
        "mass_kg": round(asset.mass, 4),
        "in": placement.resting.model_dump(),
    }


def _spawn(space: Space, scene: Scene) -> dict[str, Any]:
    """Describe a space that takes objects: where it is, how much of it is free, and what people put there.

    `size`: width, depth, height. `pose`, in the world and in the fixture (joints at zero), is that of the middle of its
    floor, x along the front, y to the back. `largest_box` is that of the largest free floor, at `x`, `y` in the frame
    of the space. `things` is the number of cubes of 10 cm that fit on the free floor.
    """
    holder = next(place for place in scene.placements if place.name == space.placement)
    box, middle = largest_box(space)
    return {
        "placement": space.placement,
        "link": space.link,
        "region": space.region,
        "kinds": list(space.kinds),
        "moves": space.is_moving,
        "shape": "cylinder" if space.is_round else "box",
        "size": [round(side, 4) for side in space.size],
        "pose": {"world": _pose(space.pose), "fixture": _pose(holder.pose.inverse() @ space.pose)},
        "bounds": [[decimals(float(c), 4) for c in corner] for corner in world_bounds(space)],
        "largest_box": {"size": [round(side, 4) for side in box], "x": round(middle[0], 4), "y": round(middle[1], 4)},
        "things": count_of_things(space),
        "objects": list(load_habits().kept_in(space.kinds)),
    }


def _pose(pose: Pose) -> dict[str, Any]:
    return {
        "position": [decimals(float(c), 6) for c in pose.position],
        "quaternion": [decimals(float(c), 9) for c in pose.quaternion],
    }
