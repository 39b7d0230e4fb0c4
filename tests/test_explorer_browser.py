"""The page in a real browser: its kernel against the Python engine, and what a reader does."""

import json
import tomllib
from xml.etree import ElementTree

import numpy as np
import pytest

import escapement as esc
from browser import chromium, opened, until
from escapement import explorer
from escapement.explorer.fields import design_of
from escapement.outlines.geneva import GenevaOutline
from escapement.study.parse import parse_plan

pytestmark = pytest.mark.slow

DESIGN = {
    "slots": 4, "crank_radius": 0.02, "driver_inertia": 3.39e-7, "follower_inertia": 5.65e-6,
    "torque": 0.0113, "friction": 0.35,
}  # fmt: skip
OF_WHEEL = ("slots", "pins", "internal", "crank_radius", "pin_radius")
OF_INERTIA = {"driver_inertia": "driver", "follower_inertia": "follower"}
# of every sixth the figures of the terminal cycle as well
SIMULATE_ALL = """designs => designs.map((design, i) => {
    const {status, end_time, handoff_times, handoff_velocities, reversals, extrema, ...rest} =
        explorer.simulate(design);
    const motion = {status, end_time, handoff_times, handoff_velocities, reversals, extrema};
    return {...motion, figures: i % 6 ? null : explorer.simulate(design).figures};
})"""
ON_TOP = """e => {
    const {left, right, top, bottom} = e.getBoundingClientRect();
    return document.elementFromPoint((left + right) / 2, (top + bottom) / 2) === e;
}"""


def escapement_of(design):
    wheel = esc.Geneva(**{name: design[name] for name in OF_WHEEL if name in design})
    inertia = esc.Inertia(**{key: design[name] for name, key in OF_INERTIA.items()})
    other = {*OF_WHEEL, *OF_INERTIA, "initial_speed", "engagements"}
    return esc.Escapement(
        wheel, inertia, **{name: value for name, value in design.items() if name not in other}
    )


@pytest.fixture(scope="module")
def browser():
    with chromium() as found:
        yield found


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("explorer") / "page.html"
    path.write_text(explorer.page(escapement_of(DESIGN)), encoding="utf-8")
    return path


@pytest.fixture
def page(browser, file):
    with opened(browser, file, viewport={"width": 1280, "height": 900}) as found:
        yield found


def random_design(rng):
    n, internal = int(rng.integers(3, 13)), bool(rng.random() < 0.25)
    most = 1 if internal else 2 * n // (n - 2)
    pins = most if rng.random() < 0.5 else int(rng.integers(1, most + 1))
    follower, torque = 10.0 ** rng.uniform(-7, -5), 10.0 ** rng.uniform(-3, 0)
    driver = follower * 10.0 ** rng.uniform(-2, 1)
    design = {"slots": n, "internal": internal, "pins": pins, "torque": torque}
    design |= {"driver_inertia": driver, "follower_inertia": follower}

    def some(share, **numbers):
        if rng.random() < share:
            design.update(numbers)

    if rng.random() < 0.6:
        crank = design["crank_radius"] = 0.02
        some(0.5, pin_radius=crank * rng.uniform(0.005, 0.08))
        for body in ("driver", "follower"):
            rubs = f"{body}_bearing_friction", f"{body}_bearing_radius"
            values = rng.uniform(0, 0.3), crank * rng.uniform(0, 0.1)
            some(0.4, **dict(zip(rubs, values, strict=True)))
    some(0.3, driver_bearing_torque=torque * rng.uniform(0, 0.3))
    some(0.3, driver_drag=follower * 10.0 ** rng.uniform(-4, -1))
    some(0.3, follower_drag=follower * 10.0 ** rng.uniform(-4, -1))
    some(0.2, spring_rate=torque * 10.0 ** rng.uniform(-4, -1.5))
    some(0.4, load_torque=torque * rng.uniform(0, 0.5))
    some(0.2, initial_speed=10.0 ** rng.uniform(-4, 2))
    return design


