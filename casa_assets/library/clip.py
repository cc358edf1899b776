"""Compare pictures with words by CLIP; embeddings of a library's pictures are kept by content."""

from __future__ import annotations

import hashlib
import io
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.cache.store import Store
from casa_assets.checks.library import NAMED, CategoryRank
from casa_assets.core.numeric import Floats
from casa_assets.core.system import require
from casa_assets.errors import CasaError
from casa_assets.library.entry_files import checked_model, write_files
from casa_assets.library.pairs import AssetRow
from casa_assets.model.asset.asset import Asset
from casa_assets.model.registry.category import clip_prompts

# Pictures (PNG) and names -> a share for each name; they add up to 1.
Scorer = Callable[[Sequence[bytes], Sequence[str]], tuple[float, ...]]

# What the pictures are compared with, by the id of the kind. `other` takes what is no such thing.
KIND_PHRASES: Mapping[str, str] = {
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
LEAST_SHARE = 0.4  # below it no name is taken
DEFAULT_ARCHITECTURE = "ViT-B-32"  # where the file name of the weights says none that open_clip knows
NO_WEIGHTS = "no weights of CLIP were given"
WEIGHT_SUFFIXES = (".pt", ".pth", ".bin", ".safetensors")  # ends of the names of files with weights
# A folder of weights has this beside them: what open_clip writes and what its models are published with.
CONFIG_FILE = "open_clip_config.json"
HUB_PREFIX = "hf-hub:"  # of the names of repositories of the hub that open_clip loads from
TEXT_BATCH = 64  # sentences that are read at once


@dataclass(frozen=True)
class ClipModel:
    """A model that compares pictures with words.

    Attributes:
        name: what is said of it in reports. weights_digest: digest of its weights, 64 hex digits.
        logit_scale: that cosines are multiplied with before they become shares.
        encode_images: pictures (PNG) -> (N, D) of length 1. encode_text: sentences -> (N, D) of length 1.
    """

    name: str
    weights_digest: str
    logit_scale: float
    encode_images: Callable[[Sequence[bytes]], Floats]
    encode_text: Callable[[Sequence[str]], Floats]


def require_weights(weights: str) -> None:
    """Check that weights can be loaded. Raises CasaError: nothing of that name, or open_clip is not installed."""
    place = Path(weights)
    if place.is_dir() and not (place / CONFIG_FILE).is_file():
        raise CasaError(f"{place}: holds no weights of CLIP: a folder of them has {CONFIG_FILE} beside them")
    if not place.exists() and (place.suffix in WEIGHT_SUFFIXES or place.is_absolute()):
        raise CasaError(f"{place}: there are no weights of CLIP")
    require("open_clip", "clip", "CLIP")


def load_clip(weights: str) -> ClipModel:
    """Load CLIP with these weights, on the CPU.

    Args:
        weights: a checkpoint of open_clip on this machine, its name beginning with that of the architecture, such as
            `ViT-B-32-laion2b.pt`; or a folder that holds one with `open_clip_config.json`; or, to be downloaded
            if it is not in the cache yet, `ViT-B-32/laion2b_s34b_b79k` or `hf-hub:...` as open_clip names them.
    Raises:
        CasaError: no weights have that name, they cannot be loaded, or open_clip is not installed.
    """
    require_weights(weights)
    import open_clip
    import torch

    architecture, pretrained = _architecture_of(Path(weights), weights, open_clip)
    torch.manual_seed(0)
    try:
        # This one refuses to go on with weights drawn at random where it finds none.
        model, prepare = open_clip.create_model_from_pretrained(architecture, pretrained=pretrained)
        tokens = open_clip.get_tokenizer(architecture)
    except Exception as error:  # whatever a broken file or a network that is not there raises
        raise CasaError(f"{weights}: these weights of CLIP cannot be loaded: {error}".split("\n")[0]) from error
    model.eval()

    def encode_images(pictures: Sequence[bytes]) -> Floats:
        with torch.no_grad():
            stack = torch.stack([prepare(Image.open(io.BytesIO(p)).convert("RGB")) for p in pictures])
            return _normalized(model.encode_image(stack).numpy())

    def encode_text(sentences: Sequence[str]) -> Floats:
        with torch.no_grad():
            parts = [sentences[i : i + TEXT_BATCH] for i in range(0, len(sentences), TEXT_BATCH)]
            return _normalized(np.concatenate([model.encode_text(tokens(list(part))).numpy() for part in parts]))

    return ClipModel(
        Path(weights).name, weights_digest(weights), float(model.logit_scale.exp()), encode_images, encode_text
    )


def _architecture_of(place: Path, name: str, open_clip: Any) -> tuple[str, str | None]:
    """Architecture and weights as open_clip asks for them."""
    if place.is_dir():
        return f"local-dir:{place.resolve()}", None
    if place.is_file():
        architectures = sorted(
            (n for n in open_clip.list_models() if place.name.startswith(n)), key=lambda n: (-len(n), n)
        )
        return (architectures[0] if architectures else DEFAULT_ARCHITECTURE), str(place)
    if name.startswith(HUB_PREFIX):
        return name, None
    architecture, _, tag = name.partition("/")
    if (architecture, tag) not in open_clip.list_pretrained():
        tags = ", ".join(sorted(t for a, t in open_clip.list_pretrained() if a == architecture)[:5])
        message = f"open_clip has of {architecture}: {tags}" if tags else "such as ViT-B-32/laion2b_s34b_b79k"
        raise CasaError(f"{name}: there are no weights of CLIP of that name, neither a file nor a folder; {message}")
    return architecture, tag


def weights_digest(weights: str) -> str:
    """Digest of the weights where they lie on this machine, else of their name."""
    place = Path(weights)
    whole = hashlib.sha256(b"" if place.exists() else weights.encode())
    for path in sorted(p for p in place.rglob("*") if p.is_file()) if place.is_dir() else [place] * place.is_file():
        with path.open("rb") as file:
            whole.update(hashlib.file_digest(file, "sha256").digest())
    return whole.hexdigest()


def _normalized(rows: npt.NDArray[Any]) -> Floats:
    values = rows.astype(np.float64)
    return np.asarray(values / np.linalg.norm(values, axis=1, keepdims=True))


def class_shares(image_features: Floats, text_features: Floats, logit_scale: float) -> Floats:
    """(C,) how well each of (C, D) sentences fits (N, D) pictures of one thing, as shares that add up to 1."""
    logits = logit_scale * (image_features @ text_features.T).mean(axis=0)
    exponentials: Floats = np.exp(logits - logits.max())
    return np.asarray(exponentials / exponentials.sum())


def load_scorer(weights: Path) -> Scorer:
    """A scorer with these weights, see `load_clip`. Raises CasaError as that does."""
    model = load_clip(str(weights))

    def scores(pictures: Sequence[bytes], names: Sequence[str]) -> tuple[float, ...]:
        text_features = model.encode_text([PROMPT.format(n) for n in names])
        return tuple(
            round(float(s), 4) for s in class_shares(model.encode_images(pictures), text_features, model.logit_scale)
        )

    return scores


def classify_by_look(asset: Asset, score: Scorer) -> tuple[str, float, str]:
    """The kind that a thing looks like, how sure, and why; an empty kind where it looks like none.

    Args:
        asset: under any category; its front faces -y.
    """
    kinds = list(KIND_PHRASES)
    found = score(render_asset_views(asset), list(KIND_PHRASES.values()))
    best = max(range(len(kinds)), key=lambda i: (found[i], -i))
    message = f"CLIP says {KIND_PHRASES[kinds[best]]}"
    if kinds[best] == "other" or found[best] < LEAST_SHARE:
        return "", found[best], f"{message} at {found[best]:.0%}, which names nothing"
    return kinds[best], found[best], message


def render_asset_views(asset: Asset) -> list[bytes]:
    """PNGs of a thing from a few sides, with the look that it came with."""
    from casa_assets.formats import mjcf

    with tempfile.TemporaryDirectory() as folder:
        write_files(Path(folder), mjcf.write(asset))
        return render_model_views(Path(folder) / "model.xml")


def render_model_views(model: Path) -> list[bytes]:
    """Return PNGs of an asset on disk, given by its model.xml, from the sides of VIEWS."""
    from casa_assets.show.stills.still import render
    from casa_assets.show.stills.studio import View

    return [render(model, View(azimuth_deg=a, elevation_deg=e, size_px=PICTURE_PX, passes=4)) for a, e in VIEWS]


# Smallest cosine between the pictures of a pair that is reported; the limit of the check is stricter.
MIN_COSINE = 0.9


def image_embeddings(row: AssetRow, eye: ClipModel, store: Store) -> Floats:
    """(V, D) unit embeddings of the pictures of an asset; taken from the store if they are there."""
    words = ["pictures", key_of(render_model_views), eye.weights_digest, row.digest]
    return _cached(store, words, lambda: eye.encode_images(render_model_views(checked_model(row.folder / "model.xml"))))


def text_embedding(phrases: Sequence[str], eye: ClipModel, store: Store) -> Floats:
    """(D,) mean embedding of several phrases, of length 1."""
    found = _cached(store, ["words", eye.weights_digest, *phrases], lambda: eye.encode_text(phrases))
    mean: Floats = found.mean(axis=0)
    return mean / float(np.linalg.norm(mean))


def likenesses(
    seen: Mapping[str, Floats], rows: Sequence[AssetRow], eye: ClipModel, store: Store
) -> Iterator[CategoryRank]:
    """Rank the categories of the registry by how well they fit the pictures of each asset.

    Args:
        seen: id -> (V, D) numbers of its pictures. rows: the assets.
    """
    if not rows:
        return
    categories = [category for category in registry.load().categories.values() if category.id != registry.FALLBACK]
    text_embeddings = np.array([text_embedding(clip_prompts(category), eye, store) for category in categories])
    for row in rows:
        shares = class_shares(seen[row.id], text_embeddings, eye.logit_scale).tolist()
        both = sorted(zip(shares, categories, strict=True), key=lambda one: (-one[0], one[1].id))
        ranked = [(category.id, round(share, 4)) for share, category in both]
        rank = next((n for n, (name, _) in enumerate(ranked, start=1) if name == row.category), 0)
        others = tuple(one for one in ranked if one[0] != row.category)[:NAMED]
        yield CategoryRank(row.id, row.category, ranked[rank - 1][1] if rank else 0.0, rank, others)


def similar_looking_pairs(seen: Mapping[str, Floats], min_cosine: float = MIN_COSINE) -> list[tuple[str, str, float]]:
    """Pairs of ids with the cosine between their mean embeddings, if that is at least `min_cosine`, nearest first."""
    names = list(seen)
    if len(names) < 2:
        return []
    means = np.array([seen[name].mean(axis=0) for name in names])
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    pairs = []
    for i in range(len(names) - 1):
        cosines = means[i + 1 :] @ means[i]
        pairs += [
            (names[i], names[i + 1 + int(j)], round(float(cosines[j]), 4))
            for j in np.flatnonzero(cosines >= min_cosine)
        ]
    return sorted(pairs, key=lambda pair: (-pair[2], pair[0], pair[1]))


def _cached(store: Store, key_parts: Sequence[object], compute: Callable[[], Floats]) -> Floats:
    key = digest_of(*key_parts)
    stored = store.get(key)
    if stored is not None:
        return np.asarray(np.load(io.BytesIO(stored), allow_pickle=False), dtype=np.float64)
    values = compute()
    out = io.BytesIO()
    np.save(out, values.astype(np.float32), allow_pickle=False)
    with suppress(OSError):  # a library that may only be read
        store.put(key, out.getvalue())
    return values.astype(np.float32).astype(np.float64)
