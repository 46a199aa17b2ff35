// Puts the page together: replay, controls, state of the swarm, charts.
Swarm.start = function () {
  const run = JSON.parse(document.getElementById("run").textContent);
  const element = (id) => document.getElementById(id);
  const replay = new Swarm.Replay(run.replay);
  const view = new Swarm.views[run.view](element("arena"), replay, run.extra);
  const player = new Swarm.Player(replay, update);
  const charts = new Swarm.Charts(element("charts"), run.charts, (time) => player.seek(time));
  let isDrawn = true;

  function update() {
    element("scrubber").value = player.time;
    element("clock").textContent = `${player.time.toFixed(1)} s`;
    element("play").textContent = player.isPlaying ? "❚❚ pause" : "▶ play";
    charts.show(player.time);
    redraw();
  }

  // Several changes between two pictures of the screen are drawn once.
  function redraw() {
    if (!isDrawn) return;
    isDrawn = false;
    requestAnimationFrame(() => {
      isDrawn = true;
      if (!replay.frames) return;
      const frame = replay.frameAt(player.time);
      view.draw(frame);
      Swarm.showState(replay, frame, view.selected);
    });
  }

  Swarm.makeControls(element, player, replay);
  Swarm.makeLayers(element("layers"), view, redraw);
  Swarm.makeLegend(element("legend"), view);
  Swarm.makeAlerts(element("alerts"), replay, player);
  Swarm.makePointer(element("arena"), view, () => replay.frameAt(player.time), redraw);
  element("fit-arena").onclick = () => { view.fit(view.arena()); redraw(); };
  element("fit-shape").onclick = () => { view.fit(view.shapeBox(replay.frameAt(player.time))); redraw(); };
  new ResizeObserver(redraw).observe(element("arena"));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { Swarm.colors.clear(); redraw(); });
  window.swarmReport = { replay, view, player, charts };
  update();
};

Swarm.makeControls = function (element, player, replay) {
  const scrubber = element("scrubber"), speed = element("speed");
  scrubber.max = replay.duration;
  scrubber.oninput = () => player.seek(Number(scrubber.value));
  element("play").onclick = () => player.toggle();
  element("back").onclick = () => player.step(-1);
  element("forward").onclick = () => player.step(1);
  const speeds = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
  for (const factor of speeds) speed.append(new Option(`${factor} ×`, factor));
  const WATCHED_S = 20; // about as long as somebody watches a replay that they did not ask for
  player.speed = speeds.find((factor) => replay.duration / factor <= WATCHED_S) || speeds[speeds.length - 1];
  speed.value = player.speed;
  speed.onchange = () => { player.speed = Number(speed.value); };
  document.addEventListener("keydown", (event) => {
    if (["INPUT", "SELECT", "BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
    const actions = { " ": () => player.toggle(), ArrowLeft: () => player.step(-1), ArrowRight: () => player.step(1) };
    if (!actions[event.key]) return;
    event.preventDefault();
    actions[event.key]();
  });
};

Swarm.makeLayers = function (parent, view, redraw) {
  for (const [name, text] of view.layers) {
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: !view.hidden.has(name) });
    box.dataset.layer = name;
    box.onchange = () => {
      if (box.checked) view.hidden.delete(name);
      else view.hidden.add(name);
      redraw();
    };
    const label = document.createElement("label");
    label.append(box, " " + text);
    parent.append(label);
  }
};

Swarm.makeLegend = function (parent, view) {
  for (const [text, paint] of view.legend()) {
    const canvas = Object.assign(document.createElement("canvas"), { width: 52, height: 36 });
    const context = canvas.getContext("2d");
    context.scale(2, 2);
    paint(context);
    const item = document.createElement("li");
    item.append(canvas, text);
    parent.append(item);
  }
};

