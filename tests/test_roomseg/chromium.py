"""Debian's Chromium, driven by Playwright, where there is one."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium; setup.sh installs it where it can"
)

FIND_FIGURE = """() => {
  const find = (view) => view.model.type == "Figure" ? view :
    (view.child_views ?? []).map(find).find((found) => found != null)
  return [...Bokeh.index.roots].map(find).find((found) => found != null)
}"""
"""Code that finds Bokeh's view of the plot."""
TO_PAGE = """([x, y]) => {
  const view = (FIND)()
  const corner = view.canvas_view.el.getBoundingClientRect()
  const {x_scale, y_scale} = view.frame
  return [corner.left + x_scale.compute(x), corner.top + y_scale.compute(y)]
}""".replace("FIND", FIND_FIGURE)
"""Code that tells where on the page a point of the plot is."""


@contextmanager
def chromium() -> Iterator[Any]:
    """A browser without a window."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"]
        )
        yield browser
        browser.close()
