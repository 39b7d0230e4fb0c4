"""Random bodies with outlines: whether they overlap, energy balance, and momentum in blows.

``python benchmarks/outline_cases.py [--geometries 2000] [--pitches 50] [--polygons 52]``
draws geometries around runaway escapements with pins and with flat pallets, deadbeat and recoil
clocks, and Geneva wheels with clearance whose outlines are given, with friction up to 0.3; some of
them rebound or lose energy elsewhere. The gap of lines and arcs, which shares nothing with the
engine, is taken where pieces begin and end and three times within each. Impulses are compared with
the momentum that both bodies gain in a blow at the point where that gap is least. Some geometries
are checked by Shapely too, at 200 instants of each of five pitches: its polygons leave arcs by less
than 1e-6 radii, and bodies of which one is made smaller by two times this must not touch. A line
for each case goes to the output, and a row for each kind to ``results/outline_cases.csv``, in units
of the radius of wheel or crank, of the work, and of the impulse.
"""

import cmath
import math

import numpy as np
import shapely
from common import asked, tell

import escapement as esc
from escapement.base.errors import InvalidValue
from escapement.base.status import Status
from escapement.outlines.gaps import Segments, gap, nearest_on, segments_of
from escapement.outlines.touching import edges_of

RAD, CHORD, PARTS, TIE = math.pi / 180.0, 1e-6, 4, 1e-9


