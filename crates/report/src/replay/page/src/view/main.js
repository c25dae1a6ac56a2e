// The page of `samara view`: a mission whose values can be changed, flown at each change. What a user has done
// is here, and goes with the page; the program knows the mission as it was opened.

import { find, fixed, listen, Player, put, Run } from "../main.js";
import { Campaign } from "./campaign.js";
import { Controls } from "./controls.js";
import { Refused, Server } from "./server.js";

/** The campaign begins when nothing was changed for so long [ms]. */
const QUIET_MS = 400;
/** Changes of one key that follow one another faster are undone together [ms]. */
const ONE_CHANGE_MS = 800;
const MOST_PINS = 6;
const [LAST, OPENED, NONE] = ["before", "opened", "none"];

/** What changes come to, as one text. */
const textOf = (changes) => new URLSearchParams([...changes]).toString();

class View {
  constructor(server, mission) {
    Object.assign(this, { server, mission, changes: new Map(), past: [], future: [], shown: null, before: null });
    Object.assign(this, { opened: null, pins: [], besideOf: LAST, flying: false, asked: false, pending: null });
    document.title = `${mission.name} \u2013 samara view`;
    put("#name", mission.name);
    this.controls = new Controls(mission, (key, value, done) => this.set(key, value, done));
    this.campaign = new Campaign(server, mission.campaign);
    this.wire();
    for (const [key, value] of new URLSearchParams(location.hash.slice(1))) this.changes.set(key, value);
    this.controls.show(this.changes);
    this.fly();
  }

  // ---- what is changed ----

  /** Another value of a key; none: the mission's own. Until a hand is `done`, and shortly after, it is one
   * change. */
  set(key, value, done) {
    const { last } = this;
    const at = performance.now();
    const goesOn = last?.key === key && (!last.done || at - last.at < ONE_CHANGE_MS);
    this.last = { key, done, at };
    if ((value ?? undefined) === this.changes.get(key)) return this.controls.show(this.changes);
    if (!goesOn) this.remember();
    const changes = new Map(this.changes);
    if (value === null) changes.delete(key);
    else changes.set(key, value);
    this.change(changes);
  }

  /** What is there now can be undone, and is drawn beside what comes. */
  remember() {
    this.past.push(this.changes);
    this.future = [];
    this.before = this.shown;
    this.isBesideOld = true;
  }

  change(changes) {
    this.changes = changes;
    this.controls.show(changes);
    find("#undo").disabled = !this.past.length;
    find("#redo").disabled = !this.future.length;
    find("#reset").disabled = !changes.size;
    this.campaign.stop();
    this.fly();
  }

  travel(from, to) {
    if (!from.length) return;
    to.push(this.changes);
    this.last = null;
    this.before = this.shown;
    this.isBesideOld = true;
    this.change(from.pop());
  }

  goTo(changes) {
    this.last = null;
    this.remember();
    this.change(new Map(changes));
  }

  // ---- flying ----

  /** Asks for the flight of what is there; while one is under way the newest waits. */
  async fly() {
    this.asked = true;
    if (this.flying) return;
    this.flying = true;
    document.body.classList.add("flying");
    while (this.asked) {
      this.asked = false;
      const { changes } = this;
      try {
        const told = await this.server.json("fly", { number: this.server.next(), changes: Object.fromEntries(changes) });
        this.pending = { told, changes };
        // Later ones are taken by the next frame.
        if (!this.player) this.take();
      } catch (error) {
        if (!this.asked) this.refused(error);
      }
    }
    this.flying = false;
    document.body.classList.remove("flying");
  }

  /** Nothing was changed for a while: the campaign is flown, and the address holds what is there. */
  rest() {
    const { shown } = this;
    if (shown.changes !== this.changes) return;
    history.replaceState(null, "", this.changes.size ? `#${textOf(this.changes)}` : location.pathname);
    this.campaign.fly(Object.fromEntries(this.changes));
    shown.tally = this.campaign.tally;
    put("#said", `${find("#verdict").textContent} ${shown.told.hint ?? ""}`);
  }

