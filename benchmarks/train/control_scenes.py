"""Plain appliances and cabinets whose controls and clutter are drawn at random, each face labelled with what it is.

They stand in the frame: z up, the front faces -y, metres. They teach what groups of controls look like, not what
appliances look like: a body is a box, doors are plates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Rng = np.random.Generator

# What a face is: nothing that is pressed or turned, a knob, or a key.
NEITHER, KNOB, KEY = 0, 1, 2


@dataclass
class Scene:
    """A mesh that grows: points, triangles, and the label of each triangle."""

    points: list[Floats] = field(default_factory=list)
    faces: list[Ints] = field(default_factory=list)
    labels: list[Ints] = field(default_factory=list)
    count: int = 0

    def add(self, points: Floats, faces: Ints, label: int) -> None:
        """Add a piece."""
        self.points.append(points)
        self.faces.append(faces + self.count)
        self.labels.append(np.full(len(faces), label))
        self.count += len(points)

    def mesh(self) -> tuple[Floats, Ints, Ints]:
        """The (V, 3) points, (F, 3) triangles and (F,) labels."""
        return np.concatenate(self.points), np.concatenate(self.faces), np.concatenate(self.labels)

    def box(self, low: tuple[float, float, float], high: tuple[float, float, float], label: int = NEITHER) -> None:
        """Add a closed box."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        outline = np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]])
        self.prism(outline, y0, y1, label, back=True)

    def prism(
        self, outline: Floats, near: float, far: float, label: int = NEITHER, taper: float = 1.0, back: bool = False
    ) -> None:
        """Add what stands out of a front: (N, 2) outline in (x, z), from depth `far` to `near`, narrower in front."""
        middle = outline.mean(axis=0)
        tip = middle + taper * (outline - middle)
        n = len(outline)
        front = np.column_stack([tip[:, 0], np.full(n, near), tip[:, 1]])
        rear = np.column_stack([outline[:, 0], np.full(n, far), outline[:, 1]])
        i = np.arange(n)
        j = (i + 1) % n
        fan = np.column_stack([np.zeros(n - 2, dtype=np.int64), i[1:-1], i[2:]])
        walls = np.concatenate([np.column_stack([i, i + n, j]), np.column_stack([j, i + n, j + n])])
        faces = [fan, walls, fan[:, ::-1] + n] if back else [fan, walls]
        self.add(np.concatenate([front, rear]), np.concatenate(faces), label)


def ngon(x: float, z: float, width: float, height: float, corners: int, turn: float = 0.0) -> Floats:
    """(N, 2) a regular polygon, anticlockwise."""
    angle = np.arange(corners) * 2 * np.pi / corners + turn
    return np.column_stack([x + width / 2 * np.cos(angle), z + height / 2 * np.sin(angle)])


def rectangle(x: float, z: float, width: float, height: float, rounding: float = 0.0) -> Floats:
    """(N, 2) a rectangle, its corners rounded by a share of its shorter side."""
    if not rounding:
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        return np.array([x, z]) + corners * np.array([width, height]) / 2
    r = rounding * min(width, height)
    out = []
    for k, (a, b) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        middle = np.array([x + a * (width / 2 - r), z + b * (height / 2 - r)])
        angle = (k + np.linspace(0, 1, 4)) * np.pi / 2
        out.append(middle + r * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.concatenate(out)


def _knob_style(rng: Rng) -> Callable[[Scene, float, float, float, float], None]:
    """A way to draw a knob of a width at a place: (scene, x, z, depth of its ground, width)."""
    manner = str(
        rng.choice(["plain", "stepped", "bar", "grip", "pointer", "flat"], p=[0.35, 0.2, 0.15, 0.1, 0.15, 0.05])
    )
    corners = int(rng.choice([6, 8, 10, 12, 16, 20, 24, 32]))
    reach = float(rng.uniform(0.07, 0.25) if manner == "flat" else rng.uniform(0.22, 1.1))
    taper = float(rng.choice([1.0, rng.uniform(0.6, 1.0)]))
    slim, base = float(rng.uniform(0.12, 0.35)), float(rng.uniform(0.55, 0.85))
    turned = float(rng.choice([0.0, np.pi / 2, rng.uniform(0, np.pi)]))
    squash = float(rng.choice([1.0, 1.0, rng.uniform(0.85, 1.0)]))
    sunk = _sunk(rng)
    start = float(rng.choice([0.0, np.pi / corners]))

    def draw(scene: Scene, x: float, z: float, y: float, width: float) -> None:
        near, round_ = y - reach * width, ngon(x, z, width, squash * width, corners, start)
        y += sunk * width
        if manner == "stepped":
            step = near + 0.7 * reach * width
            scene.prism(round_, step, y, KNOB)
            scene.prism(
                ngon(x, z, base * width, base * squash * width, corners), near, step - 0.001 * width, KNOB, taper
            )
        elif manner == "bar":
            step = near + 0.7 * reach * width
            scene.prism(round_, step, y, KNOB, taper)
            bar = rectangle(0, 0, slim * width, 0.98 * width) @ _turn(turned) + (x, z)
            scene.prism(bar, near, step - 0.001 * width, KNOB)
        elif manner == "grip":
            bar = rectangle(0, 0, 1.4 * slim * width, width) @ _turn(turned) + (x, z)
            scene.prism(bar, near, y, KNOB, taper)
        else:
            scene.prism(round_, near, y, KNOB, taper)
            if manner == "pointer":
                line = rectangle(0, 0.28 * width, 0.08 * width, 0.4 * width) @ _turn(turned) + (x, z)
                scene.prism(line, near - 0.03 * width, near - 0.001 * width, KNOB)

    return draw


def _sunk(rng: Rng) -> float:
    """How far controls reach into what they sit on, by their width: many are drawn with a shaft, or float before it."""
    return float(rng.choice([0.0, rng.uniform(0.0, 0.5), rng.uniform(0.5, 2.0)], p=[0.6, 0.28, 0.12]))


def _turn(angle: float) -> Floats:
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])


