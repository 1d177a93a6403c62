// Blocks that scroll sideways are reached by Tab, so that arrow keys move them.
(() => {
  const reach = () =>
    document.querySelectorAll(".highlight pre, .table-wrapper, .math-wrapper").forEach((block) => {
      if (block.scrollWidth > block.clientWidth) block.tabIndex = 0;
      else block.removeAttribute("tabindex");
    });
  addEventListener("load", reach);
  addEventListener("resize", reach);
})();
