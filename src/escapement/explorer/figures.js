/** Motions in natural units, the terminal cycle, and its figures of merit. */

import { March, NotConverged, Stopped } from "./march.js";
import { N, POINTS } from "./polynomial.js";

const LONGEST_RISE = 200;
const LOSSLESS = ["mu", "b_d", "b_f", "c_d", "c_f"];
const isLossless = (scene) => LOSSLESS.every((name) => scene[name] === 0);

/** The terminal cycle: the fixed point of the map from handoff to handoff, by Newton's method. */
function terminalCycle(scene, chain, start) {
  const march = new March(scene, chain, true);
  let [w, follow, length] = [start, 2, 8];
  let last = start;
  for (let i = 0; i < 400; i++) {
    let found;
    march.rising = 0;
    try {
      found = march.engagement(w);
    } catch (error) {
      if (error instanceof NotConverged) return { status: "not_converged" };
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
    if (sound && follow === 0 && Math.abs(better - w) <= (i > 60 ? 1e-11 : 1e-13) * w) {
      return { status: "ok", w: better, contraction: Math.exp(-found.exponent) };
    }
    if (follow > 0 || !(better > 0)) [better, follow] = [last, Math.max(follow - 1, 0)];
    w = better;
  }
  return { status: "not_converged" };
}

/** Greatest accelerations of driver and follower, contact moment and force over the runs. */
function peaksOf(runs) {
  const of = ({ w, X, Q, J, h, pose: at }, run, q) => {
    if (q === 0) return Math.abs(Q / J);
    if (q === 1) return Math.abs(at.g * (Q / J) + at.dg * w);
    return run.panel.locked ? 0 : Math.abs(q === 2 ? X / J : X / (J * h));
  };
  const read = (run, x, q) => of(run.at(x), run, q);
  const states = runs.map((run) => POINTS.map((x) => run.at(x)));
  return [0, 1, 2, 3].map((q) => {
    let best = -1;
    const tops = [];
    for (const [k, run] of runs.entries()) {
      const values = states[k].map((state) => of(state, run, q));
      values.forEach((value, i) => {
        best = Math.max(best, value);
        const top = !(value < values[i - 1]) && !(value < values[i + 1]);
        if (top) tops.push([value, run, i]);
      });
    }
    // a maximum between two points is little higher than the points
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

/** Figures of the terminal cycle in SI; if there are none, status and message say why. */
export function figuresOf({ design, scene, chain, status }, limits, w, out) {
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
  const lost = { ...base, status: "not_converged",
    message: "the search for the terminal cycle did not converge" };
  if (first.status === "stall") return stalls;
  if (first.status !== "ok" && !first.out.handoffs.length) return lost;
  if (isLossless(scene)) {
    const gain = (1 - scene.bearing) * scene.cell - scene.load * scene.step;
    if (!(gain > 0)) return stalls;
    return { ...base, status: "no_terminal",
      message: "no terminal velocity exists: no loss grows with the speed" };
  }
  const cycle = terminalCycle(held, chain, first.out.handoffs[0].w);
  if (cycle.status === "stall") return stalls;
  if (cycle.status !== "ok") return lost;
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
    contact_force_max: (force * design.torque) / design.crank_radius,
  };
  figures.rise_time = riseTime(first.out.events, figures, clock);
  if (Number.isNaN(figures.rise_time)) {
    const long = emptyRecord();
    marchAll(held, chain, w, LONGEST_RISE, long);
    figures.rise_time = riseTime(long.events, figures, clock);
  }
  return figures;
}

export const emptyRecord = () => ({ handoffs: [], events: [], runs: [] });

/** Compute engagements from w; `out` receives handoffs, events and runs. */
export function marchAll(scene, chain, w, count, out) {
  const march = new March(scene, chain);
  let [time, status] = [0, "ok"];
  let [before, rose] = [NaN, 0];
  for (let j = 0; j < count; j++) {
    const started = time;
    // an engagement that begins as the last one is the same: the next ones differ even less
    const same = scene.rate === 0 && march.rising === rose && Math.abs(w - before) <= 1e-12 * w;
    [before, rose] = [w, march.rising];
    try {
      if (same) march.runs = march.runs.map((run) => run.again());
      else march.engagement(w, scene.rate > 0 ? j * scene.cell : 0);
    } catch (error) {
      if (error instanceof NotConverged) return { status: "not_converged", time: started };
      if (!(error instanceof Stopped)) throw error;
      status = march.spent ? "spent" : "stall";
      Object.assign(out, { stopAngle: march.angle, stopEngagement: j });
    }
    time += march.time;
    out.events.push(...march.events.map((e) => ({ ...e, engagement: j, time: started + e.time })));
    out.runs.push(...march.runs.map((run) =>
      Object.assign(run, { engagement: j, start: started + run.since })));
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
