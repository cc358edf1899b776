"""Names of the files of a scene in its folder, and of the folder that scenes share."""

from __future__ import annotations

SHARED = "assets"
LIGHT_FILE = "scene_light.xml"
SCENE_JSON = "scene.json"
OVERVIEW = "overview"
