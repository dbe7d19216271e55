// Search and filters of the index of benchmarks. Without it the table shows every row.
"use strict";
(function () {
  const rows = Array.from(document.querySelectorAll("tr[data-status]"));
  const control = (name) => document.getElementById(name);
  const search = control("search"), method = control("method"), source = control("source"), status = control("status");
  const shown = () => rows.filter((row) => !row.hidden);

  function filter() {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of rows) {
      const text = row.textContent.toLowerCase();
      const is = (select, name) => !select.value || row.dataset[name] === select.value;
      const from = !source.value || row.dataset.sources.split("|").includes(source.value);
      row.hidden = !(words.every((word) => text.includes(word)) && is(method, "method") && is(status, "status") && from);
    }
    control("count").textContent = shown().length + " of " + rows.length + " shown";
  }

  // The next row of a state below the top of the window, from the first again after the last.
  function jump(state) {
    const wanted = shown().filter((row) => row.dataset.status === state);
    const bar = document.querySelector(".tools").getBoundingClientRect().height;
    const next = wanted.find((row) => row.getBoundingClientRect().top > bar + 4) || wanted[0];
    if (next) window.scrollBy(0, next.getBoundingClientRect().top - bar - 2);
  }

  for (const one of [search, method, source, status]) one.addEventListener("input", filter);
  for (const state of ["fail", "open"]) {
    const button = control("next-" + state);
    if (button) button.addEventListener("click", () => jump(state));
  }
  document.querySelector(".tools").hidden = false;
  filter();
})();
