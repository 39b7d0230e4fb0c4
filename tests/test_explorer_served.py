"""The explorer's server: its answers, the requests that it refuses, and how it stops."""

import json
import os
import signal
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPConnection

import numpy as np
import pytest

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.explorer.answers import EXAMPLES, Answers
from escapement.explorer.as_text import text_of
from escapement.explorer.serve import MOST_BYTES, serving
from escapement.explorer.served_page import server_of, shown_study
from escapement.study.parse import parse_plan

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
TIMER = esc.Escapement(esc.Geneva(4, crank_radius=0.02), INERTIA, torque=0.0113, friction=0.2)
TEXT = text_of(TIMER)


@pytest.fixture(scope="module")
def server():
    found = server_of(TIMER)
    with serving(found):
        yield found


def send(server, path="/motion", body=b"{}", method="POST", **headers):
    connection = HTTPConnection("127.0.0.1", server.server_port, timeout=60)
    given = {"X-Token": server.token, **{k.replace("_", "-"): v for k, v in headers.items()}}
    connection.request(method, path, body, {k: v for k, v in given.items() if v is not None})
    answer = connection.getresponse()
    return answer.status, answer.read()


def asked(server, path="/motion", **question):
    status, body = send(server, path, json.dumps(question).encode())
    return status, json.loads(body)


def test_the_page_is_sent_to_those_who_know_the_token(server):
    assert server.server_address[0] == "127.0.0.1"
    status, body = send(server, f"/?token={server.token}", None, "GET")
    assert status == 200
    assert server.token.encode() in body
    assert b"connect-src 'self'" in body
    assert len(body) < 250_000
    for path in ("/", "/?token=", "/?token=wrong", f"/?token={server.token}x"):
        assert send(server, path, None, "GET")[0] == 403


@pytest.mark.parametrize(
    ("code", "change"),
    [
        (403, {"X_Token": "wrong"}),
        (403, {"X_Token": None}),
        (403, {"Host": "evil.example"}),
        (403, {"Host": "evil.example:80"}),
        (403, {"Origin": "http://evil.example"}),
        (413, {"body": b"x" * (MOST_BYTES + 1)}),
        (411, {"Content_Length": "-1"}),
        (404, {"path": "/etc/passwd"}),
        (400, {"body": b"not json"}),
        (400, {"body": b"[" * 100_000}),
        (422, {"body": b'{"text": 3}'}),
    ],
)
def test_what_is_wrong_is_refused_in_one_line(server, code, change):
    status, body = send(server, **change)
    assert status == code
    assert 0 < len(json.loads(body)["error"]) < 250


def test_a_hundred_requests_at_once_are_answered(server):
    given = {"text": TEXT, "change": {"driver_viscous": 1e-6}, "engagements": 1}
    question = json.dumps(given).encode()
    send(server, body=question)  # which compiles
    with ThreadPoolExecutor(100) as pool:
        found = list(pool.map(lambda _: send(server, body=question)[0], range(100)))
    assert found == [200] * 100


def test_what_the_page_computes_is_left_to_it(server):
    status, answer = asked(server, text=TEXT, change={"friction": 0.3}, engagements=7)
    assert status == 200
    assert (answer["plain"]["friction"], answer["plain"]["engagements"]) == (0.3, 7)
    assert answer["motion"] is None


CHANGES = {
    "viscous": {"driver_viscous": 1e-6},
    "roller": {"pin_radius": 1e-3, "roller_radius": 2e-3},
    "clearance": {"pin_radius": 1e-3, "clearance": 5e-5},
}


@pytest.mark.parametrize("name", CHANGES)
def test_what_the_page_cannot_compute_is_computed_by_the_package(server, name):
    status, answer = asked(server, text=TEXT, change=CHANGES[name], engagements=3)
    assert status == 200
    plan = parse_plan(tomllib.loads(answer["text"]))
    motion = esc.simulate(plan.escapement(0), 3)
    assert (
        answer["motion"]["engine"]
        == motion.engine
        == ("contact" if name == "clearance" else "energy")
    )
    np.testing.assert_array_equal(answer["motion"]["handoff_times"], motion.handoff_times)
    figures = esc.terminal(plan.escapement(0))
    assert answer["motion"]["figures"]["period"] == figures.period
    assert CHANGES[name].items() <= answer["design"].items()


