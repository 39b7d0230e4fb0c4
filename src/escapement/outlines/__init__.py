"""Outlines: the bodies of a mechanism as closed curves, for drawings and checks."""
