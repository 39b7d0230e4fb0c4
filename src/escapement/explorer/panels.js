/**
 * Panels of an engagement, and the motion over one of them.
 *
 * E = (rho + g^2) w, twice the kinetic energy, obeys dE/dtheta = A - B E, which is linear. The
 * engagement is cut into panels. On each of them E = alpha E_left + beta follows from two
 * quadratures at Chebyshev points, and the time from a third, t = int dtheta/sqrt(w).
 */

import { bendAt, pose, slideAt, slideChanges } from "./law.js";
import { INTEGRAL, N, POINTS, blank, dot, integrate, interpolate, root, tail } from "./polynomial.js";

export const START = 1;
export const STOP = 2;
/** A polynomial is fine enough when the last coefficients are this small. */
export const FINE = 1e-12;

/**
 * A range of driver angles in which everything is smooth, with its geometry at the points. At rest
 * 1/sqrt(w) is singular: the coordinate of a panel that begins at rest (START), or ends at rest
 * (STOP), is the square root of the angle from there.
 */
export class Panel {
  constructor(scene, left, right, { shape = 0, locked = false } = {}) {
    this.scene = scene;
    this.left = left;
    this.right = right;
    this.shape = shape;
    this.locked = locked;
    this.sides = [null, null];
    this.way = [0, 0];
    this.pair = null;
    const size = right - left;
    this.theta = blank();
    this.slope = blank();
    this.poses = POINTS.map((x, i) => {
      this.theta[i] = this.angle(x);
      if (shape === 0) this.slope[i] = 0.5 * size;
      else this.slope[i] = size * 0.5 * (shape === START ? 1 + x : 1 - x);
      return this.poseAt(this.theta[i]);
    });
    this.inverse = this.poses.map(({ g }) => 1 / (scene.rho + g * g));
  }

  /** Driver angle at x. */
  angle(x) {
    const size = this.right - this.left;
    if (this.shape === START) return this.left + 0.25 * size * (1 + x) ** 2;
    if (this.shape === STOP) return this.right - 0.25 * size * (1 - x) ** 2;
    return this.left + 0.5 * size * (1 + x);
  }

  /** g, u, g', R and k at a driver angle; all but R are zero where the follower is locked. */
  poseAt(theta) {
    if (this.locked) return { g: 0, u: 0, dg: 0, R: 1, k: 0 };
    const at = pose(this.scene, theta);
    at.k = at.dg + this.scene.c_f * at.g * Math.abs(at.g);
    return at;
  }

  /** c and h at a pose, with the sign that v has in this panel. */
  bend(at, s) {
    if (this.locked) return { c: 0, h: 1 };
    const { scene, way } = this;
    const side = s > 0 ? 0 : 1;
    way[side] ||= Math.sign(slideAt(scene, pose(scene, 0.5 * (this.left + this.right)), s));
    return bendAt(scene, at, s, way[side]);
  }

  /**
   * E = alpha E_left + beta of the side s. Load, torque at the left end and the slope of the torque
   * each contribute a term to beta, so that one solution serves all engagements.
   */
  solution(s) {
    return (this.sides[s > 0 ? 0 : 1] ??= this.solve(s));
  }

  solve(s) {
    const { scene, poses, inverse, slope } = this;
    const [A, bend] = [[0, 1, 2].map(() => blank()), blank()];
    const B = blank();
    let noise = FINE;
    for (let i = 0; i <= N; i++) {
      const { g, k } = poses[i];
      const { c } = this.bend(poses[i], s);
      const amplified = 1 / (1 + g * c * inverse[i]); // (rho + g^2)/J
      // next to the Painleve limit J is a difference of nearly equal terms, and multiplies rounding
      noise = Math.max(noise, 1e-15 * amplified);
      const twice = 2 * slope[i];
      bend[i] = c;
      A[0][i] = -twice * scene.load * (g + c * scene.rho * amplified * inverse[i]);
      A[1][i] = twice * (1 - c * g * amplified * inverse[i]);
      A[2][i] = A[1][i] * (this.theta[i] - this.left);
      B[i] = twice * inverse[i]
        * ((c * scene.rho * k * inverse[i] + scene.c_d) * amplified + scene.c_f * g * g * g);
    }
    const exponent = integrate(B);
    const alpha = exponent.map((value) => Math.exp(-value));
    const beta = A.map((source) => {
      for (let i = 0; i <= N; i++) B[i] = source[i] / alpha[i];
      const sum = integrate(B);
      for (let i = 0; i <= N; i++) sum[i] *= alpha[i];
      return sum;
    });
    const rough = Math.max(tail(alpha), tail(A[1]), tail(inverse));
    return { bend, exponent, alpha, beta, fine: rough <= noise };
  }

  /** Both halves of a panel, which are computed once. */
  get halves() {
    if (!this.pair) {
      const middle = 0.5 * (this.left + this.right);
      const { locked, shape, scene } = this;
      const first = { locked, shape: shape === START ? START : 0 };
      const second = { locked, shape: shape === STOP ? STOP : 0 };
      this.pair = [
        new Panel(scene, this.left, middle, first), new Panel(scene, middle, this.right, second),
      ];
    }
    return this.pair;
  }
}

/** Panels of an engagement and its dwell. */
export function chainOf(scene) {
  const edges = [-scene.exit, ...slideChanges(scene), scene.exit];
  const chain = edges.slice(1).map((edge, i) => new Panel(scene, edges[i], edge));
  if (scene.dwell > 0) {
    chain.push(new Panel(scene, scene.exit, scene.exit + scene.dwell, { locked: true }));
  }
  return { panels: chain, edges };
}

