/** The page: fields, figures, plots and playback, all drawn from one motion at one time. */

import { simulate, samples, stateAt } from "./kernel.js";
import { frictionLimits } from "./law.js";
import { NUMBERS, checkDesign } from "./rules.js";
import { drawCharts } from "./charts.js";
import { byId, data, digits, element, origin, shown, signed, unitOf, units } from "./dom.js";
import { asFragment, asToml, fromFragment, fromToml } from "./design.js";
import { Fields } from "./fields.js";
import { Picture } from "./picture.js";
import { Played } from "./played.js";
import { Plot } from "./plots.js";
import { report } from "./report.js";

const { systems, stops } = data;
let design = data.design && checkDesign(data.design);
let motion = null;
let columns = null;
let events = [];
let kept = null;
let time = 0;
let playing = false;
const picture = new Picture(byId("picture"));
const plots = Object.fromEntries(["velocity", "moment", "phase", "map"].map((id) => [id, new Plot(byId(id))]));
const fields = new Fields(byId("fields"), {
  change: (numbers, name) => change(numbers, name),
  complain: (line, name) => complain(line, fields.refuse(name)),
});

/** Show a mistake at its cause: at the end of a field, of the text, or of the page's head. */
function complain(line, cause = byId("top")) {
  byId("problem").textContent = line;
  if (line && byId("problem").parentElement !== cause) cause.append(byId("problem"));
}

/** Change some numbers of the design; if a number breaks a rule, the last good design stays. */
function change(numbers, active = null) {
  try {
    take(checkDesign({ ...design, ...numbers }), active);
  } catch (error) {
    if (!(error instanceof RangeError)) throw error;
    complain(error.message, active ? fields.refuse(active) : undefined);
  }
}

/** Compute a design in this page and show it. */
function take(next, active = null) {
  const found = simulate(next);
  show(found, found.design, active);
}

/** Show a motion and its design. */
function show(found, numbers, active = null) {
  motion = found;
  design = numbers;
  columns = motion.samples();
  events = motion.events();
  time = Math.min(time, motion.end_time);
  complain("");
  picture.layOut(motion);
  byId("scrub").max = motion.end_time || 1;
  clearTimeout(show.later);
  // browsers limit how often an address may change
  show.later = setTimeout(() => {
    if (!data.fields) return;
    const fragment = `#${asFragment(design)}`;
    // the frame of a notebook has no address; it receives a message
    if (parent !== window) parent.postMessage({ explorer: design }, "*");
    else if (location.hash !== fragment) history.replaceState(null, "", fragment);
  }, 250);
  refresh(active);
}

function writeText() {
  const toml = byId("toml");
  if (data.fields && document.activeElement !== toml) toml.value = asToml(design);
}

function refresh(active = null) {
  fields.refresh(design, motion.figures, active);
  // a long text takes time, so it waits for the end of a drag
  clearTimeout(writeText.later);
  if (active === null) writeText();
  else writeText.later = setTimeout(writeText, 250);
  report(motion, kept?.figures);
  draw();
}

function draw() {
  if (plots.velocity.width) {
    drawCharts(plots, motion, columns, byId("shown").value, unitOf("torque"), kept?.columns);
  }
  setTime(time);
}

/** Show the motion at a time [s]; all that moves is driven by this function. */
export function setTime(t) {
  time = Math.min(Math.max(t, 0), motion.end_time);
  byId("scrub").value = time;
  const state = motion.at(time);
  if (!state) {
    byId("now").textContent = "There is no motion to show.";
    picture.turn({ theta: 0, phi: 0, angle: 0, side: 0, contact_moment: 0 }, 0);
    for (const plot of Object.values(plots)) if (plot.width) plot.head(NaN);
    return;
  }
  picture.turn(state, motion.figures.contact_moment_max || greatestMoment());
  const told = saying(state);
  byId("now").textContent = told;
  byId("scrub").setAttribute("aria-valuetext", told);
  if (!plots.velocity.width) return;
  plots.velocity.head(time);
  plots.moment.head(time);
  plots.phase.head((state.angle * 180) / Math.PI, state.theta_dot);
  const ends = [motion.initial_speed, ...motion.handoff_velocities];
  plots.map.head(ends[state.engagement], ends[state.engagement + 1] ?? NaN);
}

