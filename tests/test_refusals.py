"""Whatever a command refuses leaves nothing on disk, and no mistake ends in a traceback."""

import pytest

pytestmark = pytest.mark.slow


MODEL = ["--torque", "0.0113", "--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6"]
SIZES = ["--slots", "4", "--pins", "1", "--crank-radius", "0.02", "--pin-radius", "1e-3",
         "--clearance", "1e-5"]  # fmt: skip
DATA = "theta,phi\n" + "".join(f"{x},{0.5 * x}\n" for x in range(0, 720, 7))
RIGHT = {
    "run": [*MODEL, "--friction", "0.3", "--engagements", "1", "-o", "out.h5", "--plot", "out.png",
            "--report", "out.html"],
    "mechanism": [*SIZES, "--plot", "out.png"],
    "export": [*SIZES, "-o", "out.svg"],
    "index": ["--speed", "1", "--load-torque", "1", "--follower-inertia", "1", "--plot",
                     "out.png"],
    "measure": ["data.csv", "--slots", "4", "--pins", "1", "-o", "out.csv", "--plot", "out.png"],
}  # fmt: skip
# mistakes that show only when the work is done, or almost
LATE = [
    ("run", ["--engagements", "60", "--plot", "out.gif"], "at most 50 engagements"),
    ("run", ["--slots", "300", "--pins", "1"], "at most 200 in a drawing"),
    ("run", ["--slots", "300", "--pins", "1", "--plot", "out.gif"], "at most 200 in a drawing"),
    ("mechanism", ["--slots", "300"], "at most 200 in a drawing"),
    ("mechanism", ["--driver-inertia", "1"], "must come with --follower-inertia I, got none"),
    ("export", ["--thickness", "1 mm"], "--density"),
    ("export", ["--density", "7850"], "--thickness"),
    ("export", ["--locking-radius", "19.9 mm"], "locking_radius must be between"),
    ("export", ["--kerf", "3 mm"], "narrower kerf"),
    ("index", ["--pin-gap", "1 mm"], "--pin-gap must come with --pin-length"),
    ("measure", ["--phase", "1"], "--phase must come with --offset"),
]


@pytest.mark.parametrize(("name", "words", "said"), LATE)
def test_what_is_refused_late_leaves_nothing(refusal, tmp_path, name, words, said):
    (tmp_path / "data.csv").write_text(DATA)
    assert said in refusal(2, name, *RIGHT[name], *words)


def test_the_corrected_call_is_not_refused(refusal, command, tmp_path):
    words = ["export", *RIGHT["export"], "--thickness", "1 mm"]
    refusal(2, *words)
    assert command(*words, "--density", "7850")[0] == 0
    assert (tmp_path / "out.svg").exists()