  refused(error) {
    if (!(error instanceof Refused)) throw error;
    // No plan, say, is no key's fault: what was moved last is what it came of.
    const beside = this.controls.fail(error.key ?? this.last?.key ?? null, error.message);
    this.trouble(beside ? "" : error.message);
    this.campaign.stop();
    document.body.classList.add("stale");
    if (!this.shown) put("#verdict", "No flight yet.");
  }

  trouble(text) {
    put("#trouble", text);
    find("#trouble").hidden = !text;
  }

  /** Draws the newest flight, once a frame. */
  take() {
    const { told, changes } = this.pending;
    this.pending = null;
    const run = Run.fromObject(told.drop);
    this.shown = { run, changes, told, tally: null };
    this.opened ??= this.shown;
    this.before ??= this.shown;
    this.controls.fail(null);
    this.trouble("");
    document.body.classList.remove("stale");
    if (this.player) this.player.open(run);
    else this.begin(run);
    this.tell(told);
    if (this.isBesideOld ?? true) this.showBeside();
    this.controls.beside(this.beside()?.changes, changes);
    clearTimeout(this.quiet);
    this.quiet = setTimeout(() => this.rest(), QUIET_MS);
  }

  begin(run) {
    this.player = new Player(run);
    this.player.onFrame = () => this.frame();
    listen(this.player, () => (this.campaign.dirty = true), {
      k: () => this.pin(),
      "/": () => find("#key").focus(),
    });
    this.player.look("path", true);
    this.player.seek(run.about.times.steady_s ?? run.plan?.end ?? run.motion.zero);
    /** For tests: what is shown. */
    window.replay = this.player;
  }

  frame() {
    if (this.pending) this.take();
    this.campaign.draw();
  }

  tell({ words, passed, hint, cost, loops, command }) {
    const verdict = find("#verdict");
    verdict.innerHTML = words.verdict;
    verdict.className = `verdict ${cost === null ? "open" : passed ? "" : "no"}`;
    put("#hint", hint ?? "");
    find("#hint").hidden = !hint;
    for (const name of ["numbers", "facts", "table"]) find(`#${name}`).innerHTML = words[name];
    find("#facts").title = find("#facts").textContent;
    put("#command", command);
    const rows = loops.map(({ name, modulus, delay_margin_s, passed }) => {
      const delay = delay_margin_s === null ? "\u2013" : `${fixed(1000 * delay_margin_s, 0)} ms`;
      return [name, fixed(modulus ?? NaN, 2), delay, passed];
    });
    const cell = (tag, text) => Object.assign(document.createElement(tag), { textContent: text });
    const table = document.createElement("table");
    table.append(document.createElement("thead"), document.createElement("tbody"));
    table.tHead.insertRow().append(...["Loops", "modulus", "delay margin"].map((text) => cell("th", text)));
    for (const [name, modulus, delay, passed] of rows) {
      const row = table.tBodies[0].insertRow();
      row.className = passed ? "" : "no";
      row.append(cell("th", name), cell("td", modulus), cell("td", passed ? delay : `${delay}, too little`));
    }
    find("#loops").replaceChildren(...(rows.length ? [table] : []));
  }

  // ---- what is drawn beside ----

  beside() {
    if (this.besideOf === NONE) return null;
    if (this.besideOf === LAST) return this.before;
    return this.besideOf === OPENED ? this.opened : this.besideOf;
  }

