// Curves of a history, with a dot at the current moment.

const ROUNDED = 1e-8;  // times of frames have 9 digits

// Index of the first row of a history at or after a time, except for rounding; else of the last row.
function rowAt(history, time) {
  const times = history.time_s;
  const row = times.findIndex(t => t >= time * (1 - ROUNDED));
  return row < 0 ? times.length - 1 : row;
}

const ENERGIES = [['kinetic_energy_J', 'kinetic'], ['strain_energy_J', 'strain'], ['contact_energy_J', 'joints'],
  ['dissipated_tension_J', 'tension'], ['dissipated_cohesion_J', 'cohesion'], ['dissipated_friction_J', 'friction'],
  ['dissipated_crushing_J', 'crushing'], ['damping_work_J', 'damping'], ['external_work_J', 'external work']];
const CHART = {narrowest: 260, widest: 700, gap: 8, height: 235, left: 62, right: 14, bottom: 42};  // pixels

// Direction of the response to ground motion. Results of older versions have its axis alone.
const directionOf = curve => curve.direction || [...'xyz'].map(axis => Number(axis === curve.along));

// Axes of the curve of a stage: columns of the history, factors and labels. `at`: value of a row, of no column.
function axesOf(stage, history) {
  const curve = (stage && stage.curve) || {kind: 'push', along: 'x'};
  const along = curve.along, of = curve.of ? ` of ${curve.of}` : '';
  const moved = along === 'y' ? 'vertical_displacement_m' : 'displacement_m';
  const carried = along === 'y' ? 'vertical_force_N' : 'horizontal_force_N';
  const direction = along === 'y' ? 'vertical' : along === 'z' ? 'out-of-plane' : 'horizontal';
  const time = {key: 'time_s', factor: 1, label: 'time [s]'};
  const displacement = {key: moved, factor: 1e3, label: `${direction} displacement${of} [mm]`};
  const force = {key: carried, factor: 1e-3, label: `${direction} force [kN]`};
  if (curve.kind === 'collapse' && history.multiplier)
    return [[{key: 'largest_displacement_m', factor: 1e3, label: 'largest displacement [mm]'},
      {key: 'multiplier', factor: 1, label: 'multiplier of the weight'}]];
  const isWatched = curve.of !== null;
  if (curve.kind === 'earthquake') {
    // Along the response: relative displacement and base force, if the history has both.
    const moves = ['monitor_relative_dx_m', 'monitor_relative_dy_m', 'monitor_relative_dz_m'];
    const carries = ['base_shear_x_N', 'base_vertical_N', 'base_shear_z_N'], d = directionOf(curve);
    if (![...moves, ...carries].every(key => history[key])) return [[time, displacement], [time, force]];
    const sum = keys => row => keys.reduce((all, key, k) => all + (d[k] === 0 ? 0 : d[k] * history[key][row]), 0);
    const relative = {at: sum(moves), factor: 1e3, label: `relative displacement along ${along}${of} [mm]`};
    const base = {at: sum(carries), factor: 1e-3, label: `base ${d[1] === 0 ? 'shear' : 'force'} along ${along} [kN]`};
    return isWatched ? [[time, relative], [time, base]] : [[time, base]];
  }
  if (!isWatched) {
    const largest = {key: 'largest_displacement_m', factor: 1e3, label: 'largest displacement of a block [mm]'};
    return history.largest_displacement_m ? [[time, largest]] : [];
  }
  if (curve.kind === 'rest') return [[time, {key: 'vertical_displacement_m', factor: 1e3, label: `vertical displacement${of} [mm]`}]];
  return [[displacement, force]];
}

// Rows of all stages with equal axes.
function rowsLike(stage, stages, history) {
  const like = s => JSON.stringify(s && s.curve) === JSON.stringify(stage && stage.curve);
  const rows = [];
  history.stage.forEach((s, i) => { if (like(stages[s - 1])) rows.push(i); });
  return rows;
}

