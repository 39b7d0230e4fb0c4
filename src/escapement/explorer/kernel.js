/**
 * The motion of a Geneva escapement, computed over the driver angle.
 *
 * The symbols are those of the theory page and of the Python module `dynamics`. Units are natural:
 * the follower's inertia I_f, the torque tau at the start, sqrt(I_f/tau) and the crank radius are
 * the units of inertia, torque, time and length. With w = theta_dot^2 and the side s of the slot
 *
 *     D = pull - c_d w,    F = k w + load,    k = g' + c_f g |g|
 *     v = V + s r_p (g - beta),    h = R - sign(v) mu r_p - s b_f
 *     p = g + c,    c = s (mu |v| + b_d + b_f g)/h,    J = rho + g p
 *     J theta_ddot = D - p F,    N h J = X = rho F + g D
 *
 * E = (rho + g^2) w, twice the kinetic energy, obeys dE/dtheta = A - B E, which is linear. The
 * engagement is cut into panels. On each of them E = alpha E_left + beta follows from two
 * quadratures at Chebyshev points, and the time from a third, t = int dtheta/sqrt(w).
 */

// --- a polynomial through Chebyshev points -------------------------------------------------------

const N = 16;
const indices = [...Array(N + 1).keys()];
/** The points x_i, from -1 to 1. */
const POINTS = indices.map((i) => -Math.cos((Math.PI * i) / N));
const ends = (i) => (i === 0 || i === N ? 0.5 : 1);
/** Row k gives the coefficient of the Chebyshev polynomial T_k from values at the points. */
const COEFFICIENT = indices.map((k) =>
  indices.map((j) => (2 / N) * ends(k) * ends(j) * Math.cos((Math.PI * k * (N - j)) / N)));
/** Row i gives the integral from -1 to x_i from values at the points. */
const INTEGRAL = indices.map((i) => {
  const T = (k, x) => Math.cos(k * Math.acos(x));
  const whole = (k, x) => {
    if (k === 0) return x;
    return k === 1 ? (x * x) / 2 : T(k + 1, x) / (2 * (k + 1)) - T(k - 1, x) / (2 * (k - 1));
  };
  return Float64Array.from(indices, (j) =>
    indices.reduce((sum, k) => sum + COEFFICIENT[k][j] * (whole(k, POINTS[i]) - whole(k, -1)), 0));
});
const LAST = [COEFFICIENT[N - 1], COEFFICIENT[N]].map((row) => Float64Array.from(row));
const BARYCENTRIC = indices.map((i) => (i % 2 ? -1 : 1) * ends(i));

function dot(row, values) {
  let sum = 0;
  for (let i = 0; i <= N; i++) sum += row[i] * values[i];
  return sum;
}

/** Integrals from the first point to every point. */
function integrate(values) {
  const sums = new Float64Array(N + 1);
  for (let i = 1; i <= N; i++) sums[i] = dot(INTEGRAL[i], values);
  return sums;
}

/** The polynomial through values at the points, at x. */
function interpolate(values, x) {
  let above = 0;
  let below = 0;
  for (let i = 0; i <= N; i++) {
    const way = x - POINTS[i];
    if (way === 0) return values[i];
    const weight = BARYCENTRIC[i] / way;
    above += weight * values[i];
    below += weight;
  }
  return above / below;
}

/** Size of the last two coefficients over the greatest value: how coarse the polynomial is. */
function tail(values) {
  let most = 0;
  for (let i = 0; i <= N; i++) most = Math.max(most, Math.abs(values[i]));
  const rest = Math.abs(dot(LAST[0], values)) + Math.abs(dot(LAST[1], values));
  return most > 0 ? rest / most : 0;
}

/** Root of f between low and high, where its signs differ (Anderson and Bjorck). */
export function root(f, low, high, atLow = f(low), atHigh = f(high)) {
  if (atLow === 0) return low;
  if (atHigh === 0 || atLow * atHigh > 0) return high;
  for (let i = 0; i < 100 && Math.abs(high - low) > 1e-16 + 2e-16 * Math.abs(high); i++) {
    let x = high - (atHigh * (high - low)) / (atHigh - atLow);
    if (!(x > Math.min(low, high) && x < Math.max(low, high))) x = 0.5 * (low + high);
    const value = f(x);
    if (value === 0) return x;
    if (value * atHigh < 0) [low, atLow] = [high, atHigh];
    else {
      const share = 1 - value / atHigh;
      atLow *= share > 0 ? share : 0.5;
    }
    if (x === high) return x;
    [high, atHigh] = [x, value];
  }
  return high;
}

