"""Path-traced stills of a kitchen's or an asset's USD, by Cycles in a separate process, and its errors."""

from __future__ import annotations

import io
import json
import math
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import median_filter, rank_filter

from casa_assets.core import system
from casa_assets.errors import CasaError
from casa_assets.show.stills import pictures
from casa_assets.show.stills.photoreal.views import BEYOND_M, EYE, View, eye_view, named_view, sun_direction
from casa_assets.show.stills.pictures import Pixels

CUTAWAY = "cutaway"  # a view that every kitchen has beside its own cameras, as it has EYE
CUTAWAY_FOV_X_RAD = math.radians(45.0)
ASSET_FOV_X_RAD, ASSET_AZIMUTH_DEG, ASSET_ELEVATION_DEG = math.radians(26.0), 32.0, 20.0
ASSET_SAMPLES = 4  # times those of a room: the plain floor of a studio shows noise that a room hides
ABOVE = ("overview", "above")  # cameras of a scene that look in from above
_SCRIPT = Path(__file__).with_name("blender") / "main.py"


class NoPathTracer(CasaError):
    """There is no Blender, or it failed; the message says what to do."""


@dataclass(frozen=True)
class StillSettings:
    """Size of a still in pixels, and what it costs.

    Attributes:
        samples: paths of each pixel of a room, at most; ASSET_SAMPLES times as many of an asset. threads: of the
            renderer; the picture does not depend on the machine's number of cores. seed: of the paths.
    """

    width_px: int = 960
    height_px: int = 540
    samples: int = 20
    threads: int = 2
    seed: int = 1


@dataclass(frozen=True)
class Still:
    """One picture: its name, (height, width, 3) pixels, and the wall seconds that it took."""

    name: str
    pixels: Pixels
    seconds: float

    @property
    def png(self) -> bytes:
        """Encoded, without a date."""
        return pictures.png(self.pixels)


def scene_stills(
    folder: Path, cameras: Sequence[str] = (), settings: StillSettings | None = None, pose: str = "closed"
) -> Iterator[Still]:
    """Stills of a kitchen in its folder, through its own cameras, `eye` or `cutaway`; by default the last two.

    Args:
        folder: holds scene.usda and scene.json. pose: of the variant set `pose`.
    Raises:
        NoPathTracer: see the class; also if there is no such camera.
    """
    frame = settings or StillSettings()
    told = json.loads((folder / "scene.json").read_text(encoding="utf-8"))
    aspect = frame.width_px / frame.height_px
    views = [_view(told, name, frame) for name in cameras or (EYE, CUTAWAY)]
    # Views from above look into the room without its ceiling, which is a choice that holds for a whole process.
    for above in (False, True):
        chosen = [view for view in views if (view.name in (*ABOVE, CUTAWAY)) == above]
        if chosen:
            job = {
                "usd": (folder / "scene.usda").resolve().as_posix(),
                "root": "World",
                "variants": {"pose": pose, "ceiling": "hidden" if above else "shown"},
                "room": told["room"],
                "beyond_m": BEYOND_M,
                "sun": None if above else sun_direction(told, eye_view(told, EYE, aspect, BEYOND_M), aspect),
                "kind": "cutaway" if above else "room",
            }
            yield from _run(job, chosen, frame)


def _view(told: Mapping[str, Any], name: str, frame: StillSettings) -> View:
    aspect = frame.width_px / frame.height_px
    if name == EYE:
        return eye_view(told, name, aspect, BEYOND_M)
    view = named_view(told, "overview" if name == CUTAWAY else name, aspect)
    if view is None:
        names = [EYE, CUTAWAY, *(c["name"] for c in told["cameras"])]
        raise NoPathTracer(f"there is no camera {name!r}; there are {', '.join(names)}")
    if name == CUTAWAY:
        low, high = told["room"]["bounds"]
        corners = tuple((x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2]))
        return View(name, view.position, view.quaternion, CUTAWAY_FOV_X_RAD, fit=corners)
    return view


def asset_still(usd: Path, settings: StillSettings | None = None, pose: str = "") -> Still:
    """Still of an asset on a studio's floor, seen from the front and a little from its right and above.

    Args:
        usd: `usd/<id>.usda` of its folder. pose: of the variant set `pose`; empty: as the file says.
    """
    turn, tilt = math.radians(ASSET_AZIMUTH_DEG) / 2, math.radians(90 - ASSET_ELEVATION_DEG) / 2
    c, s, up, down = math.cos(turn), math.sin(turn), math.cos(tilt), math.sin(tilt)
    view = View(usd.stem, (0.0, 0.0, 0.0), (c * up, c * down, s * down, s * up), ASSET_FOV_X_RAD, fit=())
    variants = {"pose": pose} if pose else {}
    job = {"usd": usd.resolve().as_posix(), "root": usd.stem, "variants": variants, "kind": "asset"}
    frame = settings or StillSettings()
    (still,) = _run(job, [view], replace(frame, samples=ASSET_SAMPLES * frame.samples))
    return still


def _run(job: Mapping[str, Any], views: Sequence[View], frame: StillSettings) -> Iterator[Still]:
    """Draw views in one process of Blender."""
    program = system.find_blender()
    if not program:
        raise NoPathTracer(f"stills by a path tracer need Blender, {system.how_to_install()}")
    with tempfile.TemporaryDirectory(prefix="casa_photoreal_") as place:
        folder = Path(place)
        text = json.dumps({**job, **asdict(frame), "views": [asdict(view) for view in views]})
        (folder / "job.json").write_text(text, encoding="utf-8")
        line, around = system.command(program, _SCRIPT, str(folder)), system.environment(folder)
        done = subprocess.run(line, cwd=folder, env=around, capture_output=True, check=False)
        told = folder / "told.json"
        if done.returncode or not told.is_file():
            words = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
            why = words[0] if words else f"it ended with {done.returncode}"
            raise NoPathTracer(f"Blender ({program}) failed: {why}")
        for view in json.loads(told.read_text(encoding="utf-8"))["views"]:
            pixels = np.asarray(Image.open(io.BytesIO((folder / f"{view['name']}.png").read_bytes())).convert("RGB"))
            yield Still(view["name"], pixels, float(view["seconds"]))


BLACK = 2  # 8-bit value; the tone curve gives anything that some light reaches more
FIREFLY_STEP = 100  # 8-bit brightness of a pixel above all but one of its 24 neighbours, and above their median


@dataclass(frozen=True)
class PictureFaults:
    """Numbers of pixels that no light has reached, and that are far brighter than all that is round them."""

    black: int
    fireflies: int

    def __bool__(self) -> bool:
        """True if there are any."""
        return bool(self.black or self.fireflies)


def picture_faults(pixels: Pixels) -> PictureFaults:
    """Count the faults of a (height, width, 3) picture."""
    brightest = pixels.max(axis=2).astype(np.int16)
    black = int((brightest < BLACK).sum())
    # The third brightest of 5 x 5: a firefly and its fringe are two of them.
    others, middle = rank_filter(brightest, rank=-3, size=5), median_filter(brightest, size=5)
    firefly = (brightest - others > FIREFLY_STEP) & (brightest - middle > FIREFLY_STEP)
    return PictureFaults(black, int(firefly.sum()))
