"""Elastic walls: driver and follower move under a contact force that grows with the penetration.

Read `law` first, then `march`.

- `law`: the equations of motion and of the contact force
- `radau`: one step of the method that integrates them
- `march`: step by step, and the events between
- `rows`, `trajectory`: states at given times, and the pieces of the motion
- `simulate`, `terminal`: what the engine offers
"""
