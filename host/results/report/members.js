// Ties, dowels, strips and beams as bars, floors as panels, in their current places. Colours show tension and
// compression.

const BAR = 0.15;  // width of a bar over the thinnest side of a block
const PULL = '#b3331f', PUSH = '#1c4f8a';

class Members {
  constructor(model) {
    this.model = model; this.array = model.array;
    this.known = this.array('member_line0').length + this.array('member_panel0').length > 0;
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({vertexColors: THREE.VertexColors,
      side: THREE.DoubleSide, depthTest: false, transparent: true, opacity: 0.85}));
    this.mesh.renderOrder = 4; this.mesh.frustumCulled = false;
    const sides = model.boxes(this.array('position')).filter(b => b).map(b => Math.min(...b.high.map((h, k) => h - b.low[k])));
    this.width = BAR * sides.sort((a, b) => a - b)[Math.floor(sides.length / 2)];
    this.most = {force: 0, shear: 0}; this.pull = this.push = 0;
    for (let f = 0; this.known && f < model.head.times.length; ++f)
      for (const what of ['force', 'shear'])
        for (const value of this.array(`member_${what}${f}`)) {
          this.most[what] = Math.max(this.most[what], Math.abs(value));
          if (what === 'force') this.pull = Math.max(this.pull, value), this.push = Math.max(this.push, -value);
        }
  }
  // Places of corners in the picture, between those at the start and those of a frame.
  placed(what, frame, magnified) {
    const start = this.array(`member_${what}0`), now = this.array(`member_${what}${frame}`);
    return start.map((x, i) => x + magnified * (now[i] - x));
  }
  // Grey without force, towards red in tension, towards blue in compression.
  tint(value, most) {
    const share = most > 0 ? Math.max(-1, Math.min(1, value / most)) : 0, end = share > 0 ? [0.70, 0.20, 0.12] : [0.11, 0.31, 0.54];
    return [0.45, 0.45, 0.43].map((grey, k) => grey + Math.sqrt(Math.abs(share)) * (end[k] - grey));
  }
  show(frame, magnified) {
    if (!this.known) return;
    const position = [], colour = [];
    const add = (corners, tint) => { for (const c of corners) { position.push(...c); colour.push(...tint); } };
    const line = this.placed('line', frame, magnified), force = this.array(`member_force${frame}`);
    for (let i = 0; i < force.length; ++i) {
      const from = new THREE.Vector3().fromArray(line, 6 * i), to = new THREE.Vector3().fromArray(line, 6 * i + 3);
      const along = to.clone().sub(from).normalize(), side = new THREE.Vector3(0.31, 0.52, 0.79).cross(along).normalize();
      const sides = [side, along.clone().cross(side)].map(s => s.multiplyScalar(0.5 * this.width));
      const ends = [from, to].map(p => [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([u, v]) =>
        p.clone().addScaledVector(sides[0], u).addScaledVector(sides[1], v).toArray()));
      for (let k = 0; k < 4; ++k) {
        const n = (k + 1) % 4;
        add([ends[0][k], ends[1][k], ends[1][n], ends[0][k], ends[1][n], ends[0][n]], this.tint(force[i], this.most.force));
      }
    }
    const panel = this.placed('panel', frame, magnified), shear = this.array(`member_shear${frame}`);
    for (let i = 0; i < shear.length; ++i) {
      const c = [0, 1, 2, 3].map(k => Array.from(panel.slice(12 * i + 3 * k, 12 * i + 3 * k + 3)));
      add([c[0], c[1], c[2], c[0], c[2], c[3]], this.tint(Math.abs(shear[i]), this.most.shear));
    }
    this.mesh.geometry.setAttribute('position', new THREE.Float32BufferAttribute(position, 3));
    this.mesh.geometry.setAttribute('color', new THREE.Float32BufferAttribute(colour, 3));
  }
  // Lines of the legend with the largest values of the run: text and colour.
  get labels() {
    if (!this.known) return [];
    const all = [], strips = this.model.head.summary.strips || [];
    const debonded = Math.max(0, ...strips.map(s => s.debonded_m));
    if (this.pull > 0) all.push([`bars pull: ${short(this.pull / 1e3)} kN`, PULL]);
    if (this.push > 0) all.push([`bars push: ${short(this.push / 1e3)} kN`, PUSH]);
    if (this.most.shear > 0) all.push([`floors, shear: ${short(this.most.shear / 1e3)} kN/m`, PULL]);
    if (debonded > 0) all.push([`strips: ${short(debonded)} m debonded`, PULL]);
    return all;
  }
}
