// A flight while it flies: its rows as they come.

import { Run } from "../main.js";

/** Most rows that are kept; of more the older half is forgotten. */
const MOST_ROWS = 60_000;
const FIRST_ROOM = 2_048;

export class Flight {
  /** `about`: what is known of it beforehand; `number`: which of the program's it is. */
  constructor(about, number) {
    Object.assign(this, { about, number, count: 0, room: FIRST_ROOM, marks: [] });
    this.columns = about.columns.map(() => new Float64Array(this.room));
  }

  /** Takes further rows; what there is none of is not a number. */
  take(rows) {
    for (const row of rows) {
      if (this.count === this.room) this.makeRoom();
      this.columns.forEach((column, k) => (column[this.count] = row[k] ?? NaN));
      this.count++;
    }
  }

  makeRoom() {
    const forgotten = this.room >= MOST_ROWS ? this.room >> 1 : 0;
    if (!forgotten) this.room *= 2;
    this.columns = this.columns.map((column) => {
      const next = new Float64Array(this.room);
      next.set(column.subarray(forgotten));
      return next;
    });
    this.count -= forgotten;
  }

  /** The flight so far; none before its first row. */
  run() {
    if (!this.count) return null;
    const columns = this.about.columns.map((name, k) => [name, this.columns[k].subarray(0, this.count)]);
    return Run.soFar(this.about, this.marks, Object.fromEntries(columns));
  }
}
