"""Run time against error of the package's two engines and SciPy's solve_ivp.

`work_precision.run` measures, `work_precision.write` fills a folder.
"""
