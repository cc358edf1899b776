"""Draws kitchens side by side by the renderer of mujoco_warp and one after the other by MuJoCo's own, and compares.

    python batch_pictures.py PACKAGES PICTURES FOLDER ...

PACKAGES is the folder that mujoco_warp is installed in, which is looked at after ours. Each FOLDER holds
`scene_batch.xml`. Prints one JSON object; the folder PICTURES gets `<kitchen>.png`, ours and theirs side by side.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

import casa_assets as casa

WIDTH, HEIGHT, CAMERA = 480, 360, "overview"
# mujoco_warp has no mipmaps, so that fine patterns differ from pixel to pixel: means of so many are compared.
BLOCK = 8


def main() -> None:
    packages, pictures, *folders = sys.argv[1:]
    sys.path.append(packages)
    batch = casa.batch(folders, engine="mujoco_warp", device="cpu", textures=True)
    theirs = drawn_at_once(batch)
    told = {}
    for kitchen, picture in zip(batch.kitchens, theirs, strict=True):
        ours = drawn_alone(kitchen)
        shown = reduced(picture.any(axis=2)[..., None])[..., 0] == 1
        off = np.abs(reduced(ours) - reduced(picture))[shown].mean()
        others = [np.abs(reduced(picture) - reduced(other)).mean() for other in theirs if other is not picture]
        told[kitchen.id] = {"off": float(off), "shown": float(shown.mean()), "from_others": float(min(others))}
        Image.fromarray(np.concatenate([ours, picture], axis=1)).save(Path(pictures) / f"{kitchen.id}.png")
    print(json.dumps(told))


def drawn_at_once(batch: casa.Batch[Any]) -> list[NDArray[np.uint8]]:
    import mujoco_warp as mjw
    import warp as wp

    first = batch.kitchens[0]
    wanted = [number == first.cameras[CAMERA] for number in range(first.model.ncam)]
    with wp.ScopedDevice("cpu"):
        mjw.kinematics(batch.engine.model, batch.engine.data)
        mjw.camlight(batch.engine.model, batch.engine.data)
        context: Any = mjw.create_render_context(
            first.model,
            nworld=len(batch),
            cam_res=(WIDTH, HEIGHT),
            render_rgb=True,
            use_textures=True,
            use_shadows=True,
            cam_active=wanted,
        )
        mjw.refit_bvh(batch.engine.model, batch.engine.data, context)
        mjw.render(batch.engine.model, batch.engine.data, context)
    packed = context.rgb_data.numpy().reshape(len(batch), HEIGHT, WIDTH)
    return list(np.stack([packed >> 16 & 255, packed >> 8 & 255, packed & 255], axis=-1).astype(np.uint8))


def reduced(picture: NDArray[Any]) -> NDArray[np.float64]:
    blocks = picture.reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, -1)
    return np.asarray(blocks.mean(axis=(1, 3)), dtype=np.float64)


def drawn_alone(kitchen: casa.BatchKitchen) -> NDArray[np.uint8]:
    data = mujoco.MjData(kitchen.model)
    data.qpos[:] = kitchen.rows.qpos[0]
    mujoco.mj_forward(kitchen.model, data)
    with mujoco.Renderer(kitchen.model, HEIGHT, WIDTH) as renderer:
        renderer.update_scene(data, kitchen.cameras[CAMERA])
        return np.array(renderer.render())


if __name__ == "__main__":
    main()
