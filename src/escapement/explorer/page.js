/** The page: fields, figures, plots and playback, all drawn from one motion at one time. */

import { eventsOf, samples, simulate, stateAt } from "./kernel.js";
import { frictionLimits, mostPins } from "./law.js";
import { NUMBERS, checkDesign } from "./rules.js";
import { drawCharts } from "./charts.js";
import { byId, digits, element } from "./dom.js";
import { asFragment, asToml, fromFragment, fromToml, short } from "./design.js";
import { Picture } from "./picture.js";
import { Plot } from "./plots.js";
import { report } from "./report.js";

const { design: given, fields, systems, stops } = JSON.parse(byId("data").textContent);
const GROUPS = {
  "Mechanism": ["slots", "pins", "internal", "crank_radius", "pin_radius"],
  "Drive, inertia and load": ["torque", "spring_rate", "driver_inertia", "follower_inertia",
    "load_torque", "initial_speed", "engagements"],
  "Friction": ["friction", "driver_bearing_friction", "driver_bearing_radius",
    "follower_bearing_friction", "follower_bearing_radius", "driver_bearing_torque"],
  "Air": ["driver_drag", "follower_drag"],
};
const WHOLE = ["slots", "pins", "engagements"];
const WIDE = ["torque", "driver_inertia", "follower_inertia", "crank_radius"];
let design = checkDesign(given);
let motion = null;
let columns = null;
let events = [];
let kept = null;
let time = 0;
let playing = false;
let units = "SI";
const picture = new Picture(byId("picture"));
const plots = Object.fromEntries(["velocity", "moment", "phase", "map"].map((id) => [id, new Plot(byId(id))]));

const kindOf = (name) => fields[name]?.unit ?? "ratio";
const factor = (kind) => systems[units][kind].factor;
const unit = (kind) => systems[units][kind].name;
const shown = (value, kind) => `${digits(value / factor(kind))} ${unit(kind).replaceAll(" ", "\u00a0")}`.trim();

/** Least and greatest value of a slider. */
function rangeOf(name) {
  const limits = { slots: [3, 12], pins: [1, mostPins(design.slots, design.internal)],
    engagements: [1, 60], driver_bearing_friction: [0, 0.4], follower_bearing_friction: [0, 0.4],
    initial_speed: [0, 500] };
  if (name in limits) return limits[name];
  const crank = design.crank_radius ?? 0;
  const critical = motion?.figures.critical_friction ?? 1;
  const most = { friction: Number.isFinite(critical) ? 1.05 * critical : 1,
    load_torque: 0.6 * design.torque, spring_rate: 0.05 * design.torque,
    driver_bearing_torque: 0.5 * design.torque, driver_drag: 0.1 * design.follower_inertia,
    follower_drag: 0.1 * design.follower_inertia, pin_radius: 0.15 * crank,
    driver_bearing_radius: 0.2 * crank, follower_bearing_radius: 0.2 * crank };
  return [0, most[name]];
}

// a slider of a number without an upper end runs over four decades about where it was taken up
const centres = {};
const toSlider = (name, value) => {
  if (WIDE.includes(name)) return 0.5 + Math.log10(value / (centres[name] ??= value)) / 4;
  const [low, high] = rangeOf(name);
  return high > low ? (value - low) / (high - low) : 0;
};
const fromSlider = (name, share) => {
  if (WIDE.includes(name)) return Number((centres[name] * 10 ** (4 * (share - 0.5))).toPrecision(4));
  const [low, high] = rangeOf(name);
  const value = low + share * (high - low);
  return WHOLE.includes(name) ? Math.round(value) : Number(value.toPrecision(4));
};

const inputs = {};

function makeFields() {
  for (const [title, names] of Object.entries(GROUPS)) {
    const group = element("fieldset", {}, element("legend", { textContent: title }));
    for (const name of names) group.append(name === "internal" ? makeCheck() : makeField(name));
    byId("fields").append(group);
  }
  byId("fields").addEventListener("submit", (event) => event.preventDefault());
  for (const name of Object.keys(systems)) byId("units").append(element("option", { value: name, textContent: name }));
  byId("units").addEventListener("change", (event) => {
    units = event.target.value;
    refresh();
  });
}

function makeCheck() {
  const box = element("input", { type: "checkbox", id: "internal" });
  box.addEventListener("change", () => change({ internal: box.checked, pins: null }));
  inputs.internal = { box };
  return element("div", { className: "check" }, box,
    element("label", { htmlFor: "internal", textContent: fields.internal.label }));
}