def geneva(near):
    """A Geneva wheel with clearance by its outlines; a pin enters at the angles 0."""
    slots = (3, 4, 6)[int(3.0 * near(0.5) - 1.5)]
    centre, half, pin = 1.0 / math.sin(math.pi / slots), 1e-3 * near(0.9), 0.03 * near(0.5)
    entry = math.pi / slots - 0.5 * math.pi
    along = np.exp(1j * entry) - centre
    along /= abs(along)
    bottom, wall = max(centre - 1.2, 0.05), half + pin
    end = math.sqrt(centre**2 - 1.0 - half**2)
    slot = [end - 1j * wall, bottom - 1j * wall, bottom + 1j * wall, end + 1j * wall]
    slot = along * np.array([*slot, slot[0] * np.exp(2j * math.pi / slots)])
    at = np.exp(1j * entry) + np.array([pin, -pin, pin])
    rows = [[(z.real, z.imag, bulge) for z in body] for body, bulge in ((at, 1.0), (slot, 0.0))]
    return esc.Outlines(rows[:1], rows[1:], centre, 2 * slots // (slots - 2), slots)


def pins(near):
    """A runaway escapement with pins."""
    return esc.Runaway(
        12, 1.0, 0.22 * near(0.05), 45 * RAD * near(0.1), 15 * RAD * near(0.3), 0.01 * near(0.5),
        pallets="pins", span=2.5, pallet_radius=1.02 * near(0.005), pin_radius=0.05 * near(0.1),
    )  # fmt: skip


def flat(near):
    """A runaway escapement with flat pallets."""
    return esc.Runaway(
        20, 1.0, 0.2 * near(0.05), -5 * RAD * near(0.5), 30 * RAD * near(0.05), 0.01 * near(0.5),
        pallets="flat", span=3.5, pallet_radius=0.95 * near(0.004), pallet_length=0.2,
        pallet_angle=45 * RAD * near(0.05), pallet_thickness=0.08 * near(0.1),
        corner_radius=0.01 * near(0.5),
    )  # fmt: skip


def clock(near):
    """A deadbeat or a recoil escapement."""
    wheel = 30, 1.0, 0.2, -8 * RAD, 35 * RAD, 0.002 * near(0.9), 7.5
    sizes = {"lift": 2 * RAD * near(0.2), "lock": 0.5 * RAD * near(0.3), "drop": RAD * near(0.2)}
    if near(0.5) < 1.0:
        return esc.Deadbeat(*wheel, **sizes)
    return esc.Recoil(*wheel, **sizes, recoil_angle=10 * RAD * near(0.5))


KINDS = {
    "pins": (pins, (1.0, 0.3), 1.0), "flat": (flat, (1.0, 0.1), 1.0),
    "clock": (clock, (1e-4, 1.0), 0.006), "geneva": (geneva, (0.06, 1.0), 1.0),
}  # fmt: skip
"""How a geometry is drawn, inertias of driver and follower, and the torque."""


def case(kind, seed):
    """A random escapement."""
    random = np.random.default_rng([seed, list(KINDS).index(kind)])
    make, inertias, torque = KINDS[kind]

    def near(spread):
        return random.uniform(1.0 - spread, 1.0 + spread)

    model = {"friction": random.uniform(0.0, 0.3)}
    if kind == "clock":
        model |= {"follower_gravity": 1.0, "follower_viscous": 0.02, "friction": 0.1 * near(0.5)}
    elif random.random() < 0.3:
        model |= {"driver_bearing_torque": 0.02, "driver_drag": 0.02, "follower_viscous": 0.01}
        model |= {"follower_bearing_friction": 0.1, "follower_bearing_radius": 0.02}
    if random.random() < 0.3:
        model["restitution"] = random.uniform(0.0, 0.4)
    inertia = esc.Inertia(inertias[0] * near(0.3), inertias[1] * near(0.3))
    while True:
        try:
            return esc.Escapement(make(near), inertia, torque, **model)
        except InvalidValue:
            continue


def edges(wheel):
    """The edges of both bodies of a mechanism, each about its own axis."""
    bodies = (wheel.driver_chains, wheel.driver_fold), (wheel.follower_chains, wheel.follower_fold)
    return [edges_of(*body) for body in bodies]


def outlines_at(wheel, theta, phi):
    """Lines and arcs of both bodies in a pose."""
    driver, follower = map(segments_of, edges(wheel))
    turned = cmath.rect(1.0, theta), cmath.rect(1.0, phi)
    return driver.moved(turned[0], 0.0), follower.moved(turned[1], wheel.axes_distance)


def edge_at(bodies, point):
    """Direction of the edge at a point where two bodies touch, of which one may have a corner."""
    every = Segments(*(np.concatenate(column) for column in zip(*bodies, strict=True)))
    nearest, along = nearest_on(every, point)
    inner = np.minimum(np.abs(every.start - point), np.abs(every.end - point))
    k = np.argmax(np.where(np.abs(nearest - point) < TIE, inner, -1.0))
    return along[k] / abs(along[k])


def between(motion):
    """Instants at which pieces begin and end, and some within them."""
    ends = np.append(motion.trajectory.start, motion.end_time)
    return (ends[:-1, None] + np.diff(ends)[:, None] * np.arange(PARTS) / PARTS).ravel()


def momentum(motion):
    """How much the impulse of a blow differs from the momentum that both bodies gain.

    It is a share of the greatest impulse, beyond what the bodies gain in two roundings of the time
    before and after. Blows are left out where two contacts take impulses at once, as of Geneva
    wheels at handoffs and where the bodies touch already, and with bearings whose friction takes
    momentum.
    """
    own, impacts, start = motion.escapement, motion.impacts, motion.trajectory.start
    centre, late, worst = own.mechanism.axes_distance, 2.0 * np.spacing(motion.end_time), 0.0
    inertias = np.array([own.inertia.driver, own.inertia.follower])
    if own.follower_bearing_friction or isinstance(own.mechanism, esc.Outlines):
        return 0.0
    for time, impulse in zip(impacts.time, impacts.impulse, strict=True):
        alone = np.sum(np.abs(impacts.time - time) < 1e-9) == 1
        after = int(np.searchsorted(start, time, side="right")) - 1
        if not alone or start[after] != time or after == 0:
            continue
        old, new = (motion.within(k, time) for k in (after - 1, after))
        before = motion.within(after - 1, 0.5 * (start[after - 1] + time))
        apart = outlines_at(own.mechanism, float(before.theta), float(before.phi))
        if gap(*apart)[0] < 1e-12:
            continue
        bodies = outlines_at(own.mechanism, float(new.theta), float(new.phi))
        along = edge_at(bodies, point := gap(*bodies)[1])
        matrix = [[-point.imag, point.real], [point.imag, centre - point.real]]
        gains = [
            [new.theta_dot - old.theta_dot, late * old.theta_ddot, late * new.theta_ddot],
            [new.phi_dot - old.phi_dot, late * old.phi_ddot, late * new.phi_ddot],
        ]
        forces = np.linalg.solve(matrix, inertias[:, None] * gains)
        found, *allowed = np.abs([-along.imag, along.real] @ forces)
        worst = max(worst, abs(found - impulse) - sum(allowed))
    return worst / impacts.impulse.max(initial=1e-300)


def crossings(motion):
    """At how many instants polygons overlap by more than their error."""
    wheel = motion.escapement.mechanism
    shapes = []
    for body in edges(wheel):
        size = max(np.abs(edge.corners).max() for edge in body)
        rings = [edge.drawn(math.sqrt(CHORD / size)) for edge in body]
        shapes.append(shapely.union_all([shapely.Polygon(np.c_[z.real, z.imag]) for z in rings]))
    driver, follower = shapes[0], shapes[1].buffer(-2.0 * CHORD)
    shapely.prepare(driver)
    poses, found = motion.at(np.linspace(0.0, motion.end_time, 200 * len(motion.handoff_times))), 0
    for q, phi in zip(poses.theta.tolist(), poses.phi.tolist(), strict=True):
        turn, place = cmath.rect(1.0, phi - q), cmath.rect(wheel.axes_distance, -q)
        matrix = turn.real, -turn.imag, turn.imag, turn.real, place.real, place.imag
        found += driver.intersects(shapely.affinity.affine_transform(follower, matrix))
    return found


def main():
    """Run the cases, write a row for each kind, print them."""
    count, pitches, polygons, whole = asked(__doc__, geometries=2000, pitches=50, polygons=52)
    rows = []
    for kind in KINDS:
        statuses, deep, balance, gained, crossed = [], [], [], [], 0
        for seed in range(count // len(KINDS)):
            motion = esc.simulate(case(kind, seed), pitches)
            statuses.append(motion.status)
            if not motion.handoff_times.size:
                continue
            wheel, poses = motion.escapement.mechanism, motion.at(between(motion))
            every = zip(poses.theta.tolist(), poses.phi.tolist(), strict=True)
            deep.append(min(gap(*outlines_at(wheel, *pose))[0] for pose in every))
            balance.append(abs(motion.ledger.residual))
            gained.append(momentum(motion))
            if seed < polygons // len(KINDS):
                crossed += crossings(esc.simulate(motion.escapement, 5))
            bad = motion.status is Status.NOT_CONVERGED or deep[-1] < -1e-12
            bad = bad or balance[-1] > 1e-11 or gained[-1] > 1e-12
            words = (motion.message,) if bad else ()
            print(kind, seed, deep[-1], balance[-1], gained[-1], *words, flush=True)
        rows.append({
            "kind": kind, "geometries": len(statuses), "ran": statuses.count(Status.OK),
            "lost": statuses.count(Status.NOT_CONVERGED), "least gap": min(deep),
            "energy": max(balance), "momentum": max(gained), "polygons crossed": crossed,
        })  # fmt: skip
    tell("outline_cases", rows, whole)


if __name__ == "__main__":
    main()
