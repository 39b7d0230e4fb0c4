/** Plots on canvases: a lower one with the curves, and an upper one with the playhead. */

const PAD = { left: 58, right: 12, top: 12, bottom: 36 };

/** Even steps of 1, 2 or 5 between two values. */
function ticksOf(low, high, count) {
  const raw = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((s) => s * power).find((s) => s >= raw * 0.999);
  const ticks = [];
  for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-12); k++) ticks.push(k * step);
  return { ticks, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

const label = (value, digits) =>
  Math.abs(value) >= 1e5 || (value !== 0 && digits > 4)
    ? value.toExponential(1).replace("e", "e") : value.toFixed(digits);

export class Plot {
  /** figure: an element with two canvases. Nothing is drawn while it is out of view. */
  constructor(figure) {
    this.seen = true;
    [this.lower, this.upper] = figure.querySelectorAll("canvas");
    this.figure = figure;
  }

  /** Take the size of the page and its colours. */
  measure() {
    const { width, height } = this.lower.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    for (const canvas of [this.lower, this.upper]) {
      const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
      if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    Object.assign(this, { width, height });
    const style = getComputedStyle(this.figure);
    const known = {};
    this.colour = (name) => (known[name] ??= style.getPropertyValue(`--${name}`).trim());
    // setting a font takes longer than drawing a plot
    this.lower.getContext("2d").font = `12px ${style.fontFamily}`;
  }

  /** Axes between two corners, with their words. */
  axes([x0, x1], [y0, y1], xLabel, yLabel) {
    Object.assign(this, { x0, x1: x1 > x0 ? x1 : x0 + 1, y0, y1: y1 > y0 ? y1 : y0 + 1 });
    if (!this.seen) return;
    const pen = this.lower.getContext("2d");
    pen.clearRect(0, 0, this.width, this.height);
    pen.lineWidth = 1;
    pen.setLineDash([]);
    const across = ticksOf(this.x0, this.x1, Math.max(2, Math.floor(this.width / 90)));
    const up = ticksOf(this.y0, this.y1, Math.max(2, Math.floor(this.height / 45)));
    pen.strokeStyle = this.colour("grid");
    pen.fillStyle = this.colour("muted");
    pen.beginPath();
    for (const x of across.ticks) {
      pen.moveTo(this.x(x), PAD.top);
      pen.lineTo(this.x(x), this.height - PAD.bottom);
    }
    for (const y of up.ticks) {
      pen.moveTo(PAD.left, this.y(y));
      pen.lineTo(this.width - PAD.right, this.y(y));
    }
    pen.stroke();
    pen.textAlign = "center";
    for (const x of across.ticks) {
      if (this.x(x) < this.width - 18) {
        pen.fillText(label(x, across.digits), this.x(x), this.height - PAD.bottom + 14);
      }
    }
    pen.fillText(xLabel, (PAD.left + this.width - PAD.right) / 2, this.height - 6);
    pen.textAlign = "right";
    for (const y of up.ticks) pen.fillText(label(y, up.digits), PAD.left - 5, this.y(y) + 4);
    pen.save();
    pen.translate(12, (PAD.top + this.height - PAD.bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(yLabel, 0, 0);
    pen.restore();
  }

  x(value) {
    return PAD.left + ((value - this.x0) / (this.x1 - this.x0)) * (this.width - PAD.left - PAD.right);
  }

  y(value) {
    const room = this.height - PAD.top - PAD.bottom;
    return PAD.top + (1 - (value - this.y0) / (this.y1 - this.y0)) * room;
  }

  /** Draw within the axes. */
  within(draw) {
    if (!this.seen) return;
    const pen = this.lower.getContext("2d");
    pen.save();
    pen.beginPath();
    pen.rect(PAD.left, PAD.top, this.width - PAD.left - PAD.right, this.height - PAD.top - PAD.bottom);
    pen.clip();
    draw(pen);
    pen.restore();
  }

  /**
   * A line through columns, which are multiplied by kx and ky; `lifts(i)` says whether the line is
   * interrupted before point i.
   */
  line(xs, ys, { colour, width = 1.5, dash = [], lifts = null, from = 0, to = xs.length, kx = 1, ky = 1 }) {
    this.within((pen) => {
      pen.strokeStyle = this.colour(colour);
      pen.lineWidth = width;
      pen.lineJoin = "round";
      pen.setLineDash(dash);
      pen.beginPath();
      let [px, py, lifted] = [0, 0, true];
      for (let i = from; i < to; i++) {
        const [x, y] = [this.x(kx * xs[i]), this.y(ky * ys[i])];
        if (lifts && lifts(i)) lifted = true;
        if (lifted) pen.moveTo(x, y);
        else if (i < to - 1 && Math.abs(x - px) + Math.abs(y - py) < 0.6) continue;
        else pen.lineTo(x, y);
        [px, py, lifted] = [x, y, false];
      }
      pen.stroke();
    });
  }

  /** Fill between the zero line and the values with one sign of a column, multiplied by ky. */
  fill(xs, ys, { colour, sign, from, to, ky }) {
    this.within((pen) => {
      pen.fillStyle = this.colour(colour);
      pen.beginPath();
      pen.moveTo(this.x(xs[from]), this.y(0));
      let px = -1;
      for (let i = from; i < to; i++) {
        const x = this.x(xs[i]);
        const value = sign * ys[i] > 0 ? ky * ys[i] : 0;
        if (x - px < 0.5 && value === 0) continue;
        pen.lineTo(x, this.y(value));
        px = x;
      }
      pen.lineTo(this.x(xs[to - 1]), this.y(0));
      pen.fill();
    });
  }

  /** The playhead: a line at x, or a dot at x and y. */
  head(x, y = null) {
    const pen = this.upper.getContext("2d");
    pen.clearRect(0, 0, this.width, this.height);
    if (!Number.isFinite(x) || x < this.x0 || x > this.x1) return;
    pen.strokeStyle = pen.fillStyle = this.colour("head");
    pen.lineWidth = 1.5;
    pen.beginPath();
    if (y === null) {
      pen.moveTo(this.x(x), PAD.top);
      pen.lineTo(this.x(x), this.height - PAD.bottom);
      pen.stroke();
    } else if (Number.isFinite(y)) {
      pen.arc(this.x(x), this.y(y), 4.5, 0, 2 * Math.PI);
      pen.fill();
    }
  }

  /** Call `callback` with the value under the pointer. */
  onPoint(callback) {
    const told = (event) => {
      if (event.buttons === 0 && event.type === "pointermove") return;
      const box = this.upper.getBoundingClientRect();
      const share = (event.clientX - box.left - PAD.left) / (box.width - PAD.left - PAD.right);
      callback(this.x0 + Math.min(Math.max(share, 0), 1) * (this.x1 - this.x0));
    };
    this.upper.addEventListener("pointerdown", told);
    this.upper.addEventListener("pointermove", told);
  }
}
