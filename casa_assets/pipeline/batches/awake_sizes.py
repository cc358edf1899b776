"""Sizes of buffers for engines in which nothing is asleep when they begin, so that all contacts at rest count."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from casa_assets.checks.scene.batch.form import candidate_pairs
from casa_assets.pipeline.batches.shared_model import SharedModel
from casa_assets.pipeline.batches.start_rows import StartRows

# Room for so many times what there is at rest.
MARGIN = 1.5
# MJX looks at the pairs whose bounding balls are nearest, and what moves comes near to more of them.
NEAR_MARGIN = 1.25


def awake_sizes(shared: SharedModel, rows: StartRows) -> dict[str, int]:
    """nconmax, njmax and nccdmax of a kitchen at rest, with a margin."""
    data = _at_rest(shared, rows)
    counts = {"nconmax": int(data.ncon), "njmax": int(data.nefc), "nccdmax": int(data.ncon)}
    return {name: _rounded(count * MARGIN) for name, count in counts.items()}


def near_pairs(shared: SharedModel, rows: StartRows) -> int:
    """Pairs of geoms of two kinds whose bounding balls overlap: the most of any two kinds, with a margin.

    It is what MJX's `max_geom_pairs` has to be, so that no contact is left out: it keeps the nearest of each two kinds.
    """
    model, data = shared.model, _at_rest(shared, rows)
    pairs = np.argwhere(candidate_pairs(model))
    first, second = pairs.T
    apart = np.linalg.norm(data.geom_xpos[first] - data.geom_xpos[second], axis=1)
    near = pairs[apart < model.geom_rbound[first] + model.geom_rbound[second]]
    kinds = np.sort(model.geom_type[near], axis=1)
    _, counts = np.unique(kinds, axis=0, return_counts=True)
    return _rounded(float(counts.max(initial=1)) * NEAR_MARGIN)


def _at_rest(shared: SharedModel, rows: StartRows) -> mujoco.MjData:
    data = mujoco.MjData(shared.model)
    data.qpos[:] = rows.qpos[0]
    mujoco.mj_forward(shared.model, data)
    return data


def _rounded(number: float) -> int:
    """Up to a multiple of eight."""
    return 8 * math.ceil(number / 8)
