// Texts of a page with less contrast to what stands behind them than WCAG 2.2 AA asks for: 4.5 to 1, large ones 3 to 1.
() => {
  const parse = (text) => { const n = text.match(/[\d.]+/g).map(Number); return [n[0], n[1], n[2], n.length > 3 ? n[3] : 1]; };
  const over = (upper, lower) => [0, 1, 2].map((i) => upper[i] * upper[3] + lower[i] * (1 - upper[3]));
  const linear = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
  const luminance = (c) => 0.2126 * linear(c[0]) + 0.7152 * linear(c[1]) + 0.0722 * linear(c[2]);
  const grounds = (element) => { // from the text outwards, to the first that is opaque; a box of a drawing is a rectangle in the group
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const box = e instanceof SVGElement && e !== element ? e.querySelector(":scope > rect") : null;
      if (box) {
        const style = getComputedStyle(box), fill = style.fill === "none" ? [0, 0, 0, 0] : parse(style.fill);
        fill[3] *= style.fillOpacity * style.opacity;
        layers.push(fill);
      }
      layers.push(parse(getComputedStyle(e).backgroundColor));
      if (layers.some((c) => c[3] === 1)) break;
    }
    return layers;
  };
  const pale = [], texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  let measured = 0;
  while (texts.nextNode()) {
    const text = texts.currentNode.textContent.trim(), element = texts.currentNode.parentElement;
    if (!text || element.closest("script, style, noscript")) continue;
    if (!element.checkVisibility({ opacityProperty: true, visibilityProperty: true })) continue;
    const style = getComputedStyle(element), drawn = element instanceof SVGElement;
    const colour = parse(drawn ? style.fill : style.color);
    if (drawn) colour[3] *= style.fillOpacity;
    for (let e = element; e; e = e.parentElement) colour[3] *= getComputedStyle(e).opacity;
    const ground = grounds(element).reverse().reduce((lower, upper) => over(upper, lower), [255, 255, 255]);
    const [high, low] = [luminance(over(colour, ground)), luminance(ground)].sort((a, b) => b - a);
    const size = parseFloat(style.fontSize), large = size >= 24 || (size >= 18.66 && style.fontWeight >= 700);
    const ratio = (high + 0.05) / (low + 0.05);
    measured += 1;
    if (ratio < (large ? 3 : 4.5)) pale.push(`${text.slice(0, 40)}: ${ratio.toFixed(2)}, ${element.tagName} ${element.className}`);
  }
  return { measured, pale };
}
