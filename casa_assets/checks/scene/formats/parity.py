"""Compare the MJCF and the USD of a scene by three readings."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import mujoco
from pxr import Tf

from casa_assets.checks.package import parity
from casa_assets.checks.package.fact_differences import Difference, number, turned, word, words
from casa_assets.checks.readers import mujoco_load, scene_mjcf, scene_usd, usd_facts
from casa_assets.checks.readers.mujoco_load import Loaded
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.scene.formats.facts import CameraFacts, LightFacts, PlacementFacts, SceneFacts

# Where a fault is, and what it is.
Fault = tuple[str, str]
Standing = PlacementFacts | CameraFacts
Read = TypeVar("Read")
Row = TypeVar("Row", PlacementFacts, CameraFacts, LightFacts)

# Ratios, unit vectors, radians, masses relative to those of the body: USD holds them as float32.
RELATIVE = 1e-5
# Metres: a float32 six metres from the origin is right to 2.4e-7.
LENGTH_M = 2e-6
DEGREES = 1e-4


def scene_parity(mjcf: Path, usd: Path, relative: float = RELATIVE, length: float = LENGTH_M) -> list[Fault]:
    """(pointer, message) for each cell in which what MuJoCo and UsdPhysics read from the USD differs from the MJCF.

    Args:
        mjcf, usd: scene.xml and scene.usda, beside the shared folder that they name.
        relative: tolerance of ratios, unit vectors, radians, and of masses and moments relative to those of the body.
        length: tolerance of lengths, metres.
    """
    model, refused = _model(mujoco_load.load_asset_file, mjcf)
    if model is None:
        return [(mjcf.name, refused)]
    imported, refused = _model(usd_facts.imported, usd)
    faults = [(usd.name, refused)] if imported is None else []
    return faults + parity_of(model, imported, usd, relative, length)


def parity_of(
    model: mujoco.MjModel,
    imported: mujoco.MjModel | None,
    usd: Path,
    relative: float = RELATIVE,
    length: float = LENGTH_M,
) -> list[Fault]:
    """Differences between files that MuJoCo has already read.

    Args:
        model: of scene.xml. imported: of scene.usda, which lies at `usd`; None leaves what UsdPhysics reads.
    """
    expected, why = _read(lambda: scene_mjcf.facts_of(model))
    if expected is None:
        return [("scene.xml", why)]
    faults = []
    if imported is not None:
        rows = parity.parameters(model, imported)
        faults += [(r.pointer, r.message) for r in rows if r.size is None or not r.size <= relative]
    stage, why = _read(lambda: usd_facts.opened(usd))
    if stage is None:
        return [*faults, (usd.name, why)]
    readers = [lambda: scene_usd.pxr_facts(stage)]
    if imported is not None:
        readers.insert(0, lambda: scene_usd.facts_of_import(imported, stage))
    for reader in readers:
        found, why = _read(reader)
        faults += [(usd.name, why)] if found is None else compare(expected, found, relative, length)
    # What both readers of the USD say is said once.
    return list(dict.fromkeys(faults))


def compare(
    expected: SceneFacts, found: SceneFacts, relative: float = RELATIVE, length: float = LENGTH_M
) -> list[Fault]:
    """(pointer, message) for each cell in which two tables of a scene differ by more than they may."""
    limits = {"gravity": 10 * relative, "position": length, "fov_y_deg": DEGREES, "cone_deg": DEGREES}
    faults = []
    for row in _rows(expected, found):
        limit = limits.get(row.pointer.rsplit("/", 1)[-1], relative)
        if row.size is None or not row.size <= limit:
            faults.append((row.pointer, row.message))
    return faults + parity.compare(expected.things, found.things, relative, length)


def _rows(ours: SceneFacts, theirs: SceneFacts) -> Iterator[Difference]:
    """Every cell but those of the things in it."""
    yield number("gravity", ours.gravity, theirs.gravity)
    for one, other in _pairs(ours.placements, theirs.placements):
        at = f"placements/{one.name}"
        for name in ("asset", "layer", "base"):
            yield from word(f"{at}/{name}", getattr(one, name), getattr(other, name))
        yield from _stand(at, one, other)
        for row in words(one.words, other.words):
            yield row._replace(pointer=f"{at}/{row.pointer}")
    yield from _missing("placements", ours.placements, theirs.placements)
    for camera, found in _pairs(ours.cameras, theirs.cameras):
        at = f"cameras/{camera.name}"
        yield from _stand(at, camera, found)
        yield number(f"{at}/fov_y_deg", camera.fov_y_deg, found.fov_y_deg)
    yield from _missing("cameras", ours.cameras, theirs.cameras)
    for light, lamp in _pairs(ours.lights, theirs.lights):
        at = f"lights/{light.name}"
        for name in ("kind", "castshadow"):
            yield from word(f"{at}/{name}", getattr(light, name), getattr(lamp, name))
        for name in ("position", "direction", "tint", "cone_deg"):
            yield number(f"{at}/{name}", getattr(light, name), getattr(lamp, name))
    yield from _missing("lights", ours.lights, theirs.lights)


def _stand(at: str, ours: Standing, theirs: Standing) -> Iterator[Difference]:
    yield number(f"{at}/position", ours.position, theirs.position)
    yield turned(f"{at}/quaternion", ours.quaternion, theirs.quaternion)


def _pairs(ours: Sequence[Row], theirs: Sequence[Row]) -> Iterator[tuple[Row, Row]]:
    """Rows of one name."""
    named = {row.name: row for row in theirs}
    return ((row, named[row.name]) for row in ours if row.name in named)


def _missing(at: str, ours: Sequence[Row], theirs: Sequence[Row]) -> Iterator[Difference]:
    return word(at, sorted(row.name for row in ours), sorted(row.name for row in theirs))


def _model(load: Callable[[Path], Loaded], path: Path) -> tuple[mujoco.MjModel | None, str]:
    """The model of a file, or why there is none."""
    if not path.is_file():
        return None, "does not exist"
    with quiet():
        loaded = load(path)
    return loaded.model, f"does not load: {loaded.error}"


def _read(reader: Callable[[], Read]) -> tuple[Read | None, str]:
    """Result of a reader, or the reason why there is none."""
    with quiet():
        try:
            return reader(), ""
        except (ValueError, Tf.ErrorException) as error:
            return None, " ".join(str(error).split()) or type(error).__name__
