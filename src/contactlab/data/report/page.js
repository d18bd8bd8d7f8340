"use strict";
// Sort a table by a column. Each run is a tbody of its own, so that its reason stays with it.
for (const table of document.querySelectorAll("table.sortable")) {
  const headings = [...table.querySelectorAll("thead th")];
  headings.forEach((heading, column) => {
    heading.querySelector("button")?.addEventListener("click", () => sort(table, headings, column));
  });
}

function sort(table, headings, column) {
  const up = headings[column].getAttribute("aria-sort") !== "ascending";
  headings.forEach((heading) => heading.removeAttribute("aria-sort"));
  headings[column].setAttribute("aria-sort", up ? "ascending" : "descending");
  const runs = [...table.querySelectorAll("tbody.run")];
  runs.sort((a, b) => compare(value(a, column), value(b, column), up ? 1 : -1));
  runs.forEach((run) => table.append(run));
}

function value(run, column) {
  const cell = run.rows[0].cells[column];
  const text = cell.dataset.value ?? cell.textContent;
  return text === "" || Number.isNaN(Number(text)) ? text : Number(text);
}

function compare(a, b, direction) {
  if (typeof a === typeof b) return direction * (a < b ? -1 : a > b ? 1 : 0);
  return typeof a === "number" ? -1 : 1; // what is missing comes last either way
}

for (const button of document.querySelectorAll("button[data-all]")) {
  const table = document.getElementById(button.dataset.all);
  button.addEventListener("click", () => {
    const all = table.classList.toggle("all");
    button.textContent = all ? "Show fewer columns" : "Show all columns";
  });
}
