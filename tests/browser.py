"""A headless Chromium for the tests of the page; the page may load nothing but itself."""

import shutil
from contextlib import contextmanager

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")


def found():
    return next(filter(None, map(shutil.which, NAMES)), None)


@contextmanager
def chromium():
    """A browser; the tests are skipped where there is none."""
    path = found()
    if path is None:
        pytest.skip(f"no browser is installed under any of the names {', '.join(NAMES)}")
    playwright = pytest.importorskip("playwright.sync_api")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


@contextmanager
def opened(browser, file, fragment="", **options):
    """A page of a file; every request, error and warning fails the test."""
    page = browser.new_page(**{"reduced_motion": "reduce", **options})
    wrong = []
    address = file.as_uri()

    def asked(request):
        if request.url.partition("#")[0] != address and not request.url.startswith(
            ("data:", "blob:")
        ):
            wrong.append(f"request for {request.url}")

    page.on("request", asked)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text))
    page.goto(address + fragment)
    yield page
    page.close()
    assert not wrong


def until(page, expression):
    """Wait until an expression is true; the page itself forbids the way of Playwright."""
    for _ in range(200):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    raise AssertionError(expression)
