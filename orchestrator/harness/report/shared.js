// What every page has: contents that stand in it as gzip, how Plotly is set, colours on dark paper.
"use strict";
// What stands in the page as gzip, as text or bytes; null where there is none.
async function unpacked(id, kind = "text") {
  const element = document.getElementById(id);
  if (!element) return null;
  const bytes = Uint8Array.from(atob(element.textContent), (c) => c.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")))[kind]();
}
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
