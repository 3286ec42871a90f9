/* Tables. Where one is wider than its place its words wrap, and where that is not enough each row becomes a card. */

const SHAPES = ["plain", "tight", "cards"];

function fit(place) {
  if (!place.clientWidth) return; // it is folded
  for (const shape of SHAPES) {
    place.dataset.shape = shape;
    if (place.scrollWidth <= place.clientWidth) return;
  }
}

function fitTables() {
  const seen = new ResizeObserver((found) => requestAnimationFrame(() => found.forEach((one) => fit(one.target))));
  document.querySelectorAll(".scroll").forEach((place) => seen.observe(place));
}
