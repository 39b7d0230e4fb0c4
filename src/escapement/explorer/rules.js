/** The rules for the numbers of a design. */

import { data, shown } from "./dom.js";
import { mostPins, pose, wheelOf } from "./law.js";

/** The numbers of a design and their rules, as `fields.py` has them; none where a motion is played. */
export const NUMBERS = data.fields ?? {};
/** What a number is where it is not given. */
export const otherwise = (name) => NUMBERS[name].default ?? (NUMBERS[name].truth ? false : null);

const refuse = (name, rule, value, remedy) => {
  throw new RangeError(`${name} must be ${rule}, got ${value}; ${remedy}`);
};
/** A number of a design in the units in use. */
const told = (name, value) => shown(value, NUMBERS[name].unit);

/** A number of a design that keeps the rule of its own; another one gives a RangeError. */
function checkNumber(name, value) {
  const { truth, whole, above, least, most, optional } = NUMBERS[name];
  if (value === null && optional) return;
  if (truth) {
    if (typeof value !== "boolean") refuse(name, "true or false", value, "choose one of them");
    return;
  }
  if (typeof value !== "number" || !Number.isFinite(value)) {
    refuse(name, "a finite number", value, "give a number");
  }
  if (whole && !Number.isInteger(value)) refuse(name, "a whole number", value, "round it");
  if (above && !(value > least)) refuse(name, `greater than ${least}`, told(name, value), "give its size");
  if (value < least) refuse(name, `${told(name, least)} or more`, told(name, value), "choose a greater value");
  if (value > most) refuse(name, `at most ${told(name, most)}`, told(name, value), "choose a smaller value");
}

/** A design with its defaults filled in; a number that breaks its rule gives a RangeError. */
export function checkDesign(given) {
  for (const name of Object.keys(given)) {
    if (!(name in NUMBERS)) refuse(name, "a known name", name, "leave it out");
  }
  const design = {};
  for (const name of Object.keys(NUMBERS)) {
    design[name] = given[name] ?? otherwise(name);
    checkNumber(name, design[name]);
  }
  const { slots, internal } = design;
  const most = mostPins(slots, internal);
  design.pins ??= !internal && (2 * slots) % (slots - 2) === 0 ? most : 1;
  if (design.pins > most) {
    refuse("pins", `at most ${most} with ${slots} slots`, design.pins, "choose fewer pins");
  }
  for (const [name, { needs }] of Object.entries(NUMBERS)) {
    if (needs && design[name] > 0 && !(given[needs] > 0)) {
      refuse(name, "0 without a crank radius", told(name, design[name]), "give the crank radius too");
    }
  }
  const wheel = wheelOf(design);
  const widest = design.crank_radius * Math.sin(Math.PI / slots)
    * Math.min(pose(wheel, 0).R, pose(wheel, wheel.exit).R);
  if (design.pin_radius > 0 && !(design.pin_radius < widest)) {
    refuse("pin_radius", `less than ${told("pin_radius", widest)}, where neighbouring slots meet`,
      told("pin_radius", design.pin_radius), "choose a thinner pin");
  }
  return design;
}
