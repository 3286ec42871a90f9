/* The mechanism in motion. Between the frames of a run, bodies turn by slerp and move along cubics. */

const QUIET = { displayModeBar: false, responsive: true, showTips: false, doubleClick: "reset" };
const INK = "#1d2125", DIM = "#5c646c", LINE = "#e3e4e0";

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

const motion = { time: 0, playing: false, speed: 1, first: 0, second: -1, drawn: false };

const ROOM = 1.2, NARROW_ROOM = 1.45, LOW = 0.05; // around the box for numbers, which are below it
const MANY = 20; // bodies or joints, whose marks and axes would hide them

const arrays = (thing, keys) => Object.fromEntries(keys.map((key) => [key, numbers(thing[key])]));

/** What moves, part by part: corners in m in the frame of its body, triangles, their colours; the last part stands still. */
function built(figure) {
  const { vertices, triangles, painted: paints } = arrays(figure, ["vertices", "triangles", "painted"]);
  let corner = 0, face = 0;
  const parts = figure.counts.map(([corners, faces], body) => {
    const column = (array, from, count, c, change) => Array.from({ length: count }, (_, n) => change(array[3 * (from + n) + c]));
    const [x, y, z] = [0, 1, 2].map((c) => column(vertices, corner, corners, c, (v) => v / 32767 * figure.radii[body]));
    const [i, j, k] = [0, 1, 2].map((c) => column(triangles, face, faces, c, (v) => v));
    const part = { body, x, y, z, i, j, k, paints: Array.from(paints.subarray(face, face + faces), (n) => figure.palette[n]) };
    corner += corners;
    face += faces;
    return part;
  });
  return { ...figure, parts: parts.filter((part) => part.i.length) };
}

/** A run with its arrays, ready to be posed. */
function opened(run, figures) {
  const { times, positions, quaternions } = arrays(run, ["times", "positions", "quaternions"]);
  const changing = run.places ? arrays(run, ["looks"]) : { places: [], looks: [], hits: [] };
  return { ...figures[run.figure], ...run, ...changing, times, positions, quaternions, bodies: positions.length / 3 / times.length };
}

/** The frame at or before a time, and how far it is to the next, 0 to 1. */
function between(times, t) {
  const last = times.length - 1;
  if (t >= times[last]) return [Math.max(last - 1, 0), last ? 1 : 0];
  let low = 0, high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return [low, Math.max((t - times[low]) / (times[high] - times[low]), 0)];
}

/** Coordinate c of the mass centre of body b: the cubic through two frames with the slopes of their neighbours. */
function along(run, b, c, i, u) {
  const { times: t, positions: p, bodies: k } = run;
  const last = t.length - 1, j = Math.min(i + 1, last);
  const at = (n) => p[(n * k + b) * 3 + c];
  if (i === j) return at(i);
  const slope = (n) => {
    const before = Math.max(n - 1, 0), behind = Math.min(n + 1, last);
    return (at(behind) - at(before)) / (t[behind] - t[before]);
  };
  const h = t[j] - t[i], w = 1 - u;
  return at(i) * w * w * (1 + 2 * u) + at(j) * u * u * (1 + 2 * w) + h * (slope(i) * u * w * w - slope(j) * u * u * w);
}

/** The unit quaternion w x y z of body b. */
function attitude(run, b, i, u) {
  const { quaternions: q, bodies: k, times: t } = run;
  const j = Math.min(i + 1, t.length - 1);
  const unit = (n) => {
    const x = Array.from(q.subarray((n * k + b) * 4, (n * k + b) * 4 + 4));
    const length = Math.hypot(...x);
    return x.map((e) => e / length);
  };
  const one = unit(i), other = unit(j);
  let cosine = one.reduce((sum, e, n) => sum + e * other[n], 0);
  const sign = cosine < 0 ? -1 : 1;
  cosine = Math.min(Math.abs(cosine), 1);
  const angle = Math.acos(cosine), sine = Math.sin(angle);
  const [a, c] = sine < 1e-6 ? [1 - u, u] : [Math.sin((1 - u) * angle) / sine, Math.sin(u * angle) / sine];
  return one.map((e, n) => a * e + sign * c * other[n]);
}

