"""Scene in its light form -> its batch form: fixed parts merged across fixtures, moving parts as few primitives."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from casa_assets.geometry.merging.locked_joints import with_joints_locked
from casa_assets.geometry.merging.moving_parts import (
    Inside,
    LoosePart,
    loose_parts,
    with_few_primitives,
    with_plain_parts,
)
from casa_assets.geometry.merging.still_parts import StillPart, exposed_parts, merged_parts, still_parts
from casa_assets.geometry.merging.swept_bounds import meeting_links
from casa_assets.geometry.solid.bounds import link_bounds
from casa_assets.model.asset.asset import Asset, Region
from casa_assets.model.asset.joint import joint_positions
from casa_assets.model.kitchen.batch_scene import BatchScene, PlacedJoint
from casa_assets.model.kitchen.scene import LightScene, PlacedLink, Placement
from casa_assets.model.pose import Pose

# Names of the region around a whole asset, the one that is added first. Ref: robocasa v1.0, fixtures and objects.
OUTER_REGIONS = ("bbox", "main")


class BatchForms:
    """Batch forms of one scene with more or fewer joints; what several of them share is made once.

    Args:
        light: the light form of the scene.
    """

    def __init__(self, light: LightScene) -> None:
        self._scene = light.scene
        self._light_of = {asset.id: asset for asset in light.light_assets}
        # By name of a placement and its locked joints: its asset, and its parts that never move.
        self._assets: dict[tuple[str, tuple[str, ...]], Asset] = {}
        self._still: dict[tuple[str, tuple[str, ...]], list[StillPart]] = {}
        # By the same, and what becomes of its inside: its form.
        self._forms: dict[tuple[str, tuple[str, ...], Inside], Asset] = {}

    def form(
        self,
        locked: Collection[tuple[str, str]] = (),
        filled: Collection[str] = (),
        blocks: Collection[str] = (),
    ) -> BatchScene:
        """The batch form of the scene.

        Args:
            locked: joints that are left out, (placement, joint).
            filled: placements of loose things that become solid, and of fixtures whose doors do: nothing can be put
                into them, or into the bins of a door.
            blocks: those of the fixtures of which all bins of a door become one block.
        """
        scene = self._scene
        keys = {
            place.name: (place.name, tuple(joint for where, joint in locked if where == place.name))
            for place in scene.placements
        }
        whole = [self._asset(place, keys[place.name]) for place in scene.placements]
        still = [
            part
            for place, asset in zip(scene.placements, whole, strict=True)
            for part in self._parts(place, asset, keys[place.name])
        ]
        loose = loose_parts(scene.placements, whole)
        fixed = [LoosePart(part.place.name, "", part.collider.shape, part.collider.pose, part.bounds) for part in still]
        forms = []
        for place, asset in zip(scene.placements, whole, strict=True):
            inside = Inside.SOLID if place.name in filled else Inside.KEPT
            key = (*keys[place.name], Inside.ONE_BLOCK if place.name in blocks else inside)
            if key not in self._forms:
                # A seat that becomes a block stands under a worktop, between its corbels.
                is_block = place.name in filled and not asset.joints
                few = with_few_primitives(place, asset, loose + fixed if is_block else loose, key[-1])
                self._forms[key] = _with_outer_region(few, asset)
            forms.append(self._forms[key])
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

    def _asset(self, place: Placement, key: tuple[str, tuple[str, ...]]) -> Asset:
        """The asset of a placement with its joints locked."""
        if key not in self._assets:
            plain = with_plain_parts(self._light_of[place.asset], key[1])
            self._assets[key] = with_joints_locked(plain, key[1], joint_positions(place.joints))
        return self._assets[key]

    def _parts(self, place: Placement, asset: Asset, key: tuple[str, tuple[str, ...]]) -> list[StillPart]:
        """The parts of a placement that never move."""
        if key not in self._still:
            parts = still_parts(place, asset)
            # What is inside of a unit that cannot be opened need not be looked at in the whole room.
            self._still[key] = exposed_parts(parts) if key[1] else parts
        return self._still[key]


def batch_form(light: LightScene, locked: Collection[tuple[str, str]] = (), filled: Collection[str] = ()) -> BatchScene:
    """The batch form of a scene, see `BatchForms.form`."""
    return BatchForms(light).form(locked, filled)


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
