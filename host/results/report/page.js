// The page: runs, settings of the bar, and pictures.

async function unpack(text) {
  const letters = atob(text), packed = new Uint8Array(letters.length);
  for (let i = 0; i < packed.length; ++i) packed[i] = letters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).arrayBuffer();
}

class Run {
  // beside: whether the page has other runs; the heading then includes the name of the folder.
  constructor(head, buffer, beside = false) {
    const {title} = head.summary;
    this.head = head;
    this.heading = title && beside && head.name !== title ? `${title} (${head.name})` : title || head.name;
    const arrays = {};
    const array = name => {
      const a = head.arrays[name];
      return arrays[name] = arrays[name] || (a ? new globalThis[a.type](buffer, a.offset, a.count) : new Float32Array(0));
    };
    const box = this.box = element(byId('runs'), 'div', {className: 'run'});
    element(box, 'h2', {textContent: this.heading});
    const holder = element(box, 'div', {className: 'model'});
    this.model = new Model(holder, head, array);
    this.curveBox = element(box, 'div', {className: 'curves'});
    this.curves = [];
    this.followPointer(holder);
    this.tell(element(box, 'div', {className: 'told'}));
  }
  close() { this.box.remove(); this.model.renderer.dispose(); this.model.renderer.forceContextLoss(); }
  get frames() { return this.head.times.length; }
  get stages() { return (this.head.summary.settings || {}).stages || []; }
  rowOf(frame) { return rowAt(this.head.history, this.head.times[frame]); }
  stageOf(frame) { return this.head.history.stage[this.rowOf(frame)] - 1; }
  // Text with the stage and its progress: a displacement, a multiplier, a time.
  momentOf(frame) {
    if (this.head.labels) return this.head.labels[frame];
    const h = this.head.history, row = this.rowOf(frame), s = this.stageOf(frame), stage = this.stages[s];
    const [[x, y] = [{}, {}]] = axesOf(stage, h), told = [`stage ${s + 1} of ${Math.max(this.stages.length, s + 1)}`];
    if (stage && stage.name) told[0] += ` ${stage.name}`;
    if (x.key && x.key !== 'time_s') told.push(`${short(Math.abs(h[x.key][row]) < 1e-9 ? 0 : h[x.key][row] * x.factor)} mm`);
    if (y.key === 'multiplier') told.push(`multiplier ${h.multiplier[row].toFixed(3)}`);
    told.push(`${this.head.times[frame].toPrecision(3)} s`);
    return told.join(', ');
  }
  show(frame, what) {
    if (this.head.labels) return this.model.show(frame, {...what, moment: this.momentOf(frame)});
    const stage = this.stages[this.stageOf(frame)], like = JSON.stringify([stage && stage.curve, this.curveBox.clientWidth]);
    if (like !== this.like) {
      this.curveBox.textContent = '';
      this.curves = curvesOf(this.curveBox, this.head, stage);
      this.like = like;
    }
    for (const curve of this.curves) curve.at(this.rowOf(frame));
    this.model.show(frame, {...what, moment: this.momentOf(frame), loads: (stage && stage.forces) || []});
  }
  followPointer(holder) {
    const tip = element(holder, 'div', {className: 'tip'});
    tip.style.display = 'none';
    let asked = null;
    const tell = () => {
      const [x, y] = asked, told = this.model.tell(x, y);
      asked = null;
      tip.textContent = told.join('\n');
      tip.style.display = told.length ? 'block' : 'none';
      tip.style.left = `${Math.max(0, Math.min(x + 14, holder.clientWidth - (tip.offsetWidth || 0) - 4))}px`;
      tip.style.top = `${Math.max(0, Math.min(y + 14, holder.clientHeight - (tip.offsetHeight || 0) - 4))}px`;
    };
    holder.addEventListener('mousemove', event => {
      if (event.buttons) { tip.style.display = 'none'; return; }
      const box = holder.getBoundingClientRect();
      if (!asked) requestAnimationFrame(tell);
      asked = [event.clientX - box.left, event.clientY - box.top];
    });
    holder.addEventListener('mouseleave', () => { tip.style.display = 'none'; });
  }

