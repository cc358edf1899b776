"""Names of the files of a scene in its folder, and of the folder that scenes share."""

from __future__ import annotations

SHARED = "assets"
# In the shared folder: state machines, a file for each asset that has one.
BEHAVIOR = "behavior"
LIGHT_FILE = "scene_light.xml"
# All that is written of a scene, beside scene.json: MJCF, light MJCF, USD in two forms, and a script for Isaac Lab.
WRITTEN = ("scene.xml", LIGHT_FILE, "scene.usda", "scene_nested.usda", "isaac_lab.py")
BATCH_FILE, BATCH_JSON = "scene_batch.xml", "batch.json"
SCENE_JSON = "scene.json"
ROBOTS_JSON = "robots.json"
START_STATES = "start_states.npz"
OVERVIEW = "overview"
# Picture at eye level, with doors open.
EYE_PICTURE = "eye_open.png"
