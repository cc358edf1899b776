"""Show in a compiled model what acts: a burner that is lit, a lamp that is on, water that runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import mujoco
import numpy as np

from casa_assets.model.asset.behavior import Effect, EffectKind

# What an effect of these kinds acts on changes its look; heat, cold and turning are not seen in a still picture.
SEEN = frozenset({EffectKind.SHOW, EffectKind.LIGHT})


class Glow:
    """The colours of the sites and visuals of a model while effects act on them."""

    def __init__(self, model: Any) -> None:
        """Remembers how everything looks; the model is an MjModel, whose colours `show` changes."""
        self._model = model
        self._sites, self._geoms = np.array(model.site_rgba), np.array(model.geom_rgba)
        self._materials = np.array(model.geom_matid)

    def show(self, effects: Mapping[str, Iterable[Effect]]) -> None:
        """Colour the targets of effects, and nothing else; `effects`: name of a fixture -> those that act."""
        model = self._model
        model.site_rgba[:], model.geom_rgba[:], model.geom_matid[:] = self._sites, self._geoms, self._materials
        for fixture, acting in effects.items():
            for effect in acting:
                if effect.kind in SEEN:
                    self._color(fixture, effect)

    def _color(self, fixture: str, effect: Effect) -> None:
        for name in (f"{fixture}__{effect.target}", effect.target):
            site = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_SITE, name)
            geom = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_GEOM, name)
            if site >= 0:
                self._model.site_rgba[site] = effect.color
            if geom >= 0:
                self._model.geom_rgba[geom], self._model.geom_matid[geom] = effect.color, -1
            if max(site, geom) >= 0:
                return
