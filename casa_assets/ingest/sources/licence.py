"""Map a source's word for a licence to its SPDX id."""

from __future__ import annotations

import re

# Objaverse uses Sketchfab's slugs, which are Creative Commons 4.0. Ref: https://objaverse.allenai.org/objaverse-1.0
_SLUGS = {
    "by": "CC-BY-4.0",
    "by-sa": "CC-BY-SA-4.0",
    "by-nd": "CC-BY-ND-4.0",
    "by-nc": "CC-BY-NC-4.0",
    "by-nc-sa": "CC-BY-NC-SA-4.0",
    "by-nc-nd": "CC-BY-NC-ND-4.0",
    "cc0": "CC0-1.0",
    "publicdomain": "CC0-1.0",
    "mit": "MIT",
    "mit-0": "MIT-0",
    "apache": "Apache-2.0",
    "bsd-3-clause": "BSD-3-Clause",
    "bsd-2-clause": "BSD-2-Clause",
}
# The long names that GitHub and Sketchfab show.
_NAMES = {
    "mit license": "MIT",
    "apache license 2.0": "Apache-2.0",
    "creative commons attribution": "CC-BY-4.0",
    "creative commons attribution 4.0 international": "CC-BY-4.0",
    "creative commons attribution share alike 4.0 international": "CC-BY-SA-4.0",
    "creative commons zero v1.0 universal": "CC0-1.0",
    "cc0 public domain": "CC0-1.0",
    "the unlicense": "Unlicense",
    'bsd 3-clause "new" or "revised" license': "BSD-3-Clause",
    'bsd 2-clause "simplified" license': "BSD-2-Clause",
    "gnu general public license v3.0": "GPL-3.0-only",
    "gnu general public license v2.0": "GPL-2.0-only",
}
# SPDX ids in any case. Ref: hubs of models and data sets write them small.
_IDS = {spdx_id.lower(): spdx_id for spdx_id in (*_SLUGS.values(), *_NAMES.values())}
_CREATIVE = re.compile(r"cc[ -](by(?:-(?:nc|sa|nd)){0,2})[ -]v?(\d\.\d)")


def spdx_id(word: str) -> str:
    """SPDX id where the word maps to one, the word itself where not, `unknown` where it is empty."""
    text = " ".join(word.split())
    key = text.lower()
    if not key:
        return "unknown"
    if key in _SLUGS or key in _NAMES:
        return _SLUGS.get(key) or _NAMES[key]
    if key in _IDS:
        return _IDS[key]
    creative = _CREATIVE.fullmatch(key.replace(" by ", "-by-").replace("by nc", "by-nc"))
    if creative:
        return f"CC-{creative.group(1).upper()}-{creative.group(2)}"
    return text[:80]
