'use strict';
// The page of a run: three.js draws what report.cpp has gathered. One slider moves all runs of the page.

const COLD = [59, 76, 192], MIDDLE = [224, 217, 205], WARM = [180, 4, 38];
const UNITS = {damage: ['', 1], opening: ['mm', 1e3], slip: ['mm', 1e3], stress: ['MPa', 1e-6], displacement: ['mm', 1e3]};
const ENERGIES = [['kinetic_energy_J', 'kinetic'], ['strain_energy_J', 'strain'], ['contact_energy_J', 'joints'],
  ['dissipated_tension_J', 'tension'], ['dissipated_cohesion_J', 'cohesion'], ['dissipated_friction_J', 'friction'],
  ['dissipated_crushing_J', 'crushing'], ['damping_work_J', 'damping'], ['external_work_J', 'external work']];
const PENS = ['#1d3557', '#d1495b', '#5aa9e6', '#e8a33d', '#2a9d8f', '#8d6a9f', '#777777', '#b08968', '#000000'];
const byId = id => document.getElementById(id);

// From -1 to 1, to red, green, blue in 0..1: nothing is grey, and what is less than nothing blue.
function colourAt(t) {
  const to = t < 0 ? COLD : WARM;
  return MIDDLE.map((c, k) => (c + Math.min(1, Math.abs(t)) * (to[k] - c)) / 255);
}

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).arrayBuffer();
}

function element(parent, tag, properties = {}) {
  const made = Object.assign(document.createElement(tag), properties);
  parent.appendChild(made);
  return made;
}

// A row of the history at or after a time.
function rowAt(history, time) {
  const times = history.time_s;
  let row = times.findIndex(t => t >= time * (1 - 1e-9));
  return row < 0 ? times.length - 1 : row;
}

// A number beside an axis: what is nothing to its range is 0.
function shortly(value, [low, high]) {
  return Math.abs(value) < 1e-3 * (high - low) ? '0' : String(Number(value.toPrecision(3)));
}

// Lines over a common x, with a dot on each where x was at a row.
class Curve {
  constructor(parent, xs, lines, xLabel, yLabel) {
    this.canvas = element(parent, 'canvas', {className: 'curve', width: 420, height: 240});
    this.xs = xs; this.lines = lines; this.labels = [xLabel, yLabel];
    const all = lines.flatMap(l => l.values);
    const limits = values => {
      const low = values.reduce((a, b) => Math.min(a, b), 0), high = values.reduce((a, b) => Math.max(a, b), 0);
      return high > low ? [low, high] : [low, low + 1];
    };
    this.x = limits(xs); this.y = limits(all);
    this.top = 25 + 12 * Math.ceil(lines.filter(l => l.name).length / 4);  // their names stand above
  }
  place(x, y) {
    const [left, right] = this.x, [low, high] = this.y;
    return [60 + (x - left) / (right - left) * 340, 205 - (y - low) / (high - low) * (205 - this.top)];
  }
  draw(row) {
    const c = this.canvas.getContext('2d');
    c.clearRect(0, 0, 420, 240);
    c.font = '11px sans-serif'; c.fillStyle = '#222'; c.strokeStyle = '#ccc'; c.lineWidth = 1;
    for (const k of [0, 0.5, 1]) {
      const y = this.y[0] + k * (this.y[1] - this.y[0]), x = this.x[0] + k * (this.x[1] - this.x[0]);
      const [left, level] = this.place(this.x[0], y), [across] = this.place(x, this.y[0]);
      c.beginPath(); c.moveTo(left, level); c.lineTo(405, level); c.stroke();
      c.textAlign = 'right'; c.fillText(shortly(y, this.y), 50, level + 4);
      c.textAlign = 'center'; c.fillText(shortly(x, this.x), across, 220);
    }
    c.fillText(this.labels[0], 230, 235);
    c.textAlign = 'left'; c.fillText(this.labels[1], 4, 12);
    this.dots = [];
    this.lines.forEach((line, n) => {
      c.strokeStyle = c.fillStyle = PENS[n % PENS.length]; c.lineWidth = 1.5;
      c.beginPath();
      line.values.forEach((v, i) => c.lineTo(...this.place(this.xs[i], v)));
      c.stroke();
      if (line.name) c.fillText(line.name, 60 + 82 * (n % 4), 25 + 12 * Math.floor(n / 4));
      const dot = this.place(this.xs[row], line.values[row]);
      c.beginPath(); c.arc(...dot, 4, 0, 2 * Math.PI); c.fill();
      this.dots.push(dot);
    });
  }
}