function makeField(name) {
  const label = fields[name].label;
  const slider = element("input", { type: "range", min: 0, max: 1, step: "any" });
  slider.setAttribute("aria-label", `${label}, slider`);
  const text = element("input", { type: "text", inputMode: "decimal", id: name, name });
  const after = element("span", { className: "unit" });
  const of = (value) => ({ [name]: value, ...(name === "slots" ? { pins: null } : {}) });
  slider.addEventListener("input", () => {
    if (WIDE.includes(name) && design[name] === null) return;
    const value = fromSlider(name, Number(slider.value));
    change(of(value), name);
  });
  text.addEventListener("input", () => {
    const typed = text.value.trim();
    const empty = typed === "" && ["crank_radius", "pins"].includes(name);
    const value = empty ? null : Number(typed === "" ? NaN : typed) * factor(kindOf(name));
    if (value !== null && !Number.isFinite(value)) {
      complain(`${label} must be a number, got '${typed.slice(0, 40)}'; the last good design stays`);
      text.setAttribute("aria-invalid", "true");
      return;
    }
    change(of(value), name);
  });
  text.addEventListener("blur", () => refresh());
  inputs[name] = { slider, text, after };
  return element("div", { className: "field" },
    element("label", { htmlFor: name, textContent: label }), slider, text, after);
}

const complain = (line) => {
  byId("problem").textContent = line;
};

/** Show the design in all fields but the one that has the focus. */
function refresh(active = null) {
  for (const [name, { slider, text, after, box }] of Object.entries(inputs)) {
    const value = design[name];
    if (box) {
      box.checked = value;
      continue;
    }
    const kind = kindOf(name);
    const busy = document.activeElement;
    if (busy !== text || active !== name) {
      text.value = value === null ? "" : short(value / factor(kind));
      text.removeAttribute("aria-invalid");
    } else if (text.getAttribute("aria-invalid")) text.removeAttribute("aria-invalid");
    const needs = ["pin_radius", "driver_bearing_radius", "follower_bearing_radius"].includes(name);
    const lacks = (needs && design.crank_radius === null) || (name === "crank_radius" && value === null);
    slider.disabled = lacks;
    after.textContent = needs && lacks ? "needs crank" : unit(kind);
    const share = value === null ? 0 : toSlider(name, value);
    if (busy !== slider || active !== name) slider.value = share;
    slider.setAttribute("aria-valuetext", value === null ? "none" : shown(value, kind));
  }
  const toml = byId("toml");
  if (document.activeElement !== toml) toml.value = asToml(design);
  report(motion, kept, shown);
  draw();
  setTime(time);
}

/** Take some numbers into the design; a design that breaks a rule leaves the last good one. */
function change(numbers, active = null) {
  try {
    take(checkDesign({ ...design, ...numbers }), active);
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
    complain(error.message);
    if (active && inputs[active]?.text) inputs[active].text.setAttribute("aria-invalid", "true");
  }
}

function take(next, active = null) {
  const found = simulate(next);
  design = found.design;
  motion = found;
  columns = samples(motion);
  events = eventsOf(motion);
  time = Math.min(time, motion.end_time);
  complain("");
  picture.layOut(motion);
  const fragment = `#${asFragment(design)}`;
  clearTimeout(take.later);
  // browsers bound how often an address may change
  take.later = setTimeout(() => {
    if (location.hash !== fragment) history.replaceState(null, "", fragment);
  }, 250);
  byId("scrub").max = motion.end_time || 1;
  refresh(active);
}

function draw() {
  if (!plots.velocity.width) return;
  drawCharts(plots, motion, columns, byId("shown").value, systems[units].torque);
}

/** Show the motion at a time [s]; all that moves is driven by this function. */
export function setTime(t) {
  time = Math.min(Math.max(t, 0), motion.end_time);
  byId("scrub").value = time;
  const state = stateAt(motion, time);
  if (!state) {
    byId("now").textContent = "There is no motion to show.";
    picture.turn({ theta: 0, angle: 0, side: 0, contact_moment: 0 }, 0);
    for (const plot of Object.values(plots)) if (plot.width) plot.head(NaN);
    return;
  }
  picture.turn(state, motion.figures.contact_moment_max ?? greatestMoment());
  const wall = { 1: "the pin presses on the front wall", "-1": "the pin presses on the rear wall", 0: "the follower is locked" };
  const degrees = digits((state.angle * 180) / Math.PI, 4);
  const told = `${time.toFixed(5)} s, engagement ${state.engagement + 1}, ${degrees}° from dead centre: `
    + `driver ${digits(state.theta_dot, 4)} rad/s, follower ${digits(state.phi_dot, 4)} rad/s; ${wall[state.side]}`
    + (state.side ? ` with ${shown(Math.abs(state.contact_moment), "torque")} about the follower's axis.` : ".");
  byId("now").textContent = told;
  byId("scrub").setAttribute("aria-valuetext", told);
  if (!plots.velocity.width) return;
  plots.velocity.head(time);
  plots.moment.head(time);
  plots.phase.head((state.angle * 180) / Math.PI, state.theta_dot);
  const ends = [design.initial_speed, ...motion.handoff_velocities];
  plots.map.head(ends[state.engagement], ends[state.engagement + 1] ?? NaN);
}

const greatestMoment = () => columns.contact_moment.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

