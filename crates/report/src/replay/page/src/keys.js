// Keys, the help that lists them, light and dark.

import { find } from "./player.js";
import { VIEWS } from "./scene.js";

const darkSystem = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme ?? (darkSystem.matches ? "dark" : "light")) === "dark";

/** The keys of a player, and those of the page around it. */
export function listen(player, onRecolor, ofPage = {}) {
  const recolor = () => {
    find("#theme").setAttribute("aria-pressed", String(isDark()));
    player.recolor();
    onRecolor?.();
  };
  const toggleTheme = () => {
    document.documentElement.dataset.theme = isDark() ? "light" : "dark";
    recolor();
  };
  find("#theme").addEventListener("click", toggleTheme);
  darkSystem.addEventListener("change", recolor);

  const help = find("#help");
  find("#help-open").addEventListener("click", () => help.showModal());

  const { plots } = player;
  const keys = {
    " ": () => player.play(),
    ArrowLeft: (event) => player.step(event.shiftKey ? -1 : -0.1),
    ArrowRight: (event) => player.step(event.shiftKey ? 1 : 0.1),
    Home: () => player.seek(player.motion.start),
    End: () => player.seek(player.motion.end),
    n: () => player.nextEvent(1),
    p: () => player.nextEvent(-1),
    "[": () => player.faster(-1),
    "]": () => player.faster(1),
    "+": () => plots.zoomBy(0.5),
    "-": () => plots.zoomBy(2),
    0: () => plots.zoom(...plots.full),
    m: () => player.zoomManoeuvre(),
    d: toggleTheme,
    "?": () => help.showModal(),
    ...Object.fromEntries(VIEWS.map((view, i) => [String(i + 1), () => player.look(view)])),
    ...ofPage,
  };
  // A button that was clicked, not reached by the keyboard, leaves the space key to the player.
  addEventListener("click", ({ detail, target }) => detail > 0 && target.closest("button, summary")?.blur());
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || find("dialog[open]")) return;
    const act = keys[event.key];
    if (!act || isOfTarget(event)) return;
    event.preventDefault();
    act(event);
    if (["ArrowLeft", "ArrowRight", "Home", "End"].includes(event.key)) document.body.classList.add("begun");
  });
}

/** Whether a key is meant for what has the focus: a text, a slider but that of the time, a choice; space for a
 * button. */
function isOfTarget({ key, target }) {
  if (target.matches("button, summary")) return key === " ";
  if (target.matches("input[type=range]")) return target.id !== "time" && key !== " ";
  return target.matches("input, select, textarea");
}
