"""Drive Chromium by Playwright: a line of JSON on standard input calls a method, one on standard output is its answer.

Runs in the environment of tests/consumers/environments/browser.txt; tests use it by
`tests.support.program.browser.Browser`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import Error, Page, sync_playwright

# WebGL without a graphics card, nothing that asks for the network by itself.
ARGUMENTS = (
    *("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"),
    *("--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
)


class Driver:
    """One page at a time, with its console messages and requests; methods as those of `Page` of the tests."""

    def __init__(self, chromium: Any, axe: str) -> None:
        self.chromium = chromium
        self.axe = axe
        self.context: Any = None
        self.page: Page
        self.errors: list[str] = []
        self.requests: list[str] = []

    def open(self, url: str, width: int, height: int, dark: bool, touch: bool) -> None:
        if self.context is not None:
            self.context.close()
        scheme = "dark" if dark else "light"
        view = {"width": width, "height": height}
        self.context = self.chromium.new_context(viewport=view, color_scheme=scheme, has_touch=touch, is_mobile=touch)
        self.page = self.context.new_page()
        self.page.set_default_timeout(60_000)  # the processor draws, and others use it too
        self.errors, self.requests = [], []
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type in ("error", "warning") else None)
        self.page.on("pageerror", lambda e: self.errors.append(str(e)))
        self.page.on("request", lambda r: self.requests.append(r.url))
        self.page.goto(url)

    def told(self) -> dict[str, list[str]]:
        return {"errors": self.errors, "requests": self.requests}

    def evaluate(self, script: str) -> Any:
        return self.page.evaluate(script)

    def wait(self, selector: str, timeout_s: float = 60.0) -> None:
        self.page.locator(selector).first.wait_for(timeout=timeout_s * 1000)

    def pause(self, seconds: float) -> None:
        self.page.wait_for_timeout(seconds * 1000)

    def click(self, selector: str) -> None:
        self.page.locator(selector).first.click()

    def click_at(self, x: float, y: float) -> None:
        self.page.mouse.click(x, y)

    def tap_at(self, x: float, y: float) -> None:
        self.page.touchscreen.tap(x, y)

    def drag(self, x: float, y: float, to_x: float, to_y: float) -> None:
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        self.page.mouse.move((x + to_x) / 2, (y + to_y) / 2, steps=3)
        self.page.mouse.move(to_x, to_y, steps=3)
        self.page.mouse.up()

    def wheel(self, x: float, y: float, by: float) -> None:
        self.page.mouse.move(x, y)
        self.page.mouse.wheel(0, by)

    def fill(self, selector: str, value: str) -> None:
        self.page.locator(selector).first.fill(value)

    def press(self, key: str, selector: str = "") -> None:
        if selector:
            self.page.locator(selector).first.press(key)
        else:
            self.page.keyboard.press(key)

    def violations(self) -> list[dict[str, Any]]:
        """What axe-core finds seriously wrong for people who use a keyboard or a screen reader."""
        # By the protocol and not as a script element, which the policy of a page may refuse.
        self.page.evaluate(f"() => {{ {self.axe} }}")
        found = self.page.evaluate("() => axe.run(document)")
        return [
            {"id": v["id"], "impact": v["impact"], "help": v["help"], "nodes": [n["html"][:200] for n in v["nodes"]]}
            for v in found["violations"]
            if v["impact"] in ("serious", "critical")
        ]


def main() -> None:
    program, axe = sys.argv[1:]
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=program, args=list(ARGUMENTS))
        driver = Driver(chromium, Path(axe).read_text(encoding="utf-8"))
        for line in sys.stdin:
            do, *words = json.loads(line)
            try:
                answer = {"value": getattr(driver, do)(*words)}
            except Error as error:
                answer = {"error": str(error)}
            print(json.dumps(answer), flush=True)
        chromium.close()


if __name__ == "__main__":
    main()
