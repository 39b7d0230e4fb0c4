"""Clearance with rigid bodies: the pin touches one wall, flies, and strikes the other.

The slot is wider than the pin by 2 c. In natural units (I_f, the driving torque, the crank
radius r and sqrt(I_f/torque)), and beside the symbols of `dynamics`:

    theta, omega    driver angle from dead centre, and its speed        (theta, speed)
    phi, psi        follower angle from its nominal dead centre, speed  (phi, turning)
    c               half of the clearance                        (half_clearance)
    D               distance by which the pin's centre is ahead of the slot's
                    centre line                                  (pin_offset)
    s               the wall: +1 is ahead of the pin, and is struck where D = c;
                    -1 is behind it

While the pin touches the wall s, the mechanism has one degree of freedom and follows a slotted
path with the offset delta = s c. It is solved over the driver angle, where twice the kinetic
energy obeys a linear equation, on panels of sixteen Gauss points. The pin lifts off where X no
longer has the sign of s. Then driver and follower move independently until |D| = c. In an impact
the friction is Coulomb's: the contact slides, sticks or slides back. The impulse of restitution is
`restitution` times that of compression. A rebound slower than `impact.CHATTER` is neglected.

Trains that lose power are treated as in `dynamics.train_losses`. Along a wall, each direction of
the powers has its own scene, and a panel ends where a direction changes. Without contact, driver
and follower are separate bodies, see `dynamics.free_bodies`.

A cell ends at its nominal angle: there the pin leaves the slot, and the next pin begins between
the walls of the next slot without a change of speeds. In a wheel with a dwell, the follower is
locked at its angle behind the exit and loses its speed. A motion starts with the follower at rest
and the pin in the middle of the slot.

Read `engagement` first. The files, from the bottom to the top:

- `walls`: the two walls as scenes, and the angles between which they are smooth
- `workspace`, `panel`: memory of the kernels, and contact with a wall over a panel of driver angles
- `instant`, `notes`: driver and follower at an instant, and the record of pieces and events
- `flight`, `arrival`: motion without contact, and the first wall that the pin reaches
- `impact`: the impulse between pin and wall
- `along_wall`, `touching`: contact with a wall, panel by panel
- `engagement`, `march`: one engagement, and one after the other
- `trace`, `trajectory`: states at given times, and the pieces that `Motion` asks for
- `simulate`, `terminal`: what the engine offers
"""
