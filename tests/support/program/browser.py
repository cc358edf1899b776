"""A real, headless Chromium for tests: opens a page, uses it, tells what it logged and asked for, takes a picture.

    def test_a_page(browser: Browser, tmp_path: Path) -> None:
        page = browser.open(tmp_path / "report.html")
        page.click("button")
        page.assert_clean()

The fixture `browser` of tests/consumers/conftest.py starts one for a session. See `./dev consumers`.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
HOME = ROOT / os.environ.get("CASA_BROWSER", ".venv-browser")
DRIVER = ROOT / "tests" / "consumers" / "browser_driver.py"
PROGRAMS = ("chromium", "chromium-browser", "google-chrome", "chrome")
LOCAL = ("file:", "blob:", "data:", "about:")
SERIOUS = ("serious", "critical")
TIMEOUT_S = 60.0  # pictures are drawn by the processor, which others use too


class Browser:
    """One process of Chromium with one page at a time."""

    def __init__(self) -> None:
        program = next((path for name in PROGRAMS if (path := shutil.which(name))), None)
        assert program is not None, "Chromium is needed: sudo apt-get install chromium"
        axe = HOME / "node" / "node_modules" / "axe-core" / "axe.min.js"
        assert axe.is_file(), f"{axe} is missing: ./dev consumers installs it"
        command = [str(HOME / "bin" / "python"), str(DRIVER), program, str(axe)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, do: str, **values: Any) -> Any:
        """The answer of the driver. Raises AssertionError with what Playwright says where it fails."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps({"do": do, **values}) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        assert line, f"the browser ended during {do!r}, code {self._process.poll()}"
        answer = json.loads(line)
        assert "error" not in answer, f"{do} {values}: {answer['error']}"
        return answer["value"]

    def open(
        self, page: Path | str, width: int = 1280, height: int = 800, dark: bool = False, touch: bool = False
    ) -> Page:
        """Open a file or an address; the page that was open before is gone."""
        url = page.absolute().as_uri() if isinstance(page, Path) else page
        self.ask("open", url=url, width=width, height=height, dark=dark, touch=touch)
        return Page(self, url)

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait(timeout=30)


@dataclass(frozen=True)
class Page:
    """The page that is open. Selectors are those of Playwright: CSS, `text=Open`, `role=button[name="Open"]`."""

    browser: Browser
    url: str

    def click(self, selector: str) -> None:
        """Click in the middle of an element."""
        self.browser.ask("click", selector=selector)

    def click_at(self, x: float, y: float) -> None:
        """Click at a place of the window, pixels."""
        self.browser.ask("click_at", x=x, y=y)

    def tap_at(self, x: float, y: float) -> None:
        """Touch a place of the window, pixels; the page has to be opened with `touch`."""
        self.browser.ask("tap_at", x=x, y=y)

    def drag(self, x: float, y: float, to_x: float, to_y: float) -> None:
        """Drag with the left button, pixels of the window."""
        self.browser.ask("drag", x=x, y=y, to_x=to_x, to_y=to_y)

    def wheel(self, x: float, y: float, by: float) -> None:
        """Turn the wheel above a place, pixels."""
        self.browser.ask("wheel", x=x, y=y, by=by)

    def fill(self, selector: str, value: str) -> None:
        """Put a value into a field or slider."""
        self.browser.ask("fill", selector=selector, value=value)

    def press(self, key: str, selector: str = "") -> None:
        """Press a key such as `ArrowLeft`, in an element where one is named."""
        self.browser.ask("press", key=key, selector=selector)

    def wait(self, selector: str, timeout_s: float = TIMEOUT_S) -> None:
        """Wait until something that a selector finds is seen."""
        self.browser.ask("wait", selector=selector, timeout_s=timeout_s)

    def pause(self, seconds: float) -> None:
        """Let the page go on for a while."""
        self.browser.ask("pause", seconds=seconds)

    def evaluate(self, script: str) -> Any:
        """Value of a JavaScript expression; a promise is waited for."""
        return self.browser.ask("evaluate", script=script)

    def texts(self, selector: str) -> list[str]:
        """Text of every element that a CSS selector finds and that is seen."""
        found: list[str] = self.evaluate(
            f"[...document.querySelectorAll({json.dumps(selector)})].filter(e => e.checkVisibility())"
            ".map(e => e.textContent.trim())"
        )
        return found

    @property
    def fits(self) -> bool:
        """Whether it need not be scrolled sideways."""
        return bool(self.evaluate("document.documentElement.scrollWidth <= innerWidth"))

    def screenshot(self, path: Path) -> Path:
        """Write a picture of the window; returns its path."""
        self.browser.ask("screenshot", path=str(path))
        return path

    @property
    def errors(self) -> list[str]:
        """Errors and warnings on the console so far."""
        found: list[str] = self.browser.ask("told")["errors"]
        return found

    @property
    def strange_requests(self) -> list[str]:
        """Addresses asked for that are neither on this disk nor of the server that the page came from."""
        own = self.url.split("/", 3)[:3]
        asked: list[str] = self.browser.ask("told")["requests"]
        return [url for url in asked if not url.startswith(LOCAL) and url.split("/", 3)[:3] != own]

    def violations(self, impacts: tuple[str, ...] = SERIOUS) -> list[dict[str, Any]]:
        """What axe-core finds wrong for people who use a keyboard or a screen reader."""
        found: list[dict[str, Any]] = self.browser.ask("violations", impacts=list(impacts))
        return found

    def assert_clean(self) -> None:
        """No error on the console, no request to elsewhere, nothing serious found by axe-core."""
        assert self.errors == []
        assert self.strange_requests == []
        assert self.violations() == []
