/** What the parts of the page share: its data and elements, and numbers as it writes them. */

export const byId = (id) => document.getElementById(id);

/** What Python wrote into the page: `fields.py` describes the table of numbers and units. */
export const data = JSON.parse(byId("data").textContent);

export const digits = (value, count = 5) =>
  Number.isFinite(value) ? String(Number(value.toPrecision(count))) : "–";

export function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}
