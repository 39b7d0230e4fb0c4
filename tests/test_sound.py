"""Beats from recordings and text files, and what they say of a clock."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.io import wavfile

import escapement as esc
from escapement.base.errors import InputFileError, InvalidValue, MissingInput
from escapement.cli import main
from escapement.measurement.onsets import find_onsets
from escapement.measurement.rhythm import find_rhythm

RATE = 48000
TIMER = esc.Escapement(
    esc.Geneva(5, pins=3), esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.3
)
ENCODERS = esc.Readings(np.arange(30.0), np.arange(30.0))
MODEL = [
    *("geneva", "--slots", "5", "--pins", "3", "--torque", ".0113"),
    *("--driver-inertia", "3.39e-7", "--follower-inertia", "5.65e-6"),
]


def ticks(count=60, period=0.2, jitter=1e-4, seed=0, late=()):
    """Instants of ticks whose intervals vary; `late` are offsets of the positions."""
    rng = np.random.default_rng(seed)
    offsets = np.resize(late or (0.0,), count)
    return 0.3 + period * np.arange(count) + np.cumsum(jitter * rng.normal(size=count)) + offsets


def written(path, times, loudness=1.0, **options):
    esc.write_recording(path, esc.synthetic_recording(times, loudness, **options))
    return path


def instants(times):
    """Given instants as those of beats."""
    return esc.Readings.of_beats(times)


def estimates(times, **options):
    """Timekeeping of given instants."""
    return esc.timekeeping(instants(times), **options)


@pytest.mark.parametrize(("rate", "room"), [(0.5, 0.1), (20.0, 0.0), (100.0, 0.1)])
def test_every_tick_is_found_where_it_begins(rate, room):
    times = ticks(max(int(10 * rate), 12), 1.0 / rate, 1e-3 / rate)
    sound = esc.synthetic_recording(times, signal_to_noise=20.0, room=room)
    onsets = find_onsets(sound, RATE)
    rhythm = find_rhythm(onsets)
    found = onsets.times[rhythm.beats]
    assert found.size == times.size
    assert np.median(np.abs(found - times)) < 2.0 / RATE
    inside = np.abs(found - times) <= onsets.half_widths[rhythm.beats]
    assert np.mean(inside) > 0.9


def test_dense_ticks_are_found_although_their_tails_fill_the_time_between_them():
    times = ticks(600, 0.01, 1e-5, seed=13)
    sound = esc.synthetic_recording(times, signal_to_noise=10.0, room=0.05, seed=13)
    onsets = find_onsets(sound, RATE)
    beats = find_rhythm(onsets).beats
    found = onsets.times[beats[beats >= 0]]
    apart = np.abs(found[:, None] - times).min(axis=1)
    assert np.count_nonzero(apart < 1e-3) >= 570
    assert np.count_nonzero(apart >= 1e-3) <= 6
    assert 0.91 <= np.mean(apart <= onsets.half_widths[beats[beats >= 0]]) <= 0.99


def test_noise_has_no_ticks():
    noise = np.random.default_rng(0).normal(size=20 * RATE)
    assert not find_onsets(noise, RATE).sure.any()
    assert not find_onsets(np.zeros(RATE), RATE).sure.any()


@pytest.mark.parametrize(
    ("kind", "scale", "offset"),
    [(np.uint8, 100.0, 128.0), (np.int16, 2e4, 0.0), (np.int32, 2e9, 0.0), (np.float32, 0.5, 0.0)],
)
def test_all_usual_files_are_read(tmp_path, kind, scale, offset):
    times = ticks(12)
    sound = esc.synthetic_recording(times)
    values = (scale * sound / np.abs(sound).max() + offset).astype(kind)
    wavfile.write(
        tmp_path / "a.wav", RATE, np.stack([np.full_like(values, offset), values], axis=1)
    )
    assert esc.read_recording(tmp_path / "a.wav").channels == 2
    assert esc.read_beats(tmp_path / "a.wav").time == pytest.approx(times, abs=1e-4)


def _clipped(path):
    sound = esc.synthetic_recording(ticks())
    wavfile.write(path, RATE, np.clip(2e5 * sound, -32768, 32767).astype(np.int16))


def _speech(path):
    rng = np.random.default_rng(1)
    written(path, np.cumsum(rng.exponential(0.2, 100)), np.exp(rng.normal(size=100)), room=0.3)


def _cut(path):
    content = written(path, ticks(12)).read_bytes()
    path.write_bytes(content[: len(content) // 2])


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda p: wavfile.write(p, RATE, np.zeros(RATE, np.int16)), "is silent"),
        (_clipped, "must not be clipped"),
        (_speech, "must have a rhythm"),
        (lambda p: written(p, ticks(5), duration=20.0), "at least 8 sounds, got 5"),
        (_cut, "is cut short"),
        (lambda p: p.write_text("time\n1\n2\n"), "must be a WAV file, and is not"),
        (lambda p: wavfile.write(p, 4000, np.ones(9000, np.int16)), "8000 to 192000"),
    ],
)
def test_what_holds_no_beats_is_one_clear_line(tmp_path, capsys, make, words):
    make(tmp_path / "a.wav")
    with pytest.raises(InputFileError, match=words):
        esc.read_beats(tmp_path / "a.wav")
    assert main(["measure", str(tmp_path / "a.wav")]) == 65
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert words in err


def test_a_missing_recording_and_other_formats():
    with pytest.raises(MissingInput):
        esc.read_beats("none.wav")


def test_a_beat_that_is_not_heard_is_counted_and_not_made_up(tmp_path):
    times = ticks(40)
    beats = esc.read_beats(written(tmp_path / "a.wav", np.delete(times, [7, 20, 21])))
    assert beats.missing == 3
    assert np.flatnonzero(np.isnan(beats.time)).tolist() == [7, 20, 21]
    assert "3 of 40 beats were not heard" in beats.remark
    assert np.nanmax(np.abs(beats.time - times)) < 1e-4


def test_two_sounds_of_a_beat_are_one_beat_unless_the_rate_says_otherwise(tmp_path):
    times, second = ticks(40), 0.03
    both = np.sort([*times, *(times + second)])
    path = written(tmp_path / "a.wav", both, np.resize([1.0, 0.5], 80))
    beats = esc.read_beats(path)
    assert (beats.sounds, beats.samples, beats.doubles.size) == (2, 40, 40)
    assert beats.time == pytest.approx(times, abs=1e-4)
    assert esc.read_beats(path, nominal=3600.0 / 0.1).samples == 80
    # a recording that begins with the second sound of a beat
    later = written(tmp_path / "b.wav", both[1:])
    assert esc.read_beats(later).time == pytest.approx(times[1:], abs=1e-4)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("{t}", None),
        ("time [s]\n{t}", None),
        ("time;loudness\nms;\n{t1000};1", None),
        ("beat [ms]\n{d1000}", None),
        ("{dcomma}", "ms"),
        ("n\tinterval us\n1\t{d1e6}", None),
        ("interval us\n{d1e6}", None),
        ("time\n{clock}", None),
    ],
)
def test_text_files_of_instants_and_of_intervals(tmp_path, text, unit):
    times = np.round(ticks(20), 6)
    steps = np.diff(times)
    *head, row = text.split("\n")
    forms = {
        "t": [f"{x:.6f}" for x in times], "t1000": [f"{1e3 * x:.3f}" for x in times],
        "d1000": [f"{1e3 * x:.3f}" for x in steps], "d1e6": [f"{1e6 * x:.0f}" for x in steps],
        "clock": [f"23:59:{58 + x:.6f}" for x in times if x < 2.0]
        + [f"00:00:{x - 2:09.6f}" for x in times if x >= 2.0],
        "dcomma": [f"{1e3 * x:.3f}".replace(".", ",") for x in steps],
    }  # fmt: skip
    (name,) = (key for key in forms if "{" + key + "}" in row)
    rows = [row.replace("{" + name + "}", value) for value in forms[name]]
    (tmp_path / "a.csv").write_text("\n".join([*head, *rows]))
    beats = esc.read_beats(tmp_path / "a.csv", time_unit=unit)
    assert np.diff(beats.time) == pytest.approx(steps, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "must hold rows of times, got none"),
        ("time\n1\nabc\n", "line 3 must have numbers in fields 1, got 'abc'"),
        ("speed;force\n1;2\n", "must have one column called time or interval"),
        ("interval\n.2\n-.1\n" + ".2\n" * 9, "line 3 must have an interval greater than 0"),
        ("time [weeks]\n1\n2\n", "must have times in"),
        ("1\n2\n3\n", "at least 8 sounds"),
        ("time\n" + "3\n2\n1\n" * 9, "time 1 must be later than the one before it"),
    ],
)
def test_a_text_without_beats_is_refused(tmp_path, text, words):
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(InputFileError, match=words):
        esc.read_beats(tmp_path / "a.txt")


def test_saved_beats_are_read_back(tmp_path):
    beats = esc.read_beats(written(tmp_path / "a.wav", ticks()))
    esc.write_readings(beats, tmp_path / "a.csv")
    assert esc.read_beats(tmp_path / "a.csv").time.tolist() == beats.time.tolist()


@pytest.mark.parametrize(("jitter", "noise"), [(1e-4, 0.0), (1e-4, 1e-4), (0.0, 1e-4)])
def test_intervals_hold_the_truth(jitter, noise):
    """Of 100 clocks, for noise of beats, of both, and of instants alone, where they are wide."""
    inside = np.zeros(3)
    for seed in range(100):
        rng = np.random.default_rng(seed)
        times = ticks(120, jitter=jitter, seed=seed, late=(0.0, 5e-4))
        times = times + noise * rng.normal(size=120)
        times[rng.random(120) < 0.05] = np.nan
        found = estimates(times, nominal=18000.0)
        truths = (found.rate, 0.0), (found.drift, 0.0), (found.beat_error, 1e-3)
        inside += [one.low <= true <= one.high for one, true in truths]
    assert (inside >= 88).all()
    if jitter:
        assert (inside <= 99).all()


def test_one_bad_pin_of_six_is_found_with_its_size():
    late = [0.0, 0.0, 1e-3, 0.0, 0.0, 0.0]
    found = estimates(ticks(180, jitter=1e-4, late=late), pattern=6)
    out = [k for k, one in enumerate(found.offsets) if one.low > 3e-4]
    assert out == [2]
    true = 1e-3 * (1.0 - 1.0 / 6.0)
    assert found.offsets[2].low <= true <= found.offsets[2].high


def test_allan_deviation_of_independent_beats_falls_with_the_root_of_time():
    found = estimates(ticks(4000, jitter=1e-4)).stability
    for one in found[:6]:
        assert one.low <= 1e-4 / 0.2 / math.sqrt(one.time / 0.2) <= one.high


def test_parts_and_friction_from_beats(tmp_path, capsys):
    late = (1e-2, -1e-2, 0.0)
    wheel = replace(TIMER.mechanism, pin_angle_errors=late)
    beats = np.tile(esc.terminal(replace(TIMER, mechanism=wheel)).beats, 8)
    times = 0.1 + np.cumsum([0.0, *beats])
    times += 5e-6 * np.random.default_rng(2).normal(size=times.size)
    design = [*MODEL, "--friction", ".25", "--json"]
    path = str(written(tmp_path / "a.wav", times))
    right = replace(TIMER, friction=0.3)
    found = esc.fit_beats(esc.read_beats(path), right, parts="pins")
    assert (np.abs(found.pin_angle_errors - late) <= found.pin_half_widths).all()
    run = esc.simulate(TIMER, 40).handoff_times
    run = run + 1e-5 * np.random.default_rng(3).normal(size=run.size)
    (tmp_path / "run.txt").write_text("\n".join(f"{1.0 + x:.9f}" for x in run))
    assert (
        main(["measure", "--beats", str(tmp_path / "run.txt"), *design, "--fit", "friction"]) == 0
    )
    said = capsys.readouterr().out
    assert '"good": true' in said


@pytest.mark.parametrize("noise", [0.0, 1e-6])
def test_a_run_up_gives_friction_and_torque(noise):
    run = 1.0 + esc.simulate(TIMER, 40).handoff_times
    start, inside = replace(TIMER, friction=0.25, torque=0.01), 0
    for seed in range(10 if noise else 1):
        times = run + noise * np.random.default_rng(seed).normal(size=run.size)
        fit = esc.fit_motion(instants(times), start, ["friction", "torque"])
        (friction, torque), release = fit.numbers, fit.release
        if not noise:
            assert (friction.value, torque.value) == pytest.approx((0.3, 0.0113), rel=1e-9)
            assert release.value == pytest.approx(1.0, abs=1e-9)
        inside += friction.low <= 0.3 <= friction.high and release.low <= 1.0 <= release.high
        assert fit.verdict.good is not False
    assert inside >= (8 if noise else 0)


def test_a_run_up_of_another_model_is_contradicted():
    times = esc.simulate(replace(TIMER, torque=1.1 * TIMER.torque), 40).handoff_times
    times = times + 1e-6 * np.random.default_rng(0).normal(size=times.size)
    assert esc.fit_motion(instants(times), TIMER, ["friction"]).verdict.good is False


def test_options_of_beats_and_of_readings_are_kept_apart(tmp_path, capsys):
    path = str(written(tmp_path / "a.wav", ticks(20)))
    assert main(["measure", path, "--resolution", "4096"]) == 2
    assert "must come with readings of encoders" in capsys.readouterr().err
    (tmp_path / "a.csv").write_text("input,output\n" + "1,2\n" * 30)
    assert main(["measure", str(tmp_path / "a.csv"), "--pattern", "2"]) == 2
    assert "must come with beats" in capsys.readouterr().err


def test_the_command_writes_beats_and_a_picture(tmp_path, capsys):
    path = str(written(tmp_path / "a.wav", ticks(40)))
    saved, picture = tmp_path / "b.csv", tmp_path / "b.png"
    words = ["--save-beats", str(saved), "--plot", str(picture), "--nominal-rate", "18000"]
    assert main(["measure", path, *words]) == 0
    assert saved.exists()
    assert picture.exists()
    assert "rate [s/d]" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: esc.synthetic_recording([-1.0]), "times must be"),
        (lambda: esc.read_beats("a.txt", nominal=0.0), "nominal must be"),
        (lambda: estimates(ticks(10)), "beats must be 18 or more"),
        (lambda: esc.Readings.of_beats([1.0, 3.0, 2.0]), "time 2 must be later than"),
        (lambda: esc.measure(instants(ticks(10)), esc.Geneva(4)), "must be those of encoders"),
        (lambda: esc.fit_beats(ENCODERS, TIMER), "must be Readings of beats"),
        (lambda: esc.write_recording("a.wav", [np.nan]), "recording must be"),
    ],
)
def test_wrong_arguments_are_one_line(call, words):
    with pytest.raises(InvalidValue, match=words):
        call()
