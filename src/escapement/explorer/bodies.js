/**
 * Bodies of a Geneva drive in crank radii, as `escapement.outlines.geneva` lays them out.
 *
 * The follower's axis is the origin, the driver's lies on the positive x axis, and so does slot 0
 * when the follower angle is zero. Points are pairs [x, y]; y points upwards.
 */

import { followerAngle } from "./law.js";

const polar = (radius, angle) => [radius * Math.cos(angle), radius * Math.sin(angle)];
const turned = ([x, y], angle) => [
  x * Math.cos(angle) - y * Math.sin(angle), x * Math.sin(angle) + y * Math.cos(angle),
];
const spread = (low, high, count) =>
  Array.from({ length: count }, (_, i) => low + ((high - low) * i) / (count - 1));
const arc = (radius, start, stop, count) => spread(start, stop, count).map((a) => polar(radius, a));

/** Proportions of a drive; `pin` is the pin's radius, 0 if none was given. */
export function proportionsOf(wheel, pin) {
  const { sigma, centre, slots, dwell, step } = wheel;
  const internal = sigma > 0;
  const slotEnd = centre + sigma;
  const chosen = internal ? 0.08 : Math.min(0.08, 0.4 * slotEnd);
  const halfSlot = pin || 1.08 * chosen;
  const rim = Math.hypot(centre * Math.cos(Math.PI / slots), halfSlot);
  const wall = 1 - halfSlot;
  const lock = wall - Math.min(0.1, 0.5 * wall);
  return {
    wheel, sigma, centre, slots, step, slotEnd, halfSlot, rim, lock, internal, pin: pin || chosen,
    locks: dwell > 0 && lock - Math.abs(centre - rim) > 0,
    gap: Math.min(0.02, 0.2 * Math.abs(centre - rim)),
    reach: internal ? slotEnd + halfSlot + 0.18 : rim, crankDisc: 1 + (pin || chosen) + 0.07,
    driverShaft: internal ? 0.12 : Math.min(0.14, 0.5 * (centre - rim)),
    followerShaft: internal ? 0 : Math.min(0.12, 0.5 * (slotEnd - halfSlot)),
  };
}

/** Points of the rim between slot 0 and slot 1. */
function landOf({ step, rim, halfSlot, locks, lock, centre, sigma }) {
  const middle = step / 2;
  const corner = Math.asin(halfSlot / rim);
  if (!locks) return arc(rim, corner, step - corner, 21).slice(1, -1);
  const horn = Math.acos((rim ** 2 + centre ** 2 - lock ** 2) / (2 * rim * centre));
  const [x, y] = polar(rim, horn);
  const wide = sigma * Math.abs(Math.atan2(sigma * y, sigma * (x - centre)));
  const hollow = arc(sigma * lock, -wide, wide, 31).map(([a, b]) => turned([a + centre, b], middle));
  return [
    ...arc(rim, corner, middle - horn, 5).slice(1), ...hollow.slice(1, -1),
    ...arc(rim, middle + horn, step - corner, 5).slice(0, -1),
  ];
}

/** Edge of the follower that faces the driver. */
export function followerEdge(shape) {
  const { rim, halfSlot, slotEnd, slots, step } = shape;
  const corner = Math.asin(halfSlot / rim);
  const away = Math.sign(slotEnd - rim);
  const end = spread(-0.5 * Math.PI, 0.5 * Math.PI, 13).map((a) =>
    [slotEnd + halfSlot * away * Math.cos(a), halfSlot * Math.sin(a)]);
  const sector = [polar(rim, -corner), ...end, polar(rim, corner), ...landOf(shape)];
  return Array.from({ length: slots }, (_, k) => sector.map((p) => turned(p, k * step))).flat();
}

/** Lower bound of the distance of a point in the follower's plane from its body. */
function clearance({ step, slotEnd, internal, halfSlot, sigma, rim, locks, lock, centre }, [x, y]) {
  const [u, v] = turned([x, y], -step * Math.round(Math.atan2(y, x) / step));
  const nearest = internal ? Math.min(u, slotEnd) : Math.max(u, slotEnd);
  const slot = halfSlot - Math.hypot(u - nearest, v);
  let outside = Math.max(slot, -sigma * (Math.hypot(u, v) - rim));
  if (locks) {
    const [a, b] = polar(centre, step / 2);
    outside = Math.max(outside, lock - Math.hypot(u - a, Math.abs(v) - b));
  }
  return outside;
}

