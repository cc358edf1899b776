"""Runs where open_clip is installed: makes a tiny model with weights drawn at random, or runs casa-assets there.

python clip_run.py make FOLDER
python clip_run.py casa find "red mug" --library ...
"""

from __future__ import annotations

import importlib.util
import json
import sys
from pathlib import Path

import torch

SMALL = {
    "embed_dim": 32,
    "vision_cfg": {"image_size": 32, "layers": 1, "width": 64, "head_width": 32, "patch_size": 8},
    "text_cfg": {"context_length": 77, "vocab_size": 49408, "width": 32, "heads": 2, "layers": 1},
}


def declare_what_is_missing() -> None:
    """Package indexes have torchvision for GPUs alone.

    With a torch for processors its operators, which CLIP does not use, cannot be loaded; it is content where they are
    declared.
    """
    found = importlib.util.find_spec("torchvision")
    assert found is not None
    assert found.origin is not None
    built_for_gpus = any((Path(found.origin).parents[1] / "torchvision.libs").glob("libcudart*"))
    if built_for_gpus and torch.version.cuda is None:
        for name in ("nms", "qnms"):
            torch.library.define(f"torchvision::{name}", "(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")


def make(folder: Path) -> None:
    """A folder of weights as open_clip publishes them, and one that lacks them."""
    import open_clip

    torch.manual_seed(7)
    config = json.dumps({"model_cfg": SMALL, "preprocess_cfg": {}})
    for name in ("tiny", "bare"):
        (folder / name).mkdir(parents=True)
        (folder / name / "open_clip_config.json").write_text(config, encoding="ascii")
    model = open_clip.CLIP(**SMALL)
    torch.save(model.state_dict(), folder / "tiny" / "open_clip_pytorch_model.bin")
    torch.save(model.state_dict(), folder / "ViT-B-32-of-another-size.pt")


def main() -> None:
    torch.set_num_threads(1)
    declare_what_is_missing()
    verb, *rest = sys.argv[1:]
    if verb == "make":
        make(Path(rest[0]))
        return
    from casa_assets.cli.main import main as casa

    sys.argv = ["casa-assets", *rest]
    casa()


if __name__ == "__main__":
    main()
