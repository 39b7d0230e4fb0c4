"""The reference engine: SciPy's solve_ivp in the time domain, piece by piece."""
