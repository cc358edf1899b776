"""Start states of a kitchen -> rows of positions in the shared structure, and sizes of buffers where all is awake."""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

import mujoco
import numpy as np

from casa_assets import CasaError
from casa_assets.addons.batch.shared_model import SharedModel, addresses
from casa_assets.ext.arrays import Floats, Ints
from casa_assets.ext.kitchens import StoredStates
from casa_assets.ext.scene_checks import candidate_pairs

# Steps within which a state has to fall asleep, steps between two looks, and how far it may move meanwhile, metres.
SETTLE_STEPS, LOOK_STEPS, MOTION_M = 1000, 25, 0.005
LOCKED, AWAKE, MOVED = "a joint is open that the batch form locks", "does not fall asleep", "moves by more than 5 mm"
AS_BUILT = -1  # number of the state that a kitchen begins with where none were drawn
# Sizes of buffers for engines in which nothing is asleep when they begin, so that all contacts at rest count.
# Room for this many times what there is at rest.
MARGIN = 1.5
NEAR_MARGIN = 1.25  # MJX looks at the pairs whose bounding balls are nearest, and what moves comes near to more of them


@dataclass(frozen=True)
class StartPositions:
    """States at rest of one kitchen: `qpos` (rows, nq), and `asleep` (rows, ntree) as MuJoCo's `tree_asleep`.

    `base`: (rows, 3) where a robot's base parks: x, y (m), yaw (rad). `states`: (rows,) number of the start state, -1:
    as built. `refused`: reason -> how many start states were left out.
    """

    qpos: Floats
    asleep: Ints
    base: Floats
    states: Ints
    refused: Mapping[str, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.qpos)


def start_positions(
    shared: SharedModel, states: StoredStates | None, most: int, parks: Sequence[float] = (0.0, 0.0, 0.0)
) -> StartPositions:
    """At most `most` rows of a kitchen. Raises CasaError: nothing of it is at rest.

    `states`: drawn ones; without any the one row is the kitchen as it is built, in which a robot `parks` there.
    """
    refused: Counter[str] = Counter()
    begun: list[tuple[int, Floats, Floats]] = []
    for number in range(0 if states is None else len(states)):
        assert states is not None
        if any(name not in shared.joints for name in states.notes[number].opened):
            refused[LOCKED] += 1
        elif len(begun) < most:
            row = shared.start.copy()
            for joint in (joint for joint in states.joints if joint.name in shared.joints):  # the rest are locked
                values = states.qpos[number, joint.address : joint.address + joint.width]
                row[addresses(shared.model, shared.joints[joint.name])] = values
            begun.append((number, row, states.base[number].astype(np.float64)))
    as_built = (AS_BUILT, shared.start, np.asarray(parks, dtype=np.float64))
    kept = _settled(shared, begun, refused) or _settled(shared, [as_built], refused)
    if not kept:
        raise CasaError(f"{shared.name}: nothing is at rest in the batch form: {dict(refused)}")
    numbers, qpos, asleep, base = zip(*kept, strict=True)
    return StartPositions(np.stack(qpos), np.stack(asleep), np.stack(base), np.array(numbers), dict(refused))


def _settled(
    shared: SharedModel, begun: Sequence[tuple[int, Floats, Floats]], refused: Counter[str]
) -> list[tuple[int, Floats, Ints, Floats]]:
    """Those that fall asleep where they are, with their positions then."""

    def settle(item: tuple[int, Floats, Floats]) -> tuple[int, Floats, Ints, Floats] | str:
        number, qpos, base = item
        data = mujoco.MjData(shared.model)
        data.qpos[:] = qpos
        mujoco.mj_kinematics(shared.model, data)
        placed = data.xpos.copy()
        for _ in range(SETTLE_STEPS // LOOK_STEPS):
            mujoco.mj_step(shared.model, data, nstep=LOOK_STEPS)
            if data.nv_awake == 0:
                break
        else:
            return AWAKE
        if float(np.linalg.norm(data.xpos - placed, axis=1).max()) > MOTION_M:
            return MOVED
        return number, data.qpos.copy(), data.tree_asleep.copy(), base

    # MuJoCo lets other threads run while it steps.
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        found = list(pool.map(settle, begun))
    refused.update(one for one in found if isinstance(one, str))
    return [one for one in found if not isinstance(one, str)]


def awake_sizes(shared: SharedModel, rows: StartPositions) -> dict[str, int]:
    """nconmax, njmax and nccdmax of a kitchen at rest, with a margin."""
    data = _at_rest(shared, rows)
    counts = {"nconmax": int(data.ncon), "njmax": int(data.nefc), "nccdmax": int(data.ncon)}
    return {name: _rounded(count * MARGIN) for name, count in counts.items()}


def near_pairs(shared: SharedModel, rows: StartPositions) -> int:
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


def _at_rest(shared: SharedModel, rows: StartPositions) -> mujoco.MjData:
    data = mujoco.MjData(shared.model)
    data.qpos[:] = rows.qpos[0]
    mujoco.mj_forward(shared.model, data)
    return data


def _rounded(number: float) -> int:
    return 8 * math.ceil(number / 8)
