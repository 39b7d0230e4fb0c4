"""An escapement and its numbers, and the scene that engines see.

Read `escapement` first, then `scene`.

- `escapement`: what the user declares; `inputs` lists it, `numbers` reads and changes single
  numbers
- `train`, `motor`, `torque_curve`, `negator`, `stiffness`: trains, motors, torque over the driver
  angle, the torque of a constant-force spring, stiffness of a contact
- `load_curve`, `load_cells`: a load over the follower angle, and what engines see of it
- `friction_pairs`: published coefficients of friction of pairs of materials
- `materials`: elastic constants by name, and the stresses of a pin
- `checks`: whether numbers fit together; `similar`: the same in another time
- `scene`, `natural`: the input of an engine, and its numbers in natural units
"""
