/** The table of figures of a motion, beside those of the kept design. */

import { byId, data, digits, element } from "./dom.js";

const REASONS = {
  painleve: "At or above the Painlevé limit no rigid motion exists: the pin jams in its slot.",
  stall: "The drive cannot carry the load and the mechanism stops.",
  spent: "The spring is spent and nothing moves any more.",
  no_terminal: "No terminal velocity exists: no loss grows with the speed.",
  not_converged: "The search for the terminal cycle did not converge, so no figures are shown.",
};

/** Show the figures of a motion beside those that were kept, and its margin to jamming. */
export function report(motion, kept, shown) {
  const { figures, design } = motion;
  const rows = Object.entries(data.figures).map(([name, { label, unit }]) => {
    const [now, before] = [figures[name], kept?.[name]];
    const has = (value) => value !== undefined && value !== null && !Number.isNaN(value);
    const told = (value) => {
      if (has(value)) return value === Infinity ? "none" : shown(value, unit);
      return name === "contact_force_max" && design.slots && !design.crank_radius ? "needs the crank radius" : "–";
    };
    const gain = has(now) && has(before) && before !== 0 ? 100 * (now / before - 1) : NaN;
    const change_ = Number.isFinite(gain) ? `${gain > 0 ? "+" : ""}${gain.toFixed(2)}\u00a0%` : "–";
    return [label, told(now), kept ? told(before) : "–", kept ? change_ : "–"];
  });
  const body = byId("figures").tBodies[0];
  rows.forEach((row, i) => {
    const line = body.rows[i] ?? body.insertRow();
    row.forEach((text, j) => {
      const cell = line.cells[j]
        ?? line.appendChild(element(j ? "td" : "th", j ? {} : { scope: "row" }));
      if (cell.textContent !== text) cell.textContent = text;
    });
  });
  showMargin(motion);
  const outcomes = [motion.status, figures.status].filter((status) => status !== "ok");
  byId("outcome").textContent = [...new Set(outcomes.map((status) => REASONS[status]))].join(" ")
    + (design.spring_rate > 0 && figures.status === "ok" ? " The figures are those with the full torque of the spring." : "");
  byId("forget").disabled = !kept;
  byId("figures").className = kept ? "" : "alone";
}

function showMargin(motion) {
  const { figures, design } = motion;
  const share = design.friction / figures.critical_friction;
  byId("gauge").style.width = `${Math.min(100 * (share || 0), 100)}%`;
  byId("gauge").className = share >= 1 ? "over" : "";
  const where = Number.isFinite(figures.critical_angle)
    ? ` It jams first ${digits((figures.critical_angle * 180) / Math.PI, 4)}° from dead centre, marked in the picture.` : "";
  const beside = figures.uniqueness_friction;
  const unique = motion.status !== "painleve" && !motion.unique
    ? ` At friction ${digits(beside)} and above, a second motion is possible: an impact could jam the pin.` : "";
  byId("margin").textContent = Number.isFinite(figures.critical_friction)
    ? `Friction is ${digits(100 * share, 3)} % of the Painlevé limit ${digits(figures.critical_friction)}.${where}${unique}`
    : motion.meshed ? "Gears have no Painlevé limit." : "This pin cannot jam at any friction.";
}
