"""The lab: backlash on its shaft, the verdict, and numbers of a model from a measured run-up."""

import json

import numpy as np
import pytest

import escapement as esc
from escapement import plots
from escapement.base.errors import InputFileError, InvalidValue
from measurement_tools import DEG, read

WHEEL = esc.Geneva(4)
INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
TRUTH = esc.Escapement(WHEEL, INERTIA, 0.0113, 0.30)
GUESS = esc.Escapement(WHEEL, INERTIA, 0.02, 0.15)
MODEL = [
    "--torque", ".02", "--friction", ".15", "--driver-inertia", "3.39e-7",
    "--follower-inertia", "5.65e-6",
]  # fmt: skip


def there_and_back(shaft, play, seed, wheel=WHEEL, noise=0.1 * DEG):
    """Readings of a triangle, which lags by half the play, once it is crossed, in either sense."""
    theta = 25.0 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 1200)))
    back = np.arange(1200) >= 600
    if shaft == "input":
        driver = np.where(back, np.minimum(theta + play / 2, 25.0 - play / 2), theta - play / 2)
        output = esc.measurement.position(wheel, driver)
    else:
        phi = esc.measurement.position(wheel, theta)
        output = np.where(back, np.minimum(phi + play / 2, phi.max() - play / 2), phi - play / 2)
    output = output + noise * np.random.default_rng(seed).standard_normal(1200)
    return esc.Readings(theta, output)


@pytest.mark.parametrize("shaft", ["input", "output"])
@pytest.mark.parametrize("seed", range(3))
def test_backlash_is_found_on_its_shaft_with_its_width(shaft, seed):
    result = esc.measure(there_and_back(shaft, 0.4 * DEG, seed), WHEEL)
    (play,) = [play for play in result.backlash if play.p_value < 1e-3]
    assert play.shaft == shaft
    assert abs(play.width - 0.4 * DEG) < 3.5 * play.standard_error < 0.03 * DEG
    assert not result.verdict.good
    assert f"the {shaft} has a backlash of 0." in result.verdict.text


def test_a_good_mechanism_is_called_good_and_one_way_tells_no_backlash():
    good = esc.measure(there_and_back("output", 0.0, 5), WHEEL)
    assert good.verdict.good
    assert len(good.backlash) == 2
    one_way = esc.measure(read(WHEEL, noise=0.1 * DEG), WHEEL)
    assert one_way.backlash == ()
    assert one_way.verdict.text.endswith("It turned one way only, so backlash cannot be seen.")


@pytest.mark.parametrize(
    ("counts", "stops", "both"), [(360, 40, False), (1000, 40, True), (400, 36, True)]
)
@pytest.mark.parametrize("told", [True, False])
def test_rounding_that_repeats_is_no_error_of_the_mechanism(counts, stops, both, told):
    step, encoder = 360 / counts * DEG, esc.Encoder(counts)

    def found(seed, **planted):
        planted |= {"noise": 0.1 * step, "encoder": encoder, "turns": 10, "both_ways": both}
        readings = read(WHEEL, seed=seed, samples=10 * stops * (1 + both), **planted)
        return esc.measure(readings, WHEEL, encoder=encoder if told else None)

    results = [found(seed) for seed in range(4)]
    assert all(result.verdict.good is None for result in results)
    said = f"below half a step of the encoders ({180 / counts:.3g} degrees) cannot be told"
    assert any(said in result.verdict.text for result in results)
    assert all(
        "or this is the rounding of the encoders" in result.verdict.text for result in results
    )
    # an error of one and a half steps is found
    for shaft in ("input", "output"):
        result = found(1, **{f"{shaft}_eccentricity": 1.5 * step})
        assert f"repeats once a turn of the {shaft}" in result.verdict.text


def test_play_of_the_encoder_of_the_input_is_told_as_a_lead():
    theta = 25.0 * (1.0 - np.abs(np.linspace(-1.0, 1.0, 1200)))
    back = np.arange(1200) >= 600
    seen = np.where(back, np.minimum(theta + 0.2 * DEG, 25.0 - 0.2 * DEG), theta - 0.2 * DEG)
    noise = 0.1 * DEG * np.random.default_rng(1).standard_normal(1200)
    output = esc.measurement.position(WHEEL, theta) + noise
    result = esc.measure(esc.Readings(seen, output), WHEEL)
    assert "the input leads by 0.4" in result.verdict.text