def test_the_kernel_agrees_with_the_engine_over_300_random_designs(page):
    rng = np.random.default_rng(30)
    designs = [random_design(rng) for _ in range(300)]
    limits = page.evaluate("designs => designs.map(explorer.criticalFriction)", designs)
    shares = (0.0, 0.5, 0.9, 0.99, 1.02)
    for i, (design, limit) in enumerate(zip(designs, limits, strict=True)):
        design["friction"] = min(limit, 50.0) * (shares[i % 10] if i % 10 < 5 else rng.random())
    found = page.evaluate(SIMULATE_ALL, designs)
    statuses = set()
    for i, (design, here) in enumerate(zip(designs, found, strict=True)):
        timer, speed = escapement_of(design), design.get("initial_speed", 0.0)
        motion = esc.simulate(timer, 20, initial_speed=speed)
        statuses.add(motion.status.label)
        assert here["status"] == motion.status.label, design
        if motion.end_time == 0.0:
            continue
        pairs = [("handoff_times", motion.handoff_times)]
        pairs += [("handoff_velocities", motion.handoff_velocities)]
        pairs = [(here[name], expected) for name, expected in pairs]
        for name in ("reversals", "extrema"):
            events = getattr(motion, name)
            rows = [(e["time"], e["theta"], e["speed"]) for e in here[name]]
            columns = np.array(rows).reshape(-1, 3).T
            # behind a spent spring the acceleration vanishes at the reversal itself, or all along
            turned = events.theta - timer.mechanism.breaks[0]
            held = turned * design.get("spring_rate", 0.0) < 0.999 * design["torque"]
            expected = (events.time, events.theta, events.theta_dot)
            assert held.all() or columns.shape[1] >= held.sum()
            columns = columns if held.all() else columns[:, : held.sum()]
            pairs += zip(columns, [column[held] for column in expected], strict=True)
        for one, two in pairs:
            np.testing.assert_allclose(one, two, rtol=1e-10, err_msg=str(design))
        if i % 6 == 0:
            _figures_agree(here["figures"], esc.terminal(timer, initial_speed=speed))
    assert {"ok", "stall", "painleve"} <= statuses


def _figures_agree(here, figures):
    assert here["status"] == figures.status.label
    names = ("velocity_max", "velocity_min", "period", "handoff_velocity", "contraction")
    names += ("contact_moment_max", "acceleration_max", "critical_friction", "uniqueness_friction")
    for name in names:
        expected = getattr(figures, name)
        if np.isfinite(expected):
            assert here[name] == pytest.approx(expected, rel=1e-9), name
    if np.isfinite(here["rise_time"]):
        assert here["rise_time"] == pytest.approx(figures.rise_time, rel=1e-9)


def test_states_between_the_handoffs_are_those_of_the_motion(page):
    motion = esc.simulate(escapement_of(DESIGN), 20)
    times = np.linspace(0.0, motion.end_time, 101)[1:]
    rows = page.evaluate("ts => ts.map(t => explorer.stateAt(explorer.motion, t))", times.tolist())
    state = motion.at(times)
    for name in ("theta", "theta_dot", "theta_ddot", "phi_dot", "phi_ddot", "contact_moment"):
        expected = getattr(state, name)
        found = [row[name] for row in rows]
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("slots", "pins", "internal"), [(4, 4, False), (5, 2, False), (6, 1, True)]
)
def test_the_follower_is_drawn_as_the_package_draws_it(page, slots, pins, internal):
    page.evaluate("d => explorer.change(d)", {"slots": slots, "pins": pins, "internal": internal})
    area = page.evaluate("""() => {
        const path = document.querySelector('.follower').getAttribute('d').split('Z')[0];
        const points = path.slice(1).split('L').map(pair => pair.split(' ').map(Number));
        return points.reduce((sum, [x, y], i) => {
            const [a, b] = points[(i + 1) % points.length];
            return sum + (x * b - y * a) / 2;
        }, 0);
    }""")
    edge = GenevaOutline(esc.Geneva(slots, pins, internal)).follower_edge
    assert abs(area) == pytest.approx(abs(edge.moments.area), rel=5e-3)


