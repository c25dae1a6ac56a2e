// The page of a flight while it flies: the scene and the panels grow with it, the link is told beside them, and
// at its end it is the page of the drop. What has come stays, whatever becomes of the program.

import { find, fixed, listen, Player, put, Run } from "../main.js";
import { Refused, Server, wait } from "../view/server.js";
import { Flight } from "./flight.js";

/** So often what has come is drawn [ms]; between that the time goes on. */
const GROW_EVERY_MS = 100;
/** Most events that are listed. */
const MOST_LISTED = 2_000;
/** A program whose answer has broken off is asked again after so long [ms]. */
const AGAIN_MS = 1_000;

class Live {
  constructor() {
    Object.assign(this, { flight: null, player: null, fresh: false, grown: false, grewAt: 0, end: null });
    find("#follow").addEventListener("click", () => this.player?.follow());
  }

  // ---- what comes ----

  /** All is told anew. */
  restart() {
    find("#happened").replaceChildren();
    this.flight = null;
  }

  take(line) {
    if (line.flight) this.begins(line.flight, line.number);
    else if (line.rows) this.flight?.take(line.rows);
    else if (line.event) this.happens(line.event, line.of);
    else if (line.state) this.tell(line.state);
    else if (line.missed) this.misses(line.missed);
    else if (line.end) this.ends(line.end);
    this.grown = true;
  }

  begins(about, number) {
    if (this.flight && this.flight.number !== number) this.list({ text: "the flight begins anew" });
    this.flight = new Flight(about, number);
    this.fresh = true;
    document.title = `${about.mission} \u2013 live`;
    put("#name", about.mission);
    put("#facts", about.facts);
    put("#verdict", "Waiting for the flight\u2026");
  }

  happens(event, of) {
    if (event.listed) this.list(event);
    if (event.mark && of === this.flight?.number) this.flight.marks.push({ ...event, short: event.text });
  }

  /** Lists something, the newest first. */
  list({ t_s, text, warning }) {
    const list = find("#happened");
    const item = document.createElement("li");
    if (warning) item.className = "warning";
    if (t_s != null) item.append(Object.assign(document.createElement("time"), { textContent: `${fixed(t_s, 2)} s` }));
    item.append(text);
    list.prepend(item);
    if (list.children.length > MOST_LISTED) list.lastChild.remove();
  }

  misses({ rows, events }) {
    const of = [[rows, "instants"], [events, "events"]].filter(([n]) => n).map(([n, what]) => `${n} ${what}`);
    this.list({ text: `${of.join(" and ")} came too fast for this page, or before it`, warning: true });
  }

  /** What is known of the link: names, words and since when. */
  tell(known) {
    const list = find("#state");
    const cells = () => [document.createElement("dt"), document.createElement("dd")];
    if (list.children.length !== 2 * known.length) list.replaceChildren(...known.flatMap(cells));
    known.forEach(([name, words, t_s], k) => {
      const texts = [t_s == null ? name : `${name}, ${fixed(t_s, 1)} s`, words];
      texts.forEach((text, i) => {
        const cell = list.children[2 * k + i];
        // What stays is left alone: somebody may be marking it.
        if (cell.textContent !== text) cell.textContent = text;
      });
    });
  }

  ends(end) {
    this.end = end;
    if (end.drop) this.becomes(Run.fromObject(end.drop));
    else this.grow();
    if (this.player) {
      this.player.run.goesOn = false;
      this.player.play(false);
    }
    document.body.classList.add("over");
    find("#follow").disabled = true;
    find("#follow").setAttribute("aria-pressed", "false");
    const verdict = find("#verdict");
    if (end.words) {
      verdict.innerHTML = end.words.verdict;
      for (const name of ["numbers", "facts", "table"]) find(`#${name}`).innerHTML = end.words[name];
    } else {
      verdict.textContent = end.text ?? "The program has ended.";
    }
    verdict.className = `verdict ${end.safe == null ? "open" : end.safe ? "" : "no"}`;
    this.list({ text: "the flight is over, and the program at its end; this page keeps what it has" });
  }

  // ---- what is drawn ----

  begin(run) {
    this.player = new Player(run);
    this.player.onFrame = () => this.frame();
    const follow = () => this.player.follow();
    const toEnd = () => (this.end ? this.player.seek(this.player.motion.end) : follow());
    listen(this.player, null, { l: toEnd, End: toEnd });
    /** For tests: what is shown. */
    window.replay = this.player;
  }

  /** Another run in place of the one that is drawn. */
  becomes(run) {
    if (!this.player) return this.begin(run);
    const { time, follows } = this.player;
    this.player.open(run);
    this.player.seek(follows ? run.motion.end : time);
  }

  grow() {
    const run = this.flight?.run();
    if (!run) return;
    this.grown = false;
    if (!this.player || this.fresh) {
      this.becomes(run);
      this.fresh = false;
      this.player.follow();
    } else {
      this.player.grow(run);
    }
    const free = run.about.times.released_s !== null;
    put(".axis", free ? "time since the rotors were freed [s]" : "time since the simulation began [s]");
    put("#verdict", "Flying, live.");
  }

  frame() {
    const now = performance.now();
    if (!this.grown || this.end || now - this.grewAt < GROW_EVERY_MS) return;
    this.grewAt = now;
    this.grow();
    find("#follow").setAttribute("aria-pressed", String(this.player.follows));
  }
}

const live = new Live();
/** For tests: what has come. */
window.live = live;

function trouble(text) {
  document.body.classList.toggle("lost", !!text);
  put("#trouble", text);
  find("#trouble").hidden = !text;
}

const GONE = "The program does not answer: it has ended, or the way to it is cut. What has come so far stays here, and this page goes on as soon as it answers.";

const server = new Server((lost) => trouble(lost ? GONE : ""));

/** Looks on until the flight's end, however often the way to the program is cut. */
async function look() {
  await server.enter();
  while (!live.end) {
    let first = true;
    const take = (line) => {
      if (first) {
        trouble("");
        live.restart();
      }
      first = false;
      live.take(line);
      // Without a player there are no frames yet.
      if (!live.player) live.grow();
    };
    try {
      await server.lines("flight", undefined, undefined, take);
    } catch (error) {
      if (error instanceof Refused) throw error;
    }
    if (!live.end) {
      trouble(GONE);
      await wait(AGAIN_MS);
    }
  }
}

look().then(
  () => trouble(""),
  (error) => {
    const text = error.status === 403 ? "This page is open to the browser that the program's address was opened in: open the address that samara printed." : error.message;
    trouble(text);
  },
);
