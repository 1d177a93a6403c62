// Figures are drawn when they come near the screen, and all of them before printing.
"use strict";
const config = {
  displaylogo: false, responsive: true,
  showSendToCloud: false, plotlyServerURL: "", // Plotly offers to send the data to its makers; a report never does
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  toImageButtonOptions: { format: "svg" },
};
// On dark paper every colour of a figure becomes the one that stands for it there, tints (rgba) among them.
const darkOf = JSON.parse(document.getElementById("dark-colours").textContent);
const parts = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16)).join(",");
const tintOf = Object.fromEntries(Object.entries(darkOf).map(([light, dark]) => [parts(light), parts(dark)]));
const wantsDark = window.matchMedia("screen and (prefers-color-scheme: dark)");
function recoloured(json) {
  return json.replace(/"(#[0-9a-f]{6})"/g, (all, hex) => (hex in darkOf ? `"${darkOf[hex]}"` : all))
    .replace(/"rgba\((\d+,\d+,\d+),/g, (all, rgb) => (rgb in tintOf ? `"rgba(${tintOf[rgb]},` : all));
}
function draw(element, dark = wantsDark.matches) {
  const scheme = dark ? "dark" : "light";
  if (element.dataset.drawn === scheme) return;
  element.dataset.drawn = scheme;
  const json = document.getElementById(element.id + "-data").textContent;
  const spec = JSON.parse(dark ? recoloured(json) : json);
  Plotly.newPlot(element, spec.data, spec.layout, config).then(() => {
    if (spec.frames) Plotly.addFrames(element, spec.frames);
  });
}
if (typeof Plotly === "undefined" && document.getElementById("no-plotly")) document.getElementById("no-plotly").hidden = false;
const plots = typeof Plotly === "undefined" ? [] : [...document.querySelectorAll(".plot")];
const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); draw(entry.target); }
}, { rootMargin: "1200px" });
plots.forEach((p) => watcher.observe(p));
const drawAgain = () => plots.filter((p) => p.dataset.drawn).forEach((p) => draw(p));
wantsDark.addEventListener("change", drawAgain);
// On paper figures are light and nothing is folded.
let folded = [];
window.addEventListener("beforeprint", () => {
  plots.forEach((p) => draw(p, false));
  folded = [...document.querySelectorAll("details:not([open])")];
  folded.forEach((d) => { d.open = true; });
});
window.addEventListener("afterprint", () => { drawAgain(); folded.forEach((d) => { d.open = false; }); });