def problem(page):
    return page.locator("#problem").inner_text()


@pytest.mark.parametrize("text", ["", "abc", "-1", "1e400", "<b>" + 3000 * "nonsense ", "NaN"])
def test_nonsense_in_a_field_leaves_the_last_good_design(page, text):
    page.fill("#friction", text)
    assert 0 < len(problem(page)) < 200
    assert page.evaluate("explorer.design.friction") == 0.35
    page.fill("#friction", "0.2")
    assert problem(page) == ""
    assert page.evaluate("explorer.design.friction") == 0.2


@pytest.mark.parametrize(
    "fragment", ["#slots", "#slots=2", "#frictoin=.3", "#friction=much", "#x=%E0%A4%A",
                 "#clearance=1", "#slots=4&pins=9", "#" + "a" * 5000],
)  # fmt: skip
def test_a_bad_address_leaves_the_first_design(browser, file, fragment):
    with opened(browser, file, fragment) as page:
        assert 0 < len(problem(page)) < 250
        assert page.evaluate("explorer.design.friction") == 0.35


@pytest.mark.parametrize(
    "text", ["", "slots", "[mechanism]\nkind = 'gear-driven'", "torque = {}", "torque = [1, 2]",
             "torque = 1\nvery = 2", "units = 'stones'\ntorque = 1", 5000 * "x = = \n"],
)  # fmt: skip
def test_bad_text_leaves_the_last_good_design(page, text):
    page.evaluate("text => { document.getElementById('toml').value = text; }", text)
    page.click("#read")
    assert 0 < len(problem(page)) < 250
    assert page.evaluate("explorer.design.friction") == 0.35


def test_text_and_address_bring_the_design_back(browser, file, page):
    numbers = {"slots": 5, "pins": 2, "pin_radius": 1e-3, "friction": 0.21, "load_torque": 1e-4,
               "driver_drag": 1e-9, "initial_speed": 3.5}  # fmt: skip
    page.evaluate("d => explorer.change(d)", numbers)
    design, text = page.evaluate("explorer.design"), page.input_value("#toml")
    plan = parse_plan(tomllib.loads(text))
    assert design_of(plan.escapement(0), plan.values(0)["initial_speed"]) == design
    page.evaluate("explorer.change({slots: 6, pins: 1, friction: 0})")
    page.fill("#toml", text)
    page.click("#read")
    assert page.evaluate("explorer.design") == design
    until(page, "location.hash.includes('friction=0.21')")
    with opened(browser, file, page.evaluate("location.hash")) as again:
        assert again.evaluate("explorer.design") == design


def test_text_in_inches_is_taken_with_the_package_s_factors(page):
    text = 'units = "in-lbf-s"\ntorque = 0.1\n[inertia]\ndriver = 3e-6\nfollower = 50e-6\n'
    page.fill("#toml", text + "[sweep]\nfriction = [0.3]\n[mechanism]\nslots = 4\n")
    page.click("#read")
    assert problem(page) == ""
    assert page.evaluate("explorer.design.torque") == pytest.approx(0.1 * esc.units.INCH_POUND)
    page.select_option("#units", "in-lbf-s")
    assert page.input_value("#torque") == "0.1"
    assert "in-lbf" in page.locator("#figures").inner_text()


def test_one_playhead_drives_everything(page):
    page.evaluate("explorer.setTime(0.01)")
    before = page.get_attribute("#picture .arm", "transform")
    for _ in range(3):
        page.keyboard.press(".")
    time = page.evaluate("explorer.time")
    events = page.evaluate(
        "[...explorer.motion.reversals, ...explorer.motion.extrema].map(e => e.time)"
    )
    assert min(abs(time - event) for event in events) < 1e-12
    assert page.get_attribute("#picture .arm", "transform") != before
    assert float(page.input_value("#scrub")) == pytest.approx(time)
    page.keyboard.press(" ")
    until(page, f"explorer.time > {time}")
    assert page.get_attribute("#play", "aria-pressed") == "true"
    page.keyboard.press(" ")
    assert page.get_attribute("#play", "aria-pressed") == "false"


