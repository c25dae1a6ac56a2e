// What is asked of the program that serves the page.

/** How long a program that does not answer is left alone [ms]. */
const AGAIN_MS = 1000;
/** The longest that a tab which another one has overtaken waits [ms]: each another time, so that they part. */
const APART_MS = 400;

export const wait = (ms) => new Promise((done) => setTimeout(done, ms));

/** An answer that says no, in the program's words. */
export class Refused extends Error {
  constructor(status, { error, key }) {
    super(error ?? `the program answers ${status}`);
    Object.assign(this, { status, key: key ?? null });
  }
}

export class Server {
  /** `onLost` hears whether the program answers, each time that this changes. */
  constructor(onLost) {
    Object.assign(this, { onLost, lost: false, number: 0 });
  }

  /** Every question has a number, greater than those before, of other tabs too: the newest is answered. */
  next() {
    return (this.number = Math.max(this.number + 1, Date.now()));
  }

  /** Asks until there is an answer; one that says no is thrown. */
  async ask(path, body, signal) {
    for (;;) {
      const answer = await this.once(path, body, signal);
      if (answer?.ok) return answer;
      if (answer?.status === 409 && body?.number) {
        await wait(APART_MS * Math.random());
        body.number = this.next();
      } else if (answer) {
        const told = await answer.json().catch(() => ({}));
        throw new Refused(answer.status, told);
      } else {
        await wait(AGAIN_MS);
      }
    }
  }

  /** The answer, or nothing where there is no program. */
  async once(path, body, signal) {
    const headers = { "Content-Type": "application/json" };
    const post = body && { method: "POST", headers, body: JSON.stringify(body) };
    const answer = await fetch(path, { ...post, signal }).catch((error) => {
      if (error.name === "AbortError") throw error;
      return null;
    });
    if (this.lost !== (answer === null)) this.onLost((this.lost = answer === null));
    return answer;
  }

  /** Trades the token of the address for a cookie; the address is left without it. */
  async enter() {
    const token = location.hash.slice(1);
    if (!/^[0-9a-f]{32}$/.test(token)) return;
    history.replaceState(null, "", location.pathname);
    await this.ask("enter", { token });
  }

  async json(path, body, signal) {
    return (await this.ask(path, body, signal)).json();
  }

  /** Each line of an answer that comes bit by bit, as soon as it is there. */
  async lines(path, body, signal, onLine) {
    const reader = (await this.ask(path, body, signal)).body.getReader();
    const decoder = new TextDecoder();
    let rest = "";
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const parts = (rest + decoder.decode(value, { stream: true })).split("\n");
      rest = parts.pop();
      for (const line of parts) if (line) onLine(JSON.parse(line));
    }
  }
}
