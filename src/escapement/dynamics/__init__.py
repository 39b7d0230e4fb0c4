"""The law of motion, and what is read from a motion.

Read `law` first: it is the equation of motion.

- `codes`: kinds of events, and how an engagement ends
- `law`, `torque`, `load`, `power_flow`, `train_losses`, `state_table`: the equation, the torque of
  the drive, a load that changes, trains that lose power, and what kernels tabulate
- `free_bodies`: driver and follower that move on their own
- `needs`: what a scene needs, for which alone kernels are compiled
- `painleve`: the friction at which the equation loses its solution
- `trajectory`, `motion`, `variables`: the output of an engine, the reader of it, and names of
  its variables
- `events`, `flow_changes`, `impacts`: handoffs, changes of the direction of power, and impacts of
  a motion
- `event_rows`, `followed`: rows of events of an engagement, and a motion of engagements that an
  engine follows one after the other
- `contact_state`, `state_from_table`: columns of a state in contact, and states by their columns
- `energy_balance`: where the work went
- `compliance`, `radau`, `compliant_steps`, `compliant_march`, `compliant_cycle`: the force of a
  wall that yields, the step that integrates it, the motion of such steps, and its cycle
- `batch_spread`: means over engagements that do not repeat themselves
- `figures_of_merit`, `motor_figures`, `figure_table`, `figure_record`: figures of merit, those of a
  motor, their declarations, and what is told of them
"""
