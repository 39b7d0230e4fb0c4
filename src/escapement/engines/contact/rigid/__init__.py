"""Clearance with rigid bodies: the pin touches one wall, flies, and strikes the other.

The slot is wider than the pin by 2 c. In natural units (I_f, the driving torque, the crank
radius r and sqrt(I_f/torque)), and beside the symbols of `dynamics`:

    theta, omega    driver angle from dead centre, and its speed        (theta, speed)
    phi, psi        follower angle from its nominal dead centre, speed  (phi, turning)
    c               play, half of the clearance                         (case.play)
    D               distance of the pin's centre ahead of the slot's line (ahead)
    s               the wall: +1 is ahead of the pin, and is struck where D = c; -1 behind it

While the pin touches wall s the mechanism is a slotted path with the offset delta = s c, of one
degree of freedom. It is solved over the driver angle, where twice the kinetic energy obeys a
linear equation, on panels of sixteen Gauss points. It lifts off where X has no longer the sign
of s. Then driver and follower move on their own until |D| = c. A blow passes the impulse with
Coulomb friction, which slides, sticks or slides back; what it rebounds with is `restitution`
times what it was compressed with. A rebound slower than `blow.CHATTER` is none.

The end of a cell is the nominal one: there the pin is gone, and the follower goes on between
the walls of the next slot as it is. Behind the exit of a wheel with a dwell the follower is
locked where it stands, and loses what speed it has. A motion starts with the follower at rest
and the pin in the middle of the slot.

Files, in the order in which they are best read:

    walls         the two walls as scenes, and the angles between which they are smooth
    panel         contact with a wall over a panel of driver angles
    flight        driver and follower on their own, and the first wall that the pin reaches
    blow          the impulse between pin and wall
    engagement    contact, flights and blows from entry to the end of the cell
    march         engagements one after the other, the events and the states of each
    trajectory    the pieces of a motion, as `Motion` asks for them
    simulate      the motion that `escapement.simulate` returns
    terminal      the engagement that repeats itself
"""