// Lines over a common x. lines: {name, values}; each with a dot at `rows[k]` of the history.
class Curve {
  constructor(parent, width, rows, xs, lines, xLabel, yLabel, pens) {
    this.svg = drawing(parent); this.width = width;
    this.rows = rows; this.xs = xs; this.lines = lines; this.labels = [xLabel, yLabel]; this.pens = pens;
    const limits = values => {
      const low = values.reduce((a, b) => Math.min(a, b), 0), high = values.reduce((a, b) => Math.max(a, b), 0);
      return high > low ? [low, high] : [low, low + 1];
    };
    this.x = limits(xs); this.y = limits(lines.flatMap(l => l.values));
    for (const [key, value] of [['width', width], ['height', CHART.height], ['viewBox', `0 0 ${width} ${CHART.height}`]])
      this.svg.setAttribute(key, value);
    this.draw();
  }
  place(x, y) {
    const [left, right] = this.x, [low, high] = this.y;
    return [CHART.left + (x - left) / (right - left) * (this.width - CHART.left - CHART.right),
      CHART.height - CHART.bottom - (y - low) / (high - low) * (CHART.height - CHART.bottom - this.top)];
  }
  // Names of lines, from the left, in rows as long as they fit; the height of all rows.
  name() {
    let x = CHART.left, y = 32;
    const named = this.lines.map((line, n) => [line, n]).filter(([line]) => line.name);
    for (const [line, n] of named) {
      const width = 36 + widthOf(line.name);
      if (x > CHART.left && x + width > this.width) x = CHART.left, y += 15;
      mark(this.svg, 'line', {x1: x, x2: x + 18, y1: y - 4, y2: y - 4, ...this.penOf(n)});
      mark(this.svg, 'text', {x: x + 22, y}, line.name);
      x += width;
    }
    return named.length ? y + 10 : 26;
  }
  penOf(n) {
    return {stroke: this.pens[n % this.pens.length], 'stroke-width': 1.7, fill: 'none',
      'stroke-dasharray': ['none', '6 3', '2 2'][Math.floor(n / 3) % 3]};
  }
  draw() {
    const right = this.width - CHART.right, floor = CHART.height - CHART.bottom;
    mark(this.svg, 'text', {x: 6, y: 15, class: 'label'}, fitted(this.labels[1], this.width - 12));
    const below = fitted(this.labels[0], this.width - 12), half = widthOf(below) / 2;
    mark(this.svg, 'text', {x: Math.min((CHART.left + right) / 2, this.width - 6 - half), y: CHART.height - 7,
      'text-anchor': 'middle', class: 'label'}, below);
    this.top = this.name();
    for (const y of ticksOf(...this.y, 5)) {
      const [, level] = this.place(0, y);
      mark(this.svg, 'line', {x1: CHART.left, x2: right, y1: level, y2: level, stroke: y === 0 ? '#888' : '#ddd'});
      mark(this.svg, 'text', {x: CHART.left - 6, y: level + 4, 'text-anchor': 'end'}, short(y));
    }
    for (const x of ticksThatFit(...this.x, 6, right - CHART.left)) {
      const [across] = this.place(x, 0);
      mark(this.svg, 'line', {x1: across, x2: across, y1: this.top, y2: floor, stroke: x === 0 ? '#888' : '#eee'});
      const half = widthOf(short(x)) / 2;
      mark(this.svg, 'text', {x: Math.min(across, this.width - half), y: floor + 15, 'text-anchor': 'middle'}, short(x));
    }
    this.dots = [];
    this.lines.forEach((line, n) => {
      const points = line.values.map((v, i) => this.place(this.xs[i], v).map(c => Number(c.toFixed(2))).join(','));
      mark(this.svg, 'polyline', {points: points.join(' '), class: 'curve', ...this.penOf(n)});
      this.dots.push(mark(this.svg, 'circle', {r: 4.5, fill: this.pens[n % this.pens.length], stroke: '#fff'}));
    });
  }
  // Moves the dots to a row of the history; without rows there are none.
  at(row) {
    if (!this.rows) { for (const dot of this.dots) dot.setAttribute('r', 0); return; }
    let k = this.rows.findIndex(r => r >= row);
    if (k < 0) k = this.rows.length - 1;
    this.lines.forEach((line, n) => {
      const [x, y] = this.place(this.xs[k], line.values[k]);
      this.dots[n].setAttribute('cx', x); this.dots[n].setAttribute('cy', y);
    });
  }
}

// Record of an earthquake along a direction, with its spectrum; undefined if the summary has none.
function recordOf(stage, way) {
  const along = c => Math.abs(c.direction.reduce((sum, d, k) => sum + d * way[k], 0)) > 0.999 * Math.hypot(...c.direction);
  return (((stage || {}).ground_motion || {}).components || []).find(c => c.record && c.spectrum && along(c));
}

// The curves of a stage, and the energies of the run.
function curvesOf(parent, head, stage) {
  const h = head.history, stages = (head.summary.settings || {}).stages || [], pens = head.colours.pens;
  const rows = rowsLike(stage, stages, h);
  const axes = axesOf(stage, h), curve = (stage && stage.curve) || {}, way = curve.along;
  const record = curve.kind === 'earthquake' && recordOf(stage, directionOf(curve));
  const count = record ? 4 : 2;
  const width = Math.max(CHART.narrowest, Math.min(CHART.widest, Math.floor((parent.clientWidth - (count - 1) * CHART.gap) / count) - 2));
  const made = axes.map(([x, y]) => new Curve(parent, width, rows, rows.map(i => h[x.key][i] * x.factor),
    [{values: rows.map(i => (y.at ? y.at(i) : h[y.key][i]) * y.factor)}], x.label, y.label, pens));
  if (record) {
    const begin = h.time_s[h.stage.indexOf(stages.indexOf(stage) + 1)], times = record.record.time_s.map(t => begin + t), last = h.time_s[rows[rows.length - 1]];
    const within = times.filter(t => t <= last).length, {period_s: periods, damping} = record.spectrum;
    made.push(new Curve(parent, width, times.slice(0, within).map(t => rowAt(h, t)), times.slice(0, within),
      [{values: record.record.acceleration_m_per_s2.slice(0, within)}], 'time [s]', `ground acceleration along ${way} [m/s\u00b2]`, pens));
    made.push(new Curve(parent, width, null, periods, [{values: record.spectrum.pseudo_acceleration_m_per_s2}], 'period [s]',
      `pseudo-acceleration, ${Math.round(100 * damping)} % damping [m/s\u00b2]`, pens));
  }
  if (made.length > 1) return made;
  const energies = ENERGIES.filter(([key]) => h[key] && h[key].some(value => value !== 0)).map(([key, name]) => ({name, values: h[key]}));
  made.push(new Curve(parent, width, h.time_s.map((_, i) => i), h.time_s, energies, 'time [s]', 'energy [J]', pens));
  return made;
}
