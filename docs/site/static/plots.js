// Buttons of Plotly's figures are for the mouse: Tab leads past them. A figure is named by the sentence above it.
(() => {
  const quiet = (node) => node.querySelectorAll?.(".modebar-btn, .modebar-btn *").forEach((button) => button.setAttribute("tabindex", "-1"));
  new MutationObserver((changes) => changes.forEach(({ target }) => quiet(target.parentElement ?? target))).observe(document.documentElement, {
    childList: true,
    subtree: true,
  });
  document.addEventListener("DOMContentLoaded", () => quiet(document));
})();
