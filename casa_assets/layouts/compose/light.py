"""Light of a kitchen: the sun and the sky through the windows, the lamps, and what the room throws back."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from casa_assets.layouts.order.request import KitchenRequest
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Light, LightKind, Placement
from casa_assets.model.record import Vec3

MAX_LAMPS = 3  # that are lights of the scene; more cost time and wash out the picture


def lights(kitchen: KitchenRequest, placements: Sequence[Placement], assets: Mapping[str, Asset]) -> tuple[Light, ...]:
    """A sun with shadows, light from the open side without, and the lamps under the ceiling."""
    (x0, y0), (x1, y1) = kitchen.room.bounds()
    middle = ((x0 + x1) / 2, (y0 + y1) / 2)
    sun_color = blackbody(kitchen.style.daylight_kelvin)
    lamp_color = blackbody(kitchen.style.lamp_kelvin)
    out = [
        Light(
            name="sun",
            position=(middle[0] - 2.0, y0 - 1.5, 5.5),
            direction=(0.34, 0.5, -0.8),
            color=_scaled(sun_color, 0.55),
        ),
        Light(
            name="fill",
            position=(middle[0] + 2.0, y0 - 1.0, 4.0),
            direction=(-0.55, 0.6, -0.55),
            color=_scaled(sun_color, 0.24),
            castshadow=False,
        ),
    ]
    lamps = [item for item in kitchen.items if item.role == "lamp"]
    for k, item in enumerate(lamps[:MAX_LAMPS]):
        x, y, _ = item.spot.frame.at(item.spot.u, item.spot.v)
        out.append(
            Light(
                name=f"lamp_{k + 1}",
                kind=LightKind.POINT,
                position=(x, y, round(kitchen.room.height - 0.55, 4)),
                direction=(0.0, 0.0, -1.0),
                color=_scaled(lamp_color, 0.34 / min(len(lamps), MAX_LAMPS) ** 0.5),
                castshadow=False,
                attenuation=(1.0, 0.1, 0.12),
            )
        )
    return tuple(out)


def blackbody(kelvin: float) -> Vec3:
    """Linear RGB of a colour temperature, brightest channel 1, mixed half and half with white (adaptation of the eye).

    Ref: Mitchell Charity, blackbody colour datafile, 10 degree observer; to within 0.05.
    """
    points: tuple[tuple[float, Vec3], ...] = (
        (2000.0, (1.0, 0.25, 0.01)),
        (2700.0, (1.0, 0.4, 0.1)),
        (3500.0, (1.0, 0.55, 0.25)),
        (4500.0, (1.0, 0.71, 0.49)),
        (5500.0, (1.0, 0.84, 0.74)),
        (6500.0, (1.0, 0.95, 0.98)),
        (9000.0, (0.67, 0.75, 1.0)),
    )
    for (k0, c0), (k1, c1) in itertools.pairwise(points):
        if kelvin <= k1:
            t = min(1.0, max(0.0, (kelvin - k0) / (k1 - k0)))
            mixed = [a + t * (b - a) for a, b in zip(c0, c1, strict=True)]
            break
    else:
        mixed = list(points[-1][1])
    return (round(0.5 + mixed[0] / 2, 4), round(0.5 + mixed[1] / 2, 4), round(0.5 + mixed[2] / 2, 4))


def _scaled(color: Vec3, factor: float) -> Vec3:
    return (round(color[0] * factor, 5), round(color[1] * factor, 5), round(color[2] * factor, 5))