  /** Draws beside the flight what was chosen for it, by buttons that say what there is to choose. */
  showBeside() {
    this.isBesideOld = false;
    const other = this.beside();
    const same = !other || other === this.shown;
    const names = new Map([[LAST, "before"], [OPENED, "as opened"]]);
    this.player.compare(same ? null : other.run, names.get(this.besideOf) ?? this.besideOf.name);
    this.campaign.beside = same ? null : other.tally;
    this.campaign.dirty = true;
    this.controls.beside(other?.changes, this.changes);
    const button = (of, text, title) => {
      const made = Object.assign(document.createElement("button"), { textContent: text, title });
      made.setAttribute("aria-pressed", String(this.besideOf === of));
      made.addEventListener("click", () => {
        this.besideOf = of;
        this.showBeside();
      });
      return made;
    };
    const j = ({ told }) => (told.cost === null ? "" : ` J ${fixed(told.cost, 3)}`);
    const buttons = [
      button(LAST, "before the change", "what was there before the last change"),
      button(OPENED, "as opened", "the mission as it was opened"),
      ...this.pins.map((pin) => button(pin, `${pin.name}${j(pin)}`, textOf(pin.changes) || "the mission as it was opened")),
      button(NONE, "nothing", "this flight alone"),
    ];
    if (typeof this.besideOf === "object") {
      const act = (text, title, does) => {
        const made = Object.assign(document.createElement("button"), { textContent: text, title });
        made.addEventListener("click", does);
        return made;
      };
      const { besideOf } = this;
      buttons.push(act("go back to it", "its values again; this can be undone", () => this.goTo(besideOf.changes)));
      buttons.push(act("\u00d7", `let ${besideOf.name} go`, () => this.unpin(besideOf)));
    }
    find("#besides").replaceChildren(...buttons);
    find(".beside").classList.toggle("drawn", !same);
    find("#pin").disabled = this.pins.length >= MOST_PINS;
  }

  pin() {
    if (!this.shown || this.pins.length >= MOST_PINS) return;
    const used = new Set(this.pins.map(({ name }) => name));
    const name = [..."ABCDEF"].find((letter) => !used.has(letter));
    const pin = Object.assign(this.shown, { name });
    if (!this.pins.includes(pin)) this.pins.push(pin);
    this.besideOf = pin;
    this.showBeside();
  }

  unpin(pin) {
    this.pins = this.pins.filter((other) => other !== pin);
    this.besideOf = LAST;
    this.showBeside();
  }

  // ---- buttons ----

  wire() {
    const undo = () => this.travel(this.past, this.future);
    const redo = () => this.travel(this.future, this.past);
    find("#undo").addEventListener("click", undo);
    find("#redo").addEventListener("click", redo);
    find("#reset").addEventListener("click", () => this.goTo(new Map()));
    find("#pin").addEventListener("click", () => this.pin());
    addEventListener("keydown", (event) => {
      const key = event.key.toLowerCase();
      if (!(event.ctrlKey || event.metaKey) || event.altKey || (key !== "z" && key !== "y")) return;
      event.preventDefault();
      if (key === "y" || event.shiftKey) redo();
      else undo();
    });
    const copy = find("#copy");
    copy.addEventListener("click", async () => {
      const copied = await navigator.clipboard?.writeText(find("#command").textContent).then(() => true, () => false);
      if (!copied) getSelection().selectAllChildren(find("#command"));
      if (!copied) find("#command").focus();
      copy.textContent = copied ? "Copied" : "Marked below";
      setTimeout(() => (copy.textContent = "Copy command"), 1500);
    });
    // Another tab may have had the program for itself meanwhile.
    addEventListener("focus", () => this.campaign.overtaken && this.rest());
    this.wireWrite();
  }

  wireWrite() {
    const [dialog, name] = [find("#write"), find("#file-name")];
    find("#save").addEventListener("click", () => {
      put("#written", "");
      name.value ||= `${this.mission.name}_variant.json`;
      dialog.showModal();
      name.select();
    });
    const write = async () => {
      const body = { name: name.value.trim(), changes: Object.fromEntries(this.changes) };
      try {
        const { written } = await this.server.json("write", body);
        put("#written", `Written: ${written.join(", ")}`);
      } catch (error) {
        put("#written", error.message);
      }
    };
    find("#write-now").addEventListener("click", write);
    find("#write-no").addEventListener("click", () => dialog.close());
    name.addEventListener("keydown", (event) => {
      if (event.key === "Enter") write();
    });
  }
}

const server = new Server((lost) => {
  document.body.classList.toggle("lost", lost);
  put("#trouble", lost ? "The program does not answer. This page goes on as soon as it does." : "");
  find("#trouble").hidden = !lost;
});

async function start() {
  try {
    await server.enter();
    /** For tests: what was asked and answered. */
    window.view = new View(server, await server.json("mission"));
  } catch (error) {
    const told = error.status === 403 ? "This page is open to the browser that the program's address was opened in: open the address that samara view printed." : error.message;
    put("#trouble", told);
    find("#trouble").hidden = false;
  }
}

start();
