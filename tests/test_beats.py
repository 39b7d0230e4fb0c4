"""Beats to parts: known errors are found again, and the message names what cannot be determined."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import escapement as esc
from escapement.measurement.rounds import SHARES, rounds_of
from escapement.plots import plot_beat_spectrum, plot_beats

INERTIA = esc.Inertia(3.39e-7, 5.65e-6)
PINS = 1e-3 * np.array([0.9, -1.3, 0.4])
SLOTS = 1e-3 * np.array([-1.6, -0.8, 0.4, 0.7, 1.3])


def design(slots=5, pins=3, **wheel):
    mechanism = esc.Geneva(slots, pins=pins, crank_radius=0.02, **wheel)
    return esc.Escapement(mechanism, INERTIA, torque=0.0113, friction=0.3)


def beats_of(drive, late=(), ahead=(), rounds=1, noise=0.0, seed=0):
    """Beats with planted errors, and noise as a share of the mean."""
    errors = {"pin_angle_errors": tuple(late), "slot_angle_errors": tuple(ahead)}
    cycle = esc.terminal(replace(drive, mechanism=replace(drive.mechanism, **errors)))
    beats = np.tile(cycle.beats, rounds)
    return beats * (1.0 + noise * np.random.default_rng(seed).normal(size=beats.size))


def test_without_noise_every_error_is_found():
    # whatever the torque, and whatever errors the design has
    given = replace(design(), mechanism=replace(design().mechanism, pin_angle_errors=(1e-2, 0, 0)))
    fit = esc.fit_beats(1.01 * beats_of(design(), PINS, SLOTS), given, noise=1e-9)
    assert_allclose(fit.pin_angle_errors, PINS, atol=1e-8)
    assert_allclose(fit.slot_angle_errors, SLOTS, atol=1e-8)
    assert fit.rate == pytest.approx(1.01, rel=1e-7)
    assert fit.combinations == ()
    assert_allclose(1.01 * np.array(esc.terminal(fit.escapement).beats), fit.computed, rtol=1e-6)


@pytest.mark.slow
def test_intervals_hold_and_are_narrow():
    # the share of a hundred seeds is in benchmarks/results/beats.csv
    held = []
    for seed in range(5):
        fit = esc.fit_beats(beats_of(design(), PINS, SLOTS, noise=5e-5, seed=seed), design())
        half = np.concatenate([fit.pin_half_widths, fit.slot_half_widths])
        true = np.concatenate([PINS, SLOTS])
        found = np.concatenate([fit.pin_angle_errors, fit.slot_angle_errors])
        held.append(np.abs(found - true) <= half)
        assert (half <= 0.3 * np.abs(true)).all()
    # of 40 independent intervals of 95 % more than eight fail in one of ten thousand sets
    assert np.sum(held) >= 32


def test_given_noise_and_missing_beats():
    beats = beats_of(design(), PINS, SLOTS, rounds=3, noise=2e-5)
    beats[[3, 20, 44]] = np.nan
    fit = esc.fit_beats(beats, design(), noise=2e-5 * np.nanmean(beats))
    assert fit.p_value > 1e-3
    assert fit.rounds.samples == 42
    assert np.isnan(fit.residuals).sum() == 3
    assert fit.residual == pytest.approx(fit.noise, rel=0.4)
    assert (np.abs(fit.slot_angle_errors - SLOTS) <= 2.0 * fit.slot_half_widths).all()


@pytest.mark.slow
def test_steps_that_no_pin_strikes_are_confined():
    """Whether one set of errors explains the beats, or several, depends on the noise."""
    ahead = 1e-3 * np.array([-0.6, 0.9, 0.2, -1.1, 0.6])  # behind the one before: slots 0, 2, 3
    steps = np.diff(ahead, prepend=ahead[-1])
    slots, struck, single = [], [], 0
    for seed in range(6):
        fit = esc.fit_beats(beats_of(design(), PINS, ahead, 2, 1e-5, seed), design())
        slots += [*(np.abs(fit.slot_angle_errors - ahead) <= fit.slot_half_widths)]
        # nothing tells how far a slot is behind that no pin strikes
        assert (fit.slot_half_widths > 1e-4).all()
        assert (fit.pin_half_widths < 1e-4).all()
        told = {one.name: one for one in fit.combinations}
        assert bool(told) is ("sets of errors explain the beats equally well" not in fit.message)
        if told and "no pin strikes slots 0, 2, 3" in fit.message:
            single += 1
            assert set(told) == {"slot 1 less slot 0", "slot 4 less slot 3"}
        for one in told.values():
            k = int(one.name.split()[1])
            struck.append(abs(one.value - steps[k]) <= one.half_width < 0.05 * abs(steps[k]))
    # of intervals of 95 %, so many fail in less than one of a thousand sets
    assert np.sum(slots) >= 24
    assert single >= 1
    assert np.sum(struck) >= len(struck) - 3


@pytest.mark.slow
def test_axes_too_close_tell_every_step_that_is_small():
    ahead = 1e-3 * np.array([-0.6, 0.9, 0.2, -1.1, 0.6])
    drive = design(centre_distance_error=-1e-4)
    fit = esc.fit_beats(beats_of(drive, PINS, ahead), drive, noise=1e-9)
    assert_allclose(fit.slot_angle_errors, ahead, atol=1e-8)
    assert_allclose(fit.pin_angle_errors, PINS, atol=1e-8)
    # steps of -0.7 mrad and less are picked up by pins on these axes
    drive = design(centre_distance_error=-1e-5)
    fit = esc.fit_beats(beats_of(drive, PINS, ahead, 2, 1e-5), drive)
    assert fit.message
    assert (np.abs(fit.slot_angle_errors - ahead) <= fit.slot_half_widths).all()
    assert (np.abs(fit.pin_angle_errors - PINS) <= 2.0 * fit.pin_half_widths).all()


@pytest.mark.slow
def test_a_common_factor_is_told():
    late, ahead = 1e-3 * np.array([0.5, -0.3, -0.2, 0.0]), 1e-3 * np.array([-1.0, 0.2, 0.3, 0.5])
    drive = design(4, 4)
    beats = beats_of(drive, late, ahead, rounds=2, noise=1e-6)
    fit = esc.fit_beats(beats, drive)
    assert np.isnan([*fit.pin_angle_errors, *fit.slot_half_widths]).all()
    assert "each of 4 pins meets only 1 of 4 slots" in fit.message
    names = [one.name for one in fit.combinations]
    assert names == [f"pin {k} in slot {k}" for k in range(4)]
    turned = [one.value for one in fit.combinations]
    mean = beats.mean()
    longer = 0.5 * math.pi * (beats.reshape(2, 4).mean(axis=0) / mean - 1.0)
    assert_allclose(turned, longer, rtol=1e-9)
    # if the other parts are good, either is found
    for part, errors in (("slots", ((), ahead)), ("pins", (late, ()))):
        alone = esc.fit_beats(beats_of(drive, *errors, rounds=2, noise=1e-6), drive, parts=part)
        found, half = (
            getattr(alone, f"{part[:-1]}_{name}") for name in ("angle_errors", "half_widths")
        )
        assert (np.abs(found - np.array(errors[part == "slots"])) <= 2.0 * half).all()


@pytest.mark.slow
def test_other_faults_of_the_parts_are_noticed():
    heavy = replace(design(), inertia=esc.Inertia(3.39e-7, 6.2e-6), friction=0.2)
    fit = esc.fit_beats(beats_of(heavy, PINS, SLOTS, rounds=4, noise=1e-6), design())
    assert "something besides these numbers differs from the design" in fit.message
    ticks = 2e-6 * np.random.default_rng(1).normal(size=601)
    jitter = esc.fit_beats(beats_of(design(), PINS, SLOTS, rounds=40) + np.diff(ticks), design())
    # the fit finds that the noise is that of stamps, without being told
    assert jitter.rounds.jitter > 0.9
    assert "neighbouring residuals" not in jitter.message
    drift = 1.0 + 1e-4 * np.cos(np.arange(600) / 20.0)
    slow = esc.fit_beats(beats_of(design(), PINS, SLOTS, rounds=40, noise=1e-5) * drift, design())
    assert "neighbouring residuals are alike (correlation 0." in slow.message


@pytest.mark.parametrize("late", [0.03, 0.3])
def test_a_tick_out_of_place_is_named_and_its_beats_are_left_out(late):
    clean = beats_of(design(), PINS, SLOTS, rounds=10, noise=1e-4)
    ticks = np.concatenate([[0.0], np.cumsum(clean)])
    ticks[70] += late * clean[70]
    for given in (np.diff(ticks), esc.Readings.of_beats(ticks)):
        rounds = rounds_of(given, design().mechanism)
        assert f"engagement 69 takes {1.0 + late:.2f}" in "; ".join(rounds.faults)
        assert_allclose(np.delete(rounds.table.ravel(), [69, 70]), np.delete(clean, [69, 70]))
        assert np.isnan(rounds.table.ravel()[[69, 70]]).all()
    whole, fit = (esc.fit_beats(one, design()) for one in (clean, np.diff(ticks)))
    assert_allclose(fit.pin_angle_errors, whole.pin_angle_errors, atol=2e-5)
    assert_allclose(fit.pin_half_widths, whole.pin_half_widths, rtol=0.05)
    assert "a tick is out of place" in fit.message


def test_beats_that_differ_by_design_are_no_faults():
    # one slot out of five is far out, and the clock counts whole milliseconds
    beats = beats_of(design(), PINS, 10.0 * SLOTS, rounds=8)
    assert np.ptp(beats) > 0.02 * beats.mean()
    assert rounds_of(beats, design().mechanism).faults == ()
    stamps = np.round(np.cumsum(np.tile(beats, 4)), 3)
    assert rounds_of(esc.Readings.of_beats(stamps), design().mechanism).faults == ()


def test_means_are_those_of_least_squares_averaged_over_shares_of_jitter():
    """By dense matrices: each share counts by its likelihood and by its part of the range."""
    random = np.random.default_rng(0)
    stamps = np.cumsum(1.0 + 3e-3 * random.standard_normal(46)) + 0.01 * random.standard_normal(46)
    stamps[20] = np.nan
    rounds = rounds_of(esc.Readings.of_beats(stamps), design().mechanism)
    known, columns = rounds.known, np.eye(15)[rounds.known % 15]
    apart, values = np.abs(np.subtract.outer(known, known)), rounds.table.ravel()[rounds.known]
    logs, means, covariances = [], [], []
    for share in SHARES:
        covariance = np.where(apart == 0, 1.0, np.where(apart == 1, -0.5 * share, 0.0))
        inverse = np.linalg.inv(covariance)
        information = columns.T @ inverse @ columns
        means.append(np.linalg.solve(information, columns.T @ inverse @ values))
        rest = values - columns @ means[-1]
        variance = rest @ inverse @ rest / (known.size - 15)
        covariances.append(variance * np.linalg.inv(information))
        sizes = np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(information)[1]
        logs.append(-0.5 * (sizes + (known.size - 15) * np.log(variance)))
    weights = np.exp(np.array(logs) - max(logs)) * np.sqrt(1.0 - SHARES)
    weights /= weights.sum()
    assert_allclose(rounds.weights, weights, rtol=1e-6)
    mean = weights @ np.array(means)
    assert_allclose(rounds.means, mean, rtol=1e-9)
    spread = np.einsum("i,ij,ik->jk", weights, means - mean, means - mean)
    spread += np.einsum("i,ijk->jk", weights, covariances)
    variance = rounds.scatter / (known.size - 15)
    assert_allclose(variance * np.linalg.inv(rounds.root.T @ rounds.root), spread, atol=1e-12)


def test_a_rate_that_beats_do_not_determine_is_no_number():
    late, ahead = 1e-3 * np.array([0.5, -0.3, -0.2, 0.0]), 1e-3 * np.array([-1.0, 0.2, 0.3, 0.5])
    fit = esc.fit_beats(beats_of(design(4, 4), late, ahead, 2, 1e-6), design(4, 4))
    assert np.isnan([fit.rate, fit.rate_half_width]).all()
    # and still the errors that were found explain the beats, whose noise is 42 ns
    assert fit.residual < 1e-7
    # noise of six times what the pins change
    lost = esc.fit_beats(beats_of(design(6, 3), PINS, (), 10, 2.4e-4), design(6, 3), parts="pins")
    assert np.isnan([*lost.pin_angle_errors, lost.rate]).all()
    assert "the beats do not determine pins 0, 1, 2 and the rate: very diff" in lost.message


def test_pins_on_both_sides_of_a_kink_have_no_intervals():
    """Two sets of pin errors explain these beats; the true one is near neither."""
    fit = esc.fit_beats(beats_of(design(6, 3), PINS, (), 10, 1.5e-4, 2), design(6, 3), parts="pins")
    assert np.isnan([*fit.pin_angle_errors, fit.rate]).all()
    assert (fit.slot_angle_errors == 0.0).all()
    assert "the beats do not determine pins 0, 1, 2 and the rate" in fit.message


def test_lines_have_their_culprits():
    lines = esc.beat_spectrum(beats_of(design(), PINS), design().mechanism).lines
    assert [line.culprit for line in lines] == [
        "pairs", "pairs", "slots", "pairs", "pins", "slots", "pairs"
    ]  # fmt: skip
    assert_allclose([line.frequency for line in lines], 0.2 * np.arange(1, 8))
    sizes = np.array([line.amplitude for line in lines])
    assert (np.delete(sizes, 4) < 1e-9 * sizes[4]).all()
    assert np.isnan(lines[4].p_value)
    slots = esc.beat_spectrum(beats_of(design(), (), SLOTS, 3, 1e-5), design().mechanism).lines
    assert [k for k, line in enumerate(slots) if line.p_value < 1e-4] == [2, 5]
    both = esc.beat_spectrum(beats_of(design(6, 3), PINS), design(6, 3).mechanism).lines
    assert [line.culprit for line in both] == ["slots", "pins or slots", "slots"]


def test_a_sinusoid_has_its_amplitude():
    k = np.arange(60)
    beats = 1.0 + 0.01 * np.cos(2.0 * np.pi * k / 5 + 0.4)
    beats += 1e-3 * np.random.default_rng(3).normal(size=60)
    line = esc.beat_spectrum(beats, esc.Geneva(5, pins=3)).lines[2]
    assert abs(line.amplitude - 0.01) < 3.0 * line.standard_error
    assert line.standard_error == pytest.approx(1e-3 * math.sqrt(2.0 / 60), rel=0.3)


@pytest.mark.slow
def test_verdicts_are_three():
    drive = design()
    good = esc.fit_beats(beats_of(drive, PINS, SLOTS, rounds=4, noise=1e-5), drive).verdict
    assert good.good is True
    assert "that leave out zero for pin 0 (" in good.text
    heavy = replace(drive, inertia=esc.Inertia(3.39e-7, 6.2e-6), friction=0.2)
    wrong = esc.fit_beats(beats_of(heavy, PINS, SLOTS, rounds=4, noise=1e-6), drive).verdict
    assert wrong.good is False
    assert "does not explain the beats, not even with" in wrong.text
    once = esc.fit_beats(beats_of(drive, PINS, SLOTS, noise=1e-5), drive)
    assert once.verdict.good is None
    assert "no pair of a pin and a slot was measured twice" in once.verdict.text
    # seven unknowns explain any four beats
    ahead = 1e-3 * np.array([-1.0, 0.2, 0.3, 0.5])
    both = esc.fit_beats(beats_of(design(4, 4), (), ahead, 3, 1e-6), design(4, 4), noise=1e-7)
    assert math.isnan(both.p_value)
    assert both.verdict.good is None


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("minutes", 1.0 / 60.0)])
@pytest.mark.parametrize("times", [False, True])
def test_beats_in_another_unit_are_doubted(unit, factor, times):
    beats = factor * beats_of(design(), PINS, SLOTS, rounds=2, noise=1e-5)
    given = esc.Readings.of_beats(np.cumsum([0.0, *beats])) if times else beats
    with pytest.raises(esc.errors.InvalidValue, match=f"which may be {unit} taken as s"):
        esc.fit_beats(given, design())


def test_bars_of_stamps_count_with_their_covariance():
    """The scatter of means in 4000 draws is what the bars show, not that of independent beats."""
    clean = beats_of(design(), PINS, SLOTS, rounds=6)
    random = np.random.default_rng(2)
    stamps = np.concatenate([[0.0], np.cumsum(clean)]) + 5e-6 * random.standard_normal(91)
    fit = esc.fit_beats(esc.Readings.of_beats(stamps), design())
    (bars,) = plot_beats(fit).containers[0].lines[2]
    half = np.array([0.5e-6 * np.ptp(segment[:, 1]) for segment in bars.get_segments()])
    root = np.linalg.inv(fit.rounds.root)
    means = root @ random.standard_normal((15, 4000)) * fit.noise
    assert_allclose(half, 2.0 * (means - means.mean(axis=0)).std(axis=1), rtol=0.05)


def test_figures():
    beats = beats_of(design(), PINS, SLOTS, rounds=2, noise=1e-5)
    ax = plot_beats(esc.fit_beats(beats, design()))
    assert ax.get_ylabel() == "Beat minus mean (µs)"
    assert len(ax.get_xticks()) == 15
    ax = plot_beat_spectrum(esc.beat_spectrum(beats, design().mechanism))
    assert ax.get_xlabel() == "Cycles per turn of the driver"


GOOD = np.full(15, 0.03)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: esc.fit_beats(GOOD[:14], design()), "got none of pin 2 in slot 4"),
        (lambda: esc.fit_beats(-GOOD, design()), "beat 0 must be about as long as the others"),
        (lambda: esc.fit_beats("x", design()), "beats must be a row of real numbers"),
        (lambda: esc.fit_beats(GOOD, design().mechanism), "escapement must be an Escapement"),
        (lambda: esc.fit_beats(GOOD, design(), noise=0.0), "noise must be greater than 0"),
        (lambda: esc.fit_beats(GOOD, design(), parts="pin"), "did you mean 'pins'"),
        (lambda: esc.fit_beats(GOOD, design(), confidence=1.0), "between 0 and 1"),
        (lambda: esc.fit_beats(GOOD[:4], design(4, 4)), "more than the 7 unknowns, got 4"),
        (lambda: esc.fit_beats(GOOD, replace(design(), friction=2.0)), "a terminal cycle"),
        (lambda: esc.fit_beats(0.03 * np.arange(1, 40), design()), "instants as Readings.of_beats"),
        (lambda: esc.Readings.of_beats([0.0, 1.0, 1.0]), "time 2 must be later"),
        (lambda: esc.fit_beats([*GOOD, 0.06, *GOOD], design()), "beat 15 .* missed or doubled"),
        (lambda: esc.beat_spectrum(GOOD, 3), "mechanism must be a Geneva wheel"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(make, words):
    with pytest.raises(esc.errors.InvalidValue, match=words) as caught:
        make()
    assert "\n" not in str(caught.value)
