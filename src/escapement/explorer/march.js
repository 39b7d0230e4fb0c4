/** The march over an engagement: panel by panel, cut where the pin reverses or the motion stops. */

import { pose } from "./law.js";
import { Panel, Run, START, STOP } from "./panels.js";
import { N, POINTS, interpolate, root } from "./polynomial.js";

const DEEPEST = 60;
/** If a driver has less than this share of the energy that a panel adds, it counts as at rest. */
const REST_SHARE = 1e-14;
/** An engagement takes some dozens of panels; one that takes more than this does not converge. */
const MOST_PANELS = 2000;

/** Thrown if the motion ends, or if panels are halved too often. */
export class Stopped extends Error {}
export class NotConverged extends Error {}

/** The state that is carried through an engagement, and the events on the way. */
export class March {
  /** A hurried march computes only w, neither times nor extrema. */
  constructor(scene, chain, hurried = false) {
    this.hurried = hurried;
    this.scene = scene;
    this.chain = chain;
    this.rising = 0;
    this.time = 0;
  }

  /** Torque minus that of the bearing, and its slope, after a driver angle of the engagement. */
  drive(theta) {
    const { scene } = this;
    const torque = 1 - scene.rate * (this.turned + theta + scene.exit);
    if (scene.rate === 0) return [1 - scene.bearing, 0];
    return torque > 1e-9 * scene.rate
      ? [torque - scene.bearing, -scene.rate] : [-scene.bearing, 0];
  }

  spentAt(theta) {
    const { rate } = this.scene;
    return rate > 0 && 1 - rate * (this.turned + theta + this.scene.exit) <= 1e-9 * rate;
  }

  /** One engagement and its dwell from w at pin entry; throws Stopped where the motion ends. */
  engagement(w, turned = 0) {
    const { scene, chain } = this;
    Object.assign(this, { turned, time: 0, passed: 0, exponent: 0, source: 0, events: [], runs: [] });
    this.E = scene.rho * w;
    const { k } = chain.panels[0].poses[0];
    const [pull] = this.drive(-scene.exit);
    // at pin entry g is zero, and so is X at rest without a load: k > 0 decides
    const X = scene.rho * (k * w + scene.load);
    this.side = X >= 0 ? 1 : -1;
    const resting = w === 0 || (w <= 1e-6 && this.spentAt(-scene.exit));
    if (resting && pull - chain.panels[0].solution(this.side).bend[0] * scene.load <= 0) {
      this.stop(-scene.exit);
    }
    const knot = scene.rate > 0 ? 1 / scene.rate - turned - scene.exit : Infinity;
    for (const panel of chain.panels) {
      if (knot > panel.left + 1e-9 && knot < panel.right - 1e-9) {
        this.pass(this.cut(panel, panel.left, knot));
        this.pass(this.cut(panel, knot, panel.right));
      } else this.pass(panel);
    }
    return this;
  }

  get w() {
    return this.E / this.scene.rho; // g is zero at a handoff
  }

  stop(theta) {
    this.angle = theta;
    this.spent = this.spentAt(theta);
    throw new Stopped();
  }

  cut(panel, left, right, shape = 0) {
    return new Panel(panel.scene, left, right, { shape, locked: panel.locked });
  }

  /** Go over a panel; it is cut where the pin reverses or the motion stops, or is too coarse. */
  pass(panel, depth = 0, clear = false) {
    if (panel.right <= panel.left) return;
    this.passed += 1;
    if (this.passed > MOST_PANELS) throw new NotConverged();
    if (!(this.E > 0) && panel.shape !== START) {
      this.pass(this.cut(panel, panel.left, panel.right, START), depth, clear);
      return;
    }
    const { scene } = this;
    const s = this.side;
    if (this.restsBefore(panel)) {
      this.pass(panel, depth, clear);
      return;
    }
    const halve = () => {
      if (depth > DEEPEST) throw new NotConverged();
      for (const half of panel.halves) this.pass(half, depth + 1, clear);
    };
    const { shape } = panel;
    if (!panel.solution(s).fine) return void halve();
    const run = new Run(panel, s, this.E, ...this.drive(panel.left));
    const stop = run.slowest > 0 ? null : run.crossing(run.w, (x) => run.at(x).w);
    if (!clear && !panel.locked) {
      const x = run.crossing(run.push, (y) => s * run.at(y).X);
      if (x !== null && (stop === null || x < stop)) {
        const { theta } = run.at(x);
        this.pass(this.cut(panel, panel.left, theta, shape === START ? START : 0), depth, true);
        this.note("reversal", theta, this.time, this.E / this.inertia(theta));
        this.side = -s;
        this.pass(this.cut(panel, theta, panel.right, shape === STOP ? STOP : 0), depth);
        return;
      }
    }
    if (stop !== null) {
      if (shape === START) return void halve();
      const { theta } = run.at(stop);
      this.pass(this.cut(panel, panel.left, theta, STOP), depth, clear);
      this.stop(theta);
    }
    if (!this.hurried && !run.timed) return void halve();
    this.keep(run);
  }

