"""The fast engine: the driver-angle domain, where the squared speed obeys a linear equation."""
