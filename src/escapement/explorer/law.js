/**
 * The mechanism, the law of its motion and the limits of friction.
 *
 * The symbols are those of the theory page and of the Python module `dynamics`. Units are natural:
 * the follower's inertia I_f, the torque tau at the start, sqrt(I_f/tau) and the crank radius are
 * the units of inertia, torque, time and length. With w = theta_dot^2 and the side s of the slot
 *
 *     D = pull - c_d w,    F = k w + load,    k = g' + c_f g |g|
 *     v = V + s r_p (g - beta),    h = R - sign(v) mu r_p - s b_f
 *     p = g + c,    c = s (mu |v| + b_d + b_f g)/h,    J = rho + g p
 *     J theta_ddot = D - p F,    N h J = X = rho F + g D
 */

import { root } from "./polynomial.js";

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

/** An escapement in natural units. */
export function sceneOf(design) {
  const wheel = wheelOf(design);
  const { torque, follower_inertia: follower, friction: mu, crank_radius: crank } = design;
  const journal = (body) =>
    (design[`${body}_bearing_friction`] * design[`${body}_bearing_radius`] * Math.hypot(1, mu)) / crank;
  return {
    ...wheel, mu, rho: design.driver_inertia / follower, load: design.load_torque / torque,
    bearing: design.driver_bearing_torque / torque, rate: design.spring_rate / torque,
    c_d: design.driver_drag / follower, c_f: design.follower_drag / follower,
    r_p: design.pin_radius / crank, b_d: journal("driver"), b_f: journal("follower"),
    clock: Math.sqrt(follower / torque),
  };
}

/** Sliding speed of the contact point along the wall, per driver radian. */
export const slideAt = ({ r_p, sigma }, at, s) => at.R * at.u + s * r_p * (at.g - sigma);

/** c = p - g, and the lever h; `way` is the sign of v. */
export function bendAt(scene, at, s, way) {
  const h = at.R - way * scene.mu * scene.r_p - s * scene.b_f;
  const v = way * slideAt(scene, at, s);
  return { c: (s * (scene.mu * v + scene.b_d + scene.b_f * at.g)) / h, h };
}

/** Driver angles at which v changes its sign on either side, ascending. */
export function slideChanges(scene) {
  if (scene.r_p === 0) return [0];
  const found = [1, -1].map((s) => {
    const v = (theta) => slideAt(scene, pose(scene, theta), s);
    return v(-scene.exit) * v(scene.exit) < 0 ? root(v, -scene.exit, scene.exit) : NaN;
  });
  return found.filter((angle) => Math.abs(angle) < scene.exit - 1e-9).sort((a, b) => a - b);
}

/**
 * One over the least mu at which moment - slope mu - journal sqrt(1 + mu^2) vanishes. It is infinite
 * where the moment does not exceed the friction of a journal, and not positive where there is no
 * such mu. With mu = tan x, moment cos x - slope sin x = journal.
 */
function nearness(moment, slope, journal) {
  const [b, c] = [slope / moment, journal / moment];
  return Math.abs(c) < 1 ? (b + c * Math.sqrt(1 + b * b - c * c)) / (1 - c * c) : Infinity;
}

/** `nearness` of the friction at which J h of the side s = -1 vanishes; `way` is the sign of v. */
function nearnessAt(scene, theta, way) {
  const at = pose(scene, theta);
  const { rho, r_p, mu } = scene;
  const [inertia, share] = [rho + at.g * at.g, Math.hypot(1, mu)];
  const [driver, follower] = [scene.b_d / share, scene.b_f / share];
  const slope = at.g * way * slideAt(scene, at, -1) + inertia * way * r_p;
  return nearness(inertia * at.R, slope, at.g * (driver + at.g * follower) - inertia * follower);
}

/** The greatest nearness between angles that v keeps its sign between: there it has one maximum. */
function nearest(scene, low, high) {
  const way = Math.sign(slideAt(scene, pose(scene, 0.5 * (low + high)), -1)) || 1;
  const at = (theta) => ({ value: nearnessAt(scene, theta, way), theta });
  let [a, b] = [low, high];
  const golden = 0.6180339887498949;
  let x = at(b - golden * (b - a));
  let y = at(a + golden * (b - a));
  while (b - a > 1e-12) {
    if (x.value > y.value) [b, y, x] = [y.theta, x, at(y.theta - golden * (y.theta - a))];
    else [a, x, y] = [x.theta, y, at(x.theta + golden * (b - x.theta))];
  }
  return x.value > y.value ? x : y;
}

/** Friction at which no motion exists (after dead centre), or a second one exists (before it). */
function frictionLimit(scene, behind) {
  const [low, high] = behind ? [0, scene.exit] : [-scene.exit, 0];
  const v = (theta) => slideAt(scene, pose(scene, theta), -1);
  const ends = [low, ...(v(low) * v(high) < 0 ? [root(v, low, high)] : []), high];
  const found = ends.slice(1).map((end, i) => nearest(scene, ends[i], end));
  const radius = Math.min(pose(scene, 0).R, pose(scene, scene.exit).R);
  const lever = nearness(radius, scene.r_p, scene.b_f / Math.hypot(1, scene.mu));
  // where the lever vanishes the pin jams at no angle of its own
  const { value, theta } = [...found, { value: lever, theta: NaN }]
    .reduce((one, two) => (two.value > one.value ? two : one));
  return { friction: value > 0 ? 1 / value : Infinity, theta };
}

/**
 * The Painleve limits. For a thin pin both are min (rho + g^2)/(g |u|), in closed form: with
 * u^2 = (g1 - g)(g - g2), S = g1 + g2 and P = g1 g2 the minimum is at the root of
 * S g^3 + (4 rho - 2 P) g^2 - 3 rho S g + 2 rho P between 0 and g1.
 */
export function frictionLimits(design) {
  const key = JSON.stringify(GEOMETRY.map((name) => design[name]));
  if (key !== known.key) known = { key, limits: findLimits(design) };
  return known.limits;
}

// the limits depend only on these numbers, so they stay while friction or torque is dragged
const GEOMETRY = ["slots", "internal", "crank_radius", "driver_inertia", "follower_inertia",
  "pin_radius", "driver_bearing_friction", "driver_bearing_radius", "follower_bearing_friction",
  "follower_bearing_radius"];
let known = { key: "", limits: null };

function findLimits(design) {
  const scene = sceneOf(design);
  const { rho, centre, sigma } = scene;
  if (scene.r_p > 0 || scene.b_d > 0 || scene.b_f > 0) {
    const jams = frictionLimit(scene, true);
    return { critical: jams.friction, unique: frictionLimit(scene, false).friction,
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
