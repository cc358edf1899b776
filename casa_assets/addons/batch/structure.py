"""Structure of a model that an engine cannot vary between worlds: trees of joints, kinds of shapes, contact pairs."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from casa_assets.ext.arrays import Floats, linear_from_srgb_array, srgb_from_linear
from casa_assets.ext.mjcf import BATCH_DEFAULT, BATCH_FIRST_MEETING, BATCH_LAST_MEETING, BATCH_THINGS

# Corners of the boxes around what a placement takes up, and of its inside: `scene.json` has them.
_BOUNDS = ("__ext_p0", "__ext_px", "__ext_py", "__ext_pz", "__int_p0", "__int_px", "__int_py", "__int_pz")
_COLOR = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)


class GeomKind(NamedTuple):
    """Properties that two geoms must share to take turns in one place of a model."""

    shape: int
    contype: int
    conaffinity: int
    condim: int
    priority: int
    group: int


class SiteKind(NamedTuple):
    """The same of two sites."""

    shape: int
    group: int
    size: tuple[float, ...]


class JointKind(NamedTuple):
    """The same of two joints."""

    shape: int
    limited: bool
    has_friction: bool


class BodyKind(NamedTuple):
    """The same of two bodies that move: joints in their order, sorted kinds of children, and if any geom touches."""

    joints: tuple[JointKind, ...]
    touches: bool
    children: tuple[BodyKind, ...]


class UnitKind(NamedTuple):
    """The same of two units: kinds of the roots of its trees, and which of its bodies, by position, never collide."""

    trees: tuple[BodyKind, ...]
    exclusions: tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Unit:
    """Trees of bodies of which some never collide, mostly one, such as a door. `bodies`: ids, parents first."""

    kind: UnitKind
    bodies: tuple[int, ...]


@dataclass(frozen=True)
class Structure:
    """Units of what moves; body -> kind -> its geoms that touch, largest first, and its sites. Body 0 is the world."""

    units: tuple[Unit, ...]
    geoms: Mapping[int, Mapping[GeomKind, Sequence[int]]]
    sites: Mapping[int, Mapping[SiteKind, Sequence[int]]]


def structure_of(model: mujoco.MjModel) -> Structure:
    """Structure of a compiled batch form; what does not move is of the world.

    Raises ValueError: it has tendons, equalities or bodies without joints, which batch forms do not have.
    """
    for name in ("ntendon", "neq", "nu", "nflex", "npair"):
        if getattr(model, name):
            raise ValueError(f"the model has {getattr(model, name)} of {name}; a batch form has none")
    if (model.body_jntnum[1:] == 0).any():
        raise ValueError(f"body {model.body(1 + int(np.argmin(model.body_jntnum[1:]))).name!r} has no joint")
    bits = _meeting_bits(model)
    geoms: dict[int, dict[GeomKind, list[int]]] = defaultdict(lambda: defaultdict(list))
    for geom in sorted(range(model.ngeom), key=lambda number: -float(model.geom_rbound[number])):
        if model.geom_contype[geom] | model.geom_conaffinity[geom]:
            contype, conaffinity = int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])
            if conaffinity in bits:
                contype, conaffinity = BATCH_DEFAULT | BATCH_THINGS | bits[conaffinity], bits[conaffinity]
            rest = (int(model.geom_condim[geom]), int(model.geom_priority[geom]), int(model.geom_group[geom]))
            kind = GeomKind(int(model.geom_type[geom]), contype, conaffinity, *rest)
            geoms[int(model.geom_bodyid[geom])][kind].append(geom)
    sites: dict[int, dict[SiteKind, list[int]]] = defaultdict(lambda: defaultdict(list))
    for site in range(model.nsite):
        if not str(model.site(site).name).endswith(_BOUNDS):
            size = tuple(float(number) for number in model.site_size[site])
            of_site = SiteKind(int(model.site_type[site]), int(model.site_group[site]), size)
            sites[int(model.site_bodyid[site])][of_site].append(site)
    return Structure(tuple(_units(model, geoms)), geoms, sites)


def _meeting_bits(model: mujoco.MjModel) -> dict[int, int]:
    """Bit of a set of parts that can meet -> bit of it in every kitchen: that of the most parts is the first."""
    first = 1 << BATCH_FIRST_MEETING
    found: Counter[int] = Counter()
    for body in range(1, model.nbody):
        own = slice(int(model.body_geomadr[body]), int(model.body_geomadr[body]) + int(model.body_geomnum[body]))
        found.update({bit for bit in map(int, model.geom_conaffinity[own]) if bit >= first})
    ranked = sorted(found, key=lambda bit: (-found[bit], bit))
    return {bit: 1 << min(BATCH_FIRST_MEETING + rank, BATCH_LAST_MEETING) for rank, bit in enumerate(ranked)}


def _units(model: mujoco.MjModel, geoms: Mapping[int, object]) -> Iterator[Unit]:
    """The units of a model, in the order of their first bodies."""
    excluded = {(int(pair) >> 16, int(pair) & 0xFFFF) for pair in model.exclude_signature}
    leader = {body: int(model.body_rootid[body]) for body in range(1, model.nbody)}
    for first, second in excluded:
        if first and second:  # their trees become one unit
            old, new = leader[second], leader[first]
            leader = {body: new if current == old else current for body, current in leader.items()}
    trees: dict[int, list[int]] = defaultdict(list)
    children: dict[int, list[int]] = defaultdict(list)
    for body in range(1, model.nbody):
        children[int(model.body_parentid[body])].append(body)
        if model.body_parentid[body] == 0:
            trees[leader[body]].append(body)

    def kind(body: int) -> BodyKind:
        first, joints = int(model.body_jntadr[body]), []
        for joint in range(first, first + int(model.body_jntnum[body])):
            friction = float(model.dof_frictionloss[model.jnt_dofadr[joint]])
            joints.append(JointKind(int(model.jnt_type[joint]), bool(model.jnt_limited[joint]), friction > 0))
        return BodyKind(tuple(joints), body in geoms, tuple(sorted(kind(child) for child in children[body])))

    def ordered(bodies: Iterable[int]) -> Iterator[int]:
        for body in sorted(bodies, key=lambda one: (kind(one), one)):
            yield body
            yield from ordered(children[body])

    for roots in trees.values():
        bodies = tuple(ordered(roots))
        place = {0: -1, **{body: number for number, body in enumerate(bodies)}}
        pairs = [(place[a], place[b]) for a, b in excluded if a in place and b in place and (a or b)]
        pairs = [pair for pair in pairs if max(pair) >= 0]
        exclusions = tuple(sorted((min(pair), max(pair)) for pair in pairs))
        yield Unit(UnitKind(tuple(sorted(kind(root) for root in roots)), exclusions), bodies)


class Picture(NamedTuple):
    """A picture of a compiled model, (height, width, channels), by a name that is the same in all kitchens."""

    name: str
    pixels: NDArray[np.uint8]


class PaintedMaterial(NamedTuple):
    """Values of an MjsMaterial, equal in two kitchens if the material is the same, and its picture or None."""

    values: Mapping[str, Any]
    picture: Picture | None


def materials_of(model: mujoco.MjModel) -> dict[str, PaintedMaterial]:
    """Materials of a model by their names."""
    found = {}
    for number in range(model.nmat):
        name, texture = str(model.material(number).name), int(model.mat_texid[number, _COLOR])
        gloss = ("emission", "specular", "shininess", "metallic", "roughness")
        values: dict[str, Any] = {field: float(getattr(model, f"mat_{field}")[number]) for field in gloss}
        values |= {"name": name, "rgba": model.mat_rgba[number], "texrepeat": model.mat_texrepeat[number]}
        values["texuniform"] = bool(model.mat_texuniform[number])
        picture = None
        if texture >= 0:
            shape = tuple(int(getattr(model, f"tex_{side}")[texture]) for side in ("height", "width", "nchannel"))
            first = int(model.tex_adr[texture])
            pixels = np.array(model.tex_data[first : first + int(np.prod(shape))]).reshape(shape)
            picture = Picture(str(model.tex(texture).name), pixels)
        found[name] = PaintedMaterial(values, picture)
    return found


def add_materials(spec: mujoco.MjSpec, materials: Iterable[PaintedMaterial]) -> None:
    """Add materials and their pictures to a spec that has none of them."""
    known: set[str] = set()
    for material in materials:
        added = spec.add_material(**material.values)
        if material.picture is None:
            continue
        name, pixels = material.picture
        added.textures[_COLOR] = name
        if name not in known:
            height, width, channels = pixels.shape
            texture = spec.add_texture(
                name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, width=width, height=height, nchannel=channels
            )
            texture.data = pixels.tobytes()
            known.add(name)


def plain_colors(model: mujoco.MjModel) -> Floats:
    """(ngeom, 4) colours of geoms as they look from far: those with a picture have its mean, as linear light."""
    colors = np.array(model.geom_rgba, dtype=np.float64)
    for number, material in enumerate(materials_of(model).values()):
        color = np.array(material.values["rgba"], dtype=np.float64)
        if material.picture is not None:
            pixels = material.picture.pixels.reshape(-1, material.picture.pixels.shape[2])[:, :3] / 255
            color[:3] *= [srgb_from_linear(float(value)) for value in linear_from_srgb_array(pixels).mean(axis=0)]
        colors[model.geom_matid == number] = color
    return colors
