/* Charts: drawn when they come near the screen, again when the theme changes, and as wide as their place. */

const FONT = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', sans-serif";
const QUIET = { displayModeBar: false, responsive: true, showTips: false, doubleClick: "reset" };
const touch = matchMedia("(pointer: coarse)");

function axis(own) {
  return {
    gridcolor: "--grid", linecolor: "--line", zerolinecolor: "--line", tickcolor: "--line", ticks: "outside", ticklen: 4,
    tickfont: { color: "--quiet" }, automargin: true, nticks: innerWidth < 640 ? 5 : 6, exponentformat: "power", ...own,
    title: { text: "", standoff: 8, font: { size: 12, color: "--quiet" }, ...(own && own.title) },
  };
}

function layout(own) {
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { family: FONT, size: 12, color: "--ink" },
    margin: { l: 12, r: 14, t: 10, b: 8 }, hovermode: "x unified", dragmode: touch.matches ? false : "zoom",
    hoverlabel: { bgcolor: "--card", bordercolor: "--line", font: { family: FONT, size: 12, color: "--ink" }, namelength: -1 },
    showlegend: false,
    legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom", font: { size: 12 }, tracegroupgap: 0 },
    ...own, xaxis: axis({ tickangle: 0, ...own.xaxis }), yaxis: axis(own.yaxis),
  };
}

/** Draw a chart in its place; it stays in the colours of the page. */
function draw(place, traces, own) {
  const known = place.isDrawn;
  place.isDrawn = () => Plotly.react(place, painted(traces), painted(layout(own)), QUIET);
  if (!known) {
    place.style.height = `${own.height || 260}px`;
    followers.push(() => place.isDrawn());
  }
  return place.isDrawn();
}

/** Draw each chart of the data when its place comes near the screen. */
function drawCharts(charts) {
  const seen = new IntersectionObserver((entries) => {
    for (const entry of entries.filter((x) => x.isIntersecting)) {
      seen.unobserve(entry.target);
      const chart = charts[entry.target.dataset.chart];
      part([entry.target], "This chart", () => draw(entry.target, chart.traces, chart.layout));
    }
  }, { rootMargin: "500px" });
  for (const place of document.querySelectorAll("[data-chart]")) {
    place.style.height = `${charts[place.dataset.chart].layout.height || 260}px`;
    seen.observe(place);
  }
}

/** The options of a select. */
function offer(select, texts) {
  select.replaceChildren(...texts.map((text, n) => new Option(text, n)));
}

/** An array of numbers as the data have it: {dtype, bdata}, as in plotly.js. */
function numbers(packed) {
  const kinds = { f8: Float64Array, f4: Float32Array, i2: Int16Array, u2: Uint16Array, u4: Uint32Array };
  const bytes = Uint8Array.from(atob(packed.bdata), (c) => c.charCodeAt(0));
  return new kinds[packed.dtype](bytes.buffer);
}

function figure(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits))).replace("-", "−").replace(/e\+?/, "e");
}