  // ---- Words ----
  tell(box) {
    if (this.head.labels) return this.table(box, this.head.labels.map((label, k) => [String(k + 1), label]));
    const s = this.head.summary, q = s.quality || {};
    if (s.status !== 'done' && s.status !== 'running') element(box, 'div', {className: 'fault', textContent: `${s.status}: ${s.message || ''}`});
    const told = (s.warnings || []).map(w => w.text);
    const driven = this.stages.some(stage => (stage.controls || []).length || stage.cycles);
    if (driven && s.quasi_static && s.quasi_static.why_not && !told.some(t => t.includes(s.quasi_static.why_not))) told.push(s.quasi_static.why_not);
    for (const text of told) element(box, 'div', {className: 'warning', textContent: text});
    const peak = s.peak_vertical_force_N ?? s.peak_horizontal_force_N;
    const watched = new Set(this.stages.map(stage => stage.curve && stage.curve.of).filter(of => of));
    const whose = watched.size > 1 && s.peak_of ? ` of ${s.peak_of}` : '';
    const shaken = s.response;
    const rows = [['law', s.law], shaken ?
      ['response', `${shaken.of} moves ${(shaken.displacement_m * 1e3).toFixed(3)} mm along ${shaken.axis} against the ground ` +
        `(at ${shaken.displacement_at_s.toFixed(3)} s), base force ${(shaken.base_force_N / 1e3).toFixed(2)} kN (at ${shaken.base_force_at_s.toFixed(3)} s)`] :
      ['peak', peak === null ? 'none: no block is watched' : `${(peak / 1e3).toFixed(2)} kN at ${(s.displacement_at_peak_m * 1e3).toFixed(3)} mm${whose}`]];
    if (s.collapse_multiplier) rows.push(['collapse multiplier', s.collapse_multiplier.toFixed(4)]);
    rows.push(['known error', q.expected_error ?
      `quality ${q.name}: peak ${(100 * q.expected_error.peak).toFixed(1)} %, curve ${(100 * q.expected_error.curve).toFixed(1)} %` :
      `not known: ${q.why_unknown || ''}`]);
    rows.push(['model', `${s.blocks} blocks, ${s.zones} zones, ${s.contact_points} contact points`]);
    rows.push(['run', `${s.steps} steps of ${Number(s.time_step_s).toPrecision(3)} s in ${Number(s.wall_clock_s).toFixed(1)} s, ` +
      `${s.threads} threads, ${s.instruction_set}; quoin ${s.version}`]);
    if (s.set && s.set.length) rows.push(['changed', s.set.join(', ')]);
    this.table(box, rows);
    this.table(box, this.stages.map((stage, i) => [`${i + 1} ${stage.name || ''}`, this.drivenBy(stage), this.endOf(stage),
      `${stage.damping} ${short(stage.local_damping)}`]), ['stage', 'moved or loaded', 'ends', 'damping']);
    const fold = element(box, 'details');
    element(fold, 'summary', {textContent: 'all settings (JSON)'});
    element(fold, 'pre', {textContent: JSON.stringify(s.settings || {}, (key, value) => key === 'record' || key === 'spectrum' ? undefined : value, 1)});
  }
  table(box, rows, heads = null) {
    if (!rows.length) return;
    const table = element(box, 'table');
    if (heads) { const r = element(table, 'tr'); for (const h of heads) element(r, 'th', {textContent: h}); }
    for (const cells of rows) { const r = element(table, 'tr'); for (const c of cells) element(r, 'td', {textContent: c}); }
  }
  drivenBy(stage) {
    const told = [];
    for (const c of stage.controls || []) {
      c.velocity_m_per_s.forEach((v, k) => {
        if (typeof v === 'number' && v !== 0) told.push(`${c.body} ${short(v * 1e3)} mm/s along ${'xyz'[k]}`);
        if (v === 'free' && c.force_N[k]) told.push(`${c.body} ${short(c.force_N[k] / 1e3)} kN along ${'xyz'[k]}`);
      });
    }
    for (const f of stage.forces || []) told.push(`${f.block} ${f.force_N.map(n => short(n / 1e3)).join(', ')} kN (x, y, z)`);
    if (stage.cycles) told.push(`cycles of ${stage.cycles.amplitudes_m.map(a => short(a * 1e3)).join(', ')} mm`);
    if (stage.ground_motion) told.push(`ground motion along ${stage.ground_motion.direction.map(x => short(x)).join(', ')}`);
    if (stage.curve && stage.curve.kind === 'collapse') told.push('a horizontal share of gravity that grows');
    return told.join('; ') || '\u2013';
  }
  endOf(stage) {
    const told = [];
    if (stage.displacement_m !== undefined) told.push(`at ${short(stage.displacement_m * 1e3)} mm`);
    if (stage.duration_s !== undefined) told.push(`after ${short(stage.duration_s)} s`);
    if (stage.equilibrium_ratio !== undefined) told.push(`at equilibrium, ${short(stage.equilibrium_ratio)}`);
    return told.join(' or ') || '\u2013';
  }
}