// --- the mechanism -------------------------------------------------------------------------------

/**
 * The pin runs along C = centre + sigma exp(sigma i theta), seen from the follower's axis; sigma is
 * -1 for an external wheel and 1 for an internal one, and is also beta, the pin's turn by driver
 * radian. Returned are g, the slide u = R'/R, g' and R. The numerator of g is written so that it
 * keeps its digits next to pin entry and exit, where it is zero.
 */
export function pose(wheel, theta) {
  const { sigma, centre, exit } = wheel;
  const half = sigma > 0 ? Math.cos(0.5 * theta) : Math.sin(0.5 * theta);
  const square = (centre - 1) ** 2 + 4 * centre * half * half;
  const g = (2 * centre * Math.sin(0.5 * (exit + theta)) * Math.sin(0.5 * (exit - theta))) / square;
  const u = (-sigma * centre * Math.sin(theta)) / square;
  return { g, u, dg: u * (sigma - 2 * g), R: Math.sqrt(square) };
}

/** Angle of the follower from dead centre. */
export const followerAngle = ({ sigma, centre }, theta) =>
  Math.atan2(Math.sin(theta), centre + sigma * Math.cos(theta));

/** Geometry of a wheel, in crank radii and radians. */
export function wheelOf({ slots, pins, internal }) {
  const sigma = internal ? 1 : -1;
  const exit = Math.PI / 2 + (sigma * Math.PI) / slots;
  const cell = (2 * Math.PI) / pins;
  const continuous = Math.abs(cell - 2 * exit) < 1e-12 * cell;
  return {
    slots, pins, sigma, centre: 1 / Math.sin(Math.PI / slots), exit, cell,
    dwell: continuous ? 0 : cell - 2 * exit, step: (2 * Math.PI) / slots,
  };
}

/** Most pins of a wheel: 2n/(n - 2), and one for an internal wheel. */
export const mostPins = (slots, internal) =>
  internal ? 1 : Math.floor((2 * slots) / (slots - 2) + 1e-9);

// --- the law -------------------------------------------------------------------------------------

/** An escapement in natural units. */
export function sceneOf(design) {
  const wheel = wheelOf(design);
  const { torque, follower_inertia: follower, friction: mu, crank_radius: crank } = design;
  const journal = (body) =>
    (design[`${body}_bearing_friction`] * design[`${body}_bearing_radius`] * Math.hypot(1, mu))
    / (crank || 1);
  return {
    ...wheel, mu, rho: design.driver_inertia / follower, load: design.load_torque / torque,
    bearing: design.driver_bearing_torque / torque, rate: design.spring_rate / torque,
    c_d: design.driver_drag / follower, c_f: design.follower_drag / follower,
    r_p: design.pin_radius / (crank || 1), b_d: journal("driver"), b_f: journal("follower"),
    clock: Math.sqrt(follower / torque),
  };
}

/** Sliding speed of the contact point along the wall, per driver radian. */
const slideAt = ({ r_p, sigma }, at, s) => at.R * at.u + s * r_p * (at.g - sigma);

/** c = p - g, and the lever h; `way` is the sign of v. */
function bendAt(scene, at, s, way) {
  const h = at.R - way * scene.mu * scene.r_p - s * scene.b_f;
  const v = way * slideAt(scene, at, s);
  return { c: (s * (scene.mu * v + scene.b_d + scene.b_f * at.g)) / h, h };
}

/** Driver angles at which v changes its sign on either side, ascending. */
function slideChanges(scene) {
  if (scene.r_p === 0) return [0];
  const found = [1, -1].map((s) => {
    const v = (theta) => slideAt(scene, pose(scene, theta), s);
    return v(-scene.exit) * v(scene.exit) < 0 ? root(v, -scene.exit, scene.exit) : NaN;
  });
  return found.filter((angle) => Math.abs(angle) < scene.exit - 1e-9).sort((a, b) => a - b);
}

/** J h of the side s = -1, which must not vanish. */
function margin(scene, theta) {
  const at = pose(scene, theta);
  const way = Math.sign(slideAt(scene, at, -1)) || 1;
  const { c, h } = bendAt(scene, at, -1, way);
  return (scene.rho + at.g * (at.g + c)) * h;
}

