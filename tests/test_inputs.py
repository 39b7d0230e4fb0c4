"""Every command tells first what went in, in the user's units."""

import json
from types import SimpleNamespace

import pytest

from command_scenes import argv_of, scenes_of, write_inputs
from escapement.base.units import INCH, INCH_POUND
from escapement.benchmark import work_precision
from escapement.cli import COMMANDS

LENGTHS = ("crank_radius", "pin_radius", "kerf", "follower_shaft_radius")
TORQUES = ("torque", "load_torque", "driver_inertia", "follower_inertia")
FILES = {
    "sweep": {"config": "study.toml"},
    "compare": {"config": ["timer.toml", "timer.toml"]},
    "reproduce": {"source": "prikhodko"},
    "bench": {"quick": True},
}
WRITTEN = {"explore": "page.html", "plot": "x.png"}


@pytest.mark.parametrize("name", COMMANDS)
def test_every_output_begins_with_the_inputs(command, monkeypatch, few_angles, name):
    units = "in-lbf-s"
    results = SimpleNamespace(as_dict=dict, machine={}, standings=[], points=[])
    monkeypatch.setattr(work_precision, "run", lambda **_: results)
    monkeypatch.setattr("escapement.cli.compile.compile_all", lambda processes: 0)
    write_inputs(name, "geneva")
    scene = FILES.get(name) or next(iter(scenes_of(name, "geneva")), {})
    extra = ["--quiet", "--force"] if name == "sweep" else []
    if name in WRITTEN:
        extra += ["-o", WRITTEN[name]] + ["--force"] * (name == "explore")
    argv = [*argv_of(name, "geneva", scene | {"units": units}), *extra]
    code, out, err = command(*argv, "--json")
    assert code == 0, err
    told = next(iter(json.loads(out).items()))
    assert told[0] == "inputs"
    assert next(iter(told[1].items())) == ("units", units)
    assert scene.keys() - {"tried", "output"} <= {key.removesuffix("_deg") for key in told[1]}
    for key, value in scene.items():
        scale = INCH if key in LENGTHS else INCH_POUND if key in TORQUES else None
        if scale is not None:
            assert told[1][key][units] == pytest.approx(value, rel=1e-12)
            assert told[1][key]["SI"] == pytest.approx(value * scale, rel=1e-12)
    if told[1].keys() == {"units"}:
        return  # nothing went in
    # the table begins with the same names
    code, out, err = command(*argv)
    assert code == 0, err
    names = [
        line.split("  ")[0].replace(" ", "_") for line in out.partition("\n\n")[0].splitlines()
    ]
    assert names == [key.removesuffix("_deg") for key in told[1] if key != "units"]
