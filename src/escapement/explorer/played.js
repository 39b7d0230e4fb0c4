/** A motion that the package computed: polynomials in time, as `played.py` writes them. */

import { N, interpolate } from "./polynomial.js";

/** Doubles from text, little end first. */
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

const COUNT = 5; // theta, theta_dot, phi, phi_dot, contact_moment

/** Offers what the motions of `kernel.simulate` offer: at, samples, events and figures. */
export class Played {
  constructor({ spans, events, ...told }) {
    const { start, stop, values, side, engagement } = spans;
    Object.assign(this, told, { side, engagement, next: null });
    this.start = unpacked(start);
    this.stop = unpacked(stop);
    this.values = unpacked(values);
    this.happened = events;
    for (const name of Object.keys(this.figures)) {
      const value = this.figures[name];
      if (value === null || value === "Infinity") this.figures[name] = Number(value ?? NaN);
    }
    this.unique = !(this.design.friction >= this.figures.uniqueness_friction);
  }

  row(span, column) {
    const first = (span * COUNT + column) * (N + 1);
    return this.values.subarray(first, first + N + 1);
  }

  at(t) {
    const { start, stop } = this;
    if (!start.length) return null;
    const when = Math.min(Math.max(t, 0), this.end_time);
    let [low, high] = [0, start.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (start[middle] <= when) low = middle;
      else high = middle - 1;
    }
    const x = Math.min((2 * (when - start[low])) / (stop[low] - start[low]) - 1, 1);
    const [theta, theta_dot, phi, phi_dot, contact_moment] = Array.from({ length: COUNT }, (_, i) =>
      interpolate(this.row(low, i), x));
    const engagement = this.engagement[low];
    return { t: when, engagement, angle: theta - engagement * this.cell, theta, theta_dot, phi,
      phi_dot, contact_moment, side: this.side[low] };
  }

  samples() {
    const { start, stop, side, engagement, cell } = this;
    const size = start.length * (N + 1);
    const names = ["t", "angle", "theta_dot", "phi_dot", "contact_moment", "engagement"];
    const columns = Object.fromEntries(names.map((name) => [name, new Float64Array(size)]));
    for (let k = 0, i = 0; k < start.length; k++) {
      const rows = [0, 1, 3, 4].map((column) => this.row(k, column));
      for (let j = 0; j <= N; j++, i++) {
        const x = -Math.cos((Math.PI * j) / N);
        columns.t[i] = start[k] + 0.5 * (stop[k] - start[k]) * (1 + x);
        columns.angle[i] = rows[0][j] - engagement[k] * cell;
        columns.theta_dot[i] = rows[1][j];
        columns.phi_dot[i] = rows[2][j];
        columns.contact_moment[i] = side[k] ? rows[3][j] : 0;
        columns.engagement[i] = engagement[k];
      }
    }
    return columns;
  }

  events() {
    return this.happened;
  }
}