def _key_style(rng: Rng) -> Callable[[Scene, float, float, float, float, float], None]:
    """A way to draw a key: (scene, x, z, depth of its ground, width, height)."""
    manner = str(rng.choice(["square", "rounded", "round", "printed"], p=[0.4, 0.2, 0.28, 0.12]))
    corners = int(rng.choice([8, 12, 16, 24, 32]))
    reach = float(rng.choice([rng.uniform(0.02, 0.1), rng.uniform(0.1, 0.4)]))
    taper = float(rng.choice([1.0, rng.uniform(0.75, 1.0)]))
    framed = bool(rng.random() < 0.12)
    pin = manner == "round" and rng.random() < 0.2
    reach = float(rng.uniform(0.3, 1.4)) if pin else reach
    sunk = float(rng.uniform(0.8, 2.0)) if pin else _sunk(rng)

    def draw(scene: Scene, x: float, z: float, y: float, width: float, height: float) -> None:
        if manner == "round":
            outline = ngon(x, z, width, height, corners, np.pi / corners)
        else:
            outline = rectangle(x, z, width, height, 0.3 if manner == "rounded" else 0.0)
        small = min(width, height)
        if framed:
            scene.prism(x_z_scaled(outline, 1.15), y - 0.3 * reach * small, y, KEY)
        if manner == "printed":
            scene.prism(outline, y - 0.0004, y - 0.0001, KEY)
        else:
            scene.prism(outline, y - reach * small, y + sunk * small, KEY, 1.0 if pin else taper)

    draw.round = manner == "round"  # type: ignore[attr-defined]
    return draw


def x_z_scaled(outline: Floats, by: float) -> Floats:
    """An outline made larger about its middle."""
    middle = outline.mean(axis=0)
    return middle + by * (outline - middle)


def knob_row(scene: Scene, rng: Rng, left: float, right: float, z: float, y: float, width: float, count: int) -> None:
    """Equal knobs in a row, perhaps with a gap in the middle for a display, perhaps with marks round each."""
    draw = _knob_style(rng)
    width = min(width, 0.8 * (right - left) / count)
    if count > 3 and rng.random() < 0.4:
        half = count // 2
        room = 0.3 * (right - left)
        xs = [*np.linspace(left + width, left + room, half), *np.linspace(right - room, right - width, count - half)]
        width = min(width, 0.8 * room / count * 2)
    else:
        xs = list(left + (np.arange(count) + 0.5) / count * (right - left))
    odd = rng.integers(count) if count > 3 and rng.random() < 0.15 else -1
    ticks = rng.random() < 0.3
    for k, x in enumerate(xs):
        draw(scene, float(x), z, y, width * (1.25 if k == odd else 1.0))
        if ticks:
            _ticks(scene, rng, float(x), z, y, width)


