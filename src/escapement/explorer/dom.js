/** What the parts of the page share: its data and elements, and numbers as it writes them. */

export const byId = (id) => document.getElementById(id);

/** What Python wrote into the page: `fields.py` describes the table of numbers and units. */
export const data = JSON.parse(byId("data").textContent);

export const digits = (value, count = 5) =>
  Number.isFinite(value) ? String(Number(value.toPrecision(count))) : "–";

/** The units in use, those of one of the systems. */
export const units = { system: data.units };

export const unitOf = (kind) => data.systems[units.system][kind];

export const shown = (value, kind) => {
  const { factor, name } = unitOf(kind);
  return `${digits(value / factor)} ${name}`.trim().replaceAll(" ", "\u00a0");
};

/** An angle [rad] in degrees, with its sign. */
export const signed = (angle) => `${angle > 0 ? "+" : ""}${digits((angle * 180) / Math.PI, 4)}°`;

/** From where the driver angles of a motion are counted. */
export const origin = ({ touching }) => (touching ? "in its pitch" : "from dead centre");

export function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}