function stepTo(direction) {
  play(false);
  const tiny = 1e-9 * motion.end_time;
  const ahead = direction > 0 ? events.find((event) => event.time > time + tiny)
    : events.findLast((event) => event.time < time - tiny);
  setTime(ahead ? ahead.time : direction > 0 ? motion.end_time : 0);
  if (ahead) byId("now").textContent = `${ahead.kind[0].toUpperCase()}${ahead.kind.slice(1)}: ${byId("now").textContent}`;
}

/** Seconds of the motion in a second of the reader. */
function rate() {
  const choice = byId("speed").value;
  if (!["auto", "slow"].includes(choice)) return Number(choice);
  const one = motion.figures.period || motion.end_time / Math.max(motion.handoff_times.length, 1);
  return one / (choice === "slow" ? 12 : 4);
}

function play(on) {
  playing = on && motion.end_time > 0;
  byId("play").setAttribute("aria-pressed", String(playing));
  byId("play").textContent = playing ? "Pause" : "Play";
  if (!playing) return;
  if (time >= motion.end_time) time = 0;
  let last = null;
  const frame = (now) => {
    if (!playing) return;
    if (last !== null) setTime(time + (rate() * Math.min(now - last, 100)) / 1000);
    last = now;
    if (time >= motion.end_time) play(false);
    else requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

function showStop(index) {
  const { title, text, designs, claims, shown: range } = stops[index];
  [...byId("stops").children].forEach((button, i) => {
    button.setAttribute("aria-current", String(i === index));
  });
  const buttons = designs.map(({ label, design: numbers }) => {
    const button = element("button", { type: "button", textContent: label });
    button.addEventListener("click", () => {
      byId("shown").value = range;
      play(false);
      time = 0;
      for (const name of Object.keys(centres)) delete centres[name];
      take(checkDesign(numbers));
    });
    return button;
  });
  const list = claims.map(({ text: claim, test }) =>
    element("li", {}, claim, element("code", { textContent: `proved by ${test}` })));
  byId("stop").replaceChildren(element("h3", { textContent: title }), element("p", { textContent: text }),
    element("div", { className: "row" }, ...buttons), element("ul", { className: "claims" }, ...list));
}

function save(name, text, type) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

function readAddress() {
  if (location.hash.length < 2) return;
  try {
    take(fromFragment(decodeURIComponent(location.hash)));
  } catch (error) {
    const line = error instanceof URIError ? "the address holds a broken % sign; correct it" : error.message;
    complain(`${line}; the last good design stays`);
  }
}

function connect() {
  byId("play").addEventListener("click", () => play(!playing));
  byId("next").addEventListener("click", () => stepTo(1));
  byId("back").addEventListener("click", () => stepTo(-1));
  byId("scrub").addEventListener("input", (event) => {
    play(false);
    setTime(Number(event.target.value));
  });
  byId("shown").addEventListener("change", () => refresh());
  byId("keep").addEventListener("click", () => {
    kept = { ...motion.figures };
    report(motion, kept, shown);
  });
  byId("forget").addEventListener("click", () => {
    kept = null;
    report(motion, kept, shown);
  });
  byId("read").addEventListener("click", () => {
    try {
      take(fromToml(byId("toml").value, fields, systems));
    } catch (error) {
      if (!(error instanceof RangeError)) throw error;
      complain(`${error.message}; the last good design stays`);
    }
  });
  byId("save").addEventListener("click", () => save("design.toml", asToml(design), "application/toml"));
  byId("svg").addEventListener("click", () => save("mechanism.svg", picture.asText(), "image/svg+xml"));
  addEventListener("hashchange", readAddress);
  addEventListener("keydown", (event) => {
    if (event.target.matches("input[type=text], textarea, select") || event.ctrlKey || event.metaKey) return;
    if (event.key === " " && !event.target.matches("button, summary, input")) {
      event.preventDefault();
      play(!playing);
    } else if (event.key === ".") stepTo(1);
    else if (event.key === ",") stepTo(-1);
  });
  for (const plot of [plots.velocity, plots.moment]) {
    plot.onPoint((t) => {
      play(false);
      setTime(t);
    });
  }
  const measure = () => {
    Object.values(plots).forEach((plot) => plot.measure());
    draw();
    setTime(time);
  };
  new ResizeObserver(measure).observe(document.body);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", measure);
  stops.forEach(({ title }, i) => {
    const button = element("button", { type: "button", textContent: `${i + 1}. ${title}` });
    button.addEventListener("click", () => showStop(i));
    byId("stops").append(button);
  });
  for (const [id, words] of Object.entries({ velocity: "velocities over time", moment: "contact moment over time",
    phase: "driver velocity over its angle", map: "handoff map" })) {
    byId(id).querySelector("[role=img]").setAttribute("aria-label", `Plot of ${words}; the text above the sliders tells the values at the playhead`);
  }
}

makeFields();
connect();
take(design);
readAddress();
showStop(0);
window.explorer = { simulate, setTime,
  criticalFriction: (numbers) => frictionLimits(checkDesign(numbers)).critical, samples, stateAt, change, numbers: NUMBERS,
  get design() { return design; }, get motion() { return motion; }, get time() { return time; } };
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
