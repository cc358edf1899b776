"""The samples, one function each: -> file name and bytes of every file of it. Built in metres, z up, then spoilt."""

from __future__ import annotations

import json

import numpy as np

from formats import GLTF_FROM_Z_UP, Look, dae, exact, glb, gltf, mtl, obj, ply, stl
from paint import canvas, cereal_front, noise, over, png, ramp, word
from shapes import Array, Surface, joined, lathe, loft, quad, rounded, sheet, slab, tube, wall

Made = dict[str, bytes]
INCH_M = 0.0254


def apple() -> Made:
    """Nothing is wrong with it."""
    t = np.linspace(0.0, np.pi, 30)
    r = 0.038 * np.sin(t) * (1 - 0.08 * np.cos(t))
    r[0] = r[-1] = 0.0
    dimple = np.where(t > np.pi / 2, -0.013 * np.exp(-((r / 0.012) ** 2)), 0.006 * np.exp(-((r / 0.010) ** 2)))
    body = lathe(np.stack([r, 0.035 - 0.035 * np.cos(t) + dimple], axis=1), segments=40)
    angle = np.arctan2(body.vertices[:, 1], body.vertices[:, 0])
    lobes = 1 + 0.02 * np.cos(5 * angle) * (1 - body.uv[:, 1]) ** 2
    body = Surface(body.vertices * np.stack([lobes, lobes, np.ones_like(lobes)], axis=1), body.faces, body.uv)
    k = np.linspace(0.0, 1.0, 7)
    stem = np.stack([0.006 * k**2, 0 * k, 0.052 + 0.026 * k], axis=1)
    u, v = canvas(256, 160)
    streaks = noise(u, v, (60, 3), 1) * 0.6 + noise(u, v, (17, 4), 2) * 0.4
    warmth = (0.25 + 1.5 * streaks - 1.7 * np.maximum(v - 0.62, 0) - 1.2 * np.maximum(0.25 - v, 0)).clip(0, 1)
    skin = ramp(warmth, (0.86, 0.74, 0.30), (0.87, 0.42, 0.20), (0.74, 0.12, 0.13), (0.52, 0.04, 0.09))
    skin = over(skin, 0.7 * (noise(u, v, (90, 60), 3) > 0.965), (0.93, 0.80, 0.55))
    parts = [
        (_y_up(body), Look("skin", roughness=0.35, image=png(skin))),
        (_y_up(tube(stem, np.linspace([0.0013, 0.0013], [0.0022, 0.0020], 7), (0, 1, 0), 8)), Look("stem", _BARK)),
    ]
    return {"apple.glb": glb(parts, "apple")}


def mug() -> Made:
    """In millimetres, which OBJ cannot say."""
    outside = rounded([(0, 0), (0.037, 0), (0.041, 0.095)], 0.005)
    body = lathe(wall(np.concatenate([outside[:-1], np.linspace(outside[-2], outside[-1], 9)[1:]]), 0.0035))
    t = np.linspace(np.pi / 2, -np.pi / 2, 17)
    arch = np.stack([0.0375 + 0.030 * np.cos(t), 0 * t, 0.050 + 0.027 * np.sin(t)], axis=1)
    handle = tube(arch, np.full((17, 2), [0.0065, 0.0038]), (0, 1, 0))
    handle = Surface(handle.vertices, handle.faces, np.full_like(handle.uv, [0.5, 0.2]))
    u, v = canvas(256, 256)
    glaze = ramp(0.5 + 0.25 * noise(u, v, (9, 9), 4), (0.10, 0.36, 0.42), (0.16, 0.55, 0.58))
    glaze = over(glaze, v > 0.5, (0.95, 0.92, 0.85))
    glaze = over(glaze, ((v > 0.30) & (v < 0.42)), (0.95, 0.92, 0.85))
    dots = (((u * 12) % 1 - 0.5) / 0.24) ** 2 + ((v - 0.36) / 0.0193) ** 2 < 1
    glaze = over(glaze, dots, _RED)
    look = Look("glaze", image_name="mug_glaze.png")
    millimetres = joined(_y_up(body), _y_up(handle)).turned(1000 * np.eye(3))
    files = {"mug.obj": obj([(millimetres, look)], "mug.mtl"), "mug.mtl": mtl([look])}
    return {**files, "mug_glaze.png": png(glaze)}


