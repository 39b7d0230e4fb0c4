"""Parsing: from a study file, its content, or a design in Python to the plan of a study.

- `configuration`: the content of a study file, and the plan that it describes
- `design`: the same of an escapement and axes in Python
- `tables`: which key belongs in which table, and what every study gives
- `mechanism_table`: other sizes of a mechanism, and lists of which single numbers vary
- `columns`, `sample`: what varies, and how
"""

from escapement.study.parse.configuration import load_plan, load_tables, parse_plan
from escapement.study.parse.design import plan_from

__all__ = ["load_plan", "load_tables", "parse_plan", "plan_from"]