def test_arrow_keys_move_a_slider(page):
    names = ("Coefficient of friction between pin and slot", "Slots of the follower")
    friction, slots = (page.locator(f"input[aria-label='{name}, slider']") for name in names)
    friction.focus()
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("explorer.design.friction") == pytest.approx(0.35, rel=0.02)
    assert page.evaluate("explorer.design.friction") < 0.35
    slots.focus()
    page.keyboard.press("ArrowUp")
    assert page.evaluate("explorer.design.slots") == 5


def slider_of(page, name):
    return page.locator(f".field:has(#{name}) input[type=range]")


@pytest.mark.parametrize("size", [(390, 844), (844, 390), (768, 1024), (1280, 720), (1920, 1080)])
def test_picture_and_figures_stay_in_view_at_every_slider(browser, file, size):
    width, height = size
    with opened(browser, file, viewport={"width": width, "height": height}) as page:
        page.evaluate("document.querySelectorAll('details').forEach(e => { e.open = true; })")
        first = page.locator(".field input[type=text]").evaluate_all("es => es.map(e => e.id)")
        assert first[:2] == ["friction", "torque"]
        figures = "#figures tbody" if width >= 960 else "#brief"
        for name in first:
            slider = slider_of(page, name)
            slider.scroll_into_view_if_needed()
            slider.focus()
            page.keyboard.press("ArrowRight")
            assert slider.evaluate(ON_TOP), name
            for shown in ("#picture", figures):
                box = page.locator(shown).bounding_box()
                assert -1.0 <= box["y"] <= height - box["height"] + 1.0, (name, shown)
        told = page.locator(figures).inner_text()
        slider_of(page, "torque").focus()
        page.keyboard.press("ArrowRight")
        assert page.locator(figures).inner_text() != told


def test_a_drag_takes_at_most_four_milliseconds_of_script_a_frame(page):
    session = page.context.new_cdp_session(page)
    # time that the thread computes, whatever else the machine does
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    drag = """async slider => {
        for (let i = 0; i < 60; i++) {
            slider.value = 0.6 + 0.3 * Math.sin(i / 10);
            slider.dispatchEvent(new Event("input"));
            await new Promise(requestAnimationFrame);
        }
    }"""

    def spent():
        rows = session.send("Performance.getMetrics")["metrics"]
        return next(row["value"] for row in rows if row["name"] == "ScriptDuration")

    for name in ("friction", "torque"):
        slider, times = slider_of(page, name), []
        for _ in range(4):
            before = spent()
            slider.evaluate(drag)
            times.append((spent() - before) / 60)
        assert min(times) < 4e-3, times


@pytest.mark.parametrize(("name", "text"), [("torque", "-1"), ("slots", "x"), ("pin_radius", "1")])
def test_a_mistake_is_told_at_its_field(page, name, text):
    page.fill(f"#{name}", text)
    told = page.locator(f".field:has(#{name}) #problem")
    assert told.is_visible()
    assert page.get_attribute(f"#{name}", "aria-invalid") == "true"
    page.fill("#toml", "slots")
    page.click("#read")
    assert page.locator("#text #problem").is_visible()
    page.fill("#friction", "0.2")
    assert not page.locator("#problem").is_visible()


def test_where_friction_would_jam_has_its_sign_and_its_wall(page):
    jam, margin = page.locator("#picture .jam"), page.locator("#margin")
    assert jam.text_content() == "would jam here, +33.46°"
    assert "would jam at +33.46° from dead centre, on the rear wall" in margin.inner_text()
    page.fill("#friction", "0.41")
    assert jam.text_content() == "jams here, +33.46°"


