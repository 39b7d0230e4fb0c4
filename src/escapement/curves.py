"""Curves that the pin of a gear-driven Geneva wheel traces (Dijksman 1974, 12a-d)."""

CURVES = ("hypocycloid", "epicycloid", "contracted-hypocycloid", "pericycloid")
"""Protracted hypocycloid and epicycloid, and the curve cognate of each."""
COGNATES = dict(zip(CURVES, (*CURVES[2:], *CURVES[:2]), strict=True))
"""The other pair of gears that traces the same curve."""
MOST_LOBES = 100_000
"""Most unreal lobes, and most unused ones; the search for a mechanism takes a second of them."""
