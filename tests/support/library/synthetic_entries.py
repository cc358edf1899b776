"""Entries of a library drawn at random, as tables and searches meet them: no file is written."""

from __future__ import annotations

import hashlib
import random
from collections.abc import Iterator
from functools import partial
from typing import Any

from casa_assets import registry
from casa_assets.library.entry import Entry
from casa_assets.library.entry_files import Summary
from casa_assets.model.issue import REVIEW_CODE, Issue, Severity, Tally

REJECTED_SHARE, REVIEW_SHARE, ADVICE_SHARE = 0.15, 1 / 12, 0.5
# Reasons of rejections with their weights.
REASONS = {"RUN007": 40, "MSH002": 15, "SRC002": 10, "AST009": 10, "FLT005": 10, "RUN001": 8, "RUN002": 5, "SRC004": 2}
ADVICE = ("SRC042", "GEO004", "FLT010")
SUBJECTS = ("scale", "mass", "category", "up_axis")
LICENCES = ("CC-BY-4.0", "CC0-1.0", "CC-BY-NC-4.0", "unknown")
SOURCES = ("objaverse", "folder", "manifest")
WORDS = ("red", "old", "small", "low poly", "scan", "antique", "kitchen", "set", "plain", "v2")
# Categories that are asked for, and their place among all, the most frequent one first: about 8,000 in a million.
ASKED, PLACE = ("mug", "bowl"), 20


def synthetic_entries(count: int, seed: int = 0) -> Iterator[Entry]:
    draw = random.Random(seed)
    known = registry.load().categories
    names = sorted(known.keys() - set(ASKED))
    random.Random(0).shuffle(names)
    names[PLACE:PLACE] = ASKED
    categories = [(name, known[name]) for name in names]
    chosen = draw.choices(categories, [1 / (i + 1) for i in range(len(categories))], k=count)
    reasons = draw.choices(list(REASONS), list(REASONS.values()), k=count)
    for number, (name, category) in enumerate(chosen):
        sha256 = hashlib.sha256(f"{seed} {number}".encode()).hexdigest()
        made: dict[str, Any] = {
            "id": f"{name}_{sha256[:10]}",
            "category": name,
            "source": draw.choices(SOURCES, (8, 1, 1))[0],
            "source_path": f"glbs/000-{number % 160:03}/{sha256[:32]}.glb",
            "sha256": sha256,
            "title": f"{draw.choice(WORDS)} {name.replace('_', ' ')} {draw.choice(WORDS)}",
            "author": f"author {draw.randrange(50_000)}",
            "licence": draw.choices(LICENCES, (80, 10, 5, 5))[0],
            "producer": "ingest",
            "cache_key": "5" * 64,
        }
        is_good = draw.random() >= REJECTED_SHARE
        made |= _accepted(category, draw) if is_good else {"code": reasons[number], "message": "is broken; mend it"}
        made["path"] = f"{name if is_good else 'rejected'}/{made['id']}"
        made["digest"] = sha256[::-1] if is_good else ""
        yield Entry(**{"accepted": False, **made})


def _accepted(category: Any, draw: random.Random) -> dict[str, Any]:
    longest = category.longest_m.typical * draw.lognormvariate(0, 0.25)
    summary = Summary.model_construct(
        extents=tuple([longest * share for share in category.shape]),
        mass=category.mass_kg.typical * draw.lognormvariate(0, 0.4),
        colliders=draw.randint(1, 32),
        hull_vertices=64,
        faces=draw.randint(100, 20_000),
    )
    told = [(REVIEW_CODE, draw.choice(SUBJECTS))] if draw.random() < REVIEW_SHARE else []
    told += [(draw.choice(ADVICE), "")] if draw.random() < ADVICE_SHARE else []
    warning = partial(Issue.model_construct, severity=Severity.WARNING, message="")
    return {
        "accepted": True,
        "summary": summary,
        "split": "test" if draw.random() < 0.2 else "train",
        "checks": Tally(58, len(told), 1, 14, len(told)),
        "colors": ((draw.choice(("red", "white", "grey", "brown")), 0.7), ("black", 0.2)),
        "warnings": tuple(warning(code=code, pointer=pointer) for code, pointer in told),
    }