def test_the_legend_has_what_the_picture_has(page):
    names = "() => [...document.querySelectorAll('#legend li')].filter(e => !e.hidden)"
    names += ".map(e => e.textContent)"
    both = ["driver", "follower", "pin", "force on the follower", "where friction jams"]
    assert page.evaluate(names) == both
    page.evaluate("explorer.change({pins: 1})")
    assert page.evaluate(names) == [*both[:1], "locking disc", *both[1:]]


def test_a_design_without_a_size_gets_one_on_the_page(browser, tmp_path):
    path = tmp_path / "bare.html"
    without = {name: value for name, value in DESIGN.items() if name != "crank_radius"}
    path.write_text(explorer.page(escapement_of(without)), encoding="utf-8")
    with opened(browser, path) as page:
        assert page.evaluate("explorer.design.crank_radius") == 0.02
        assert "needs" not in page.locator("main").inner_text()
        row = page.locator("#figures tr", has_text="contact force").locator("td").first
        assert row.inner_text().endswith("N")
        # a thick pin must come with the length that it is compared with
        page.evaluate("location.hash = '#pin_radius=1e-3'")
        until(page, "document.getElementById('problem').textContent.includes('crank radius')")


def test_reduced_motion_is_respected(browser, file, page):
    assert page.get_attribute("#play", "aria-pressed") == "false"
    with opened(browser, file, reduced_motion="no-preference") as moving:
        until(moving, "explorer.time > 0")


def test_a_kept_design_is_compared_and_jamming_is_told(page):
    page.click("#keep")
    page.fill("#friction", "0.3")
    assert "%" in page.locator("#figures").inner_text()
    page.fill("#friction", "0.41")
    assert "Painlevé" in page.locator("#outcome").inner_text()
    row = page.locator("#figures tr", has_text="Period").locator("td").first
    assert row.inner_text() == "–"
    assert page.locator(".jam").is_visible()


def test_each_stop_shows_its_designs(page):
    for i, stop in enumerate(explorer.stops()):
        page.locator("#stops button").nth(i).click()
        for k, design in enumerate(stop["designs"]):
            page.locator("#stop button").nth(k).click()
            assert problem(page) == ""
            shown = page.evaluate("explorer.design")
            assert design["design"].items() <= shown.items()


def test_everything_has_a_name_and_the_picture_is_a_file(page):
    nameless = page.evaluate("""() =>
        [...document.querySelectorAll('input, select, textarea, button')]
        .filter(e => !(e.labels?.length || e.getAttribute('aria-label') || e.textContent.trim()))
        .map(e => e.id)""")
    assert nameless == []
    with page.expect_download() as download:
        page.click("#svg")
    root = ElementTree.parse(download.value.path()).getroot()
    assert root.tag.endswith("svg")
    assert len(root.findall(".//{*}path[@class='pin']")) == 4


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [390, 1280, 1920])
def test_nothing_is_cut_or_overlaps(browser, file, width, scheme):
    size = {"width": width, "height": 900}
    with opened(browser, file, viewport=size, color_scheme=scheme) as page:
        page.click("#keep")
        # the strip of a telephone lies above all else where the page is scrolled
        page.evaluate("scrollTo(0, 0)")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        cut = page.evaluate("""() =>
            [...document.querySelectorAll('button, label, td, th, p, legend, code')]
            .filter(e => getComputedStyle(e).display !== 'inline')
            .filter(e => e.scrollWidth > e.clientWidth + 1).map(e => e.outerHTML)""")
        assert cut == []
        boxes = page.evaluate("""() => [...document.querySelectorAll('main section')].map(e => {
            const {left, right, top, bottom} = e.getBoundingClientRect();
            return [left, right, top, bottom];
        })""")
        for i, (left, right, top, bottom) in enumerate(boxes):
            for a, b, c, d in boxes[:i]:
                assert right <= a or left >= b or bottom <= c or top >= d, json.dumps(boxes)