const RAYS = 90; // from the pin to the far side, on either half
const POSITIONS = 121;

/**
 * Edge of the driver's locking disc about its axis, pin 0 at dead centre; empty if it has no disc.
 * Each ray is followed until the turning wheel, in any position, comes within the gap.
 */
export function lockingDisc(shape) {
  const { wheel, sigma, centre, gap, lock, internal } = shape;
  if (!shape.locks) return [];
  const edge = lock - 1.2 * gap;
  const positions = spread(-wheel.exit, wheel.exit, POSITIONS).map((theta) => {
    const phi = followerAngle(wheel, theta);
    return { turn: sigma * theta - phi, axis: polar(centre, -phi) };
  });
  const half = spread(0, Math.PI, RAYS + 1).map((angle) => {
    let radius = internal ? edge : 0;
    for (let i = 0; i < 40; i++) {
      const free = Math.min(...positions.map(({ turn, axis }) => {
        const [x, y] = polar(sigma * radius, angle + turn);
        return clearance(shape, [axis[0] + x, axis[1] + y]);
      })) - gap;
      const before = radius;
      radius = Math.min(Math.max(radius - sigma * free, 0), edge);
      if (Math.abs(radius - before) < 1e-4) break;
    }
    return radius;
  });
  const radius = [...half, ...half.slice(1, -1).reverse()];
  const count = radius.length;
  const ray = (i, r) => polar(sigma * r, (2 * Math.PI * i) / count);
  if (internal) {
    const solid = radius.map((r, i) => i).filter((i) => radius[i] < edge - 1e-6);
    if (!solid.length) return [];
    return [...solid.map((i) => ray(i, edge)), ...solid.reverse().map((i) => ray(i, radius[i]))];
  }
  return radius.map((_, i) => {
    const hollows = Array.from({ length: wheel.pins }, (_, k) =>
      radius[(((i - Math.round((k * count) / wheel.pins)) % count) + count) % count]);
    return ray(i, Math.min(...hollows));
  });
}

const circle = (r, x = 0) => `M${x + r} 0A${r} ${r} 0 1 0 ${x - r} 0A${r} ${r} 0 1 0 ${x + r} 0Z`;
const pathOf = (edge) =>
  edge.length ? `M${edge.map(([x, y]) => `${x.toFixed(4)} ${y.toFixed(4)}`).join("L")}Z` : "";

/**
 * The bodies of a wheel whose pins have the radius r_p, 0 if none was given, in the form that
 * `bodies.py` describes.
 */
export function bodiesOf(wheel) {
  const shape = proportionsOf(wheel, wheel.r_p);
  const { sigma, centre, reach, crankDisc, internal, slotEnd, halfSlot } = shape;
  const axis = [[centre, 0, 0]];
  const [still, driver, follower] = [[0, 0], [sigma, 0], [0, 1]];
  const body = (name, path, at = [], turn = still) => ({ name, path, at, turn });
  const mark = internal ? slotEnd + halfSlot + 0.09 : 0.78 * (slotEnd - halfSlot);
  const bodies = [
    body("crank-disc", circle(crankDisc), axis),
    body("follower", pathOf(followerEdge(shape)) + (internal ? circle(reach) : ""), [], follower),
    // slot 0 has a mark, which makes the wheel's turning visible
    body("mark", circle(Math.min(0.045, 0.25 * mark), mark), [], follower),
    ...(internal ? [] : [body("shaft", circle(shape.followerShaft))]),
    body("hidden", circle(crankDisc), axis),
    ...(shape.locks ? [body("locking-disc", "", axis, driver)] : []),
    body("shaft", circle(shape.driverShaft), axis),
    body("arm", `M0 0L${sigma} 0`, axis, driver),
  ];
  for (let k = 0; k < wheel.pins; k++) {
    const [x, y] = polar(sigma, -sigma * k * wheel.cell);
    bodies.push(body(`pin-${k}`, circle(shape.pin), [...axis, [x, y, sigma]]));
  }
  const half = Math.max(reach, crankDisc);
  return {
    bodies, contact: [...axis, [sigma, 0, sigma]], box: [-reach, Math.max(reach, centre + crankDisc), -half, half],
    later: shape.locks ? (show) => show(["locking-disc", pathOf(lockingDisc(shape))]) : null,
  };
}
