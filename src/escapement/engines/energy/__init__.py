"""The fast engine: the squared driver speed solved as a linear equation over the driver angle.

Symbols, those of docs/theory.md in natural units (I_f, the driving torque and sqrt(I_f/torque)
are the units of inertia, torque and time); in brackets the names they have in the code:

    theta   driver angle, 0 at dead centre [rad]             (theta, angle)
    w       theta_dot^2, squared driver speed                (w, squares)
    g       transmission function dphi/dtheta                (g)
    u       relative sliding R'/R; kernels hold |u|          (u)
    g'      dg/dtheta                                        (dg)
    rho     I_d/I_f, inertia of the driver                   (scene.rho)
    mu      loss of the side s: friction, or from eta        (scene.mu_plus, mu_minus)
    s       side of the slot that carries the force, +-1     (side)
    p       g + s mu |u|, effective ratio                    (dynamics.effective_ratio)
    J       rho + g p, reduced inertia J_s, positive         (dynamics.reduced_inertia)
    X       rho (g' w + load) + g = J N R; s = sign X        (dynamics.contact)
    E       (rho + g^2) w, twice the kinetic energy          (energy)
    A, B    coefficients of dE/dx = A - B E for one s        (gain, decay)
    b       int B from the left end of a panel               (b, exponent)
    alpha   exp(-b)                                          (alpha)
    beta    alpha int A/alpha, so E = alpha E_left + beta    (beta, source)
    x       -1 to 1 over a panel, theta' = dtheta/dx         (x, dtheta_dx)

J theta_ddot = 1 - p (g' w + load) is `dynamics.law.net_torque`, and dt/dx = theta'/sqrt(w) is the
`slowness`. A reversal is a zero of X, an extremum of the speed is a zero of J theta_ddot.

Files, in the order in which they are best read:

    gauss      (numerics.gauss) sixteen Gauss points: integrals, interpolation, tails, roots
    panels     a panel, the chain of panels of an engagement, and how one is halved
    cells      g, |u| and g' on the first halvings of each interval, tabulated once
    sampling   E, w, X, J theta_ddot and dt/dx at the points, and the signs they have there
    solve      alpha and beta of a panel, for one side of the slot; a start from rest
    locate     the x of a reversal or an extremum, and the motion after a reversal
    located_events reversals, extrema and breaks as they are noted and made exact
    passage    what the steps of a march hand on
    over_panel the way over one panel, up to a reversal, a stop or its right end
    march      one engagement from entry to exit
    calls      march and refine, called by address, and what they need of an escapement
    pairs      the pairs of a wheel in turn: an engagement with its handoff, a round of all pairs
    handoffs   times and speeds of handoffs, one engagement after the other
    peaks      the greatest accelerations, contact moment and force on a panel
    peak_rows  these of many scenes
    rundown_series thousands of engagements of a spring, as series over the angle turned
    pieces     events of a motion, and its states at given times
    trajectory events and states of a motion, of the engagements that are asked for
    simulate   the motion that `escapement.simulate` returns
    cycle      the terminal cycle by Newton's method
    leap       many engagements of a slow transient at once
    case_figures figures of merit of one case, transient included
    batch      figures of merit of many scenes
    terminal   the figures that `escapement.terminal` returns

A wheel has a round of pairs of pins and slots, which then meet again. Perfect parts make one pair;
imperfect ones make a pattern of pairs, each with a path of its own. Everything from `pairs` on goes
over rounds.

A call of simulate: `simulate.simulate` takes addresses, scene, cells and pattern from
`calls.prepared`; `handoffs.handoffs` calls `pairs.engage` for each engagement, which calls
`march.march` and goes over the handoff behind it, and keeps time and speed there; an
`EnergyTrajectory` holds them. When events are asked for, `pieces.events_of` marches again with full
detail and makes each exact. When states are asked for, `pieces.follow` solves the piece again and
inverts its time.

A call of terminal: `terminal.terminal` gives one scene to `batch.solve_rows`; that calls
`case_figures.figures`, which passes the rounds of the transient and keeps their extrema.
`cycle.terminal_cycle` finds the w that a round gives back. `case_figures` then compares the
extrema with the cycle for rise and settling time. In the end
`simulate.steady_engagement` makes the motion over the cycle, or `simulate.simulate` that over the
round of a pattern. A study calls `batch.solve` with many scenes instead, which first marks those
at or above the Painleve limit; for one scene the limit is known from `dynamics.painleve`.
"""
