"""Scene in its light form -> its batch form: what stands still merged across fixtures, what moves in few primitives."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from casa_assets.geometry.merging.locked_joints import with_joints_locked
from casa_assets.geometry.merging.moving_parts import loose_parts, with_few_primitives, with_plain_parts
from casa_assets.geometry.merging.still_parts import StillPart, exposed_parts, merged_parts, still_parts
from casa_assets.geometry.merging.swept_bounds import meeting_links
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.model.asset.asset import Asset, Region
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.batch_scene import BatchScene, PlacedJoint
from casa_assets.model.kitchen.scene import LightScene, PlacedLink
from casa_assets.model.pose import Pose

# Names of the region around a whole asset, the one that is added first. Ref: robocasa v1.0, fixtures and objects.
OUTER_REGIONS = ("bbox", "main")


def batch_form(light: LightScene, locked: Collection[tuple[str, str]] = (), filled: Collection[str] = ()) -> BatchScene:
    """The batch form of a scene.

    Args:
        light: its light form. locked: joints that are left out, (placement, joint).
        filled: placements of loose things that become solid, and of fixtures whose doors do: nothing can be put into
            them, or into the bins of a door.
    """
    scene = light.scene
    light_of = {asset.id: asset for asset in light.light_assets}
    whole, with_locked = [], {where for where, _ in locked}
    for place in scene.placements:
        joints = [joint for where, joint in locked if where == place.name]
        asset = with_plain_parts(light_of[place.asset], joints)
        whole.append(with_joints_locked(asset, joints, joint_positions(place.joints)))
    still: list[StillPart] = []
    for place, form in zip(scene.placements, whole, strict=True):
        parts = still_parts(place, form)
        # What is inside of a unit that cannot be opened need not be looked at in the whole room.
        still += exposed_parts(parts) if place.name in with_locked else parts
    loose = loose_parts(scene.placements, whole)
    forms = [
        _with_outer_region(with_few_primitives(place, form, loose, place.name in filled), form)
        for place, form in zip(scene.placements, whole, strict=True)
    ]
    return BatchScene(
        scene=scene,
        forms=tuple(forms),
        world=tuple(merged_parts(still)),
        meeting=tuple(
            tuple(PlacedLink(placement=where, link=link) for where, link in group)
            for group in meeting_links(scene.placements, forms)
        ),
        locked=tuple(PlacedJoint(placement=where, joint=joint) for where, joint in locked),
        filled=tuple(filled),
    )


def _with_outer_region(form: Asset, whole: Asset) -> Asset:
    """The form with a region around all colliders that the asset had before they went to the world."""
    if any(region.name in OUTER_REGIONS for region in form.regions):
        return form
    bounds = (link_bounds(link, whole.asset_from_link(link.name)) for link in whole.links)
    boxes = [found for found in bounds if found is not None]
    if not boxes:
        return form
    corners = np.array(boxes)
    lower, upper = corners[:, 0].min(axis=0), corners[:, 1].max(axis=0)
    a, b, c = (float(value) for value in (lower + upper) / 2)
    x, y, z = (float(value) for value in upper - lower)
    outer = Region(name=OUTER_REGIONS[0], pose=Pose(position=(a, b, c)), size=(x, y, z))
    return form.replace(regions=(*form.regions, outer))
