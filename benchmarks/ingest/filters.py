"""Filters of ingest: what they say of the assets of a library, and of the same assets spoilt in one way each.

    ./dev bench ingest_filters LIBRARY [--every 3]

Writes out/bench/ingest_filters.json and .md, and prints the latter. LIBRARY is what `casa-assets ingest` made; its
accepted assets are taken as sound: what a filter says of them is listed by name, to be judged by eye. Each is then
spoilt in twelve ways (WAYS) and called by other names, and it is counted how often the filter
that should speak does.
"""

from __future__ import annotations

import argparse
import io
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
from PIL import Image

from benchmarks.ingest.inputs import publish
from casa_assets import registry
from casa_assets.checks.check import Check, Package
from casa_assets.checks.filters import FACES_MS, PIXELS_MS, UNKNOWN, misfit
from casa_assets.checks.table import TABLE
from casa_assets.core.numeric import Floats
from casa_assets.ingest.texture import png_bytes
from casa_assets.library.entry_files import read_asset
from casa_assets.library.library import Library
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

# Ways of spoiling -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Way:
    """One way of spoiling.

    Attributes:
        name: in words. code: of the filter that has to speak.
        spoil: the spoilt asset, None where an asset cannot be spoilt so.
    """

    name: str
    code: str
    spoil: Callable[[Asset, Category], Asset | None]


def without_bottom(asset: Asset, category: Category) -> Asset | None:
    """Less all triangles that face down in the lowest twentieth."""
    if category.build not in (MatterFill.SOLID, MatterFill.FILLED) or category.upright is not RestingPose.STANDS:
        return None
    low, high = asset.bounds[:, 2]

    def stays(mesh: Mesh) -> npt.NDArray[np.bool_]:
        normals, _ = face_normals(mesh.vertices, mesh.faces.astype(np.int64))
        deep = mesh.vertices[mesh.faces][:, :, 2].mean(axis=1) < low + 0.05 * (high - low)
        kept: npt.NDArray[np.bool_] = ~(deep & (normals[:, 2] < -0.5))
        return kept

    return _faces(asset, stays)


def turned(asset: Asset, category: Category) -> Asset | None:
    """Three in ten triangles wound the other way."""

    def one(mesh: Mesh) -> Mesh:
        faces = mesh.faces.copy()
        rows = np.arange(len(faces)) * 7 % 10 < 3
        faces[rows] = faces[rows, ::-1]
        return mesh.replace(faces=faces)

    return _meshes(asset, one)


def doubled(asset: Asset, category: Category) -> Asset | None:
    """Two of it in one file, a fifth of its width apart."""
    shift = np.array([1.2 * float(np.ptp(asset.bounds[:, 0])), 0.0, 0.0])
    extra = tuple(
        v.replace(name=f"{v.name}_again", mesh=v.mesh.with_vertices(v.mesh.vertices + shift, v.mesh.normals))
        for v in asset.root.visuals
    )
    return _link(asset, (*asset.root.visuals, *extra))


def grounded(asset: Asset, category: Category) -> Asset | None:
    """On a slab three times as wide as it is."""
    if category.upright is not RestingPose.STANDS or category.fixed:
        return None
    wide = 3 * float(np.ptp(asset.bounds, axis=0)[:2].max())
    box = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-1.0, 0.0)])
    points, faces = convex_hull(box * [wide, wide, 0.02 * float(np.ptp(asset.bounds[:, 2]))])
    slab = Visual(name="slab", mesh=Mesh(vertices=points, faces=faces), material=asset.root.visuals[0].material)
    return _link(asset, (*asset.root.visuals, slab))


def of_cards(asset: Asset, category: Category) -> Asset | None:
    """Two crossed sheets of its height and width in its place."""
    x, y, z = (float(v) for v in np.ptp(asset.bounds, axis=0))
    faces = [(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)]
    sheets = (
        [[-x / 2, 0, 0], [x / 2, 0, 0], [x / 2, 0, z], [-x / 2, 0, z]],
        [[0, -y / 2, 0], [0, y / 2, 0], [0, y / 2, z], [0, -y / 2, z]],
    )
    look = asset.root.visuals[0].material
    cards = (Visual(name=f"card_{i}", mesh=Mesh(vertices=s, faces=faces), material=look) for i, s in enumerate(sheets))
    return _link(asset, tuple(cards))


def filled(asset: Asset, category: Category) -> Asset | None:
    """A vessel as its own hull."""
    if category.build is not MatterFill.VESSEL:
        return None
    points, faces = convex_hull(np.concatenate([v.mesh.vertices for v in asset.root.visuals]))
    first = asset.root.visuals[0]
    return _link(asset, (first.replace(mesh=Mesh(vertices=points, faces=faces)),))


def stretched(asset: Asset, category: Category) -> Asset | None:
    """Two and a half times as tall for its width."""
    return _meshes(asset, lambda m: m.with_vertices(m.vertices * [1.0, 1.0, 2.5], m.normals))


def blackened(asset: Asset, category: Category) -> Asset | None:
    """All materials black, as exporters leave them."""
    return _looks(
        asset,
        lambda m: Material(id=m.id, base_color=(0.0, 0.0, 0.0, 1.0), roughness=m.roughness, substance=m.substance),
    )