// Ranges of a quantity over all runs of the page, which share their colours.
class Ranges {
  constructor(runs) { this.runs = runs; this.known = {}; }
  whole(quantity) {
    const all = this.runs.map(r => quantity === 'displacement' ? [0, this.farthest(r)] : r.head.range[quantity]);
    return [Math.min(0, ...all.map(a => a[0])), Math.max(0, ...all.map(a => a[1]))];
  }
  farthest(run) {
    if (run.model.grounded < 0) return run.head.largest_displacement;
    let most = 0;
    for (let f = 0; f < run.frames; ++f) for (const value of run.model.values(f, 'displacement')) most = Math.max(most, value);
    return most;
  }
  // Range of 98 % of the values other than 0 in each moment, so that single values do not set the colours.
  robust(quantity) {
    if (quantity === 'damage') return [0, 1];
    if (!this.known[quantity]) this.known[quantity] = this.tidy(quantity, this.within(quantity, r => [...Array(r.frames).keys()]));
    return this.known[quantity];
  }
  moment(quantity) { return this.tidy(quantity, this.within(quantity, r => [r.model.frame || 0])); }
  // Largest range of any run and moment. So neither runs with more blocks nor moments with small values set it.
  within(quantity, framesOf) {
    const most = [0, 0];
    for (const run of this.runs)
      for (const f of framesOf(run)) this.sidesOf(run, quantity, f).forEach((side, k) => { most[k] = Math.max(most[k], side); });
    return most;
  }
  // Largest values below and above 0 in a frame, for 98 % of values.
  sidesOf(run, quantity, frame) {
    const sides = [[], []], values = run.model.values(frame, quantity);
    const every = Math.max(1, Math.floor(values.length * run.frames / 4e5));
    for (let v = 0; v < values.length; v += every) if (values[v] !== 0) sides[values[v] < 0 ? 0 : 1].push(Math.abs(values[v]));
    const total = sides[0].length + sides[1].length;
    // A side with few values has no colours of its own.
    return sides.map(side => side.length < 0.01 * total || !total ? 0 : Float64Array.from(side).sort()[Math.floor(0.98 * (side.length - 1))]);
  }
  // The range, rounded up to two digits.
  tidy(quantity, [below, above]) {
    const up = x => { if (!x) return 0; const power = 10 ** Math.floor(Math.log10(x) - 1); return Math.ceil(x / power - 1e-9) * power; };
    const range = [-up(below), up(above)];
    return range[0] === range[1] ? [0, 1 / QUANTITIES[quantity].factor] : range;
  }
}

