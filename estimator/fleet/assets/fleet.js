// Sorts the table by the column whose heading is pressed, and hides rows that lack a word.
(function () {
  "use strict";
  const table = document.getElementById("fleet");
  const body = table.tBodies[0];
  const headings = [...table.tHead.rows[0].cells];

  function value(row, column) {
    const cell = row.cells[column];
    return cell.dataset.v === undefined ? cell.textContent.trim() : Number(cell.dataset.v);
  }

  // Numbers before words, words before nothing, whichever way it is sorted.
  function compare(a, b, sign) {
    const rank = (x) => (typeof x === "number" ? 0 : x === "" ? 2 : 1);
    if (rank(a) !== rank(b)) return rank(a) - rank(b);
    if (typeof a === "number") return sign * (a - b);
    return sign * a.localeCompare(b, "en", { numeric: true });
  }

  headings.forEach((heading, column) => {
    heading.querySelector("button").addEventListener("click", () => {
      const descending = heading.getAttribute("aria-sort") === "ascending";
      for (const other of headings) other.setAttribute("aria-sort", "none");
      heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
      const rows = [...body.rows].map((row) => [value(row, column), row]);
      rows.sort((a, b) => compare(a[0], b[0], descending ? -1 : 1));
      body.append(...rows.map((row) => row[1]));
    });
  });

  const filter = document.getElementById("filter");
  filter.addEventListener("input", () => {
    const words = filter.value.toLowerCase();
    let shown = 0;
    for (const row of body.rows) {
      row.hidden = !row.textContent.toLowerCase().includes(words);
      shown += row.hidden ? 0 : 1;
    }
    document.getElementById("shown").textContent = shown + " of " + body.rows.length;
  });
})();
