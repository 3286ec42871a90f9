() => {
  // What of the page, or of a chart in it, reaches beyond its place.
  const found = [], wide = document.documentElement.clientWidth;
  const apart = "nav, .scroll, .plot, script, select, details:not([open]) > :not(summary)";
  const isShown = (box) => box.width > 0 && box.height > 0;
  for (const element of document.querySelectorAll("body *")) {
    const texts = [...element.childNodes].filter((node) => node.nodeType === 3 && node.textContent.trim());
    if (!texts.length || element.closest(apart)) continue;
    const box = element.getBoundingClientRect();
    const inside = getComputedStyle(element).display === "inline" ? 0 : element.scrollWidth - element.clientWidth;
    if (isShown(box) && (box.left < -1 || box.right > wide + 1 || inside > 1))
      found.push(`${element.tagName}: ${element.textContent.slice(0, 60)}`);
  }
  for (const plot of document.querySelectorAll(".plot")) {
    const place = plot.getBoundingClientRect();
    for (const text of plot.querySelectorAll("svg text")) {
      const box = text.getBoundingClientRect();
      const over = [place.left - box.left, box.right - place.right, place.top - box.top, box.bottom - place.bottom];
      if (isShown(box) && Math.max(...over) > 3) found.push(`chart ${plot.dataset.chart || plot.id}: ${text.textContent}`);
    }
  }
  return found;
}
