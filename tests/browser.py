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
    """A page of a file, or at an address; every request, error and warning fails the test.

    A page that is served may ask its own server.
    """
    page = browser.new_page(**{"reduced_motion": "reduce", **options})
    wrong = []
    address = file if isinstance(file, str) else file.as_uri()
    own = address.partition("?")[0] if isinstance(file, str) else address

    def asked(request):
        known = request.url.partition("#")[0] == address or request.url.startswith(
            ("data:", "blob:", *([own] if isinstance(file, str) else []))
        )
        if not known:
            wrong.append(f"request for {request.url}")

    def told(message):
        # a browser logs every question that a server refuses
        if "422" not in message.text:
            wrong.append(message.text)

    page.on("request", asked)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", told)
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
