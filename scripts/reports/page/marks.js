// How things look, in the replay and in the legend alike.
Swarm.TYPE_COLORS = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9"]; // Okabe-Ito: safe for color blindness
Swarm.POSITIONING = ["localized", "lost", "returning home"];

Swarm.colors = new Map();
Swarm.color = function (name) {
  if (!Swarm.colors.has(name)) {
    Swarm.colors.set(name, getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim());
  }
  return Swarm.colors.get(name);
};

Swarm.typeColor = function (replay, robot) {
  const types = replay.data.robot_type;
  if (!types) return Swarm.TYPE_COLORS[0];
  const known = [...new Set(types)].sort((a, b) => a - b);
  return Swarm.TYPE_COLORS[known.indexOf(types[robot]) % Swarm.TYPE_COLORS.length];
};

Swarm.marks = {
  // A robot as its coverage circle, or as a square on a lattice; a ring says that it does not know where it is.
  robot(context, x, y, radius, look) {
    context.save();
    context.translate(x, y);
    context.beginPath();
    if (look.isSquare) {
      context.rotate(-look.yaw);
      context.rect(-radius, -radius, 2 * radius, 2 * radius);
    } else context.arc(0, 0, radius, 0, 2 * Math.PI);
    context.globalAlpha = look.isAlive ? 0.75 : 0.25;
    context.fillStyle = look.color;
    context.fill();
    context.globalAlpha = 1;
    context.lineWidth = look.isSelected ? 3 : 1;
    context.strokeStyle = look.isSelected ? Swarm.color("text") : look.color;
    context.stroke();
    context.restore();
    if (look.carriesSensor) Swarm.marks.dot(context, x, y, Math.min(4, Math.max(1.5, 0.25 * radius)), "#ffffff");
    if (look.positioning > 0) Swarm.marks.ring(context, x, y, radius + 3, look.positioning);
    if (!look.isAlive) Swarm.marks.cross(context, x, y, Math.max(4, 0.7 * radius), Swarm.color("dead"), Math.PI / 4);
  },

  ring(context, x, y, radius, positioning) {
    context.save();
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.setLineDash(positioning === 1 ? [4, 3] : []);
    context.lineWidth = 2.5;
    context.strokeStyle = Swarm.color("lost");
    context.stroke();
    context.restore();
  },

  dot(context, x, y, radius, color) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fillStyle = color;
    context.fill();
  },

  cross(context, x, y, reach, color, turn = 0) {
    context.save();
    context.translate(x, y);
    context.rotate(turn);
    context.beginPath();
    context.moveTo(-reach, 0);
    context.lineTo(reach, 0);
    context.moveTo(0, -reach);
    context.lineTo(0, reach);
    context.lineWidth = 1.5;
    context.strokeStyle = color;
    context.stroke();
    context.restore();
  },

  line(context, points, color, width, options = {}) {
    if (points.length < 2) return;
    context.save();
    context.beginPath();
    points.forEach(([x, y], number) => (number ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (options.isClosed) context.closePath();
    if (options.fill) {
      context.fillStyle = options.fill;
      context.fill();
    }
    context.setLineDash(options.dash || []);
    context.globalAlpha = options.alpha || 1;
    context.lineWidth = width;
    context.strokeStyle = color;
    context.stroke();
    context.restore();
  },

  ellipse(context, x, y, long, short, turn, color) {
    context.save();
    context.beginPath();
    context.ellipse(x, y, long, short, turn, 0, 2 * Math.PI);
    context.globalAlpha = 0.15;
    context.fillStyle = color;
    context.fill();
    context.globalAlpha = 0.6;
    context.strokeStyle = color;
    context.stroke();
    context.restore();
  },
};
