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
