// Charts in uPlot. How a line looks is read from its swatch in the legend, so that the style sheet alone says it.

const DASHES = { dashed: [7, 5], dotted: [2, 4] };
const MARGIN = { across: 70, along: 50 };
const POINTS = 60; // more values than this are a curve, and not marked

function look(swatch) {
  const style = getComputedStyle(swatch);
  return {
    stroke: style.borderTopColor,
    width: parseFloat(style.borderTopWidth),
    dash: DASHES[style.borderTopStyle],
  };
}

function faded(colour) {
  return colour.replace("rgb(", "rgba(").replace(")", ", 0.16)");
}

function axis(label) {
  const style = getComputedStyle(document.body);
  const colour = style.getPropertyValue("--quiet");
  const line = { stroke: style.getPropertyValue("--line"), width: 1 };
  const font = "12px system-ui";
  return { label, labelSize: 18, labelGap: 0, labelFont: font, font, stroke: colour, grid: line, ticks: { ...line, size: 4 } };
}

function fromZero(u, low, high) {
  return [0, high > 0 ? 1.06 * high : 1];
}

// A line that may turn back: uPlot's own take it that horizontal values rise, and cut gaps by them.
function stretches(u, place) {
  const [across, up] = u.data[place];
  const stroke = new Path2D();
  across.forEach((x, i) => {
    if (up[i] == null) return;
    const point = [u.valToPos(x, "x", true), u.valToPos(up[i], "y", true)];
    if (i && up[i - 1] != null) stroke.lineTo(...point);
    else stroke.moveTo(...point);
  });
  return { stroke, fill: null, clip: null, band: null, gaps: null, flags: 0 };
}

export class Chart {
  constructor(figure, about, arrays) {
    Object.assign(this, { figure, about, arrays, plot: figure.querySelector(".plot") });
    this.swatches = [...figure.querySelectorAll(".swatch")];
    this.outputs = [...figure.querySelectorAll(".legend output")];
  }

  // Of a chart of one log there is an array for each.
  row(array, state, combination = 0) {
    return this.arrays.row(Array.isArray(array) ? array[state.log] : array, combination);
  }

  values(line, array, state) {
    return this.row(array, state, line.switched ? state.on : 0);
  }

  // Every line, with the ends of its interval where it has one.
  data(state) {
    const columns = this.about.lines.flatMap((line) =>
      [line.values, line.low, line.high].filter((array) => array !== null).map((array) => this.values(line, array, state)),
    );
    return [this.row(this.about.along, state), ...columns];
  }

  series() {
    const points = { show: this.about.points, size: 6 };
    const series = [{}];
    const bands = [];
    this.about.lines.forEach((line, place) => {
      const own = look(this.swatches[place]);
      series.push({ ...own, points, spanGaps: false });
      if (line.low !== null) {
        bands.push({ series: [series.length + 1, series.length], fill: faded(own.stroke) });
        series.push({ points: { show: false } }, { points: { show: false } });
      }
    });
    return { series, bands };
  }

  options(state) {
    const y = this.about.zero ? { range: fromZero } : {};
    return {
      ...this.size(),
      ...this.series(),
      scales: { x: { time: false }, y },
      axes: [{ ...axis(this.about.x), size: 26 }, { ...axis(this.about.y), size: 58 }],
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false }, points: { show: false } },
      hooks: { setCursor: [(u) => this.read(u)] },
    };
  }

  size() {
    return { width: Math.max(200, this.plot.clientWidth), height: parseFloat(getComputedStyle(this.plot).minHeight) };
  }

  // Values below the cursor, beside the lines' names.
  read(u) {
    const at = u.cursor.idx;
    let place = 1;
    this.about.lines.forEach((line, index) => {
      const value = at == null ? null : u.data[place][at];
      this.outputs[index].textContent = value == null ? "" : figures(value);
      place += line.low === null ? 1 : 3;
    });
  }

  draw(state) {
    this.shown = state.version;
    if (!this.u) this.u = new uPlot(this.options(state), this.data(state), this.plot);
    else this.u.setData(this.data(state));
    this.point(state);
  }

  // The cursor at the slider's time.
  point(state) {
    if (this.about.kind !== "time") return;
    const left = this.u.valToPos(state.time, "x");
    this.u.setCursor({ left, top: 0 });
  }

  resize() {
    if (this.u) this.u.setSize(this.size());
  }

  forget() {
    if (this.u) this.u.destroy();
    this.u = null;
    this.shown = -1;
  }
}

// A path: both axes have one scale, and every line its own horizontal values.
export class Path extends Chart {
  data(state) {
    const lines = this.about.lines.map((line) => [
      this.row(line.x, state),
      this.values(line, line.values, state),
    ]);
    return [null, ...lines];
  }

  now(state) {
    const time = this.row(this.about.along, state);
    const after = time.findIndex((one) => one >= state.time);
    const place = after < 0 ? time.length - 1 : after;
    const [line] = this.about.lines;
    return [this.row(line.x, state)[place], this.values(line, line.values, state)[place]];
  }

  circle(u) {
    const [x, y] = this.here;
    u.ctx.beginPath();
    u.ctx.arc(u.valToPos(x, "x", true), u.valToPos(y, "y", true), 7 * devicePixelRatio, 0, 2 * Math.PI);
    u.ctx.lineWidth = 3 * devicePixelRatio;
    u.ctx.strokeStyle = look(this.swatches.at(-1)).stroke;
    u.ctx.stroke();
  }

  ranges(state) {
    const { width, height } = this.size();
    const [, [x, y]] = this.data(state);
    const ends = [x, y].map((values) => [Math.min(...values), Math.max(...values)]);
    const scale = 1.12 * Math.max((ends[0][1] - ends[0][0]) / (width - MARGIN.across), (ends[1][1] - ends[1][0]) / (height - MARGIN.along), 1e-6);
    const half = [((width - MARGIN.across) * scale) / 2, ((height - MARGIN.along) * scale) / 2];
    return ends.map(([low, high], place) => [(low + high) / 2 - half[place], (low + high) / 2 + half[place]]);
  }

  options(state) {
    const facets = [{ scale: "x", auto: false }, { scale: "y", auto: false }];
    const lines = this.about.lines.map((_, place) => ({ ...look(this.swatches[place]), facets, paths: stretches, points: { show: false } }));
    return {
      ...super.options(state),
      mode: 2,
      bands: [],
      series: [null, ...lines],
      scales: { x: { time: false, range: () => this.ranges(state)[0] }, y: { range: () => this.ranges(state)[1] } },
      cursor: { show: false },
      hooks: { draw: [(u) => this.circle(u)] },
    };
  }

  draw(state) {
    this.here = this.now(state);
    super.draw(state);
  }

  point(state) {
    this.here = this.now(state);
    this.u.redraw(false);
  }
}
