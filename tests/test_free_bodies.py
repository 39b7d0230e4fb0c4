"""A body with a shaft behind a lossy train: its equation, the direction of power, and energy."""

import numpy as np
import pytest

import escapement as esc
from escapement.dynamics import free_bodies as bodies
from escapement.engines.contact import slot
from escapement.engines.contact.rigid.impact import _thrust
from random_drives import from_python

move, shared, thrust = (from_python(f) for f in (bodies.move, bodies.shared, _thrust))


def random_body(rng, lossy=True):
    near, far, drag, viscous = 10.0 ** rng.uniform(-2, 1, 4)
    return bodies.FreeBody(near, far, rng.uniform(0.3, 0.95) if lossy else 1.0, drag, viscous, 0.0)


@pytest.mark.parametrize("lossy", [True, False], ids=["lossy", "lossless"])
def test_a_body_keeps_its_equation_and_loses_what_its_speed_takes(lossy):
    rng = np.random.default_rng(42)
    flows = set()
    for _ in range(200):
        body, sense = random_body(rng, lossy), rng.choice([-1.0, 1.0])
        speed, torque, push = sense * 10.0 ** rng.uniform(-2, 1), *rng.normal(size=2) * 3.0
        friction = rng.uniform(0.0, 1.0)
        found = move(body, speed, sense, torque, push, friction)
        # what the train takes in, and what it passes on to the body
        taken = torque - body.far * found.rate
        given = taken - found.train
        resisting = sense * friction + (body.drag * abs(speed) + body.viscous) * speed
        size = abs(torque) + abs(push) + resisting * sense
        assert abs(body.near * found.rate - given - push + resisting) < 1e-13 * size
        # power flows to the body where it moves with the torque of its train
        efficiency = body.efficiency if taken * sense > 0.0 else 1.0 / body.efficiency
        assert abs(given - efficiency * taken) < 1e-12 * size
        assert found.train * speed >= -1e-12 * size * abs(speed)
        assert found.through * taken >= 0.0
        flows.add(taken * sense > 0.0)
    assert flows == {True, False}


def test_near_rest_the_share_of_a_train_passes_from_one_direction_to_the_other():
    assert [shared(0.8, flow) for flow in (1.0, 0.0, -1.0)] == pytest.approx([0.8, 1.025, 1.25])


def test_a_journal_holds_a_body_at_rest_against_a_weaker_blow():
    rng = np.random.default_rng(7)
    for _ in range(50):
        body, push = random_body(rng), rng.normal()
        assert thrust(body, 0.0, push, abs(push) * 1.01)[0] == 0.0
        gained = thrust(body, 0.0, push, 0.5 * abs(push))[0]
        # the shaft is driven through the train
        assert gained * (body.near + body.far / body.efficiency) == pytest.approx(0.5 * push)


def test_the_wall_does_no_work_but_by_friction():
    """Torques of a force on both bodies, against the speeds across and along the slot."""
    rng = np.random.default_rng(3)
    push = from_python(slot.pushes)
    wheel = esc.Geneva(5, crank_radius=0.02, pin_radius=0.002, clearance=1e-4)
    scene = esc.Escapement(wheel, esc.Inertia(1e-6, 3e-6), 0.01, 0.2).scene
    pose, slide = from_python(slot.pose), from_python(slot.slide)
    for side in (1.0, -1.0):
        for _ in range(50):
            theta, phi, f = rng.uniform(-0.3, 0.3, 3)
            driver, follower = rng.normal(size=2)
            at = pose((theta, phi, driver, follower), 0, scene)
            on_driver, on_follower = push(at, side, f, scene)
            power = on_driver * driver + on_follower * follower
            lost = side * at.speed + f * slide(at, side, scene)
            assert power == pytest.approx(-lost, abs=1e-13)