class Run {
  constructor(head, buffer) {
    this.head = head; this.buffer = buffer;
    this.vertices = this.array('position').length / 3;
    this.reference = new THREE.Box3().setFromArray(this.array('position'));
    const box = element(byId('runs'), 'div', {className: 'run'});
    element(box, 'h2', {textContent: head.summary.title || head.name});
    this.model = element(box, 'div', {className: 'model'});
    this.build();
    const curves = element(box, 'div', {className: 'curves'}), h = head.history;
    this.curve = typeof head.summary.peak_vertical_force_N === 'number'
      ? new Curve(curves, h.vertical_displacement_m.map(u => u * 1e3), [{values: h.vertical_force_N.map(f => f / 1e3)}],
        'displacement up [mm]', 'vertical force, compression positive [kN]')
      : new Curve(curves, h.displacement_m.map(u => u * 1e3), [{values: h.horizontal_force_N.map(f => f / 1e3)}],
        'displacement [mm]', 'horizontal force [kN]');
    const energies = ENERGIES.filter(([key]) => h[key]).map(([key, name]) => ({name, values: h[key]}));
    this.energies = new Curve(curves, h.time_s, energies, 'time [s]', 'energy [J]');
    this.tell(box);
  }
  array(name) {
    const a = this.head.arrays[name];
    return a ? new globalThis[a.type](this.buffer, a.offset, a.count) : new Float32Array(0);
  }
  get frames() { return this.head.times.length; }
  build() {
    this.renderer = new THREE.WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    this.renderer.setClearColor(0xfbfbfa);
    this.model.appendChild(this.renderer.domElement);
    this.legend = element(this.model, 'div', {className: 'legend'});
    const size = this.reference.getSize(new THREE.Vector3()), centre = this.reference.getCenter(new THREE.Vector3());
    this.size = size.length();
    this.camera = new THREE.PerspectiveCamera(35, 1, 0.01 * this.size, 20 * this.size);
    this.camera.position.copy(centre).add(new THREE.Vector3(0.25, 0.2, 1).normalize().multiplyScalar(1.6 * this.size));
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.target.copy(centre);
    this.controls.update();
    this.controls.addEventListener('change', () => this.paint());
    this.scene = new THREE.Scene();
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x999990, 0.75));
    const sun = new THREE.DirectionalLight(0xffffff, 0.45);
    sun.position.set(1, 2, 3);
    this.scene.add(sun);
    this.position = new THREE.BufferAttribute(this.array('position').slice(), 3);
    this.colour = new THREE.BufferAttribute(new Float32Array(3 * this.vertices), 3);
    const surface = new THREE.BufferGeometry();
    surface.setAttribute('position', this.position);
    surface.setAttribute('color', this.colour);
    surface.setIndex(new THREE.BufferAttribute(this.array('triangle'), 1));
    this.scene.add(new THREE.Mesh(surface, new THREE.MeshPhongMaterial({vertexColors: THREE.VertexColors, flatShading: true,
      side: THREE.DoubleSide, shininess: 5, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1})));
    const edges = new THREE.BufferGeometry();
    edges.setAttribute('position', this.position);
    edges.setIndex(new THREE.BufferAttribute(this.array('edge'), 1));
    this.scene.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: 0x666660, transparent: true,
      opacity: 0.35})));
    this.rim = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial(
      {vertexColors: THREE.VertexColors, depthFunc: THREE.LessEqualDepth}));
    this.dots = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial(
      {vertexColors: THREE.VertexColors, size: 0.008 * this.size}));
    for (const thing of [this.rim, this.dots]) { thing.frustumCulled = false; this.scene.add(thing); }
    surface.computeBoundingSphere();
    for (const thing of this.scene.children) thing.frustumCulled = false;
    this.resize();
  }
  resize() {
    const width = this.model.clientWidth, height = this.model.clientHeight;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
  }
  // The magnification at which the model is seen to move.
  get natural() {
    const moved = this.head.range.moved;
    return moved > 0.05 * this.size ? 1 : moved > 0 ? Number((0.04 * this.size / moved).toPrecision(1)) : 1;
  }
  // frame of this run; what colours it; magnification; whether cracks are drawn
  show(frame, what, magnified, cracks) {
    this.frame = frame;
    const start = this.array('position'), moved = this.array('moved' + frame);
    const step = this.head.range.moved / 32767, to = this.position.array, paint = this.colour.array;
    for (let i = 0; i < to.length; ++i) to[i] = start[i] + magnified * step * moved[i];
    const stored = what === 'displacement' ? null : this.array(what + frame);
    const [low, high] = what === 'displacement' ? [0, this.head.range.moved] : this.head.range[what];
    const most = Math.max(-low, high) || 1;
    for (let v = 0; v < this.vertices; ++v) {
      const value = stored ? low + stored[v] / 255 * (high - low)
        : step * Math.hypot(moved[3 * v], moved[3 * v + 1], moved[3 * v + 2]);
      paint.set(colourAt(value / most), 3 * v);
    }
    this.position.needsUpdate = this.colour.needsUpdate = true;
    this.drawCracks(frame, magnified, cracks);
    const [unit, factor] = UNITS[what];
    this.legend.textContent = '';
    const css = t => `rgb(${colourAt(t).map(c => Math.round(255 * c))})`;
    element(this.legend, 'div', {className: 'scale'}).style.background =
      `linear-gradient(to right, ${css(low / most)}, ${css(0)} ${100 * -low / (high - low || 1)}%, ${css(high / most)})`;
    element(this.legend, 'div', {textContent: `${(low * factor).toPrecision(3)} to ${(high * factor).toPrecision(3)} ${unit}`});
    if (cracks) for (const {label, colour} of this.head.cracks.slice(1)) {
      element(this.legend, 'div', {textContent: '\u25a0 ' + label}).style.color = colour;
    }
    const row = rowAt(this.head.history, this.head.times[frame]);
    this.curve.draw(row); this.energies.draw(row);
    this.paint();
  }
  // Intact places are not drawn. On the lattice lines where joints come to the surface; elsewhere points.
  drawCracks(frame, magnified, cracks) {
    const rim = this.array('rim'), moved = this.array('rim_moved' + frame), kind = this.array('crack' + frame);
    const step = this.head.range.rim_moved / 32767, at = [], paint = [];
    for (let s = 0; cracks && moved.length === rim.length && s < kind.length; s += 2) {
      if (kind[s] === 0 || kind[s + 1] === 0) continue;
      const colour = new THREE.Color(this.head.cracks[Math.max(kind[s], kind[s + 1])].colour);
      for (let i = 3 * s; i < 3 * s + 6; ++i) at.push(rim[i] + magnified * step * moved[i]);
      for (let end = 0; end < 2; ++end) paint.push(colour.r, colour.g, colour.b);
    }
    this.fill(this.rim.geometry, at, paint);
    const points = this.array('points' + frame), moved_points = this.array('points_moved' + frame);
    const kinds = this.array('point_crack' + frame), dots = [], stand = [];
    if (cracks) points.forEach((x, i) => stand.push(x + magnified * moved_points[i]));
    for (const k of cracks ? kinds : []) { const c = new THREE.Color(this.head.cracks[k].colour); dots.push(c.r, c.g, c.b); }
    this.fill(this.dots.geometry, stand, dots);
    this.cracked = at.length / 6 + dots.length / 3;
  }
  fill(geometry, at, paint) {
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(at, 3));
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(paint.slice(0, at.length), 3));
  }
  paint() { this.renderer.render(this.scene, this.camera); }
  tell(box) {
    const s = this.head.summary, q = s.quality || {}, told = [];
    if (s.status !== 'done') element(box, 'div', {className: 'fault', textContent: `${s.status}: ${s.message || ''}`});
    if (s.quasi_static && s.quasi_static.why_not) told.push(s.quasi_static.why_not);
    if (s.motion && s.motion.exceeded) told.push(s.motion.exceeded);
    for (const text of told) element(box, 'div', {className: 'warning', textContent: text});
    const table = element(box, 'table'), row = (name, value) => {
      const r = element(table, 'tr');
      element(r, 'td', {textContent: name}); element(r, 'td', {textContent: value});
    };
    row('law', s.law);
    row('peak', `${((s.peak_vertical_force_N ?? s.peak_horizontal_force_N) / 1e3).toFixed(2)} kN at ${(s.displacement_at_peak_m * 1e3).toFixed(3)} mm`);
    if (s.collapse_multiplier) row('collapse multiplier', s.collapse_multiplier.toFixed(4));
    row('known error', q.expected_error ?
      `quality ${q.name}: peak ${(100 * q.expected_error.peak).toFixed(1)} %, curve ${(100 * q.expected_error.curve).toFixed(1)} %` :
      `not known: ${q.why_unknown || ''}`);
    row('model', `${s.blocks} blocks, ${s.zones} zones, ${s.contact_points} contact points`);
    row('run', `${s.steps} steps of ${Number(s.time_step_s).toPrecision(3)} s in ${Number(s.wall_clock_s).toFixed(1)} s, ` +
      `${s.threads} threads, ${s.instruction_set}; quoin ${s.version}`);
    const settings = s.settings || {};
    for (const key of Object.keys(settings)) {
      if (key !== 'stages') row(key, JSON.stringify(settings[key]));
    }
    for (const stage of settings.stages || []) row('stage ' + stage.name, JSON.stringify(stage));
  }
}

