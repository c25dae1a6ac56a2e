// The page of a drop: its flight, and another one beside it. What the pages that a program serves share is
// exported.

import { find, Player, put } from "./player.js";
import { listen } from "./keys.js";
import { Run } from "./run.js";
import { fixed } from "./words.js";

export { costCss, css } from "./colors.js";
export { find, fixed, listen, Player, put, Run };

/** Lays the run of a file beside the page's own: a flight.csv or a drop.html. */
async function compare(player, file) {
  const chip = find("#comparison");
  try {
    const text = await file.text();
    const other = /^\s*</.test(text) ? Run.fromHtml(text) : Run.fromCsv(text, file.name);
    player.compare(other, "other run");
    const theirs = other.about.verdict?.j_tpf;
    const mine = player.about.verdict?.j_tpf;
    const gains = other.about.gains ? `, gains ${other.about.gains}` : "";
    const costs = theirs == null || mine == null ? "" : `: J_TPF ${fixed(theirs, 3)} there, ${fixed(mine, 3)} here`;
    put("#comparison-text", `compared with ${file.name} (${other.about.mission}${gains})${costs}`);
    chip.classList.remove("failed");
  } catch (error) {
    put("#comparison-text", `${file.name} cannot be compared: ${error.message}`);
    chip.classList.add("failed");
  }
  chip.hidden = false;
}

function dropPage(player) {
  const input = find("#file");
  find("#compare").addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    if (input.files[0]) compare(player, input.files[0]);
    input.value = "";
  });
  find("#comparison-end").addEventListener("click", () => {
    find("#comparison").hidden = true;
    player.compare(null);
  });
  const cover = find("#drop-here");
  let over = 0;
  addEventListener("dragenter", (event) => {
    if (![...(event.dataTransfer?.types ?? [])].includes("Files")) return;
    over++;
    cover.hidden = false;
  });
  addEventListener("dragleave", () => {
    over = Math.max(0, over - 1);
    if (over === 0) cover.hidden = true;
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    over = 0;
    cover.hidden = true;
    const file = event.dataTransfer?.files[0];
    if (file) compare(player, file);
  });
  listen(player, null, { c: () => input.click() });
  const asked = Number(new URLSearchParams(location.hash.slice(1)).get("t"));
  if (Number.isFinite(asked) && location.hash.includes("t=")) player.seek(asked);
}

const drop = find("#drop");
if (drop) {
  const player = new Player(Run.fromObject(JSON.parse(drop.textContent)));
  dropPage(player);
  /** For tests: what is shown. */
  window.replay = player;
}
