"""In a real browser: a motion that is played, and the page in a notebook."""

import json

import pytest

import escapement as esc
from browser import chromium, opened, until
from escapement.explorer import player

pytestmark = pytest.mark.slow

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(4, crank_radius=0.02)
TIMER = esc.Escapement(WHEEL, INERTIA, torque=0.0113, friction=0.2)


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.mark.parametrize("name", ["gear-driven", "contact"])
def test_a_motion_is_played_without_any_request(browser, tmp_path, name):
    wheel = esc.GearDriven(4, 1, "epicycloid")
    timer = esc.Escapement(wheel, INERTIA, torque=0.0113, friction=0.05)
    if name == "contact":
        wheel = esc.Geneva(4, crank_radius=0.02, pin_radius=1e-3, clearance=5e-5)
        timer = esc.Escapement(wheel, INERTIA, torque=0.0113, friction=0.2)
    motion = esc.simulate(timer, 4)
    file = tmp_path / "motion.html"
    file.write_text(player(motion), encoding="utf-8")
    with opened(browser, file, reduced_motion="no-preference") as page:
        until(page, "explorer.time > 0")
        page.keyboard.press(" ")
        page.evaluate("explorer.setTime(0)")
        before = page.get_attribute("#picture .follower", "transform")
        page.keyboard.press(".")
        assert 0.0 < page.evaluate("explorer.time") <= motion.end_time
        page.evaluate(f"explorer.setTime({motion.handoff_times[0]})")
        assert page.get_attribute("#picture .follower", "transform") != before
        assert not page.locator("#fields").is_visible()


def test_a_cell_of_a_notebook_plays_the_motion(browser, tmp_path):
    motion = esc.simulate(TIMER, 5, initial_speed=2.0)
    file = tmp_path / "cell.html"
    file.write_text(motion._repr_html_(), encoding="utf-8")
    page = browser.new_page(reduced_motion="reduce", viewport={"width": 900, "height": 900})
    page.goto(file.as_uri())
    frame = page.frame_locator("iframe")
    told = frame.locator("#picture").evaluate("() => explorer.motion.handoff_times")
    assert told == pytest.approx(motion.handoff_times, rel=1e-10)
    assert frame.locator("#picture").is_visible()
    assert not frame.locator("#fields").is_visible()
    page.close()


HARNESS = """<iframe hidden></iframe><div id="cell"></div><script type="module">
const told = TOLD, heard = {};
const model = {
  get: (name) => told[name], set: (name, value) => { told[name] = value; }, off: () => {},
  save_changes: () => { window.saved = { ...told.design }; },
  on: (name, call) => { heard[name] = call; },
};
const module = new Blob([told.esm], { type: "text/javascript" });
const { default: widget } = await import(URL.createObjectURL(module));
widget.render({ model, el: document.getElementById("cell") });
window.set = (design) => { told.design = design; heard["change:design"](); };
</script>"""


def test_in_a_notebook_the_design_goes_both_ways(browser, tmp_path):
    shown = esc.plots.explore(TIMER)
    told = {"page": shown.page, "height": shown.height, "design": {}, "esm": str(shown._esm)}
    file = tmp_path / "cell.html"
    text = json.dumps(told).replace("<", "\\u003c")
    file.write_text(HARNESS.replace("TOLD", text), encoding="utf-8")
    page = browser.new_page(reduced_motion="reduce")
    wrong = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(file.as_uri())
    frame = page.frame_locator("#cell iframe")
    frame.locator("#friction").fill("0.15")
    until(page, "window.saved?.friction === 0.15")
    page.evaluate("window.set({...window.saved, friction: 0.25})")
    until(page, "window.saved.friction === 0.25")
    assert frame.locator("#friction").input_value() == "0.25"
    page.close()
    assert wrong == []