/** Position and rotation matrix, by rows, of each body at a time. */
function poses(run, t) {
  const [i, u] = between(run.times, t);
  return Array.from({ length: run.bodies }, (_, b) => {
    const [w, x, y, z] = attitude(run, b, i, u);
    return {
      r: [0, 1, 2].map((c) => along(run, b, c, i, u)),
      R: [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    };
  });
}

/** Where points [body, x, y, z] are; null is a gap in a line. */
function placed(points, pose) {
  const found = { x: [], y: [], z: [] };
  for (const point of points) {
    if (!point) { for (const key of "xyz") found[key].push(null); continue; }
    const [body, ...p] = point;
    const at = body < 0 ? p : [0, 3, 6].map((n, c) => pose[body].r[c] + pose[body].R[n] * p[0] + pose[body].R[n + 1] * p[1] + pose[body].R[n + 2] * p[2]);
    [..."xyz"].forEach((key, c) => found[key].push(at[c]));
  }
  return found;
}

const STILL = { r: [0, 0, 0], R: [1, 0, 0, 0, 1, 0, 0, 0, 1] }; // of the ground

/** The paths of the mass centres so far; of many bodies that of the last one. */
function trails(run, t) {
  const [i, u] = between(run.times, t);
  const stride = Math.ceil(run.times.length / 300);
  const bodies = run.seen.length > 12 ? run.seen.slice(-1) : run.seen;
  const found = { x: [], y: [], z: [] };
  for (const b of bodies) {
    for (let n = 0; n <= i; n += stride) [..."xyz"].forEach((key, c) => found[key].push(run.positions[(n * run.bodies + b) * 3 + c]));
    [..."xyz"].forEach((key, c) => found[key].push(along(run, b, c, i, u), null));
  }
  return found;
}

function crowded(run) {
  return run.bodies > MANY || run.marks.length > 2 * MANY;
}

function lines(run, kinds) {
  return run.segments.filter((x) => kinds.includes(x.kind)).flatMap((x) => [...x.ends, null]);
}

// How a switched constraint looks: locked, open, closed, sticking; and what was hit, for FLASH s of watching.
const LOOKS = [["diamond", "#b34a00", 6], ["circle-open", "#b34a00", 8], ["square", "#009e73", 6], ["cross", "#cc79a7", 5]];
const HIT = ["x", "#e69f00", 9], FLASH = 0.3;

/** Marks of what is locked, open, closed or hit; null where something else is. */
function changed(run, t, pose) {
  const [i, u] = between(run.times, t), frame = Math.min(i + Math.floor(u), run.times.length - 1), n = run.places.length;
  const hit = new Set(run.hits.filter(([at]) => at <= t && t < at + FLASH * motion.speed).map(([, m]) => m));
  const some = (test) => placed(run.places.map((place, m) => (test(m) ? place : null)), pose);
  return n ? [...LOOKS.map((_, look) => some((m) => run.looks[frame * n + m] === look + 1)), some((m) => hit.has(m))] : [];
}

/** The lines of a run at a time: arms and rods, axes, joints, trails, what changes. */
function strokes(run, t, pose) {
  const some = (things) => (crowded(run) ? [] : things);
  return [placed(lines(run, some(["arm"]).concat("rod")), pose), placed(lines(run, some(["axis"])), pose), placed(some(run.marks), pose), trails(run, t), ...changed(run, t, pose)];
}

const FLAT = { hoverinfo: "skip", showlegend: false };

function looksOfStrokes(run, faint) {
  const stroke = (name, width) => ({ ...FLAT, type: "scatter3d", mode: "lines", opacity: faint ? 0.35 : 1, line: { color: name, width } });
  return [
    stroke(DIM, run.marks.length > MANY ? 2 : 4),
    stroke(INK, run.marks.length > MANY ? 1.5 : 3),
    { ...FLAT, type: "scatter3d", mode: "markers", opacity: faint ? 0.35 : 1, marker: { size: run.marks.length > MANY ? 1.5 : 2.5, color: INK, line: { width: 0 } } },
    stroke(DIM, 2),
    ...(run.places.length ? [...LOOKS, HIT] : []).map(([symbol, color, size]) => ({
      ...FLAT, type: "scatter3d", mode: "markers", opacity: faint ? 0.35 : 1, marker: { symbol, size, color, line: { width: 0 } },
    })),
  ];
}

function lookOfPart(part, faint) {
  const { i, j, k, paints } = part;
  const colors = new Set(paints).size === 1 ? { color: paints[0] } : { facecolor: paints };
  return {
    ...FLAT, ...colors, type: "mesh3d", i, j, k, flatshading: true, opacity: faint ? 0.22 : 1,
    lighting: { ambient: 0.55, diffuse: 0.65, specular: 0.08, roughness: 0.9, fresnel: 0.05, facenormalsepsilon: 0 }, // of small triangles, too
  };
}

/** Two points that no one sees, so that plotly.js scales all coordinates alike and light falls on bodies as they turn. */
function frame(data, runs) {
  const far = Math.max(...[...data.low, ...data.high].map(Math.abs), ...runs.flatMap((run) => run.radii)), ends = [-far, far];
  return { ...FLAT, type: "scatter3d", mode: "markers", x: ends, y: ends, z: ends, marker: { size: 1, opacity: 0 }, meta: {} };
}

/** All traces of the runs that are shown, each with where it comes from. */
function drawn(data, runs, t) {
  return [frame(data, runs), ...runs.flatMap((run, n) => {
    const pose = poses(run, t), faint = n === 1, at = strokes(run, t, pose);
    const parts = run.parts.filter((part) => !faint || part.body < run.bodies);
    return [
      ...looksOfStrokes(run, faint).map((look, m) => ({ ...look, ...at[m], meta: { run: n, stroke: m } })),
      ...parts.map((part) => ({ ...lookOfPart(part, faint), x: part.x, y: part.y, z: part.z, meta: { run: n, part } })),
    ];
  })];
}

/** The matrix by columns, as WebGL has it, that moves a body whose coordinates plotly.js has scaled. */
function matrix({ r, R }, scale) {
  const at = (row, column) => (column < 3 ? scale[row] * R[3 * row + column] / scale[column] : scale[row] * r[row]);
  return Float32Array.from({ length: 16 }, (_, n) => (n % 4 === 3 ? Number(n === 15) : at(n % 4, n >> 2)));
}

function product(a, b) {
  return Float32Array.from({ length: 16 }, (_, n) => [0, 1, 2, 3].reduce((sum, k) => sum + a[4 * k + n % 4] * b[4 * (n >> 2) + k], 0));
}

/** Where on the screen, and how deep, a point x, y, z, 1 before the eye is. */
function seen(point, projection) {
  const [x, y, z, w] = [0, 1, 2, 3].map((row) => point.reduce((sum, p, k) => sum + projection[4 * k + row] * p, 0));
  return [x / w, y / w, z / w];
}

const LIGHT = [-1.5, 2, 1.5, 1]; // to the left of the eye, above it, behind it
const ANYWHERE = [[-1e6, -1e6, -1e6], [1e6, 1e6, 1e6]];

/** The corners of the cube that travels with runs: halfway between their mass centres, with room for each. */
function cube(runs, t) {
  const at = runs.map((run) => {
    const [i, u] = between(run.times, t);
    return [0, 1, 2].map((c) => run.shares.reduce((sum, share, b) => sum + share * along(run, b, c, i, u), 0));
  });
  const middle = [0, 1, 2].map((c) => (Math.min(...at.map((x) => x[c])) + Math.max(...at.map((x) => x[c]))) / 2);
  const apart = Math.max(...at.flatMap((x) => x.map((e, c) => Math.abs(e - middle[c]))));
  const half = apart + Math.max(...runs.map((run) => run.half));
  return { low: middle.map((x) => x - half), high: middle.map((x) => x + half) };
}

/** Let the view travel: its axes and what it hides are those of a cube about the runs at a time. */
function travel(stage, runs, t) {
  const { glplot, dataScale } = stage._fullLayout.scene._scene, { low, high } = cube(runs, t);
  low.forEach((x, c) => glplot.setBounds(c, { min: x * dataScale[c], max: high[c] * dataScale[c] }));
}

/** Draw the runs at a time. A body moves by the matrix with which the graphics card draws its mesh; its corners stay. */
function pose(stage, runs, t) {
  const { traces, dataScale } = stage._fullLayout.scene._scene;
  const at = runs.map((run) => poses(run, t)), lined = runs.map((run, n) => strokes(run, t, at[n]));
  stage.data.forEach(({ meta: { run, part, stroke } }, n) => {
    const full = stage._fullData[n], known = traces[full.uid];
    if (!known || run === undefined) return; // has nothing to draw, or never moves
    if (!part) {
      const { x, y, z } = lined[run][stroke];
      known.update({ ...full, x, y, z, _length: x.length });
      return;
    }
    const { mesh } = known;
    if (!mesh.placed) {
      const draw = mesh.draw;
      mesh.draw = mesh.drawTransparent = (given) => {
        if (part.body < runs[run].bodies) mesh.clipBounds = ANYWHERE; // which are of its corners before they are moved
        mesh.lightPosition = seen(LIGHT, given.projection); // which plotly.js takes back through all matrices
        draw.call(mesh, { ...given, model: product(given.model, mesh.placed) });
      };
    }
    mesh.placed = matrix(at[run][part.body] || STILL, dataScale);
    mesh.dirty = true;
  });
}

/** From how far along an eye direction a box of this aspect fills a place that is so many times as wide as high. */
function distance(eye, up, aspect, wide) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a.reduce((sum, x, n) => sum + x * b[n], 0), unit = (a) => a.map((x) => x / Math.hypot(...a));
  const toward = unit(eye), right = unit(cross(up, toward)), above = cross(toward, right), tangent = Math.tan(Math.PI / 8);
  const corners = Array.from({ length: 8 }, (_, n) => aspect.map((x, c) => (n >> c & 1 ? 0.5 : -0.5) * x));
  return Math.max(...corners.map((p) => dot(p, toward) + Math.max(Math.abs(dot(p, right)) / wide, Math.abs(dot(p, above))) / tangent));
}