def run_up(seed, sense=1.0, motion=None):
    """Driver angles of a run-up, and nothing of the follower."""
    motion = motion or esc.simulate(TRUTH, 12)
    random = np.random.default_rng(seed)
    time = np.linspace(-0.02, 1.0, 300) * motion.end_time
    theta = motion.at(np.clip(time, 0.0, motion.end_time)).theta
    angle = sense * (theta + 0.3 * DEG * random.standard_normal(300))
    return esc.Readings(angle, np.full(300, np.nan), time=time + 3.0)


@pytest.mark.parametrize("seed", range(3))
def test_friction_and_torque_of_a_run_up(seed):
    fit = esc.fit_motion(run_up(seed, sense=(-1.0) ** seed), GUESS)
    assert (np.abs(fit.values - [0.30, 0.0113]) < 2.0 * fit.half_widths).all()
    assert (fit.half_widths < 0.05 * fit.values).all()
    assert fit.release.value == pytest.approx(3.0, abs=1e-3)
    assert fit.noise == pytest.approx(0.3 * DEG, rel=0.2)
    assert fit.verdict.good
    assert (fit.escapement.friction, fit.escapement.torque) == tuple(fit.values)
    # speeds scatter as differences of noisy angles do
    expected = np.sqrt(2.0) * 0.3 * DEG / np.diff(fit.time)[0]
    assert np.std(fit.speeds - fit.computed_speeds) == pytest.approx(expected, rel=0.2)


def test_an_inertia_is_found_with_the_torque_held():
    held = esc.Escapement(WHEEL, esc.Inertia(3.39e-7, 4e-6), 0.0113, 0.15)
    fit = esc.fit_motion(run_up(1), held, ("friction", "follower_inertia"))
    assert (np.abs(fit.values - [0.30, 5.65e-6]) < 2.0 * fit.half_widths).all()


def test_what_speeds_cannot_tell_is_refused_in_one_line():
    names = ("torque", "driver_inertia", "follower_inertia")
    with pytest.raises(InvalidValue, match=f"got {', '.join(names)}, of which it shows"):
        esc.fit_motion(run_up(1), TRUTH, names)
    for said, parameters in (
        ("did you mean 'friction'", ("frictn",)),
        ("load_torque must be above 0 to be fitted", ("load_torque",)),
        ("name each once", ("torque", "torque")),
    ):
        with pytest.raises(InvalidValue, match=said):
            esc.fit_motion(run_up(1), GUESS, parameters)
    with pytest.raises(InvalidValue, match="Readings with times"):
        esc.fit_motion(read(WHEEL), GUESS)


def test_counts_rows_to_skip_and_times(tmp_path):
    path = tmp_path / "data.csv"
    rows = "".join(f"{i * 10},{i * 100},{i * 41}\n" for i in range(60))
    path.write_text(f"a logger\nof 3 axes\nt_ms,a,out\n{rows}")
    names = {"input": "a", "time": "t", "resolution": 4000, "skip_rows": 2}
    readings = esc.read_readings(path, **names, angle_unit="counts")
    turns = np.arange(60) * 100 / 4000
    np.testing.assert_allclose(readings.input, 2 * np.pi * turns)
    np.testing.assert_allclose(readings.time, np.arange(60) * 0.01)
    assert readings.remark == ""
    path.write_text(f"time_s,input_counts,output_counts\n{rows}")
    np.testing.assert_allclose(esc.read_readings(path, resolution=4000).input, readings.input)
    with pytest.raises(InputFileError, match="come with the number of counts in a turn"):
        esc.read_readings(path)
    path.write_text(path.read_text() + "10,7,7\n")
    with pytest.raises(InputFileError, match="time must increase, got 10 s after 590 s in line 62"):
        esc.read_readings(path, time="time", resolution=4000, angle_unit="counts")


