// Forces between blocks: a spindle in each joint in compression, and the line of thrust.

const SPINDLE = {length: 0.45, width: 0.13, least: 0.01};  // over the distance of the blocks' centres; over the largest force
const LOAD = {length: 0.7, width: 0.03, pen: 4};  // over the size of a block; index of a colour that other forces do not have
// Width and gap between supports over the size of a block; least |y| of a bed's normal; gap of levels over a height.
const THRUST = {width: 0.02, apart: 0.3, bed: 0.7, level: 0.3};

class Forces {
  constructor(model) {
    this.model = model; this.array = model.array;
    this.a = this.array('joint_a'); this.b = this.array('joint_b');
    this.known = this.array('joint_force0').length === 3 * this.a.length && this.a.length > 0;
    this.mesh = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({depthTest: false, transparent: true, vertexColors: true}));
    this.mesh.renderOrder = 5; this.mesh.frustumCulled = false;
    this.boxes = model.boxes(this.array('position'));
    this.centre = this.boxes.map(b => b && b.low.map((l, k) => (l + b.high[k]) / 2));
    this.largest = this.known ? this.robust() : 0;
  }
  get loadColour() { return this.model.head.colours.pens[LOAD.pen]; }
  get colour() { return this.model.head.colours.pens[this.kind === 'thrust' ? 0 : 1]; }
  // Force above which 2 % of all forces of the run lie, N, for the modelled thickness.
  robust() {
    const all = [];
    const every = Math.max(1, Math.floor(this.a.length * this.model.head.times.length / 4e5));
    for (let f = 0; f < this.model.head.times.length; ++f) {
      const force = this.array('joint_force' + f);
      for (let j = 0; j < this.a.length; j += every) {
        const size = Math.hypot(force[3 * j], force[3 * j + 1], force[3 * j + 2]);
        if (size > 0) all.push(size);
      }
    }
    return all.length ? Float64Array.from(all).sort()[Math.floor(0.98 * (all.length - 1))] : 0;
  }
  // Mean displacement of the vertices of each block.
  moved(frame) {
    const moved = this.array('moved' + frame), block = this.array('block'), step = this.model.head.range.moved / 32767;
    const sum = [], count = [];
    for (let v = 0; v < block.length; ++v) {
      const s = sum[block[v]] = sum[block[v]] || [0, 0, 0];
      count[block[v]] = (count[block[v]] || 0) + 1;
      for (let k = 0; k < 3; ++k) s[k] += step * moved[3 * v + k];
    }
    return sum.map((s, b) => s && s.map(x => x / count[b]));
  }
  // Joints of a frame in compression, in their places in the picture. F: on block a, N.
  pressed(frame, magnified) {
    const force = this.array('joint_force' + frame), place = this.array('joint_place' + frame), normal = this.array('joint_normal' + frame);
    const axis = this.array('joint_axis' + frame), moved = this.moved(frame), all = [];
    let most = 0;  // of this frame: impacts in other frames must not hide its forces
    for (let i = 0; i < force.length; i += 3) most = Math.max(most, Math.hypot(force[i], force[i + 1], force[i + 2]));
    for (let j = 0; j < this.a.length; ++j) {
      const F = [0, 1, 2].map(k => force[3 * j + k]), size = Math.hypot(...F), a = this.a[j], b = this.b[j];
      if (!(normal[j] < 0) || !(size > SPINDLE.least * most) || !this.centre[a] || !this.centre[b]) continue;
      if (this.model.hidden(a) || this.model.hidden(b)) continue;
      const at = [0, 1, 2].map(k => place[3 * j + k] + (magnified - 1) * (moved[a][k] + moved[b][k]) / 2);
      all.push({j, a, b, F, size, at, bed: Math.abs(axis[3 * j + 1]), level: (this.centre[a][1] + this.centre[b][1]) / 2});
    }
    return all;
  }
  show(frame, kind, magnified) {
    this.kind = this.known ? kind : 'none';
    this.parts = [];
    if (this.kind === 'joints') for (const joint of this.pressed(frame, magnified)) this.addSpindle(joint);
    for (const load of this.model.shown.loads || []) this.addArrow(load, frame, magnified);
    if (this.kind === 'thrust') for (const [from, to] of this.thrust(this.pressed(frame, magnified))) this.addBar(from, to);
    this.fill();
  }
  // Point on the arrow of a load, by share of its length from the tip.
  arrow(at, F) {
    const size = Math.hypot(...F) || 1, length = LOAD.length * this.model.block;
    return share => at.map((x, k) => x - share * length * F[k] / size);
  }
  // Adds the arrow of a load, with its tip at its place. It moves with the vertex nearest to it at the start.
  addArrow({point_m: point, force_N: F}, frame, magnified) {
    const width = LOAD.width * this.model.block, start = this.array('position'), moved = this.array('moved' + frame);
    if (!Math.hypot(...F)) return;
    let nearest = 0, least = Infinity;
    for (let v = 0; v < start.length / 3; ++v) {
      const away = Math.hypot(...point.map((x, k) => x - start[3 * v + k]));
      if (away < least) least = away, nearest = v;
    }
    const step = this.model.head.range.moved / 32767;
    const back = this.arrow(point.map((x, k) => x + magnified * step * moved[3 * nearest + k]), F);
    this.addBar(back(1), back(0.45), width, 0.5, this.loadColour);
    this.addBar(back(0.45), back(0), 4 * width, 0, this.loadColour);
  }
  addSpindle({a, b, F, size, at}) {
    const apart = Math.hypot(...[0, 1, 2].map(k => this.centre[a][k] - this.centre[b][k]));
    this.addBar(...[-1, 1].map(s => at.map((x, k) => x + s * SPINDLE.length * apart * F[k] / size)),
      SPINDLE.width * apart * Math.min(1.3, size / this.largest), 0.5, this.colour, true);
  }
  // Adds a bar of square section. widest: share of its length at which a pointed bar is widest; 0: a cone.
  addBar(from, to, width = THRUST.width * this.model.block, widest = 0.5, colour = this.colour, pointed = widest === 0) {
    this.parts.push({from, to, width, widest, colour, pointed});
  }
  fill() {
    const at = [], paint = [], index = [], x = new THREE.Vector3(), p = new THREE.Vector3(), q = new THREE.Vector3();
    for (const {from, to, width, widest, colour, pointed} of this.parts) {
      const first = at.length / 3, tint = new THREE.Color(colour).toArray();
      x.set(...to.map((t, k) => t - from[k])).normalize();
      p.set(Math.abs(x.x) < 0.9 ? 1 : 0, Math.abs(x.x) < 0.9 ? 0 : 1, 0).cross(x).normalize();
      q.crossVectors(x, p);
      const corner = (o, u, v) => at.push(...[0, 1, 2].map(k => o[k] + width * (u * p.getComponent(k) + v * q.getComponent(k))));
      if (pointed) {
        const middle = from.map((f, k) => f + widest * (to[k] - f));
        at.push(...from, ...to);
        for (const [u, v] of [[1, 0], [0, 1], [-1, 0], [0, -1]]) corner(middle, u, v);
        for (let k = 0; k < 4; ++k) for (const end of [0, 1]) index.push(first + end, first + 2 + k, first + 2 + (k + 1) % 4);
      } else {
        for (const o of [from, to]) for (const [u, v] of [[1, 1], [-1, 1], [-1, -1], [1, -1]]) corner(o, u, v);
        for (let k = 0; k < 4; ++k) { const l = (k + 1) % 4; index.push(first + k, first + l, first + 4 + k, first + l, first + 4 + l, first + 4 + k); }
      }
      while (paint.length < at.length) paint.push(...tint);
    }
    const geometry = this.mesh.geometry;
    geometry.setAttribute('position', new THREE.Float32BufferAttribute(at, 3));
    geometry.setAttribute('color', new THREE.Float32BufferAttribute(paint, 3));
    geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(index), 1));
  }

  // ---- The line of thrust, as pieces between two places ----
  thrust(joints) {
    const of = new Map();
    for (const joint of joints) for (const b of [joint.a, joint.b]) if (this.boxes[b].moves) of.set(b, [...(of.get(b) || []), joint]);
    const degrees = [...of.values()].map(list => list.length).sort((x, y) => x - y);
    if (degrees.length && degrees[Math.floor(0.9 * (degrees.length - 1))] <= 2) return this.alongChains(of);
    const abutments = this.supports(joints);
    return abutments.length === 2 ? this.throughRings(joints, abutments[0]) : this.throughCourses(joints);
  }
  // Groups of adjacent blocks that hold others and do not move.
  supports(joints) {
    const held = [...new Set(joints.flatMap(j => [j.a, j.b]).filter(b => !this.boxes[b].moves))], groups = [];
    const near = (p, q) => [0, 1, 2].every(k => Math.min(this.boxes[p].high[k], this.boxes[q].high[k]) -
      Math.max(this.boxes[p].low[k], this.boxes[q].low[k]) > -THRUST.apart * this.model.block);
    for (const b of held) {
      const touching = groups.filter(g => g.some(other => near(b, other)));
      const group = touching.shift() || groups[groups.push([]) - 1];
      for (const other of touching) { group.push(...other); groups.splice(groups.indexOf(other), 1); }
      group.push(b);
    }
    return groups;
  }
  // Vaults and bridges between two abutments: through resultants of joints at an equal number of blocks from one
  // abutment.
  throughRings(joints, abutment) {
    const of = new Map(), away = new Map(abutment.map(b => [b, 0])), cuts = [];
    for (const j of joints) for (const b of [j.a, j.b]) of.set(b, [...(of.get(b) || []), j]);
    for (const b of away.keys())  // in the order of insertion, including those added in the loop
      for (const j of of.get(b) || []) for (const next of [j.a, j.b]) if (!away.has(next)) away.set(next, away.get(b) + 1);
    for (const j of joints) {
      const from = Math.min(away.get(j.a), away.get(j.b));
      if (away.get(j.a) !== away.get(j.b)) (cuts[from] = cuts[from] || []).push(j);
    }
    return this.joined(cuts.map(cut => this.clusters(cut, j => away.get(j.a) > away.get(j.b), j => j.size)));
  }
  joined(cuts) {
    const pieces = [];
    for (let l = 1; l < cuts.length; ++l)
      for (const below of cuts[l - 1] || []) for (const above of cuts[l] || [])
        if ([...above.lower].some(b => below.upper.has(b))) pieces.push([below.at, above.at]);
    return pieces;
  }
  // Arches and columns: from joint to joint of each block.
  alongChains(of) {
    return [...of.values()].filter(list => list.length === 2).map(([one, other]) => [one.at, other.at]);
  }
  // Walls, piers, buttresses: through resultants of groups of bed joints at one level that share blocks.
  throughCourses(joints) {
    const beds = joints.filter(j => j.bed > THRUST.bed).sort((x, y) => x.level - y.level);
    const heights = this.boxes.filter(b => b && b.moves).map(b => b.high[1] - b.low[1]).sort((x, y) => x - y);
    const gap = THRUST.level * (heights[Math.floor(heights.length / 2)] || 1), levels = [];
    for (const j of beds) {
      const last = levels[levels.length - 1];
      if (last && j.level - last[last.length - 1].level < gap) last.push(j); else levels.push([j]);
    }
    return this.joined(levels.map(level => this.clusters(level, j => this.centre[j.a][1] > this.centre[j.b][1], j => Math.abs(j.F[1]))));
  }
  // Groups of joints that share blocks, with the place of their resultant. up: whether block a is the upper one; push:
  // weight of a joint.
  clusters(level, up, push) {
    const groups = [];
    for (const j of level) {
      const touching = groups.filter(g => g.blocks.has(j.a) || g.blocks.has(j.b));
      const group = touching.shift() || groups[groups.push({blocks: new Set(), joints: []}) - 1];
      for (const other of touching) {
        other.joints.forEach(k => group.joints.push(k)); other.blocks.forEach(b => group.blocks.add(b));
        groups.splice(groups.indexOf(other), 1);
      }
      group.joints.push(j); group.blocks.add(j.a).add(j.b);
    }
    return groups.map(({joints}) => {
      const total = joints.reduce((sum, j) => sum + push(j), 0) || 1, upper = new Set(), lower = new Set();
      for (const j of joints) upper.add(up(j) ? j.a : j.b), lower.add(up(j) ? j.b : j.a);
      return {at: [0, 1, 2].map(k => joints.reduce((sum, j) => sum + push(j) * j.at[k], 0) / total), upper, lower};
    });
  }
}
