// What the reader chooses, and the charts that follow.

const report = JSON.parse(document.getElementById("report").textContent);
const form = document.querySelector(".controls");
const state = { on: 0, log: 0, time: 0, version: 0 };
const arrays = await Arrays.read(report.arrays);
const charts = [...document.querySelectorAll("figure[data-chart]")].map((figure) => {
  const about = report.charts[figure.dataset.chart];
  return new (about.kind === "path" ? Path : Chart)(figure, about, arrays);
});
const inView = new Set();

function fillErrors() {
  for (const table of document.querySelectorAll("table.errors")) {
    for (const cell of table.querySelectorAll("td.now")) {
      const row = arrays.row(cell.dataset.array, state.on);
      cell.textContent = figures(row[table.dataset.horizon]);
    }
  }
}

function read() {
  const given = new FormData(form);
  state.on = given.getAll("switch").reduce((sum, place) => sum | (1 << place), 0);
  state.log = Number(given.get("log"));
  state.time = Number(given.get("time")) * (report.seconds[state.log] ?? 1);
  if (form.elements.now) form.elements.now.textContent = `${state.time.toFixed(2)} s`;
}

function follow() {
  const started = performance.now();
  read();
  state.version += 1;
  fillErrors();
  for (const chart of inView) chart.draw(state);
  queueMicrotask(() => performance.measure("follow", { start: started, end: performance.now() }));
}

function onInput(event) {
  if (event.target.name !== "time") return follow();
  read();
  for (const chart of inView) chart.point(state);
}

function onView(entries) {
  for (const { target, isIntersecting } of entries) {
    const chart = charts.find((one) => one.figure === target);
    if (isIntersecting) inView.add(chart);
    else inView.delete(chart);
    if (isIntersecting && chart.shown !== state.version) chart.draw(state);
  }
}

function again() {
  for (const chart of charts) chart.forget();
  follow();
}

const view = new IntersectionObserver(onView, { rootMargin: "200px" });
const sizes = new ResizeObserver((entries) => {
  for (const { target } of entries) charts.find((one) => one.plot === target).resize();
});
if (form) {
  form.addEventListener("input", onInput);
  form.addEventListener("submit", (event) => event.preventDefault());
  read();
  fillErrors();
}
for (const chart of charts) {
  view.observe(chart.figure);
  sizes.observe(chart.plot);
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
document.documentElement.dataset.ready = "yes";
