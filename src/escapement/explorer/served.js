/** Additions of the served page: the package computes what the page's own kernel cannot. */

import { asToml } from "./design.js";
import { byId, element } from "./dom.js";
import { Played } from "./played.js";
import { NUMBERS } from "./rules.js";

const PATIENCE = 500; // ms after which a text says that the package is computing

/** Questions to one address: one at a time; only the latest of those that wait is sent. */
export class Line {
  constructor(path, token, heard) {
    Object.assign(this, { path, token, heard, busy: false, waiting: null });
  }

  async ask(make) {
    if (this.busy) {
      this.waiting = make;
      return;
    }
    this.busy = true;
    const slow = setTimeout(() => this.slow?.(), PATIENCE);
    const question = make();
    let answer;
    try {
      const found = await fetch(this.path, { method: "POST", body: JSON.stringify(question),
        headers: { "Content-Type": "application/json", "X-Token": this.token } });
      answer = await found.json();
    } catch {
      answer = { error: "the program that serves this page does not answer; start escapement explore --serve again" };
    }
    clearTimeout(slow);
    this.busy = false;
    this.heard(answer, question);
    const next = this.waiting;
    this.waiting = null;
    if (next) this.ask(next);
  }
}

export class Served {
  /** page : design(), take(), show(), complain(), refuse() and lay() of the page. */
  constructor({ token, kinds, kind }, page) {
    Object.assign(this, { kinds, kind, page, text: null, changes: {}, whole: {} });
    this.line = new Line("motion", token, (answer, { active }) => this.hear(answer, active));
    this.line.slow = () => {
      byId("outcome").textContent = "The package is computing.";
    };
    byId("kind").append(...Object.keys(kinds).map((value) => element("option", { value, textContent: value })));
    byId("kind").value = kind;
    byId("kind").addEventListener("change", () => this.ask({ kind: byId("kind").value }));
  }

  /** Whether numbers are to be computed by the package. */
  takes(numbers) {
    return this.text !== null || this.line.busy
      || Object.keys(numbers).some((name) => !(name in NUMBERS) && name !== "internal");
  }

  /** Let the page compute by itself again. */
  leave() {
    this.text = null;
    this.lay("geneva");
  }

  lay(kind) {
    byId("kind").value = kind;
    if (kind === this.kind) return;
    this.kind = kind;
    this.page.lay(this.kinds[kind] ?? {});
  }

  /** The description of the design that the package is sent. */
  get question() {
    const design = this.page.design();
    return { text: this.text ?? asToml(design), engagements: design.engagements };
  }

  /** Ask for another design: `change` of some numbers, or a `text`, `kind` or `case`. */
  ask({ change = {}, ...whole }, active = null) {
    if (Object.keys(whole).length) Object.assign(this, { changes: {}, whole });
    Object.assign(this.changes, change);
    this.line.ask(() => {
      const question = { ...this.question, ...this.whole, change: this.changes, active };
      Object.assign(this, { changes: {}, whole: {} });
      return question;
    });
  }

  hear({ error, plain, text, kind, design, motion }, active) {
    if (error) {
      byId("outcome").textContent = "";
      this.page.complain(`${error}; the last good design stays`);
      byId("kind").value = this.kind;
      if (active) this.page.refuse(active);
    } else if (plain) {
      this.page.take(plain, active);
    } else {
      this.text = text;
      this.lay(kind);
      this.page.show(new Played(motion), design, active);
    }
  }
}
