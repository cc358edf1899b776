"""The folder that keeps what is costly to make between runs."""

from __future__ import annotations

import math
import os
from pathlib import Path

import platformdirs

from casa_assets.errors import CasaError

VARIABLE = "CASA_ASSETS_CACHE"
SIZE_VARIABLE = "CASA_ASSETS_CACHE_GB"
# Room for each of the 400 textures (1.2 MB) in four versions, and for 25,000 built assets (40 kB).
DEFAULT_GB = 4.0


def cache_dir() -> Path:
    """The folder in which functions called from Python keep built assets and painted textures between runs.

    It is the environment variable CASA_ASSETS_CACHE where that is set, else the user's cache folder of this platform,
    such as `~/.cache/casa-assets` (`$XDG_CACHE_HOME/casa-assets` where that is set). It is made when something is first
    kept in it, and removing it costs time and nothing else. What was used longest ago is removed where it grows over
    4 GB, or over the number of the environment variable CASA_ASSETS_CACHE_GB. The command line keeps its cache beside
    its output, within the same bound.

    Returns:
        Absolute path; the folder need not exist yet.
    """
    stated = os.environ.get(VARIABLE)
    if stated:
        return Path(stated).expanduser().absolute()
    return platformdirs.user_cache_path("casa-assets", appauthor=False)


def max_cache_bytes() -> int:
    """Bytes that painted textures and built assets of one cache may take together.

    Raises:
        CasaError: the environment variable CASA_ASSETS_CACHE_GB is no number of gigabytes.
    """
    stated = os.environ.get(SIZE_VARIABLE) or str(DEFAULT_GB)
    try:
        gigabytes = float(stated)
    except ValueError:
        gigabytes = math.nan
    if not 0 <= gigabytes < math.inf:
        raise CasaError(f"{SIZE_VARIABLE}={stated}: give gigabytes, such as 4 or 0.5; 0 keeps nothing")
    return int(gigabytes * 1e9)
