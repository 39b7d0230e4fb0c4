"""The engine of clearance and compliant contact: driver and follower move on their own.

Two laws of contact, each in a folder of its own with `simulate` and `terminal`:

    rigid      clearance and rigid bodies: contact on either wall, flights and blows
    compliant  walls that give way

`state` makes of both a state of the motion.
"""
