/** Effect of tolerances on a figure: a cloud of many cases, computed by the package. */

import { byId, digits, element } from "./dom.js";
import { Plot } from "./plots.js";
import { Line } from "./served.js";

const WAIT = 300; // ms after the last change until all cases are computed
const FEW = 10; // during a drag, one of so many cases is computed

export class Cloud {
  constructor({ token, figures, sizes }, fields, served) {
    Object.assign(this, { fields, served, sizes, found: null });
    this.plot = new Plot(byId("cloud"));
    this.line = new Line("cloud", token, (answer) => this.hear(answer));
    const choices = figures.map(([value, textContent]) => element("option", { value, textContent }));
    byId("cloud-figure").append(...choices);
    byId("tolerances").addEventListener("input", () => this.ask());
    byId("cloud-figure").addEventListener("change", () => this.ask());
    byId("shows").addEventListener("shown", () => this.ask());
    new ResizeObserver(() => this.draw()).observe(byId("cloud"));
  }

  get tolerances() {
    const inputs = [...byId("tolerances").querySelectorAll("input")];
    return Object.fromEntries(inputs.map(({ name, value }) => [name, Number(value) / 100])
      .filter(([, share]) => share > 0));
  }

  ask() {
    if (!byId("clouds").open) return;
    const send = (size) => this.line.ask(() => ({ ...this.served.question, size,
      tolerances: this.tolerances, figure: byId("cloud-figure").value }));
    byId("cloud").classList.add("old");
    clearTimeout(this.later);
    this.later = setTimeout(() => send(this.sizes), WAIT);
    send(this.sizes / FEW);
  }

  hear(answer) {
    // the question that waits concerns a newer design
    if (!this.line.waiting) byId("cloud").classList.remove("old");
    this.found = answer.error ? null : answer;
    byId("cloud-told").textContent = answer.error ?? this.saying(answer);
    this.draw();
  }

  saying({ cases, failed, figure, kind, quantiles, seconds }) {
    const [low, middle, high] = quantiles.map((value) => this.fields.shown(value, kind));
    const none = failed ? ` ${failed} cases have no result.` : "";
    return `${cases} cases in ${digits(seconds, 2)} s. ${figure}: half of them are below ${middle}, `
      + `nine in ten lie from ${low} to ${high}.${none}`;
  }

  draw() {
    const { plot, found, fields } = this;
    plot.measure();
    if (!plot.width) return;
    const pen = plot.lower.getContext("2d");
    pen.clearRect(0, 0, plot.width, plot.height);
    if (!found) return;
    const [x, y] = [found.x, found.y].map(({ low, high, kind }) => {
      const { factor, name } = fields.units()[kind];
      return { low: low / factor, high: high / factor, unit: name ? ` [${name}]` : "" };
    });
    plot.axes([x.low, x.high], [y.low, y.high], found.x.words + x.unit, found.y.words + y.unit);
    const { counts } = found;
    const most = Math.max(...counts.flat());
    plot.within(() => {
      pen.fillStyle = plot.colour("driver");
      const [wide, high] = [(x.high - x.low) / counts.length, (y.high - y.low) / counts[0].length];
      counts.forEach((column, i) => column.forEach((count, j) => {
        if (!count) return;
        pen.globalAlpha = 0.12 + (0.88 * count) / most;
        const [left, top] = [plot.x(x.low + i * wide), plot.y(y.low + (j + 1) * high)];
        pen.fillRect(left, top, plot.x(x.low + (i + 1) * wide) - left + 0.5, plot.y(y.low + j * high) - top + 0.5);
      }));
      pen.globalAlpha = 1;
    });
  }
}