/** The motion over a panel on one side, from E at its left end; torque = pull + fall (theta - left). */
export class Run {
  constructor(panel, s, E_left, pull, fall) {
    this.panel = panel;
    this.s = s;
    this.pull = pull;
    this.fall = fall;
    this.solution = panel.solution(s);
    this.E = blank();
    this.w = blank();
    this.push = blank(); // s X, which is negative behind a reversal
    this.Q = blank();
    this.dt = this.elapsed = null;
    // time since the start of the engagement, and of the motion
    this.since = this.start = this.engagement = 0;
    this.slowest = Infinity;
    this.reverses = false;
    const { alpha, beta } = this.solution;
    // where the motion stops, E is set to zero in place of its rounding error
    const stopped = -(beta[0][N] + pull * beta[1][N] + fall * beta[2][N]) / alpha[N];
    this.fill(panel.shape === STOP ? stopped : E_left);
  }

  fill(E_left) {
    const { panel, s, pull, fall, E: energy, w: square, push, Q } = this;
    const { alpha, beta, bend } = this.solution;
    const { scene, inverse, poses, theta, locked } = panel;
    const { rho, c_d, load } = scene;
    const [ofLoad, ofPull, ofFall] = beta;
    const [first, last] = [panel.shape === START ? 1 : 0, panel.shape === STOP ? N - 1 : N];
    for (let i = 0; i <= N; i++) {
      const E = alpha[i] * E_left + ofLoad[i] + pull * ofPull[i] + fall * ofFall[i];
      const { g, k } = poses[i];
      const w = E * inverse[i];
      const D = pull + fall * (theta[i] - panel.left) - c_d * w;
      const F = locked ? 0 : k * w + load;
      const X = rho * F + g * D;
      energy[i] = E;
      square[i] = w;
      // X counts as rounding error if it is so small against its terms
      const rounding = 4e-15 * (rho * (Math.abs(k) * w + load) + g * (Math.abs(pull) + c_d * w));
      push[i] = Math.abs(X) > rounding ? s * X : 0;
      Q[i] = D - (g + bend[i]) * F;
      if (i < first || i > last) continue;
      if (w < this.slowest) this.slowest = w;
    }
  }

  /** The same motion in another engagement, which begins with the same speed. */
  again() {
    return Object.assign(Object.create(Run.prototype), this);
  }

  /** Angle, w, X, Q = J theta_ddot, J and h at x. */
  at(x) {
    const { panel, s } = this;
    const { scene } = panel;
    const theta = panel.angle(x);
    const pose = panel.poseAt(theta);
    const { c, h } = panel.bend(pose, s);
    const w = interpolate(this.E, x) / (scene.rho + pose.g * pose.g);
    const D = this.pull + this.fall * (theta - panel.left) - scene.c_d * w;
    const F = panel.locked ? 0 : pose.k * w + scene.load;
    const J = scene.rho + pose.g * (pose.g + c);
    const [X, Q] = [scene.rho * F + pose.g * D, D - (pose.g + c) * F];
    return { theta, w, X, Q, J, h, pose };
  }

  /** dt/dx at the points, and its integral from the left end. */
  get slowness() {
    if (!this.dt) {
      const { panel, w, Q } = this;
      this.dt = blank();
      for (let i = 0; i <= N; i++) this.dt[i] = panel.slope[i] / Math.sqrt(w[i]);
      // where w is zero it grows by 2 theta_ddot with the angle
      const edge = panel.shape === START ? 0 : N;
      if (panel.shape !== 0) {
        const { g } = panel.poses[edge];
        const J = panel.scene.rho + g * (g + this.solution.bend[edge]);
        const size = panel.right - panel.left;
        this.dt[edge] = Math.sqrt((0.5 * size * J) / Math.abs(Q[edge]));
      }
    }
    return this.dt;
  }

  get times() {
    return (this.elapsed ??= integrate(this.slowness));
  }

  get duration() {
    return dot(INTEGRAL[N], this.slowness);
  }

  /** Whether the time over the panel is accurate, as far as rounding lets it before a stop. */
  get timed() {
    return tail(this.slowness) <= Math.max(FINE, (4e-16 * this.w[0]) / this.slowest);
  }

  /**
   * First x at which values change from positive to negative, from the point `from` on, or null.
   * A pair of changes between two points shows where the parabola through three points dips
   * below zero.
   */
  crossing(values, exact, from = 1) {
    for (let i = from; i <= N; i++) {
      const value = values[i];
      if (value < 0) return root(exact, POINTS[i - 1], POINTS[i], Math.max(values[i - 1], 0), value);
      if (i === N || !(value <= values[i - 1] && value < values[i + 1])) continue;
      const [one, two] = [POINTS[i - 1] - POINTS[i], POINTS[i + 1] - POINTS[i]];
      const [f1, f2] = [(values[i - 1] - value) / one, (values[i + 1] - value) / two];
      const bend = (f2 - f1) / (two - one);
      const slope = f1 - bend * one;
      const x = (-0.5 * slope) / bend;
      if (value + 0.5 * x * slope > 0.1 * value) continue;
      const least = exact(POINTS[i] + x);
      if (!(least < -1e-14 * Math.abs(values[i - 1]))) continue;
      const low = x > 0 ? i : i - 1;
      return root(exact, POINTS[low], POINTS[i] + x, values[low], least);
    }
    return null;
  }
}
