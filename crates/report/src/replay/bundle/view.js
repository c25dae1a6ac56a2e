const show = (what) => (document.getElementById("answer").textContent = JSON.stringify(what, null, 1));
const post = (path, body) =>
  fetch(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });
const token = location.hash.slice(1);
const entered = token ? post("/enter", { token }) : Promise.resolve();
entered
  .then(() => history.replaceState(null, "", location.pathname))
  .then(() => post("/fly", { number: Date.now(), changes: {} }))
  .then((answer) => answer.json())
  .then(({ drop, ...rest }) => show(rest));