// Frame of another run that corresponds to frame `of` of the first: in the same stage, at the same displacement of the
// driven part, or at the same time in the stage. First and last frames correspond.
function frameLike(first, of, other) {
  if (of === 0) return 0;
  if (of === first.frames - 1) return other.frames - 1;
  const stage = first.stageOf(of), begin = (run, s) => run.head.history.time_s[run.head.history.stage.indexOf(s + 1)];
  const comes = (run, f) => {
    const [[x]] = axesOf(run.stages[stage], run.head.history);
    return x.key === 'time_s' ? run.head.times[f] - begin(run, stage) : Math.abs(run.head.history[x.key][run.rowOf(f)]);
  };
  const frames = [...Array(other.frames).keys()].filter(f => other.stageOf(f) === stage);
  if (!frames.length || (first.stages[stage] || {}).cycles) return Math.round(of / (first.frames - 1) * (other.frames - 1));
  const away = f => Math.abs(comes(other, f) - comes(first, of));
  return frames.reduce((a, b) => away(b) < away(a) ? b : a);
}

// Draws models and curves of the page in one picture on a canvas.
async function paintPicture(runs, canvas, scale) {
  const gap = 10, width = runs.reduce((w, r) => w + r.model.width + gap, gap);
  const tallest = Math.max(...runs.map(r => r.model.height)), curve = 260, height = tallest + 40 + curve;
  const even = x => 2 * Math.round(x / 2);  // video needs even sides
  if (canvas.width !== even(scale * width)) canvas.width = even(scale * width);
  if (canvas.height !== even(scale * height)) canvas.height = even(scale * height);
  const images = new Map(), drawings = runs.flatMap(r => [[r.model.overlay, r.model.width, r.model.height],
    ...r.curves.map(c => [c.svg, c.width, CHART.height])]);
  await Promise.all(drawings.map(async ([svg, w, h]) => {
    const copy = svg.cloneNode(true), image = new Image();
    copy.setAttribute('width', scale * w); copy.setAttribute('height', scale * h);
    image.src = 'data:image/svg+xml;charset=utf-8,' + encodeURIComponent(new XMLSerializer().serializeToString(copy));
    await image.decode();
    images.set(svg, image);
  }));
  const c = canvas.getContext('2d');
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.fillStyle = '#fff'; c.fillRect(0, 0, width, height);
  let x = gap;
  for (const run of runs) {
    const m = run.model;
    c.fillStyle = '#222'; c.font = '600 16px sans-serif';
    c.fillText(run.heading, x, 24, m.width);
    c.drawImage(m.renderer.domElement, x, 34, m.width, m.height);
    c.drawImage(images.get(m.overlay), x, 34, m.width, m.height);
    let left = x;
    for (const {svg, width: wide} of run.curves) { c.drawImage(images.get(svg), left, tallest + 44, wide, CHART.height); left += wide + gap; }
    x += m.width + gap;
  }
}