/** Least margin between two driver angles, and where it is. */
function leastMargin(scene, low, high) {
  const lever = Math.min(pose(scene, 0).R, pose(scene, scene.exit).R)
    - scene.mu * scene.r_p - scene.b_f;
  if (!(lever > 0)) return { value: lever, theta: 0 };
  const at = (theta) => ({ value: margin(scene, theta), theta });
  const step = (high - low) / 32;
  let best = at(low);
  for (let i = 1; i <= 32; i++) {
    const next = at(low + i * step);
    if (next.value < best.value) best = next;
  }
  let a = Math.max(best.theta - step, low);
  let b = Math.min(best.theta + step, high);
  const golden = 0.6180339887498949;
  let x = at(b - golden * (b - a));
  let y = at(a + golden * (b - a));
  while (b - a > 1e-9) {
    if (x.value < y.value) [b, y, x] = [y.theta, x, at(y.theta - golden * (y.theta - a))];
    else [a, x, y] = [x.theta, y, at(x.theta + golden * (b - x.theta))];
  }
  return [x, y].reduce((least, one) => (one.value < least.value ? one : least), best);
}

/** Friction at which no motion exists (behind dead centre), or another one exists beside it. */
function frictionLimit(design, behind) {
  const least = (friction) => {
    const scene = sceneOf({ ...design, friction });
    return leastMargin(scene, behind ? 0 : -scene.exit, behind ? scene.exit : 0);
  };
  const value = (friction) => least(friction).value;
  if (!(value(0) > 0)) return { friction: 0, theta: 0 };
  let most = 1;
  while (value(most) > 0) {
    most *= 2;
    if (most > 1e3) return { friction: Infinity, theta: NaN };
  }
  const friction = root(value, 0, most);
  return { friction, theta: least(friction).theta };
}

/**
 * The Painleve limits. Of a thin pin both are min (rho + g^2)/(g |u|), in closed form: with
 * u^2 = (g1 - g)(g - g2), S = g1 + g2 and P = g1 g2 the minimum is at the root of
 * S g^3 + (4 rho - 2 P) g^2 - 3 rho S g + 2 rho P between 0 and g1.
 */
export function frictionLimits(design) {
  const key = JSON.stringify(GEOMETRY.map((name) => design[name]));
  if (key !== known.key) known = { key, limits: findLimits(design) };
  return known.limits;
}

// they change with the numbers of this list alone, and not while friction or torque is dragged
const GEOMETRY = ["slots", "internal", "crank_radius", "driver_inertia", "follower_inertia",
  "pin_radius", "driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction",
  "follower_bearing_radius"];
let known = { key: "", limits: null };

function findLimits(design) {
  const scene = sceneOf(design);
  const { rho, centre, sigma } = scene;
  if (scene.r_p > 0 || scene.b_d > 0 || scene.b_f > 0) {
    const jams = frictionLimit(design, true);
    return { critical: jams.friction, unique: frictionLimit(design, false).friction,
      theta: jams.theta };
  }
  const g1 = 1 / (1 + sigma * centre) * sigma;
  const g2 = -1 / ((centre * centre - 1) * g1); // u^2 = -g1 g2 at pin exit, where g = 0
  const [S, P] = [g1 + g2, g1 * g2];
  const cubic = (g) => ((S * g + 4 * rho - 2 * P) * g - 3 * rho * S) * g + 2 * rho * P;
  const g = root(cubic, 0, g1);
  const critical = (rho + g * g) / (g * Math.sqrt((g1 - g) * (g - g2)));
  const at = (theta) => pose(scene, theta).g - g;
  return { critical, unique: critical, theta: root(at, 0, scene.exit) };
}

// --- panels --------------------------------------------------------------------------------------

const [START, STOP] = [1, 2];
/** A polynomial is fine enough when the last coefficients are this small. */
const FINE = 1e-12;
const DEEPEST = 60;

/**
 * A stretch of driver angle on which all is smooth, with its geometry at the points. At rest
 * 1/sqrt(w) is singular: a panel that begins so (START), or ends so (STOP), takes the root of the
 * angle from there for its coordinate.
 */
class Panel {
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
    this.theta = new Float64Array(N + 1);
    this.slope = new Float64Array(N + 1);
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
   * E = alpha E_left + beta of the side s. In beta the load, the torque at the left end and its
   * slope by the angle each have a share, so that one solution serves all engagements.
   */
  solution(s) {
    return (this.sides[s > 0 ? 0 : 1] ??= this.solve(s));
  }

