/* Which input matters for which output: a matrix of rank correlations to choose from, the points, a tornado, indices. */

function showSensitivity(data) {
  const known = Object.fromEntries(Object.entries(data.numbers).map(([key, packed]) => [key, numbers(packed)]));
  const columns = data.inputs.length;
  const value = (name, row, column) => (known[name] ? known[name][row * columns + column] : NaN);
  const points = { outputs: data.points.outputs.map(numbers), inputs: data.points.inputs.map((x) => x && numbers(x)) };
  const chosen = { output: 0, input: 0 };
  const outputs = document.getElementById("output"), inputs = document.getElementById("input");
  const named = (x, at = "") => x.name + (x.unit ? ` (${x.unit})` : "") + at;
  const short = (x) => x.toFixed(2).replace(/^-(?=0\.00$)/, "").replace("-", "−"); // 0 has no sign
  const safe = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;").replace(/%\{/g, "%&#123;");

  offer(outputs, data.outputs.map((x) => named(x, x.at && `, ${x.at}`)));
  offer(inputs, data.inputs.map((x) => named(x)));
  const buttons = fillMatrix();
  outputs.addEventListener("change", () => choose(Number(outputs.value), chosen.input));
  inputs.addEventListener("change", () => choose(chosen.output, Number(inputs.value)));
  choose(0, 0);

  function fillMatrix() {
    const table = document.getElementById("matrix");
    const cell = (row, kind, text) => { const made = document.createElement(kind); made.textContent = text; row.append(made); return made; };
    const head = table.createTHead().insertRow();
    cell(head, "th", "");
    data.inputs.forEach((x) => { cell(head, "th", "").append(breakable(x.name)); });
    const body = table.createTBody();
    return data.outputs.map((output, n) => {
      const row = body.insertRow();
      cell(row, "th", "").append(breakable(output.name));
      return data.inputs.map((input, k) => {
        const r = value("rank_correlation", n, k), button = document.createElement("button");
        button.type = "button";
        button.textContent = Number.isFinite(r) ? short(r) : "–";
        button.setAttribute("aria-label", `${output.name} over ${input.name}: ${button.textContent}`);
        button.style.setProperty("--tint", r < 0 ? "var(--c1)" : "var(--c0)");
        button.style.setProperty("--weight", `${Math.round(55 * Math.abs(r) || 0)}%`);
        button.addEventListener("click", () => choose(n, k));
        const place = cell(row, "td", "");
        place.dataset.label = input.name;
        place.append(button);
        return button;
      });
    });
  }

  /** A name that may be broken behind its dots, as `breakable` in markup.py has it. */
  function breakable(name) {
    const parts = document.createDocumentFragment();
    name.split(/(?<=[._])(?=[a-z])/i).forEach((part, n) => parts.append(...(n ? [document.createElement("wbr"), part] : [part])));
    return parts;
  }

  function choose(output, input) {
    Object.assign(chosen, { output, input });
    outputs.value = output;
    inputs.value = input;
    buttons.forEach((row, n) => row.forEach((button, k) => button.setAttribute("aria-pressed", n === output && k === input)));
    scatter();
    tornado();
    if (document.getElementById("sobol")) sobol();
  }

  function caption(id, title, note) {
    const small = document.createElement("small");
    small.textContent = note;
    document.getElementById(id).replaceChildren(title, document.createElement("br"), small);
  }

  function scatter() {
    const { output: n, input: k } = chosen, x = points.inputs[k], y = points.outputs[n];
    const [r, low, high] = ["", "_low", "_high"].map((end) => value(`rank_correlation${end}`, n, k));
    const told = Number.isFinite(r) ? `rank correlation ${short(r)} (${short(low)} to ${short(high)}), ${data.outputs[n].runs.toLocaleString("en")} runs` : "no rank correlation";
    caption("scatter-caption", `${data.outputs[n].name} over ${data.inputs[k].name}`, told);
    const trace = {
      type: "scatter", mode: "markers", x: x || [], y: y || [], customdata: data.labels, marker: { size: 5, color: "--c0 55%" },
      hovertemplate: `run %{customdata}<br>%{x:.5~g} ${safe(data.inputs[k].unit)}<br>%{y:.5~g} ${safe(data.outputs[n].unit)}<extra></extra>`,
    };
    draw(document.getElementById("scatter"), [trace], {
      height: 340, hovermode: "closest", xaxis: { title: { text: safe(named(data.inputs[k])) } }, yaxis: { title: { text: safe(named(data.outputs[n])) } },
    });
  }

  /** The inputs with the largest value first, at most twelve, for bars from below upwards. */
  function strongest(name) {
    return data.inputs.map((_, k) => k).filter((k) => Number.isFinite(value(name, chosen.output, k)))
      .sort((a, b) => Math.abs(value(name, chosen.output, b)) - Math.abs(value(name, chosen.output, a))).slice(0, 12).reverse();
  }

  function bars(place, traces, own, count) {
    draw(document.getElementById(place), traces, {
      height: Math.max(340, 60 + 26 * count), hovermode: "closest", bargap: 0.35, ...own,
      yaxis: { type: "category", tickfont: { size: 11 }, nticks: 0 },
    });
  }

  function tornado() {
    const n = chosen.output, order = strongest("change"), unit = data.outputs[n].unit;
    const of = (name) => order.map((k) => value(name, n, k));
    caption("tornado-caption", `Change of the mean ${data.outputs[n].name}`, "from the lowest to the highest tenth of each input, the others varying; with 95 % intervals");
    const change = of("change"), half = of("change_high").map((x, m) => x - change[m]);
    const trace = {
      type: "bar", orientation: "h", x: change, y: order.map((k) => safe(data.inputs[k].name)), customdata: half,
      marker: { color: change.map((x) => (x < 0 ? "--c1 75%" : "--c0 75%")) }, error_x: { type: "data", array: half, color: "--quiet", thickness: 1.2, width: 3 },
      hovertemplate: `%{y}<br>%{x:.4~g} ± %{customdata:.2~g} ${safe(unit)}<extra></extra>`,
    };
    bars("tornado", [trace], { xaxis: { title: { text: safe(unit) } } }, order.length);
  }

  function sobol() {
    const n = chosen.output, total = "total_order" in data.numbers, order = strongest(total ? "total_order" : "first_order");
    caption("sobol-caption", `Sobol’ indices of ${data.outputs[n].name}`, `the part of its variance that an input explains alone${total ? ", and that takes the input" : ""}; with 95 % intervals`);
    const traces = [...(total ? [["total_order", "takes it", "--c4"]] : []), ["first_order", "alone", "--c0"]].map(([key, name, shade]) => {
      const x = order.map((k) => value(key, n, k)), half = order.map((k, m) => value(`${key}_high`, n, k) - x[m]);
      return {
        type: "bar", orientation: "h", name, x, y: order.map((k) => safe(data.inputs[k].name)), customdata: half, marker: { color: `${shade} 80%` },
        error_x: { type: "data", array: half, color: "--quiet", thickness: 1.2, width: 3 }, hovertemplate: `%{y}, ${name}<br>%{x:.3f} ± %{customdata:.2~g}<extra></extra>`,
      };
    });
    bars("sobol", traces, { showlegend: total, xaxis: { title: { text: "part of the variance" } } }, (total ? 2 : 1) * order.length);
  }
}
