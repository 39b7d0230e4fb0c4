/** The cases of a study, chosen by its axes. */

import { byId, digits, element } from "./dom.js";
import { Plot } from "./plots.js";

const named = (words, unit) => (unit && unit !== "1" ? `${words} [${unit}]` : words);

export class StudyView {
  /** study : axes and results, each a list of objects with name, words, unit and values. */
  constructor(study, served) {
    Object.assign(this, study, { served, place: study.axes.map(() => 0) });
    this.plot = new Plot(byId("study-plot"));
    byId("study-title").textContent = study.title;
    this.results.forEach(({ words }, value) => byId("study-result").append(
      element("option", { value, textContent: words })));
    byId("study-result").addEventListener("change", () => this.draw());
    byId("axes").append(...this.axes.map((axis, i) => this.slider(axis, i)));
    this.plot.onPoint((x) => this.go(0, this.nearest(x)));
    new ResizeObserver(() => this.draw()).observe(byId("study-plot"));
  }

  slider({ words, unit, values }, i) {
    const label = element("output");
    const slider = element("input", { type: "range", min: 0, max: values.length - 1, step: 1, value: 0 });
    slider.addEventListener("input", () => this.go(i, Number(slider.value)));
    const tell = () => {
      slider.value = this.place[i];
      label.textContent = `${digits(values[this.place[i]])} ${unit}`;
      slider.setAttribute("aria-valuetext", label.textContent);
    };
    (this.told ??= []).push(tell);
    tell();
    return element("label", { className: "wide" }, `${words} `, slider, label);
  }

  /** Take another value of an axis, and the case that it makes. */
  go(axis, index) {
    if (this.place[axis] === index) return;
    this.place[axis] = index;
    this.told.forEach((tell) => tell());
    this.served.ask({ case: this.at(this.place) });
    this.draw();
  }

  at(place) {
    return place.reduce((sum, index, i) => sum * this.axes[i].values.length + index, 0);
  }

  nearest(x) {
    const apart = this.axes[0].values.map((value) => Math.abs(value - x));
    return apart.indexOf(Math.min(...apart));
  }

  /** A result over the first axis, at the chosen values of the others. */
  draw() {
    this.plot.measure();
    if (!this.plot.width) return;
    const [{ values: xs, words, unit }] = this.axes;
    const result = this.results[Number(byId("study-result").value)];
    const ys = xs.map((_, i) => result.values[this.at([i, ...this.place.slice(1)])] ?? NaN);
    const known = ys.filter(Number.isFinite);
    const [low, high] = known.length ? [Math.min(...known), Math.max(...known)] : [0, 1];
    const room = 0.05 * (high - low || Math.abs(high) || 1);
    this.plot.axes([Math.min(...xs), Math.max(...xs)], [low - room, high + room],
      named(words, unit), named(result.name, result.unit));
    this.plot.line(xs, ys, { colour: "driver", width: 2,
      lifts: (i) => !Number.isFinite(ys[i]) || !Number.isFinite(ys[i - 1]) });
    this.plot.head(xs[this.place[0]], ys[this.place[0]]);
  }
}