Swarm.makeAlerts = function (parent, replay, player) {
  for (const [frame, text] of replay.data.alerts) {
    const time = replay.timeOf(frame);
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: `${time.toFixed(1)} s` });
    button.onclick = () => player.seek(time);
    const item = document.createElement("li");
    item.append(button, text);
    parent.append(item);
  }
  if (!replay.data.alerts.length) parent.append(Object.assign(document.createElement("li"), { textContent: "none" }));
};

// Drag, wheel, and a click on a robot.
Swarm.makePointer = function (canvas, view, frameNow, redraw) {
  const at = (event) => [event.offsetX, event.offsetY];
  let from = null, hasMoved = false;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    [from, hasMoved] = [at(event), false];
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!from) return;
    const to = at(event), CLICK_PX = 4;
    if (!hasMoved && Math.hypot(to[0] - from[0], to[1] - from[1]) < CLICK_PX) return;
    hasMoved = true;
    view.drag(to[0] - from[0], to[1] - from[1]);
    from = to;
    redraw();
  });
  canvas.addEventListener("pointerup", (event) => {
    if (from && !hasMoved) view.selected = view.pick(at(event), frameNow());
    from = null;
    redraw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom(Math.exp(-event.deltaY * 0.0015), at(event));
    redraw();
  }, { passive: false });
};

// The table beside the replay: the selected robot, or the whole swarm.
Swarm.showState = function (replay, frame, robot) {
  const rows = robot === null ? Swarm.swarmState(replay, frame) : Swarm.robotState(replay, frame, robot);
  document.getElementById("state-title").textContent = robot === null ? "Swarm (click a robot)" : replay.data.names[robot];
  const body = document.createElement("tbody");
  for (const [name, value] of rows) {
    const row = body.insertRow();
    row.append(Object.assign(document.createElement("th"), { textContent: name }));
    row.insertCell().textContent = value;
  }
  document.querySelector("#state tbody").replaceWith(body);
};

Swarm.swarmState = function (replay, frame) {
  const counts = new Map();
  const add = (name) => counts.set(name, (counts.get(name) || 0) + 1);
  for (let robot = 0; robot < replay.robots; robot++) {
    if (!replay.isAlive(frame, robot)) { add("off"); continue; }
    const mode = replay.state("mode", frame, robot);
    if (mode !== undefined) add(mode < 0 ? "silent" : replay.data.modes[mode] || `mode ${mode}`);
    const positioning = replay.state("positioning", frame, robot);
    if (positioning > 0) add(`positioning: ${Swarm.POSITIONING[positioning]}`);
  }
  return [...counts.entries()].sort((one, other) => other[1] - one[1]);
};

Swarm.robotState = function (replay, frame, robot) {
  const meters = (point) => point.map((value) => value.toFixed(2)).join(", ") + " m";
  const apart = (one, other) => `${Math.hypot(...one.map((value, axis) => value - other[axis])).toFixed(2)} m`;
  const [truth, believed] = [replay.point("position", frame, robot), replay.point("estimate", frame, robot)];
  const rows = [];
  const mode = replay.state("mode", frame, robot), positioning = replay.state("positioning", frame, robot);
  if (!replay.isAlive(frame, robot)) rows.push(["mode", "off"]);
  else if (mode !== undefined) rows.push(["mode", mode < 0 ? "silent" : replay.data.modes[mode] || mode]);
  if (positioning >= 0) rows.push(["positioning", Swarm.POSITIONING[positioning]]);
  if (truth) rows.push(["position", meters(truth)]);
  if (truth && believed) rows.push(["estimate", meters(believed)], ["error", apart(believed, truth.slice(0, believed.length))]);
  const goal = replay.goalOf(frame, robot);
  if (goal && truth) rows.push(["goal", `number ${replay.state("goal", frame, robot)}, ${apart(goal, truth.slice(0, goal.length))} away`]);
  if (replay.links) {
    const others = replay.links.at(frame).filter((pair) => pair.includes(robot)).map(([a, b]) => (a === robot ? b : a));
    rows.push(["links", others.sort((a, b) => a - b).map((other) => replay.data.names[other] || "mission computer").join(" ") || "none"]);
  }
  return rows;
};

Swarm.start();
