// The model of a run in three dimensions: its surface, cracks, view, labels, and the values under the pointer.

const VIEWS = {front: [0, 0, 1], side: [1, 0, 0], top: [0, 1, 0], iso: [0.55, 0.45, 1]};
const EDGE = {legend: 240, below: 62, around: 14};  // pixels of the picture that the model leaves free
const LOWEST = 280, ROOM = 70;  // pixels: height of the picture; height of title, borders and gaps around it
const LARGE = 1e5;  // vertices, of some 12,000 blocks
const TINY = 6;  // pixels of a block; of smaller ones the edges would hide the faces
// Light from the viewer: faces towards the viewer have the colours of the legend.
const FACE_SHADER = `varying vec3 tint, place;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  tint = color; place = seen.xyz;
  gl_Position = projectionMatrix * seen;
}`;
const LIGHT_SHADER = `varying vec3 tint, place; uniform float opacity;
void main() {
  vec3 across = cross(dFdx(place), dFdy(place));
  gl_FragColor = vec4(tint * (0.55 + 0.45 * abs(across.z) / max(length(across), 1e-30)), opacity);
}`;
const PICKED = 4;  // pixels on each side of a square that is searched for a block

class Model {
  constructor(parent, head, array) {
    this.head = head; this.array = array; this.holder = parent;
    this.vertices = array('position').length / 3;
    const box = new THREE.Box3().setFromArray(array('position'));
    this.size = box.getSize(new THREE.Vector3()).length();
    this.renderer = new THREE.WebGLRenderer({antialias: this.vertices < LARGE, preserveDrawingBuffer: true});
    this.renderer.setClearColor(0xfbfbfa);
    parent.appendChild(this.renderer.domElement);
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -20 * this.size, 40 * this.size);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    box.getCenter(this.controls.target);
    const sizes = this.boxes(array('position')).filter(b => b).map(b => Math.max(...b.high.map((h, k) => h - b.low[k])));
    this.block = sizes.sort((a, b) => a - b)[Math.floor(sizes.length / 2)];  // median size of blocks, m
    this.scene = new THREE.Scene();
    this.build();
    this.forces = new Forces(this);
    this.scene.add(this.forces.mesh);
    this.members = new Members(this);
    this.scene.add(this.members.mesh);
    this.overlay = drawing(parent);
    this.resize();
    this.controls.addEventListener('change', () => this.paintSoon());
    // Details that slow down large models are hidden while the model turns.
    this.controls.addEventListener('start', () => { this.turning = this.vertices > LARGE; });
    this.controls.addEventListener('end', () => { this.turning = false; this.paintSoon(); });
  }
  build() {
    this.position = new THREE.BufferAttribute(this.array('position').slice(), 3);
    this.colour = new THREE.BufferAttribute(new Float32Array(3 * this.vertices), 3);
    const surface = new THREE.BufferGeometry();
    surface.setAttribute('position', this.position);
    surface.setAttribute('color', this.colour);
    surface.setIndex(new THREE.BufferAttribute(this.array('triangle'), 1));
    this.skin = new THREE.ShaderMaterial({vertexShader: FACE_SHADER, fragmentShader: LIGHT_SHADER,
      uniforms: {opacity: {value: 1}}, extensions: {derivatives: true}, vertexColors: THREE.VertexColors, side: THREE.DoubleSide,
      polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1, transparent: true});
    this.surface = new THREE.Mesh(surface, this.large ? [this.skin] : this.skin);
    this.scene.add(this.surface);
    const edges = new THREE.BufferGeometry();
    edges.setAttribute('position', this.position);
    edges.setIndex(new THREE.BufferAttribute(this.array('edge'), 1));
    this.edges = new THREE.LineSegments(edges, new THREE.LineBasicMaterial({color: 0x555550, transparent: true, opacity: 0.5}));
    this.scene.add(this.edges);
    this.cracks = new Cracks(this);
    for (const thing of this.scene.children) thing.frustumCulled = false;
    this.buildPicking();
  }
  // Hides blocks whose centre is beyond a share of the model along an axis (0, 1, 2); null: hides none.
  cut(axis, share) {
    const key = axis === null ? '' : `${axis} ${share}`;
    if (key === (this.cutKey || '')) return;
    this.cutKey = key;
    const centre = this.forces.centre.map(c => c ? c[axis || 0] : 0), moving = this.forces.boxes.filter(b => b && b.moves);
    const low = Math.min(...moving.map(b => b.low[axis || 0])), high = Math.max(...moving.map(b => b.high[axis || 0]));
    this.left = axis === null ? null : centre.map(c => c > low + share * (high - low));
    const block = this.array('block'), kept = (index, size) => {
      if (!this.left) return new THREE.BufferAttribute(index, 1);
      const to = [];
      for (let i = 0; i < index.length; i += size)
        if (!this.left[block[index[i]]]) for (let k = 0; k < size; ++k) to.push(index[i + k]);
      return new THREE.BufferAttribute(Uint32Array.from(to), 1);
    };
    if (!this.large) this.showFaces(kept(this.array('triangle'), 3));
    this.edges.geometry.setIndex(kept(this.array('edge'), 2));
    this.limit = axis === null ? null : {axis, at: low + share * (high - low)};
  }
  // Large models are drawn without covered faces, if joints are known.
  get large() { return this.vertices > LARGE && this.array('joint_area0').length > 0; }
  showFaces(index) { this.surface.geometry.setIndex(index); this.picking.children[0].geometry.setIndex(index); }
  showSeen(frame, magnified) {
    const key = [frame, magnified, this.cutKey].join(' ');
    if (!this.large || key === this.seenKey) return;
    this.seenKey = key;
    this.faces = this.faces || new Faces(this);
    this.showFaces(new THREE.BufferAttribute(this.faces.seen(frame, magnified), 1));
  }
  hidden(block) { return Boolean(this.left && this.left[block]); }
  // The surface for picking: each block has a colour that encodes its number.
  buildPicking() {
    const block = this.array('block'), ids = new Uint8Array(3 * this.vertices), surface = new THREE.BufferGeometry();
    for (let v = 0; v < this.vertices; ++v)
      for (let k = 0; k < 3; ++k) ids[3 * v + k] = (block[v] + 1) >> (8 * k) & 255;
    surface.setAttribute('position', this.position);
    surface.setAttribute('color', new THREE.BufferAttribute(ids, 3, true));
    surface.setIndex(new THREE.BufferAttribute(this.array('triangle'), 1));
    const mesh = new THREE.Mesh(surface, new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors, side: THREE.DoubleSide}));
    mesh.frustumCulled = false;
    this.picking = new THREE.Scene();
    this.picking.background = new THREE.Color(0);
    this.picking.add(mesh);
    this.target = new THREE.WebGLRenderTarget(PICKED, PICKED);
  }
  // Sizes the model so that it fills the window together with the curves.
  resize() {
    const others = byId('bar').offsetHeight + CHART.height + ROOM;
    this.holder.style.height = `${Math.max(LOWEST, window.innerHeight - others)}px`;
    this.width = this.holder.clientWidth; this.height = this.holder.clientHeight;
    this.renderer.setPixelRatio(window.devicePixelRatio || 1);
    this.renderer.setSize(this.width, this.height);
    for (const [key, value] of [['width', this.width], ['height', this.height], ['viewBox', `0 0 ${this.width} ${this.height}`]])
      this.overlay.setAttribute(key, value);
  }

  // ---- Views ----
  // View from the front if all moving blocks share their middle plane, except for shapes that leave the plane.
  get natural() {
    if (this.head.labels && this.head.times.some((_, f) => this.leavesPlane(f))) return 'iso';
    const box = this.boxes(this.array('position'));
    let low = Infinity, high = -Infinity, thick = 0;
    for (const b of box) {
      if (!b || !b.moves) continue;
      const middle = (b.low[2] + b.high[2]) / 2;
      low = Math.min(low, middle); high = Math.max(high, middle); thick = Math.max(thick, b.high[2] - b.low[2]);
    }
    return high - low < 0.25 * thick ? 'front' : 'iso';
  }
  leavesPlane(frame) {
    const moved = this.array('moved' + frame);
    for (let v = 0; v < this.vertices; ++v) if (Math.abs(moved[3 * v + 2]) > 0.5 * 32767) return true;
    return false;
  }
  // By block: the box of its vertices, and whether it has moved in the last frame.
  boxes(position) {
    const block = this.array('block'), all = [];
    for (let v = 0; v < this.vertices; ++v) {
      const b = all[block[v]] = all[block[v]] || {low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity], moves: false};
      for (let k = 0; k < 3; ++k) {
        b.low[k] = Math.min(b.low[k], position[3 * v + k]); b.high[k] = Math.max(b.high[k], position[3 * v + k]);
      }
    }
    const moved = this.array('moved' + (this.head.times.length - 1));
    for (let v = 0; v < this.vertices; ++v)
      if (moved[3 * v] || moved[3 * v + 1] || moved[3 * v + 2]) all[block[v]].moves = true;
    if (!all.some(b => b && b.moves)) all.forEach(b => { b.moves = true; });
    return all;
  }
  // Turns the view to a direction and fits the model into it.
  look(name) {
    this.viewed = name;
    const direction = new THREE.Vector3(...VIEWS[name]).normalize();
    if (name === 'top') direction.z = 1e-4;  // up in the picture is away from the viewer, -z
    this.camera.position.copy(this.controls.target).addScaledVector(direction, this.size);
    this.camera.zoom = 1;
    this.camera.lookAt(this.controls.target);
    this.camera.updateMatrixWorld();
    this.fit();
  }
  // Takes the view of another model of equal blocks.
  seenAs(other) {
    this.viewed = other.viewed;
    for (const key of ['left', 'right', 'top', 'bottom', 'zoom']) this.camera[key] = other.camera[key];
    this.camera.position.copy(other.camera.position); this.camera.quaternion.copy(other.camera.quaternion);
    this.controls.target.copy(other.controls.target);
    this.camera.updateProjectionMatrix();
    this.controls.update();
  }
  // Fits the picture to moving blocks, at the start and now, and to the parts of supports near them.
  fit() {
    const x = new THREE.Vector3(), y = new THREE.Vector3(), z = new THREE.Vector3();
    this.camera.matrixWorld.extractBasis(x, y, z);
    const start = this.array('position'), now = this.position.array, block = this.array('block'), boxes = this.boxes(start);
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    const on = (p, v, axis) => p[3 * v] * axis.x + p[3 * v + 1] * axis.y + p[3 * v + 2] * axis.z;
    const include = (p, moves, most) => {
      const [l, h] = [low.slice(), high.slice()];
      for (let v = 0; v < this.vertices; ++v) {
        const box = boxes[block[v]];
        if (box.moves !== moves || (!moves && box.small !== (most === Infinity))) continue;
        [x, y].forEach((axis, k) => {
          const room = most * reach;
          const at = most === Infinity ? on(p, v, axis) : Math.min(h[k] + room, Math.max(l[k] - room, on(p, v, axis)));
          low[k] = Math.min(low[k], at); high[k] = Math.max(high[k], at);
        });
      }
    };
    const moving = boxes.filter(b => b && b.moves);
    const reach = Math.max(...[0, 1, 2].map(k => Math.max(...moving.map(b => b.high[k])) - Math.min(...moving.map(b => b.low[k]))));
    include(start, true, Infinity); include(now, true, 0.4);
    // Small supports are shown as a whole, large ones as a strip.
    for (const b of boxes) if (b) b.small = Math.max(...b.high.map((h, k) => h - b.low[k])) < 0.5 * reach;
    include(start, false, Infinity); include(start, false, 0.3);
    for (const {point_m, force_N} of ((this.head.summary.settings || {}).stages || []).flatMap(s => s.forces || [])) {
      const tail = this.forces.arrow(point_m, force_N)(1);
      [x, y].forEach((axis, k) => { const at = on(tail, 0, axis); low[k] = Math.min(low[k], at); high[k] = Math.max(high[k], at); });
    }
    const wide = Math.max(high[0] - low[0], 1e-9), tall = Math.max(high[1] - low[1], 1e-9), {legend, below, around} = EDGE;
    const room = [this.width - legend - around, this.height - below - around];
    const scale = Math.max(1e-9, Math.min(Math.max(room[0], 50) / wide, Math.max(room[1], 50) / tall));  // pixels a metre
    const middle = [around + room[0] / 2, around + room[1] / 2];
    const across = (low[0] + high[0]) / 2, up = (low[1] + high[1]) / 2, target = this.controls.target;
    const move = x.clone().multiplyScalar(across - target.dot(x)).addScaledVector(y, up - target.dot(y));
    target.add(move); this.camera.position.add(move);
    Object.assign(this.camera, {left: -middle[0] / scale, right: (this.width - middle[0]) / scale,
      top: middle[1] / scale, bottom: -(this.height - middle[1]) / scale});
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.paint();
  }
  get cracked() { return this.cracks.count; }
  get pixelsPerMetre() { return this.width / (this.camera.right - this.camera.left) * this.camera.zoom; }

  // ---- A frame ----
  // Magnification at which displacements are visible; 1 in large motion.
  get magnification() {
    const moved = this.head.range.moved, {motion} = this.head.summary;
    if (this.head.labels) return Number((0.06 * this.size / (moved || 1)).toPrecision(2));
    if (motion && motion.small_displacements === false || moved === 0) return 1;
    return Math.max(1, roundDown(0.05 * this.size / moved));
  }
  // Index of a vertex of the lowest block, if the ground moves; displacements are relative to it. -1: displacements are
  // absolute.
  get grounded() {
    if (this.groundVertex !== undefined) return this.groundVertex;
    const p = this.array('position'), shaken = this.head.history && this.head.history.ground_dx_m;
    let lowest = 0;
    for (let v = 1; v < this.vertices; ++v) if (p[3 * v + 1] < p[3 * lowest + 1]) lowest = v;
    return this.groundVertex = shaken ? lowest : -1;
  }
  groundAt(moved) { return this.grounded < 0 ? [0, 0, 0] : [0, 1, 2].map(k => moved[3 * this.grounded + k]); }
  valueAt(frame, what, v) {
    if (what === 'displacement') return this.values(frame, what)[v];
    const stored = this.array(what + frame), [low, high] = this.head.range[what];
    if (what === 'damage') return low + stored[v] / 255 * (high - low);
    return Math.max(high, -low) / 32767 * stored[v];
  }
  values(frame, what) {
    const values = new Float32Array(this.vertices);
    if (what === 'displacement') {
      const moved = this.array('moved' + frame), step = this.head.range.moved / 32767, [x, y, z] = this.groundAt(moved);
      for (let v = 0; v < this.vertices; ++v) values[v] = step * Math.hypot(moved[3 * v] - x, moved[3 * v + 1] - y, moved[3 * v + 2] - z);
      return values;
    }
    const stored = this.array(what + frame), [low, high] = this.head.range[what];
    const step = what === 'damage' ? (high - low) / 255 : Math.max(high, -low) / 32767;
    for (let v = 0; v < this.vertices; ++v) values[v] = step * stored[v];
    return values;
  }
  // what: {quantity, low, high, magnified, cracks, moment}
  show(frame, what) {
    this.frame = frame; this.shown = what;
    const start = this.array('position'), moved = this.array('moved' + frame);
    const step = this.head.range.moved / 32767, to = this.position.array, paint = this.colour.array;
    for (let i = 0; i < to.length; ++i) to[i] = start[i] + what.magnified * step * moved[i];
    const values = this.values(frame, what.quantity), scale = this.scaleOf(what);
    for (let v = 0; v < this.vertices; ++v) paint.set(scale(values[v]), 3 * v);
    this.position.needsUpdate = this.colour.needsUpdate = true;
    this.cut(what.cut ? what.cut.axis : null, what.cut ? what.cut.share : 1);
    this.showSeen(frame, what.magnified);
    this.forces.show(frame, what.forces || 'none', what.magnified);
    this.members.show(frame, what.magnified);
    this.skin.uniforms.opacity.value = this.forces.kind === 'none' ? 1 : 0.3;
    this.skin.depthWrite = this.forces.kind === 'none';
    this.cracks.show(frame, what.magnified, what.cracks);
    this.paint();
  }
  // Function from a value to its colour. 0 has the middle colour, if it is in the range.
  scaleOf({low, high}) {
    const zero = Math.min(Math.max(0, low), high), most = Math.max(zero - low, high - zero) || 1;
    return value => colourAt((value - zero) / most, this.head.colours);
  }
  // Paints once before the browser's next frame, regardless of the number of pointer events until then.
  paintSoon() {
    if (!this.awaited) requestAnimationFrame(() => { if (this.awaited) this.paint(); });
    this.awaited = true;
  }
  paint() {
    this.awaited = false;
    if (!this.shown || !this.viewed) return;
    this.cracks.scale(this.pixelsPerMetre);
    if (this.large) this.faces.facing(this.surface.geometry, this.camera.getWorldDirection(new THREE.Vector3()).negate());
    this.edges.visible = !this.turning && this.block * this.pixelsPerMetre > TINY;
    this.renderer.render(this.scene, this.camera);
    this.drawMarks();
  }

  // ---- Labels over the picture ----
  drawMarks() {
    while (this.overlay.firstChild) this.overlay.removeChild(this.overlay.firstChild);
    this.drawLegend();
    const base = this.height - 14, length = roundDown(110 / this.pixelsPerMetre), pixels = length * this.pixelsPerMetre;
    mark(this.overlay, 'path', {d: `M 76 ${base - 5} v 5 h ${pixels} v -5`, stroke: '#222', fill: 'none', 'stroke-width': 1.5, class: 'bar'});
    mark(this.overlay, 'text', {x: 76 + pixels / 2, y: base - 6, 'text-anchor': 'middle'}, length < 1 ? `${short(length * 100)} cm` : `${length} m`);
    const {magnified, moment} = this.shown;
    const scale = this.head.labels ? 'shape, at no scale' : 'displacements ' + (magnified === 1 ? 'true to scale' : `\u00d7 ${short(magnified)}`), whole = `${moment}; ${scale}`;
    const lines = 96 + pixels + widthOf(whole) < this.width ? [whole] : [moment, scale];
    lines.forEach((line, k) => mark(this.overlay, 'text', {x: 96 + pixels, y: base - 15 * (lines.length - 1 - k), class: 'caption'}, line));
    this.drawAxes(34, base - 24);
  }
  drawAxes(x0, y0) {
    const inverse = this.camera.matrixWorldInverse;
    [['x', '#b3321e'], ['y', '#2a7a3a'], ['z', '#1d4e89']].forEach(([name, stroke], k) => {
      const d = new THREE.Vector3().setComponent(k, 1).transformDirection(inverse);
      if (Math.hypot(d.x, d.y) < 0.15) return;
      mark(this.overlay, 'line', {x1: x0, y1: y0, x2: x0 + 20 * d.x, y2: y0 - 20 * d.y, stroke, 'stroke-width': 2});
      mark(this.overlay, 'text', {x: x0 + 28 * d.x, y: y0 - 28 * d.y + 4, 'text-anchor': 'middle', fill: stroke}, name);
    });
  }
  nameOf(name) { return name === 'displacement' && this.grounded >= 0 ? 'relative displacement' : name; }
  drawLegend() {
    const {quantity, low, high, cracks} = this.shown, {name, unit, factor} = this.head.labels ? SHAPE : QUANTITIES[quantity];
    const width = 205, x = this.width - width - 18, scale = this.scaleOf(this.shown), n = 34;
    let y = 22;
    mark(this.overlay, 'text', {x, y, class: 'legend', 'font-weight': 600}, this.nameOf(name) + (unit ? ` [${unit}]` : ' [\u2013]'));
    y += 8;
    for (let k = 0; k < n; ++k)
      mark(this.overlay, 'rect', {x: x + width * k / n, y, width: width / n + 0.5, height: 11, class: 'colour',
        fill: cssOf(scale(low + (k + 0.5) / n * (high - low)))});
    y += 25;
    const ticks = ticksThatFit(low * factor, high * factor, 5, width), range = high - low || 1;
    ticks.forEach(t => mark(this.overlay, 'text', {x: x + width * (t / factor - low) / range, y, 'text-anchor': 'middle'}, short(t)));
    if (this.forces.kind !== 'none') {
      const whole = this.head.summary.symmetry_factor || 1, largest = short(whole * this.forces.largest / 1e3);
      const thrust = this.forces.kind === 'thrust', label = thrust ? 'line of thrust' : `force in a joint: ${largest} kN`;
      y += 23;
      mark(this.overlay, 'path', {d: thrust ? `M ${x} ${y - 4} h 30` : `M ${x} ${y - 4} l 15 -5 l 15 5 l -15 5 z`, class: 'force',
        fill: this.forces.colour, stroke: this.forces.colour, 'stroke-width': thrust ? 3 : 0.5});
      mark(this.overlay, 'text', {x: x + 36, y, class: 'force'}, label);
    }
    const loads = this.shown.loads || [];
    if (loads.length) {
      const sizes = [...new Set(loads.map(l => short(Math.hypot(...l.force_N) / 1e3)))];
      y += 23;
      mark(this.overlay, 'path', {d: `M ${x} ${y - 4} h 18 l 0 -4 l 12 4 l -12 4 l 0 -4`, class: 'load', fill: this.forces.loadColour,
        stroke: this.forces.loadColour, 'stroke-width': 2});
      mark(this.overlay, 'text', {x: x + 36, y, class: 'load'}, sizes.length > 2 ? 'loads' : `load: ${sizes.join(', ')} kN`);
    }
    for (const [label, fill] of this.members.labels) {
      y += 19;
      mark(this.overlay, 'rect', {x, y: y - 7, width: 30, height: 5, fill, class: 'member'});
      mark(this.overlay, 'text', {x: x + 36, y, class: 'member'}, label);
    }
    if (!cracks || this.head.labels) return;
    y += 6;
    for (const {label, colour} of this.head.colours.cracks.slice(1)) {
      y += 17;
      mark(this.overlay, 'rect', {x, y: y - 9, width: 14, height: 9, fill: colour, class: 'crack'});
      mark(this.overlay, 'text', {x: x + 20, y, class: 'crack'}, label);
    }
  }

  // ---- Under the pointer ----
  // Number of the block at a place of the picture; -1: none.
  blockAt(x, y) {
    const ratio = window.devicePixelRatio || 1, w = this.width * ratio, h = this.height * ratio;
    const to = new Uint8Array(4 * PICKED * PICKED), camera = this.camera.clone();
    camera.setViewOffset(w, h, x * ratio - PICKED / 2, y * ratio - PICKED / 2, PICKED, PICKED);
    this.renderer.setRenderTarget(this.target);
    this.renderer.render(this.picking, camera);
    this.renderer.readRenderTargetPixels(this.target, 0, 0, PICKED, PICKED, to);
    this.renderer.setRenderTarget(null);
    const i = 4 * (PICKED / 2 * PICKED + PICKED / 2);
    return to[i] + 256 * to[i + 1] + 65536 * to[i + 2] - 1;
  }
  // Triangles of each block, as indices of their first corner.
  get trianglesOf() {
    if (this.by_block) return this.by_block;
    const triangle = this.array('triangle'), block = this.array('block'), all = [];
    for (let t = 0; t < triangle.length; t += 3) (all[block[triangle[t]]] = all[block[triangle[t]]] || []).push(t);
    return this.by_block = all;
  }
  cornersOf(t) {
    const triangle = this.array('triangle'), p = this.position.array;
    return [0, 1, 2].map(k => new THREE.Vector3().fromArray(p, 3 * triangle[t + k]));
  }
  // Point of a block under the pointer, and the vertex nearest to it.
  hit(block, x, y) {
    const to = {x: 2 * x / this.width - 1, y: 1 - 2 * y / this.height}, caster = new THREE.Raycaster();
    caster.setFromCamera(to, this.camera);
    const at = new THREE.Vector3(), triangle = this.array('triangle');
    let nearest = Infinity, found = null;
    for (const t of this.trianglesOf[block] || []) {
      const corners = this.cornersOf(t);
      if (!caster.ray.intersectTriangle(...corners, false, at)) continue;
      const away = at.distanceTo(caster.ray.origin);
      if (away >= nearest) continue;
      nearest = away;
      const k = [0, 1, 2].reduce((a, b) => corners[b].distanceTo(at) < corners[a].distanceTo(at) ? b : a);
      found = {place: at.clone(), vertex: triangle[t + k]};
    }
    return found;
  }
  // Joint of a block nearest to a place on it; null: it has none.
  jointNear(block, place) {
    const a = this.array('joint_a'), b = this.array('joint_b'), at = new THREE.Vector3();
    const area = this.array('joint_area' + this.frame);
    let nearest = Infinity, found = null;
    for (let j = 0; j < a.length; ++j) {
      if (a[j] !== block && b[j] !== block || !area[j]) continue;
      for (const t of this.trianglesOf[a[j] === block ? b[j] : a[j]] || []) {
        const away = new THREE.Triangle(...this.cornersOf(t)).closestPointToPoint(place, at).distanceTo(place);
        if (away < nearest) nearest = away, found = j;
      }
    }
    return found;
  }
  // Lines of text about a place of the picture; empty: there is no block.
  tell(x, y) {
    const block = this.blockAt(x, y), hit = block < 0 ? null : this.hit(block, x, y);
    if (!hit) return [];
    const {quantity} = this.shown, {name, unit, factor} = QUANTITIES[quantity], moved = this.array('moved' + this.frame);
    const u = [0, 1, 2].map(k => short(this.head.range.moved / 32767 * moved[3 * hit.vertex + k] * 1e3));
    const names = this.head.summary.block_names || {}, whole = this.head.summary.symmetry_factor || 1, title = b => names[b] || `block ${b}`;
    const told = [title(block), `moved ${u.join(', ')} mm (x, y, z)`];
    if (quantity !== 'displacement') told.push(`${name} ${short(factor * this.valueAt(this.frame, quantity, hit.vertex))} ${unit}`.trim());
    const j = this.jointNear(block, hit.place);
    if (j === null) return told;
    const get = what => this.array(`joint_${what}${this.frame}`)[j], a = this.array('joint_a')[j], b = this.array('joint_b')[j];
    told.push(`joint to ${title(a === block ? b : a)}: ${this.head.colours.cracks[get('crack')].label}`);
    told.push(`  normal ${short(get('normal') / 1e6)} MPa (${short(whole * get('normal') * get('area') / 1e3)} kN), shear ${short(get('shear') / 1e6)} MPa`);
    if (get('normal') < 0) told.push(`  eccentricity ${short(get('eccentricity'))} of its depth`);
    told.push(`  opening ${short(1e3 * get('opening'))} mm, slip ${short(1e3 * get('slip'))} mm, damage ${short(get('damage'))}`);
    return told;
  }
}
