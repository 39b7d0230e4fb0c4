/** The table of figures of a motion, beside those of the kept design. */

import { byId, data, digits, element, shown, signed } from "./dom.js";

const REASONS = {
  painleve: "At or above the Painlevé limit no rigid motion exists: the pin jams in its slot.",
  stall: "The drive cannot carry the load and the mechanism stops.",
  spent: "The spring is spent and nothing moves any more.",
  no_terminal: "No terminal velocity exists: no loss grows with the speed.",
  not_converged: "The search for the terminal cycle did not converge, so no figures are shown.",
};

/** Show the figures of a motion beside those that were kept, and its margin to jamming. */
export function report(motion, kept) {
  const { figures } = motion;
  const rows = Object.entries(data.figures).map(([name, { label, unit }]) => {
    const [now, before] = [figures[name], kept?.[name]];
    const has = (value) => value !== undefined && value !== null && !Number.isNaN(value);
    const told = (value) => (!has(value) ? "–" : value === Infinity ? "none" : shown(value, unit));
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
  const share = showMargin(motion);
  const brief = [rows[0][1], rows[5][1], Number.isFinite(share) ? `${digits(100 * share, 3)}\u00a0%` : "–"];
  byId("brief").querySelectorAll("dd").forEach((told, i) => {
    told.textContent = brief[i];
  });
  const outcomes = [motion.status, figures.status].filter((status) => status !== "ok");
  byId("outcome").textContent = [...new Set(outcomes.map((status) => REASONS[status]))].join(" ");
  byId("forget").disabled = !kept;
  byId("figures").className = kept ? "" : "alone";
}

/** Show how near friction is to its limit, and return its share of it. */
function showMargin(motion) {
  const { figures, design } = motion;
  const share = design.friction / figures.critical_friction;
  byId("gauge").style.width = `${Math.min(100 * (share || 0), 100)}%`;
  byId("gauge").className = share >= 1 ? "over" : "";
  const where = Number.isFinite(figures.critical_angle) ? ` The pin ${share >= 1 ? "jams" : "would jam"} at `
    + `${signed(figures.critical_angle)} from dead centre, on the rear wall, which holds the follower back.` : "";
  const beside = figures.uniqueness_friction;
  const unique = motion.status !== "painleve" && !motion.unique
    ? ` At friction ${digits(beside)} and above, a second motion is possible: an impact could jam the pin.` : "";
  const spring = design.spring_rate > 0 && figures.status === "ok" ? " The figures are those with the full torque of the spring." : "";
  byId("margin").textContent = Number.isFinite(figures.critical_friction)
    ? `Friction is ${digits(100 * share, 3)} % of the Painlevé limit ${digits(figures.critical_friction)}.${where}${unique}${spring}`
    : (motion.touching ? "" : motion.meshed ? "Gears have no Painlevé limit." : "This pin cannot jam at any friction.") + spring;
  return share;
}
