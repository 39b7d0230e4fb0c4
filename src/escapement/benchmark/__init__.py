"""Run time against error of the package's two engines and SciPy's solve_ivp.

`suite.run` measures, `suite.write` fills a folder; nothing is imported before it is used.
"""
