"""A polygon of very many corners costs memory in proportion to its corners, in every format that has raw_parts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from casa_assets.errors import Rejected
from casa_assets.formats.read import load, raw_parts
from casa_assets.formats.read import obj as obj_reader
from casa_assets.ingest.gaps import MAX_PAIRS, _within
from casa_assets.model import rejection_codes
from casa_assets.model.source import Bundle
from tests.support.mesh.mesh_files import LIMITS

CORNERS = 60_000
# What reading and cleaning such a file may take on top of the program itself. It took 0.8 GB, and four times as much
# for twice the corners.
MORE_BYTES = 400_000_000
# Reads and cleans a file in a process that may not grow by more than it says.
CHILD = """
import resource, sys
from pathlib import Path
from casa_assets import registry
from casa_assets.ingest.clean import clean
from casa_assets.formats.read import load
from casa_assets.ingest.sources.discover import collect, discover

now = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
most = now + int(sys.argv[2])
resource.setrlimit(resource.RLIMIT_AS, (most, most))
limits = registry.load().limits
(found,) = discover([Path(sys.argv[1])])
raw = load(collect(found, limits), limits)
print(sum(len(part.mesh.faces) for part in raw.parts))
if sys.argv[3] == "cleaned":  # what comes after reading is the same for all
    clean(raw)
"""


def rim(corners: int) -> np.ndarray:
    """(n, 3) corners of a flat polygon of 0.1 m radius, then the tip of a cone over it."""
    turn = np.linspace(0.0, 2 * np.pi, corners, endpoint=False)
    points = np.column_stack((0.1 * np.cos(turn), 0.1 * np.sin(turn), np.zeros(corners)))
    return np.vstack((points, [(0.0, 0.0, 0.1)]))


def obj(corners: int) -> bytes:
    rows = [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in rim(corners)]
    rows += ["f " + " ".join(map(str, range(1, corners + 1))), f"f 1 2 {corners + 1}"]
    return ("\n".join(rows) + "\n").encode()


def ply(corners: int) -> bytes:
    head = f"ply\nformat ascii 1.0\nelement vertex {corners + 1}\n"
    head += "property float x\nproperty float y\nproperty float z\n"
    head += "element face 2\nproperty list int int vertex_indices\nend_header\n"
    rows = [f"{x:.7f} {y:.7f} {z:.7f}" for x, y, z in rim(corners)]
    rows += [f"{corners} " + " ".join(map(str, range(corners))), f"3 0 1 {corners}"]
    return (head + "\n".join(rows) + "\n").encode()


def dae(corners: int) -> bytes:
    numbers = " ".join(f"{v:.7f}" for v in rim(corners).ravel())
    picks = " ".join(map(str, [*range(corners), 0, 1, corners]))
    return f"""<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="{3 * corners + 3}">{numbers}</float_array><technique_common>
<accessor source="#pa" count="{corners + 1}" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="2"><input semantic="VERTEX" source="#v" offset="0"/><vcount>{corners} 3</vcount>
<p>{picks}</p></polylist></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>""".encode()


FORMATS = {"obj": obj, "ply": ply, "dae": dae}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "step"),
    [*((suffix, "read") for suffix in FORMATS), pytest.param("obj", "cleaned", marks=pytest.mark.certify)],
)
def test_a_polygon_of_many_corners_takes_little_memory(tmp_path: Path, suffix: str, step: str) -> None:
    place = tmp_path / f"mug.{suffix}"
    place.write_bytes(FORMATS[suffix](CORNERS))
    words = [sys.executable, "-c", CHILD, str(place), str(MORE_BYTES), step]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.stdout.split(), done.returncode) == ([str(CORNERS - 1)], 0), done.stderr[-800:]


@pytest.mark.parametrize("suffix", FORMATS)
def test_triangles_are_counted_before_they_are_made(suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (obj_reader, raw_parts):
        monkeypatch.setattr(module, "triangulate", None)  # whoever calls it fails
    name = f"a.{suffix}"
    with pytest.raises(Rejected, match=f"{rejection_codes.TOO_LARGE}: .*999 triangles, more than 500"):
        load(Bundle(main=name, files={name: FORMATS[suffix](1000)}), {**LIMITS, "input_faces": 500.0})


def test_near_points_are_the_same_as_by_comparing_all() -> None:
    """Points of very different reach: those of a fine rim among those of coarse faces."""
    rng = np.random.default_rng(3)
    points = np.vstack((rng.random((400, 3)), 0.5 + 0.01 * rng.random((200, 3))))
    reach = np.concatenate((0.08 * rng.random(400), 0.002 * rng.random(190), np.zeros(10)))
    i, j = np.triu_indices(len(points), 1)
    near = np.linalg.norm(points[i] - points[j], axis=1) <= np.minimum(reach[i], reach[j])
    found = _within(points, reach)
    assert {(a, b) for a, b in found.tolist()} == set(zip(i[near].tolist(), j[near].tolist(), strict=True))
    assert 0 < len(found) == int(near.sum()) < MAX_PAIRS
