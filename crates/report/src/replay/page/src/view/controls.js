// The values that can be changed: sliders with fields, and a search for every other key.

import { find } from "../main.js";

/** A key without a range of its own has a slider over this many times its value. */
const AROUND = 2;
const STEPS = 100;
const MOST_FOUND = 14;
/** Below this width groups but the first are folded [px]. */
const NARROW_PX = 928;
const GROUP_OF_FOUND = "Found";

function make(tag, properties = {}, ...children) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

/** A value as one would type it. */
function typed(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "number") return String(Number(value.toPrecision(6)));
  return typeof value === "string" ? value : JSON.stringify(value);
}

/** A step of 1, 2 or 5 times a power of ten, some hundred of them in a span. */
function stepOf(span) {
  const power = 10 ** Math.floor(Math.log10(span / STEPS));
  return Number(([1, 2, 5, 10].map((m) => m * power).find((step) => step >= span / STEPS) ?? power).toPrecision(3));
}

/** A key of the search box as a control: a number's slider reaches around its value. */
function controlOf({ key, description, unit, kind, value, minimum, maximum, choices }) {
  const control = { key, label: key.replace(/[._]/g, "$&\u200b"), unit, group: GROUP_OF_FOUND, value, choices, description };
  if (kind === "boolean") control.choices = ["false", "true"];
  if ((kind !== "number" && kind !== "integer") || typeof value !== "number" || value === 0) return control;
  const low = Math.max(Math.min(0, AROUND * value), minimum ?? -Infinity);
  const high = Math.min(Math.max(0, AROUND * value), maximum ?? Infinity);
  return { ...control, minimum: low, maximum: high, step: stepOf(high - low) };
}

/** One value: label, slider where it has a range, field, unit, what is wrong with it. */
class Control {
  constructor(spec, id, onSet) {
    Object.assign(this, { spec, onSet, own: typed(spec.value) });
    const { key, label, unit, minimum, maximum, choices, absent, description } = spec;
    const [field, error] = [`field-${id}`, `error-${id}`];
    this.reset = make("button", { className: "reset", title: `as in the mission: ${this.own || (absent ?? "not there")}`, ariaLabel: `${label}: as in the mission`, hidden: true }, "\u21ba");
    this.reset.addEventListener("click", () => {
      this.onSet(null, true);
      this.field.focus();
    });
    if (choices) {
      const options = choices.map((choice) => new Option(typed(choice), typed(choice)));
      if (spec.value === null || spec.value === undefined) options.unshift(new Option(absent ?? "\u2013", ""));
      this.field = make("select", { id: field }, ...options);
    } else {
      const numeric = typeof spec.value === "number" || minimum !== undefined;
      this.field = make("input", { id: field, type: "text", inputMode: numeric ? "decimal" : "text", autocomplete: "off", spellcheck: false, placeholder: absent ? "\u2013" : "" });
    }
    this.field.setAttribute("aria-describedby", error);
    this.field.addEventListener("change", () => this.onSet(this.field.value.trim() || null, true));
    this.error = make("p", { className: "error", id: error, role: "alert", hidden: true });
    const ofUnit = make("span", { className: "unit" }, unit ?? "");
    const title = [key, description ?? absent].filter(Boolean).join(": ");
    this.element = make("div", { className: "control", title });
    this.element.dataset.key = key;
    this.element.append(make("label", { htmlFor: field }, label), this.reset, make("span", { className: "entry" }, this.field, ofUnit));
    if (minimum !== undefined && maximum !== undefined) this.slide(label, spec);
    else this.element.classList.toggle("long", !choices);
    this.element.append(this.error);
    this.show(undefined);
  }

  slide(label, { minimum, maximum, step, whole }) {
    if (whole) step = Math.max(1, Math.round(step));
    // From a multiple of the step on: what it comes to are round numbers.
    const min = Number((Math.ceil(minimum / step - 1e-9) * step).toPrecision(9));
    this.slider = make("input", { type: "range", min, max: maximum, step, ariaLabel: label });
    this.mark = make("i", { hidden: true });
    this.slider.addEventListener("input", () => this.onSet(this.slider.value, false));
    this.slider.addEventListener("change", () => this.onSet(this.slider.value, true));
    this.slider.addEventListener("dblclick", () => this.onSet(null, true));
    this.field.addEventListener("keydown", (event) => {
      const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
      if (!by) return;
      event.preventDefault();
      const now = Number(this.field.value);
      if (!Number.isFinite(now)) return;
      const digits = Math.max(0, Math.ceil(-Math.log10(step)));
      this.onSet(typed(Number((now + by * step).toFixed(digits + 1))), true);
    });
    this.element.append(make("span", { className: "slide" }, this.slider, this.mark));
  }

  /** Shows a value, or the mission's own. */
  show(changed) {
    const text = changed ?? this.own;
    if (this.field.value !== text) this.field.value = text;
    if (this.slider) {
      const number = Number.parseFloat(text);
      this.slider.value = String(Number.isFinite(number) ? number : this.slider.min);
      this.slider.parentElement.classList.toggle("none", !Number.isFinite(number));
      this.slider.setAttribute("aria-valuetext", text ? `${text} ${this.spec.unit ?? ""}` : (this.spec.absent ?? "none"));
    }
    this.reset.hidden = changed === undefined;
    this.element.classList.toggle("changed", changed !== undefined);
  }