  /**
   * Whether the driver is nearly at rest before a panel. It is then replaced by a driver that was
   * released from rest sqrt(w)/theta_ddot earlier.
   */
  restsBefore(panel) {
    const { fine, beta, bend } = panel.solution(this.side);
    const [pull] = this.drive(panel.left);
    const gain = pull * beta[1][N] + beta[0][N];
    if (!fine || this.E === 0 || !(this.E <= REST_SHARE * gain)) return false;
    const { g } = panel.poses[0];
    const torque = pull - (g + bend[0]) * this.scene.load;
    if (!(torque > 0)) return false;
    const J = this.scene.rho + g * (g + bend[0]);
    this.time -= (Math.sqrt(this.E * panel.inverse[0]) * J) / torque;
    this.E = 0;
    return true;
  }

  inertia(theta) {
    const { g } = pose(this.scene, theta);
    return this.scene.rho + g * g;
  }

  note(kind, theta, time, w) {
    this.events.push({ kind, theta, time, w });
  }

  /** Record the extrema of the driver speed in a panel, and step to its right end. */
  keep(run) {
    const { alpha, beta, exponent } = run.solution;
    const b = beta[0][N] + run.pull * beta[1][N] + run.fall * beta[2][N];
    this.source = alpha[N] * this.source + b;
    this.exponent += exponent[N];
    this.E = run.E[N];
    if (this.hurried) return;
    this.noteExtrema(run);
    run.since = this.time;
    this.runs.push(run);
    this.time += run.duration;
  }

  noteExtrema(run) {
    const { panel, Q } = run;
    const steady = panel.locked && run.fall === 0;
    let from = 0;
    for (let i = 0; i <= (steady ? 0 : N); i++) {
      const sign = Math.sign(Q[i]);
      const turns = this.rising !== 0 && sign * this.rising < 0;
      if (i === 0 && steady && panel.left !== this.scene.exit) break;
      if (turns && i === 0) {
        this.note(this.rising > 0 ? "maximum" : "minimum", panel.left, this.time, run.w[0]);
      } else if (turns) {
        const x = root((y) => run.at(y).Q, POINTS[i - 1], POINTS[i], Q[i - 1], Q[i]);
        this.extremum(run, x, this.rising);
      } else if (i > from + 1 && i < N && this.rising !== 0) {
        // a pair of extrema between two points
        const side = this.rising;
        if (side * Q[i] <= side * Q[i - 1] && side * Q[i] < side * Q[i + 1]) this.pair(run, i, side);
      }
      if (turns) from = i;
      if (sign !== 0) this.rising = sign;
    }
  }

  pair(run, i, side) {
    const values = run.Q.map((value) => side * value);
    const local = values.map((value, j) => (Math.abs(j - i) <= 1 ? value : Infinity));
    const exact = (x) => side * run.at(x).Q;
    const first = run.crossing(local, exact, i);
    if (first === null || first >= POINTS[i + 1]) return;
    const middle = first + 1e-9;
    const second = root(exact, middle, POINTS[i + 1], exact(middle), values[i + 1]);
    this.extremum(run, first, side);
    this.extremum(run, second, -side);
  }

  extremum(run, x, rising) {
    const { theta, w } = run.at(x);
    this.note(rising > 0 ? "maximum" : "minimum", theta, this.time + interpolate(run.times, x), w);
  }
}
