"use strict";
/* Colours. A colour in the data of a chart is the name of a custom property of the page, "--c0", or a share of it,
   "--c0 25%", so that charts follow the theme. */

const root = document.documentElement;
const probe = document.createElement("span");
const followers = []; // what draws itself again in other colours

function color(name) {
  const [property, share] = name.split(" ");
  probe.style.color = `var(${property})`;
  const found = getComputedStyle(probe).color;
  return share ? found.replace(/rgba?\(([^,]+),([^,]+),([^,)]+).*/, `rgba($1,$2,$3,${parseFloat(share) / 100})`) : found;
}

/** The same data with colours in place of their names. */
function painted(thing) {
  if (typeof thing === "string") return thing.startsWith("--") ? color(thing) : thing;
  if (Array.isArray(thing)) return thing.map(painted);
  if (thing === null || typeof thing !== "object" || ArrayBuffer.isView(thing)) return thing;
  return Object.fromEntries(Object.entries(thing).map(([key, value]) => [key, painted(value)]));
}

function isDark() {
  return (root.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light")) === "dark";
}

function followTheme() {
  const button = document.getElementById("theme");
  const say = () => { button.textContent = isDark() ? "Light" : "Dark"; };
  const change = () => { say(); followers.forEach((draw) => draw()); };
  button.addEventListener("click", () => { root.dataset.theme = isDark() ? "light" : "dark"; change(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", change);
  probe.hidden = true;
  document.body.append(probe);
  say();
}
