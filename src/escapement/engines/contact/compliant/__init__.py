"""Elastic walls: driver and follower move under a contact force that grows with the penetration.

Read `law` first, then `march`.

- `law`: the equations of motion, with the force of `dynamics.compliance`
- `march`: step by step with `dynamics.radau`, and the events between
- `rows`: states at given times, for `dynamics.compliant_steps`
- `simulate`, `terminal`: what the engine offers
"""