def dials_with_keys(scene: Scene, rng: Rng, width: float, z: float, y: float) -> None:
    """One or two dials, each with a smaller round push button or two beside it, as on toasters and coffee machines."""
    dial, count, keys = float(rng.uniform(0.09, 0.18)) * width, int(rng.integers(1, 3)), int(rng.integers(1, 3))
    draw, small = _knob_style(rng), float(rng.uniform(0.35, 0.75)) * dial
    corners, reach = int(rng.choice([8, 12, 16, 24, 32])), float(rng.uniform(0.3, 1.6)) * small
    away, lift = float(rng.uniform(0.75, 1.3)) * dial, float(rng.choice([0.0, rng.uniform(-1.0, 1.0)])) * dial
    sides = rng.permutation([-1.0, 1.0])[:keys]
    for x in ([0.0], [-0.22 * width, 0.22 * width])[count - 1]:
        draw(scene, x, z, y, dial)
        for side in sides:
            scene.prism(ngon(x + float(side) * away, z + lift, small, small, corners), y - reach, y + 0.1 * small, KEY)


def _ticks(scene: Scene, rng: Rng, x: float, z: float, y: float, width: float) -> None:
    """Marks around a knob, printed or raised a little."""
    count, raised = int(rng.integers(4, 12)), float(rng.choice([0.0003, 0.001]))
    dots = rng.random() < 0.4
    for angle in np.linspace(-0.2 * np.pi, 1.2 * np.pi, count):
        at = np.array([x, z]) + 0.68 * width * np.array([np.cos(angle), np.sin(angle)])
        size = 0.08 * width
        mark = ngon(at[0], at[1], size, size, 8) if dots else rectangle(0, 0, 2 * size, 0.6 * size) @ _turn(angle) + at
        scene.prism(mark, y - raised, y - 0.0001)


def key_pad(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, rows: int, columns: int) -> None:
    """A grid of equal keys in a rectangle of the front."""
    draw = _key_style(rng)
    cell = (high - low) / (columns, rows)
    size = cell * rng.uniform(0.4, 0.93, 2)
    if draw.round or rng.random() < 0.3:  # type: ignore[attr-defined]
        size[:] = size.min()
    if draw.round and rng.random() < 0.2:  # type: ignore[attr-defined]
        size[0] = min(1.6 * size[1], 0.95 * cell[0])
    if rng.random() < 0.25:
        raised = float(rng.uniform(0.0003, 0.004))
        scene.prism(rectangle(*((low + high) / 2), *(high - low)), y - raised, y - 0.0001)
        y -= raised + 0.0001
    wide = rng.random() < 0.2
    for row in range(rows):
        if wide and row == 0 and columns > 1:
            draw(scene, float((low + high)[0] / 2), float(low[1] + 0.5 * cell[1]), y, float(size[0] + cell[0]), size[1])
            continue
        for column in range(columns):
            x, z = low + (np.array([column, row]) + 0.5) * cell
            draw(scene, float(x), float(z), y, float(size[0]), float(size[1]))


def key_row(scene: Scene, rng: Rng, left: float, right: float, z: float, y: float, height: float, count: int) -> None:
    """Keys side by side."""
    key_pad(scene, rng, np.array([left, z - height / 2]), np.array([right, z + height / 2]), y, 1, count)


