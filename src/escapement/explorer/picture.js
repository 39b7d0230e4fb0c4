/** The mechanism to scale, as SVG: laid out once for its bodies, then turned. */

import { byId, signed } from "./dom.js";

const NAMESPACE = "http://www.w3.org/2000/svg";
const DEGREES = 180 / Math.PI;

/** Sum of vectors [x, y, rate] that turn with the driver angle. */
export function placeOf(vectors, theta) {
  let [x, y] = [0, 0];
  for (const [a, b, rate] of vectors) {
    const [c, s] = [Math.cos(rate * theta), Math.sin(rate * theta)];
    x += a * c - b * s;
    y += a * s + b * c;
  }
  return [x, y];
}

export class Picture {
  constructor(svg) {
    this.svg = svg;
  }

  add(parent, name, attributes) {
    const element = document.createElementNS(NAMESPACE, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    parent.append(element);
    return element;
  }

  /** Give words in the picture a size that can be read. */
  measure() {
    const { width, height } = this.svg.viewBox.baseVal ?? { width: 1, height: 1 };
    const scale = Math.min(this.svg.clientWidth / width, this.svg.clientHeight / height);
    this.svg.style.setProperty("--letters", `${Math.min(Math.max(0.085 * this.half, 12 / scale), 0.18 * this.half)}px`);
  }

  /** Lay out the bodies of a motion; `drawn` is described in `bodies.py`. */
  layOut({ drawn, figures, design }) {
    this.svg.style.display = drawn ? "" : "none";
    this.drawn = drawn;
    if (!drawn) return;
    if (drawn !== this.shape) this.draw(drawn);
    this.shape = drawn;
    this.jamAngle = drawn.contact ? figures.critical_angle : NaN;
    const jams = Number.isFinite(this.jamAngle);
    this.jam.style.display = jams ? "" : "none";
    const would = design.friction >= figures.critical_friction ? "jams" : "would jam";
    this.jamText.textContent = `${would} here, ${signed(this.jamAngle)}`;
    byId("legend").lastElementChild.hidden = !jams;
    this.marked = -1;
  }

  /** Where the pin touches at an angle of an engagement, and the axis or shaft that carries it. */
  touch(angle, engagement) {
    const { contact, step = 0 } = this.drawn;
    const [c, s] = [Math.cos(engagement * step), Math.sin(engagement * step)];
    return [contact, contact.slice(0, 1)].map((vectors) => {
      const [x, y] = placeOf(vectors, angle);
      return [x * c - y * s, x * s + y * c];
    });
  }

  /** Mark where friction jams first in an engagement. */
  mark(engagement) {
    this.marked = engagement;
    const [[x, y], [a, b]] = this.touch(this.jamAngle, engagement);
    // the words stand outside the bodies, where no pin passes
    const edge = y > 0 ? this.high + 0.04 * this.half : this.low - 0.04 * this.half;
    this.jamLine.setAttribute("d", `M${a} ${b}L${x} ${y}L${x} ${edge}`);
    this.jamText.setAttribute("x", x);
    this.jamText.setAttribute("y", -edge + (y > 0 ? -0.03 : 0.12) * this.half);
  }

  draw({ bodies, box, contact, later }) {
    const { svg } = this;
    const [left, right, low, high] = box;
    [...svg.children].filter((child) => child.tagName === "g").forEach((child) => child.remove());
    [this.low, this.high] = [low, high];
    const half = (this.half = 0.5 * (high - low));
    const room = 0.15 * half;
    svg.setAttribute("viewBox", `${left - room} ${-high - 1.6 * room} `
      + `${right - left + 2 * room} ${high - low + 3.2 * room}`);
    this.measure();
    const up = this.add(svg, "g", { transform: "scale(1,-1)" });
    this.parts = bodies.map(({ name, path, at, turn }) => ({ at, turn,
      element: this.add(up, "path", { d: path, class: name.replace(/-\d+$/, ""), "fill-rule": "evenodd" }) }));
    this.place({ theta: 0, phi: 0 });
    // bodies at rest are placed once
    this.parts = this.parts.filter(({ at, turn }) => turn.some(Boolean) || at.some(([, , rate]) => rate));
    this.add(up, "path", { class: "centres", d: `M${left - 0.8 * room} 0L${right + 0.8 * room} 0` });
    this.jam = this.add(svg, "g", { class: "jam" });
    this.jamLine = this.add(this.jam, "path", { transform: "scale(1,-1)", fill: "none" });
    this.jamText = this.add(this.jam, "text", { "text-anchor": "middle" });
    this.force = this.add(up, "path", { class: "force" });
    for (const item of byId("legend").children) {
      item.hidden = !svg.querySelector(`.${item.dataset.of}`) || (item.dataset.of === "force" && !contact);
    }
    // parts that take time to compute are added after the picture is shown
    clearTimeout(this.later);
    this.later = setTimeout(() => later?.(([name, path]) =>
      up.querySelector(`.${name}`).setAttribute("d", path)), 0);
  }

  /** Turn everything to a state of the motion; the arrow is the force on the follower. */
  turn(state, greatest) {
    if (!this.drawn) return;
    this.place(state);
    const { engagement = 0 } = state;
    if (this.marked !== engagement && Number.isFinite(this.jamAngle)) this.mark(engagement);
    this.push(state, greatest);
  }

  place({ theta, phi }) {
    for (const { element, at, turn } of this.parts) {
      const [x, y] = placeOf(at, theta);
      const angle = (turn[0] * theta + turn[1] * phi) * DEGREES;
      element.setAttribute("transform", `translate(${x.toFixed(6)} ${y.toFixed(6)}) rotate(${angle.toFixed(5)})`);
    }
  }

  push(state, greatest) {
    this.force.setAttribute("d", "");
    if (!this.drawn.contact || state.side === 0 || !(greatest > 0)) return;
    const [[x, y]] = this.touch(state.angle, state.engagement);
    const size = 0.9 * this.half;
    // its length is the moment over the lever, limited by the room
    const share = ((0.7 * state.contact_moment) / greatest) * Math.min(1 / Math.hypot(x, y), 3);
    const length = Math.max(-size, Math.min(size, share));
    if (Math.abs(length) < 0.02) return;
    const along = Math.atan2(y, x);
    // the force acts across the slot, in the sense in which the follower turns or against it
    const [a, b] = [-Math.sin(along), Math.cos(along)];
    const s = Math.sign(length);
    const tip = [x + length * a, y + length * b];
    const barb = (turn) => {
      const [c, d] = [Math.cos(turn), Math.sin(turn)];
      return `M${tip.join(" ")}l${-0.12 * s * (a * c - b * d)} ${-0.12 * s * (a * d + b * c)}`;
    };
    this.force.setAttribute("d", `M${x} ${y}L${tip.join(" ")}${barb(0.45)}${barb(-0.45)}`);
  }

  /** The picture as the text of an SVG file, with the colours it has here. */
  asText() {
    const copy = this.svg.cloneNode(true);
    const originals = this.svg.querySelectorAll("*");
    copy.querySelectorAll("*").forEach((element, i) => {
      const style = getComputedStyle(originals[i]);
      for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "font-size", "display",
        "vector-effect", "paint-order"]) {
        element.style.setProperty(name, style.getPropertyValue(name));
      }
    });
    copy.setAttribute("xmlns", NAMESPACE);
    return new XMLSerializer().serializeToString(copy);
  }
}