def greyed(asset: Asset, category: Category) -> Asset | None:
    """All materials a default grey, as exporters leave them."""
    return _looks(asset, lambda m: Material(id=m.id, substance=m.substance))


def shrunk(asset: Asset, category: Category) -> Asset | None:
    """Pictures of 12 pixels."""
    return _pictures(asset, lambda p: p.resize((12, 12), Image.Resampling.BOX))


def blurred(asset: Asset, category: Category) -> Asset | None:
    """Pictures that were 12 pixels once and have their old size again."""
    return _pictures(asset, lambda p: p.resize((12, 12), Image.Resampling.BOX).resize(p.size, Image.Resampling.BICUBIC))


def light_headed(asset: Asset, category: Category) -> Asset | None:
    """A tenth of its inertia."""
    inertial = asset.root.inertial
    xx, yy, zz, xy, xz, yz = (v / 10 for v in inertial.inertia)
    link = asset.root.replace(inertial=inertial.replace(inertia=(xx, yy, zz, xy, xz, yz)))
    return asset.replace(links=(link,))


WAYS = (
    Way("open bottom", "FLT002", without_bottom),
    Way("mixed winding", "FLT003", turned),
    Way("flat cards", "FLT004", of_cards),
    Way("two objects in one file", "FLT005", doubled),
    Way("ground baked in", "FLT006", grounded),
    Way("2.5 times too tall", "FLT008", stretched),
    Way("vessel filled up", "FLT009", filled),
    Way("black materials", "FLT010", blackened),
    Way("grey default materials", "FLT011", greyed),
    Way("pictures of 12 pixels", "FLT012", shrunk),
    Way("blurred pictures", "FLT012", blurred),
    Way("inertia ten times too small", "FLT014", light_headed),
)


def _link(asset: Asset, visuals: tuple[Visual, ...]) -> Asset:
    return asset.replace(links=(asset.root.replace(visuals=visuals),))


def _meshes(asset: Asset, change: Callable[[Mesh], Mesh]) -> Asset:
    return _link(asset, tuple(v.replace(mesh=change(v.mesh)) for v in asset.root.visuals))


def _faces(asset: Asset, stays: Callable[[Mesh], npt.NDArray[np.bool_]]) -> Asset | None:
    kept = [(v, stays(v.mesh)) for v in asset.root.visuals]
    if all(rows.all() for _, rows in kept):
        return None
    left = tuple(v.replace(mesh=v.mesh.replace(faces=v.mesh.faces[rows])) for v, rows in kept if rows.any())
    return _link(asset, left)


def _looks(asset: Asset, change: Callable[[Material], Material]) -> Asset:
    return asset.replace(materials=tuple(change(m) for m in asset.materials))


def _pictures(asset: Asset, change: Callable[[Image.Image], Image.Image]) -> Asset | None:
    if not any(m.base_color_texture is not None and m.base_color_texture.name != "painted" for m in asset.materials):
        return None

    def one(look: Material) -> Material:
        image = look.base_color_texture
        if image is None:
            return look
        with Image.open(io.BytesIO(image.png)) as opened:
            small = change(opened.convert("RGB"))
        skin = Texture(name=image.name, png=png_bytes(small), width_px=small.width, height_px=small.height)
        return look.replace(base_color_texture=skin)

    return _looks(asset, one)


# Filters --------------------------------------------------------------------------------------------------------------


# Nothing is wrong with the mesh, but with what it is said to be.
RENAMED = "called something else"
# Share of spoilt assets that the filter meant for them has to find.
TARGET = 0.95
ROWS = {check.code: check for check in TABLE if check.code.startswith("FLT")}


