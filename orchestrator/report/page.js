// Figures are drawn when they come near the screen, and all of them before printing.
"use strict";
const config = {
  displaylogo: false, responsive: true,
  showSendToCloud: false, plotlyServerURL: "", // Plotly offers to send the data to its makers; a report never does
  modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"],
  toImageButtonOptions: { format: "svg" },
};
function draw(element) {
  if (element.dataset.drawn) return;
  element.dataset.drawn = "yes";
  const spec = JSON.parse(document.getElementById(element.id + "-data").textContent);
  Plotly.newPlot(element, spec.data, spec.layout, config).then(() => {
    if (spec.frames) Plotly.addFrames(element, spec.frames);
  });
}
const plots = [...document.querySelectorAll(".plot")];
const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) if (entry.isIntersecting) { watcher.unobserve(entry.target); draw(entry.target); }
}, { rootMargin: "1200px" });
plots.forEach((p) => watcher.observe(p));
window.addEventListener("beforeprint", () => plots.forEach(draw));