function space({ low, high, eye, up }) {
  const extent = high.map((x, c) => x - low[c]), largest = Math.max(...extent);
  const narrow = innerWidth < 640, stage = document.getElementById("stage");
  const aspect = extent.map((x) => Math.max(x / largest, 0.02));
  const one = (title, c) => ({
    range: [low[c], high[c]], autorange: false, title: { text: `${title} (m)`, font: { size: narrow ? 10 : 12 } },
    tickfont: { size: narrow ? 9 : 11, color: DIM }, nticks: extent[c] > 0.35 * largest ? (narrow ? 4 : 6) : 3,
    gridcolor: LINE, zerolinecolor: LINE, linecolor: LINE, showbackground: false, showspikes: false, exponentformat: "power",
  });
  const near = (narrow ? NARROW_ROOM : ROOM) * distance(eye, up, aspect, stage.clientWidth / stage.clientHeight) / Math.hypot(...eye);
  const [x, y, z] = eye;
  return {
    paper_bgcolor: "rgba(0,0,0,0)", font: { color: INK }, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "kept",
    hovermode: false, showlegend: false,
    scene: {
      xaxis: one("x", 0), yaxis: one("y", 1), zaxis: one("z", 2), aspectmode: "manual", hovermode: false, dragmode: "orbit",
      aspectratio: Object.fromEntries([..."xyz"].map((key, c) => [key, aspect[c]])),
      camera: { eye: { x: x * near, y: y * near, z: z * near }, up: Object.fromEntries([..."xyz"].map((key, c) => [key, up[c]])), center: Object.fromEntries([..."xyz"].map((key, c) => [key, -LOW * up[c]])) },
    },
  };
}