@pytest.fixture
def recorded(tmp_path):
    readings, path = run_up(4), tmp_path / "run_up.csv"
    rows = zip(readings.time.tolist(), np.degrees(readings.input).tolist(), strict=True)
    path.write_text("time,input_deg\n" + "".join(f"{t:.6f},{a:.4f}\n" for t, a in rows))
    return str(path)


def test_the_report_of_a_run_up(command, recorded, tmp_path):
    words = ("measure", recorded, *MODEL, "--fit", "friction,torque")
    code, out, _ = command(*words, "--plot", str(tmp_path / "speeds.png"), "--json")
    found = json.loads(out)
    assert code == 0
    assert list(found)[:2] == ["inputs", "verdict"]
    assert found["good"]
    low, high = found["motion"]["fitted"]["friction"]["interval"]
    assert low < 0.30 < high
    assert found["motion"]["fitted"]["torque"]["unit"] == "N m"
    assert (tmp_path / "speeds.png").exists()
    table = command(*words)[1]
    assert table.partition("\n\n")[2].startswith("The model explains the motion with friction 0.")
    assert "torque" in table


WRONG = {
    "no resolution": (["--angle-unit", "counts"], 2, "--resolution N"),
    "no output": ([], 65, "--output-column NAME"),
    "rows": (["--skip-rows", "-1"], 2, "--skip-rows must be a whole number of at least 0"),
    "too many rows": (["--skip-rows", "9999"], 65, "must hold rows of angles"),
    "no fit": (["--torque", "1"], 2, "--torque must come with --fit"),
    "no time wanted": (["--time-column", "t"], 2, "--time-column must come with --fit"),
    "no numbers": (["--fit", "torque"], 2, "--torque, --driver-inertia"),
    "no such number": ([*MODEL, "--fit", "frictn"], 2, "--fit", "did you mean 'friction'?"),
    "no such time": ([*MODEL, "--fit", "torque", "--time-column", "x"], 2, "(--time-column)"),
    "no such input": ([*MODEL, "--fit", "torque", "--input-column", "x"], 2, "(--input-column)"),
    "errors of nothing": ([*MODEL, "--fit", "torque", "-o", "e.csv"], 2, "column of the output"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("argv", "code", "said"), [(a, c, s) for a, c, *s in WRONG.values()], ids=WRONG
)
def test_wrong(refusal, recorded, tmp_path, monkeypatch, argv, code, said):
    monkeypatch.chdir(tmp_path)
    line = refusal(code, "measure", recorded, *argv)
    assert [words for words in said if words not in line] == []


def test_speeds_are_drawn():
    fit = esc.fit_motion(run_up(1), TRUTH, ())
    ax = plots.plot_speeds(fit)
    assert ax.get_xlabel() == "Time (ms)"
    np.testing.assert_allclose(ax.lines[1].get_ydata(), fit.computed_speeds)
    with pytest.raises(InvalidValue, match="a MotionFit"):
        plots.plot_speeds(None)


ORIGINS = (0.0, 60.0, 1000.0, 1.7641e9)


def test_a_fit_does_not_depend_on_when_the_clock_was_started():
    given = run_up(2)
    since = given.time - given.time[0]
    fits = [
        esc.fit_motion(esc.Readings(given.input, given.output, time=since + origin), GUESS)
        for origin in ORIGINS
    ]
    for fit, origin in zip(fits, ORIGINS, strict=True):
        # a double holds Unix time to 0.2 microseconds
        np.testing.assert_allclose(fit.values, fits[0].values, rtol=1e-5)
        np.testing.assert_allclose(fit.half_widths, fits[0].half_widths, rtol=1e-3)
        assert fit.release.value - origin == pytest.approx(fits[0].release.value, abs=1e-6)
        assert fit.verdict.good is True
    # the scale of time is that of torque over inertia, and friction has none
    slow = esc.Escapement(WHEEL, esc.Inertia(3.39e-5, 5.65e-4), 0.02, 0.15)
    other = esc.fit_motion(esc.Readings(given.input, given.output, time=10.0 * since), slow)
    np.testing.assert_allclose(other.values, fits[0].values, rtol=1e-7)
    np.testing.assert_allclose(other.half_widths, fits[0].half_widths, rtol=1e-5)


@pytest.mark.parametrize(
    ("scale", "unit"), [(1e3, "ms"), (1e6, "us"), (1e9, "ns"), (1 / 60, "minutes")]
)
@pytest.mark.parametrize("names", [("friction", "torque"), ("friction",), ()])
def test_a_wrong_unit_of_the_times_is_doubted(scale, unit, names):
    given = run_up(1)
    wrong = esc.Readings(given.input, given.output, time=scale * (given.time - 3.0))
    with pytest.raises(InvalidValue, match=f"which may be {unit} taken as s") as caught:
        esc.fit_motion(wrong, TRUTH, names)
    assert "\n" not in str(caught.value)
    assert "give the escapement a torque of about" in str(caught.value)


def test_a_torque_far_from_the_guess_is_found_with_the_one_that_is_advised():
    far = esc.Escapement(WHEEL, INERTIA, 11.3, 0.15)
    with pytest.raises(InvalidValue, match="a torque of about") as caught:
        esc.fit_motion(run_up(1), far)
    advised = float(str(caught.value).rsplit("about ", 1)[1].split()[0])
    fit = esc.fit_motion(run_up(1), esc.Escapement(WHEEL, INERTIA, advised, 0.15))
    assert (np.abs(fit.values - [0.30, 0.0113]) < 2.0 * fit.half_widths).all()


def test_what_the_readings_do_not_show_is_not_explained():
    random, time = np.random.default_rng(1), np.linspace(0.0, 0.6, 300)
    nothing = np.full(300, np.nan)
    still = esc.Readings(0.01 * random.standard_normal(300), nothing, time=time)
    with pytest.raises(InvalidValue, match="readings must show a driver that turns"):
        esc.fit_motion(still, GUESS)
    # the motion of another wheel, at an even speed, or evenly accelerated
    other = esc.simulate(esc.Escapement(esc.Geneva(6), INERTIA, 0.0113, 0.3), 12)
    noise = 0.005 * random.standard_normal(300)
    for angle in (40.0 * time, 60.0 * time**2):
        fit = esc.fit_motion(esc.Readings(angle + noise, nothing, time=time), TRUTH, ())
        assert fit.verdict.good is False
    assert esc.fit_motion(run_up(1, motion=other), TRUTH, ()).verdict.good is False


def test_a_smooth_curve_that_fits_as_well_leaves_no_verdict():
    motion = esc.simulate(TRUTH, 12)
    random = np.random.default_rng(4)
    time = np.linspace(0.0, 1.0, 60) * motion.end_time
    noisy = motion.at(time).theta + 1.0 * random.standard_normal(60)
    fit = esc.fit_motion(esc.Readings(noisy, np.full(60, np.nan), time=time), TRUTH, ())
    assert fit.verdict.good is None
    assert fit.verdict.text.startswith("Cannot say whether the model explains the motion: a smooth")


def test_intervals_end_where_the_physical_range_does():
    smooth = esc.simulate(esc.Escapement(WHEEL, INERTIA, 0.0113, 0.0), 12)
    fit = esc.fit_motion(run_up(2, motion=smooth), GUESS)
    low, high = fit.numbers[0].low, fit.numbers[0].high
    assert low == 0.0 < high < 1e-3
    train = esc.Train(2.0, 1.0, 1e-6)
    geared = esc.Escapement(WHEEL, INERTIA, 0.0113, 0.3, barrel=train)
    guess = esc.Escapement(WHEEL, INERTIA, 0.0113, 0.2, barrel=esc.Train(2.0, 0.8, 1e-6))
    made = run_up(3, motion=esc.simulate(geared, 12))
    fit = esc.fit_motion(made, guess, ("friction", "barrel_efficiency"))
    low, high = fit.numbers[1].low, fit.numbers[1].high
    assert 0.9 < low < high <= 1.0


def test_readings_without_noise_are_explained():
    motion = esc.simulate(TRUTH, 12)
    time = np.linspace(0.0, 1.0, 200) * motion.end_time
    exact = esc.Readings(motion.at(time).theta, np.full(200, np.nan), time=time)
    fit = esc.fit_motion(exact, GUESS)
    np.testing.assert_allclose(fit.values, [0.30, 0.0113], rtol=1e-6)
    assert fit.verdict.good is True