def bowl() -> Made:
    """In centimetres, which glTF does not allow, and of two shells, one inside the other."""
    s = np.linspace(0.0, np.pi / 2, 16)
    flank = np.stack([0.034 + 0.041 * np.sin(s), 0.004 + 0.061 * (1 - np.cos(s))], axis=1)
    curve = np.concatenate([[[0, 0], [0.016, 0], [0.030, 0], [0.033, 0.001]], flank])
    shell, liner = lathe(wall(curve, 0.0025)), lathe(wall(curve * [0.945, 0.94] + [0, 0.0035], 0.0015))
    looks = Look("outside", (0.05, 0.12, 0.33), roughness=0.3), Look("inside", (0.86, 0.83, 0.76), roughness=0.25)
    parts = [(_y_up(part).turned(100 * np.eye(3)), look) for part, look in zip((shell, liner), looks, strict=True)]
    return {"bowl.glb": glb(parts, "bowl")}


def wine_bottle() -> Made:
    """Stands along z where glTF says that y is up; its label is an open sheet in front of the glass."""
    outline = [(0, 0.016), (0.026, 0.003), (0.030, 0), (0.0375, 0), (0.0375, 0.195), (0.0145, 0.235), (0.0145, 0.252)]
    glass = lathe(rounded([(float(r), float(z)) for r, z in outline], 0.014, 6))
    foil = [(0.0145, 0.252), (0.0145, 0.284), (0.0158, 0.285), (0.0158, 0.293), (0.0145, 0.300), (0, 0.300)]
    capsule = lathe(rounded([(float(r), float(z)) for r, z in foil], 0.001, 2))
    label = lathe(np.array([[0.0378, 0.060], [0.0378, 0.145]]), 24, start=np.radians(-165), turn=np.radians(150))
    u, v = canvas(256, 224)
    paper = ramp(noise(u, v, (24, 24), 5), (0.93, 0.89, 0.79), (0.97, 0.95, 0.88))
    edge = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v))
    paper = over(paper, ((edge > 0.04) & (edge < 0.055)), (0.62, 0.48, 0.20))
    paper = over(paper, word(u, v, "VINO", (0.22, 0.58, 0.78, 0.80)), (0.30, 0.05, 0.10))
    hills = 0.25 + 0.08 * np.sin(7 * u) + 0.04 * np.sin(17 * u + 1)
    paper = over(paper, ((v < hills) & (edge > 0.07)), (0.42, 0.12, 0.16))
    parts = [
        (glass, Look("glass", (0.02, 0.07, 0.03), roughness=0.1)),
        (capsule, Look("foil", (0.28, 0.02, 0.05), 0.8, 0.35)),
        (label, Look("label", image=png(paper), roughness=0.8)),
    ]
    return {"wine_bottle.glb": glb(parts, "wine_bottle")}


def knife() -> Made:
    """A speck floats almost a metre away from it."""
    x = np.concatenate([np.linspace(0, 0.15, 8), 0.2 - 0.05 * np.linspace(1, 0, 14)[1:] ** 2])
    spine = 0.020 - 0.010 * (x / 0.2) ** 3
    edge = np.minimum(spine - 0.0008, -0.025 + 0.034 * (x / 0.2) ** 4)
    thick = np.linspace(0.0012, 0.0005, len(x))
    rows = [
        [(a, e, -0.0001), (a, s, -t), (a, s, t), (a, e, 0.0001)]
        for a, e, s, t in zip(x, edge, spine, thick, strict=True)
    ]
    k = np.linspace(0.0, 1.0, 15)
    grip = np.stack([0.002 - 0.122 * k, 0.006 - 0.004 * k**2, 0 * k], axis=1)
    swell = np.stack([0.0125 - 0.003 * np.sin(np.pi * k) + 0.002 * k**4, 0.0088 - 0.001 * k], axis=1)
    bolster = tube(np.array([[0.012, 0.004, 0], [0.006, 0.004, 0], [-0.006, 0.005, 0]]), _BOLSTER, (0, 1, 0), 20)
    speck = loft(np.array([[(0, 0, 0), (0.0006, 0, 0), (0, 0.0006, 0)], [(0, 0, 0.0006)] * 3])).moved((0.9, 0.35, 0.2))
    return {"knife.stl": stl(joined(loft(np.array(rows)), tube(grip, swell, (0, 1, 0), 20), bolster, speck))}