@pytest.mark.parametrize("kind", EXAMPLES)
def test_every_kind_of_mechanism_has_an_example(server, kind):
    status, answer = asked(server, text=TEXT, kind=kind)
    assert (status, answer["kind"]) == (200, kind)
    assert (answer["plain"] or answer["motion"]) is not None
    assert answer["motion"] is None or answer["motion"]["status"] == "ok"


@pytest.mark.parametrize(
    ("question", "words"),
    [
        ({"text": "torque ="}, "TOML"),
        ({"text": TEXT.replace("[0.0113]", "[1, 2]")}, "one case"),
        ({"text": TEXT, "change": {"friction": -1}}, "friction"),
        ({"text": TEXT, "change": {"frictoin": 1}}, "did you mean 'friction'"),
        ({"text": TEXT, "change": {"pin_radius": 1.0}}, "pin_radius"),
        ({"text": TEXT, "change": 3}, "change"),
        ({"text": TEXT, "kind": "pendulum"}, "kind"),
        ({"text": TEXT, "engagements": 10**9}, "engagements"),
        ({"case": 3}, "case"),
    ],
)
def test_a_bad_question_has_one_clear_line(server, question, words):
    status, answer = asked(server, **question)
    assert status == 422
    assert words in answer["error"]
    assert "\n" not in answer["error"]


def test_a_cloud_has_the_scatter_of_a_study(server):
    shares = {"friction": 0.1, "torque": 0.05}
    given = {"text": TEXT, "tolerances": shares, "figure": "period", "size": 5000}
    status, answer = asked(server, "/cloud", **given)
    assert status == 200
    sample = {name: {"relative_tolerance": share} for name, share in shares.items()}
    study = esc.budget(TIMER, sample, figures=["period"], size=5000, seed=0).study
    expected = np.quantile(study.results["period"], [0.05, 0.5, 0.95])
    np.testing.assert_allclose(answer["quantiles"], expected, rtol=1e-12)
    assert np.sum(answer["counts"]) + answer["failed"] == answer["cases"] == 5000
    for wrong in ({"figure": "colour"}, {"size": 10**9}, {"tolerances": {}}):
        assert asked(server, "/cloud", **given | wrong)[0] == 422


def test_a_study_is_shown_with_all_its_cases(tmp_path):
    path = tmp_path / "study.h5"
    esc.sweep(TIMER, friction=[0.1, 0.2, 0.5], torque=[0.01, 0.02], path=path)
    plan = parse_plan(esc.read_study(path).configuration)
    shown = shown_study(plan, esc.read_study(path))
    assert [axis["values"] for axis in shown["axes"]] == [[0.1, 0.2, 0.5], [0.01, 0.02]]
    periods = next(row for row in shown["results"] if row["words"].startswith("Period"))["values"]
    answers = Answers(plan)
    found = answers.motion({"case": 3})
    assert (found["plain"]["friction"], found["plain"]["torque"]) == (0.2, 0.02)
    assert periods[3] == pytest.approx(esc.terminal(plan.escapement(3)).period)
    assert periods[4] is None
    with pytest.raises(InvalidValue, match="case must be"):
        answers.motion({"case": 6})


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
def test_ctrl_c_ends_it_in_order():
    given = ["--driver-inertia", "1e-6", "--follower-inertia", "1e-5", "--torque", "0.01"]
    words = [sys.executable, "-m", "escapement", "explore", *given, "--serve", "--json"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(words, env=os.environ, text=True, **pipes) as process:
        told = "".join(iter(process.stdout.readline, "}\n")) + "}"
        assert json.loads(told)["url"].startswith("http://127.0.0.1:")
        process.send_signal(signal.SIGINT)
        assert process.wait(20) == 130
        assert process.stderr.read() == "escapement: error: interrupted\n"
