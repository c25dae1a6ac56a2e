// A run's folder: its pages and its worst trials, each a click away.

import { Refused, Server } from "../view/server.js";

const find = (selector) => document.querySelector(selector);

function made(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

function trouble(text) {
  find("#trouble").textContent = text;
  find("#trouble").hidden = !text;
}

const link = (href, text) => made("a", { href, target: "_blank", rel: "noopener" }, text);

/** A table of the campaign's worst trials, each of which is flown again by its link. */
function worst({ worst: trials }, place) {
  const table = made("table", {}, made("thead"), made("tbody"));
  table.tHead.append(made("tr", {}, ...["worst trials", "J", "steady after"].map((text) => made("th", {}, text))));
  for (const { trial, j_tpf, steady_after_s } of trials) {
    const j = made("td", { className: j_tpf === null || j_tpf >= 1 ? "no" : "" }, j_tpf === null ? "lost" : j_tpf.toFixed(3));
    const steady = made("td", { className: steady_after_s === null ? "no" : "" });
    steady.append(steady_after_s === null ? "never" : `${steady_after_s.toFixed(2)} s`);
    const number = made("td", {}, link(`trial/${place}/${trial}`, `trial ${trial}`));
    table.tBodies[0].append(made("tr", {}, number, j, steady));
  }
  return table;
}

function show({ folder, lines, pages, campaigns }) {
  document.title = `${folder} \u2013 samara view`;
  find("#name").textContent = folder;
  find("#lines").replaceChildren(...lines.map((line) => made("li", {}, line)));
  find("#pages").replaceChildren(
    ...pages.map((name, place) => made("li", {}, link(`page/${place}`, name))),
    ...(pages.length ? [] : [made("li", {}, "there is no page in this folder")]),
  );
  for (const [place, campaign] of campaigns.entries()) {
    const { label, trials, unsafe_trials } = campaign;
    const told = `${unsafe_trials} of ${trials.toLocaleString("en")} trials were not safe. A trial is flown again when it is opened.`;
    find("#campaigns").append(made("h2", {}, label), made("p", {}, told), worst(campaign, place));
  }
}

const server = new Server((lost) => trouble(lost ? "The program does not answer." : ""));

async function begin() {
  try {
    await server.enter();
    show(await server.json("run"));
  } catch (error) {
    const closed = error instanceof Refused && error.status === 403;
    const how = "open the address that samara view printed.";
    trouble(closed ? `This page is open to the browser that the program's address was opened in: ${how}` : error.message);
  }
}
begin();
