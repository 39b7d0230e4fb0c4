/** The mechanism to scale, as SVG: laid out once for a wheel, then turned. */

import { lockedAngle } from "./kernel.js";
import { pose } from "./law.js";
import { followerEdge, lockingDisc, pinAt, proportionsOf } from "./bodies.js";

const NAMESPACE = "http://www.w3.org/2000/svg";
const DEGREES = 180 / Math.PI;
const pathOf = (edge) =>
  edge.length ? `M${edge.map(([x, y]) => `${x.toFixed(4)} ${y.toFixed(4)}`).join("L")}Z` : "";
const circleOf = (r) => `M${r} 0A${r} ${r} 0 1 0 ${-r} 0A${r} ${r} 0 1 0 ${r} 0Z`;

export class Picture {
  constructor(svg) {
    this.svg = svg;
    this.key = "";
  }

  add(parent, name, attributes) {
    const element = document.createElementNS(NAMESPACE, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    parent.append(element);
    return element;
  }

  /** Lay out the bodies of a motion's wheel; `limits` holds where friction jams first. */
  layOut({ scene, design, figures }) {
    const key = [design.slots, design.pins, design.internal, scene.r_p].join();
    this.scene = scene;
    if (key !== this.key) this.draw(proportionsOf(scene, scene.r_p));
    this.key = key;
    const angle = figures.critical_angle;
    const shown = Number.isFinite(angle);
    this.jam.style.display = shown ? "" : "none";
    if (shown) {
      const [x, y] = pinAt(scene, angle, 0);
      const out = [scene.centre + 1.22 * (x - scene.centre), 1.22 * y];
      this.jamLine.setAttribute("d", `M${scene.centre} 0L${out.join(" ")}`);
      this.jamText.setAttribute("x", out[0]);
      this.jamText.setAttribute("y", -out[1] + (y > 0 ? -0.04 : 0.14) * this.half);
    }
  }

  draw(shape) {
    const { svg } = this;
    const { wheel, centre, reach, crankDisc, internal } = shape;
    [...svg.children].filter((child) => child.tagName === "g").forEach((child) => child.remove());
    const half = Math.max(reach, crankDisc) + 0.18;
    const right = Math.max(reach, centre + crankDisc) + 0.3;
    this.half = half;
    svg.setAttribute("viewBox", `${-reach - 0.2} ${-half - 0.12} ${right + reach + 0.2} ${2 * half + 0.24}`);
    svg.style.setProperty("--letters", `${0.085 * half}px`);
    const up = this.add(svg, "g", { transform: "scale(1,-1)" });
    const crank = this.add(up, "g", {});
    const disc = { d: circleOf(crankDisc), class: "crank-disc" };
    this.add(crank, "path", { ...disc, transform: `translate(${centre} 0)` });
    this.follower = this.add(up, "g", {});
    const ring = internal ? circleOf(reach) : "";
    this.add(this.follower, "path", { d: pathOf(followerEdge(shape)) + ring, class: "follower",
      "fill-rule": "evenodd" });
    // slot 0 is marked, so that the eye can follow the wheel
    const mark = internal ? shape.slotEnd + shape.halfSlot + 0.09 : 0.78 * (shape.slotEnd - shape.halfSlot);
    this.add(this.follower, "circle", { class: "mark", r: Math.min(0.045, 0.25 * mark), cx: mark });
    if (!internal) this.add(this.follower, "circle", { r: shape.followerShaft, class: "shaft" });
    this.add(up, "path", { ...disc, class: "hidden", transform: `translate(${centre} 0)` });
    this.crank = this.add(up, "g", {});
    this.locking = this.add(this.crank, "path", { d: "", class: "locking-disc" });
    this.add(this.crank, "circle", { r: shape.driverShaft, class: "shaft" });
    this.add(this.crank, "path", { d: `M0 0L${shape.sigma} 0`, class: "arm" });
    for (let k = 0; k < wheel.pins; k++) {
      const turn = -shape.sigma * k * wheel.cell * DEGREES;
      this.add(this.crank, "circle", { class: "pin", cx: shape.sigma, r: shape.pin,
        transform: `rotate(${turn.toFixed(6)})` });
    }
    this.add(up, "path", { class: "centres", d: `M${-reach - 0.15} 0L${right - 0.1} 0` });
    this.jam = this.add(svg, "g", { class: "jam" });
    this.jamLine = this.add(this.jam, "path", { transform: "scale(1,-1)" });
    this.jamText = this.add(this.jam, "text", { "text-anchor": "middle" });
    this.jamText.textContent = "jams here first";
    this.force = this.add(up, "path", { class: "force" });
    this.shape = shape;
    // the envelope takes a while: the picture comes first
    clearTimeout(this.later);
    this.later = setTimeout(() => this.locking.setAttribute("d", pathOf(lockingDisc(shape))), 0);
  }

  /** Turn everything to a state of the motion; the arrow is the force on the follower. */
  turn(state, greatest) {
    const { scene, shape } = this;
    const phi = lockedAngle(scene, state.theta);
    this.follower.setAttribute("transform", `rotate(${phi * DEGREES})`);
    this.crank.setAttribute("transform",
      `translate(${scene.centre} 0) rotate(${scene.sigma * state.theta * DEGREES})`);
    const length = greatest > 0 ? (0.9 * state.contact_moment) / greatest / pose(scene, state.angle).R : 0;
    if (state.side === 0 || Math.abs(length) < 0.02) return void this.force.setAttribute("d", "");
    const [x, y] = pinAt(scene, state.angle, 0);
    const along = Math.atan2(y, x);
    // the force stands across the slot, in the sense in which the follower turns or against it
    const [a, b] = [-Math.sin(along), Math.cos(along)];
    const s = Math.sign(length);
    const from = [x + s * shape.pin * a, y + s * shape.pin * b];
    const tip = [from[0] + length * a, from[1] + length * b];
    const barb = (turn) => {
      const [c, d] = [Math.cos(turn), Math.sin(turn)];
      return `M${tip.join(" ")}l${-0.12 * s * (a * c - b * d)} ${-0.12 * s * (a * d + b * c)}`;
    };
    this.force.setAttribute("d", `M${from.join(" ")}L${tip.join(" ")}${barb(0.45)}${barb(-0.45)}`);
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
