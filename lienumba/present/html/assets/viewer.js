/* The page: unpacks its data and plotly.js, both compressed with gzip, and fills its places. */

async function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

function say(sentence) {
  const message = document.createElement("p");
  message.className = "message";
  message.textContent = sentence;
  document.querySelector("main").prepend(message);
}

function offerScenario() {
  const button = document.getElementById("save-scenario");
  if (!button) return;
  button.addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([document.getElementById("scenario-toml").textContent]));
    link.download = "scenario.toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

/** Fill a part of the page, of which these are the places; if that fails, a sentence stands there, and the rest goes on. */
async function part(places, what, fill) {
  try {
    await fill();
  } catch (error) {
    const message = document.createElement("p");
    message.className = "message";
    message.textContent = `${what} cannot be drawn here: ${error.message || error}.`;
    places[0].before(message);
    places.forEach((place) => place.remove());
  }
}

async function start() {
  followTheme();
  offerScenario();
  fitTables();
  if (!window.DecompressionStream) {
    say("The charts need a browser from 2023 or later: Chrome 80, Edge 80, Firefox 113, Safari 16.4, or newer.");
    return;
  }
  const library = document.createElement("script");
  library.textContent = await unpacked("library");
  document.head.append(library);
  const data = JSON.parse(await unpacked("data"));
  drawCharts(data.charts);
  if (data.sensitivity) await part(document.querySelectorAll("#sensitivity > .panels"), "This", () => showSensitivity(data.sensitivity));
  if (data.motion) await part(document.querySelectorAll("#motion > .stage"), "The mechanism", () => showMotion(data.motion));
  root.dataset.ready = "yes";
}

start();
