for (const field of document.querySelectorAll("input.filter")) {
  const table = document.getElementById(field.dataset.table);
  field.addEventListener("input", () => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const run of table.querySelectorAll("tbody.run")) {
      const text = run.textContent.toLowerCase();
      run.hidden = !words.every((word) => text.includes(word));
    }
  });
}
// The plot shows the rows of the case that is chosen, of what is ticked.
const choices = document.querySelector(".explore form");
choices?.addEventListener("change", () => {
  const model = (name) => Bokeh.documents[0].get_model_by_name(name);
  const picked = choices.elements.case;
  const ticked = {};
  for (const box of choices.querySelectorAll("input")) {
    (ticked[box.name] ??= new Set());
    if (box.checked) ticked[box.name].add(box.value);
  }
  for (const name of ["front", "curves", "points"]) {
    const all = model(`${name}-all`).data;
    const rows = all.case.map((_, row) => row).filter((row) => all.case[row] === picked.value &&
      Object.entries(ticked).every(([key, values]) => !(key in all) || values.has(all[key][row])));
    model(`${name}-shown`).data = Object.fromEntries(
      Object.entries(all).map(([key, values]) => [key, rows.map((row) => values[row])]));
  }
  model("unclear").top = Number(picked.selectedOptions[0].dataset.clear);
  model("explore").reset.emit();
});
