/**
 * The motion of a Geneva escapement, computed over the driver angle as the theory page has it.
 *
 * `law` holds the mechanism and its equation of motion, `panels` the linear equation of the energy
 * on a piece of an engagement, `march` an engagement, and `figures` the terminal cycle.
 */

import { bodiesOf } from "./bodies.js";
import { emptyRecord, figuresOf, marchAll } from "./figures.js";
import { followerAngle, frictionLimits, sceneOf } from "./law.js";
import { March, NotConverged, Stopped } from "./march.js";
import { chainOf } from "./panels.js";
import { N, interpolate, root } from "./polynomial.js";
import { checkDesign } from "./rules.js";

/**
 * Simulate a design from pin entry.
 *
 * A design has the names of the Python package, in SI: slots, pins, internal, crank_radius,
 * driver_inertia, follower_inertia, torque, friction, load_torque, pin_radius,
 * driver_bearing_friction, driver_bearing_radius, the same of the follower, driver_bearing_torque,
 * driver_drag, follower_drag, spring_rate, initial_speed and engagements. A number that breaks its
 * rule gives a RangeError.
 */
export function simulate(given) {
  const design = checkDesign(given);
  const scene = sceneOf(design);
  const limits = frictionLimits(design);
  const { clock } = scene;
  if (design.friction >= limits.critical) {
    const figures = { status: "painleve", critical_friction: limits.critical,
      uniqueness_friction: limits.unique, critical_angle: limits.theta,
      jam_margin: 1 - design.friction / limits.critical,
      message: "friction is at or above the Painleve limit: no unique rigid motion exists" };
    return Object.assign(offered(design, scene), { status: "painleve", end_time: 0,
      handoff_times: [], handoff_velocities: [], reversals: [], extrema: [], runs: [], figures,
      message: figures.message, next: null });
  }
  const chain = chainOf(scene);
  const out = emptyRecord();
  const w = (design.initial_speed * clock) ** 2;
  const { status, time } = marchAll(scene, chain, w, design.engagements, out);
  const inSI = ({ kind, engagement, time: t, theta, w: square }) => ({ kind, engagement,
    time: t * clock, angle: theta, theta: theta + engagement * scene.cell,
    speed: Math.sqrt(square) / clock });
  const events = out.events.map(inSI);
  const motion = Object.assign(offered(design, scene), {
    chain, status, end_time: time * clock,
    handoff_times: out.handoffs.map((at) => at.time * clock),
    handoff_velocities: out.handoffs.map((at) => Math.sqrt(at.w) / clock),
    reversals: events.filter(({ kind }) => kind === "reversal"),
    extrema: events.filter(({ kind }) => kind !== "reversal"), runs: out.runs,
    stop: status === "ok" ? null : { angle: out.stopAngle, engagement: out.stopEngagement },
  });
  const reasons = { ok: "done", stall: "the drive cannot carry the load and the mechanism stops",
    spent: "the spring is spent and nothing moves any more",
    not_converged: "the iteration did not converge within its limit" };
  motion.message = reasons[status];
  let figures = null;
  Object.defineProperty(motion, "figures", {
    get: () => (figures ??= figuresOf(motion, limits, w, out)),
  });
  motion.unique = design.friction < limits.unique;
  return motion;
}

/** The methods and data that the page uses of a motion; `Played` has the same. */
function offered(design, scene) {
  const motion = { design, scene, engine: "this page", initial_speed: design.initial_speed,
    entry: -scene.exit, cell: scene.cell, at: (t) => stateAt(motion, t),
    samples: () => samples(motion), events: () => eventsOf(motion),
    next: (speeds) => handoffMap(motion, speeds) };
  Object.defineProperty(motion, "drawn", { get: () => {
    const key = [scene.slots, scene.pins, scene.sigma, scene.r_p].join();
    if (key !== shape.key) shape = { key, ...bodiesOf(scene) };
    return shape;
  } });
  return motion;
}

// the bodies depend only on these numbers, so they stay while friction or torque is dragged
let shape = { key: "" };

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
    contact_force: ((free * X) / (J * h)) * (design.torque / design.crank_radius),
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
  const [t, angle, theta_dot, phi_dot, contact_moment] = [1, 2, 3, 4, 5].map(() => new Float64Array(size));
  const engagement = new Uint16Array(size);
  let row = 0;
  for (const run of runs) {
    const { panel, w, push, s, solution, times } = run;
    for (let i = 0; i <= N; i++, row++) {
      const { g } = panel.poses[i];
      const v = Math.sqrt(Math.max(w[i], 0)) / scene.clock;
      const J = scene.rho + g * (g + solution.bend[i]);
      t[row] = (run.start + times[i]) * scene.clock;
      angle[row] = panel.theta[i];
      engagement[row] = run.engagement;
      theta_dot[row] = v;
      phi_dot[row] = g * v;
      contact_moment[row] = panel.locked ? 0 : ((s * push[i]) / J) * design.torque;
    }
  }
  return { t, angle, engagement, theta_dot, phi_dot, contact_moment };
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
  const march = new March({ ...scene, rate: 0 }, chain, true);
  return speeds.map((speed) => {
    march.rising = 0;
    try {
      return Math.sqrt(march.engagement((speed * scene.clock) ** 2).w) / scene.clock;
    } catch (error) {
      if (error instanceof Stopped || error instanceof NotConverged) return NaN;
      throw error;
    }
  });
}