class Bar {
  constructor(runs) {
    this.playing = 0; this.swung = 1;
    this.take(runs);
    byId('time').value = this.longest.frames - 1;
    byId('magnification').value = Math.min(...runs.map(r => r.model.magnification));
    // Damage has no meaning where most joints are dry from the start.
    const dry = run => run.model.array('damage0').reduce((sum, d) => sum + d, 0) > 0.3 * 255 * run.model.vertices;
    if (runs.some(dry)) byId('colour').value = 'displacement';
    for (const id of ['time', 'colour', 'range', 'magnification', 'cracks', 'forces', 'cut', 'cutat']) byId(id).addEventListener('input', () => this.show());
    for (const id of ['lowest', 'highest']) byId(id).addEventListener('input', () => { byId('range').value = 'given'; this.show(); });
    byId('play').addEventListener('click', () => this.play());
    byId('save').addEventListener('click', () => this.save());
    const still = runs.some(r => r.head.labels);  // motions that are not of a run oscillate from the start
    if (still) {
      byId('colour').value = 'displacement'; byId('time').value = 0;
      for (const id of ['colour', 'range', 'lowest', 'highest', 'cracks']) byId(id).disabled = true;
    }
    byId('film').addEventListener('click', () => this.film());
    byId('forces').disabled = !runs.some(r => r.model.forces.known);
    for (const button of document.querySelectorAll('#views button'))
      button.addEventListener('click', () => { for (const run of this.runs) run.model.look(button.dataset.view); });
    window.addEventListener('resize', () => { for (const run of this.runs) { run.model.resize(); run.model.fit(); } this.show(); });
    this.show();
    for (const run of runs) run.model.look(run.model.natural);
    if (still && location.hash !== '#picture') this.play();
  }
  take(runs) {
    this.runs = runs; this.ranges = new Ranges(runs);
    this.longest = runs.reduce((a, b) => b.frames > a.frames ? b : a);
    byId('time').max = this.longest.frames - 1;
  }
  // New frames of the same runs. A slider at the last frame moves to the new last frame.
  renew(runs) {
    const slider = byId('time'), atEnd = Number(slider.value) >= this.longest.frames - 1;
    this.take(runs);
    if (atEnd) {
      slider.value = this.longest.frames - 1;
      byId('magnification').value = Math.min(...runs.map(r => r.model.magnification));
    }
    this.show();
  }
  range(quantity) {
    const how = byId('range').value, {factor, unit} = QUANTITIES[quantity];
    if (this.longest.head.labels) return [0, 1];
    byId('unit').textContent = unit;
    const given = [Number(byId('lowest').value) / factor, Number(byId('highest').value) / factor];
    if (how === 'given' && given[1] > given[0]) return given;
    const [low, high] = how === 'given' ? this.ranges.robust(quantity) : this.ranges[how](quantity);
    if (how !== 'given') { byId('lowest').value = Number((low * factor).toPrecision(4)); byId('highest').value = Number((high * factor).toPrecision(4)); }
    return [low, high > low ? high : low + 1 / factor];
  }
  show() {
    const at = Number(byId('time').value), quantity = byId('colour').value;
    if (this.quantity !== quantity && byId('range').value === 'given') byId('range').value = 'robust';
    this.quantity = quantity;
    const frames = this.runs.map(run => run === this.longest ? at : frameLike(this.longest, at, run));
    this.runs.forEach((run, k) => { run.model.frame = frames[k]; });
    const [low, high] = this.range(quantity);
    this.runs.forEach((run, k) => run.show(frames[k], {quantity, low, high, magnified: (Number(byId('magnification').value) || 0) * this.swung,
      cracks: byId('cracks').checked, forces: byId('forces').value,
      cut: byId('cut').value === 'none' || !byId('cut').value ? null : {axis: Number(byId('cut').value), share: Number(byId('cutat').value) / 100}}));
    byId('moment').textContent = this.runs.map((run, k) => run.momentOf(frames[k])).join(' | ');
  }
  play() {
    if (this.playing) { clearInterval(this.playing); this.playing = 0; this.swung = 1; byId('play').textContent = 'play'; this.show(); return; }
    byId('play').textContent = 'stop';
    if (this.longest.head.labels) { this.playing = setInterval(() => this.swing(), 40); return; }
    const slider = byId('time');
    this.playing = setInterval(() => {
      slider.value = Number(slider.value) >= this.longest.frames - 1 ? 0 : Number(slider.value) + 1;
      this.show();
    }, 250);
  }
  // Oscillates: a mode to both sides, a mechanism to one side.
  swing() {
    const phase = 2 * Math.PI * performance.now() / 2000;
    this.swung = this.longest.head.summary.one_way ? (1 - Math.cos(phase)) / 2 : Math.sin(phase);
    this.show();
  }
  async save() {
    const link = document.createElement('a');
    const canvas = document.createElement('canvas');
    await paintPicture(this.runs, canvas, 2);
    link.href = this.saved = canvas.toDataURL('image/png');
    link.download = this.runs.map(r => r.head.name).join('_') + '.png';
    link.click();
  }
  // Records all frames one after the other, as WebM.
  async film(pause = 200) {
    const canvas = document.createElement('canvas'), link = document.createElement('a'), pieces = [], slider = byId('time'), at = slider.value;
    await paintPicture(this.runs, canvas, 1);
    const recorder = new MediaRecorder(canvas.captureStream(25), {videoBitsPerSecond: 8e6});
    const done = new Promise(resolve => { recorder.onstop = resolve; });
    recorder.ondataavailable = event => pieces.push(event.data);
    recorder.start();
    byId('film').disabled = true;
    for (slider.value = 0; ; slider.value = Number(slider.value) + 1) {
      this.show();
      await paintPicture(this.runs, canvas, 1);
      const last = Number(slider.value) >= this.longest.frames - 1;
      await new Promise(resolve => setTimeout(resolve, last ? 4 * pause : pause));
      if (last) break;
    }
    recorder.stop();
    await done;
    byId('film').disabled = false;
    slider.value = at; this.show();
    this.filmed = new Blob(pieces, {type: 'video/webm'});
    link.href = URL.createObjectURL(this.filmed);
    link.download = this.runs.map(r => r.head.name).join('_') + '.webm';
    link.click();
  }
}

