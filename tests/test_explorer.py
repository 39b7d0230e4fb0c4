"""The explorer's page: what it holds, what it refuses, how the command writes it."""

import ast
import json
import re
from pathlib import Path

import pytest

import escapement as esc
from escapement import explorer
from escapement.cli import main
from escapement.explorer.fields import COMPUTED, settings

ROOT = Path(__file__).resolve().parents[1]
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
GIVEN = ("--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6", "--torque", "0.0113")


def timer(mechanism=None, **numbers):
    return esc.Escapement(mechanism or esc.Geneva(4), INERTIA, **{"torque": 0.0113} | numbers)


def data_of(text):
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


def test_the_page_is_one_small_file_that_asks_for_no_other():
    text = explorer.page(timer(friction=0.35))
    assert len(text.encode()) < 250_000
    assert not re.findall(r"""(?:src|href)=["'](?!#|data:)|@import|url\(|fetch\(|import\(""", text)
    assert "default-src 'none'" in text
    assert "/*" + "SCRIPT*/" not in text


def test_the_command_has_a_design_of_its_own(tmp_path):
    for given, slots, friction in ((), 4, 0.2), (("--slots", "6", "--friction", ".1"), 6, 0.1):
        path = tmp_path / f"{slots}.html"
        assert main(["explore", *given, "--units", "mm", "-o", str(path)]) == 0
        design = data_of(path.read_text(encoding="utf-8"))["design"]
        assert (design["slots"], design["friction"]) == (slots, friction)
        assert design["crank_radius"] == pytest.approx(0.02)


def test_the_page_begins_with_the_design_and_its_words_are_those_of_the_package():
    wheel = esc.Geneva(5, 2, crank_radius=0.02, pin_radius=0.001)
    found = data_of(explorer.page(timer(wheel, friction=0.3, spring_rate=1e-5), 12.0, 7))
    design = found["design"]
    assert set(design) == set(COMPUTED) == set(found["fields"])
    # what the page does not compute it refuses with the words of its declaration
    known = {*found["fields"], *found["beyond"]} - {"barrel", "load_train"}
    assert known == set(settings())
    assert (design["slots"], design["pins"], design["pin_radius"]) == (5, 2, 0.001)
    assert (design["friction"], design["initial_speed"], design["engagements"]) == (0.3, 12.0, 7)
    assert found["systems"]["in-lbf-s"]["torque"]["factor"] == esc.units.INCH_POUND


def test_each_claim_of_a_stop_names_a_test_that_exists():
    claims = [claim["test"] for stop in explorer.stops() for claim in stop["claims"]]
    assert len(explorer.stops()) == 5
    for claim in claims:
        file, name = claim.split("::")
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        tests = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert name in tests, claim


def test_the_command_writes_a_page_of_options_and_of_a_study(command, tmp_path):
    study = ROOT / "runs" / "meyer_four_pins.toml"
    chosen = ("--select", "friction=0.35,torque=0.1")
    assert command("explore", "--from", study, *chosen, "-o", "a.html")[0] == 0
    typed = ("--slots", 4, "--friction", 0.35, "--units", "in-lbf-s", "--torque", 0.1)
    inertia = ("--driver-inertia", 3e-6, "--follower-inertia", 50e-6)
    assert command("explore", *typed, *inertia, "-o", "b.html")[0] == 0
    one, two = (data_of((tmp_path / f"{x}.html").read_text("utf-8")) for x in "ab")
    assert one["design"] == two["design"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        ((*GIVEN,), 2, "--output must name the page"),
        ((*GIVEN, "-o", "page.png"), 2, "must end in .html"),
        ((*GIVEN, "-o", "there.html"), 73, "there.html"),
        ((*GIVEN, "--follower-viscous", "1e-9", "-o", "a.html"), 2, "follower_viscous"),
        (("--from", "none.toml", "-o", "a.html"), 66, "none.toml"),
    ],
)
def test_the_command_refuses_in_one_line(command, tmp_path, words, code, message):
    (tmp_path / "there.html").write_text("kept")
    found, _, err = command("explore", *words)
    assert found == code, err
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "a.html").exists()
    assert (tmp_path / "there.html").read_text() == "kept"