async function open() {
  if (location.hash === '#picture') document.body.className = 'picture';  // the model alone, in the whole window
  const heads = [...document.querySelectorAll('script.head')], data = [...document.querySelectorAll('script.data')];
  const runs = [];
  for (let i = 0; i < heads.length; ++i) runs.push(new Run(JSON.parse(heads[i].textContent), await unpack(data[i].textContent)));
  const slider = byId('time'), most = Math.max(...runs.map(r => r.frames)) - 1;
  slider.max = most; slider.value = most;
  byId('magnification').value = Math.min(...runs.map(r => r.natural));
  // Where most joints are dry from the start, damage says nothing.
  const dry = run => run.array('damage0').reduce((sum, d) => sum + d, 0) > 0.3 * 255 * run.vertices;
  if (runs.some(dry)) byId('colour').value = 'displacement';
  const show = () => {
    for (const run of runs) {
      const frame = most > 0 ? Math.round(slider.value / most * (run.frames - 1)) : 0;
      run.show(frame, byId('colour').value, Number(byId('magnification').value) || 0, byId('cracks').checked);
    }
    byId('moment').textContent = runs.map(r => `${r.head.times[r.frame].toPrecision(4)} s`).join(' | ');
  };
  for (const id of ['time', 'colour', 'magnification', 'cracks']) byId(id).addEventListener('input', show);
  let playing = 0;
  byId('play').addEventListener('click', () => {
    if (playing) { clearInterval(playing); playing = 0; byId('play').textContent = 'play'; return; }
    byId('play').textContent = 'stop';
    playing = setInterval(() => { slider.value = Number(slider.value) >= most ? 0 : Number(slider.value) + 1; show(); }, 250);
  });
  window.addEventListener('resize', () => { for (const run of runs) { run.resize(); run.paint(); } });
  show();
  window.quoinRuns = runs;  // for who looks into the page, as its test does
  document.body.dataset.ready = 'yes';
}
open().catch(fault => {
  document.body.dataset.ready = 'no';
  element(document.body, 'div', {className: 'fault', textContent: 'The page cannot be drawn: ' + fault.message});
  throw fault;
});
