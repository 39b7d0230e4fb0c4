"""Two bodies that touch with their outlines: lines, arcs, corners and pins.

Driver and follower turn about fixed axes, and each has a list of `mechanisms.features.Features`. A
contact is that of a nose on a track. In natural units (I_f, the driving torque, the mechanism's
unit of length and sqrt(I_f/torque)) the motion consists of flights, in which the bodies are
independent, and of contacts of one pair of features, with blows in between. Angles of both bodies
are counterclockwise. An engagement is one pitch of the driver.

Read `march` first. The files, from the bottom to the top:

- `pairs`: the pairs of features that can touch, as a table for kernels
- `touch`: gap and directions of a pair, and how near it is
- `law`: torques, and accelerations in flight and in contact
- `blow`: the impulse of a blow with friction and restitution
- `step`: one step, and the first event in it
- `overlap`: whether bodies overlap
- `watch`: the pair that closes first in a step
- `change`: the mode behind an event
- `march`: from handoff to handoff
- `trace`, `trajectory`: states at given times, and the pieces that `Motion` asks for
- `scene`: an escapement as the kernels take it
- `simulate`, `terminal`: what the engine offers
- `compliant`: outlines that yield, in a folder of its own with the same steps
"""