async function showMotion(data) {
  if (!document.createElement("canvas").getContext("webgl")) throw new Error("the browser has no WebGL");
  const stage = document.getElementById("stage"), slider = document.getElementById("time");
  const clock = document.getElementById("clock"), play = document.getElementById("play");
  const figures = data.figures.map(built);
  const runs = data.runs.map((run) => opened(run, figures));
  const shown = () => [motion.first, motion.second].filter((n) => n >= 0).map((n) => runs[n]);
  const digits = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(data.duration || 1))));

  const followed = runs[0].shares !== undefined;
  const move = () => {
    if (followed) travel(stage, shown(), motion.time);
    pose(stage, shown(), motion.time);
    tell();
  };
  const view = () => (followed ? { ...data, ...cube(shown(), motion.time) } : data);
  const redraw = async () => {
    await Plotly.react(stage, drawn(data, shown(), motion.time), space(view()), QUIET);
    move();
  };
  const tell = () => {
    clock.textContent = data.cycles ? `${Math.round(360 * motion.time / data.duration)}°` : `${motion.time.toFixed(digits)} s`;
    if (document.activeElement !== slider || motion.playing) slider.value = motion.time;
    play.textContent = motion.playing ? "Pause" : "Play";
  };

  let before = 0, visible = false, ended = 0;
  const tick = (now) => {
    if (!motion.playing || !visible) return;
    const passed = Math.min((now - before) / 1000, 0.1);
    before = now;
    if (data.cycles) motion.time = (motion.time + passed * motion.speed) % data.duration;
    else if (motion.time < data.duration) motion.time = Math.min(motion.time + passed * motion.speed, data.duration);
    else if (!ended) ended = now;
    else if (now - ended > 900) { motion.time = 0; ended = 0; }
    move();
    requestAnimationFrame(tick);
  };
  const go = (on) => {
    motion.playing = on;
    before = performance.now();
    tell();
    if (on) requestAnimationFrame(tick);
  };

  const speeds = data.cycles ? [0.1, 0.25, 0.5, 1, 2, 4] : speedsFor(data.duration);
  const speed = document.getElementById("speed"), run = document.getElementById("run"), beside = document.getElementById("beside");
  offer(speed, speeds.map((x) => (x === 1 && !data.cycles ? "real time" : `${x} ×`)));
  speed.value = 3;
  motion.speed = speeds[3];
  offer(run, runs.map((x) => x.label));
  if (beside) {
    offer(beside, ["nothing", ...runs.map((x) => x.label)]);
    beside.value = data.compared ? data.compared + 1 : 0;
    motion.second = data.compared || -1;
    beside.addEventListener("change", () => { motion.second = Number(beside.value) - 1; redraw(); });
  }
  slider.max = data.duration;
  slider.step = "any";
  slider.addEventListener("input", () => { motion.time = Number(slider.value); go(false); move(); });
  speed.addEventListener("change", () => { motion.speed = speeds[Number(speed.value)]; });
  run.addEventListener("change", () => { motion.first = Number(run.value); redraw(); });
  play.addEventListener("click", () => { if (motion.time >= data.duration) motion.time = 0; go(!motion.playing); });

  await Plotly.newPlot(stage, drawn(data, shown(), motion.time), space(view()), QUIET);
  move();
  stage.dataset.drawn = "yes";
  tell();
  new IntersectionObserver(([entry]) => {
    visible = entry.isIntersecting;
    if (visible && motion.playing) go(true);
  }).observe(stage);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) go(true);
}

/** Speeds around the one at which a run takes some ten seconds, of numbers that people use. */
function speedsFor(duration) {
  const wanted = (duration || 1) / 10, power = 10 ** Math.floor(Math.log10(wanted));
  const nice = [1, 2, 5, 10].map((x) => x * power).reduce((a, b) => (Math.abs(Math.log(b / wanted)) < Math.abs(Math.log(a / wanted)) ? b : a));
  return [0.05, 0.2, 0.5, 1, 2, 5].map((x) => Number((x * nice).toPrecision(3)));
}
