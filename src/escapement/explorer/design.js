/** A design as text: in the page's address, and as a study in TOML. */

import { data } from "./dom.js";
import { NUMBERS, checkDesign, otherwise } from "./rules.js";

/** A number with all its digits, in its shortest form. */
function exact(value) {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e6) ? value.toExponential() : String(value);
}

/** A number in its shortest form with at most ten digits. */
export const short = (value) => exact(Number(value.toPrecision(10)));

const isDefault = (name, value) => value === null || value === otherwise(name);

/** The design as the fragment of an address: all numbers that differ from their defaults. */
export const asFragment = (design) =>
  Object.entries(design)
    .filter(([name, value]) => ["slots", "pins", "crank_radius", "torque"].includes(name) || !isDefault(name, value))
    .map(([name, value]) => `${name}=${value}`).join("&");

const number = (name, text) => {
  const value = Number(text);
  if (text.trim() === "" || !Number.isFinite(value)) {
    const said = text.length > 40 ? `${text.slice(0, 40)}...` : text;
    throw new RangeError(`${name} must be a number, got '${said.replace(/\s+/g, " ")}'; give digits`);
  }
  return value;
};

function assign(design, name, text) {
  if (name in data.beyond) {
    throw new RangeError(`this page does not compute with ${name} (${data.beyond[name]}); use the Python package`);
  }
  if (!(name in NUMBERS)) {
    throw new RangeError(`'${name.slice(0, 40)}' is not the name of a number of a design; leave it out`);
  }
  if (!NUMBERS[name].truth) design[name] = number(name, text);
  else if (["true", "false"].includes(text)) design[name] = text === "true";
  else throw new RangeError(`${name} must be true or false, got '${text.slice(0, 40)}'; choose one`);
}

/** The design in a fragment; a fragment with a mistake gives a RangeError with one line. */
export function fromFragment(fragment) {
  const design = {};
  for (const part of fragment.replace(/^#/, "").split("&").filter(Boolean)) {
    const [name, value, more] = part.split("=");
    if (value === undefined || more !== undefined) {
      throw new RangeError(`the address must consist of name=value, got '${part.slice(0, 40)}'; correct it`);
    }
    assign(design, name, value);
  }
  return checkDesign(design);
}

/** The design as a study of one case, which `escapement sweep` and `escapement explore` read. */
export function asToml(design) {
  const ALWAYS = ["slots", "pins", "internal", "crank_radius", "torque", "driver_inertia", "follower_inertia"];
  // friction is the axis of the study, and the engagements belong to a motion only
  const lines = (section) => Object.entries(NUMBERS)
    .filter(([name, rule]) => rule.section === section && !["friction", "engagements"].includes(name)
      && (ALWAYS.includes(name) || !isDefault(name, design[name])))
    .map(([name, { key, truth }]) => `${key} = ${truth ? design[name] : exact(design[name])}`);
  return [
    'title = "a design of the explorer"', 'units = "SI"', ...lines(""),
    "", "[mechanism]", 'kind = "geneva"', ...lines("mechanism"), "", "[inertia]", ...lines("inertia"),
    "", "[sweep]", `friction = [${exact(design.friction)}]`, "",
  ].join("\n");
}

/** Name of a number by its table and its key there. */
const nameOf = (section, key) => Object.keys(NUMBERS).find((name) =>
  section === "inertia" && NUMBERS[name].section === section && NUMBERS[name].key === key) ?? key;

/**
 * The design of a study of one case. Numbers in other units than SI are taken with the factors of
 * that system, by the kind of unit of each name.
 */
export function fromToml(text) {
  const { systems } = data;
  let [section, units] = ["", "SI"];
  const found = [];
  for (const [i, raw] of text.split("\n").entries()) {
    const line = raw.replace(/#.*$/, "").trim();
    const where = `line ${i + 1}`;
    const header = line.match(/^\[([a-z]+)\]$/);
    const pair = line.match(/^([A-Za-z_]+)\s*=\s*(.+)$/);
    if (!line) continue;
    if (header && ["mechanism", "inertia", "sweep", "solver"].includes(header[1])) {
      [, section] = header;
    } else if (pair && !header) {
      const [, key, value] = pair;
      const plain = value.replace(/^\[\s*([^\],]+)\s*,?\s*\]$/, "$1").replace(/^(["'])(.*)\1$/, "$2");
      if (/[[{,]/.test(plain) && key !== "title") {
        throw new RangeError(`${where}: ${key} must be one number, got '${value.slice(0, 40)}'; `
          + "this page shows one design");
      }
      if (key === "title" || section === "solver") continue;
      if (key === "units") units = plain;
      else if (section === "mechanism" && key === "kind") {
        if (plain !== "geneva") {
          throw new RangeError(`${where}: this page computes Geneva wheels, got '${plain.slice(0, 40)}'; `
            + "use the package");
        }
      } else found.push([nameOf(section, key), plain]);
    } else {
      throw new RangeError(`${where} must be 'name = value' or '[section]', got `
        + `'${line.slice(0, 40)}'; correct it`);
    }
  }
  if (!(units in systems)) {
    throw new RangeError(`units must be ${Object.keys(systems).join(" or ")}, got '${units.slice(0, 40)}'; `
      + "choose one");
  }
  const design = {};
  for (const [name, value] of found) {
    assign(design, name, value);
    if (typeof design[name] === "number") design[name] *= systems[units][NUMBERS[name].unit].factor;
  }
  for (const name of ["torque", "driver_inertia", "follower_inertia"]) {
    if (!(name in design)) throw new RangeError(`the text must give ${name}, got none; add it`);
  }
  return checkDesign(design);
}
