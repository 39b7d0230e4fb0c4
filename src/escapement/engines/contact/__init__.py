"""The engine of clearance and compliant contact: driver and follower move on their own.

There are two laws of contact, each in a folder of its own with `simulate` and `terminal`:

    rigid      clearance and rigid bodies: contact on either wall, flights and impacts
    compliant  elastic walls

`slot` gives the position of a pin in its slot. `state_rows` names the rows of their tables of
states, and `state` converts them to SI units.
"""