@dataclass
class Filter:
    """What one filter said of sound assets: numbers by id, and what it found."""

    numbers: dict[str, float] = field(default_factory=dict)
    flagged: dict[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass
class Spoilt:
    """How often spoilt assets were found: ids of those that were not."""

    tried: int = 0
    missed: list[str] = field(default_factory=list)


def packages(root: Path, every: int) -> Iterator[Package]:
    """Accepted assets of a library, every n-th."""
    known = registry.load()
    for folder in list(Library(root).accepted())[::every]:
        asset = read_asset(folder)
        yield Package(asset, known.category(asset.labels.category), folder)


def judge(check: Check, package: Package) -> tuple[float | None, str]:
    """Number and words of one filter on one asset."""
    limit = None if check.limit is None else registry.load().limits[check.limit]
    found = check.function(package.asset if check.subject is Asset else package, limit)
    return found.number, "; ".join(message for _, message in found.problems)


def load_ms(folder: Path) -> float:
    """Processor time that MuJoCo takes to load the model, milliseconds."""
    start = time.process_time()
    mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    return 1000 * (time.process_time() - start)


def measure(root: Path, every: int) -> tuple[int, dict[str, Filter], dict[str, Spoilt], list[tuple[float, float]]]:
    """Assets seen, by filter what it said, by way of spoiling what it missed, and (reckoned, measured) ms to load."""
    sound = {code: Filter() for code in ROWS}
    spoilt = {name: Spoilt() for name in (*(way.name for way in WAYS), RENAMED)}
    loads: list[tuple[float, float]] = []
    seen: list[tuple[str, Floats, Category]] = []
    for package in packages(root, every):
        name = package.asset.id
        # First, for MuJoCo remembers what it has loaded.
        took = load_ms(package.root)
        for code, check in ROWS.items():
            _listen(sound[code], check, package)
        loads.append((sound["FLT013"].numbers[name], took))
        for way in WAYS:
            bad = way.spoil(package.asset, package.category)
            if bad is not None and name not in sound[way.code].flagged:
                found = judge(ROWS[way.code], Package(bad, package.category, package.root))[1]
                _count(spoilt[way.name], name, bool(found))
        seen.append((name, np.ptp(package.asset.bounds, axis=0), package.category))
        print(f"{name}: done", flush=True)
    _rename(seen, spoilt[RENAMED])
    return len(seen), sound, spoilt, loads


def _listen(to: Filter, check: Check, package: Package) -> None:
    start = time.process_time()
    number, message = judge(check, package)
    to.seconds += time.process_time() - start
    if number is not None:
        to.numbers[package.asset.id] = number
    if message:
        to.flagged[package.asset.id] = message


def _rename(seen: list[tuple[str, Floats, Category]], into: Spoilt) -> None:
    """Each thing under the names of up to four others, as far round the list as can be."""
    limit = registry.load().limits["odd_shape"]
    for i, (name, size, category) in enumerate(seen):
        for step in range(1, 5):
            other = seen[(i + step * len(seen) // 5) % len(seen)][2]
            if other.id not in (category.id, UNKNOWN):
                _count(into, f"{name} as {other.id}", misfit(size, other) > limit)


def _count(into: Spoilt, name: str, found: bool) -> None:
    into.tried += 1
    if not found:
        into.missed.append(name)


def table(name: str, count: int, sound: dict[str, Filter], spoilt: dict[str, Spoilt], loads: list[list[float]]) -> str:
    """All tables as markdown."""
    lines = [f"Filters on {count} accepted assets of `{name}`", ""]
    lines += [
        "| filter | severity | limit | least | median | most | speaks of | ms |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [_sound_row(check, sound[code], count) for code, check in ROWS.items()]
    lines += ["", f"Spoilt on purpose (target: at least {TARGET:.0%} of each found)", ""]
    lines += ["| spoilt by | filter | found | of | share | target | missed |", "|---|---|---|---|---|---|---|"]
    lines += [_spoilt_row(way.name, way.code, spoilt[way.name]) for way in WAYS]
    lines.append(_spoilt_row(RENAMED, "FLT008", spoilt[RENAMED]))
    if loads:
        off = np.array([measured / max(reckoned, 1e-9) for reckoned, measured in loads])
        low, mid, high = np.percentile(off, (10, 50, 90))
        by = f"{FACES_MS:g} ms a thousand triangles, {PIXELS_MS:g} ms a million pixels"
        lines += [
            "",
            f"Time to load, measured over reckoned ({by}): median {mid:.2f}, 80 % from {low:.2f} to {high:.2f}",
        ]
    return "\n".join(lines) + "\n"


def _sound_row(check: Check, found: Filter, count: int) -> str:
    limit = "" if check.limit is None else f"{registry.load().limits[check.limit]:g} {check.unit}".strip()
    spread = np.percentile(list(found.numbers.values()), (0, 50, 100)) if found.numbers else ()
    least, median, most = (f"{v:.3g}" for v in spread) if len(spread) else ("", "", "")
    who = f"{len(found.flagged)}: {', '.join(sorted(found.flagged)[:6])}" if found.flagged else "0"
    cells = [f"{check.code} {check.function.__name__}", check.severity.value, limit, least, median, most, who]
    return f"| {' | '.join([*cells, f'{1000 * found.seconds / max(count, 1):.0f}'])} |"


def _spoilt_row(name: str, code: str, one: Spoilt) -> str:
    found = one.tried - len(one.missed)
    share = found / one.tried if one.tried else float("nan")
    verdict = "pass" if share >= TARGET else f"miss by {100 * (TARGET - share):.0f} points"
    cells = [name, code, str(found), str(one.tried), f"{share:.0%}", verdict, ", ".join(one.missed[:6])]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    """Parse, run, write, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("library", type=Path, help="library that ingest made")
    parser.add_argument("--every", type=int, default=1, help="only every n-th asset")
    parser.add_argument("--out", type=Path, default=Path("out/bench"), help="where results go")
    given = parser.parse_args()
    count, sound, spoilt, loads = measure(given.library, given.every)
    rows = {
        "assets": count,
        "sound": {code: {"numbers": f.numbers, "flagged": f.flagged} for code, f in sound.items()},
        "spoilt": {name: {"tried": s.tried, "missed": s.missed} for name, s in spoilt.items()},
        "load_ms": loads,
    }
    text = table(given.library.name, count, sound, spoilt, [list(pair) for pair in loads])
    publish(given.out / "ingest_filters", rows, text)


if __name__ == "__main__":
    main()
