/* The mechanism in motion. Between the frames of a run, bodies turn by slerp and move along cubics. */

const motion = { time: 0, playing: false, speed: 1, first: 0, second: -1, drawn: false };

const ROOM = 1.2, LOW = 0.05; // around the box for numbers, which are below it
const MANY = 20; // bodies or joints, whose marks and axes would hide them

/** A run with its arrays, ready to be posed. */
function opened(run) {
  const { times, positions, quaternions, vertices, owner, triangles, painted } = Object.fromEntries(
    ["times", "positions", "quaternions", "vertices", "owner", "triangles", "painted"].map((key) => [key, numbers(run[key])]));
  return { ...run, times, positions, quaternions, vertices, owner, triangles, painted, bodies: positions.length / 3 / times.length };
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

function solids(run, pose) {
  const count = run.owner.length;
  const found = { x: new Float64Array(count), y: new Float64Array(count), z: new Float64Array(count) };
  for (let n = 0; n < count; n += 1) {
    const { r, R } = pose[run.owner[n]];
    const [a, b, c] = run.vertices.subarray(3 * n, 3 * n + 3);
    found.x[n] = r[0] + R[0] * a + R[1] * b + R[2] * c;
    found.y[n] = r[1] + R[3] * a + R[4] * b + R[5] * c;
    found.z[n] = r[2] + R[6] * a + R[7] * b + R[8] * c;
  }
  return found;
}

/** The paths of the mass centres so far; of many bodies that of the last one. */
function trails(run, t) {
  const [i, u] = between(run.times, t);
  const stride = Math.ceil(run.times.length / 300);
  const bodies = run.bodies > 12 ? [run.bodies - 1] : Array.from({ length: run.bodies }, (_, b) => b);
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

/** What is drawn of a run at a time: solids, arms and rods, axes, joints, trails; and the fixed part of each. */
function shapes(run, t) {
  const pose = poses(run, t);
  const some = (things) => (crowded(run) ? [] : things);
  return [solids(run, pose), placed(lines(run, some(["arm"]).concat("rod")), pose), placed(lines(run, some(["axis"])), pose), placed(some(run.marks), pose), trails(run, t)];
}

function looks(run, faint) {
  const corner = (n) => run.triangles.filter((_, m) => m % 3 === n);
  const flat = { hoverinfo: "skip", showlegend: false };
  const stroke = (name, width) => ({ ...flat, type: "scatter3d", mode: "lines", opacity: faint ? 0.35 : 1, line: { color: name, width } });
  return [
    { ...flat, type: "mesh3d", i: corner(0), j: corner(1), k: corner(2), flatshading: true, opacity: faint ? 0.22 : 1,
      facecolor: Array.from(run.painted, (n) => `--${n % 2 ? "s" : "c"}${(n >> 1) % 7}`), lighting: { ambient: 0.55, diffuse: 0.65, specular: 0.08, roughness: 0.9, fresnel: 0.05 },
      lightposition: { x: 2000, y: -4000, z: 8000 } },
    stroke("--quiet", run.marks.length > MANY ? 2 : 4),
    stroke("--ink", run.marks.length > MANY ? 1.5 : 3),
    { ...flat, type: "scatter3d", mode: "markers", opacity: faint ? 0.35 : 1, marker: { size: run.marks.length > MANY ? 1.5 : 2.5, color: "--ink", line: { width: 0 } } },
    stroke("--quiet", 2),
  ];
}

/** From how far along an eye direction a box of this aspect fills a place that is so many times as wide as high. */
function distance(eye, up, aspect, wide) {
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a.reduce((sum, x, n) => sum + x * b[n], 0), unit = (a) => a.map((x) => x / Math.hypot(...a));
  const toward = unit(eye), right = unit(cross(up, toward)), above = cross(toward, right), tangent = Math.tan(Math.PI / 8);
  const corners = Array.from({ length: 8 }, (_, n) => aspect.map((x, c) => (n >> c & 1 ? 0.5 : -0.5) * x));
  return Math.max(...corners.map((p) => dot(p, toward) + Math.max(Math.abs(dot(p, right)) / wide, Math.abs(dot(p, above))) / tangent));
}

function space(data) {
  const extent = data.high.map((x, c) => x - data.low[c]), largest = Math.max(...extent);
  const narrow = innerWidth < 640, stage = document.getElementById("stage");
  const aspect = extent.map((x) => Math.max(x / largest, 0.02));
  const one = (title, c) => ({
    range: [data.low[c], data.high[c]], autorange: false, title: { text: `${title} (m)`, font: { size: narrow ? 10 : 12 } },
    tickfont: { size: narrow ? 9 : 11, color: "--quiet" }, nticks: extent[c] > 0.35 * largest ? (narrow ? 4 : 6) : 3,
    gridcolor: "--line", zerolinecolor: "--line", linecolor: "--line", showbackground: false, showspikes: false, exponentformat: "power",
  });
  const near = ROOM * distance(data.eye, data.up, aspect, stage.clientWidth / stage.clientHeight) / Math.hypot(...data.eye);
  const [x, y, z] = data.eye;
  return {
    paper_bgcolor: "rgba(0,0,0,0)", font: { family: FONT, color: "--ink" }, margin: { l: 0, r: 0, t: 0, b: 0 }, uirevision: "kept",
    hovermode: false, showlegend: false,
    scene: {
      xaxis: one("x", 0), yaxis: one("y", 1), zaxis: one("z", 2), aspectmode: "manual", hovermode: false, dragmode: "orbit",
      aspectratio: Object.fromEntries([..."xyz"].map((key, c) => [key, aspect[c]])),
      camera: { eye: { x: x * near, y: y * near, z: z * near }, up: Object.fromEntries([..."xyz"].map((key, c) => [key, data.up[c]])), center: Object.fromEntries([..."xyz"].map((key, c) => [key, -LOW * data.up[c]])) },
    },
  };
}

async function showMotion(data) {
  if (!document.createElement("canvas").getContext("webgl")) throw new Error("the browser has no WebGL");
  const stage = document.getElementById("stage"), slider = document.getElementById("time");
  const clock = document.getElementById("clock"), play = document.getElementById("play");
  const runs = data.runs.map(opened);
  const shown = () => [motion.first, motion.second].filter((n) => n >= 0).map((n) => runs[n]);
  const digits = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(data.duration || 1))));

  const all = () => shown().flatMap((run, n) => {
    const moved = shapes(run, motion.time);
    return looks(run, n === 1).map((look, m) => ({ ...look, ...moved[m] }));
  });
  const redraw = () => Plotly.react(stage, painted(all()), painted(space(data)), QUIET);
  const move = () => {
    const moved = shown().flatMap((run) => shapes(run, motion.time));
    Plotly.restyle(stage, Object.fromEntries([..."xyz"].map((key) => [key, moved.map((x) => x[key])])), moved.map((_, n) => n));
    tell();
  };
  const tell = () => {
    clock.textContent = `${motion.time.toFixed(digits)} s`;
    if (document.activeElement !== slider || motion.playing) slider.value = motion.time;
    play.textContent = motion.playing ? "Pause" : "Play";
  };

  let before = 0, visible = false, ended = 0;
  const tick = (now) => {
    if (!motion.playing || !visible) return;
    const passed = Math.min((now - before) / 1000, 0.1);
    before = now;
    if (motion.time < data.duration) motion.time = Math.min(motion.time + passed * motion.speed, data.duration);
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

  const speeds = speedsFor(data.duration);
  const speed = document.getElementById("speed"), run = document.getElementById("run"), beside = document.getElementById("beside");
  offer(speed, speeds.map((x) => (x === 1 ? "real time" : `${x} ×`)));
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
  followers.push(redraw);

  await Plotly.newPlot(stage, painted(all()), painted(space(data)), QUIET);
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