/** A state in words. */
function saying({ engagement, angle, theta_dot, phi_dot, side, contact_moment }) {
  const nothing = { contact: "the pin touches no wall", two_bodies: "the bodies are apart" }[motion.engine]
    ?? "the follower is locked";
  const [front, rear] = motion.touching ? ["the driver pushes the follower forwards", "the driver pushes the follower backwards"]
    : motion.meshed ? ["the driver pushes the follower", "the driver holds the follower back"]
    : ["the pin presses on the front wall", "the pin presses on the rear wall"];
  const wall = { 1: front, "-1": rear, 0: nothing }[side];
  const moment = side ? ` with a moment of ${shown(Math.abs(contact_moment), "torque")}` : "";
  return `${time.toFixed(5)} s, engagement ${engagement + 1}, ${signed(angle)} ${origin(motion)}: `
    + `driver ${digits(theta_dot, 4)} rad/s, follower ${digits(phi_dot, 4)} rad/s; ${wall}${moment}.`;
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

/** Seconds of the motion that are shown in one second. */
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

const button = (textContent, onclick) => element("button", { type: "button", textContent, onclick });

function showStop(index) {
  const { title, text, designs, claims, shown: range } = stops[index];
  [...byId("stops").children].forEach((one, i) => one.setAttribute("aria-current", String(i === index)));
  const buttons = designs.map(({ label, design: numbers }) => button(label, () => {
    byId("shown").value = range;
    play(false);
    time = 0;
    fields.centres = {};
    take(checkDesign(numbers));
  }));
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

/** Take a design that `read` makes; if it has a mistake, the last good design stays. */
function takeRead(read, cause) {
  try {
    take(read());
  } catch (error) {
    if (!(error instanceof URIError || error instanceof RangeError)) throw error;
    const line = error instanceof URIError ? "the address has a % sign that is not followed by two hexadecimal digits; correct it" : error.message;
    complain(`${line}; the last good design stays`, cause);
  }
}

function readAddress() {
  if (location.hash.length > 1) takeRead(() => fromFragment(decodeURIComponent(location.hash)));
}

/** Connect the fields and buttons of a page whose design can be changed. */
function connectDesign() {
  fields.lay(data.groups);
  for (const name of Object.keys(systems)) byId("units").append(element("option", { value: name, textContent: name }));
  byId("units").value = units.system;
  byId("units").addEventListener("change", (event) => {
    units.system = event.target.value;
    refresh();
  });
  byId("keep").addEventListener("click", () => {
    kept = { figures: { ...motion.figures }, columns };
    refresh();
  });
  byId("forget").addEventListener("click", () => {
    kept = null;
    refresh();
  });
  byId("read").addEventListener("click", () => takeRead(() => fromToml(byId("toml").value), byId("text")));
  byId("save").addEventListener("click", () => save("design.toml", byId("toml").value, "application/toml"));
  addEventListener("hashchange", readAddress);
  addEventListener("message", (event) => {
    const told = event.source === parent && parent !== window ? event.data?.explorer : null;
    if (told && Object.keys(told).some((name) => told[name] !== design[name])) change(told);
  });
  stops.forEach(({ title }, i) => {
    byId("stops").append(button(`${i + 1}. ${title}`, () => showStop(i)));
  });
  if (stops.length) showStop(0);
}

function connect() {
  byId("play").addEventListener("click", () => play(!playing));
  byId("next").addEventListener("click", () => stepTo(1));
  byId("back").addEventListener("click", () => stepTo(-1));
  byId("scrub").addEventListener("input", (event) => {
    play(false);
    setTime(Number(event.target.value));
  });
  byId("shown").addEventListener("change", draw);
  byId("svg").addEventListener("click", () => save("mechanism.svg", picture.asText(), "image/svg+xml"));
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
    picture.measure();
    Object.values(plots).forEach((plot) => plot.measure());
    draw();
  };
  new ResizeObserver(measure).observe(document.body);
  const watch = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) plots[target.id].seen = isIntersecting;
    draw();
  });
  for (const plot of Object.values(plots)) watch.observe(plot.figure);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", measure);
  for (const [id, words] of Object.entries({ velocity: "velocities over time", moment: "contact moment over time",
    phase: "driver velocity over its angle", map: "handoff map" })) {
    byId(id).querySelector("[role=img]").setAttribute("aria-label", `Plot of ${words}; the text above the sliders gives the values at the playhead`);
  }
}

connect();
if (document.body.matches(".play")) byId("figures").tHead.rows[0].cells[1].textContent = "Value";
if (data.fields) {
  connectDesign();
  take(design);
  readAddress();
} else {
  show(new Played(data.motion), data.motion.design);
}
window.explorer = { simulate, setTime,
  criticalFriction: (numbers) => frictionLimits(checkDesign(numbers)).critical, samples, stateAt, change, numbers: NUMBERS,
  get design() { return design; }, get motion() { return motion; }, get time() { return time; } };
if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