def cutting_board() -> Made:
    """Its material library names a picture that is not there."""
    outer = _rounded_rectangle(0.36, 0.24, 0.028)
    ray = outer - [-0.150, 0.0]
    hole = [-0.150, 0.0] + 0.011 * ray / np.linalg.norm(ray, axis=1, keepdims=True)
    board = slab(outer, hole, (0.0, 0.018), 0.003)
    look = Look("wood", (0.62, 0.40, 0.22), image_name="textures/walnut_4k.png")
    return {"cutting_board.obj": obj([(_y_up(board), look)], "cutting_board.mtl"), "cutting_board.mtl": mtl([look])}


def milk_carton() -> Made:
    """Its only colours are those of its vertices."""
    level = [(0.035, 0.035, z) for z in np.linspace(0, 0.195, 40)]
    level += [(0.035, 0.035 - 0.033 * t, 0.195 + 0.034 * t) for t in np.linspace(0, 1, 7)[1:]]
    level += [(0.035, 0.002, z) for z in (0.236, 0.246)]
    turn = [(-1, -1, 2, 0), (1, -1, 0, 2), (1, 1, -2, 0), (-1, 1, 0, -2)]
    square = np.array([(x + a * t, y + b * t) for x, y, a, b in turn for t in np.linspace(0, 1, 13)])
    rows = np.array([np.column_stack([square * [a, b], np.full(len(square), z)]) for a, b, z in level])
    body = sheet(np.concatenate([rows, rows[:, :1]], axis=1), np.linspace(0, 1, len(rows)))
    lids = [quad(np.array(c), np.array(r), np.array(u)) for c, r, u in _MILK_LIDS]
    slope = np.array([0.0, -0.034, 0.033]) / np.hypot(0.034, 0.033)
    tilt = np.stack([[1.0, 0.0, 0.0], np.cross(slope, [1.0, 0.0, 0.0]), slope], axis=1)
    cap = lathe(rounded([(0, -0.004), (0.0135, -0.004), (0.0130, 0.011), (0, 0.011)], 0.001, 2), 28)
    cap = cap.turned(tilt).moved((0.0, -0.0185, 0.212))
    milk = joined(body, *lids, cap)
    x, y, z = milk.vertices.T
    u = np.arctan2(y, x) / (2 * np.pi) + 0.5
    spots = (noise(u, z / 0.1, (7, 4), 11) > 0.60) & (z > 0.075) & (z < 0.185)
    colors = np.full((len(x), 3), [246, 245, 240])
    colors[spots] = [38, 36, 40]
    colors[z < 0.055 + 0.010 * np.sin(4 * np.pi * u)] = [92, 168, 78]
    colors[z > 0.194] = [40, 96, 182]
    colors[len(x) - len(cap.vertices) :] = [214, 45, 48]
    return {"milk_carton.ply": ply(milk, colors.astype(np.uint8))}


