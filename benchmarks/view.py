"""Seconds from `casa-assets view` to the first picture on its page, in headless Chromium.

    ./dev bench view                                 a kitchen and an asset
    ./dev bench view u_small__rustic apple/3         others

Each is looked at twice, so that in the second turn all that it is made of comes out of the cache. `address`: seconds
from the command to the line with the address; `model`: from there until the server has the model; `picture`: from the
command to the second frame in which the model is drawn, by a browser that was started before and draws with the
processor alone (SwiftShader): a graphics card is faster. `GLB`: megabytes of the model. Needs the environment of
`./dev consumers` with Chromium.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
import urllib.parse
import urllib.request
from pathlib import Path
from typing import NamedTuple

from tests.browser import Browser

SUBJECTS = ("l_small__coastal", "microwave/steel")
TURNS = ("first", "again")
SHOWN = "body[data-shown]"
PATIENCE_S = 600.0


class Turn(NamedTuple):
    """What one look took, seconds, and the size of the model, megabytes."""

    subject: str
    name: str
    address_s: float
    model_s: float
    picture_s: float
    glb_mb: float


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("subjects", nargs="*", default=SUBJECTS, help="what `casa-assets view` takes")
    subjects = parser.parse_args().subjects
    browser = Browser()
    try:
        browser.open("about:blank")
        print("| | turn | address, s | model, s | picture, s | GLB, MB |\n|---|---|---|---|---|---|")
        for subject in subjects:
            for name in TURNS:
                turn = look(subject, name, browser)
                numbers = f"{turn.address_s:.1f} | {turn.model_s:.1f} | {turn.picture_s:.1f} | {turn.glb_mb:.1f}"
                print(f"| {turn.subject} | {turn.name} | {numbers} |", flush=True)
    finally:
        browser.close()


def look(subject: str, turn: str, browser: Browser) -> Turn:
    """Start the command, wait for its picture, end it."""
    begin = time.monotonic()
    command = [str(Path(sys.executable).with_name("casa-assets")), "view", subject, "--web", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as running:
        try:
            assert running.stdout is not None
            address = running.stdout.readline().strip()
            address_s = time.monotonic() - begin
            page = browser.open(address)
            page.wait(f"{SHOWN}, body[data-failed]", PATIENCE_S)
            picture_s = time.monotonic() - begin
            shown = page.evaluate("document.body.dataset.shown ?? ''")
            if not shown:
                raise SystemExit(f"{subject}: {page.texts('#progress')}")
            name = urllib.parse.quote(shown, safe="")
            model_s = json.loads(fetched(f"{address}progress/{name}"))["seconds"]
            size = len(fetched(f"{address}model/{name}.glb"))
        finally:
            os.kill(running.pid, signal.SIGINT)
    return Turn(subject, turn, address_s, model_s, picture_s, size / 1e6)


def fetched(address: str) -> bytes:
    """What a server of ours answers."""
    with urllib.request.urlopen(address) as answer:
        body: bytes = answer.read()
    return body


if __name__ == "__main__":
    main()
