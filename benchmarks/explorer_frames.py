"""Script time of the explorer's page in headless Chromium, in ms, and its first picture.

It writes `results/explorer_frames.csv`, which has the least and the median time of 200
repetitions, and the mean processor time of the page's thread, which other work on the machine does
not lengthen. The motion is twenty engagements of Meyer's four-pin escapement from rest, with
friction from 0.30 to 0.40.
"""

import csv
import sys
import tempfile
from pathlib import Path

import escapement as esc
from escapement.explorer import page

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "tests"))
from browser import chromium, opened  # noqa: E402

WORK = {
    "motion": "explorer.simulate({...design, friction})",
    "motion and figures": "explorer.simulate({...design, friction}).figures",
    "drag of friction": "explorer.change({friction})",
    "playhead": "explorer.setTime(1e-4 * i)",
}
REPEAT = """() => {
    const {design} = explorer, times = [];
    for (let i = 0; i < COUNT; i++) {
        const friction = 0.3 + 0.1 * i / COUNT, start = performance.now();
        WHAT;
        times.push(performance.now() - start);
    }
    return times.sort((a, b) => a - b);
}"""
COUNT = 200
PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"


def measured(shown, ticks, what):
    """Least and median wall time, and the mean processor time of the page's thread."""
    run = REPEAT.replace("WHAT", what).replace("COUNT", str(COUNT))
    shown.evaluate(run)
    before = script(ticks)
    times = shown.evaluate(run)
    return times[0], times[COUNT // 2], 1e3 * (script(ticks) - before) / COUNT


def script(ticks):
    """Processor time of all scripts up to now [s]."""
    found = {row["name"]: row["value"] for row in ticks.send("Performance.getMetrics")["metrics"]}
    return found["DevToolsCommandDuration"]


def main():
    wheel = esc.Geneva(4, crank_radius=0.02)
    timer = esc.Escapement(wheel, esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.35)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        file = Path(folder) / "page.html"
        file.write_text(page(timer), encoding="utf-8")
        with opened(browser, file, viewport={"width": 1280, "height": 900}) as shown:
            shown.wait_for_timeout(500)
            ticks = shown.context.new_cdp_session(shown)
            ticks.send("Performance.enable", {"timeDomain": "threadTicks"})
            rows = {name: measured(shown, ticks, what) for name, what in WORK.items()}
            rows["first picture"] = (shown.evaluate(PAINT),) * 2 + (0.0,)
    lines = [("what", "least_ms", "median_ms", "processor_ms")]
    lines += [(name, *(f"{time:.2f}" for time in times)) for name, times in rows.items()]
    with (HERE / "results" / "explorer_frames.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(lines)
    for line in lines:
        print("{:<20}{:>12}{:>12}{:>14}".format(*line))


if __name__ == "__main__":
    main()
