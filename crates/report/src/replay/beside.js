// Takes the run that the page holds beside its own as if it had been chosen by hand.
{
  const held = document.getElementById("beside");
  const page = `<script id="drop" type="application/json">${held.textContent}<\/script>`;
  const files = new DataTransfer();
  files.items.add(new File([page], held.dataset.name));
  const chosen = document.getElementById("file");
  chosen.files = files.files;
  chosen.dispatchEvent(new Event("change"));
}