// A running simulation: requests its state every second, and the model after each new frame.
async function follow() {
  const told = element(document.body, 'div', {id: 'live', textContent: 'the run begins'});
  document.body.insertBefore(told, byId('runs'));
  for (let frames = 0, missed = 0; missed < 3;) {
    try {
      const state = await (await fetch('state')).json();
      told.textContent = liveText(state);
      if (state.frames > frames) {
        const {head, data} = await (await fetch('run')).json();
        frames = head.times.length;
        renew(new Run(head, await unpack(data)));
      }
      missed = 0;
    } catch (fault) { ++missed; }
    await new Promise(resolve => setTimeout(resolve, 1000));
  }
  told.textContent += '. The run has ended: quoin report makes a page of its folder';
  document.body.dataset.live = 'ended';
}
function liveText(state) {
  if (!state.stage) return 'the first steps are taken';
  const left = state.seconds_left >= 0 ? `, ${short(state.seconds_left)} s left of it` : '';
  return `stage ${state.stage} of ${state.stages} ${state.name}: ${Math.round(100 * state.fraction)} %${left}; ` +
    `${short(1e3 * state.displacement_m)} mm, ${short(state.force_N / 1e3)} kN, peak so far ${short(state.peak_N / 1e3)} kN at ` +
    `${short(1e3 * state.displacement_at_peak_m)} mm; ${short(100 * state.cracked)} % of contact points no longer elastic; ` +
    `kinetic energy ${short(state.kinetic_energy_J)} J`;
}
// Replaces the run on the page by its newer state, with the same view.
function renew(run) {
  const old = window.quoinRuns && window.quoinRuns[0], bar = window.quoinBar;
  window.quoinRuns = [run];
  if (!old) {
    window.quoinBar = new Bar([run]);
    document.body.dataset.ready = 'yes';
    return;
  }
  run.model.seenAs(old.model);
  old.close();
  bar.renew([run]);
}

async function open() {
  if (location.hash === '#picture') document.body.className = 'picture';  // only the model, in the whole window
  if (document.querySelectorAll('script.live').length) return follow();
  const heads = [...document.querySelectorAll('script.head')], data = [...document.querySelectorAll('script.data')], runs = [];
  for (let i = 0; i < heads.length; ++i) runs.push(new Run(JSON.parse(heads[i].textContent), await unpack(data[i].textContent), heads.length > 1));
  window.quoinRuns = runs;  // for access from outside, as by tests
  window.quoinBar = new Bar(runs);
  document.body.dataset.ready = 'yes';
}
open().catch(fault => {
  document.body.dataset.ready = 'no';
  element(document.body, 'div', {className: 'fault', textContent: 'The page cannot be drawn: ' + fault.message});
  throw fault;
});
