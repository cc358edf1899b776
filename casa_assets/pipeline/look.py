"""Pictures of a thing and names for it -> how well each name fits, by CLIP; where its weights lie on this machine."""

from __future__ import annotations

import importlib.util
import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from PIL import Image

from casa_assets.errors import CasaError
from casa_assets.export import mjcf
from casa_assets.model.asset import Asset
from casa_assets.pipeline import library as disk
from casa_assets.preview.camera import View
from casa_assets.preview.still import render

# Pictures (PNG) and names -> a share for each name; they add up to 1.
Scorer = Callable[[Sequence[bytes], Sequence[str]], tuple[float, ...]]

# What the pictures are compared with, by the id of the kind. `other` takes what is no such thing.
WORDS: Mapping[str, str] = {
    "base_cabinet": "a kitchen base cabinet with doors",
    "wall_cabinet": "a kitchen wall cabinet",
    "tall_cabinet": "a tall pantry cabinet or wardrobe",
    "drawer_stack": "a chest of drawers",
    "range": "a kitchen range with an oven and burners",
    "hob": "a cooktop with burners",
    "wall_oven": "a built-in oven",
    "microwave": "a microwave oven",
    "refrigerator": "a refrigerator",
    "dishwasher": "a dishwasher",
    "coffee_machine": "a coffee machine",
    "toaster": "a toaster with slots for bread",
    "toaster_oven": "a toaster oven with a glass door",
    "kettle": "an electric kettle",
    "sink": "a faucet at a kitchen sink",
    "hood": "a range hood",
    "blender": "a blender",
    "stand_mixer": "a stand mixer",
    "other": "some other thing",
}
PROMPT = "a 3D rendering of {}"
# Walks round the thing: its front, both sides of it, and from higher up.
VIEWS = ((0.0, 15.0), (35.0, 25.0), (-35.0, 25.0), (20.0, 55.0))
PICTURE_PX = 256
# Below this share no name is taken.
SURE = 0.4
# Where the file name of the weights says no architecture that open_clip knows.
USUAL = "ViT-B-32"
NO_WEIGHTS = "no weights of CLIP were given"


def scorer(weights: Path) -> Scorer:
    """CLIP with these weights, on the processor.

    Args:
        weights: checkpoint of open_clip, on this machine; its name begins with that of the architecture, such as
            `ViT-B-32-laion2b.pt`.
    Raises:
        CasaError: the file is not there, or open_clip is not installed.
    """
    if not weights.is_file():
        raise CasaError(f"{weights}: there are no weights of CLIP; leave out --clip to name things without them")
    if importlib.util.find_spec("open_clip") is None:
        raise CasaError("--clip needs the packages open_clip_torch and torch, which are not installed here")
    import open_clip
    import torch

    known = sorted((n for n in open_clip.list_models() if weights.name.startswith(n)), key=lambda n: (-len(n), n))
    name = known[0] if known else USUAL
    torch.manual_seed(0)
    model, _, prepare = open_clip.create_model_and_transforms(name, pretrained=str(weights))
    model.eval()
    tokens = open_clip.get_tokenizer(name)

    def scores(pictures: Sequence[bytes], names: Sequence[str]) -> tuple[float, ...]:
        with torch.no_grad():
            stack = torch.stack([prepare(Image.open(io.BytesIO(p)).convert("RGB")) for p in pictures])
            seen = model.encode_image(stack)
            said = model.encode_text(tokens([PROMPT.format(n) for n in names]))
            seen = seen / seen.norm(dim=-1, keepdim=True)
            said = said / said.norm(dim=-1, keepdim=True)
            logits = model.logit_scale.exp() * (seen @ said.T)
            return tuple(round(float(s), 4) for s in logits.mean(dim=0).softmax(dim=-1))

    return scores


def kind_seen(asset: Asset, score: Scorer) -> tuple[str, float, str]:
    """The kind that a thing looks like, how sure, and why; an empty kind where it looks like none.

    Args:
        asset: under any category; its front faces -y.
    """
    kinds = list(WORDS)
    shares = score(pictures(asset), list(WORDS.values()))
    best = max(range(len(kinds)), key=lambda i: (shares[i], -i))
    says = f"CLIP says {WORDS[kinds[best]]}"
    if kinds[best] == "other" or shares[best] < SURE:
        return "", shares[best], f"{says} at {shares[best]:.0%}, which names nothing"
    return kinds[best], shares[best], says


def pictures(asset: Asset) -> list[bytes]:
    """PNGs of a thing from a few sides, with the look that it came with.

    Raises:
        NoRenderer: there is no OpenGL.
    """
    with tempfile.TemporaryDirectory() as folder:
        disk.write_files(Path(folder), mjcf.write(asset))
        model = Path(folder) / "model.xml"
        return [render(model, View(azimuth_deg=a, elevation_deg=e, size_px=PICTURE_PX, passes=4)) for a, e in VIEWS]
