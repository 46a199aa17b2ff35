// The swarm from above. World frame: x right, y up; pixels: y down.
Swarm.views.plane = class {
  constructor(canvas, replay, extra) {
    Object.assign(this, { canvas, replay, extra, context: canvas.getContext("2d") });
    this.selected = null;
    const { data } = replay;
    this.layers = [
      ["circles", extra.cell ? "hulls" : "coverage circles", true],
      ["shape", "shape", extra.cells || data.shape.frames.length],
      ["goals", "goals", data.goals.frames.length],
      ["paths", "paths", data.paths.length],
      ["trails", "trails", true],
      ["links", "radio links", replay.links],
      ["estimates", "estimated positions", replay.fields.estimate],
      ["obstacles", "obstacles", data.obstacles.length],
      ["names", "names", true],
    ].filter(([, , isThere]) => isThere); // what a run did not record cannot be switched on
    this.hidden = new Set(["names"]);
    this.fit(this.arena());
  }

  arena() {
    const bounds = this.replay.data.bounds;
    const box = bounds ? [...bounds] : [Infinity, Infinity, -Infinity, -Infinity];
    for (let robot = 0; robot < this.replay.robots; robot++) {
      for (const frame of [0, this.replay.frames - 1]) Swarm.widen(box, this.replay.point("position", Math.max(frame, 0), robot));
    }
    return box;
  }

  shapeBox(frame) {
    const points = this.replay.pointsAt(this.replay.data.shape, frame);
    if (!points.length) return this.arena();
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    points.forEach((point) => Swarm.widen(box, point));
    return box;
  }

  fit([left, low, right, high]) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    this.scale = 0.94 * Math.min(width / Math.max(right - left, 0.1), height / Math.max(high - low, 0.1));
    this.center = [(left + right) / 2, (low + high) / 2];
  }

  pixel([x, y]) {
    return [
      this.canvas.clientWidth / 2 + (x - this.center[0]) * this.scale,
      this.canvas.clientHeight / 2 - (y - this.center[1]) * this.scale,
    ];
  }

  world([x, y]) {
    return [
      this.center[0] + (x - this.canvas.clientWidth / 2) / this.scale,
      this.center[1] - (y - this.canvas.clientHeight / 2) / this.scale,
    ];
  }

  zoom(factor, at) {
    const fixed = this.world(at);
    this.scale = Math.max(0.5, Math.min(2000, this.scale * factor));
    const moved = this.world(at);
    this.center = [this.center[0] + fixed[0] - moved[0], this.center[1] + fixed[1] - moved[1]];
  }

  drag(dx, dy) {
    this.center = [this.center[0] - dx / this.scale, this.center[1] + dy / this.scale];
  }

  // The robot at a pixel, null if there is none.
  pick(at, frame) {
    let best = null, least = Infinity;
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const point = this.replay.point("position", frame, robot);
      if (!point) continue;
      const [x, y] = this.pixel(point);
      const distance = Math.hypot(x - at[0], y - at[1]);
      if (distance < least && distance <= Math.max(8, this.replay.data.radius[robot] * this.scale)) [best, least] = [robot, distance];
    }
    return best;
  }

  shows(layer) { return !this.hidden.has(layer); }

  draw(frame) {
    const { canvas, context } = this, ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    this.drawGround(frame);
    if (this.shows("links")) this.drawLinks(frame);
    if (this.shows("paths")) this.drawPaths(frame);
    if (this.shows("trails")) this.drawTrails(frame);
    if (this.shows("goals")) this.drawGoals(frame);
    this.drawDocks(frame);
    if (this.shows("circles")) this.drawRobots(frame);
    if (this.shows("estimates")) this.drawEstimates(frame);
    if (this.shows("names")) this.drawNames(frame);
    this.drawScaleBar();
  }

  outline(points, color, width, options) {
    Swarm.marks.line(this.context, points.map((point) => this.pixel(point)), color, width, { isClosed: true, ...options });
  }

  drawGround(frame) {
    const { data } = this.replay;
    if (data.bounds) {
      const [left, low, right, high] = data.bounds;
      this.outline([[left, low], [right, low], [right, high], [left, high]], Swarm.color("line"), 1);
    }
    if (this.shows("shape")) {
      const shape = this.replay.pointsAt(data.shape, frame);
      this.outline(shape, Swarm.color("shape-edge"), 1.5, { fill: Swarm.color("shape-fill") });
      for (const [x, y] of this.extra.cells || []) {
        const half = this.extra.cell / 2;
        const corners = [[x - half, y - half], [x + half, y - half], [x + half, y + half], [x - half, y + half]];
        this.outline(corners, Swarm.color("shape-edge"), 1, { fill: Swarm.color("shape-fill") });
      }
    }
    if (this.shows("obstacles")) {
      for (const corners of data.obstacles) this.outline(corners, Swarm.color("wall-edge"), 1, { fill: Swarm.color("wall") });
    }
    if (data.mission_position) {
      const [x, y] = this.pixel(data.mission_position);
      Swarm.marks.line(this.context, [[x, y - 7], [x + 6, y + 5], [x - 6, y + 5]], Swarm.color("mission"), 2, { isClosed: true });
    }
  }

  place(node, frame) {
    return node < this.replay.robots ? this.replay.point("position", frame, node) : this.replay.data.mission_position || null;
  }

  drawPairs(pairs, frame, color, width, alpha) {
    for (const [a, b] of pairs) {
      const [from, to] = [this.place(a, frame), this.place(b, frame)];
      if (from && to) Swarm.marks.line(this.context, [this.pixel(from), this.pixel(to)], color, width, { alpha });
    }
  }

  drawLinks(frame) {
    if (!this.replay.links) return;
    const pairs = this.replay.links.at(frame);
    const alpha = Math.max(0.06, Math.min(0.3, 60 / pairs.length)); // many links must not hide the robots
    this.drawPairs(pairs, frame, Swarm.color("link"), 1, alpha);
  }

  drawDocks(frame) {
    if (this.replay.docks) this.drawPairs(this.replay.docks.at(frame), frame, Swarm.color("mission"), 5, 1);
  }

  // Paths from where the robot is to its way-points that it has not passed yet.
  drawPaths(frame) {
    this.replay.data.paths.forEach((changes, robot) => {
      const points = this.replay.pointsAt(changes, frame);
      const from = this.replay.point("position", frame, robot);
      if (!from || !points.length || !this.replay.isAlive(frame, robot)) return;
      const line = [from, ...Swarm.ahead(from, points)].map((point) => this.pixel(point));
      Swarm.marks.line(this.context, line, Swarm.typeColor(this.replay, robot), 1.2, { dash: [5, 4], alpha: 0.8 });
    });
  }

  drawTrails(frame) {
    const step = Math.max(1, Math.floor(frame / 400));
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const points = [];
      for (let past = 0; past <= Math.floor(frame); past += step) points.push(this.replay.point("position", past, robot));
      points.push(this.replay.point("position", frame, robot));
      const line = points.filter(Boolean).map((point) => this.pixel(point));
      Swarm.marks.line(this.context, line, Swarm.typeColor(this.replay, robot), 1, { alpha: 0.35 });
    }
  }

  drawGoals(frame) {
    for (const goal of this.replay.pointsAt(this.replay.data.goals, frame)) {
      const [x, y] = this.pixel(goal);
      Swarm.marks.cross(this.context, x, y, 4, Swarm.color("goal"));
    }
  }

  look(frame, robot) {
    const { data } = this.replay;
    return {
      color: Swarm.typeColor(this.replay, robot),
      isAlive: this.replay.isAlive(frame, robot),
      isSelected: robot === this.selected,
      isSquare: Boolean(this.extra.cell),
      yaw: this.replay.yaw(frame, robot),
      carriesSensor: Boolean(data.carries_sensor && data.carries_sensor[robot]),
      positioning: this.replay.state("positioning", frame, robot) || 0,
    };
  }

  drawRobots(frame) {
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const point = this.replay.point("position", frame, robot);
      if (!point) continue;
      const [x, y] = this.pixel(point), look = this.look(frame, robot);
      const radius = Math.max(2, this.replay.data.radius[robot] * this.scale);
      Swarm.marks.robot(this.context, x, y, radius, look);
      const nose = [x + radius * Math.cos(look.yaw), y - radius * Math.sin(look.yaw)];
      Swarm.marks.line(this.context, [[x, y], nose], "#ffffff", 1);
    }
  }

  drawEstimates(frame) {
    const color = Swarm.color("estimate");
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const [believed, truth] = [this.replay.point("estimate", frame, robot), this.replay.point("position", frame, robot)];
      if (!believed || !truth || !this.replay.isAlive(frame, robot)) continue;
      const [x, y] = this.pixel(believed), ellipse = this.replay.point("ellipse", frame, robot);
      if (ellipse) {
        const [long, short] = ellipse.map((axis) => Math.max(0, axis) * this.scale); // of rounded numbers
        Swarm.marks.ellipse(this.context, x, y, long, short, -this.replay.state("ellipse_turn", frame, robot), color);
      }
      Swarm.marks.line(this.context, [this.pixel(truth), [x, y]], color, 1.5);
      Swarm.marks.cross(this.context, x, y, 3.5, color, Math.PI / 4);
    }
  }

  drawNames(frame) {
    this.context.fillStyle = Swarm.color("text");
    this.context.font = "11px system-ui, sans-serif";
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const point = this.replay.point("position", frame, robot);
      if (point) this.context.fillText(this.replay.data.names[robot], ...this.pixel(point).map((at) => at + 5));
    }
  }

  drawScaleBar() {
    const { context } = this, wanted = 120 / this.scale;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const length = [5, 2, 1].map((factor) => factor * power).find((candidate) => candidate <= wanted);
    const [x, y] = [14, this.canvas.clientHeight - 16];
    Swarm.marks.line(context, [[x, y], [x + length * this.scale, y]], Swarm.color("text"), 3);
    context.fillStyle = Swarm.color("text");
    context.font = "12px system-ui, sans-serif";
    context.fillText(`${Number(length.toPrecision(3))} m`, x, y - 6);
  }

  legend() {
    const { replay } = this, entries = [];
    const robot = (text, look) =>
      entries.push([text, (context) => Swarm.marks.robot(context, 13, 9, 5.5, { color: Swarm.TYPE_COLORS[0], isAlive: true, positioning: 0, yaw: 0, ...look })]);
    const types = [...new Set(replay.data.robot_type || [])].sort((a, b) => a - b);
    for (const type of types) {
      const first = replay.data.robot_type.indexOf(type);
      robot(`type ${type}, radius ${replay.data.radius[first]} m`, { color: Swarm.typeColor(replay, first) });
    }
    if (this.extra.cell) robot("boat", { isSquare: true });
    if (this.extra.cells) robot("place of the structure", { isSquare: true, color: Swarm.color("shape-edge") });
    if ((replay.data.carries_sensor || []).includes(1)) robot("carries a position sensor", { carriesSensor: true });
    const positioning = replay.fields.positioning || [];
    if (positioning.includes(1)) robot("lost", { positioning: 1 });
    if (positioning.includes(2)) robot("returning home", { positioning: 2 });
    if ((replay.fields.alive || []).includes(0)) robot("dead or switched off", { isAlive: false });
    if (replay.data.goals.frames.length) entries.push(["goal", (context) => Swarm.marks.cross(context, 13, 9, 5, Swarm.color("goal"))]);
    if (replay.data.paths.length) entries.push(["path ahead", (context) => Swarm.marks.line(context, [[2, 9], [24, 9]], Swarm.TYPE_COLORS[0], 1.2, { dash: [5, 4] })]);
    if (replay.links) entries.push(["radio link", (context) => Swarm.marks.line(context, [[2, 9], [24, 9]], Swarm.color("link"), 1.5, { alpha: 0.5 })]);
    if (replay.docks) entries.push(["docked", (context) => Swarm.marks.line(context, [[2, 9], [24, 9]], Swarm.color("mission"), 5)]);
    if (replay.fields.estimate) {
      entries.push(["where it believes to be, with its 2 σ ellipse", (context) => {
        Swarm.marks.ellipse(context, 13, 9, 10, 6, 0, Swarm.color("estimate"));
        Swarm.marks.cross(context, 13, 9, 3.5, Swarm.color("estimate"), Math.PI / 4);
      }]);
    }
    if (replay.data.mission_position) {
      entries.push(["mission computer", (context) => Swarm.marks.line(context, [[13, 2], [19, 14], [7, 14]], Swarm.color("mission"), 2, { isClosed: true })]);
    }
    return entries;
  }
};

// Stretch a box, [left, low, right, high], so that it holds a point.
Swarm.widen = function (box, point) {
  if (!point) return;
  box[0] = Math.min(box[0], point[0]);
  box[1] = Math.min(box[1], point[1]);
  box[2] = Math.max(box[2], point[0]);
  box[3] = Math.max(box[3], point[1]);
};

// The way-points that are still ahead: a robot has passed those that lie before the segment it is closest to.
Swarm.ahead = function (from, points) {
  let best = 0, least = Infinity;
  for (let number = 0; number + 1 < points.length; number++) {
    const [a, b] = [points[number], points[number + 1]];
    const along = [b[0] - a[0], b[1] - a[1]];
    const length = along[0] ** 2 + along[1] ** 2;
    if (!length) continue;
    const share = Math.max(0, Math.min(1, ((from[0] - a[0]) * along[0] + (from[1] - a[1]) * along[1]) / length));
    const distance = Math.hypot(from[0] - a[0] - share * along[0], from[1] - a[1] - share * along[1]);
    if (share > 0 && distance < least) [best, least] = [number + 1, distance];
  }
  return points.slice(best);
};