def frying_pan() -> Made:
    """Its node mirrors it, so every triangle of the file has to be turned round."""
    curve = rounded([(0, 0), (0.10, 0), (0.13, 0.048)], 0.015, 6)
    curve = np.concatenate([np.linspace(curve[0], curve[1], 8), curve[2:]])
    path = np.linspace([0.1235, 0, 0.040], [0.305, 0, 0.072], 14)
    k = np.linspace(0, 1, 14)
    grip = tube(
        path, np.stack([0.013 - 0.004 * np.sin(np.pi * k) + 0.003 * k**2, 0.008 + 0.002 * k], axis=1), (0, 1, 0)
    )
    u, v = canvas(256, 256)
    coat = ramp(noise(u, v, (64, 128), 7), (0.10, 0.10, 0.11), (0.17, 0.17, 0.18))
    coat = over(coat, 0.8 * (noise(u, v, (128, 200), 8) > 0.93), (0.55, 0.55, 0.56))
    coat = over(coat, v < 0.5, ramp(noise(u, v, (5, 9), 9), (0.62, 0.10, 0.07), (0.74, 0.14, 0.09)))
    coat = over(coat, v < 0.30, (0.70, 0.70, 0.72))
    mirror = np.diag([-1.0, 1.0, 1.0])
    parts = [
        (
            _y_up(lathe(wall(curve, 0.003))).turned(mirror),
            Look("coating", roughness=0.5, image=png(coat), image_name=_PAN),
        ),
        (_y_up(grip).turned(mirror), Look("grip", (0.015, 0.015, 0.017), roughness=0.7)),
    ]
    document, blob = gltf(parts, "frying_pan", scale=(-1.0, 1.0, 1.0))
    document["buffers"][0]["uri"] = "frying_pan.bin"
    text = json.dumps(document, indent=1) + "\n"
    return {"frying_pan.gltf": text.encode(), "frying_pan.bin": blob, _PAN: png(coat)}


def spoon() -> Made:
    """In inches and z up, both of which the file says."""
    s = np.linspace(0.0, 1.0, 44)
    x = 0.19 * s
    dish = np.sqrt(np.clip(1 - ((s - 0.17) / 0.172) ** 2, 1e-4, 1))
    half = np.where(
        s < 0.17, 0.021 * dish, np.maximum(0.021 * dish * (s < 0.342), 0.0032 + 0.0045 * np.clip(s - 0.4, 0, 1))
    )
    half[-3:] *= [0.93, 0.75, 0.35]
    deep = 0.008 * np.clip(1 - ((s - 0.17) / 0.19) ** 2, 0, 1)
    bow = 0.010 + 0.014 * np.sin(np.pi * np.clip((s - 0.30) / 0.7, 0, 1)) ** 2
    a = 2 * np.pi * np.arange(20) / 20
    y = half[:, None] * np.cos(a)
    z = bow[:, None] + 0.0009 * np.sin(a) + deep[:, None] * (np.cos(a) ** 2 - 1)
    metal = loft(np.stack([np.broadcast_to(x[:, None], y.shape), y, z], axis=2))
    inches = metal.turned(np.eye(3) / INCH_M)
    return {"spoon.dae": dae(inches, Look("steel", (0.62, 0.62, 0.64)), ("inch", INCH_M), "Z_UP")}


def cereal_box() -> Made:
    """Six sheets that do not share a vertex, in four materials."""
    w, d, h = 0.19, 0.06, 0.29
    x, y, z = np.array([w, 0, 0]), np.array([0, d, 0]), np.array([0, 0, h])
    corner = np.array([-w / 2, -d / 2, 0.0])
    sides = joined(quad(corner + x, y, z), quad(corner + y, -y, z))
    flaps = joined(quad(corner + z, x, y), quad(corner + y, x, -y))
    parts = [
        (_y_up(quad(corner, x, z)), Look("front", image=png(cereal_front()), roughness=0.45)),
        (_y_up(quad(corner + x + y, -x, z)), Look("back", (0.88, 0.62, 0.18), roughness=0.45)),
        (_y_up(sides), Look("sides", (0.80, 0.24, 0.07), roughness=0.45)),
        (_y_up(flaps), Look("cardboard", (0.45, 0.33, 0.21), roughness=0.9)),
    ]
    return {"cereal_box.glb": glb(parts, "cereal_box")}


