"""Show assets and kitchens in MuJoCo's viewer, or on a page in the browser."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from typing import Any

from casa_assets.api.behaviors import Behaviors
from casa_assets.errors import OutputError
from casa_assets.show.local_server import open_in_browser
from casa_assets.show.view.model import asset_of, make, mujoco_model
from casa_assets.show.view.server import ViewServer, Workshop
from casa_assets.show.view.subject import ModelFile, Subject, cache_of


def has_screen() -> bool:
    """True if windows can be opened."""
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def show(subject: Subject, pose: str, web: bool) -> None:
    """Show a subject in MuJoCo's viewer, or on a page without a screen or with `web`, until the user ends it."""
    if not web and has_screen():
        show_model(mujoco_model(subject, cache_of(subject), lambda *_: None), pose, subject.id)
        return
    with serving(subject, pose) as server, suppress(KeyboardInterrupt):
        sys.stderr.write(f"{subject.id} is shown at {server.address}; Ctrl-C ends it\n")
        if not os.environ.get("SSH_CONNECTION"):
            open_in_browser(server.address)
        server.serve_forever()


def show_model(model: Any, pose: str, name: str) -> None:
    """Show a compiled model in MuJoCo's viewer, with its state machines, until its window is closed."""
    from casa_assets.show.stills.live_viewer import Glow
    from casa_assets.show.stills.live_viewer import show as open_viewer

    behaviors, glow = Behaviors(model), Glow(model)

    def each_frame(_: Any, data: Any) -> None:
        if data.time == 0.0:
            behaviors.reset(data)
        else:
            behaviors.update(data)
        glow.show(behaviors.effects)

    open_viewer(model, pose, name, each_frame)


def serving(subject: Subject, pose: str, port: int = 0) -> ViewServer:
    """Return a server of the page of a subject; 0: any port that is free.

    Raises:
        CasaError: there is no record that a page can be made from. OutputError: the port cannot be used.
    """
    cache = cache_of(subject)
    if isinstance(subject, ModelFile):
        asset_of(subject, cache)
    try:
        return ViewServer(subject, Workshop(lambda wanted, tell: make(wanted, cache, tell)), pose, port)
    except (OSError, OverflowError) as error:
        raise OutputError(f"port {port}", f"cannot be used: {error}; leave --port out for one that is free") from error
