"""Controls with their features and their true types, of drawn scenes and of cases of the articulation benchmark."""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.articulate.cases.fuse import fused
from benchmarks.articulate.cases.labelled import AXES, LabelledMesh
from benchmarks.articulate.cases.plain.draw import draw
from benchmarks.train.control_cases.scenes import KEY, KNOB, NEITHER, draw_scene
from casa_assets.articulate.controls.classify import control_features
from casa_assets.articulate.controls.controls import Control, find_controls
from casa_assets.articulate.controls.levers_and_buttons import find_levers
from casa_assets.articulate.frame import given_frame
from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.segment.fragments import MeasuredFragments, measure_fragments, render_sides
from casa_assets.articulate.segment.orthographic import FRONT, TOP
from casa_assets.articulate.segment.segmentations import segmentations
from casa_assets.articulate.segment.shell_segments import fragment_mesh
from casa_assets.articulate.segment.welded_mesh import weld_triangles

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# A control has a type where at least this share of its surface is of that type; of less nothing is learned.
MIN_SHARE = 0.6
# A part whose type is not scored teaches nothing, but for these, which are seen on the top and never turned or pressed.
# Least cosine between the axis of a control and the direction out of the side that it is on.
MIN_ALONG = 0.7
SKIP, NO_CONTROLS = -1, frozenset({"burner", "wheel"})


@dataclass
class Samples:
    """The controls of one side of one object.

    Attributes:
        features: (N, K). types: (N,) NEITHER, KNOB, KEY, or SKIP. groups: (N,) number of the group within the side.
        today: (N,) type by the rule that looks at each control alone.
        source: who made the object: nothing of a source is learned where it is judged.
    """

    name: str
    source: str
    features: Floats
    types: Ints
    groups: Ints
    controls: list[Control]


def samples_of(
    name: str, source: str, measured: MeasuredFragments, face_types: Mapping[int, Ints]
) -> Iterator[Samples]:
    """Look at the front and the top of an object.

    Args:
        face_types: by side, the (F,) types of faces: what is turned or pressed from there.
    """
    panels = find_panels(measured)
    rectangles = [(p.lower[:2], p.upper[:2]) for p in panels]
    front = find_controls(measured, FRONT, [f for p in panels for f in p.members])
    levers, front = find_levers(measured, front)
    gone = [f for v in levers for f in v.control.fragments]
    for side, controls, plates in ((FRONT, front, rectangles), (TOP, find_controls(measured, TOP, gone), [])):
        if not controls:
            continue
        features, groups = control_features(measured, side, controls, plates)
        number = np.zeros(len(controls), dtype=np.int64)
        for k, group in enumerate(groups):
            number[list(group.members)] = k
        types = np.array([_type(measured, c, face_types[side]) for c in controls])
        yield Samples(f"{name}.{side}", source, features, types, number, list(controls))


def _type(measured: MeasuredFragments, control: Control, face_types: Ints) -> int:
    faces = measured.faces_of(control.fragments)
    area = measured.mesh.areas[faces]
    for kind in (NEITHER, KNOB, KEY):
        if area[face_types[faces] == kind].sum() >= MIN_SHARE * area.sum():
            return kind
    return SKIP


def scene_samples(seed: int, index: int) -> list[Samples]:
    """The controls of a drawn scene."""
    kind, points, faces, labels = draw_scene(seed, index)
    mesh = weld_triangles(points, faces)
    mesh = mesh.in_frame(given_frame(mesh, (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)))
    right, wrong = (TOP, FRONT) if kind == "hob" else (FRONT, TOP)
    sides = {right: labels, wrong: np.full_like(labels, NEITHER)}
    return list(samples_of(f"{kind}_{index}", "scenes", measure_fragments(mesh, mesh.fragment_labels), sides))


def fused_scene_samples(seed: int, index: int) -> list[Samples]:
    """The controls of a drawn scene as one shell of cubes."""
    kind, points, faces, labels = draw_scene(seed, index)
    parts = [{"id": KNOB, "type": "knob", "scored": True}, {"id": KEY, "type": "button", "scored": True}]
    for part in parts:
        part["joint"] = {"axis": [0.0, 0.0, 1.0] if kind == "hob" else [0.0, 1.0, 0.0]}
    truth = {"name": f"{kind}_{index}.fused", "up": "+Z", "front": "-Y", "parts": parts}
    shell = fused(LabelledMesh(points, faces, labels, np.zeros(len(faces), dtype=bool), truth))[1]
    return _labelled("scenes", truth, shell.points, shell.faces, shell.part)


def drawn_samples(kind: str, seed: int, index: int, as_shell: bool = False) -> list[Samples]:
    """The controls of a plain drawing, whose bodies, doors and interiors are more like real ones.

    Args:
        as_shell: as one shell of cubes.
    """
    mesh = draw(kind, seed, index)
    if as_shell:
        mesh = fused(mesh)[1]
        mesh.truth["name"] = f"{mesh.truth['name']}.fused"
    return _labelled("drawn", mesh.truth, mesh.points, mesh.faces, mesh.part)


def case_samples(score: ModuleType, name: str, source: str, variant: str) -> list[Samples]:
    """The controls of a case of the benchmark, in its true frame."""
    case: Any = score.Case(f"{score.CASES}/{name}", variant)
    truth = {**case.J, "name": f"{name}.{variant}", "parts": case.parts}
    return _labelled(source, truth, case.V, case.F, case.lab)


def _labelled(source: str, truth: dict[str, Any], points: Floats, faces: Ints, part: Ints) -> list[Samples]:
    """The controls of a mesh in its true frame, split in each way.

    Args:
        truth: as in gt.json. part: (F,) identifier of the part of each face.
    """
    mesh = weld_triangles(points, faces)
    up, front = (AXES[axis] if isinstance(axis, str) else axis for axis in (truth["up"], truth.get("front") or "-Y"))
    frame = given_frame(mesh, up, front)
    placed = mesh.in_frame(frame)
    sides = {}
    for side, along in ((FRONT, 1), (TOP, 2)):
        table = {p["id"]: _part_type(p, frame.rotation[along]) for p in truth["parts"]}
        sides[side] = np.array([table.get(int(k), NEITHER) for k in part])
    images = render_sides(placed)
    found = []
    for way, split in segmentations(placed).items():
        pieces = fragment_mesh(placed, split)
        measured = measure_fragments(placed, pieces.labels, images=images)
        found += samples_of(f"{truth['name']}.{way}", source, measured, sides)
    return found


def _part_type(part: dict[str, Any], outward: Floats) -> int:
    """What a part is from a side: what is turned or pressed along another direction is no control of it."""
    kind = {"knob": KNOB, "button": KEY}.get(part["type"], NEITHER)
    if not part["scored"] and part["type"] not in NO_CONTROLS:
        return SKIP
    axis = np.array((part.get("joint") or {}).get("axis") or outward, dtype=np.float64)
    along = abs(float(axis @ outward)) / max(float(np.linalg.norm(axis)), 1e-9)
    return kind if along >= MIN_ALONG else NEITHER


def cached(path: Path, make: Any) -> Any:
    """What `make` gives, stored in a file."""
    if not path.exists():
        found = make()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(pickle.dumps(found))
        return found
    return pickle.loads(path.read_bytes())
