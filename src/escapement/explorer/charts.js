/** The four plots of a motion. */

import { origin } from "./dom.js";

/** Times and rows of the columns that are shown. */
function windowShown(motion, columns, choice) {
  const { handoff_times: ends, end_time } = motion;
  const last = ends.length;
  const rows = columns.t.length;
  const row = (engagement) => {
    const index = columns.engagement.indexOf(engagement);
    return index < 0 ? rows : index;
  };
  if (choice === "first" && last > 3) return { low: 0, high: ends[2], from: 0, to: row(3) };
  if (choice === "last" && last > 2) {
    return { low: ends[last - 3], high: ends[last - 1], from: row(last - 2), to: row(last) };
  }
  return { low: 0, high: end_time, from: 0, to: rows };
}

/** Zero, the least and the greatest of some values, with a little room. */
function bounds(values, from, to) {
  let [low, high] = [0, 0];
  for (let i = from; i < to; i++) {
    if (values[i] < low) low = values[i];
    if (values[i] > high) high = values[i];
  }
  const room = 0.05 * (high - low || 1);
  return [low < 0 ? low - room : low, high + room];
}

/**
 * Draw velocities, contact moment, phase portrait and handoff map.
 *
 * choice : which engagements are shown, "all", "first" or "last".
 * torque : name and size of the unit of torque.
 * kept : columns of the design that this one is compared with, if any.
 */
export function drawCharts(plots, motion, columns, choice, torque, kept = null) {
  const { t, angle, theta_dot, phi_dot, contact_moment } = columns;
  const { low, high, from, to } = windowShown(motion, columns, choice);
  const ky = 1 / torque.factor;
  const some = { from, to };
  const lifted = (angles) => (i) => i > 0 && angles[i] < angles[i - 1] - 0.01;
  const { velocity, moment: force, phase, map } = plots;
  velocity.axes([low, high], bounds(theta_dot, from, to), "time [s]", "velocity [rad/s]");
  force.axes([low, high], bounds(contact_moment, from, to).map((value) => ky * value), "time [s]", `moment [${torque.name}]`);
  const { cell, entry: start } = motion;
  const kx = 180 / Math.PI;
  phase.axes([(start * 180) / Math.PI, ((start + cell) * 180) / Math.PI], bounds(theta_dot, 0, t.length),
    `driver angle ${origin(motion)} [°]`, "velocity [rad/s]");
  if (kept) {
    // the part of a long motion that lies beyond the axes is cut off
    velocity.line(kept.t, kept.theta_dot, { colour: "muted", dash: [2, 3] });
    phase.line(kept.angle, kept.theta_dot, { colour: "muted", dash: [2, 3], kx, lifts: lifted(kept.angle) });
  }
  if (t.length) {
    velocity.line(t, theta_dot, { colour: "driver", width: 2, ...some });
    velocity.line(t, phi_dot, { colour: "follower", dash: [6, 3], ...some });
    force.fill(t, contact_moment, { colour: "front", sign: 1, ky, ...some });
    force.fill(t, contact_moment, { colour: "rear", sign: -1, ky, ...some });
    force.line(t, contact_moment, { colour: "line", width: 1, ky, ...some });
    phase.line(angle, theta_dot, { colour: "driver", kx, lifts: lifted(angle) });
  }
  drawMap(map, motion);
}

function drawMap(map, motion) {
  const speeds = [motion.initial_speed, ...motion.handoff_velocities];
  const most = 1.15 * Math.max(...speeds, 1e-9);
  map.axes([0, most], [0, most], "velocity at this handoff [rad/s]", "at the next [rad/s]");
  if (!map.seen || (!motion.next && !motion.handoff_times.length)) return;
  map.line([0, most], [0, most], { colour: "muted", width: 1, dash: [3, 3] });
  if (motion.next) {
    const grid = Array.from({ length: 17 }, (_, i) => (most * i) / 16);
    const next = motion.next(grid);
    map.line(grid, next, { colour: "driver", width: 2, lifts: (i) => Number.isNaN(next[i]) || Number.isNaN(next[i - 1]) });
  }
  const steps = speeds.slice(0, -1).flatMap((v, i) => [[v, v], [v, speeds[i + 1]]]);
  map.line(steps.map(([x]) => x), steps.map(([, y]) => y), { colour: "follower", width: 1 });
  if (motion.figures.status === "ok") {
    map.within((pen) => {
      pen.fillStyle = map.colour("follower");
      const v = motion.figures.handoff_velocity;
      pen.fillRect(map.x(v) - 4, map.y(v) - 4, 8, 8);
    });
  }
}
