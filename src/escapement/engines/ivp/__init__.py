"""The reference engine: SciPy's solve_ivp in the time domain, one smooth piece after another.

    law        the equation of motion, as numbers and as solve_ivp's right-hand side
    free       a driver that turns free of the follower, in closed form
    piece      one piece: integrated, its end located, its last step taken again
    simulate   a motion as a sequence of pieces, with its events
    terminal   the terminal cycle as the fixed point of an engagement

Symbols are those of docs/theory.md: g, u and dg for g, u and g', w for the squared driver
speed, rho for I_d/I_f, mu for the losses on the two sides and sign for s. The units of inertia,
torque and time are I_f, the driving torque and sqrt(I_f/torque). In these natural units the
tolerance means the same for a watch and for a turret.
"""
