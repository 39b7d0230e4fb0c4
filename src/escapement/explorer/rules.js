/** The rules for the numbers of a design. */

import { mostPins, pose, wheelOf } from "./law.js";

/** The least and greatest value of each number, and its default. */
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

/** A design with its defaults filled in; a number that breaks its rule gives a RangeError. */
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
      refuse(name, "0 without a crank radius", design[name], "give the crank radius too");
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