  /** A mark where the flight that is drawn beside has this value; none where it is the same. */
  beside(text, now) {
    if (!this.slider) return;
    const value = Number.parseFloat(text ?? this.own);
    const { min, max } = this.slider;
    const share = (value - min) / (max - min);
    this.mark.hidden = !(share >= 0 && share <= 1) || text === now;
    this.mark.style.setProperty("--share", String(share));
  }

  fail(message) {
    this.error.textContent = message ?? "";
    this.error.hidden = !message;
    this.field.setAttribute("aria-invalid", String(!!message));
  }
}

export class Controls {
  /** `onSet` hears key, value (none: the mission's) and whether a hand has let go. */
  constructor({ controls, keys }, onSet) {
    Object.assign(this, { onSet, keys, all: new Map(), groups: new Map() });
    controls.forEach((spec) => this.add(spec));
    const narrow = innerWidth < NARROW_PX;
    [...this.groups.values()].forEach((group, k) => (group.open = !narrow || k === 0));
    this.search();
  }

  add(known) {
    const spec = { ...known, whole: this.keys.find(({ key }) => key === known.key)?.kind === "integer" };
    const control = new Control(spec, this.all.size, (value, done) => this.onSet(spec.key, value === control.own ? null : value, done));
    this.all.set(spec.key, control);
    this.group(spec.group).append(control.element);
    return control;
  }

  group(name) {
    if (!this.groups.has(name)) {
      const group = make("details", { className: "group", open: true }, make("summary", {}, name));
      this.groups.set(name, group);
      if (name === GROUP_OF_FOUND) find("#groups").prepend(group);
      else find("#groups").append(group);
    }
    return this.groups.get(name);
  }

  /** The control of a key, made where it is not there yet; none where no key is called so. */
  of(key) {
    if (this.all.has(key)) return this.all.get(key);
    const known = this.keys.find((k) => k.key === key);
    return known ? this.add(controlOf(known)) : null;
  }

  show(changes) {
    for (const key of changes.keys()) this.of(key);
    for (const [key, control] of this.all) control.show(changes.get(key));
  }

  beside(theirs, mine) {
    for (const [key, control] of this.all) control.beside(theirs?.get(key), theirs ? mine.get(key) : undefined);
  }

  /** Says beside a key what is wrong with it; whether that key has a place. */
  fail(key, message) {
    for (const control of this.all.values()) control.fail(null);
    const control = key === null ? null : (this.all.get(key) ?? this.of(key));
    if (!control || !message) return false;
    control.element.closest("details").open = true;
    control.fail(message);
    return true;
  }

  // ---- the search ----

  search() {
    const [box, list] = [find("#key"), find("#found")];
    let found = [];
    let chosen = 0;
    const mark = () => {
      [...list.children].forEach((item, k) => item.setAttribute("aria-selected", String(k === chosen)));
      const item = list.children[chosen];
      box.setAttribute("aria-activedescendant", item ? item.id : "");
      item?.scrollIntoView({ block: "nearest" });
    };
    const close = () => {
      list.hidden = true;
      box.setAttribute("aria-expanded", "false");
    };
    const open = () => {
      found = this.matches(box.value);
      chosen = 0;
      list.replaceChildren(...found.map((key, k) => this.option(key, k)));
      if (box.value && !found.length) list.append(make("li", { className: "none" }, "no key is called or described so"));
      list.hidden = list.children.length === 0;
      box.setAttribute("aria-expanded", String(!list.hidden));
      mark();
    };
    const take = (k) => {
      if (!found[k]) return;
      const control = this.of(found[k].key);
      box.value = "";
      close();
      control.element.closest("details").open = true;
      control.element.scrollIntoView({ block: "nearest" });
      control.field.focus();
    };
    box.addEventListener("input", open);
    box.addEventListener("focus", open);
    box.addEventListener("blur", close);
    box.addEventListener("keydown", (event) => {
      const by = { ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (by && found.length) {
        chosen = (chosen + by + found.length) % found.length;
        mark();
      } else if (event.key === "Enter") take(chosen);
      else if (event.key === "Escape") close();
      else return;
      event.preventDefault();
    });
    list.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      const item = event.target.closest("[role=option]");
      if (item) take([...list.children].indexOf(item));
    });
  }

  /** Keys that have every word in name or description, those first whose name begins so. */
  matches(text) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    if (!words.length) return [];
    const rank = ({ key, description }) => {
      const [name, all] = [key.toLowerCase(), `${key} ${description ?? ""}`.toLowerCase()];
      if (!words.every((word) => all.includes(word))) return null;
      if (name.startsWith(words[0]) || name.includes(`.${words[0]}`)) return 0;
      return words.every((word) => name.includes(word)) ? 1 : 2;
    };
    const ranked = this.keys.map((key) => [rank(key), key]).filter(([r]) => r !== null);
    return ranked.sort((a, b) => a[0] - b[0]).slice(0, MOST_FOUND).map(([, key]) => key);
  }

  option({ key, description, unit, value }, k) {
    const now = typed(value);
    const shown = now.length > 24 ? `${now.slice(0, 23)}\u2026` : now;
    return make("li", { id: `found-${k}`, role: "option" }, make("b", {}, key), make("span", {}, shown ? `${shown} ${unit ?? ""}` : "not there"), make("small", {}, description ?? ""));
  }
}
