// Charts over time: a line that shows the time of the replay, and a click that takes the replay there.
Swarm.Charts = class {
  constructor(parent, charts, onSeek) {
    this.plots = charts.map((chart) => this.make(parent, chart, onSeek));
    new ResizeObserver(() => this.plots.forEach(({ plot, box }) => plot.setSize(Swarm.chartSize(box)))).observe(parent);
  }

  make(parent, chart, onSeek) {
    const box = document.createElement("figure");
    box.dataset.chart = chart.name;
    box.append(Object.assign(document.createElement("figcaption"), { textContent: chart.title }));
    parent.append(box);
    const axis = { stroke: Swarm.color("text"), grid: { stroke: Swarm.color("line") }, ticks: { stroke: Swarm.color("line") } };
    const options = {
      ...Swarm.chartSize(box),
      cursor: { sync: { key: "time" }, drag: { x: false, y: false } },
      scales: { x: { time: false } },
      axes: [{ ...axis }, { ...axis, size: 58 }],
      series: [
        { label: "s" },
        ...chart.lines.map((line, number) => ({
          label: line.label, stroke: Swarm.TYPE_COLORS[number % Swarm.TYPE_COLORS.length], width: 1.5, points: { show: false },
        })),
      ],
    };
    const plot = new uPlot(options, [chart.times, ...chart.lines.map((line) => line.values)], box);
    const now = Object.assign(document.createElement("div"), { className: "now" });
    plot.over.append(now);
    plot.over.addEventListener("click", (event) => onSeek(plot.posToVal(event.offsetX, "x")));
    return { plot, box, now };
  }

  show(time) {
    for (const { plot, now } of this.plots) now.style.left = plot.valToPos(time, "x") + "px";
  }
};

Swarm.chartSize = (box) => ({ width: Math.max(220, box.clientWidth - 18), height: 190 });
