"""In a real browser: the page that a server sends, a motion that is played, and the notebook."""

import json

import pytest

import escapement as esc
from browser import chromium, opened, until
from escapement.explorer import player
from escapement.explorer.serve import serving
from escapement.explorer.served_page import server_of
from escapement.study.parse import parse_plan

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
WHEEL = esc.Geneva(4, crank_radius=0.02)
TIMER = esc.Escapement(WHEEL, INERTIA, torque=0.0113, friction=0.2)
ENGINE = "explorer.motion.engine"


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("served") / "study.h5"
    esc.sweep(TIMER, friction=[0.1, 0.2, 0.3], path=path)
    return esc.read_study(path)


@pytest.fixture
def page(browser, study):
    plan = parse_plan(study.configuration)
    server = server_of(TIMER, plan=plan, study=study)
    with serving(server), opened(browser, server.url) as found:
        yield found


def problem(page):
    return page.locator("#problem").inner_text()


def test_the_package_computes_what_the_page_does_not(page):
    assert page.evaluate(ENGINE) == "this page"
    page.fill("#driver_viscous", "1e-5")
    until(page, f"{ENGINE} === 'energy'")
    timer = esc.Escapement(WHEEL, INERTIA, torque=0.0113, friction=0.2, driver_viscous=1e-5)
    figures = esc.terminal(timer)
    assert page.evaluate("explorer.motion.figures.period") == figures.period
    motion = esc.simulate(timer)
    state = motion.at(0.5 * motion.end_time)
    found = page.evaluate("explorer.motion.at(0.5 * explorer.motion.end_time)")
    for name in ("theta", "theta_dot", "phi", "phi_dot", "contact_moment"):
        assert found[name] == pytest.approx(float(getattr(state, name)), rel=1e-9)
    assert "driver_viscous = 1e-05" in page.input_value("#toml")
    page.fill("#friction", "-1")
    until(page, "document.getElementById('problem').textContent !== ''")
    assert "friction must be" in problem(page)
    assert page.evaluate("explorer.motion.figures.period") == figures.period
    page.fill("#friction", "0.1")
    page.fill("#driver_viscous", "0")
    until(page, f"{ENGINE} === 'this page' && explorer.design.friction === 0.1")
    page.select_option("#kind", "elliptical-planetary")
    until(page, f"{ENGINE} === 'energy' && document.getElementById('sun_radius') !== null")
    assert page.locator(".driving").count() == 1
    page.select_option("#kind", "geneva")
    until(page, f"{ENGINE} === 'this page' && document.getElementById('slots') !== null")


def test_a_mechanism_that_the_page_does_not_know_is_served_from_the_first(browser):
    wheel = esc.GearDriven(4, 1, "epicycloid")
    server = server_of(esc.Escapement(wheel, INERTIA, torque=0.0113, friction=0.05))
    with serving(server), opened(browser, server.url) as page:
        assert page.evaluate(ENGINE) == "energy"
        page.fill("#stations", "6")
        until(page, "explorer.design.stations === 6")
        page.fill("#friction", "0.5")
        until(page, "explorer.motion.status === 'painleve'")
        assert "no motion" in page.locator("#now").inner_text()
        page.locator("#stop button").first.click()
        assert page.evaluate(ENGINE) == "this page"
        assert page.locator("#slots").is_visible()


def test_a_text_of_any_study_is_read(page):
    curve = "[torque]\nangle = [0.0, 100.0]\ntorque = [0.012, 0.01]\n"
    text = "load_torque = 1e-4\n[mechanism]\nkind = 'geneva'\nslots = 4\n[inertia]\ndriver = 1e-6\n"
    text += "follower = 5e-6\n[sweep]\nfriction = [0.1]\n" + curve
    page.fill("#toml", text)
    page.click("#read")
    until(page, f"{ENGINE} === 'energy'")
    assert problem(page) == ""
    page.evaluate("document.getElementById('toml').value = 'torque = ['")
    page.click("#read")
    until(page, "document.getElementById('problem').textContent.includes('TOML')")
    assert page.evaluate(ENGINE) == "energy"


def test_a_cloud_follows_and_a_study_is_walked(page):
    page.evaluate("document.getElementById('clouds').open = true")
    page.fill("#tolerances [name=torque]", "6")
    until(page, "document.getElementById('cloud-told').textContent.includes(' cases in ')")
    slider = page.locator("#axes input")
    slider.fill("2")
    until(page, "explorer.design.friction === 0.3")
    assert "0.3" in page.locator("#axes output").inner_text()


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
