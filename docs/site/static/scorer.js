// The search: pages written by hand before those made from declarations; excerpts without the letters of drawings.
var Scorer = {  // as searchtools.js of Sphinx looks for it
  score: ([page, , anchor, , score]) => {
    if (page.startsWith("papers/")) return score - 3;
    if (page.startsWith("generated/scenes/") && !anchor) return score - 2;
    return page.startsWith("generated/") ? score : score + 6;
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
document.addEventListener("DOMContentLoaded", () => {
  const text = Search.htmlToText;
  Search.htmlToText = (html, anchor) => text(html.replace(/<svg[\s\S]*?<\/svg>/g, ""), anchor);
});
