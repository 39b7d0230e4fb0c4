"""Script time of the explorer's page in headless Chromium, in ms, and its first picture.

Writes `results/explorer_frames.csv`: of 200 repetitions the least, the median and the 90th
percentile. The motion is twenty engagements of Meyer's four pins from rest, and friction is
dragged from 0.30 to 0.40.
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

MEASURE = """() => {
    const {design} = explorer, rows = {};
    const friction = i => 0.3 + 0.1 * (i % 200) / 200;
    const work = {
        "motion": i => explorer.simulate({...design, friction: friction(i)}),
        "motion and figures": i => explorer.simulate({...design, friction: friction(i)}).figures,
        "drag of friction": i => explorer.change({friction: friction(i)}),
        "playhead": i => explorer.setTime(1e-4 * i),
    };
    for (const [name, run] of Object.entries(work)) {
        for (let i = 0; i < 100; i++) run(i);
        const times = Array.from({length: 200}, (_, i) => {
            const start = performance.now();
            run(i);
            return performance.now() - start;
        }).sort((a, b) => a - b);
        rows[name] = [times[0], times[100], times[180]];
    }
    const [paint] = performance.getEntriesByName("first-contentful-paint");
    rows["first picture"] = [paint.startTime, paint.startTime, paint.startTime];
    return rows;
}"""


def main():
    wheel = esc.Geneva(4, crank_radius=0.02)
    timer = esc.Escapement(wheel, esc.Inertia(3.39e-7, 5.65e-6), torque=0.0113, friction=0.35)
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        file = Path(folder) / "page.html"
        file.write_text(page(timer), encoding="utf-8")
        with opened(browser, file, viewport={"width": 1280, "height": 900}) as shown:
            shown.wait_for_timeout(500)
            rows = shown.evaluate(MEASURE)
    lines = [("what", "least_ms", "median_ms", "percentile_90_ms")]
    lines += [(name, *(f"{time:.2f}" for time in times)) for name, times in rows.items()]
    with (HERE / "results" / "explorer_frames.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows(lines)
    for line in lines:
        print("{:<20}{:>12}{:>12}{:>18}".format(*line))


if __name__ == "__main__":
    main()
