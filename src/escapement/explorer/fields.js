/** Sliders and fields for the numbers of a design. */

import { element, shown, unitOf, units } from "./dom.js";
import { short } from "./design.js";
import { mostPins } from "./law.js";
import { NUMBERS, otherwise } from "./rules.js";

// the slider of a number without an upper limit covers four decades around its first value
const WIDE = ["torque", "driver_inertia", "follower_inertia", "crank_radius"];

export class Fields {
  /** on : functions that take changed numbers (change), and the field of a mistake (complain). */
  constructor(form, on) {
    Object.assign(this, { form, on, inputs: {}, centres: {}, design: {}, figures: {} });
    form.addEventListener("submit", (event) => event.preventDefault());
  }

  /** Make the fields of some groups, which are names by their title; the first two are open. */
  lay(groups) {
    this.groups = Object.entries(groups).map(([title, names], i) => [names, element("details", { open: i < 2 },
      element("summary", { textContent: title }), ...names.map((name) => this.make(name)))]);
    this.form.append(...this.groups.map(([, group]) => group));
  }

  make(name) {
    const { label, truth } = NUMBERS[name];
    if (truth) {
      const box = element("input", { type: "checkbox", id: name });
      box.addEventListener("change", () => this.changed(name, box.checked));
      this.inputs[name] = { box };
      return element("div", { className: "check" }, box,
        element("label", { htmlFor: name, textContent: label }));
    }
    return this.makeNumber(name, label);
  }

  makeNumber(name, label) {
    const slider = element("input", { type: "range", min: 0, max: 1, step: "any" });
    slider.setAttribute("aria-label", `${label}, slider`);
    const text = element("input", { type: "text", inputMode: "decimal", id: name, name });
    text.autocomplete = "off";
    const after = element("span", { className: "unit" });
    slider.addEventListener("input", () => {
      this.changed(name, this.fromSlider(name, Number(slider.value)));
    });
    // arrow keys move a slider by a hundredth of its range, or by one for whole numbers
    slider.addEventListener("keydown", (event) => {
      const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      if (!way) return;
      event.preventDefault();
      const [low, high] = this.rangeOf(name);
      const step = NUMBERS[name].whole ? 1 / (high - low || 1) : 0.01;
      slider.value = Number(slider.value) + way * step;
      slider.dispatchEvent(new Event("input"));
    });
    text.addEventListener("input", () => this.typed(name, text));
    text.addEventListener("blur", () => this.refresh(this.design, this.figures));
    this.inputs[name] = { slider, text, after };
    return element("div", { className: "field" },
      element("label", { htmlFor: name, textContent: label }), slider, text, after);
  }

  changed(name, value) {
    // the greatest number of pins follows from the slots
    const more = ["slots", "internal"].includes(name) ? { pins: null } : {};
    this.on.change({ [name]: value, ...more }, name);
  }

  typed(name, text) {
    const { label, optional, unit } = NUMBERS[name];
    this.inputs[name].said = "";
    const words = text.value.trim();
    const value = words === "" ? (optional ? null : NaN) : Number(words) * unitOf(unit).factor;
    if (value === null || Number.isFinite(value)) this.changed(name, value);
    else this.on.complain(`${label} must be a number, got '${words.slice(0, 40)}'; the last good design stays`, name);
  }

  /** Mark the field of a mistake, and give the element below which its message stands. */
  refuse(name) {
    const { text, box } = this.inputs[name];
    this.inputs[name].said = "";
    text?.setAttribute("aria-invalid", "true");
    text?.setAttribute("aria-describedby", "problem");
    return (text ?? box).parentElement;
  }

  /** Least and greatest value of a slider. */
  rangeOf(name) {
    if (WIDE.includes(name)) return [0, 1];
    const { torque, follower_inertia, slots, internal, crank_radius: crank } = this.design;
    const critical = this.figures.critical_friction;
    const limits = {
      slots: [3, 12], pins: [1, mostPins(slots, internal)], engagements: [1, 60], initial_speed: [0, 500],
      driver_bearing_friction: [0, 0.4], follower_bearing_friction: [0, 0.4],
      friction: [0, Number.isFinite(critical) ? 1.05 * critical : 1], load_torque: [0, 0.6 * torque],
      spring_rate: [0, 0.05 * torque], driver_bearing_torque: [0, 0.5 * torque],
      driver_drag: [0, 0.1 * follower_inertia], follower_drag: [0, 0.1 * follower_inertia],
      pin_radius: [0, 0.15 * crank], driver_bearing_radius: [0, 0.2 * crank],
      follower_bearing_radius: [0, 0.2 * crank],
    };
    return limits[name] ?? [0, 1];
  }

  toSlider(name, value) {
    if (WIDE.includes(name)) return 0.5 + Math.log10(value / (this.centres[name] ??= value)) / 4;
    const [low, high] = this.rangeOf(name);
    return high > low ? (value - low) / (high - low) : 0;
  }

  fromSlider(name, share) {
    const [low, high] = this.rangeOf(name);
    const value = WIDE.includes(name) ? this.centres[name] * 10 ** (4 * (share - 0.5))
      : low + share * (high - low);
    return NUMBERS[name].whole ? Math.round(value) : Number(value.toPrecision(4));
  }

  /** Show a design in all fields except the one that has the focus. */
  refresh(design, figures, active = null) {
    Object.assign(this, { design, figures });
    // a design that is shown anew hides nothing that differs from its default
    for (const [names, group] of active === null ? this.groups ?? [] : []) {
      group.open ||= names.some((name) => design[name] !== otherwise(name));
    }
    for (const [name, { slider, text, after, box }] of Object.entries(this.inputs)) {
      if (box) box.checked = design[name];
      else this.refreshNumber(name, design[name], { slider, text, after }, active);
    }
  }

  refreshNumber(name, value, { slider, text, after }, active) {
    const kind = NUMBERS[name].unit;
    const busy = document.activeElement;
    const held = active === name && (busy === text || busy === slider);
    const position = this.toSlider(name, value);
    // elements that do not change are left alone, which saves time
    const said = [value, position, units.system].join();
    if (!held && this.inputs[name].said === said && busy !== text) return;
    this.inputs[name].said = said;
    const { name: unit, factor } = unitOf(kind);
    if (busy !== text || active !== name) text.value = short(value / factor);
    text.removeAttribute("aria-invalid");
    after.textContent = unit;
    if (busy !== slider || active !== name) slider.value = position;
    slider.setAttribute("aria-valuetext", shown(value, kind));
  }
}
