"""Engines: each turns a scene into a motion, and none knows another."""
