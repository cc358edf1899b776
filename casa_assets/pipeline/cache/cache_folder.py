"""The folder that keeps what is costly to make between runs."""

from __future__ import annotations

import os
from pathlib import Path

import platformdirs

VARIABLE = "CASA_ASSETS_CACHE"


def cache_dir() -> Path:
    """The folder in which functions called from Python keep built assets and painted textures between runs.

    It is the environment variable CASA_ASSETS_CACHE where that is set, else the user's cache folder of this platform,
    such as `~/.cache/casa-assets` (`$XDG_CACHE_HOME/casa-assets` where that is set). It is made when something is first
    kept in it, and removing it costs time and nothing else. The command line keeps its cache beside its output.

    Returns:
        Absolute path; the folder need not exist yet.
    """
    said = os.environ.get(VARIABLE)
    if said:
        return Path(said).expanduser().absolute()
    return platformdirs.user_cache_path("casa-assets", appauthor=False)
