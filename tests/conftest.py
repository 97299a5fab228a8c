"""A browser, where one is; where HANDLAB_REQUIRE_BROWSER is set, one must be."""

import os
import shutil

import pytest

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
# Software WebGL, and no sandbox: builds run as root in containers.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


def absent(reason):
    """Skip, or fail where a browser is required."""
    if os.environ.get("HANDLAB_REQUIRE_BROWSER") == "1":
        pytest.fail(f"{reason}, and HANDLAB_REQUIRE_BROWSER=1 asks for it")
    pytest.skip(reason)


@pytest.fixture(scope="module")
def chromium():
    """A headless Chromium of the system."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        absent("playwright is not installed")
    path = next((found for name in PROGRAMS if (found := shutil.which(name))), None)
    if path is None:
        absent("no Chromium is installed (apt-get install chromium)")
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=FLAGS)
        yield browser
        browser.close()
