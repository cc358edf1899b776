"""Assets of libraries that a plan or a style names in place of a family's member: `library:<id>`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from casa_assets import registry
from casa_assets.asset.scale_asset import level_of, scaled
from casa_assets.cache.cache_key import digest_of
from casa_assets.core.numeric import seven_digits
from casa_assets.errors import OutputError, UnknownId
from casa_assets.layouts.compose import AssetOutlines, box_of
from casa_assets.layouts.plan.style_models import NO_LIBRARY
from casa_assets.library.entry_files import read_asset, read_certificate
from casa_assets.library.library import Library
from casa_assets.mesh.planar import stands_by_itself
from casa_assets.model.asset.asset import Asset, Base, Guess, Joint, JointKind, JointValue
from casa_assets.model.kitchen.style import PresetChoice
from casa_assets.projects import SETTINGS, project_folder, read_once
from casa_assets.registry.read import load_project

FITTED_DIGITS = 10  # of the digest in the id of an asset that was fitted to its place
# Steps in which the range of a door is made smaller, down to this share of it at least.
REACH_STEPS, MIN_SHARE = 61, 0.5


class LibraryPresets(Mapping[str, Mapping[str, Any]]):
    """Sizes and properties, by id, of the assets in the libraries of the project in use, as layouts need them.

    An asset is read when it is first asked for. Keys of each entry, lengths in metres: `width`, `depth` and `height` of
    the asset without its handles; `size`, the larger of width and depth; `level`, the height of its working surface;
    `sweep`, how far its doors reach past its sides as they turn; `drop`, how far its flaps and their handles hang below
    it as they open; `category`; `base`; and stands: True if it can stand by itself.
    """

    def __getitem__(self, name: str) -> Mapping[str, Any]:
        """Raises KeyError; OutputError where the asset cannot be read."""
        if name not in _folders():
            raise KeyError(name)
        return _sizes(name)

    def __contains__(self, name: object) -> bool:
        return name in _folders()

    def __iter__(self) -> Iterator[str]:
        """Ids, sorted."""
        return iter(_folders())

    def __len__(self) -> int:
        return len(_folders())


@read_once
def _sizes(name: str) -> Mapping[str, Any]:
    asset = library_asset(name)
    middle, size = box_of(asset)
    width, depth, height = (round(float(value), 4) for value in size)
    outlines, hinges = AssetOutlines(asset), [joint for joint in asset.joints if joint.kind is JointKind.HINGE]
    doors, flaps = ([joint for joint in hinges if _is_upright(joint) is upright] for upright in (True, False))
    aside = [float(np.abs(outlines.swept_points(joint)[..., 0] - middle[0]).max()) for joint in doors]
    down = [float(outlines.swept_points(joint)[..., 2].min()) for joint in flaps]
    # The place of an asset is decided by its box: its level face counts from the foot of that.
    foot = middle[2] - size[2] / 2 - float(asset.bounds[0, 2])
    return {
        "width": width,
        "depth": depth,
        "height": height,
        "size": max(width, depth),
        "level": round(level_of(asset) - foot, 4),
        # How far doors reach past the sides of the box, and flaps hang below its foot.
        "sweep": round(max(0.0, *aside, size[0] / 2) - size[0] / 2, 4),
        "drop": round(max(0.0, *(middle[2] - size[2] / 2 - height for height in down), 0.0), 4),
        "category": asset.labels.category,
        "base": asset.base.value,
        "stands": stands_by_itself(asset),
    }


@read_once
def library_asset(name: str) -> Asset:
    """Return the asset with that id, as it is in its library.

    Raises UnknownId: no library has this id; names the nearest ones. OutputError: the asset cannot be read, or differs
    from the one that was checked when it was made.
    """
    folders = _folders()
    if name not in folders:
        raise UnknownId("library asset", name, folders, "" if folders else NO_LIBRARY)
    folder = folders[name]
    asset = read_asset(folder)
    if asset.digest != read_certificate(folder).asset_digest:
        message = "is not what was checked: it was changed by hand, or made by another version; make it again"
        raise OutputError(str(folder), message)
    return asset


def placed_asset(choice: PresetChoice) -> Asset:
    """Return the chosen asset as it is placed in a kitchen: scaled, free or fixed, with limited door angles.

    An asset that differs from the one in the library gets a separate id, `<category>_fitted_<digits>`, and notes in its
    provenance.

    Raises:
        UnknownId, OutputError: as `library_asset`.
    """
    asset = library_asset(choice.name)
    own, category = asset.id, asset.labels.category
    scale, base = float(choice.params.get("scale", 1.0)), Base(choice.params.get("base", asset.base))
    notes = []
    if scale != 1.0:
        asset = scaled(asset, scale, _mass(asset, scale))
        value = f"{scale:g} of its size in the library"
        notes.append(_note("size_in_the_kitchen", value, "scaled evenly to its place"))
    if "reach" in choice.params:
        asset = _within_reach(asset, float(choice.params["reach"]))
        notes.append(_note("doors_in_the_kitchen", "open less wide", "they would reach what stands beside"))
    if base is not asset.base:
        asset = asset.replace(base=base)
        notes.append(_note("base_in_the_kitchen", base.value, "as its place asks for"))
    if not notes:
        return asset
    notes.append(_note("asset_in_the_library", own, "named by a plan or a style"))
    asset = asset.replace(provenance=asset.provenance.replace(guesses=(*asset.provenance.guesses, *notes)))
    return asset.replace(id=f"{category}_fitted_{asset.digest[:FITTED_DIGITS]}")


def _note(subject: str, value: str, reason: str) -> Guess:
    return Guess(subject=subject, value=value, confidence=1.0, reason=reason)


def _within_reach(asset: Asset, reach: float) -> Asset:
    """Return an asset whose doors open only as far as they stay within `reach` metres of the sides of its box."""
    (middle, *_), (width, *_) = box_of(asset)
    outlines, joints = AssetOutlines(asset), []
    for joint in asset.joints:
        low, high = joint.range
        steps = np.linspace(1.0, 0.0, REACH_STEPS) if _is_upright(joint) else ()
        for share in steps:
            tried = joint.replace(range=(seven_digits(low * float(share)), seven_digits(high * float(share))))
            beside = np.abs(outlines.swept_points(tried)[-1, :, 0] - middle).max() - width / 2
            if share < MIN_SHARE or beside <= reach:
                joint = tried
                break
        joints.append(joint)
    ranges = {joint.name: joint.range for joint in joints}

    def limited(at: JointValue) -> JointValue:
        low, high = ranges[at.joint]
        return at.replace(value=min(max(at.value, low), high))

    keys = tuple(key.replace(joints=tuple(map(limited, key.joints))) for key in asset.keyframes)
    return asset.replace(joints=tuple(joints), keyframes=keys)


def _is_upright(joint: Joint) -> bool:
    """True if a joint turns about an upright axis, as most doors do."""
    return joint.kind is JointKind.HINGE and abs(joint.axis[2]) > 0.5


def placed_key(choice: PresetChoice) -> str:
    """Key of `placed_asset`: what it is to the last byte. Raises as `library_asset`."""
    return digest_of("library", placed_asset(choice).digest)


def _mass(asset: Asset, scale: float) -> float:
    """Mass of a scaled asset, kg: of the same density, but no lighter or heavier than things of its category are."""
    known = registry.load()
    name, mass = asset.labels.category, asset.mass * scale**3
    category = known.fixtures.get(name) or known.categories.get(name)
    if category is None:
        return seven_digits(mass)
    low, high = min(category.mass_kg.low, asset.mass), max(category.mass_kg.high, asset.mass)
    return seven_digits(min(max(mass, low), high))


@read_once
def _folders() -> Mapping[str, Path]:
    """Folder of each accepted asset, by id, sorted; of two libraries with one id the first counts.

    Raises RegistryError: a library that casa.yaml names is not there.
    """
    loaded, place = load_project(), project_folder()
    if loaded is None or place is None:
        return {}
    project, document = loaded
    found: dict[str, Path] = {}
    for number, stated in enumerate(project.libraries):
        folder = place / stated
        if not folder.is_dir():
            raise document.fault(("libraries", number), f"a folder beside {SETTINGS}", repr(stated))
        for one in Library(folder).accepted():
            found.setdefault(one.name, one)
    return dict(sorted(found.items()))
