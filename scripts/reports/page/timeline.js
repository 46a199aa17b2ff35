// The run by frames; a frame may lie between two of them, so that motion is smooth.
Swarm.Replay = class {
  constructor(data) {
    this.data = data;
    this.times = data.times;
    this.robots = data.names.length;
    this.frames = data.times.length;
    this.dimensions = data.position.shape[2];
    this.fields = {};
    for (const name of ["position", "estimate", "ellipse", "ellipse_turn", "yaw", "alive", "mode", "goal", "positioning"]) {
      if (data[name]) this.fields[name] = Swarm.unpack(data[name]);
    }
    this.links = data.links && new Swarm.Pairs(Swarm.unpack(data.links));
    this.docks = data.docks && new Swarm.Pairs(Swarm.unpack(data.docks));
  }

  get duration() { return this.frames ? this.times[this.frames - 1] : 0; }

  // The frame at a time [s], with its fraction.
  frameAt(time) {
    const last = this.frames - 1;
    if (last < 1 || time <= this.times[0]) return 0;
    if (time >= this.times[last]) return last;
    const after = Swarm.after(this.times, time);
    const before = this.times[after - 1];
    return after - 1 + (time - before) / (this.times[after] - before);
  }

  timeOf(frame) { return this.times[Math.max(0, Math.min(this.frames - 1, frame))]; }

  // Where a robot is, or believes to be, at a frame; null where it is nowhere.
  point(name, frame, robot) {
    const values = this.fields[name];
    if (!values) return null;
    const size = name === "ellipse" ? 2 : name === "estimate" ? this.data.estimate.shape[2] : this.dimensions;
    const first = Math.floor(frame), share = frame - first;
    const from = (first * this.robots + robot) * size, to = from + this.robots * size;
    const point = [];
    for (let axis = 0; axis < size; axis++) {
      const start = values[from + axis];
      const end = share > 0 ? values[to + axis] : start;
      point.push(share > 0 ? start + share * (end - start) : start);
    }
    return point.some(Number.isNaN) ? null : point;
  }

  // A state of a robot; undefined if the run did not record it.
  state(name, frame, robot) {
    const values = this.fields[name];
    return values ? values[Math.floor(frame) * this.robots + robot] : undefined;
  }

  isAlive(frame, robot) { return this.state("alive", frame, robot) !== 0; }

  yaw(frame, robot) {
    const values = this.fields.yaw;
    if (!values) return 0;
    const from = values[Math.floor(frame) * this.robots + robot];
    const to = values[Math.ceil(frame) * this.robots + robot];
    const turn = Math.atan2(Math.sin(to - from), Math.cos(to - from)); // the short way round
    return from + (frame - Math.floor(frame)) * turn;
  }

  // The points that hold at a frame, of shape, goals or a path.
  pointsAt(changes, frame) {
    const number = Swarm.after(changes.frames, Math.floor(frame)) - 1;
    return number >= 0 ? changes.points[number] : [];
  }

  goalOf(frame, robot) {
    const goal = this.state("goal", frame, robot);
    return goal >= 0 ? this.pointsAt(this.data.goals, frame)[goal] || null : null;
  }
};

// Pairs of nodes that come together and part.
Swarm.Pairs = class {
  constructor(changes) {
    this.changes = changes;
    this.reset();
  }

  reset() {
    this.next = 0;
    this.frame = -1;
    this.present = new Map();
  }

  // All pairs at a frame, each [node, node].
  at(frame) {
    const wanted = Math.floor(frame);
    if (wanted < this.frame) this.reset();
    this.frame = wanted;
    const { changes } = this;
    for (; this.next < changes.length && changes[this.next] <= wanted; this.next += 4) {
      const [a, b, isUp] = [changes[this.next + 1], changes[this.next + 2], changes[this.next + 3]];
      const key = a * 65536 + b;
      if (isUp) this.present.set(key, [a, b]);
      else this.present.delete(key);
    }
    return [...this.present.values()];
  }
};

// How many of the ascending numbers are at most `value`.
Swarm.after = function (numbers, value) {
  let low = 0, high = numbers.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (numbers[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low;
};