def teapot() -> Made:
    """Every triangle faces inwards."""
    t = np.linspace(0, 1, 22)
    belly = np.stack([0.045 + 0.033 * np.sin(np.pi * t**0.9), 0.004 + 0.096 * t], axis=1)
    body = lathe(np.concatenate([[[0, 0], [0.040, 0], [0.045, 0.002]], belly, [[0.040, 0.102], [0, 0.102]]]))
    lid = [(0, 0.098), (0.043, 0.098), (0.044, 0.103), (0.030, 0.112), (0.007, 0.117), (0.005, 0.122), (0.010, 0.127)]
    top = lathe(rounded([*lid, (0.008, 0.134), (0, 0.135)], 0.003, 3))
    k = np.linspace(0, 1, 12)
    spout = np.stack([0.062 + 0.066 * k, 0 * k, 0.038 + 0.067 * k**1.6], axis=1)
    a = np.linspace(np.radians(98), np.radians(262), 18)
    arch = np.stack([-0.066 + 0.048 * np.cos(a), 0 * a, 0.054 + 0.033 * np.sin(a)], axis=1)
    parts = [body, top, tube(spout, np.linspace([0.017, 0.019], [0.007, 0.008], 12), (0, 1, 0))]
    parts.append(tube(arch, np.full((18, 2), [0.0075, 0.0048]), (0, 1, 0)))
    u, v = canvas(256, 160)
    china = ramp(noise(u, v, (20, 14), 12), (0.93, 0.94, 0.95), (0.98, 0.98, 0.97))
    x, y = (u * 8) % 1 - 0.5, (v - 0.55) * 4.2
    petals = np.hypot(x, y) * (1 + 0.3 * np.cos(6 * np.arctan2(y, x)))
    china = over(china, petals < 0.33, (0.13, 0.25, 0.60))
    china = over(china, petals < 0.09, (0.93, 0.78, 0.25))
    china = over(china, (np.abs(v - 0.36) < 0.012) | (np.abs(v - 0.74) < 0.012), (0.13, 0.25, 0.60))
    look = Look("china", roughness=0.2, image=png(china))
    return {"teapot.glb": glb([(_y_up(joined(*parts)).inside_out(), look)], "teapot")}


def banana() -> Made:
    """Only its first half arrived."""
    a = np.linspace(np.radians(200), np.radians(340), 24)
    path = np.stack([0.085 * np.cos(a), 0 * a, 0.1 + 0.085 * np.sin(a)], axis=1)
    half = 0.004 + 0.013 * np.clip(np.sin(np.linspace(0.05, np.pi - 0.05, 24)), 0, 1) ** 0.6
    whole = glb(
        [(_y_up(tube(path, np.stack([half, half], axis=1), (0, 1, 0), 10)), Look("peel", (0.9, 0.7, 0.1)))], "banana"
    )
    return {"banana.glb": whole[: len(whole) // 2]}


SAMPLES = (
    apple,
    banana,
    bowl,
    cereal_box,
    cutting_board,
    frying_pan,
    knife,
    milk_carton,
    mug,
    spoon,
    teapot,
    wine_bottle,
)

_BARK = (0.16, 0.09, 0.04)
_RED = (0.80, 0.25, 0.16)
_PAN = "frying_pan_coating.png"
_BOLSTER = np.array([[0.010, 0.0030], [0.0130, 0.0060], [0.0130, 0.0092]])
_MILK_LIDS = (
    ((-0.035, 0.035, 0.0), (0.07, 0.0, 0.0), (0.0, -0.07, 0.0)),
    ((-0.035, -0.002, 0.246), (0.07, 0.0, 0.0), (0.0, 0.004, 0.0)),
)


def _y_up(surface: Surface) -> Surface:
    return surface.turned(GLTF_FROM_Z_UP)


def _rounded_rectangle(width: float, depth: float, radius: float) -> Array:
    """(N, 2) outline, counter-clockwise, metres."""
    points = []
    for n, (sx, sy) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        centre = np.array([sx * (width / 2 - radius), sy * (depth / 2 - radius)])
        angle = np.radians(np.linspace(90 * n, 90 * n + 90, 9))
        points.append(centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    loop = np.concatenate(points)
    after = np.roll(loop, -1, axis=0)
    fine = [
        np.linspace(p, q, 9)[:-1] if np.linalg.norm(q - p) > 0.05 else p[None] for p, q in zip(loop, after, strict=True)
    ]
    return exact(np.concatenate(fine))
