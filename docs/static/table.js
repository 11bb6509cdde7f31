// Tables that their headings sort, and a form that filters their rows. Without JavaScript the whole table is shown.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
  const form = table.closest(".wide").previousElementSibling;

  const value = (row, column) => {
    const cell = row.cells[column];
    // errors are sorted by their absolute value
    return "value" in cell.dataset ? Math.abs(cell.dataset.value.replace("inf", "Infinity")) : cell.textContent;
  };
  const compare = (a, b) => {
    if (typeof a === "string") return a.localeCompare(b, undefined, {numeric: true});
    return Number.isNaN(a) || Number.isNaN(b) ? Number.isNaN(a) - Number.isNaN(b) : a === b ? 0 : a < b ? -1 : 1;
  };

  heads.forEach((head, column) => head.querySelector("button")?.addEventListener("click", () => {
    const down = head.ariaSort === "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.ariaSort = down ? "descending" : "ascending";
    const rows = [...body.rows];
    const missing = (row) => Number.isNaN(value(row, column));
    rows.sort((a, b) => (missing(a) - missing(b)) || compare(value(a, column), value(b, column)) * (down ? -1 : 1));
    body.append(...rows);
  }));

  const narrow = () => {
    const words = form.elements.words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const chosen = form.elements.chosen?.checked, verdict = form.elements.verdict?.value;
    for (const row of body.rows) {
      const text = `${row.textContent} ${row.dataset.words ?? ""}`.toLowerCase();
      const left = (chosen && !row.querySelector("input").checked) || (verdict && row.dataset.verdict !== verdict);
      row.hidden = !words.every((word) => text.includes(word)) || left;
    }
  };
  form.hidden = false;
  form.addEventListener("input", narrow);
  form.addEventListener("submit", (event) => event.preventDefault());
  body.addEventListener("input", narrow);
}
