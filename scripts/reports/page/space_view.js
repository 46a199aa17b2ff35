// The swarm in space: drag to turn, wheel to come closer. World frame: x right, y away, z up, before it is turned.
Swarm.views.space = class {
  constructor(canvas, replay, extra) {
    Object.assign(this, { canvas, replay, extra, context: canvas.getContext("2d") });
    this.selected = null;
    this.layers = [
      ["circles", "robots", true],
      ["shape", "shape", extra.surfaces.length || extra.edges.length],
      ["goals", "goals", replay.data.goals.frames.length],
      ["trails", "trails", true],
      ["links", "radio links", replay.links || extra.reach],
    ].filter(([, , isThere]) => isThere); // what a run did not record cannot be switched on
    this.hidden = new Set(["trails"]);
    this.surfaces = extra.surfaces.map(({ frame, points }) => {
      const values = Swarm.unpack(points), places = [];
      for (let at = 0; at < values.length; at += 3) places.push([values[at], values[at + 1], values[at + 2]]);
      return { frame, places };
    });
    this.shifts = extra.shift && Swarm.unpack(extra.shift);
    this.azimuth = -0.6;
    this.elevation = 0.5;
    this.fit(this.arena());
  }

  // Corners of everything that is ever shown: [x, y, z] lowest and highest.
  arena() { return this.box((grow) => {
    for (let frame = 0; frame < this.replay.frames; frame++) {
      for (let robot = 0; robot < this.replay.robots; robot++) grow(this.replay.point("position", frame, robot));
    }
    this.extra.edges.flat().forEach(grow);
    for (const { frame } of this.surfaces) this.surfaceAt(frame).forEach(grow);
    this.surfaceAt(this.replay.frames - 1).forEach(grow);
  }); }

  // Points on the shape in force, where it is at a frame.
  surfaceAt(frame) {
    const shown = this.surfaces.filter((surface) => surface.frame <= frame).pop();
    if (!shown) return [];
    if (!this.shifts) return shown.places;
    const first = Math.floor(frame), share = frame - first;
    const shift = [0, 1, 2].map((axis) => {
      const start = this.shifts[3 * first + axis];
      return share > 0 ? start + share * (this.shifts[3 * (first + 1) + axis] - start) : start;
    });
    return shown.places.map((place) => place.map((value, axis) => value + shift[axis]));
  }

  shapeBox(frame) { return this.box((grow) => {
    [...this.extra.edges.flat(), ...this.surfaceAt(frame)].forEach(grow);
    for (let robot = 0; robot < this.replay.robots; robot++) grow(this.replay.point("position", frame, robot));
  }); }

  box(visit) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    visit((point) => point && point.forEach((value, axis) => {
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    }));
    return [low, high];
  }

  fit([low, high]) {
    this.center = low.map((value, axis) => (value + high[axis]) / 2);
    const reach = Math.hypot(...high.map((value, axis) => value - low[axis])) || 1;
    this.scale = (0.9 * Math.min(this.canvas.clientWidth, this.canvas.clientHeight)) / reach;
  }

  // Pixel and depth (larger is farther) of a point, by an orthographic camera.
  project(point) {
    const [x, y, z] = point.map((value, axis) => value - this.center[axis]);
    const [cosA, sinA] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [cosE, sinE] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    const right = cosA * x - sinA * y, away = sinA * x + cosA * y;
    const up = cosE * z + sinE * away, depth = cosE * away - sinE * z;
    return [this.canvas.clientWidth / 2 + right * this.scale, this.canvas.clientHeight / 2 - up * this.scale, depth];
  }

  zoom(factor) { this.scale = Math.max(0.1, Math.min(5000, this.scale * factor)); }

  drag(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.elevation + dy * 0.008));
  }

  pick(at, frame) {
    let best = null, least = Infinity;
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const point = this.replay.point("position", frame, robot);
      if (!point) continue;
      const [x, y, depth] = this.project(point);
      const isHit = Math.hypot(x - at[0], y - at[1]) <= Math.max(8, this.radius(robot));
      if (isHit && depth < least) [best, least] = [robot, depth];
    }
    return best;
  }

  radius(robot) { return Math.max(2.5, this.replay.data.radius[robot] * this.scale); }

  shows(layer) { return !this.hidden.has(layer); }

  draw(frame) {
    const { canvas, context } = this, ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const points = Array.from({ length: this.replay.robots }, (_, robot) => this.replay.point("position", frame, robot));
    if (this.shows("shape")) this.drawShape(frame);
    if (this.shows("goals")) {
      for (const goal of this.replay.pointsAt(this.replay.data.goals, frame)) {
        if (goal.length === 3) Swarm.marks.cross(context, ...this.project(goal).slice(0, 2), 3, Swarm.color("goal"));
      }
    }
    if (this.shows("links")) {
      for (const [a, b] of this.pairs(frame, points)) {
        if (points[a] && points[b]) this.line([points[a], points[b]], Swarm.color("link"), 1, 0.35);
      }
    }
    if (this.shows("trails")) this.drawTrails(frame);
    if (this.shows("circles")) this.drawRobots(frame, points);
    this.drawAxes();
  }

  drawShape(frame) {
    this.extra.edges.forEach((edge) => this.line(edge, Swarm.color("shape-edge"), 1, 0.7));
    this.context.globalAlpha = 0.45;
    for (const point of this.surfaceAt(frame)) {
      const [x, y] = this.project(point);
      Swarm.marks.dot(this.context, x, y, 1, Swarm.color("shape-edge"));
    }
    this.context.globalAlpha = 1;
  }

  // Who is linked to whom: as recorded, or all that are in reach of each other.
  pairs(frame, points) {
    if (this.replay.links) return this.replay.links.at(frame);
    const reach = this.extra.reach, pairs = [];
    if (!reach) return pairs;
    points.forEach((from, a) => {
      for (let b = 0; b < a; b++) {
        const to = points[b];
        const isNear = from && to && Math.hypot(from[0] - to[0], from[1] - to[1], from[2] - to[2]) <= reach;
        if (isNear && this.replay.isAlive(frame, a) && this.replay.isAlive(frame, b)) pairs.push([a, b]);
      }
    });
    return pairs;
  }

  line(points, color, width, alpha) {
    Swarm.marks.line(this.context, points.map((point) => this.project(point)), color, width, { alpha });
  }

  // The farthest first, so that nearer ones cover them.
  drawRobots(frame, points) {
    const seen = points.map((point, robot) => point && [...this.project(point), robot]).filter(Boolean);
    seen.sort((one, other) => other[2] - one[2]);
    const nearest = seen.length ? seen[seen.length - 1][2] : 0, farthest = seen.length ? seen[0][2] : 0;
    for (const [x, y, depth, robot] of seen) {
      const closeness = farthest > nearest ? (farthest - depth) / (farthest - nearest) : 1;
      this.context.globalAlpha = 0.5 + 0.5 * closeness;
      Swarm.marks.robot(this.context, x, y, this.radius(robot), {
        color: this.color(robot, frame),
        isAlive: this.replay.isAlive(frame, robot),
        isSelected: robot === this.selected,
        positioning: this.replay.state("positioning", frame, robot) || 0,
      });
    }
    this.context.globalAlpha = 1;
  }

  drawTrails(frame) {
    const step = Math.max(1, Math.floor(frame / 200));
    for (let robot = 0; robot < this.replay.robots; robot++) {
      const points = [];
      for (let past = 0; past <= Math.floor(frame); past += step) points.push(this.replay.point("position", past, robot));
      points.push(this.replay.point("position", frame, robot));
      this.line(points.filter(Boolean), Swarm.typeColor(this.replay, robot), 1, 0.4);
    }
  }

  drawAxes() {
    const { context } = this, origin = [46, this.canvas.clientHeight - 46];
    const [x, y] = this.project(this.center);
    [["x", [1, 0, 0]], ["y", [0, 1, 0]], ["z", [0, 0, 1]]].forEach(([name, axis]) => {
      const tip = this.project(this.center.map((value, number) => value + axis[number] / this.scale));
      const end = [origin[0] + 30 * (tip[0] - x), origin[1] + 30 * (tip[1] - y)];
      Swarm.marks.line(context, [origin, end], Swarm.color("quiet"), 1.5);
      context.fillStyle = Swarm.color("text");
      context.font = "12px system-ui, sans-serif";
      context.fillText(name, end[0] + 3, end[1] + 3);
    });
  }

  // Robots of one type are told apart by what they do.
  color(robot, frame) {
    const mode = this.replay.state("mode", frame, robot);
    if (this.replay.data.robot_type || !(mode >= 0)) return Swarm.typeColor(this.replay, robot);
    return Swarm.TYPE_COLORS[mode % Swarm.TYPE_COLORS.length];
  }

  legend() {
    const { data } = this.replay;
    const mark = (look) => (context) => Swarm.marks.robot(context, 13, 9, 5.5, { isAlive: true, positioning: 0, ...look });
    const byMode = !data.robot_type && data.mode && data.modes.length;
    const robots = byMode
      ? data.modes.map((name, mode) => [name, mark({ color: Swarm.TYPE_COLORS[mode % Swarm.TYPE_COLORS.length] })])
      : [["robot", mark({ color: Swarm.TYPE_COLORS[0] })]];
    const entries = [...robots, ["off, or not there yet", mark({ color: Swarm.TYPE_COLORS[0], isAlive: false })]];
    if (this.replay.links || this.extra.reach) {
      entries.push(["radio link", (context) => Swarm.marks.line(context, [[2, 9], [24, 9]], Swarm.color("link"), 1.5, { alpha: 0.5 })]);
    }
    entries.push(["shape", (context) => Swarm.marks.line(context, [[2, 9], [24, 9]], Swarm.color("shape-edge"), 1.5)]);
    return entries;
  }
};