  solve(s) {
    const { scene, poses, inverse, slope } = this;
    const [A, bend] = [[0, 1, 2].map(() => new Float64Array(N + 1)), new Float64Array(N + 1)];
    const B = new Float64Array(N + 1);
    for (let i = 0; i <= N; i++) {
      const { g, k } = poses[i];
      const { c } = this.bend(poses[i], s);
      const amplified = 1 / (1 + g * c * inverse[i]); // (rho + g^2)/J
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
    return { bend, exponent, alpha, beta, rough };
  }

  /** Both halves of a panel, which are kept. */
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
function chainOf(scene) {
  const edges = [-scene.exit, ...slideChanges(scene), scene.exit];
  const chain = edges.slice(1).map((edge, i) => new Panel(scene, edges[i], edge));
  if (scene.dwell > 0) {
    chain.push(new Panel(scene, scene.exit, scene.exit + scene.dwell, { locked: true }));
  }
  return { panels: chain, edges };
}

// --- the motion over one panel -------------------------------------------------------------------

/** The motion over a panel on one side, from E at its left end; torque = pull + fall (theta - left). */
class Run {
  constructor(panel, s, E_left, pull, fall) {
    this.panel = panel;
    this.s = s;
    this.pull = pull;
    this.fall = fall;
    this.solution = panel.solution(s);
    this.E = new Float64Array(N + 1);
    this.w = new Float64Array(N + 1);
    this.push = new Float64Array(N + 1); // s X, which is negative behind a reversal
    this.Q = new Float64Array(N + 1);
    this.dt = this.elapsed = null;
    this.start = this.engagement = 0;
    this.fastest = 0;
    this.slowest = Infinity;
    this.reverses = false;
    const { alpha, beta } = this.solution;
    // where the motion stops E is zero, and not its rounding error
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
      // X is rounding where it is so small against its parts
      const rounding = 4e-15 * (rho * (Math.abs(k) * w + load) + g * (Math.abs(pull) + c_d * w));
      push[i] = Math.abs(X) > rounding ? s * X : 0;
      Q[i] = D - (g + bend[i]) * F;
      if (i < first || i > last) continue;
      if (w > this.fastest) this.fastest = w;
      if (w < this.slowest) this.slowest = w;
    }
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
      this.dt = new Float64Array(N + 1);
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

  /** Whether the time over the panel is accurate. */
  get timed() {
    return tail(this.slowness) <= Math.max(FINE, (4e-16 * this.fastest) / this.slowest);
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

// --- the march -----------------------------------------------------------------------------------

/** Thrown where the motion ends, and where halving panels does not end. */
class Stopped extends Error {}
class NotConverged extends Error {}

/** The state that is carried through an engagement, and what is met on the way. */
class March {
  constructor(scene, chain) {
    this.scene = scene;
    this.chain = chain;
    this.rising = 0;
    this.time = 0;
  }

  /** Torque less that of the bearing, and its slope, behind a driver angle of the engagement. */
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
    Object.assign(this, { turned, time: 0, exponent: 0, source: 0, events: [], runs: [] });
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
    if (!(this.E > 0) && panel.shape !== START) {
      this.pass(this.cut(panel, panel.left, panel.right, START), depth, clear);
      return;
    }
    const { scene } = this;
    const s = this.side;
    const halve = () => {
      if (depth > DEEPEST) throw new NotConverged();
      for (const half of panel.halves) this.pass(half, depth + 1, clear);
    };
    const { shape } = panel;
    if (panel.solution(s).rough > FINE) return void halve();
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
    if (!run.timed) return void halve();
    this.keep(run);
  }

  inertia(theta) {
    const { g } = pose(this.scene, theta);
    return this.scene.rho + g * g;
  }

  note(kind, theta, time, w) {
    this.events.push({ kind, theta, time, w });
  }

  /** Note the extrema of the driver speed in a panel, and step to its right end. */
  keep(run) {
    const { panel, Q } = run;
    const { alpha, beta, exponent } = run.solution;
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
    const b = beta[0][N] + run.pull * beta[1][N] + run.fall * beta[2][N];
    this.source = alpha[N] * this.source + b;
    this.exponent += exponent[N];
    run.start = this.time;
    this.runs.push(run);
    this.time += run.duration;
    this.E = run.E[N];
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

// --- motions and figures -------------------------------------------------------------------------

/** What a design may hold: the least and the greatest value, and the default. */
export const NUMBERS = {
  slots: [3, 40, 4], pins: [1, 6, null], crank_radius: [0, 1e3, null],
  driver_inertia: [0, 1e6, 3.39e-7], follower_inertia: [0, 1e6, 5.65e-6], torque: [0, 1e9, 0.0113],
  friction: [0, 1e3, 0], load_torque: [0, 1e9, 0], pin_radius: [0, 1e3, 0],
  driver_bearing_friction: [0, 1e3, 0], driver_bearing_radius: [0, 1e3, 0],
  follower_bearing_friction: [0, 1e3, 0], follower_bearing_radius: [0, 1e3, 0],
  driver_bearing_torque: [0, 1e9, 0], driver_drag: [0, 1e6, 0], follower_drag: [0, 1e6, 0],
  spring_rate: [0, 1e9, 0], initial_speed: [0, 1e9, 0], engagements: [1, 1000, 20],
};
const POSITIVE = ["driver_inertia", "follower_inertia", "torque", "crank_radius"];
const LENGTHS = ["pin_radius", "driver_bearing_radius", "follower_bearing_radius"];
const refuse = (name, rule, value, remedy) => {
  throw new RangeError(`${name} must be ${rule}, got ${value}; ${remedy}`);
};

/** A design with its defaults filled in; RangeError with one line where a number breaks its rule. */
export function checkDesign(given) {
  const design = { internal: false };
  for (const name of Object.keys(given)) {
    if (!(name in NUMBERS) && name !== "internal") refuse(name, "a known name", name, "leave it out");
  }
  if (![undefined, true, false].includes(given.internal)) {
    refuse("internal", "true or false", given.internal, "choose one of them");
  }
  design.internal = given.internal ?? false;
  for (const [name, [low, high, otherwise]] of Object.entries(NUMBERS)) {
    const value = given[name] ?? otherwise;
    design[name] = value;
    if (value === null) continue;
    const whole = ["slots", "pins", "engagements"].includes(name);
    if (typeof value !== "number" || !Number.isFinite(value)) {
      refuse(name, "a finite number", value, "give a number");
    }
    if (whole && !Number.isInteger(value)) refuse(name, "a whole number", value, "round it");
    if (value < low || value > high) {
      refuse(name, `from ${low} to ${high}`, value, "choose a value in this range");
    }
    if (POSITIVE.includes(name) && !(value > 0)) refuse(name, "greater than 0", value, "give its size");
  }
  const { slots, internal } = design;
  const most = mostPins(slots, internal);
  design.pins ??= !internal && (2 * slots) % (slots - 2) === 0 ? most : 1;
  if (design.pins > most) {
    refuse("pins", `at most ${most} with ${slots} slots`, design.pins, "choose fewer pins");
  }
  for (const name of LENGTHS) {
    if (design[name] > 0 && design.crank_radius === null) {
      refuse(name, "0 without a crank radius", design[name], "give the crank radius first");
    }
  }
  const wheel = wheelOf(design);
  const widest = design.crank_radius * Math.sin(Math.PI / slots)
    * Math.min(pose(wheel, 0).R, pose(wheel, wheel.exit).R);
  if (design.pin_radius > 0 && !(design.pin_radius < widest)) {
    refuse("pin_radius", `less than ${Number(widest.toPrecision(6))} m, where neighbouring slots meet`,
      design.pin_radius, "choose a thinner pin");
  }
  return design;
}

const LOSSLESS = ["mu", "b_d", "b_f", "c_d", "c_f"];
const isLossless = (scene) => LOSSLESS.every((name) => scene[name] === 0);

/** The terminal cycle: the fixed point of the map from handoff to handoff, by Newton's method. */
function terminalCycle(scene, chain, start) {
  const march = new March(scene, chain);
  let [w, follow, length] = [start, 2, 8];
  let last = start;
  for (let i = 0; i < 400; i++) {
    let found;
    march.rising = 0;
    try {
      found = march.engagement(w);
    } catch (error) {
      if (!(error instanceof Stopped)) throw error;
      if (follow > 0) return { status: "stall", angle: march.angle, engagement: i };
      [w, follow, length] = [last, length, 2 * length];
      continue;
    }
    last = found.w;
    const gap = -Math.expm1(-found.exponent);
    const turned = found.events.some(({ kind }) => kind === "reversal");
    const sound = gap > (turned ? 0 : 1e-12);
    let better = sound ? found.source / scene.rho / gap : last;
    if (!sound && last > w) better = 4 * last;
    if (sound && follow === 0 && Math.abs(better - w) <= 1e-13 * w) {
      return { status: "ok", w: better, contraction: Math.exp(-found.exponent) };
    }
    if (sound && follow === 0 && i > 60 && Math.abs(better - w) <= 1e-11 * w) {
      return { status: "ok", w: better, contraction: Math.exp(-found.exponent) };
    }
    if (follow > 0 || !(better > 0)) [better, follow] = [last, Math.max(follow - 1, 0)];
    w = better;
  }
  return { status: "not_converged" };
}

/** Greatest accelerations of driver and follower, contact moment and force over the runs. */
function peaksOf(runs) {
  const read = (run, x, q) => {
    const { w, X, Q, J, h, pose: at } = run.at(x);
    if (q === 0) return Math.abs(Q / J);
    if (q === 1) return Math.abs(at.g * (Q / J) + at.dg * w);
    return run.panel.locked ? 0 : Math.abs(q === 2 ? X / J : X / (J * h));
  };
  return [0, 1, 2, 3].map((q) => {
    let best = -1;
    const tops = [];
    for (const run of runs) {
      const values = POINTS.map((x) => read(run, x, q));
      values.forEach((value, i) => {
        best = Math.max(best, value);
        const top = !(value < values[i - 1]) && !(value < values[i + 1]);
        if (top) tops.push([value, run, i]);
      });
    }
    // a top between two points rises little above them
    for (const [value, run, i] of tops.filter((top) => top[0] > 0.9 * best)) {
      let [a, b] = [POINTS[Math.max(i - 1, 0)], POINTS[Math.min(i + 1, N)]];
      while (b - a > 1e-6) {
        const [x, y] = [b - 0.618034 * (b - a), a + 0.618034 * (b - a)];
        if (read(run, x, q) > read(run, y, q)) b = y;
        else a = x;
      }
      best = Math.max(best, value, read(run, 0.5 * (a + b), q));
    }
    return best;
  });
}

/** Figures of the terminal cycle in SI; its status and message say why there are none. */
function figuresOf({ design, scene, chain, status }, limits, w, out) {
  const base = { critical_friction: limits.critical, uniqueness_friction: limits.unique,
    critical_angle: limits.theta, jam_margin: 1 - design.friction / limits.critical,
    rise_time: NaN };
  const stalls = { ...base, status: "stall", message: "the drive cannot carry the load torque" };
  const held = { ...scene, rate: 0 };
  let first = { status, out };
  if (scene.rate > 0) {
    first = { out: emptyRecord() };
    first.status = marchAll(held, chain, w, 1, first.out).status;
  }
  if (first.status === "stall") return stalls;
  if (isLossless(scene)) {
    const gain = (1 - scene.bearing) * scene.cell - scene.load * scene.step;
    if (!(gain > 0)) return stalls;
    return { ...base, status: "no_terminal",
      message: "no terminal velocity exists: nothing takes more work at a higher speed" };
  }
  const cycle = terminalCycle(held, chain, first.out.handoffs[0].w);
  if (cycle.status === "stall") return stalls;
  if (cycle.status !== "ok") {
    return { ...base, status: cycle.status,
      message: "the search for the terminal cycle did not converge" };
  }
  const { clock } = scene;
  const march = new March(held, chain);
  const { events, runs, time } = march.engagement(cycle.w);
  const extrema = events.filter(({ kind }) => kind !== "reversal").map((event) => event.w);
  const speeds = [cycle.w, march.w, ...extrema].map((square) => Math.sqrt(square) / clock);
  const [driver, follower, moment, force] = peaksOf(runs);
  const figures = {
    ...base, status: "ok", message: "done", velocity_max: Math.max(...speeds),
    velocity_min: Math.min(...speeds), velocity_mean: scene.cell / (time * clock),
    period: time * clock, handoff_velocity: Math.sqrt(cycle.w) / clock,
    contraction: cycle.contraction,
    reversal_angles: events.filter(({ kind }) => kind === "reversal").map(({ theta }) => theta),
    acceleration_max: driver / clock ** 2, follower_acceleration_max: follower / clock ** 2,
    contact_moment_max: moment * design.torque,
    contact_force_max: design.crank_radius ? (force * design.torque) / design.crank_radius : null,
  };
  figures.rise_time = riseTime(first.out.events, figures, clock);
  if (Number.isNaN(figures.rise_time)) {
    const long = emptyRecord();
    marchAll(held, chain, w, LONGEST_RISE, long);
    figures.rise_time = riseTime(long.events, figures, clock);
  }
  return figures;
}

const emptyRecord = () => ({ handoffs: [], events: [], runs: [] });

/** March engagements from w; `out` gets handoffs, events and runs. */
function marchAll(scene, chain, w, count, out) {
  const march = new March(scene, chain);
  let [time, status] = [0, "ok"];
  for (let j = 0; j < count; j++) {
    const started = time;
    try {
      march.engagement(w, scene.rate > 0 ? j * scene.cell : 0);
    } catch (error) {
      if (!(error instanceof Stopped)) throw error;
      status = march.spent ? "spent" : "stall";
      Object.assign(out, { stopAngle: march.angle, stopEngagement: j });
    }
    time += march.time;
    out.events.push(...march.events.map((e) => ({ ...e, engagement: j, time: started + e.time })));
    out.runs.push(...march.runs.map((run) =>
      Object.assign(run, { engagement: j, start: started + run.start })));
    if (status !== "ok") break;
    w = march.w;
    out.handoffs.push({ time, w });
  }
  return { status, time };
}

/** Time of the first extremum within 2 % of its terminal value [s], or NaN. */
function riseTime(events, figures, clock) {
  const near = ({ kind, w }) => {
    const final = kind === "maximum" ? figures.velocity_max : figures.velocity_min;
    return kind !== "reversal" && Math.abs(Math.sqrt(w) / clock / final - 1) <= 0.02;
  };
  const found = events.find(near);
  return found ? found.time * clock : NaN;
}

const LONGEST_RISE = 400;

/**
 * Simulate a design from pin entry.
 *
 * A design has the names of the Python package, in SI: slots, pins, internal, crank_radius,
 * driver_inertia, follower_inertia, torque, friction, load_torque, pin_radius,
 * driver_bearing_friction, driver_bearing_radius, the same of the follower, driver_bearing_torque,
 * driver_drag, follower_drag, spring_rate, initial_speed and engagements. RangeError where one of
 * them breaks its rule.
 */
export function simulate(given) {
  const design = checkDesign(given);
  const scene = sceneOf(design);
  const limits = frictionLimits(design);
  const { clock } = scene;
  const none = { design, scene, status: "painleve", end_time: 0, handoff_times: [],
    handoff_velocities: [], reversals: [], extrema: [], runs: [] };
  const jams = scene.r_p > 0 || scene.b_d > 0 || scene.b_f > 0
    ? !(leastMargin(scene, 0, scene.exit).value > 0) : design.friction >= limits.critical;
  if (jams) {
    const figures = { status: "painleve", critical_friction: limits.critical,
      uniqueness_friction: limits.unique, critical_angle: limits.theta,
      jam_margin: 1 - design.friction / limits.critical,
      message: "friction is at or above the Painleve limit: no unique rigid motion exists" };
    return { ...none, figures, message: figures.message };
  }
  const chain = chainOf(scene);
  const out = emptyRecord();
  const w = (design.initial_speed * clock) ** 2;
  const { status, time } = marchAll(scene, chain, w, design.engagements, out);
  const inSI = ({ kind, engagement, time: t, theta, w: square }) => ({ kind, engagement,
    time: t * clock, angle: theta, theta: theta + engagement * scene.cell,
    speed: Math.sqrt(square) / clock });
  const events = out.events.map(inSI);
  const motion = {
    design, scene, chain, status, end_time: time * clock,
    handoff_times: out.handoffs.map((at) => at.time * clock),
    handoff_velocities: out.handoffs.map((at) => Math.sqrt(at.w) / clock),
    reversals: events.filter(({ kind }) => kind === "reversal"),
    extrema: events.filter(({ kind }) => kind !== "reversal"), runs: out.runs,
    stop: status === "ok" ? null : { angle: out.stopAngle, engagement: out.stopEngagement },
  };
  const reasons = { ok: "done", stall: "the drive cannot carry the load and the mechanism stops",
    spent: "the spring is spent and nothing moves any more" };
  motion.message = reasons[status];
  let figures = null;
  Object.defineProperty(motion, "figures", {
    get: () => (figures ??= figuresOf(motion, limits, w, out)),
  });
  motion.unique = design.friction < limits.unique;
  return motion;
}

/** Follower angle at a driver angle from the first dead centre, locked in dwells. */
export function lockedAngle(wheel, theta) {
  const engagement = Math.floor((theta + wheel.exit) / wheel.cell);
  const local = Math.min(theta - engagement * wheel.cell, wheel.exit);
  return engagement * wheel.step + followerAngle(wheel, local);
}

function stateOf(motion, run, x) {
  const { scene, design } = motion;
  const { clock } = scene;
  const { theta, w, X, Q, J, h, pose: at } = run.at(x);
  const free = run.panel.locked ? 0 : 1;
  const [v, a] = [Math.sqrt(Math.max(w, 0)) / clock, Q / J / clock ** 2];
  return {
    t: (run.start + interpolate(run.times, x)) * clock, engagement: run.engagement, angle: theta,
    theta: theta + run.engagement * scene.cell, theta_dot: v, theta_ddot: a, side: free * run.s,
    phi: lockedAngle(scene, theta) + run.engagement * scene.step, phi_dot: at.g * v,
    phi_ddot: at.g * a + at.dg * v * v, contact_moment: ((free * X) / J) * design.torque,
    contact_force: design.crank_radius ? ((free * X) / (J * h)) * (design.torque / design.crank_radius) : null,
  };
}

/** The state of a motion at a time [s]. */
export function stateAt(motion, t) {
  const { runs, scene } = motion;
  if (!runs.length) return null;
  const when = Math.min(Math.max(t, 0), motion.end_time) / scene.clock;
  let [low, high] = [0, runs.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (runs[middle].start <= when) low = middle;
    else high = middle - 1;
  }
  const run = runs[low];
  const since = Math.min(when - run.start, run.duration);
  const x = root((y) => interpolate(run.times, y) - since, -1, 1, -since, run.duration - since);
  return stateOf(motion, run, since > 0 ? x : -1);
}

/** Columns of the motion at the points of its panels, as it was computed, for plots; in SI. */
export function samples({ runs, scene, design }) {
  const size = runs.length * (N + 1);
  const names = ["t", "angle", "theta", "theta_dot", "phi_dot", "contact_moment", "side"];
  const columns = Object.fromEntries(names.map((name) => [name, new Float64Array(size)]));
  let row = 0;
  for (const run of runs) {
    const { panel, w, push, s, solution, times } = run;
    const turned = run.engagement * scene.cell;
    for (let i = 0; i <= N; i++, row++) {
      const { g } = panel.poses[i];
      const v = Math.sqrt(Math.max(w[i], 0)) / scene.clock;
      const J = scene.rho + g * (g + solution.bend[i]);
      columns.t[row] = (run.start + times[i]) * scene.clock;
      columns.angle[row] = panel.theta[i];
      columns.theta[row] = panel.theta[i] + turned;
      columns.theta_dot[row] = v;
      columns.phi_dot[row] = g * v;
      columns.contact_moment[row] = panel.locked ? 0 : ((s * push[i]) / J) * design.torque;
      columns.side[row] = panel.locked ? 0 : s;
    }
  }
  return columns;
}

/** Times of handoffs, reversals, slide changes, extrema and the stop [s], ascending. */
export function eventsOf(motion) {
  const { scene, chain, runs } = motion;
  const found = [...motion.reversals, ...motion.extrema].map(({ kind, time }) => ({ kind, time }));
  motion.handoff_times.forEach((time) => found.push({ kind: "handoff", time }));
  runs.forEach((run, i) => {
    const before = runs[i - 1];
    if (!before || before.engagement !== run.engagement || before.s !== run.s) return;
    const at = run.panel.left;
    if (run.panel.locked) {
      if (!before.panel.locked) found.push({ kind: "pin exit", time: run.start * scene.clock });
    } else if (chain.edges.slice(1, -1).includes(at)
      && before.panel.bend(before.panel.poses[N], run.s).h !== run.panel.bend(run.panel.poses[0], run.s).h) {
      found.push({ kind: "slide change", time: run.start * scene.clock });
    }
  });
  if (motion.stop) found.push({ kind: "stop", time: motion.end_time });
  return found.sort((one, two) => one.time - two.time);
}

/** Driver speeds at the next handoff from speeds at one [rad/s]; NaN where the motion stops. */
export function handoffMap({ scene, chain }, speeds) {
  const march = new March({ ...scene, rate: 0 }, chain);
  return speeds.map((speed) => {
    march.rising = 0;
    try {
      return Math.sqrt(march.engagement((speed * scene.clock) ** 2).w) / scene.clock;
    } catch (error) {
      if (error instanceof Stopped) return NaN;
      throw error;
    }
  });
}