def _screws(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    size, reach = float(rng.uniform(0.006, 0.015)), max(raised, 0.0008)
    for a in (low[0] + size, high[0] - size):
        for b in (low[1] + size, high[1] - size) if high[1] - low[1] > 6 * size else ((low + high)[1] / 2,):
            scene.prism(ngon(a, b, size, size, int(rng.choice([6, 8, 12, 16]))), y - reach, y)


def _letters(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    x, z = (low + high) / 2
    count, tall = int(rng.integers(3, 10)), float(rng.uniform(0.15, 0.5) * (high - low).min())
    for k in range(count):
        across = tall * float(rng.uniform(0.3, 1.0))
        at = x + (k - count / 2) * 1.1 * tall
        scene.prism(rectangle(at, z, across, tall * float(rng.uniform(0.7, 1.0))), y - raised, y)


def _vents(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    count, upright = int(rng.integers(4, 18)), rng.random() < 0.5
    slot = (high - low) * (np.array([0.5 / count, 0.8]) if upright else np.array([0.8, 0.5 / count]))
    for k in range(count):
        share = np.array([(k + 0.5) / count, 0.5] if upright else [0.5, (k + 0.5) / count])
        x, z = low + share * (high - low)
        scene.prism(rectangle(x, z, *slot), y - raised, y)


def _display(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    (x, z), (width, height) = (low + high) / 2, high - low
    scene.prism(rectangle(x, z, 0.8 * width, 0.7 * height), y - raised, y)
    for k in range(4 if rng.random() < 0.5 else 0):
        digit = rectangle(x + (k - 1.5) * 0.16 * width, z, 0.1 * width, 0.4 * height)
        scene.prism(digit, y - raised - 0.0004, y - raised - 0.0001)


def _lamps(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    x, z = (low + high) / 2
    size, count = float(rng.uniform(0.004, 0.01)), int(rng.integers(1, 5))
    for k in range(count):
        disc = ngon(x + (k - count / 2) * float(rng.uniform(2, 5)) * size, z, size, size, 12)
        scene.prism(disc, y - max(raised, 0.0003), y)


def _badge(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    size = float(rng.uniform(0.25, 0.8) * (high - low).min())
    scene.prism(ngon(*((low + high) / 2), size, size * float(rng.uniform(0.5, 1.0)), 20), y - raised, y)


def _dots(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    (x, z), raised = (low + high) / 2, min(raised, 0.0003)
    size, n = float(rng.uniform(0.003, 0.006)), int(rng.integers(4, 9))
    for a in range(n):
        for b in range(n):
            disc = ngon(x + (a - n / 2) * 1.8 * size, z + (b - n / 2) * 1.8 * size, size, size, 8)
            scene.prism(disc, y - raised, y - 0.0001)


def _square(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    size = float(rng.uniform(0.2, 0.5) * (high - low).min())
    scene.prism(rectangle(*((low + high) / 2), size, size), y - raised, y)


def _lock(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float, raised: float) -> None:
    (x, z), size = (low + high) / 2, float(rng.uniform(0.012, 0.025))
    scene.prism(ngon(x, z, size, size, 16), y - 0.003 - raised, y)
    scene.prism(rectangle(x, z, 0.1 * size, 0.5 * size), y - 0.0034 - raised, y - 0.0031 - raised)


CLUTTER = (_screws, _letters, _vents, _display, _lamps, _badge, _dots, _square, _lock)


def _clutter(scene: Scene, rng: Rng, low: Floats, high: Floats, y: float) -> None:
    """What is on a free rectangle of a front and is no control; or nothing."""
    raised = float(rng.choice([0.0002, 0.0006, 0.0015, 0.004]))
    kind = int(rng.integers(len(CLUTTER) + 1))
    if kind < len(CLUTTER):
        CLUTTER[kind](scene, rng, low, high, y, raised)


def _handle(scene: Scene, rng: Rng, a: tuple[float, float], b: tuple[float, float], y: float) -> None:
    """A bar from one place to another, on two feet, or a thin one right on the front."""
    thick, out = float(rng.uniform(0.01, 0.03)), float(rng.uniform(0.02, 0.06))
    (x0, z0), (x1, z1) = a, b
    t = thick / 2
    scene.box((min(x0, x1) - t, y - out - thick, min(z0, z1) - t), (max(x0, x1) + t, y - out, max(z0, z1) + t))
    for x, z in (a, b):
        if rng.random() < 0.5:
            scene.prism(ngon(x, z, thick, thick, 12), y - out - 0.0002, y)
        else:
            scene.prism(rectangle(x, z, thick, thick), y - out - 0.0002, y)


def _door(scene: Scene, rng: Rng, low: tuple[float, float], high: tuple[float, float], folds: bool) -> float:
    """A plate before the front with a handle, perhaps hinges and a window; returns the depth of its face."""
    thick = float(rng.uniform(0.01, 0.04))
    face = -thick
    (x0, z0), (x1, z1) = low, high
    scene.box((x0, face, z0), (x1, -0.0005, z1))
    manner = rng.random()
    if manner < 0.75:
        if folds:
            z = z1 - 0.08 * (z1 - z0)
            _handle(scene, rng, (x0 + 0.15 * (x1 - x0), z), (x1 - 0.15 * (x1 - x0), z), face)
        else:
            x = float(rng.choice([x0, x1])) * 0.92 + 0.04 * (x0 + x1)
            _handle(scene, rng, (x, z0 + 0.2 * (z1 - z0)), (x, z1 - 0.2 * (z1 - z0)), face)
    if rng.random() < 0.5:
        window = rectangle((x0 + x1) / 2, (z0 + z1) / 2, 0.6 * (x1 - x0), 0.5 * (z1 - z0))
        scene.prism(window, face - 0.001, face)
    if rng.random() < 0.3:
        for x in (x0 + 0.04 * (x1 - x0), x1 - 0.04 * (x1 - x0)):
            scene.box((x - 0.012, face - 0.004, z0 - 0.008), (x + 0.012, face, z0 + 0.008))
    return face


def _feet(scene: Scene, rng: Rng, width: float) -> None:
    """Feet under the front edge of the body, and now and then something small anywhere."""
    for _ in range(int(rng.choice([0, 0, 0, 1, 2]))):
        size, ratio = float(rng.uniform(0.008, 0.07)), float(rng.uniform(0.2, 1.0))
        x, z = float(rng.uniform(-0.45, 0.45)) * width, float(rng.uniform(0.05, 0.9)) * width
        y, out = float(rng.uniform(-0.03, 0.0)), float(rng.uniform(0.0005, 0.06))
        round_ = rng.random() < 0.25
        outline = ngon(x, z, size, size, 12) if round_ and out < 0.3 * size else rectangle(x, z, size, ratio * size)
        scene.prism(outline, y - out, y + float(rng.uniform(0, 0.05)))
    if rng.random() < 0.5:
        size = float(rng.uniform(0.02, 0.05))
        for x in (-width / 2 + size, width / 2 - size):
            scene.box((x - size / 2, 0.01, -0.02), (x + size / 2, 0.01 + size, -0.0002))


def _body(scene: Scene, width: float, depth: float, height: float) -> None:
    scene.box((-width / 2, 0.0, 0.0), (width / 2, depth, height))


def microwave(rng: Rng) -> Scene:
    """A door beside a panel with keys, or with one or two dials, or both."""
    scene = Scene()
    w, d, h = rng.uniform(0.42, 0.6), rng.uniform(0.3, 0.48), rng.uniform(0.25, 0.36)
    _body(scene, w, d, h)
    split = w / 2 - w * rng.uniform(0.2, 0.32)
    _door(scene, rng, (-w / 2, 0.0), (split, h), False)
    _feet(scene, rng, w)
    y = -float(rng.choice([0.0, 0.0, 0.01, 0.025]))
    if y:
        scene.box((split + 0.001, y, 0.001), (w / 2, -0.0002, h))
    low, high = np.array([split + 0.015, 0.02]), np.array([w / 2 - 0.015, h - 0.02])
    middle = float(low[0] + high[0]) / 2
    span = high - low
    if rng.random() < 0.5:
        _clutter(scene, rng, np.array([low[0], high[1] - 0.18 * span[1]]), high, y)
        high = high - np.array([0.0, 0.22 * span[1]])
    if rng.random() < 0.4:
        key_pad(scene, rng, low, np.array([high[0], low[1] + 0.12 * span[1]]), y, 1, int(rng.choice([1, 1, 2])))
        low = low + np.array([0.0, 0.16 * span[1]])
    manner = rng.random()
    if manner < 0.6:
        key_pad(scene, rng, low, high, y, int(rng.integers(2, 8)), int(rng.integers(2, 5)))
    else:
        count = int(rng.choice([1, 2, 2]))
        draw = _knob_style(rng)
        top = high[1]
        if manner < 0.75:
            top = (low + high)[1] / 2
            key_pad(scene, rng, np.array([low[0], top]), high, y, int(rng.integers(1, 4)), int(rng.integers(2, 4)))
        width = float(min(span[0] * rng.uniform(0.35, 0.7), 0.75 * (top - low[1]) / count))
        for k in range(count):
            z = float(low[1] + (k + 0.5) / count * (top - low[1]))
            draw(scene, middle, z, y, width)
            if rng.random() < 0.4:
                _ticks(scene, rng, middle, z, y, width)
    return scene


def oven(rng: Rng) -> Scene:
    """A panel with a row of knobs, perhaps keys or a clock between, over doors that fold down; or over a hob."""
    scene = Scene()
    w, d, h = rng.uniform(0.45, 0.95), rng.uniform(0.45, 0.65), rng.uniform(0.4, 0.95)
    _body(scene, w, d, h)
    band = float(rng.uniform(0.07, 0.16))
    doors = int(rng.choice([1, 1, 2]))
    at = 0.02
    for _ in range(doors):
        top = at + (h - band - 0.03) / doors
        _door(scene, rng, (-w / 2, at), (w / 2, top - 0.004), True)
        at = top
    z, y = h - band / 2, 0.0
    if rng.random() < 0.4:
        y = -float(rng.uniform(0.005, 0.04))
        scene.box((-w / 2, y, h - band), (w / 2, -0.0002, h - 0.001))
    if rng.random() < 0.25:
        z = h + band / 2
        y = float(d - 0.04)
        scene.box((-w / 2, y, h + 0.001), (w / 2, d, h + band))
    left, right, count = -w / 2 + 0.02, w / 2 - 0.02, int(rng.choice([1, 2, 3, 4, 4, 5, 5, 6, 7, 8]))
    manner = rng.random()
    if manner < 0.5:
        knob_row(scene, rng, left, right, z, y, float(rng.uniform(0.3, 0.65)) * band, count)
    elif manner < 0.8:
        third = (right - left) / 3
        knob_row(scene, rng, left, left + third, z, y, float(rng.uniform(0.3, 0.65)) * band, min(count, 3))
        if rng.random() < 0.7:
            rows = int(rng.choice([1, 1, 2]))
            low, high = np.array([left + 1.1 * third, z - 0.3 * band]), np.array([right - 1.1 * third, z + 0.3 * band])
            key_pad(scene, rng, low, high, y, rows, int(rng.integers(2, 7)))
        else:
            low, high = np.array([left + 1.1 * third, z - 0.3 * band]), np.array([right - 1.1 * third, z + 0.3 * band])
            _clutter(scene, rng, low, high, y)
        if rng.random() < 0.8:
            scene2 = np.random.default_rng(int(rng.integers(1 << 30)))
            knob_row(scene, scene2, right - third, right, z, y, float(rng.uniform(0.3, 0.65)) * band, min(count, 3))
    else:
        middle = (right + left) / 2
        key_row(scene, rng, left, middle - 0.05, z, y, float(rng.uniform(0.15, 0.6)) * band, int(rng.integers(3, 10)))
        _clutter(scene, rng, np.array([middle, z - 0.3 * band]), np.array([right, z + 0.3 * band]), y)
    _feet(scene, rng, w)
    return scene


def dishwasher(rng: Rng) -> Scene:
    """A door with keys in a row along its top, perhaps a dial; also washing machines with a drawer and a dial."""
    scene = Scene()
    w, d, h = rng.uniform(0.42, 0.65), rng.uniform(0.5, 0.65), rng.uniform(0.7, 0.95)
    _body(scene, w, d, h)
    band = float(rng.uniform(0.06, 0.14))
    apart = rng.random() < 0.5
    if apart:
        y = _door(scene, rng, (-w / 2, 0.05), (w / 2, h - band - 0.005), True)
        scene.box((-w / 2, y, h - band), (w / 2, -0.0002, h - 0.001))
    else:
        y = _door(scene, rng, (-w / 2, 0.05), (w / 2, h), True)
    z, left, right = h - band / 2, -w / 2 + 0.02, w / 2 - 0.02
    if not apart:
        band *= 0.5
        z = h - band / 2 - 0.002
    middle = float(rng.uniform(0.4, 0.6)) * (right - left) + left
    sides = [(left, middle - 0.02), (middle + 0.02, right)]
    rng.shuffle(sides)
    key_row(scene, rng, *sides[0], z, y, float(rng.uniform(0.15, 0.6)) * band, int(rng.integers(2, 11)))
    if rng.random() < 0.5:
        a, b = sides[1]
        knob_row(scene, rng, a, b, z, y, float(rng.uniform(0.4, 0.85)) * band, int(rng.choice([1, 1, 2])))
    else:
        a, b = sides[1]
        _clutter(scene, rng, np.array([a, z - 0.35 * band]), np.array([b, z + 0.35 * band]), y)
    _feet(scene, rng, w)
    return scene


def washer(rng: Rng) -> Scene:
    """A round door, one large dial, some keys, a drawer for soap."""
    scene = Scene()
    w, d, h = rng.uniform(0.55, 0.7), rng.uniform(0.45, 0.65), rng.uniform(0.8, 1.0)
    _body(scene, w, d, h)
    size = 0.6 * w
    scene.prism(ngon(0.0, 0.45 * h, size, size, 32), -0.03, 0.0, taper=0.9)
    z, band, y = 0.92 * h, 0.12 * h, 0.0
    if rng.random() < 0.7:
        scene.box((-w / 2 + 0.01, -0.015, z - band / 2), (-w / 6, -0.0002, z + band / 2))
    x = float(rng.uniform(-0.1, 0.1)) * w
    if rng.random() < 0.8:
        _knob_style(rng)(scene, x, z, y, float(rng.uniform(0.45, 0.9)) * band)
    left, right = x + 0.12 * w, w / 2 - 0.02
    height = float(rng.uniform(0.1, 0.4)) * band
    if rng.random() < 0.8:
        key_row(scene, rng, left, right, z - 0.2 * band, y, height, int(rng.integers(2, 9)))
    _clutter(scene, rng, np.array([left, z + 0.05 * band]), np.array([right, z + 0.45 * band]), y)
    _feet(scene, rng, w)
    return scene


def small_appliance(rng: Rng) -> Scene:
    """A toaster, coffee machine or the like: a dial or two, or a few keys, round ones often."""
    scene = Scene()
    w, d, h = rng.uniform(0.18, 0.4), rng.uniform(0.15, 0.4), rng.uniform(0.15, 0.45)
    _body(scene, w, d, h)
    z, y = float(rng.uniform(0.15, 0.85)) * h, 0.0
    if rng.random() < 0.3:
        dials_with_keys(scene, rng, w, z, y)
    elif rng.random() < 0.6:
        knob_row(scene, rng, -0.4 * w, 0.4 * w, z, y, float(rng.uniform(0.1, 0.22)) * w, int(rng.integers(1, 4)))
        z = float(np.clip(z + rng.choice([-1, 1]) * 0.3 * h, 0.1 * h, 0.9 * h))
    if rng.random() < 0.6:
        key_row(scene, rng, -0.35 * w, 0.35 * w, z, y, float(rng.uniform(0.05, 0.12)) * h, int(rng.integers(1, 6)))
    z = 0.5 * h if abs(z - 0.5 * h) > 0.2 * h else 0.1 * h
    _clutter(scene, rng, np.array([-0.4 * w, z - 0.05 * h]), np.array([0.4 * w, z + 0.05 * h]), y)
    _feet(scene, rng, w)
    return scene


def keypad(rng: Rng) -> Scene:
    """A remote control, lock or calculator: a plate full of keys."""
    scene = Scene()
    w = float(rng.uniform(0.04, 0.2))
    h, d = w * float(rng.uniform(0.8, 4)), w * float(rng.uniform(0.1, 0.6))
    _body(scene, w, d, h)
    low, high = np.array([-0.43 * w, 0.05 * h]), np.array([0.43 * w, 0.95 * h])
    middle = float(rng.uniform(0.4, 0.7)) * h
    key_pad(scene, rng, low, np.array([high[0], middle]), 0.0, int(rng.integers(2, 8)), int(rng.integers(2, 6)))
    if rng.random() < 0.5:
        rows = np.array([low[0], middle + 0.04 * h])
        key_pad(scene, rng, rows, high, 0.0, int(rng.integers(1, 4)), int(rng.integers(1, 5)))
    else:
        _clutter(scene, rng, np.array([low[0], middle + 0.04 * h]), high, 0.0)
    return scene


def cabinet(rng: Rng) -> Scene:
    """Doors and drawers with pulls, which are no controls."""
    scene = Scene()
    w, d, h = rng.uniform(0.3, 1.6), rng.uniform(0.3, 0.6), rng.uniform(0.3, 2.0)
    _body(scene, w, d, h)
    columns, rows = int(rng.integers(1, 4)), int(rng.integers(1, 6))
    size, reach = float(rng.uniform(0.02, 0.045)), float(rng.uniform(0.3, 1.2))
    manner, corners = rng.random(), int(rng.choice([8, 12, 16, 24]))
    thick, drawers = float(rng.uniform(0.01, 0.03)), rng.random() < 0.6
    for a in range(columns):
        for b in range(rows):
            x0, z0 = -w / 2 + a * w / columns + 0.004, 0.02 + b * (h - 0.04) / rows + 0.004
            x1, z1 = x0 + w / columns - 0.008, z0 + (h - 0.04) / rows - 0.008
            scene.box((x0, -thick, z0), (x1, -0.0005, z1))
            x = (x0 + x1) / 2 if drawers else (x1 - 1.5 * size if a % 2 == 0 else x0 + 1.5 * size)
            for pull in (x - 0.25 * (x1 - x0), x + 0.25 * (x1 - x0)) if drawers and manner > 0.85 else (x,):
                z = (z0 + z1) / 2
                if manner < 0.2:
                    scene.prism(rectangle(pull, z, size, size), -thick - reach * size, -thick)
                elif manner < 0.3:
                    _handle(scene, rng, (pull - 2 * size, z), (pull + 2 * size, z), -thick)
                else:
                    outline = ngon(pull, z, size, size, corners)
                    if manner < 0.5:
                        scene.prism(x_z_scaled(outline, 0.5), -thick - 0.4 * reach * size, -thick)
                        scene.prism(outline, -thick - reach * size, -thick - 0.401 * reach * size)
                    else:
                        scene.prism(outline, -thick - reach * size, -thick, taper=float(rng.choice([1.0, 0.8])))
    return scene


def fridge(rng: Rng) -> Scene:
    """Tall doors with handles, and clutter."""
    scene = Scene()
    w, d, h = rng.uniform(0.5, 1.0), rng.uniform(0.5, 0.75), rng.uniform(1.2, 1.9)
    _body(scene, w, d, h)
    if rng.random() < 0.5:
        split = float(rng.uniform(0.3, 0.75)) * h
        y = _door(scene, rng, (-w / 2, 0.02), (w / 2, split), False)
        y = _door(scene, rng, (-w / 2, split + 0.01), (w / 2, h), False)
    else:
        y = _door(scene, rng, (-w / 2, 0.02), (-0.004, h), False)
        y = _door(scene, rng, (0.004, 0.02), (w / 2, h), False)
    x, z = float(rng.uniform(-0.3, 0.1)) * w, float(rng.uniform(0.6, 0.85)) * h
    low, high = np.array([x, z]), np.array([x + 0.15 * w, z + 0.05 * h])
    if rng.random() < 0.3:
        key_pad(scene, rng, low, high, y, int(rng.integers(1, 3)), int(rng.integers(2, 5)))
    else:
        _clutter(scene, rng, low, high, y)
    for side in (-w / 2 + 0.03, w / 2 - 0.03):
        scene.box((side - 0.02, -0.01, h + 0.001), (side + 0.02, 0.05, h + 0.015))
    return scene


def hob(rng: Rng) -> Scene:
    """A plate with burners and knobs on its top; built upright and laid down."""
    scene = Scene()
    w, d, h = rng.uniform(0.3, 0.9), rng.uniform(0.3, 0.52), rng.uniform(0.03, 0.12)
    _body(scene, w, h, d)
    for x in (-0.25 * w, 0.2 * w):
        for z in (0.4 * d, 0.78 * d):
            size = float(rng.uniform(0.2, 0.3)) * min(w, d)
            scene.prism(ngon(x, z, size, size, 24), -0.012, 0.0)
            scene.prism(ngon(x, z, 0.4 * size, 0.4 * size, 16), -0.022, -0.0121)
            if rng.random() < 0.5:
                for k in range(4):
                    arm = rectangle(0.4 * size, 0, 0.5 * size, 0.05 * size) @ _turn(k * np.pi / 2) + (x, z)
                    scene.prism(arm, -0.035, -0.028)
    if rng.random() < 0.8:
        count = int(rng.choice([2, 4, 4, 5, 6]))
        if rng.random() < 0.6:
            knob_row(scene, rng, -0.45 * w, 0.45 * w, 0.12 * d, 0.0, float(rng.uniform(0.03, 0.05)), count)
        else:
            draw, size = _knob_style(rng), min(0.045, 0.14 * d)
            for k in range(count):
                draw(scene, 0.42 * w, (k + 0.5) / count * 0.8 * d + 0.1 * d, 0.0, size)
    else:
        key_row(scene, rng, -0.3 * w, 0.3 * w, 0.1 * d, 0.0, 0.04 * d, int(rng.integers(4, 10)))
    for k, p in enumerate(scene.points):
        scene.points[k] = np.column_stack([p[:, 0], p[:, 2], -p[:, 1]])
    return scene


KINDS: Mapping[str, tuple[Callable[[Rng], Scene], float]] = {
    "microwave": (microwave, 2.0),
    "oven": (oven, 2.5),
    "dishwasher": (dishwasher, 1.5),
    "washer": (washer, 1.0),
    "small_appliance": (small_appliance, 1.5),
    "keypad": (keypad, 0.7),
    "cabinet": (cabinet, 1.5),
    "fridge": (fridge, 0.8),
    "hob": (hob, 1.0),
}


def draw_scene(seed: int, index: int) -> tuple[str, Floats, Ints, Ints]:
    """The kind of the scene of this number, its points, triangles and labels."""
    rng = np.random.default_rng([seed, index])
    weights = np.array([w for _, w in KINDS.values()])
    kind = list(KINDS)[int(rng.choice(len(weights), p=weights / weights.sum()))]
    points, faces, labels = KINDS[kind][0](rng).mesh()
    return kind, points, faces, labels
