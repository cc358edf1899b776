"""casa-assets view: which viewer opens, what is printed where, how it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import urllib.request
from pathlib import Path

import pytest
from typer.testing import CliRunner

import casa_assets as casa
from casa_assets.api import assets as viewing
from casa_assets.cli.main import app
from casa_assets.show.stills import live_viewer
from tests.support.library.libraries import command

RUNNER = CliRunner()
PATIENCE_S = 60


def without_screen(**more: str) -> dict[str, str]:
    """The environment of a machine that nobody sits at."""
    hidden = ("DISPLAY", "WAYLAND_DISPLAY", "SSH_CONNECTION")
    return {**{name: value for name, value in os.environ.items() if name not in hidden}, **more}


def test_serves_a_page_until_it_is_stopped(tmp_path: Path) -> None:
    running = subprocess.Popen(
        command("view", "mug"),
        cwd=tmp_path,
        env=without_screen(SSH_CONNECTION="10.0.0.2 50000 10.0.0.9 22", USER="ada"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert running.stdout is not None
    address = running.stdout.readline().strip()
    with urllib.request.urlopen(address, timeout=PATIENCE_S) as answer:
        assert b"mug" in answer.read()
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=PATIENCE_S)
    port = address.rstrip("/").rpartition(":")[2]
    assert address == f"http://127.0.0.1:{port}/"
    assert (running.returncode, out) == (0, "")
    assert f"ssh -N -L {port}:127.0.0.1:{port} ada@10.0.0.9" in err
    assert "Ctrl-C ends it" in err
    assert list(tmp_path.iterdir()) == []


def test_with_a_screen_mujoco_shows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("DISPLAY", ":99")
    shown = []
    monkeypatch.setattr(live_viewer, "require_screen", lambda: None)
    monkeypatch.setattr(live_viewer, "show", lambda model, pose, name, _: shown.append((model.nkey, pose, name)))
    done = RUNNER.invoke(app, ["view", "microwave/steel", "--pose", "open"])
    assert done.exit_code == 0, done.output
    assert shown == [(2, "open", "microwave/steel")]
    assert done.stdout == ""
    microwave = casa.build("microwave", "steel")
    microwave.show("open")
    assert shown[1:] == [(2, "open", microwave.id)]


def test_a_screen_is_one_of_x_or_wayland(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not viewing.has_screen()
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert viewing.has_screen()


def test_an_mjcf_without_a_record_needs_a_screen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "robot.xml").write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    done = RUNNER.invoke(app, ["view", str(tmp_path / "robot.xml"), "--web"])
    assert done.exit_code == 1
    assert "leave --web out" in str(done.exception)


def test_a_port_that_is_taken_is_told(tmp_path: Path) -> None:
    import socket

    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        done = RUNNER.invoke(app, ["view", "mug", "--web", "--no-browser", "--port", str(taken.getsockname()[1])])
    assert done.exit_code == 1
    assert "leave --port out" in str(done.exception)
