"""Outlines that yield: driver and follower move under forces that grow with the penetration.

- `law`: the equations of motion, with the force of `dynamics.compliance` in each contact
- `march`: step by step with `dynamics.radau`, and the events between
- `rows`: states at given times, for `dynamics.compliant_steps`
- `simulate`, `terminal`: what the engine offers
"""
